//! How far the sums of a film can be off, from the scatter between blocks of samples.

use super::{Film, luminance, slot};

/// Variances of the samples of some pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Sum over the pixels of what the variance of one sample amounts to: that of the mean times its samples.
    pub variance_sum: f64,
    /// Samples of these pixels.
    pub samples: u64,
    /// Number of pixels.
    pub pixels: u32,
}

impl Spread {
    pub(crate) fn add(&mut self, other: &Spread) {
        self.variance_sum += other.variance_sum;
        self.samples += other.samples;
        self.pixels += other.pixels;
    }

    /// The mean over the pixels; 0 where there are none.
    pub fn mean(&self) -> f64 {
        self.variance_sum / f64::from(self.pixels.max(1))
    }
}

/// The noise of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard error, RMS over pixels and R, G, B, relative to the mean luminance.
    pub relative: f64,
    /// How uncertain its square is: the relative standard error of the sum of variances.
    pub uncertainty: f64,
}

/// Variance of a channel's mean: the scatter of the blocks' sums about their share of the total (theory (93)).
pub(super) fn mean_variance(pixel: &[f64], c: usize) -> f64 {
    let (n, n_squares) = (pixel[slot::COUNT], pixel[slot::COUNT_SQUARES]);
    let independent = n * n - n_squares;
    if independent <= 0.0 {
        return 0.0;
    }
    let mean = pixel[slot::BEAUTY + c] / n;
    let scatter = pixel[slot::SQUARES + c] - mean * (2.0 * pixel[slot::PRODUCTS + c] - mean * n_squares);
    (scatter / independent).max(0.0)
}

/// Variance of the mean, averaged over R, G and B: what a picture's error is measured by.
fn channel_variance(pixel: &[f64]) -> f64 {
    (0..3).map(|c| mean_variance(pixel, c)).sum::<f64>() / 3.0
}

/// Degrees of freedom of a pixel's variance: its blocks less one, had they one length (theory (94)).
fn freedom(pixel: &[f64]) -> f64 {
    pixel[slot::COUNT].powi(2) / pixel[slot::COUNT_SQUARES] - 1.0
}

impl Film {
    /// The noise of the picture; infinite before two samples in every pixel, 0 for a black picture.
    pub fn noise(&self) -> f64 {
        self.noise_and_uncertainty().relative
    }

    /// The noise of the picture, and how far it can be trusted.
    pub fn noise_and_uncertainty(&self) -> Noise {
        let (mut mean, mut variance, mut of_variance, mut n) = (0.0, 0.0, 0.0, 0usize);
        for pixel in self.pixels() {
            let freedom = freedom(pixel);
            if freedom.is_nan() || freedom <= 0.0 {
                return Noise { relative: f64::INFINITY, uncertainty: f64::INFINITY };
            }
            mean += luminance(|c| pixel[slot::BEAUTY + c] / pixel[slot::COUNT]);
            let of_pixel = channel_variance(pixel);
            variance += of_pixel;
            // The variance of a variance of normal deviates is 2 / degrees of freedom of its square.
            of_variance += of_pixel * of_pixel * 2.0 / freedom;
            n += 1;
        }
        if mean == 0.0 || variance == 0.0 {
            return Noise { relative: 0.0, uncertainty: 0.0 };
        }
        Noise { relative: (variance * n as f64).sqrt() / mean.abs(), uncertainty: of_variance.sqrt() / variance }
    }

    /// The spread of samples in every tile, of pixels where x + y is even and of those where it is odd.
    pub fn tile_spreads(&self) -> Vec<[Spread; 2]> {
        let of_tile = |tile| {
            let mut spreads = [Spread::default(); 2];
            for (x, y) in self.tile(tile).pixels() {
                let pixel = self.pixel(x, y);
                let of_parity = &mut spreads[(x + y) % 2];
                of_parity.variance_sum += channel_variance(pixel) * pixel[slot::COUNT];
                of_parity.samples += pixel[slot::COUNT] as u64;
                of_parity.pixels += 1;
            }
            spreads
        };
        (0..self.n_tiles()).map(of_tile).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Layer, Sample};
    use super::*;

    fn grey(value: f64) -> Sample {
        let mut sample = Sample { opacity: 1.0, ..Sample::default() };
        sample.layers[Layer::Direct as usize] = [value; 3];
        sample
    }

    /// A film of one row whose pixels see these samples.
    fn film(rows: &[&[f64]]) -> Film {
        let mut film = Film::new(rows.len() as u32, 1, &[], 0);
        let empty = film.tally();
        film.par_tiles(&|| empty.clone(), |tally, tile, mut pixels| {
            for (x, y) in tile.pixels() {
                tally.start(0);
                rows[x].iter().for_each(|value| tally.add(&grey(*value), &[]));
                pixels.pour(x, y, tally);
            }
        });
        film
    }

    #[test]
    fn noise_is_the_relative_standard_error() {
        assert_eq!(Film::new(2, 1, &[], 0).noise(), f64::INFINITY);
        assert_eq!(film(&[&[1.0, 3.0], &[1.0]]).noise(), f64::INFINITY, "one sample tells nothing");
        // Blocks of 1, 1 and 2 samples about a mean of 2: sums 1, 3, 4 against 2, 2, 4; scatter 2 over 16 - 6.
        let noise = film(&[&[1.0, 3.0, 1.0, 3.0], &[2.0; 4]]).noise_and_uncertainty();
        assert!((noise.relative - (2.0 / 10.0 / 2.0f64).sqrt() / 2.0).abs() < 1e-12);
        // One pixel varies, with 16/6 - 1 degrees of freedom.
        assert!((noise.uncertainty - (2.0 / (16.0 / 6.0 - 1.0f64)).sqrt()).abs() < 1e-12);
        assert_eq!(film(&[&[0.0; 4], &[0.0; 4]]).noise(), 0.0);
    }

    /// Independent samples of variance 1/12: the estimate of the mean's variance is unbiased for whatever number of
    /// samples, also where the last block is cut.
    #[test]
    fn variances_of_independent_samples_are_unbiased() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
        for n in [2, 3, 5, 16, 23, 100] {
            let estimates: Vec<f64> = (0..4000)
                .map(|_| {
                    let values: Vec<f64> = (0..n).map(|_| rng.random()).collect();
                    mean_variance(film(&[&values]).pixel(0, 0), 0) * f64::from(n) * 12.0
                })
                .collect();
            let mean = estimates.iter().sum::<f64>() / 4000.0;
            let error = (estimates.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 4000.0 / 3999.0).sqrt();
            assert!((mean - 1.0).abs() < 4.0 * error, "{n}: {mean} +- {error}");
            assert!(error < 0.03, "{error}");
        }
    }
}
