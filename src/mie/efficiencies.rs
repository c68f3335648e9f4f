//! Efficiencies and asymmetry as sums over the partial waves.

use super::{
    Efficiencies,
    coefficients::{BLOCK, Block, RAMP},
};

/// Sums of squares below this have lost digits to underflow (|m - 1| < 1e-140): such a sphere scatters nothing.
const NOTHING: f64 = 1e-280;

/// Running sums over n, theory (12)-(15), one accumulator per place in a block.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    /// (2n+1) (|a_n|^2 + |b_n|^2).
    sca: [f64; BLOCK],
    /// (2n+1) (Re(a_n + b_n) - |a_n|^2 - |b_n|^2).
    abs: [f64; BLOCK],
    /// The terms whose sum times 4 / (x^2 q_sca) is g.
    asymmetry: [f64; BLOCK],
    /// (2n+1) (a_n - b_n); blocks start at odd orders, so that places have a parity.
    back_re: [f64; BLOCK],
    back_im: [f64; BLOCK],
}

impl Sums {
    #[inline(always)]
    pub fn new() -> Self {
        let zero = [0.0; BLOCK];
        Self { sca: zero, abs: zero, asymmetry: zero, back_re: zero, back_im: zero }
    }

    /// Adds the orders of one block.
    #[inline(always)]
    pub fn add(&mut self, c: &Block) {
        let first = c.first as f64;
        for (i, step) in RAMP.into_iter().enumerate() {
            let n = first + step;
            let weight = 2.0 * n + 1.0;
            let ladder = 1.0 / (n * (n + 1.0));
            let next_a = c.a_re[i] * c.a_re[i + 1] + c.a_im[i] * c.a_im[i + 1];
            let next_b = c.b_re[i] * c.b_re[i + 1] + c.b_im[i] * c.b_im[i + 1];
            let same = c.a_re[i] * c.b_re[i] + c.a_im[i] * c.b_im[i];
            self.sca[i] += weight * c.sca[i];
            self.abs[i] += weight * c.abs[i];
            self.asymmetry[i] += ladder * (n * n * (n + 2.0) * (next_a + next_b) + weight * same);
            self.back_re[i] += weight * (c.a_re[i] - c.b_re[i]);
            self.back_im[i] += weight * (c.a_im[i] - c.b_im[i]);
        }
    }

    /// The efficiencies of a sphere of size parameter `x`.
    #[inline(always)]
    pub fn finish(&self, x: f64, n_terms: usize) -> Efficiencies {
        let (sca, abs) = (total(&self.sca), total(&self.abs));
        let (back_re, back_im) = (alternating(&self.back_re), alternating(&self.back_im));
        let inv_area = 1.0 / (x * x);
        let q_sca = 2.0 * inv_area * sca;
        let q_abs = 2.0 * inv_area * abs;
        let q_ext = q_sca + q_abs;
        let g = if sca > NOTHING { 2.0 * total(&self.asymmetry) / sca } else { 0.0 };
        let q_back = (back_re * back_re + back_im * back_im) * inv_area;
        Efficiencies { q_ext, q_sca, q_abs, q_back, q_pr: q_ext - g * q_sca, g, n_terms }
    }
}

/// Sum of the accumulators, by halves.
#[inline(always)]
fn total(row: &[f64; BLOCK]) -> f64 {
    let mut row = *row;
    let mut half = BLOCK / 2;
    while half > 0 {
        for i in 0..half {
            row[i] += row[i + half];
        }
        half /= 2;
    }
    row[0]
}

/// Odd places minus even ones.
#[inline(always)]
fn alternating(row: &[f64; BLOCK]) -> f64 {
    let mut row = *row;
    for value in row.iter_mut().step_by(2) {
        *value = -*value;
    }
    total(&row)
}
