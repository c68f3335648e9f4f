//! The validated domain, as data.

use num_complex::Complex64;

use super::MieError;

/// Smallest and largest size parameter.
pub const SIZE_PARAMETER: [f64; 2] = [1e-6, 1e6];
/// Smallest and largest real part of the relative index.
pub const INDEX_REAL: [f64; 2] = [0.05, 20.0];
/// Smallest and largest imaginary part of the relative index.
pub const INDEX_IMAGINARY: [f64; 2] = [0.0, 100.0];

/// Refuses what lies outside the domain, NaN included.
pub(super) fn check(x: f64, m: Complex64) -> Result<(), MieError> {
    let inside = |value: f64, [low, high]: [f64; 2]| value >= low && value <= high;
    if !inside(x, SIZE_PARAMETER) {
        return Err(MieError::SizeParameter(x));
    }
    if !inside(m.re, INDEX_REAL) || !inside(m.im, INDEX_IMAGINARY) {
        return Err(MieError::Index { n: m.re, k: m.im });
    }
    Ok(())
}
