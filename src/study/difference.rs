//! How much two noisy pictures differ, without their noise: each is rendered twice, with independent seeds.
//!
//! Legend: a1, a2 and b1, b2 are the two renders of each picture; D1 = a1 - b1 and D2 = a2 - b2 are estimates of the true
//! difference d whose noises are independent of each other, so that the mean of D1 D2 over pixels is d^2 without bias.
//! m = (D1 + D2)/2 and e = D1 - D2; v is the variance of either D. m and e are independent for normal noise, and
//! m^2 e^2 has the mean (d^2 + v/2) 2v = 2 d^2 v + v^2: the variance of D1 D2.

use serde::Serialize;

use crate::film::Channel;
use crate::spectrum::color::BT709_LUMINANCE;

/// R, G, B of every pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixels(pub Vec<[f64; 3]>);

impl Pixels {
    /// The first three channels: R, G, B.
    pub fn from_channels(channels: &[Channel]) -> Self {
        let [r, g, b, ..] = channels else { return Self::default() };
        let rows = r.values.iter().zip(&g.values).zip(&b.values);
        Self(rows.map(|((r, g), b)| [r, g, b].map(|value| f64::from(*value))).collect())
    }

    /// Mean luminance; 0 where there are no pixels.
    pub fn mean_luminance(&self) -> f64 {
        self.0.iter().map(luminance).sum::<f64>() / self.0.len().max(1) as f64
    }
}

fn luminance(rgb: &[f64; 3]) -> f64 {
    rgb.iter().zip(BT709_LUMINANCE).map(|(value, weight)| value * weight).sum()
}

/// A difference, relative to the second picture's mean luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Mean square over pixels and R, G, B without noise, which may come out a little below zero.
    pub square: f64,
    /// Its standard error.
    pub square_error: f64,
    /// Mean luminance over the second's, less 1.
    pub bias: f64,
    /// Its standard error.
    pub bias_error: f64,
}

impl Difference {
    /// Compares the two renders of a picture with the two of another; `known_variance` is the part of the square that noise
    /// which both renders of a picture share is known to make, 0 where all are independent. `None` where b is black or
    /// sizes differ.
    pub fn of(a: [&Pixels; 2], b: [&Pixels; 2], known_variance: f64) -> Option<Self> {
        let n = b[0].0.len();
        let mean = 0.5 * (b[0].mean_luminance() + b[1].mean_luminance());
        if n == 0 || mean <= 0.0 || [a[0], a[1], b[1]].iter().any(|pixels| pixels.0.len() != n) {
            return None;
        }
        let (mut square, mut variance, mut bias, mut bias_variance) = (0.0, 0.0, 0.0, 0.0);
        for pixel in 0..n {
            let d: [[f64; 3]; 2] = [0, 1].map(|k| std::array::from_fn(|c| a[k].0[pixel][c] - b[k].0[pixel][c]));
            square += (0..3).map(|c| d[0][c] * d[1][c]).sum::<f64>() / 3.0;
            // Channels share their paths: their noise is taken as fully correlated, the largest that it can be.
            let spread = (0..3).map(|c| (0.5 * (d[0][c] + d[1][c]) * (d[0][c] - d[1][c])).abs()).sum::<f64>() / 3.0;
            variance += spread * spread;
            let [y1, y2] = d.map(|rgb| luminance(&rgb));
            bias += 0.5 * (y1 + y2);
            bias_variance += 0.25 * (y1 - y2).powi(2);
        }
        let (n, mean_squared) = (n as f64, mean * mean);
        Some(Self {
            square: square / n / mean_squared - known_variance,
            square_error: variance.sqrt() / n / mean_squared,
            bias: bias / n / mean,
            bias_error: bias_variance.sqrt() / n / mean,
        })
    }

    /// Root mean square, relative to the mean luminance; 0 where the square came out below zero.
    pub fn rms(&self) -> f64 {
        self.square.max(0.0).sqrt()
    }

    /// What the root mean square does not exceed by two standard errors.
    pub fn at_most(&self) -> f64 {
        (self.square.max(0.0) + 2.0 * self.square_error).sqrt()
    }

