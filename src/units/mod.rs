//! Quantities with units as they are written by people: `5um`, `550nm`, `0.3g/m3`, `4GiB`, `1h30m`.

pub mod short;

use thiserror::Error;

/// A quantity could not be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnitError {
    /// No number at the start.
    #[error("`{0}` does not begin with a number")]
    NotANumber(String),
    /// The unit is missing or unknown.
    #[error("`{text}` needs a unit: one of {expected}")]
    Unit { text: String, expected: &'static str },
    /// The number is negative, infinite, NaN or, of a time, beyond a century.
    #[error("`{0}` is not a finite, non-negative number within reason")]
    Range(String),
}

const LENGTHS: [(&str, f64); 7] =
    [("nm", 1e-9), ("um", 1e-6), ("µm", 1e-6), ("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("km", 1e3)];

/// Reads a length with its unit (nm, um, mm, cm, m, km), in metres.
///
/// # Errors
/// When the number is missing, negative or not finite, or the unit is missing or unknown.
///
/// ```
/// assert_eq!(mie_cloud::units::parse_length_m("5um")?, 5e-6);
/// # Ok::<(), mie_cloud::units::UnitError>(())
/// ```
pub fn parse_length_m(text: &str) -> Result<f64, UnitError> {
    let text = text.trim();
    let (number, unit) = split_unit(text);
    let value: f64 = number.parse().map_err(|_| UnitError::NotANumber(text.into()))?;
    let scale = LENGTHS
        .iter()
        .find(|(name, _)| *name == unit)
        .map(|(_, scale)| *scale)
        .ok_or(UnitError::Unit { text: text.into(), expected: "nm, um, mm, cm, m, km" })?;
    // Dividing by an exact power of ten rounds once; 5um is 5e-6, not 4.9999999999999996e-6.
    let value_m = if scale < 1.0 { value / (1.0 / scale).round() } else { value * scale };
    // Kilometres can overflow.
    if value_m.is_finite() && value_m >= 0.0 { Ok(value_m) } else { Err(UnitError::Range(text.into())) }
}

const SIZES: [(&str, f64); 9] = [
    ("B", 1.0),
    ("kB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
    ("TB", 1e12),
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
];

/// Reads an amount of memory with its unit (B, kB, MB, GB, TB by thousands, KiB, MiB, GiB, TiB by 1024), in bytes.
///
/// # Errors
/// When the number is missing, negative or not finite, or the unit is missing or unknown.
///
/// ```
/// use mie_cloud::units::parse_bytes;
/// assert_eq!(parse_bytes("1.5GiB")?, 3 << 29);
/// assert_eq!(parse_bytes("500 MB")?, 500_000_000);
/// # Ok::<(), mie_cloud::units::UnitError>(())
/// ```
pub fn parse_bytes(text: &str) -> Result<u64, UnitError> {
    let text = text.trim();
    let (number, unit) = split_unit(text);
    let value: f64 = number.parse().map_err(|_| UnitError::NotANumber(text.into()))?;
    let scale = SIZES.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit)).map(|(_, scale)| *scale);
    let scale =
        scale.ok_or(UnitError::Unit { text: text.into(), expected: "B, kB, MB, GB, TB, KiB, MiB, GiB, TiB" })?;
    if !(value.is_finite() && value >= 0.0) {
        return Err(UnitError::Range(text.into()));
    }
    // Saturates where there is more than can be counted.
    Ok((value * scale) as u64)
}

/// Writes an amount of memory for people, with two or three digits: `312 kB`, `1.5 GB`.
///
/// ```
/// assert_eq!(mie_cloud::units::format_bytes(1_530_000_000), "1.53 GB");
/// ```
pub fn format_bytes(bytes: u64) -> String {
    let (mut value, mut units) = (bytes as f64, ["B", "kB", "MB", "GB", "TB", "PB"].into_iter());
    let mut unit = units.next().unwrap_or_default();
    while value >= 999.5 {
        let Some(larger) = units.next() else { break };
        (value, unit) = (value / 1000.0, larger);
    }
    let digits = if unit == "B" || value >= 99.95 { 0 } else { 1 + usize::from(value < 9.995) };
    format!("{value:.digits$} {unit}")
}

const TIMES: [(&str, f64); 6] = [("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("m", 60.0), ("h", 3600.0), ("d", 86_400.0)];

/// Longest time that can be asked for: a century. Clocks overflow somewhere beyond.
const MAX_SECONDS: f64 = 3.2e9;

/// Reads a length of time, in seconds: `90s`, `3m`, `1h30m`, `1.5h`; a number without unit is seconds.
///
/// # Errors
/// When a number is missing, negative, not finite or beyond a century, or a unit is unknown.
///
/// ```
/// use mie_cloud::units::parse_time_s;
/// assert_eq!(parse_time_s("1h30m")?, 5400.0);
/// assert_eq!(parse_time_s("20")?, 20.0);
/// # Ok::<(), mie_cloud::units::UnitError>(())
/// ```
pub fn parse_time_s(text: &str) -> Result<f64, UnitError> {
    let text = text.trim();
    let mut rest = text;
    let mut sum_s = 0.0;
    loop {
        let (number, after) = split_unit(rest);
        let value: f64 = number.parse().map_err(|_| UnitError::NotANumber(text.into()))?;
        let end = after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len());
        let (unit, later) = (&after[..end], after[end..].trim_start());
        let is_bare = rest == text && unit.is_empty() && later.is_empty();
        let scale = if is_bare { Some(1.0) } else { TIMES.iter().find(|(name, _)| *name == unit).map(|(_, s)| *s) };
        let scale =
            scale.ok_or(UnitError::Unit { text: text.into(), expected: "ms, s, m, h, d, as in 90s or 1h30m" })?;
        // A sign would make 1h-30m half an hour.
        if value < 0.0 || number.starts_with(['+', '-']) {
            return Err(UnitError::Range(text.into()));
        }
        sum_s += value * scale;
        if later.is_empty() {
            break;
        }
        rest = later;
    }
    if sum_s <= MAX_SECONDS { Ok(sum_s) } else { Err(UnitError::Range(text.into())) }
}

/// Writes a value in a smaller unit, `per_unit` of which make one, so that reading it back gives the same value where
/// a number does.
///
/// ```
/// use mie_cloud::units::{format_in, parse_length_m};
/// assert_eq!(format_in(5.5e-7, 1e9) + "nm", "550nm");
/// assert_eq!(parse_length_m("550nm")?, 5.5e-7);
/// # Ok::<(), mie_cloud::units::UnitError>(())
/// ```
pub fn format_in(value: f64, per_unit: f64) -> String {
    let scaled = value * per_unit;
    let rounded = format!("{scaled:.14e}").parse().unwrap_or(scaled);
    let candidates = [rounded, scaled, scaled.next_up(), scaled.next_down()];
    candidates.into_iter().find(|text| text / per_unit == value).unwrap_or(scaled).to_string()
}

/// Writes a length in a unit, `per_m` of which make a metre, or in metres where no number of that unit is read back as the
/// same length.
///
/// ```
/// use mie_cloud::units::{format_length, parse_length_m};
/// assert_eq!(format_length(5.5e-7, "nm", 1e9), "550nm");
/// assert_eq!(format_length(1.5421e-6, "nm", 1e9), "1.5421e-6m");
/// assert_eq!(parse_length_m("1.5421e-6m")?, 1.5421e-6);
/// # Ok::<(), mie_cloud::units::UnitError>(())
/// ```
pub fn format_length(length_m: f64, unit: &str, per_m: f64) -> String {
    let text = format_in(length_m, per_m) + unit;
    if parse_length_m(&text) == Ok(length_m) { text } else { format!("{length_m:e}m") }
}

/// Splits `12.5e-3um` into its number and its unit.
pub fn split_unit(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    let mut end = 0;
    while end < bytes.len() {
        let exponent_sign = matches!(bytes[end], b'+' | b'-') && (end == 0 || matches!(bytes[end - 1], b'e' | b'E'));
        let exponent = matches!(bytes[end], b'e' | b'E')
            && bytes.get(end + 1).is_some_and(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-'));
        if !(bytes[end].is_ascii_digit() || bytes[end] == b'.' || exponent_sign || exponent) {
            break;
        }
        end += 1;
    }
    (&text[..end], text[end..].trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_carry_a_unit() {
        assert_eq!(parse_length_m("550nm"), Ok(550e-9));
        assert_eq!(parse_length_m("3cm"), Ok(0.03));
        assert_eq!(parse_length_m("1.5e2 mm"), Ok(0.15));
        assert_eq!(parse_length_m("2km"), Ok(2000.0));
        assert!(matches!(parse_length_m("5"), Err(UnitError::Unit { .. })));
        assert!(matches!(parse_length_m("-5um"), Err(UnitError::Range(_))));
        assert!(matches!(parse_length_m("1e308km"), Err(UnitError::Range(_))));
        assert!(matches!(parse_length_m("um"), Err(UnitError::NotANumber(_))));
    }

    #[test]
    fn memory_carries_a_unit() {
        assert_eq!(parse_bytes("64MiB"), Ok(64 << 20));
        assert_eq!(parse_bytes("2 GB"), Ok(2_000_000_000));
        assert_eq!(parse_bytes("1gib"), Ok(1 << 30));
        assert_eq!(parse_bytes("1e30TB"), Ok(u64::MAX));
        assert!(matches!(parse_bytes("64"), Err(UnitError::Unit { .. })));
        assert!(matches!(parse_bytes("64M"), Err(UnitError::Unit { .. })));
        assert!(matches!(parse_bytes("-1GB"), Err(UnitError::Range(_))));
        assert!(matches!(parse_bytes("GB"), Err(UnitError::NotANumber(_))));
        let shown = [0, 999, 1000, 9_994, 99_949, 999_499, 999_500, 64 << 20].map(format_bytes);
        assert_eq!(shown, ["0 B", "999 B", "1.00 kB", "9.99 kB", "99.9 kB", "999 kB", "1.00 MB", "67.1 MB"]);
    }

    #[test]
    fn times_carry_units_or_are_seconds() {
        for (text, seconds) in [
            ("90", 90.0),
            ("90s", 90.0),
            ("3m", 180.0),
            ("3min", 180.0),
            ("1h", 3600.0),
            ("1h30m", 5400.0),
            ("1.5h", 5400.0),
            (" 1h 2m 3.5s ", 3723.5),
            ("250ms", 0.25),
            ("2d", 172_800.0),
            ("1e3", 1000.0),
        ] {
            assert_eq!(parse_time_s(text), Ok(seconds), "{text}");
        }
        for text in ["", "s", "-3", "1h-30m", "1h30", "30 1h", "5 parsec", "nan", "inf", "1e300", "1e300h", "+5m"] {
            assert!(parse_time_s(text).is_err(), "{text}");
        }
    }
}
