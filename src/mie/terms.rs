//! How many partial waves a sphere needs.

/// Number of partial waves for a size parameter `x`: the truncation error lies below that of rounding.
///
/// Wiscombe's (1980) count x + 4.05 x^(1/3) + 2 leaves 1e-6 in S(180 deg); 6.2 x^(1/3) + 8 leaves less than 1e-13.
/// Below x = 2, where psi_n / chi_n falls by more than (n/x)^2 per order, 5 does as well.
#[inline(always)]
pub(super) fn n_terms(x: f64) -> usize {
    turning_terms(x).ceil() as usize
}

/// The same as a real number: where psi_n(x) has decayed by the digits of a double beyond its turning point n = x.
#[inline(always)]
pub(super) fn turning_terms(x: f64) -> f64 {
    x + 6.2 * x.cbrt() + if x < 2.0 { 5.0 } else { 8.0 }
}
