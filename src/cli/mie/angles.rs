//! Scattering angles as they are written: `0,90,180` or `0:180:0.5`, in degrees.

use std::str::FromStr;

/// Most angles: a table of them takes 100 MB.
const MAX_ANGLES: usize = 1_000_001;

/// Most decimals that make a range exact; finer ones are computed in binary.
const MAX_DECIMALS: i32 = 12;

/// Scattering angles in degrees, each in 0 ..= 180, at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleList(Vec<f64>);

impl AngleList {
    /// Every ten degrees.
    pub fn standard() -> Self {
        Self((0..=18).map(|i| 10.0 * f64::from(i)).collect())
    }

    /// The smallest and the largest angle; the whole range where that is one.
    pub fn range_deg(&self) -> [f64; 2] {
        let [from, to] = [f64::min, f64::max].map(|of| self.0.iter().copied().reduce(of).unwrap_or(0.0));
        if from < to { [from, to] } else { [0.0, 180.0] }
    }

    /// The angles in the order they were given.
    pub fn degrees(&self) -> &[f64] {
        &self.0
    }
}

impl FromStr for AngleList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut all = Vec::new();
        for item in text.split(',') {
            let parts: Vec<f64> = item.split(':').map(number).collect::<Result<_, _>>()?;
            match parts[..] {
                [angle] => all.push(in_range(angle)?),
                [from, to, step] => all.extend(range(in_range(from)?, in_range(to)?, step)?),
                _ => return Err(format!("`{item}` is neither an angle nor FROM:TO:STEP, e.g. 0:180:1")),
            }
            check_count(all.len())?;
        }
        Ok(Self(all))
    }
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("`{text}` is not a number of degrees; write A,B,C or FROM:TO:STEP, e.g. 0:180:1"))
}

fn in_range(angle: f64) -> Result<f64, String> {
    if (0.0..=180.0).contains(&angle) {
        // Minus zero is zero.
        Ok(angle + 0.0)
    } else {
        Err(format!("{angle} degrees is not a scattering angle: 0 is forward, 180 backward"))
    }
}

fn check_count(count: usize) -> Result<(), String> {
    if count <= MAX_ANGLES {
        return Ok(());
    }
    Err(format!("these are {count} angles or more; at most {MAX_ANGLES} are printed, so take a longer step"))
}

/// Angles from `from` by `step`, and `to` itself where a step ends there.
fn range(from: f64, to: f64, step: f64) -> Result<Vec<f64>, String> {
    if step <= 0.0 {
        return Err(format!("the step {step} must be above zero"));
    }
    if from > to {
        return Err(format!("the range begins at {from} and ends before it, at {to}; write the smaller angle first"));
    }
    // Whole numbers of the last decimal are exact, so that 0:180:0.1 has 0.3 and not 0.30000000000000004.
    let per_unit = per_unit(&[from, step]).unwrap_or(1.0);
    let (from, step) = (from * per_unit, step * per_unit);
    let (from, step) = if per_unit > 1.0 { (from.round(), step.round()) } else { (from, step) };
    // A billionth of a step is rounding, not a missing angle.
    let steps = ((to * per_unit - from) / step + 1e-9).floor();
    check_count(if steps < 1e15 { steps as usize + 1 } else { usize::MAX })?;
    Ok((0..=steps as usize).map(|i| ((from + i as f64 * step) / per_unit).min(180.0)).collect())
}

/// The smallest power of ten that makes all values whole.
fn per_unit(values: &[f64]) -> Option<f64> {
    let scales = (0..=MAX_DECIMALS).map(|decimals| 10f64.powi(decimals));
    scales.into_iter().find(|scale| values.iter().all(|value| (value * scale).round() / scale == *value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(text: &str) -> Vec<f64> {
        text.parse::<AngleList>().expect(text).0
    }

    #[test]
    fn lists_and_ranges_are_read() {
        assert_eq!(degrees("0, 90,180"), [0.0, 90.0, 180.0]);
        assert_eq!(degrees("0:180:45"), [0.0, 45.0, 90.0, 135.0, 180.0]);
        assert_eq!(degrees("0:1:0.5,170:180:5"), [0.0, 0.5, 1.0, 170.0, 175.0, 180.0]);
        assert_eq!(degrees("10:10:1"), [10.0]);
        assert_eq!(degrees("0:10:4"), [0.0, 4.0, 8.0]);
        assert_eq!(degrees("-0")[0].to_bits(), 0);
    }

    #[test]
    fn ranges_are_decimal_and_reach_their_end() {
        let tenths = degrees("0:180:0.1");
        assert_eq!(tenths.len(), 1801);
        for (i, angle) in tenths.iter().enumerate() {
            assert_eq!(*angle, format!("{}.{}", i / 10, i % 10).parse::<f64>().unwrap());
        }
        assert_eq!(degrees("179.9:180:1e-3").len(), 101);
        let thirds = degrees(&format!("0:180:{}", 1.0 / 3.0));
        assert_eq!((thirds.len(), thirds[540]), (541, 180.0));
        assert_eq!(degrees("0:180:0.00018").len(), 1_000_001);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, said) in [
            ("", "not a number"),
            ("0,,1", "not a number"),
            ("a", "not a number"),
            ("NaN", "not a number"),
            ("-1", "not a scattering angle"),
            ("181", "not a scattering angle"),
            ("0:180", "FROM:TO:STEP"),
            ("0:1:2:3", "FROM:TO:STEP"),
            ("0:200:1", "not a scattering angle"),
            ("0:180:0", "above zero"),
            ("0:180:-1", "above zero"),
            ("90:0:1", "smaller angle first"),
            ("0:180:1e-4", "longer step"),
            ("0:180:1e-300", "longer step"),
            ("0:180:0.0002,0:180:0.0002", "longer step"),
        ] {
            let error = text.parse::<AngleList>().unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
