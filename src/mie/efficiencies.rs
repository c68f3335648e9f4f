//! Efficiencies and asymmetry as sums over the partial waves.

use super::{
    Efficiencies,
    coefficients::{BLOCK, Block},
};

/// Accumulators per sum: eight keep vector units busy and rounding errors small.
const LANES: usize = 8;

/// Running sums over n, theory (12)-(15).
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    /// sum (2n+1) (|a_n|^2 + |b_n|^2).
    sca: [f64; LANES],
    /// sum (2n+1) (Re(a_n + b_n) - |a_n|^2 - |b_n|^2).
    abs: [f64; LANES],
    /// The sum of which g is 4 / (x^2 q_sca) times.
    asymmetry: [f64; LANES],
    /// sum (2n+1) (-1)^n (a_n - b_n).
    back_re: [f64; LANES],
    back_im: [f64; LANES],
}

impl Sums {
    /// Adds the orders of one block; its entry `len` must hold the order after its last.
    #[inline(always)]
    pub fn add(&mut self, block: &Block) {
        let mut terms = Terms::new();
        terms.fill(block);
        for (sum, term) in [
            (&mut self.sca, &terms.sca),
            (&mut self.abs, &terms.abs),
            (&mut self.asymmetry, &terms.asymmetry),
            (&mut self.back_re, &terms.back_re),
            (&mut self.back_im, &terms.back_im),
        ] {
            for chunk in term.as_chunks::<LANES>().0 {
                for lane in 0..LANES {
                    sum[lane] += chunk[lane];
                }
            }
        }
    }

    /// The efficiencies of a sphere of size parameter `x`.
    pub fn finish(&self, x: f64, n_terms: usize) -> Efficiencies {
        let total = |lanes: &[f64; LANES]| lanes.iter().sum::<f64>();
        let (sca, abs) = (total(&self.sca), total(&self.abs));
        let (back_re, back_im) = (total(&self.back_re), total(&self.back_im));
        let per_area = 2.0 / (x * x);
        let q_sca = per_area * sca;
        let q_abs = per_area * abs;
        let q_ext = q_sca + q_abs;
        let g = 2.0 * total(&self.asymmetry) / sca;
        Efficiencies {
            q_ext,
            q_sca,
            q_abs,
            q_back: (back_re * back_re + back_im * back_im) / (x * x),
            q_pr: q_ext - g * q_sca,
            g,
            n_terms,
        }
    }
}

/// Weighted terms of one block.
struct Terms {
    sca: [f64; BLOCK],
    abs: [f64; BLOCK],
    asymmetry: [f64; BLOCK],
    back_re: [f64; BLOCK],
    back_im: [f64; BLOCK],
}

impl Terms {
    #[inline(always)]
    fn new() -> Self {
        let zero = [0.0; BLOCK];
        Self { sca: zero, abs: zero, asymmetry: zero, back_re: zero, back_im: zero }
    }

    #[inline(always)]
    fn fill(&mut self, c: &Block) {
        for i in 0..c.len {
            let n = (c.first + i) as f64;
            let weight = 2.0 * n + 1.0;
            let ladder = 1.0 / (n * (n + 1.0));
            // Blocks start at odd orders, so that the sign (-1)^n alternates from minus.
            let signed = if i % 2 == 0 { -weight } else { weight };
            let next = c.a_re[i] * c.a_re[i + 1]
                + c.a_im[i] * c.a_im[i + 1]
                + c.b_re[i] * c.b_re[i + 1]
                + c.b_im[i] * c.b_im[i + 1];
            let same = c.a_re[i] * c.b_re[i] + c.a_im[i] * c.b_im[i];
            self.sca[i] = weight * c.sca[i];
            self.abs[i] = weight * c.abs[i];
            self.asymmetry[i] = ladder * (n * n * (n + 2.0) * next + weight * same);
            self.back_re[i] = signed * (c.a_re[i] - c.b_re[i]);
            self.back_im[i] = signed * (c.a_im[i] - c.b_im[i]);
        }
    }
}
