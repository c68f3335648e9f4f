//! The scattering coefficients a_n, b_n of one sphere, block by block, from the waves outside and inside.
//!
//! Legend: `psi`, `chi` Riccati-Bessel functions of x; `w0`, `w1` the inner wave at n and n + 1 (see `interior`);
//! `pa`, `qa`, `pb`, `qb` numerators and cofactors: a_n = pa / (pa - i qa), b_n = pb / (pb - i qb), theory (7)-(9).

use num_complex::Complex64;

use super::{
    interior::{ComplexWaves, fill_complex, fill_real},
    riccati::fill_riccati,
    terms::n_terms,
};

/// Orders per block: its arrays (4 kB) live on the stack and in the first-level cache.
pub(super) const BLOCK: usize = 32;

/// Below this |1 - m^2| the difference form p_b = w_n psi_{n+1} - m w_{n+1} psi_n loses digits and the
/// summed form, theory (10), is used; above it loses at most a factor of two.
const NEAR_ONE: f64 = 0.5;

/// Coefficients of the orders `first`, `first + 1`, .. of one block; entry `len` is the order after the last.
pub(super) struct Block {
    /// First order, 1, 1 + BLOCK, ..
    pub first: usize,
    /// Number of orders.
    pub len: usize,
    pub a_re: [f64; BLOCK + 1],
    pub a_im: [f64; BLOCK + 1],
    pub b_re: [f64; BLOCK + 1],
    pub b_im: [f64; BLOCK + 1],
    /// |a_n|^2 + |b_n|^2.
    pub sca: [f64; BLOCK],
    /// Re(a_n + b_n) - |a_n|^2 - |b_n|^2, from terms of one sign.
    pub abs: [f64; BLOCK],
}

impl Block {
    fn new() -> Self {
        Self {
            first: 1,
            len: 0,
            a_re: [0.0; BLOCK + 1],
            a_im: [0.0; BLOCK + 1],
            b_re: [0.0; BLOCK + 1],
            b_im: [0.0; BLOCK + 1],
            sca: [0.0; BLOCK],
            abs: [0.0; BLOCK],
        }
    }

    /// Moves to the block that ends just below this one; its entry `len` is this block's first order.
    fn step_down(&mut self, first: usize, len: usize) {
        for c in [&mut self.a_re, &mut self.a_im, &mut self.b_re, &mut self.b_im] {
            c[len] = c[0];
        }
        (self.first, self.len) = (first, len);
    }
}

/// The arrays over n that a sphere needs; kept between spheres, so that a sequence of them allocates once.
#[derive(Clone, Debug, Default)]
pub(super) struct Waves {
    psi: Vec<f64>,
    chi: Vec<f64>,
    w0_re: Vec<f64>,
    w0_im: Vec<f64>,
    w1_re: Vec<f64>,
    w1_im: Vec<f64>,
    pb_re: Vec<f64>,
    pb_im: Vec<f64>,
}

impl Waves {
    /// Visits the coefficients of a sphere in blocks of falling order and returns their number.
    ///
    /// `x` and `m` must have been checked.
    #[inline(always)]
    pub fn visit_blocks(&mut self, x: f64, m: Complex64, mut visit: impl FnMut(&Block)) -> usize {
        let n_terms = n_terms(x);
        self.fill(x, m, n_terms);
        let sphere = Sphere::new(x, m);
        let mut block = Block::new();
        let mut end = n_terms + 1;
        while end > 1 {
            let first = 1 + (end - 2) / BLOCK * BLOCK;
            block.step_down(first, end - first);
            if m.im == 0.0 { self.real_block(&sphere, &mut block) } else { self.complex_block(&sphere, &mut block) }
            visit(&block);
            end = first;
        }
        n_terms
    }

