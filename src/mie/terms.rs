//! How many partial waves a sphere needs.

/// Number of partial waves for a size parameter `x`: the truncation error lies below that of rounding.
///
/// Wiscombe's (1980) count x + 4.05 x^(1/3) + 2 leaves 1e-6 in S(180 deg); 6.2 x^(1/3) + 8 leaves less than 1e-13.
pub(super) fn n_terms(x: f64) -> usize {
    (x + 6.2 * x.cbrt() + 8.0).ceil() as usize
}
