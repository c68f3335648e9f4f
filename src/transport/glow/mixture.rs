//! Many size bins as few functions: the mean phase function of all droplets, and the directions in which bins differ
//! from it most.
//!
//! Legend: p_bl, phase function of bin b at wavelength l; m_bl, the bin's share of all scattering; P_l = sum_b m_bl p_bl;
//! V_r = sum_b q_rb (p_b - P), the r-th principal deviation; c_br, how much of it bin b has: p_b = P + sum_r c_br V_r, but for a
//! remainder. Theory (63). The remainder of a node is the mean of its droplets' remainders, which cancel where sizes are mixed
//! and do not where a puff has sizes of its own; a sketch tells how much of it is left (111).

use crate::transport::media::Media;
use crate::transport::random::hash_uniform;

/// Deviations that are kept at most.
pub(super) const MOST_DEVIATIONS: usize = 12;

/// Beyond so many one more must take away at least this part of what remains: the fringes of single sizes are all different.
const FEW_DEVIATIONS: usize = 6;
const WORTH_IT: f64 = 0.15;

/// Remaining RMS deviation of a droplet's phase function at which no more are kept, of the error that is asked for: half of what
/// nodes may have wrong in common.
const PART_OF_TOLERANCE: f64 = 0.2;

/// Angles at which bins are compared, for one wavelength; fewer for many, between which fringes move.
const ANGLES: usize = 768;
const LEAST_ANGLES: usize = 96;

/// Numbers of a sketch: they give a remainder's RMS to within 18 %.
pub(super) const SKETCH: usize = 16;

/// Rounds of power iteration: what is not told apart by then is equally large.
const ROUNDS: usize = 24;

/// Phase functions of all bins, in few.
pub(super) struct Mixture {
    n_wavelengths: usize,
    /// m, one row per bin.
    shares: Vec<f64>,
    /// q, one row per deviation.
    combinations: Vec<Vec<f64>>,
    /// c, one row per bin.
    coefficients: Vec<f32>,
    /// Sketch of what remains of every bin; empty where that is little.
    sketches: Vec<f32>,
    /// Remaining variance of a droplet's phase function, relative to its square.
    pub remainder: f64,
    /// How much of it does not matter.
    pub negligible: f64,
    n_angles: usize,
}

impl Mixture {
    /// Mean square relative deviation of a phase function per square of a coefficient.
    pub fn per_column(&self) -> f64 {
        1.0 / (self.n_angles * self.n_wavelengths) as f64
    }

    /// Compares bins; `scattering` holds what each scatters in all, one row of wavelengths per bin.
    pub fn new(media: &Media, scattering: &[f64], tolerance: f64) -> Self {
        let (n_bins, n) = (media.n_bins(), media.n_wavelengths());
        let mut shares = scattering.to_vec();
        for w in 0..n {
            let total: f64 = scattering.iter().skip(w).step_by(n).sum();
            let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
            shares.iter_mut().skip(w).step_by(n).for_each(|share| *share *= scale);
        }
        let mut mixture = Self {
            n_wavelengths: n,
            shares,
            combinations: Vec::new(),
            coefficients: Vec::new(),
            sketches: Vec::new(),
            remainder: 0.0,
            negligible: (PART_OF_TOLERANCE * tolerance).powi(2),
            n_angles: (ANGLES / n).max(LEAST_ANGLES),
        };
        let weights: Vec<f64> = (0..n_bins).map(|bin| mean(&mixture.shares[bin * n..(bin + 1) * n])).collect();
        let mut deviations = mixture.relative_deviations(media);
        mixture.find_deviations(&mut deviations, &weights);
        if mixture.remainder > mixture.negligible {
            mixture.sketches = deviations.iter().flat_map(|row| sketch(row)).collect();
        }
        mixture
    }

    /// Sketch of what the deviations leave of a bin's phase function, over the mean's; empty where that is little.
    #[inline]
    pub fn sketch(&self, bin: usize) -> &[f32] {
        if self.sketches.is_empty() { &[] } else { &self.sketches[bin * SKETCH..(bin + 1) * SKETCH] }
    }

    /// Number of functions: the mean and its deviations.
    pub fn rank(&self) -> usize {
        1 + self.combinations.len()
    }

    /// How much of each deviation a bin has.
    #[inline]
    pub fn coefficients(&self, bin: usize) -> &[f32] {
        let n = self.combinations.len();
        &self.coefficients[bin * n..(bin + 1) * n]
    }

    /// Fills in the mean and the deviations at h, wavelengths running fastest.
    pub fn eval(&self, media: &Media, h: f64, out: &mut [f64]) {
        let n = self.n_wavelengths;
        out.fill(0.0);
        let (mean, deviations) = out.split_at_mut(n);
        for (bin, shares) in self.shares.chunks_exact(n).enumerate() {
            if self.combinations.is_empty() && shares.iter().all(|share| *share == 0.0) {
                continue;
            }
            for (w, (mean, phase)) in mean.iter_mut().zip(media.phase(bin)).enumerate() {
                let p = phase.eval(h);
                *mean += shares[w] * p;
                for (deviation, combination) in deviations.chunks_exact_mut(n).zip(&self.combinations) {
                    deviation[w] += combination[bin] * p;
                }
            }
        }
        for (deviation, combination) in deviations.chunks_exact_mut(n).zip(&self.combinations) {
            let sum: f64 = combination.iter().sum();
            deviation.iter_mut().zip(&*mean).for_each(|(deviation, mean)| *deviation -= sum * mean);
        }
    }

