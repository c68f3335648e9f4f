//! The scattering coefficients a_n, b_n of one block of orders from the waves outside and inside.
//!
//! Legend: `psi`, `chi` Riccati-Bessel functions of x; `w0`, `w1` the inner wave at n and n + 1 (see `interior`);
//! `pa`, `qa`, `pb`, `qb` numerators and cofactors: a_n = pa / (pa - i qa), b_n = pb / (pb - i qb), theory (7)-(9);
//! a number at the end of a name is the step from n: `psi1` = psi_{n+1}.
//!
//! Loops run over arrays of fixed length with plain operations, so that the compiler turns them into vector code.

use num_complex::Complex64;

/// Orders per block: two vectors of AVX-512, four of AVX2.
pub(super) const BLOCK: usize = 16;

/// 0, 1, .. as floating-point numbers.
pub(super) const RAMP: [f64; BLOCK] = {
    let mut ramp = [0.0; BLOCK];
    let mut i = 0;
    while i < BLOCK {
        ramp[i] = i as f64;
        i += 1;
    }
    ramp
};

/// Below this |1 - m^2| the difference form p_b = w_n psi_{n+1} - m w_{n+1} psi_n loses digits and the summed
/// form, theory (10), is used; above it loses at most a factor of two.
const NEAR_ONE: f64 = 0.5;

type Row = [f64; BLOCK];

/// Coefficients of the orders `first` ..; entry BLOCK is the order after the last.
pub(super) struct Block {
    /// First order: 1, 1 + BLOCK, ..
    pub first: usize,
    pub a_re: [f64; BLOCK + 1],
    pub a_im: [f64; BLOCK + 1],
    pub b_re: [f64; BLOCK + 1],
    pub b_im: [f64; BLOCK + 1],
    /// |a_n|^2 + |b_n|^2.
    pub sca: Row,
    /// Re(a_n + b_n) - |a_n|^2 - |b_n|^2, theory (11).
    pub abs: Row,
}

impl Block {
    /// The block of zeros above the last order.
    #[inline(always)]
    pub fn above(last: usize) -> Self {
        let (zeros, rows) = ([0.0; BLOCK + 1], [0.0; BLOCK]);
        Self { first: last + 1, a_re: zeros, a_im: zeros, b_re: zeros, b_im: zeros, sca: rows, abs: rows }
    }

    /// Moves to the block below; its entry BLOCK is this block's first order.
    #[inline(always)]
    pub fn step_down(&mut self) {
        self.first -= BLOCK;
        self.a_re[BLOCK] = self.a_re[0];
        self.a_im[BLOCK] = self.a_im[0];
        self.b_re[BLOCK] = self.b_re[0];
        self.b_im[BLOCK] = self.b_im[0];
    }
}

/// Constants of one sphere.
pub(super) struct Sphere {
    pub x: f64,
    pub m: Complex64,
    pub inv_m: Complex64,
    /// 1 - m^2.
    pub one_minus_m2: Complex64,
    /// k = (1 - m^2) / m^2.
    pub k: Complex64,
    /// p_b must be summed.
    pub near_one: bool,
}

impl Sphere {
    #[inline(always)]
    pub fn new(x: f64, m: Complex64) -> Self {
        let one_minus_m2 = Complex64::new((1.0 - m.re) * (1.0 + m.re) + m.im * m.im, -2.0 * m.re * m.im);
        let inv_m = m.conj() / m.norm_sqr();
        // The product would lose |m|^2 ulps of Im(1/m^2), which is what a small metal sphere absorbs by.
        let inv_m2 = inv_m * inv_m;
        let k = Complex64::new((one_minus_m2 * inv_m2).re, inv_m2.im);
        Self { x, m, inv_m, one_minus_m2, k, near_one: one_minus_m2.norm_sqr() < NEAR_ONE * NEAR_ONE }
    }
}

/// The outer waves of one block.
pub(super) struct Outer<'a> {
    pub psi0: &'a Row,
    pub psi1: &'a Row,
    pub chi0: &'a Row,
    pub chi1: &'a Row,
}

/// The inner wave of one block for a real index; `pb` where it had to be summed.
pub(super) struct RealInner<'a> {
    pub w0: &'a Row,
    pub w1: &'a Row,
    pub pb: Option<&'a Row>,
}

