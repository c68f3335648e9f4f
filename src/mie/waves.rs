//! The waves of one sphere over all orders, and the walk through its coefficients.

use num_complex::Complex64;

use super::{
    coefficients::{BLOCK, Block, ComplexInner, Outer, RealInner, Sphere, complex_block, real_block},
    exterior::fill_exterior,
    interior::{ComplexInterior, RealInterior},
    terms::n_terms,
};

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

/// Lengthens `row` to at least `len` and lends that much of it.
#[inline(always)]
fn lend(row: &mut Vec<f64>, len: usize) -> &mut [f64] {
    if row.len() < len {
        row.resize(len, 0.0);
    }
    &mut row[..len]
}

/// The block of `row` that starts at `first`.
#[inline(always)]
fn window(row: &[f64], first: usize) -> &[f64; BLOCK] {
    &row[first..].as_chunks::<BLOCK>().0[0]
}

impl Waves {
    /// Visits the coefficients of a sphere in blocks of falling order and returns the number of terms it needs.
    ///
    /// The first block may hold a few orders more. `x` and `m` must have been checked.
    #[inline(always)]
    pub fn visit_blocks(&mut self, x: f64, m: Complex64, visit: impl FnMut(&Block)) -> usize {
        let n_terms = n_terms(x);
        let last = n_terms.next_multiple_of(BLOCK);
        let sphere = Sphere::new(x, m);
        if m.im == 0.0 {
            self.visit_real(&sphere, last, visit)
        } else {
            self.visit_complex(&sphere, last, visit)
        }
        n_terms
    }

    #[inline(always)]
    fn visit_real(&mut self, sphere: &Sphere, last: usize, mut visit: impl FnMut(&Block)) {
        self.fill_real(sphere, last);
        if sphere.near_one {
            self.sum_real(sphere, last);
        }
        let mut block = Block::above(last);
        while block.first > 1 {
            block.step_down();
            let first = block.first;
            let pb = sphere.near_one.then(|| window(&self.pb_re, first));
            let inner = RealInner { w0: window(&self.w0_re, first), w1: window(&self.w1_re, first), pb };
            real_block(sphere, &self.outer(first), &inner, &mut block);
            visit(&block);
        }
    }

    #[inline(always)]
    fn visit_complex(&mut self, sphere: &Sphere, last: usize, mut visit: impl FnMut(&Block)) {
        self.fill_complex(sphere, last);
        if sphere.near_one {
            self.sum_complex(sphere, last);
        }
        let mut block = Block::above(last);
        while block.first > 1 {
            block.step_down();
            let first = block.first;
            let inner = ComplexInner {
                w0_re: window(&self.w0_re, first),
                w0_im: window(&self.w0_im, first),
                w1_re: window(&self.w1_re, first),
                w1_im: window(&self.w1_im, first),
                pb: sphere.near_one.then(|| (window(&self.pb_re, first), window(&self.pb_im, first))),
            };
            complex_block(sphere, &self.outer(first), &inner, &mut block);
            visit(&block);
        }
    }

    #[inline(always)]
    fn outer(&self, first: usize) -> Outer<'_> {
        Outer {
            psi0: window(&self.psi, first),
            psi1: window(&self.psi, first + 1),
            chi0: window(&self.chi, first),
            chi1: window(&self.chi, first + 1),
        }
    }

    #[inline(always)]
    fn fill_real(&mut self, sphere: &Sphere, last: usize) {
        let (psi, chi) = (lend(&mut self.psi, last + 2), lend(&mut self.chi, last + 2));
        let (w0, w1) = (lend(&mut self.w0_re, last + 1), lend(&mut self.w1_re, last + 1));
        let mut rows = w0.iter_mut().zip(w1).rev();
        let mut interior = RealInterior::new(sphere.m.re * sphere.x, last);
        fill_exterior(
            sphere.x,
            psi,
            chi,
            #[inline(always)]
            || {
                if let Some((w0, w1)) = rows.next() {
                    (*w0, *w1) = interior.step();
                }
            },
        );
    }

    #[inline(always)]
    fn fill_complex(&mut self, sphere: &Sphere, last: usize) {
        let (psi, chi) = (lend(&mut self.psi, last + 2), lend(&mut self.chi, last + 2));
        let (w0_re, w0_im) = (lend(&mut self.w0_re, last + 1), lend(&mut self.w0_im, last + 1));
        let (w1_re, w1_im) = (lend(&mut self.w1_re, last + 1), lend(&mut self.w1_im, last + 1));
        let mut rows = w0_re.iter_mut().zip(w0_im).zip(w1_re.iter_mut().zip(w1_im)).rev();
        let mut interior = ComplexInterior::new(sphere.m * sphere.x, last);
        fill_exterior(
            sphere.x,
            psi,
            chi,
            #[inline(always)]
            || {
                if let Some(((w0_re, w0_im), (w1_re, w1_im))) = rows.next() {
                    let (w0, w1) = interior.step();
                    (*w0_re, *w0_im, *w1_re, *w1_im) = (w0.re, w0.im, w1.re, w1.im);
                }
            },
        );
    }

    /// p_b by its own downward recurrence, theory (10): no difference of close numbers at m -> 1.
    fn sum_real(&mut self, sphere: &Sphere, last: usize) {
        let pb = lend(&mut self.pb_re, last + 1);
        let (m, one_minus_m2) = (sphere.m.re, sphere.one_minus_m2.re);
        // Factors 1/m and m as 1 + shift: a rounded factor would add up over n_terms orders.
        let shift = if m >= 1.0 { (1.0 - m) / m } else { m - 1.0 };
        let (mut p, mut w0_above) = (0.0, 0.0);
        for n in (1..=last).rev() {
            let (w0, w1) = (self.w0_re[n], self.w1_re[n]);
            if w0_above != w1 && w0_above != 0.0 {
                // The inner wave was rescaled between n + 1 and n, by a power of two.
                p *= w1 / w0_above;
            }
            p = if m >= 1.0 {
                let sum = p + one_minus_m2 * w1 * self.psi[n];
                sum + sum * shift
            } else {
                p + (p * shift + one_minus_m2 * w0 * self.psi[n + 1])
            };
            pb[n] = p;
            w0_above = w0;
        }
    }

    /// As [`Self::sum_real`] for a complex index.
    fn sum_complex(&mut self, sphere: &Sphere, last: usize) {
        let (pb_re, pb_im) = (lend(&mut self.pb_re, last + 1), lend(&mut self.pb_im, last + 1));
        let outside = sphere.m.norm_sqr() >= 1.0;
        let shift = if outside { (1.0 - sphere.m) * sphere.inv_m } else { sphere.m - 1.0 };
        let (mut p, mut above) = (Complex64::default(), Complex64::default());
        for n in (1..=last).rev() {
            let w0 = Complex64::new(self.w0_re[n], self.w0_im[n]);
            let w1 = Complex64::new(self.w1_re[n], self.w1_im[n]);
            if above != w1 && above != Complex64::default() {
                let scale = if above.re != 0.0 { w1.re / above.re } else { w1.im / above.im };
                p *= scale;
            }
            p = if outside {
                let sum = p + sphere.one_minus_m2 * w1 * self.psi[n];
                sum + sum * shift
            } else {
                p + (p * shift + sphere.one_minus_m2 * w0 * self.psi[n + 1])
            };
            (pb_re[n], pb_im[n]) = (p.re, p.im);
            above = w0;
        }
    }
}
