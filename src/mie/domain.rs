//! The validated domain and the accuracy promised in it, as data that the tests enforce.

use num_complex::Complex64;

use super::MieError;

/// Smallest and largest size parameter.
pub const SIZE_PARAMETER: [f64; 2] = [1e-6, 1e6];
/// Smallest and largest real part of the relative index.
pub const INDEX_REAL: [f64; 2] = [0.05, 20.0];
/// Smallest and largest imaginary part of the relative index.
pub const INDEX_IMAGINARY: [f64; 2] = [0.0, 100.0];

/// Units in the last place of x and m that the results may be off by, beyond the floors of [`ACCURACY`].
///
/// An output F that answers a relative change e of x or m by cond e, cond = |d ln F / d ln x| + |d ln F / d ln m|,
/// cannot be better than cond times the rounding of x and m. Near narrow resonances cond reaches 1e13.
pub const CONDITION_ULPS: f64 = 4.0;

/// Largest relative error of each kind of output over a range of sizes, where its condition does not demand more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// The range ends at this size parameter.
    pub x_max: f64,
    /// q_ext, q_sca, q_abs and g, each relative to itself.
    pub efficiencies: f64,
    /// S1 and S2, relative to their root mean square over angles that include the forward direction.
    pub amplitudes: f64,
}

/// The promise by size: phases near x cost x times the rounding of x, hence the growth for S.
pub const ACCURACY: [Accuracy; 5] = [
    Accuracy { x_max: 1e2, efficiencies: 1e-12, amplitudes: 1e-13 },
    Accuracy { x_max: 3e3, efficiencies: 1e-12, amplitudes: 1e-12 },
    Accuracy { x_max: 2e4, efficiencies: 1e-12, amplitudes: 1e-11 },
    Accuracy { x_max: 1e5, efficiencies: 1e-12, amplitudes: 1e-10 },
    Accuracy { x_max: 1e6, efficiencies: 1e-12, amplitudes: 1e-9 },
];

/// The accuracy promised at size parameter `x`.
pub fn accuracy(x: f64) -> Accuracy {
    let [.., last] = ACCURACY;
    ACCURACY.into_iter().find(|range| x <= range.x_max).unwrap_or(last)
}

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
