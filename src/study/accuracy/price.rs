//! The cheapest settings for an error, from the rows of every knob.
//!
//! Knobs are taken as independent: the squares of their errors add up to each other and to the noise, and each makes a
//! picture's time, and the variance of a sample, so many times what the finest setting has. Noise falls as one over the root of
//! the samples. What comes out is therefore a prediction, to be tested by a render.

use serde::Serialize;

use super::{Row, Setting};

/// Errors whose price is named.
pub const TARGETS: [f64; 3] = [0.1, 0.02, 0.005];

/// Times and noises that differ by less count as equal: timing is no better, and a flag that gains nothing is not named.
const SAME: f64 = 0.04;

/// The cheapest settings for an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Price {
    /// The error: RMS over pixels and R, G, B, relative to the mean luminance.
    pub target: f64,
    /// Flags of `render`, beside the finest settings; empty where no setting reaches the error.
    pub flags: Vec<String>,
    /// Samples per pixel.
    pub spp: u32,
    /// Processor seconds that a picture is predicted to take.
    pub cpu_s: f64,
    /// The predicted error.
    pub error: f64,
}

/// A choice so far: factors on the finest setting's time and variance, the sum of squared errors, the flags.
#[derive(Clone, Debug)]
struct Choice {
    time: f64,
    variance: f64,
    square: f64,
    flags: Vec<String>,
}

/// Tries all combinations of the knobs' settings, the finest of each among them.
pub fn cheapest(finest: &Row, rows: &[Row], target: f64) -> Price {
    let start = Choice { time: 1.0, variance: 1.0, square: 0.0, flags: Vec::new() };
    let mut choices = vec![start];
    let mut knobs: Vec<&str> = rows.iter().filter(|row| is_part(row)).map(|row| row.knob).collect();
    knobs.dedup();
    for knob in knobs {
        let settings: Vec<&Row> = rows.iter().filter(|row| row.knob == knob).collect();
        let with = |choice: &Choice, row: &Row| add(choice, finest, row);
        let more: Vec<Choice> = choices.iter().flat_map(|c| settings.iter().map(move |row| with(c, row))).collect();
        choices.extend(more);
        choices.retain(|choice| choice.square < target * target);
        choices = unbeaten(choices);
    }
    let priced = choices.into_iter().map(|choice| price(finest, choice, target));
    priced.min_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s)).unwrap_or(Price {
        target,
        flags: Vec::new(),
        spp: 0,
        cpu_s: f64::INFINITY,
        error: f64::INFINITY,
    })
}

/// Those that no other is as good as in time, variance and error alike: what is added later makes both worse by the same. Of
/// equals the first stays, which has the fewest flags.
fn unbeaten(mut choices: Vec<Choice>) -> Vec<Choice> {
    // Stable, and the better ones come first: each need only be held against those that stayed.
    choices.sort_by(|a, b| {
        a.time.total_cmp(&b.time).then(a.variance.total_cmp(&b.variance)).then(a.square.total_cmp(&b.square))
    });
    let mut stayed: Vec<Choice> = Vec::new();
    for choice in choices {
        if !stayed.iter().any(|s| s.variance <= choice.variance && s.square <= choice.square) {
            stayed.push(choice);
        }
    }
    stayed
}

/// Samples are chosen last, and a target is everything at once.
fn is_part(row: &Row) -> bool {
    !matches!(row.value, None | Some(Setting::Spp(_) | Setting::Target(_)))
}

fn add(choice: &Choice, finest: &Row, row: &Row) -> Choice {
    let ratio = |a: f64, b: f64| match a / b {
        ratio if ratio > 0.0 && ratio.is_finite() && (ratio - 1.0).abs() > SAME => ratio,
        _ => 1.0,
    };
    Choice {
        time: choice.time * ratio(row.cpu_s, finest.cpu_s),
        variance: choice.variance * ratio(row.noise, finest.noise).powi(2),
        // An error that is known only to be small counts as large as it may be.
        square: choice.square + row.error.square.max(0.0) + row.error.square_error,
        flags: [&choice.flags[..], std::slice::from_ref(&row.flag)].concat(),
    }
}