    /// What it does exceed by two standard errors.
    pub fn at_least(&self) -> f64 {
        (self.square - 2.0 * self.square_error).max(0.0).sqrt()
    }

    /// Standard error of the root mean square; where the square is within its error of zero, the root of that.
    pub fn rms_error(&self) -> f64 {
        let (square, error) = (self.square.max(0.0), self.square_error);
        if square > error { 0.5 * error / square.sqrt() } else { error.sqrt() }
    }
}

/// Noise of one of two renders that differ in their seeds, RMS over pixels and R, G, B, relative to the mean luminance.
pub fn noise_between(a: &Pixels, b: &Pixels) -> f64 {
    let mean = 0.5 * (a.mean_luminance() + b.mean_luminance());
    let square = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>() / 6.0;
    let sum: f64 = a.0.iter().zip(&b.0).map(square).sum();
    if mean > 0.0 { (sum / a.0.len().max(1) as f64).sqrt() / mean } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    /// Grey pixels of 1 + `wave` (alternating in sign) with uniform noise of standard deviation `sigma`.
    fn noisy(wave: f64, offset: f64, sigma: f64, seed: u64) -> Pixels {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
        let grey = |i: usize| {
            let noise = sigma * 12f64.sqrt() * (rng.random::<f64>() - 0.5);
            [1.0 + offset + if i.is_multiple_of(2) { wave } else { -wave } + noise; 3]
        };
        Pixels((0..4096).map(grey).collect())
    }

    /// A hundred trials: means are true within four standard errors, and the standard errors are those of the trials.
    #[test]
    fn differences_are_found_below_the_noise_and_their_errors_are_true() {
        for (wave, offset) in [(0.0, 0.0), (0.05, 0.02)] {
            let trial = |i: u64| {
                let a = [1, 2].map(|k| noisy(wave, offset, 0.2, 4 * i + k));
                let b = [3, 4].map(|k| noisy(0.0, 0.0, 0.2, 4 * i + k));
                Difference::of([&a[0], &a[1]], [&b[0], &b[1]], 0.0).unwrap()
            };
            let trials: Vec<Difference> = (0..100).map(trial).collect();
            let check = |value: &dyn Fn(&Difference) -> f64, error: &dyn Fn(&Difference) -> f64, truth: f64| {
                let mean = trials.iter().map(value).sum::<f64>() / 100.0;
                let scatter = (trials.iter().map(|d| (value(d) - mean).powi(2)).sum::<f64>() / 99.0).sqrt();
                let stated = trials.iter().map(error).sum::<f64>() / 100.0;
                assert!((mean - truth).abs() < 4.0 * scatter / 10.0, "{mean} +- {scatter}, not {truth}");
                // A standard deviation of 100 values is known to 7 %; four of these.
                assert!((stated / scatter - 1.0).abs() < 0.28, "stated {stated}, scatter {scatter}");
            };
            check(&|d| d.square, &|d| d.square_error, wave * wave + offset * offset);
            check(&|d| d.bias, &|d| d.bias_error, offset);
        }
    }

    #[test]
    fn noise_is_that_of_one_render() {
        let noise = noise_between(&noisy(0.0, 0.0, 0.1, 1), &noisy(0.0, 0.0, 0.1, 2));
        // 4096 squares: 4 sigma are 4 %.
        assert!((noise / 0.1 - 1.0).abs() < 0.05, "{noise}");
    }

    #[test]
    fn black_and_misshapen_pictures_have_no_difference() {
        let (black, grey) = (Pixels(vec![[0.0; 3]; 4]), Pixels(vec![[1.0; 3]; 4]));
        assert_eq!(Difference::of([&grey, &grey], [&black, &black], 0.0), None);
        assert_eq!(Difference::of([&grey, &Pixels::default()], [&grey, &grey], 0.0), None);
        let same = Difference::of([&grey, &grey], [&grey, &grey], 0.0).unwrap();
        assert_eq!((same.rms(), same.at_most(), same.bias_error), (0.0, 0.0, 0.0));
    }
}