    /// Fills the waves, and the summed form of p_b where m is near 1.
    fn fill(&mut self, x: f64, m: Complex64, n_terms: usize) {
        let grow = |v: &mut Vec<f64>, len: usize| {
            if v.len() < len {
                v.resize(len, 0.0);
            }
        };
        grow(&mut self.psi, n_terms + 2);
        grow(&mut self.chi, n_terms + 2);
        fill_riccati(x, &mut self.psi[..n_terms + 2], &mut self.chi[..n_terms + 2]);
        let len = n_terms + 1;
        for v in [&mut self.w0_re, &mut self.w1_re] {
            grow(v, len);
        }
        let near_one = Sphere::new(x, m).near_one;
        if m.im == 0.0 {
            fill_real(m.re * x, &mut self.w0_re[..len], &mut self.w1_re[..len]);
            if near_one {
                grow(&mut self.pb_re, len);
                self.sum_real(m.re, n_terms);
            }
            return;
        }
        for v in [&mut self.w0_im, &mut self.w1_im] {
            grow(v, len);
        }
        let waves = ComplexWaves {
            w0_re: &mut self.w0_re[..len],
            w0_im: &mut self.w0_im[..len],
            w1_re: &mut self.w1_re[..len],
            w1_im: &mut self.w1_im[..len],
        };
        fill_complex(m * x, waves);
        if near_one {
            grow(&mut self.pb_re, len);
            grow(&mut self.pb_im, len);
            self.sum_complex(m, n_terms);
        }
    }

    /// p_b by its own downward recurrence, theory (10): no difference of close numbers at m -> 1.
    fn sum_real(&mut self, m: f64, n_terms: usize) {
        let one_minus_m2 = (1.0 - m) * (1.0 + m);
        let mut p = 0.0;
        let mut w0_above = f64::NAN;
        for n in (1..=n_terms).rev() {
            let (w0, w1) = (self.w0_re[n], self.w1_re[n]);
            if w0_above.abs() > w1.abs() {
                // The inner wave was rescaled between n + 1 and n.
                p *= w1 / w0_above;
            }
            p = if m >= 1.0 {
                (p + one_minus_m2 * w1 * self.psi[n]) / m
            } else {
                p * m + one_minus_m2 * w0 * self.psi[n + 1]
            };
            self.pb_re[n] = p;
            w0_above = w0;
        }
    }

    /// As [`Self::sum_real`] for a complex index.
    fn sum_complex(&mut self, m: Complex64, n_terms: usize) {
        let one_minus_m2 = (1.0 - m) * (1.0 + m);
        let inv_m = m.inv();
        let outside = m.norm_sqr() >= 1.0;
        let mut p = Complex64::new(0.0, 0.0);
        let mut w0_above = Complex64::new(0.0, 0.0);
        for n in (1..=n_terms).rev() {
            let w0 = Complex64::new(self.w0_re[n], self.w0_im[n]);
            let w1 = Complex64::new(self.w1_re[n], self.w1_im[n]);
            if w0_above.norm_sqr() > w1.norm_sqr() {
                p *= (w1.norm_sqr() / w0_above.norm_sqr()).sqrt();
            }
            p = if outside {
                (p + one_minus_m2 * w1 * self.psi[n]) * inv_m
            } else {
                p * m + one_minus_m2 * w0 * self.psi[n + 1]
            };
            (self.pb_re[n], self.pb_im[n]) = (p.re, p.im);
            w0_above = w0;
        }
    }

    /// Coefficients of a block for a real index: a_n = p (p + i q) / (p^2 + q^2), so that Re a_n = |a_n|^2.
    #[inline(always)]
    fn real_block(&self, sphere: &Sphere, block: &mut Block) {
        let (from, len) = (block.first, block.len);
        let range = from..from + len;
        let psi0 = &self.psi[range.clone()];
        let psi1 = &self.psi[from + 1..][..len];
        let chi0 = &self.chi[range.clone()];
        let chi1 = &self.chi[from + 1..][..len];
        let (w0, w1) = (&self.w0_re[range.clone()], &self.w1_re[range.clone()]);
        let (mut pa, mut pb) = ([0.0; BLOCK], [0.0; BLOCK]);
        let (m, inv_m, k_over_x) = (sphere.m.re, sphere.inv_m.re, sphere.k_over_x.re);
        let order = (from + 1) as f64;
        if sphere.near_one {
            let sum = &self.pb_re[range];
            let k = sphere.k.re;
            for i in 0..len {
                pb[i] = sum[i];
                pa[i] = sum[i] + (k_over_x * (order + i as f64) * w0[i] - k * m * w1[i]) * psi0[i];
            }
        } else {
            for i in 0..len {
                pb[i] = w0[i] * psi1[i] - m * w1[i] * psi0[i];
                pa[i] = w0[i] * psi1[i] - (inv_m * w1[i] - k_over_x * (order + i as f64) * w0[i]) * psi0[i];
            }
        }
        for i in 0..len {
            let qb = w0[i] * chi1[i] - m * w1[i] * chi0[i];
            let qa = w0[i] * chi1[i] - (inv_m * w1[i] - k_over_x * (order + i as f64) * w0[i]) * chi0[i];
            let fa = pa[i] / (pa[i] * pa[i] + qa * qa);
            let fb = pb[i] / (pb[i] * pb[i] + qb * qb);
            block.a_re[i] = fa * pa[i];
            block.a_im[i] = fa * qa;
            block.b_re[i] = fb * pb[i];
            block.b_im[i] = fb * qb;
            block.sca[i] = fa * pa[i] + fb * pb[i];
        }
    }

