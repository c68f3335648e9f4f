//! The wave inside the sphere: w_n, proportional to psi_n(mx), by downward recurrence without divisions.
//!
//! Legend: `z` = m x; `w0[n]` and `w1[n]` are psi_n(z) and psi_{n+1}(z) times one factor that may change from
//! order to order (only their ratio enters the coefficients); `n_terms` orders 1 ..= n_terms are filled.

use num_complex::Complex64;

/// Rescaling threshold and factor, powers of two: products with psi, chi (<= 1e62) and their squares stay finite.
const BIG: f64 = (1_u128 << 100) as f64;
const SCALE: f64 = 1.0 / BIG;

/// First order of the downward recurrence for psi_n(z), theory (6).
///
/// Beyond the turning point |z| the start is forgotten like the series truncates, by the same margin as in
/// [`super::terms::n_terms`]. With absorption the start is forgotten below it too, by exp(-Im z (M^2 - N^2)/|z|^2);
/// 48 stands for the 37 e-foldings of double precision and the flattening of that law near |z| (12 %).
pub(super) fn first_order(z: Complex64, n_terms: usize) -> usize {
    let size = z.norm();
    let turning = size + 6.5 * size.cbrt() + 8.0;
    let n = n_terms as f64;
    let absorbed = if z.im > 1.0 { (n * n + 48.0 * size * size / z.im).sqrt() + 8.0 } else { f64::INFINITY };
    (turning.min(absorbed).ceil() as usize).max(n_terms + 1)
}

/// Fills `w0`, `w1` (index n, 0 ..= n_terms) for a real index.
pub(super) fn fill_real(z: f64, w0: &mut [f64], w1: &mut [f64]) {
    let n_terms = w0.len() - 1;
    let inv_z = 1.0 / z;
    let first = first_order(Complex64::new(z, 0.0), n_terms);
    let c = (2 * first + 1) as f64 * inv_z;
    let (mut current, mut above) = (1.0, 2.0 / (c + (c * c - 4.0).max(0.0).sqrt()));
    let mut step = |n: usize| {
        (above, current) = (current, (2 * n + 3) as f64 * inv_z * current - above);
        if current.abs() > BIG {
            current *= SCALE;
            above *= SCALE;
        }
        (current, above)
    };
    for n in (n_terms + 1..first).rev() {
        step(n);
    }
    for (n, (w0, w1)) in w0.iter_mut().zip(w1).enumerate().rev() {
        (*w0, *w1) = step(n);
    }
}

/// Real and imaginary parts of `w0`, `w1` in arrays of their own.
pub(super) struct ComplexWaves<'a> {
    pub w0_re: &'a mut [f64],
    pub w0_im: &'a mut [f64],
    pub w1_re: &'a mut [f64],
    pub w1_im: &'a mut [f64],
}

/// As [`fill_real`] for an absorbing sphere.
pub(super) fn fill_complex(z: Complex64, w: ComplexWaves) {
    let n_terms = w.w0_re.len() - 1;
    let inv_z = z.conj() / z.norm_sqr();
    let first = first_order(z, n_terms);
    let (mut current, mut above) = (Complex64::new(1.0, 0.0), decaying_ratio((2 * first + 1) as f64 * inv_z));
    let mut step = |n: usize| {
        (above, current) = (current, (2 * n + 3) as f64 * inv_z * current - above);
        if current.re.abs() + current.im.abs() > BIG {
            current *= SCALE;
            above *= SCALE;
        }
        (current, above)
    };
    for n in (n_terms + 1..first).rev() {
        step(n);
    }
    for n in (0..=n_terms).rev() {
        let (w0, w1) = step(n);
        (w.w0_re[n], w.w0_im[n]) = (w0.re, w0.im);
        (w.w1_re[n], w.w1_im[n]) = (w1.re, w1.im);
    }
}

/// The root of r^2 - c r + 1 = 0 inside the unit circle: the ratio of neighbours where c hardly changes.
fn decaying_ratio(c: Complex64) -> Complex64 {
    let root = (c * c - 4.0).sqrt();
    let (plus, minus) = (c + root, c - root);
    2.0 / if plus.norm_sqr() >= minus.norm_sqr() { plus } else { minus }
}