/// Coefficients for a real index: a_n = p (p + i q) / (p^2 + q^2), so that Re a_n = |a_n|^2.
#[inline(always)]
pub(super) fn real_block(sphere: &Sphere, o: &Outer, inner: &RealInner, block: &mut Block) {
    let (w0, w1) = (inner.w0, inner.w1);
    let (m, inv_m, k) = (sphere.m.re, sphere.inv_m.re, sphere.k.re);
    let (k_over_x, order1) = (k / sphere.x, block.first as f64 + 1.0);
    let (mut pa, mut pb) = ([0.0; BLOCK], [0.0; BLOCK]);
    let (mut magnetic, mut electric) = ([0.0; BLOCK], [0.0; BLOCK]);
    for i in 0..BLOCK {
        magnetic[i] = m * w1[i];
        electric[i] = inv_m * w1[i] - k_over_x * (order1 + RAMP[i]) * w0[i];
    }
    if let Some(sum) = inner.pb {
        for i in 0..BLOCK {
            pb[i] = sum[i];
            pa[i] = sum[i] + (k_over_x * (order1 + RAMP[i]) * w0[i] - k * magnetic[i]) * o.psi0[i];
        }
    } else {
        for i in 0..BLOCK {
            pb[i] = w0[i] * o.psi1[i] - magnetic[i] * o.psi0[i];
            pa[i] = w0[i] * o.psi1[i] - electric[i] * o.psi0[i];
        }
    }
    for i in 0..BLOCK {
        let qa = w0[i] * o.chi1[i] - electric[i] * o.chi0[i];
        let qb = w0[i] * o.chi1[i] - magnetic[i] * o.chi0[i];
        let fa = pa[i] / (pa[i] * pa[i] + qa * qa);
        let fb = pb[i] / (pb[i] * pb[i] + qb * qb);
        block.a_re[i] = fa * pa[i];
        block.a_im[i] = fa * qa;
        block.b_re[i] = fb * pb[i];
        block.b_im[i] = fb * qb;
        block.sca[i] = block.a_re[i] + block.b_re[i];
    }
}

/// The inner wave of one block for an absorbing sphere; `pb` where it had to be summed.
pub(super) struct ComplexInner<'a> {
    pub w0_re: &'a Row,
    pub w0_im: &'a Row,
    pub w1_re: &'a Row,
    pub w1_im: &'a Row,
    pub pb: Option<(&'a Row, &'a Row)>,
}

/// Coefficients for an absorbing sphere; what they absorb is computed directly, theory (11).
#[inline(always)]
pub(super) fn complex_block(sphere: &Sphere, o: &Outer, inner: &ComplexInner, block: &mut Block) {
    let (m, inv_m, k) = (sphere.m, sphere.inv_m, sphere.k);
    let (k_over_x, order1, inv_m2) = (k / sphere.x, block.first as f64 + 1.0, inv_m.norm_sqr());
    let (mut pa_re, mut pa_im) = ([0.0; BLOCK], [0.0; BLOCK]);
    let (mut pb_re, mut pb_im) = ([0.0; BLOCK], [0.0; BLOCK]);
    if let Some((sum_re, sum_im)) = inner.pb {
        for i in 0..BLOCK {
            let (w0, w1) = inner.waves(i);
            let pb = Complex64::new(sum_re[i], sum_im[i]);
            let pa = pb + ((order1 + RAMP[i]) * k_over_x * w0 - k * (m * w1)) * o.psi0[i];
            (pa_re[i], pa_im[i], pb_re[i], pb_im[i]) = (pa.re, pa.im, pb.re, pb.im);
        }
    } else {
        for i in 0..BLOCK {
            let (w0, w1) = inner.waves(i);
            let electric = inv_m * w1 - (order1 + RAMP[i]) * k_over_x * w0;
            let pb = w0 * o.psi1[i] - m * w1 * o.psi0[i];
            let pa = w0 * o.psi1[i] - electric * o.psi0[i];
            (pa_re[i], pa_im[i], pb_re[i], pb_im[i]) = (pa.re, pa.im, pb.re, pb.im);
        }
    }
    for i in 0..BLOCK {
        let (w0, w1) = inner.waves(i);
        let order1 = order1 + RAMP[i];
        let electric = inv_m * w1 - order1 * k_over_x * w0;
        let qa = w0 * o.chi1[i] - electric * o.chi0[i];
        let qb = w0 * o.chi1[i] - m * w1 * o.chi0[i];
        let flux = w1 * w0.conj();
        let absorbed_a =
            (m.re * flux.im - m.im * flux.re) * inv_m2 - order1 * k_over_x.im * (w0.re * w0.re + w0.im * w0.im);
        let absorbed_b = m.re * flux.im + m.im * flux.re;
        let a = Partial::new(Complex64::new(pa_re[i], pa_im[i]), qa, absorbed_a);
        let b = Partial::new(Complex64::new(pb_re[i], pb_im[i]), qb, absorbed_b);
        (block.a_re[i], block.a_im[i]) = (a.sca + a.abs, a.im);
        (block.b_re[i], block.b_im[i]) = (b.sca + b.abs, b.im);
        block.sca[i] = a.sca + b.sca;
        block.abs[i] = a.abs + b.abs;
    }
}

impl ComplexInner<'_> {
    /// w_n and w_{n+1} of one order.
    #[inline(always)]
    fn waves(&self, i: usize) -> (Complex64, Complex64) {
        (Complex64::new(self.w0_re[i], self.w0_im[i]), Complex64::new(self.w1_re[i], self.w1_im[i]))
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
        let inv = 1.0 / (d.re * d.re + d.im * d.im);
        Self { sca: (p.re * p.re + p.im * p.im) * inv, abs: absorbed * inv, im: (p.im * d.re - p.re * d.im) * inv }
    }
}
