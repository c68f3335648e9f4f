//! The waves outside the sphere: Riccati-Bessel functions psi_n(x) and chi_n(x) of a real argument.
//!
//! Legend: `x` size parameter (1); `psi[n]` = x j_n(x); `chi[n]` = -x y_n(x).

/// The recurrence z_{n+1} = (2n+1)/x z_n - z_{n-1}, theory (3), upward.
struct Upward {
    inv_x: f64,
    /// 2n + 1, n the current order.
    odd: f64,
    before: f64,
    current: f64,
}

impl Upward {
    #[inline(always)]
    fn step(&mut self) -> f64 {
        let next = self.odd * self.inv_x * self.current - self.before;
        (self.before, self.current) = (self.current, next);
        self.odd += 2.0;
        next
    }
}

/// The same downward, for psi beyond the turning point n = x.
struct Downward {
    inv_x: f64,
    /// 2n + 1, n the current order.
    odd: f64,
    above: f64,
    current: f64,
}

impl Downward {
    #[inline(always)]
    fn step(&mut self) -> f64 {
        let value = self.current;
        let next = self.odd * self.inv_x * self.current - self.above;
        (self.above, self.current) = (self.current, next);
        self.odd -= 2.0;
        value
    }
}

/// Fills `psi` and `chi`, orders 0 ..= n_last with n_last > x, and calls `interior` n_last - 1 times.
///
/// chi_n grows with n and is recurred upward throughout. psi_n is recurred upward only while it does not decay
/// (n <= x), and downward from the last order beyond it. Each of these recurrences is a chain of dependent
/// operations; run side by side, with that of the interior, they take the time of one.
#[inline(always)]
pub(super) fn fill_exterior(x: f64, psi: &mut [f64], chi: &mut [f64], mut interior: impl FnMut()) {
    let inv_x = 1.0 / x;
    let n_last = psi.len() - 1;
    let n_match = x as usize;
    let (sin, cos) = x.sin_cos();
    (psi[0], chi[0]) = (sin, cos);
    (psi[1], chi[1]) = (sin * inv_x - cos, cos * inv_x + sin);
    let mut psi_up = Upward { inv_x, odd: 3.0, before: psi[0], current: psi[1] };
    let mut chi_up = Upward { inv_x, odd: 3.0, before: chi[0], current: chi[1] };
    let split = n_match.max(1) + 1;
    let (psi_low, psi_high) = psi.split_at_mut(split);
    let (chi_low, chi_high) = chi.split_at_mut(split);
    for (psi, chi) in psi_low[2..].iter_mut().zip(&mut chi_low[2..]) {
        *psi = psi_up.step();
        *chi = chi_up.step();
        interior();
    }
    // The start, whose ratio of neighbours is a guess, is forgotten as fast as the series converges. 1e-290
    // leaves room for the growth down to n_match: 2e122 at most, from order 17 at x = 1e-6.
    let odd = (2 * n_last + 1) as f64;
    let mut psi_down = Downward { inv_x, odd, above: 1e-290 * x / (odd + 2.0), current: 1e-290 };
    for (psi, chi) in psi_high.iter_mut().rev().zip(chi_high) {
        *psi = psi_down.step();
        *chi = chi_up.step();
        interior();
    }
    if n_match == 0 {
        psi_low[1] = psi_down.step();
    }
    let scale = psi_low[n_match] / psi_down.current;
    for psi in &mut psi[n_match + 1..] {
        *psi *= scale;
    }
}
