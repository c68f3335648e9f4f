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

    /// Compares each of two renders of a picture with one of which only the mean square of its noise is known: their own noise counts.
    /// `None` as with [`Self::of`].
    pub fn with_noise_from(a: [&Pixels; 2], b: &Pixels, known_variance: f64) -> Option<Self> {
        let without = Self::of(a, [b, b], known_variance)?;
        let square = |(i, b): (usize, &[f64; 3])| {
            a.iter().flat_map(|a| (0..3).map(move |c| (a.0[i][c] - b[c]).powi(2))).sum::<f64>() / 6.0
        };
        let squares: Vec<f64> = b.0.iter().enumerate().map(square).collect();
        // Of normal noise of variance v, the mean of two squares has the mean v, the mean square 2 v^2 and the variance v^2.
        let variance = squares.iter().map(|s| s * s).sum::<f64>() / 2.0;
        let (n, mean_squared) = (squares.len() as f64, b.mean_luminance().powi(2));
        Some(Self {
            square: squares.iter().sum::<f64>() / n / mean_squared - known_variance,
            square_error: variance.sqrt() / n / mean_squared,
            ..without
        })
    }

    /// The same with a noise that is independent of it: squares add up.
    pub fn with(self, noise: Noise) -> Self {
        Self { square: self.square + noise.square, square_error: self.square_error.hypot(noise.square_error), ..self }
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

/// The noise of a picture, relative to its mean luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Mean square over pixels and R, G, B.
    pub square: f64,
    /// Its standard error.
    pub square_error: f64,
}

impl Noise {
    /// That of one of two renders that differ in their seeds: half the mean square of what is between them. Zero where both are black.
    pub fn between(a: &Pixels, b: &Pixels) -> Self {
        let mean = 0.5 * (a.mean_luminance() + b.mean_luminance());
        if mean <= 0.0 {
            return Self::default();
        }
        let square = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>() / 6.0;
        let squares: Vec<f64> = a.0.iter().zip(&b.0).map(square).collect();
        // Of normal noise of variance v, half the square of a difference has the mean v, the mean square 3 v^2 and the variance
        // 2 v^2: two thirds of its square. Channels that go together, as those of one path do, have that; others have less.
        let variance = squares.iter().map(|s| s * s).sum::<f64>() * 2.0 / 3.0;
        let (n, mean_squared) = (squares.len() as f64, mean * mean);
        Self {
            square: squares.iter().sum::<f64>() / n / mean_squared,
            square_error: variance.sqrt() / n / mean_squared,
        }
    }

    /// Root mean square.
    pub fn rms(self) -> f64 {
        self.square.sqrt()
    }
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

    /// A hundred values: their mean is true within four standard errors, and the standard errors are those of the values.
    fn check(values: &[f64], errors: &[f64], truth: f64) {
        let mean = values.iter().sum::<f64>() / 100.0;
        let scatter = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 99.0).sqrt();
        let stated = errors.iter().sum::<f64>() / 100.0;
        assert!((mean - truth).abs() < 4.0 * scatter / 10.0, "{mean} +- {scatter}, not {truth}");
        // A standard deviation of 100 values is known to 7 %; four of these.
        assert!((stated / scatter - 1.0).abs() < 0.28, "stated {stated}, scatter {scatter}");
    }

    #[test]
    fn differences_are_found_below_the_noise_and_their_errors_are_true() {
        for (wave, offset) in [(0.0, 0.0), (0.05, 0.02)] {
            let trial = |i: u64| {
                let a = [1, 2].map(|k| noisy(wave, offset, 0.2, 4 * i + k));
                let b = [3, 4].map(|k| noisy(0.0, 0.0, 0.2, 4 * i + k));
                Difference::of([&a[0], &a[1]], [&b[0], &b[1]], 0.0).unwrap()
            };
            let trials: Vec<Difference> = (0..100).map(trial).collect();
            let of = |value: &dyn Fn(&Difference) -> f64| trials.iter().map(value).collect::<Vec<f64>>();
            check(&of(&|d| d.square), &of(&|d| d.square_error), wave * wave + offset * offset);
            check(&of(&|d| d.bias), &of(&|d| d.bias_error), offset);
        }
    }

    /// As many pixels have ten times the noise as hold half of it: few pixels, and a standard error that is true all the same.
    #[test]
    fn noise_is_that_of_one_render_and_its_error_is_true() {
        for share in [1, 100] {
            let picture = |seed| {
                let pixels = noisy(0.0, 0.0, 0.1, seed).0.into_iter().enumerate();
                let louder = |(i, [r, ..]): (usize, [f64; 3])| if i % share == 0 { 1.0 + 10.0 * (r - 1.0) } else { r };
                Pixels(pixels.map(|pixel| [louder(pixel); 3]).collect())
            };
            let trials: Vec<Noise> = (0..100).map(|i| Noise::between(&picture(2 * i), &picture(2 * i + 1))).collect();
            let of = |value: &dyn Fn(&Noise) -> f64| trials.iter().map(value).collect::<Vec<f64>>();
            let loud = 4096_usize.div_ceil(share) as f64 / 4096.0;
            check(&of(&|n| n.square), &of(&|n| n.square_error), 0.01 * (1.0 + 99.0 * loud));
        }
    }

    #[test]
    fn errors_with_noise_are_found_from_a_noisy_reference() {
        for (wave, offset) in [(0.0, 0.0), (0.05, 0.02)] {
            let trial = |i: u64| {
                let a = [1, 2].map(|k| noisy(wave, offset, 0.2, 4 * i + k));
                Difference::with_noise_from([&a[0], &a[1]], &noisy(0.0, 0.0, 0.1, 4 * i + 3), 0.01).unwrap()
            };
            let trials: Vec<Difference> = (0..100).map(trial).collect();
            let of = |value: &dyn Fn(&Difference) -> f64| trials.iter().map(value).collect::<Vec<f64>>();
            check(&of(&|d| d.square), &of(&|d| d.square_error), 0.04 + wave * wave + offset * offset);
        }
    }

    #[test]
    fn independent_errors_add_up_in_squares() {
        let own = Difference { square: 9.0, square_error: 3.0, bias: 0.5, bias_error: 0.25 };
        let both = own.with(Noise { square: 16.0, square_error: 4.0 });
        assert_eq!(both, Difference { square: 25.0, square_error: 5.0, ..own });
    }

    #[test]
    fn black_and_misshapen_pictures_have_no_difference() {
        let (black, grey) = (Pixels(vec![[0.0; 3]; 4]), Pixels(vec![[1.0; 3]; 4]));
        assert_eq!(Difference::of([&grey, &grey], [&black, &black], 0.0), None);
        assert_eq!(Difference::of([&grey, &Pixels::default()], [&grey, &grey], 0.0), None);
        assert_eq!(Noise::between(&black, &black), Noise::default());
        let same = Difference::of([&grey, &grey], [&grey, &grey], 0.0).unwrap();
        assert_eq!((same.rms(), same.at_most(), same.bias_error), (0.0, 0.0, 0.0));
    }
}