/// Takes as many samples as the knobs' errors leave to the noise.
fn price(finest: &Row, choice: Choice, target: f64) -> Price {
    let one_sample = finest.noise.powi(2) * f64::from(finest.spp) * choice.variance;
    let spp = (one_sample / (target * target - choice.square)).ceil().clamp(1.0, f64::from(u32::MAX));
    Price {
        target,
        flags: choice.flags,
        spp: spp as u32,
        cpu_s: finest.cpu_s * choice.time * spp / f64::from(finest.spp.max(1)),
        error: (choice.square + one_sample / spp).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_row;
    use super::*;

    /// Expected: choices do not multiply, as 10 knobs of 9 settings would to 1e10, and the cheapest is what trying all finds: each
    /// knob's middle setting, which costs little error, or its coarsest.
    #[test]
    fn many_knobs_are_searched_in_no_time() {
        let finest = test_row(Setting::Bands(32), 0.0, 0.1, 1.0);
        let knob = |name: &'static str, settings: i32| -> Vec<Row> {
            let row = |i: i32| Row {
                knob: name,
                ..test_row(Setting::Bands(32), 2e-4 * 1.5_f64.powi(i), 0.1, 0.9 - 0.05 * f64::from(i))
            };
            (1..=settings).map(row).collect()
        };
        let names = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
        let many: Vec<Row> = names.iter().flat_map(|name| knob(name, 9)).collect();
        assert_eq!(cheapest(&finest, &many, 0.02).flags.len(), names.len());
        let few: Vec<Row> = names[..3].iter().flat_map(|name| knob(name, 4)).collect();
        let options = |name: &str| -> Vec<Option<&Row>> {
            std::iter::once(None).chain(few.iter().filter(|row| row.knob == name).map(Some)).collect()
        };
        let start = Choice { time: 1.0, variance: 1.0, square: 0.0, flags: Vec::new() };
        let mut all = vec![start];
        for name in &names[..3] {
            let with = |c: &Choice, row: Option<&Row>| row.map_or_else(|| c.clone(), |row| add(c, &finest, row));
            all = all.iter().flat_map(|c| options(name).into_iter().map(move |row| with(c, row))).collect();
        }
        let stayed = unbeaten(all.clone()).len();
        assert!(2 * stayed < all.len(), "{stayed} of {}", all.len());
        let best = all.into_iter().map(|c| price(&finest, c, 0.02).cpu_s).fold(f64::INFINITY, f64::min);
        assert_eq!(cheapest(&finest, &few, 0.02).cpu_s, best);
    }

    /// The finest setting: 10 % noise at 64 samples in 1 s. Four bands are wrong by 3 % and take a quarter of the time; order 1
    /// is wrong by 9 % and takes half.
    #[test]
    fn the_budget_is_divided_where_that_is_cheapest() {
        let finest = test_row(Setting::Bands(32), 0.0, 0.1, 1.0);
        let rows = [test_row(Setting::Bands(4), 0.03, 0.1, 0.25), test_row(Setting::Order(1), 0.09, 0.1, 0.5)];
        let ten = cheapest(&finest, &rows, 0.1);
        // 0.0091 left to noise: 64 * 0.01 / 0.0091 samples, rounded up; order 1 would leave 0.001.
        assert_eq!((ten.flags.len(), ten.spp), (1, 71));
        assert!((ten.cpu_s - 0.25 * 71.0 / 64.0).abs() < 1e-12 && ten.error <= 0.1, "{ten:?}");
        let two = cheapest(&finest, &rows, 0.02);
        // 64 * 0.01 / 0.0004, up to the rounding of squares.
        assert!(two.flags.is_empty() && (1600..=1601).contains(&two.spp), "{two:?}");
        assert!((two.cpu_s - 25.0).abs() < 0.02, "{two:?}");
    }
}
