//! One cell of a phase table: a cubic in ln p, its integral and the inverse of that.
//!
//! Legend: s = sin(theta/2); z in [0, 1] from one end of the cell to the other; the probability of ds is 8 pi s p(s) ds.

use std::f64::consts::PI;

/// Points of the cell integrals: with cells whose logarithm varies by at most `MAX_VARIATION` six points are exact to
/// 1e-12 (Gauss-Legendre remainder of exp, Abramowitz & Stegun 1964, 25.4.30).
const POINTS: usize = 6;

/// Cells are split until ln p varies by at most this much along each.
const MAX_VARIATION: f64 = 1.5;

/// Points in (0, 1) and weights of the rule (Abramowitz & Stegun 1964, table 25.4, n = 6).
pub(super) const RULE: [(f64, f64); POINTS] = {
    let x = [0.238_619_186_083_196_9, 0.661_209_386_466_264_5, 0.932_469_514_203_152];
    let w = [0.467_913_934_572_691, 0.360_761_573_048_138_6, 0.171_324_492_379_170_4];
    let mut rule = [(0.0, 0.0); POINTS];
    let mut i = 0;
    while i < 3 {
        rule[2 - i] = (0.5 - 0.5 * x[i], 0.5 * w[i]);
        rule[3 + i] = (0.5 + 0.5 * x[i], 0.5 * w[i]);
        i += 1;
    }
    rule
};

/// One cell; 32 bytes. The f32 cubic holds ln p to 1e-6, far below the tolerance that places the nodes; everything
/// that is integrated and sampled is the rounded cubic, so that both agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    /// s at the left node.
    pub s: f64,
    /// Probability below the left node.
    pub cdf: f64,
    /// ln(p / scale) as a cubic in z.
    pub ln_p: [f32; 4],
}

impl Cell {
    /// p / scale at z.
    #[inline]
    pub fn relative(&self, z: f64) -> f64 {
        let [a, b, c, d] = self.ln_p.map(f64::from);
        (a + z * (b + z * (c + z * d))).exp()
    }

    /// Unscaled probability between the left node and z; the cell ends at s = `end`.
    #[inline]
    pub fn mass_below(&self, end: f64, z: f64) -> f64 {
        let width = end - self.s;
        let mut sum = 0.0;
        for (t, weight) in RULE {
            sum += weight * (self.s + z * t * width) * self.relative(z * t);
        }
        8.0 * PI * width * z * sum
    }

    /// z below which there is the given mass, by Newton's method inside a shrinking bracket.
    #[inline]
    pub fn invert(&self, end: f64, mass: f64) -> f64 {
        let width = end - self.s;
        let density = |z: f64| 8.0 * PI * width * (self.s + z * width) * self.relative(z);
        let (mut lower, mut upper) = (0.0, 1.0);
        let mut z = guess(density(0.0), density(1.0), mass);
        // Newton doubles the digits: three steps are usual, 40 bisections would end at 1e-12 in any case.
        for _ in 0..40 {
            let excess = self.mass_below(end, z) - mass;
            if excess > 0.0 {
                upper = z
            } else {
                lower = z
            }
            let step = z - excess / density(z);
            let next = if step > lower && step < upper { step } else { 0.5 * (lower + upper) };
            let change = (next - z).abs();
            z = next;
            // The next Newton step would be the square of this one, 1e-10 of a cell.
            if change <= 1e-5 && step == next {
                break;
            }
        }
        z
    }

    /// The part of the cell that begins at a place in it; the cell ends at s = `end`.
    pub fn after(&self, s: f64, end: f64) -> Self {
        let [a, b, c, d] = self.ln_p.map(f64::from);
        let z = (s - self.s) / (end - self.s);
        let (value, slope, bend) = (a + z * (b + z * (c + z * d)), b + z * (2.0 * c + z * 3.0 * d), c + 3.0 * z * d);
        let left = 1.0 - z;
        let ln_p = [value, left * slope, left * left * bend, left * left * left * d];
        Self { s, cdf: 0.0, ln_p: ln_p.map(|value| value as f32) }
    }

    /// The largest value of the cubic along the cell.
    pub fn largest_ln(&self) -> f64 {
        let [a, b, c, d] = self.ln_p.map(f64::from);
        let value = |z: f64| a + z * (b + z * (c + z * d));
        let root = (c * c - 3.0 * b * d).max(0.0).sqrt();
        let inner = [(-c + root) / (3.0 * d), (-c - root) / (3.0 * d), -b / (2.0 * c)];
        let inner = inner.into_iter().filter(|z| (0.0..=1.0).contains(z)).map(value);
        inner.fold(value(0.0).max(value(1.0)), f64::max)
    }
}

/// Where a density that rises linearly from `d0` to `d1` along [0, 1] has the given mass below it.
fn guess(d0: f64, d1: f64, mass: f64) -> f64 {
    let discriminant = (d0 * d0 + 2.0 * (d1 - d0) * mass).max(0.0).sqrt();
    let z = 2.0 * mass / (d0 + discriminant);
    if z.is_finite() { z.clamp(0.0, 1.0) } else { 0.5 }
}

/// The cubic in z from values and slopes at both ends of a cell.
pub(super) fn hermite(y0: f64, y1: f64, d0: f64, d1: f64) -> [f64; 4] {
    let rise = y1 - y0;
    [y0, d0, 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise]
}

/// Adds a cell, in halves while its logarithm varies too much for the quadrature.
pub(super) fn push_split(cells: &mut Vec<Cell>, s: f64, width: f64, [a, b, c, d]: [f64; 4]) {
    let variation = b.abs() + c.abs() + d.abs();
    let middle = s + 0.5 * width;
    if variation <= MAX_VARIATION || middle <= s || middle >= s + width {
        cells.push(Cell { s, cdf: 0.0, ln_p: [a, b, c, d].map(|value| value as f32) });
        return;
    }
    push_split(cells, s, 0.5 * width, [a, 0.5 * b, 0.25 * c, 0.125 * d]);
    let at_middle = a + 0.5 * (b + 0.5 * (c + 0.5 * d));
    let slope = b + c + 0.75 * d;
    push_split(cells, middle, 0.5 * width, [at_middle, 0.5 * slope, 0.25 * (c + 1.5 * d), 0.125 * d]);
}
