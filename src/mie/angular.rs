//! The angular sums of one sphere: S1, S2 at many angles from one recurrence per mirrored pair.
//!
//! Legend, theory (16)-(19): `h` = 1 - mu, `pi`, `tau` the angular functions of order n, `d` = pi_n - pi_{n-1},
//! `t` = d - h pi, `g` = -h pi. Orders are taken in pairs, odd then even, because their parities differ.
//!
//! Products are added without rounding in between on every processor, if need be in software: the same bits everywhere.

use pulp::Simd;

/// What one order contributes: (2n+1)/(n(n+1)) times a and b, then 1 + 1/n and n.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Order {
    pub a_re: f64,
    pub a_im: f64,
    pub b_re: f64,
    pub b_im: f64,
    pub step: f64,
    pub n: f64,
}

/// An odd order and the even one after it.
pub(super) type OrderPair = [Order; 2];

/// S1 and S2 of a vector of folded angles, split into the parts that keep and that change sign at pi - theta.
#[derive(Clone, Copy)]
pub(super) struct Split<V> {
    pub s1_even_re: V,
    pub s1_even_im: V,
    pub s1_odd_re: V,
    pub s1_odd_im: V,
    pub s2_even_re: V,
    pub s2_even_im: V,
    pub s2_odd_re: V,
    pub s2_odd_im: V,
}

/// State of the recurrence for one vector of angles.
#[derive(Clone, Copy)]
pub(super) struct Angular<V> {
    mu: V,
    minus_h: V,
    pi_before: V,
    pi: V,
    t: V,
    g: V,
}

impl<V: Copy> Angular<V> {
    #[inline(always)]
    fn new<S: Simd<f64s = V>>(simd: S, h: V) -> Self {
        let one = simd.splat_f64s(1.0);
        let mu = simd.sub_f64s(one, h);
        let minus_h = simd.neg_f64s(h);
        Self { mu, minus_h, pi_before: simd.splat_f64s(0.0), pi: one, t: mu, g: minus_h }
    }

    /// tau of the current order.
    #[inline(always)]
    fn tau<S: Simd<f64s = V>>(&self, simd: S, n: V) -> V {
        simd.mul_add_f64s(n, self.t, simd.neg_f64s(self.pi_before))
    }

    /// On to the next order.
    #[inline(always)]
    fn advance<S: Simd<f64s = V>>(&mut self, simd: S, step: V) {
        let d = simd.mul_add_f64s(step, self.t, self.g);
        self.pi_before = self.pi;
        self.pi = simd.add_f64s(self.pi, d);
        self.t = simd.mul_add_f64s(self.mu, d, self.g);
        self.g = simd.mul_add_f64s(self.minus_h, d, self.g);
    }
}

/// Sums a series at `W` vectors of folded angles `h`.
#[inline(always)]
pub(super) fn sum_orders<S: Simd, const W: usize>(
    simd: S,
    orders: &[OrderPair],
    h: [S::f64s; W],
) -> [Split<S::f64s>; W] {
    let mut angular = start(simd, h);
    let mut sums = [Split::zero(simd); W];
    for [odd, even] in orders {
        let (c, step, n) = (Coefficients::splat(simd, odd), simd.splat_f64s(odd.step), simd.splat_f64s(odd.n));
        for i in 0..W {
            let (pi, tau) = (angular[i].pi, angular[i].tau(simd, n));
            sums[i].add_odd(simd, &c, pi, tau);
            angular[i].advance(simd, step);
        }
        let (c, step, n) = (Coefficients::splat(simd, even), simd.splat_f64s(even.step), simd.splat_f64s(even.n));
        for i in 0..W {
            let (pi, tau) = (angular[i].pi, angular[i].tau(simd, n));
            sums[i].add_even(simd, &c, pi, tau);
            angular[i].advance(simd, step);
        }
    }
    sums
}

/// The recurrence at order 1 for `W` vectors of folded angles.
#[inline(always)]
pub(super) fn start<S: Simd, const W: usize>(simd: S, h: [S::f64s; W]) -> [Angular<S::f64s>; W] {
    let mut angular = [Angular::new(simd, h[0]); W];
    for i in 1..W {
        angular[i] = Angular::new(simd, h[i]);
    }
    angular
}

/// The weighted coefficients of one order in every lane.
struct Coefficients<V> {
    a_re: V,
    a_im: V,
    b_re: V,
    b_im: V,
}

impl<V: Copy> Coefficients<V> {
    #[inline(always)]
    fn splat<S: Simd<f64s = V>>(simd: S, order: &Order) -> Self {
        Self {
            a_re: simd.splat_f64s(order.a_re),
            a_im: simd.splat_f64s(order.a_im),
            b_re: simd.splat_f64s(order.b_re),
            b_im: simd.splat_f64s(order.b_im),
        }
    }
}

/// pi and tau of one order at one vector of angles.
#[derive(Clone, Copy)]
pub(super) struct PiTau<V> {
    pub pi: V,
    pub tau: V,
}

