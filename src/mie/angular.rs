//! The angular sums of one sphere: S1, S2 at many angles from one recurrence per mirrored pair.
//!
//! Legend, theory (16)-(19): `h` = 1 - mu, `pi`, `tau` the angular functions of order n, `d` = pi_n - pi_{n-1},
//! `t` = d - h pi, `g` = -h pi. Orders are taken in pairs, odd then even, because their parities differ.

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
struct Angular<V> {
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
        simd.mul_add_e_f64s(n, self.t, simd.neg_f64s(self.pi_before))
    }

    /// On to the next order.
    #[inline(always)]
    fn advance<S: Simd<f64s = V>>(&mut self, simd: S, step: V) {
        let d = simd.mul_add_e_f64s(step, self.t, self.g);
        self.pi_before = self.pi;
        self.pi = simd.add_f64s(self.pi, d);
        self.t = simd.mul_add_e_f64s(self.mu, d, self.g);
        self.g = simd.mul_add_e_f64s(self.minus_h, d, self.g);
    }
}

/// Sums a series at `W` vectors of folded angles `h`.
#[inline(always)]
pub(super) fn sum_orders<S: Simd, const W: usize>(
    simd: S,
    orders: &[OrderPair],
    h: [S::f64s; W],
) -> [Split<S::f64s>; W] {
    let zero = simd.splat_f64s(0.0);
    let mut angular = [Angular::new(simd, h[0]); W];
    for i in 1..W {
        angular[i] = Angular::new(simd, h[i]);
    }
    let mut sums = [Split {
        s1_even_re: zero,
        s1_even_im: zero,
        s1_odd_re: zero,
        s1_odd_im: zero,
        s2_even_re: zero,
        s2_even_im: zero,
        s2_odd_re: zero,
        s2_odd_im: zero,
    }; W];
    for [odd, even] in orders {
        let [a_re, a_im, b_re, b_im, step, n] = splat(simd, odd);
        for i in 0..W {
            let (angular, s) = (&mut angular[i], &mut sums[i]);
            let (pi, tau) = (angular.pi, angular.tau(simd, n));
            s.s1_even_re = simd.mul_add_e_f64s(a_re, pi, s.s1_even_re);
            s.s1_even_im = simd.mul_add_e_f64s(a_im, pi, s.s1_even_im);
            s.s1_odd_re = simd.mul_add_e_f64s(b_re, tau, s.s1_odd_re);
            s.s1_odd_im = simd.mul_add_e_f64s(b_im, tau, s.s1_odd_im);
            s.s2_even_re = simd.mul_add_e_f64s(b_re, pi, s.s2_even_re);
            s.s2_even_im = simd.mul_add_e_f64s(b_im, pi, s.s2_even_im);
            s.s2_odd_re = simd.mul_add_e_f64s(a_re, tau, s.s2_odd_re);
            s.s2_odd_im = simd.mul_add_e_f64s(a_im, tau, s.s2_odd_im);
            angular.advance(simd, step);
        }
        let [a_re, a_im, b_re, b_im, step, n] = splat(simd, even);
        for i in 0..W {
            let (angular, s) = (&mut angular[i], &mut sums[i]);
            let (pi, tau) = (angular.pi, angular.tau(simd, n));
            s.s1_odd_re = simd.mul_add_e_f64s(a_re, pi, s.s1_odd_re);
            s.s1_odd_im = simd.mul_add_e_f64s(a_im, pi, s.s1_odd_im);
            s.s1_even_re = simd.mul_add_e_f64s(b_re, tau, s.s1_even_re);
            s.s1_even_im = simd.mul_add_e_f64s(b_im, tau, s.s1_even_im);
            s.s2_odd_re = simd.mul_add_e_f64s(b_re, pi, s.s2_odd_re);
            s.s2_odd_im = simd.mul_add_e_f64s(b_im, pi, s.s2_odd_im);
            s.s2_even_re = simd.mul_add_e_f64s(a_re, tau, s.s2_even_re);
            s.s2_even_im = simd.mul_add_e_f64s(a_im, tau, s.s2_even_im);
            angular.advance(simd, step);
        }
    }
    sums
}

#[inline(always)]
fn splat<S: Simd>(simd: S, o: &Order) -> [S::f64s; 6] {
    [
        simd.splat_f64s(o.a_re),
        simd.splat_f64s(o.a_im),
        simd.splat_f64s(o.b_re),
        simd.splat_f64s(o.b_im),
        simd.splat_f64s(o.step),
        simd.splat_f64s(o.n),
    ]
}

impl<V: Copy> Split<V> {
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
