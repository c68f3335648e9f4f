//! Quantities with units as they are written by people: `5um`, `550nm`, `0.3g/m3`.

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
    /// The number is negative, infinite or NaN.
    #[error("`{0}` is not a finite, non-negative number")]
    Range(String),
}

const LENGTHS: [(&str, f64); 6] = [("nm", 1e-9), ("um", 1e-6), ("µm", 1e-6), ("mm", 1e-3), ("km", 1e3), ("m", 1.0)];

/// Reads a length with its unit (nm, um, mm, m, km), in metres.
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
        .ok_or(UnitError::Unit { text: text.into(), expected: "nm, um, mm, m, km" })?;
    // Dividing by an exact power of ten rounds once; 5um is 5e-6, not 4.9999999999999996e-6.
    let value_m = if scale < 1.0 { value / (1.0 / scale).round() } else { value * scale };
    // Kilometres can overflow.
    if value_m.is_finite() && value_m >= 0.0 { Ok(value_m) } else { Err(UnitError::Range(text.into())) }
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
        assert_eq!(parse_length_m("1.5e2 mm"), Ok(0.15));
        assert_eq!(parse_length_m("2km"), Ok(2000.0));
        assert!(matches!(parse_length_m("5"), Err(UnitError::Unit { .. })));
        assert!(matches!(parse_length_m("-5um"), Err(UnitError::Range(_))));
        assert!(matches!(parse_length_m("1e308km"), Err(UnitError::Range(_))));
        assert!(matches!(parse_length_m("um"), Err(UnitError::NotANumber(_))));
    }
}
