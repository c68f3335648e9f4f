//! The wave inside the sphere: w_n, proportional to psi_n(mx), by downward recurrence without divisions.
//!
//! Legend: `z` = m x; `w0[n]` and `w1[n]` are psi_n(z) and psi_{n+1}(z) times one factor that may change from
//! order to order: only their ratio enters the coefficients.

use num_complex::Complex64;

use super::terms::turning_terms;

/// Rescaling threshold and factor, powers of two: products with psi, chi (<= 1e121) and their squares stay finite.
const BIG: f64 = (1_u128 << 100) as f64;
const SCALE: f64 = 1.0 / BIG;

/// First order of the downward recurrence for psi_n(z), theory (6).
///
/// Beyond the turning point |z| the start is forgotten like the series truncates. With absorption it is forgotten
/// below |z| too, by exp(-Im z (M^2 - N^2)/|z|^2); 48 stands for the 37 e-foldings of double precision and the
/// flattening of that law near |z| (12 %).
fn first_order(z: Complex64, n_last: usize) -> usize {
    let size_squared = z.norm_sqr();
    let n = n_last as f64;
    let absorbed = if z.im > 1.0 { (n * n + 48.0 * size_squared / z.im).sqrt() + 8.0 } else { f64::INFINITY };
    (turning_terms(size_squared.sqrt()).min(absorbed).ceil() as usize).max(n_last + 1)
}

/// Downward recurrence of w_n for a real index.
pub(super) struct RealInterior {
    inv_z: f64,
    /// 2n + 3, n the next order.
    odd: f64,
    current: f64,
    above: f64,
}

impl RealInterior {
    /// Recurs to the order just above `n_last`.
    #[inline(always)]
    pub fn new(z: f64, n_last: usize) -> Self {
        let inv_z = 1.0 / z;
        let first = first_order(Complex64::new(z, 0.0), n_last);
        let odd = (2 * first + 1) as f64;
        let mut interior = Self { inv_z, odd, current: 1.0, above: 1.0 / (odd * inv_z) };
        for _ in n_last + 1..first {
            interior.step();
        }
        interior
    }

    /// One order down: (w_n, w_{n+1}).
    #[inline(always)]
    pub fn step(&mut self) -> (f64, f64) {
        let next = self.odd * self.inv_z * self.current - self.above;
        (self.above, self.current) = (self.current, next);
        self.odd -= 2.0;
        if self.current.abs() > BIG {
            (self.current, self.above) = (shrink(self.current), shrink(self.above));
        }
        (self.current, self.above)
    }
}

/// Rescales one number. Out of line: a branch that is never taken costs nothing, a select lengthens the chain.
#[cold]
#[inline(never)]
fn shrink(value: f64) -> f64 {
    value * SCALE
}

/// Downward recurrence of w_n for an absorbing sphere.
pub(super) struct ComplexInterior {
    inv_z: Complex64,
    /// 2n + 3, n the next order.
    odd: f64,
    current: Complex64,
    above: Complex64,
}

impl ComplexInterior {
    /// Recurs to the order just above `n_last`.
    #[inline(always)]
    pub fn new(z: Complex64, n_last: usize) -> Self {
        let inv_z = z.conj() / z.norm_sqr();
        let first = first_order(z, n_last);
        let odd = (2 * first + 1) as f64;
        let mut interior = Self { inv_z, odd, current: Complex64::new(1.0, 0.0), above: z / odd };
        for _ in n_last + 1..first {
            interior.step();
        }
        interior
    }

    /// One order down: (w_n, w_{n+1}).
    #[inline(always)]
    pub fn step(&mut self) -> (Complex64, Complex64) {
        let (c_re, c_im) = (self.odd * self.inv_z.re, self.odd * self.inv_z.im);
        let next = Complex64::new(
            c_re * self.current.re - self.above.re - c_im * self.current.im,
            c_re * self.current.im - self.above.im + c_im * self.current.re,
        );
        (self.above, self.current) = (self.current, next);
        self.odd -= 2.0;
        if self.current.re.abs() + self.current.im.abs() > BIG {
            let parts = [self.current.re, self.current.im, self.above.re, self.above.im].map(shrink);
            self.current = Complex64::new(parts[0], parts[1]);
            self.above = Complex64::new(parts[2], parts[3]);
        }
        (self.current, self.above)
    }
}