/// Tabulates pi and tau: order by order, `stride` vectors each, of which `angular` are those from `from` on.
#[inline(always)]
pub(super) fn tabulate<S: Simd, const W: usize>(
    simd: S,
    orders: &[OrderPair],
    angular: &mut [Angular<S::f64s>; W],
    rows: &mut [PiTau<S::f64s>],
    [stride, from]: [usize; 2],
) {
    let mut local = *angular;
    for (order, row) in orders.as_flattened().iter().zip(rows.chunks_exact_mut(stride)) {
        let (step, n) = (simd.splat_f64s(order.step), simd.splat_f64s(order.n));
        for i in 0..W {
            row[from + i] = PiTau { pi: local[i].pi, tau: local[i].tau(simd, n) };
            local[i].advance(simd, step);
        }
    }
    *angular = local;
}

/// Adds orders to the sums of `W` vectors of angles, with pi and tau from a table as [`tabulate`] makes it.
#[inline(always)]
pub(super) fn sum_tabulated<S: Simd, const W: usize>(
    simd: S,
    orders: &[OrderPair],
    rows: &[PiTau<S::f64s>],
    sums: &mut [Split<S::f64s>; W],
    [stride, from]: [usize; 2],
) {
    let mut local = *sums;
    for ([odd, even], row) in orders.iter().zip(rows.chunks_exact(2 * stride)) {
        let c = Coefficients::splat(simd, odd);
        for i in 0..W {
            let PiTau { pi, tau } = row[from + i];
            local[i].add_odd(simd, &c, pi, tau);
        }
        let c = Coefficients::splat(simd, even);
        for i in 0..W {
            let PiTau { pi, tau } = row[stride + from + i];
            local[i].add_even(simd, &c, pi, tau);
        }
    }
    *sums = local;
}

impl<V: Copy> Split<V> {
    /// Sums of no orders.
    #[inline(always)]
    pub fn zero<S: Simd<f64s = V>>(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        Self {
            s1_even_re: zero,
            s1_even_im: zero,
            s1_odd_re: zero,
            s1_odd_im: zero,
            s2_even_re: zero,
            s2_even_im: zero,
            s2_odd_re: zero,
            s2_odd_im: zero,
        }
    }

    /// Adds an odd order: pi keeps its sign at pi - theta, tau changes it, theory (18).
    #[inline(always)]
    fn add_odd<S: Simd<f64s = V>>(&mut self, simd: S, c: &Coefficients<V>, pi: V, tau: V) {
        self.s1_even_re = simd.mul_add_f64s(c.a_re, pi, self.s1_even_re);
        self.s1_even_im = simd.mul_add_f64s(c.a_im, pi, self.s1_even_im);
        self.s1_odd_re = simd.mul_add_f64s(c.b_re, tau, self.s1_odd_re);
        self.s1_odd_im = simd.mul_add_f64s(c.b_im, tau, self.s1_odd_im);
        self.s2_even_re = simd.mul_add_f64s(c.b_re, pi, self.s2_even_re);
        self.s2_even_im = simd.mul_add_f64s(c.b_im, pi, self.s2_even_im);
        self.s2_odd_re = simd.mul_add_f64s(c.a_re, tau, self.s2_odd_re);
        self.s2_odd_im = simd.mul_add_f64s(c.a_im, tau, self.s2_odd_im);
    }

    /// Adds an even order: pi changes its sign, tau keeps it.
    #[inline(always)]
    fn add_even<S: Simd<f64s = V>>(&mut self, simd: S, c: &Coefficients<V>, pi: V, tau: V) {
        self.s1_odd_re = simd.mul_add_f64s(c.a_re, pi, self.s1_odd_re);
        self.s1_odd_im = simd.mul_add_f64s(c.a_im, pi, self.s1_odd_im);
        self.s1_even_re = simd.mul_add_f64s(c.b_re, tau, self.s1_even_re);
        self.s1_even_im = simd.mul_add_f64s(c.b_im, tau, self.s1_even_im);
        self.s2_odd_re = simd.mul_add_f64s(c.b_re, pi, self.s2_odd_re);
        self.s2_odd_im = simd.mul_add_f64s(c.b_im, pi, self.s2_odd_im);
        self.s2_even_re = simd.mul_add_f64s(c.a_re, tau, self.s2_even_re);
        self.s2_even_im = simd.mul_add_f64s(c.a_im, tau, self.s2_even_im);
    }

    /// [S1 re, S1 im, S2 re, S2 im] at the folded angle.
    #[inline(always)]
    pub fn forward<S: Simd<f64s = V>>(&self, simd: S) -> [V; 4] {
        [
            simd.add_f64s(self.s1_even_re, self.s1_odd_re),
            simd.add_f64s(self.s1_even_im, self.s1_odd_im),
            simd.add_f64s(self.s2_even_re, self.s2_odd_re),
            simd.add_f64s(self.s2_even_im, self.s2_odd_im),
        ]
    }

    /// The same at pi minus the folded angle.
    #[inline(always)]
    pub fn backward<S: Simd<f64s = V>>(&self, simd: S) -> [V; 4] {
        [
            simd.sub_f64s(self.s1_even_re, self.s1_odd_re),
            simd.sub_f64s(self.s1_even_im, self.s1_odd_im),
            simd.sub_f64s(self.s2_even_re, self.s2_odd_re),
            simd.sub_f64s(self.s2_even_im, self.s2_odd_im),
        ]
    }
}
