//! Gauss-Legendre rules.

use std::f64::consts::PI;

/// Nodes in (-1, 1), increasing, and their weights, which add up to 2.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussLegendre {
    /// Nodes and weights.
    pub points: Vec<(f64, f64)>,
}

impl GaussLegendre {
    /// The rule with `n` >= 1 points, exact for polynomials of degree 2n - 1.
    ///
    /// Newton's method on the Legendre polynomial from Tricomi's estimate (Abramowitz & Stegun 1964, 22.16.6 and
    /// 25.4.29).
    pub fn new(n: usize) -> Self {
        let n = n.max(1);
        let point = |i: usize| {
            let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            // Quadratic convergence: five steps from Tricomi's estimate are beyond rounding, the rest is caution.
            for _ in 0..8 {
                let (value, derivative) = legendre(n, x);
                slope = derivative;
                x -= value / derivative;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        };
        Self { points: (0..n).map(point).collect() }
    }

    /// The integral of `f` from `a` to `b`.
    pub fn integrate(&self, a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        half * self.points.iter().map(|(x, weight)| weight * f(middle + half * x)).sum::<f64>()
    }
}

/// P_n(x) and its derivative, by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, n as f64 * (before - x * value) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_to_their_degree() {
        for n in 1..=24 {
            let rule = GaussLegendre::new(n);
            for degree in 0..2 * n as i32 {
                let found = rule.integrate(0.0, 2.0, |x| x.powi(degree));
                let exact = 2f64.powi(degree + 1) / f64::from(degree + 1);
                assert!((found / exact - 1.0).abs() < 1e-13, "{n} {degree}: {found} {exact}");
            }
        }
    }
}
