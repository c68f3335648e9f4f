//! Where axes have their labels and their fine grid, and how powers of ten are written.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;

use super::caption::short;

/// An axis with labels and grid lines of its own choosing.
pub struct Axis {
    range: RangedCoordf64,
    labels: Vec<f64>,
    fine: Vec<f64>,
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.range.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.fine.clone() } else { self.labels.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.range()
    }
}

/// An axis with labels every `label` and grid lines every `fine` units.
pub fn even(range: Range<f64>, label: f64, fine: f64) -> Axis {
    let points = |step: f64| {
        let first = (range.start / step - 1e-9).ceil() as i64;
        let last = (range.end / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect::<Vec<f64>>()
    };
    Axis { range: range.clone().into(), labels: points(label), fine: points(fine) }
}

/// An axis of decimal logarithms: labels at powers of ten, at most `most`, and at 2 and 5 times each on short axes;
/// grid lines at 2, 3, .. 9 times each if there is room.
pub fn logarithmic(range: Range<f64>, most: usize) -> Axis {
    let (first, last) = (range.start.floor() as i64, range.end.ceil() as i64);
    let step = ((range.end - range.start) / most as f64).ceil().max(1.0) as i64;
    let multiples = |factors: &'static [f64]| {
        let all = (first..=last).flat_map(|power| factors.iter().map(move |factor| power as f64 + factor.log10()));
        let inside = all.filter(|value| (range.start - ROUNDING..=range.end + ROUNDING).contains(value));
        inside.collect::<Vec<f64>>()
    };
    let mut labels = multiples(if is_short(&range) { &[1.0, 2.0, 5.0] } else { &[1.0] });
    labels.retain(|value| is_short(&range) || (value.round() as i64).rem_euclid(step) == 0);
    let fine = multiples(if step == 1 { &[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0] } else { &[1.0] });
    Axis { range: range.clone().into(), labels, fine }
}

/// The range of decimal logarithms that holds all positive values: whole decades, or steps of 1, 2, 5 if it is short.
pub fn log_range(values: &[f64]) -> Option<Range<f64>> {
    let positive = || values.iter().copied().filter(|value| *value > 0.0);
    let (low, high) = (positive().reduce(f64::min)?.log10(), positive().reduce(f64::max)?.log10());
    if high - low > 0.8 * SHORT {
        return Some(low.floor()..high.ceil());
    }
    // The margins keep a constant away from the frame.
    Some(step_below(low - 0.1)..-step_below_mirrored(-high - 0.1))
}

/// Axes up to this many decades have labels between the powers of ten.
const SHORT: f64 = 1.6;

/// The rounding of logarithms.
const ROUNDING: f64 = 1e-9;

fn is_short(range: &Range<f64>) -> bool {
    range.end - range.start <= SHORT
}

/// The logarithm of the next 1, 2 or 5 times a power of ten below.
fn step_below(log: f64) -> f64 {
    let power = log.floor();
    let steps = [5f64, 2.0, 1.0].map(|factor| power + factor.log10());
    steps.into_iter().find(|step| *step <= log).unwrap_or(power)
}

/// The same for reciprocals, whose steps are 1, 1/2 and 1/5.
fn step_below_mirrored(log: f64) -> f64 {
    let power = log.ceil();
    let steps = [1f64, 2.0, 5.0, 10.0].map(|factor| power - factor.log10());
    steps.into_iter().find(|step| *step <= log).unwrap_or(power - 1.0)
}

/// How the labels of a logarithmic axis are written: 10⁻³, or 0.05 on a short axis.
pub fn log_label(range: &Range<f64>) -> impl Fn(&f64) -> String + use<> {
    let plain = is_short(range);
    move |power| if plain { short(10f64.powf(*power)) } else { power_of_ten(*power) }
}

/// 10 to a whole power, with the power raised: 10⁻³.
pub fn power_of_ten(power: f64) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    let power = power.round() as i64;
    if power == 0 { "1".into() } else { format!("10{}", power.to_string().chars().map(raised).collect::<String>()) }
}

/// 10 to a whole power in full, in degrees: 0.01°.
pub fn degrees(power: f64) -> String {
    format!("{}°", format!("{:e}", 10f64.powi(power.round() as i32)).parse::<f64>().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::{BoldPoints, LightPoints, Ranged};

    use super::*;

    #[test]
    fn powers_are_raised() {
        assert_eq!([-12.0, 0.0, 1.0, 4.0].map(power_of_ten), ["10⁻¹²", "1", "10¹", "10⁴"]);
        assert_eq!([-3.0, 0.0, 1.0].map(degrees), ["0.001°", "1°", "10°"]);
    }

    #[test]
    fn labels_stay_few() {
        let labels = |range: Range<f64>| logarithmic(range, 10).key_points(BoldPoints(99));
        assert_eq!(labels(-3.0..5.0), (-3..=5).map(f64::from).collect::<Vec<_>>());
        assert_eq!(logarithmic(-3.0..5.0, 10).key_points(LightPoints::new(99, 999)).len(), 64);
        assert!(labels(-10.0..20.0).len() <= 11);
        assert_eq!(even(0.0..180.0, 30.0, 10.0).key_points(BoldPoints(99)).len(), 7);
    }

    #[test]
    fn short_axes_are_labelled_in_steps_of_one_two_five() {
        let range = log_range(&[0.0597, 0.1194, 0.0]).unwrap();
        let label = log_label(&range);
        let labels: Vec<String> = logarithmic(range, 10).key_points(BoldPoints(99)).iter().map(label).collect();
        assert_eq!(labels, ["0.02", "0.05", "0.1", "0.2"]);
        assert_eq!(log_range(&[1e-4, 300.0]), Some(-4.0..3.0));
        let constant = log_range(&[1.0]).unwrap();
        assert!(constant.start < 0.0 && constant.end > 0.0);
        assert_eq!(log_range(&[0.0]), None);
    }
}