    /// Coefficients of a block for an absorbing sphere; absorption directly, theory (11).
    #[inline(always)]
    fn complex_block(&self, sphere: &Sphere, block: &mut Block) {
        for i in 0..block.len {
            let n = block.first + i;
            let (psi0, psi1, chi0, chi1) = (self.psi[n], self.psi[n + 1], self.chi[n], self.chi[n + 1]);
            let w0 = Complex64::new(self.w0_re[n], self.w0_im[n]);
            let w1 = Complex64::new(self.w1_re[n], self.w1_im[n]);
            let magnetic = sphere.m * w1;
            let electric = sphere.inv_m * w1 - (n + 1) as f64 * sphere.k_over_x * w0;
            let (pa, pb) = if sphere.near_one {
                let pb = Complex64::new(self.pb_re[n], self.pb_im[n]);
                (pb + ((n + 1) as f64 * sphere.k_over_x * w0 - sphere.k * magnetic) * psi0, pb)
            } else {
                (w0 * psi1 - electric * psi0, w0 * psi1 - magnetic * psi0)
            };
            let flux = w1 * w0.conj();
            let absorbed_b = sphere.m.re * flux.im + sphere.m.im * flux.re;
            let absorbed_a = (sphere.m.re * flux.im - sphere.m.im * flux.re) * sphere.inv_m.norm_sqr()
                - (n + 1) as f64 * sphere.k_over_x.im * w0.norm_sqr();
            let a = Partial::new(pa, w0 * chi1 - electric * chi0, absorbed_a);
            let b = Partial::new(pb, w0 * chi1 - magnetic * chi0, absorbed_b);
            (block.a_re[i], block.a_im[i]) = (a.sca + a.abs, a.im);
            (block.b_re[i], block.b_im[i]) = (b.sca + b.abs, b.im);
            block.sca[i] = a.sca + b.sca;
            block.abs[i] = a.abs + b.abs;
        }
    }
}

/// One coefficient c: |c|^2, Re c - |c|^2 and Im c.
struct Partial {
    sca: f64,
    abs: f64,
    im: f64,
}

impl Partial {
    #[inline(always)]
    fn new(p: Complex64, q: Complex64, absorbed: f64) -> Self {
        let d = Complex64::new(p.re + q.im, p.im - q.re);
        let inv = 1.0 / d.norm_sqr();
        Self { sca: p.norm_sqr() * inv, abs: absorbed * inv, im: (p.im * d.re - p.re * d.im) * inv }
    }
}

/// Constants of one sphere.
struct Sphere {
    m: Complex64,
    inv_m: Complex64,
    /// k = (1 - m^2) / m^2.
    k: Complex64,
    k_over_x: Complex64,
    /// p_b must be summed.
    near_one: bool,
}

impl Sphere {
    #[inline(always)]
    fn new(x: f64, m: Complex64) -> Self {
        let one_minus_m2 = (1.0 - m) * (1.0 + m);
        let inv_m = m.inv();
        let k = one_minus_m2 * inv_m * inv_m;
        Self { m, inv_m, k, k_over_x: k / x, near_one: one_minus_m2.norm_sqr() < NEAR_ONE * NEAR_ONE }
    }
}