    /// One row per bin: p / P - 1 over angles and wavelengths.
    fn relative_deviations(&self, media: &Media) -> Vec<Vec<f64>> {
        let n_angles = self.n_angles;
        let angles = || (0..n_angles).map(|i| angle_h(i as f64 / (n_angles - 1) as f64));
        let row = |bin: usize| -> Vec<f64> {
            angles().flat_map(|h| media.phase(bin).iter().map(move |phase| phase.eval(h))).collect()
        };
        let n = self.n_wavelengths;
        let mut rows: Vec<Vec<f64>> = (0..media.n_bins()).map(row).collect();
        let mut mean = vec![0.0; n_angles * n];
        for (row, shares) in rows.iter().zip(self.shares.chunks_exact(n)) {
            mean.iter_mut().zip(row).enumerate().for_each(|(i, (mean, p))| *mean += shares[i % n] * p);
        }
        for row in &mut rows {
            row.iter_mut().zip(&mean).for_each(|(p, mean)| *p = if *mean > 0.0 { *p / mean - 1.0 } else { 0.0 });
        }
        rows
    }

    /// Takes out one principal deviation after the other (power iteration with deflation).
    fn find_deviations(&mut self, rows: &mut [Vec<f64>], weights: &[f64]) {
        let n_columns = (self.n_angles * self.n_wavelengths) as f64;
        let variance = |rows: &[Vec<f64>]| -> f64 {
            rows.iter().zip(weights).map(|(row, f)| f * row.iter().map(|d| d * d).sum::<f64>()).sum::<f64>() / n_columns
        };
        let mut columns: Vec<Vec<f64>> = Vec::new();
        self.remainder = variance(rows);
        // What was taken out of each row, as a combination of the rows at the start.
        while self.remainder > self.negligible && self.combinations.len() < MOST_DEVIATIONS {
            let Some((direction, combination)) = principal(rows, weights) else { break };
            let coefficients: Vec<f64> = rows.iter().map(|row| dot(row, &direction)).collect();
            let taken = coefficients.iter().zip(weights).map(|(c, f)| f * c * c).sum::<f64>() / n_columns;
            if self.combinations.len() >= FEW_DEVIATIONS && taken < WORTH_IT * self.remainder {
                break;
            }
            for (row, c) in rows.iter_mut().zip(&coefficients) {
                row.iter_mut().zip(&direction).for_each(|(d, v)| *d -= c * v);
            }
            // The direction is a combination of deflated rows; undo the deflation: q' = q - sum over earlier r of (q . c_r) q_r.
            let mut own = combination.clone();
            for (earlier, column) in self.combinations.iter().zip(&columns) {
                let part = dot(&combination, column);
                own.iter_mut().zip(earlier).for_each(|(own, earlier)| *own -= part * earlier);
            }
            self.combinations.push(own);
            columns.push(coefficients);
            self.remainder = variance(rows);
        }
        self.coefficients =
            (0..rows.len()).flat_map(|bin| columns.iter().map(move |column| column[bin] as f32)).collect();
    }
}

/// Few numbers whose squares add up to the mean square of many, on average over signs that are drawn once; sketches of sums
/// are sums of sketches (Johnson & Lindenstrauss 1984; with signs, Achlioptas 2003).
fn sketch(row: &[f64]) -> [f32; SKETCH] {
    let scale = 1.0 / ((row.len() * SKETCH) as f64).sqrt();
    std::array::from_fn(|j| {
        let signed = |(i, d): (usize, &f64)| if hash_uniform(j as u64, i as u64) < 0.5 { *d } else { -d };
        (row.iter().enumerate().map(signed).sum::<f64>() * scale) as f32
    })
}

/// Even in theta, and towards the forward peak.
fn angle_h(part: f64) -> f64 {
    let theta = std::f64::consts::PI * part * part;
    2.0 * (0.5 * theta).sin().powi(2)
}

/// The direction of unit length along which weighted rows vary most, and which combination of rows it is.
fn principal(rows: &[Vec<f64>], weights: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let largest = rows.iter().zip(weights).max_by(|a, b| (a.1 * dot(a.0, a.0)).total_cmp(&(b.1 * dot(b.0, b.0))))?;
    let mut direction = largest.0.clone();
    let mut combination = vec![0.0; rows.len()];
    for _ in 0..ROUNDS {
        combination = rows.iter().zip(weights).map(|(row, weight)| weight * dot(row, &direction)).collect();
        direction.fill(0.0);
        for (row, part) in rows.iter().zip(&combination) {
            direction.iter_mut().zip(row).for_each(|(sum, d)| *sum += part * d);
        }
        let length = dot(&direction, &direction).sqrt();
        if length == 0.0 || !length.is_finite() {
            return None;
        }
        direction.iter_mut().chain(&mut combination).for_each(|value| *value /= length);
    }
    Some((direction, combination))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rationale: sketches stand for functions where remainders add up. Expected: sums of sketches are sketches of sums, and
    /// their squares are the mean square, within four standard errors of 35 % each over 64 functions.
    #[test]
    fn a_sketch_keeps_sums_and_squares() {
        let row = |k: usize| -> Vec<f64> { (0..500).map(|i| 2.0 * hash_uniform(k as u64 + 99, i) - 1.0).collect() };
        let (mut ratios, n) = (0.0, 64);
        for k in 0..n {
            let (a, b) = (row(k), row(k + n));
            let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
            for ((a, b), sum) in sketch(&a).iter().zip(sketch(&b)).zip(sketch(&sum)) {
                assert!((a + b - sum).abs() < 1e-6);
            }
            let square: f64 = sketch(&a).iter().map(|q| f64::from(*q).powi(2)).sum();
            ratios += square / (dot(&a, &a) / a.len() as f64) / n as f64;
        }
        assert!((ratios - 1.0).abs() < 4.0 * 0.35 / (n as f64).sqrt(), "{ratios}");
    }
}
