//! Sums of samples per pixel: means, standard errors, layers.

mod develop;

pub use develop::{Channel, Wanted, develop};

use rayon::prelude::*;

/// A class of light paths; the picture is the sum of all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// Camera, droplet, sun.
    Direct,
    /// Camera, several droplets, sun.
    Multiple,
    /// Camera, air, sun.
    Airlight,
    /// Camera, air, droplet, sun.
    Glow,
    /// All other paths with air in them.
    AirMultiple,
    /// Through resolved droplets.
    Refraction,
    /// Camera to background.
    Background,
}

impl Layer {
    /// All layers with the names of their channels, in the order of the sum.
    pub const ALL: [(Layer, &'static str); 7] = [
        (Layer::Direct, "direct"),
        (Layer::Multiple, "multiple"),
        (Layer::Airlight, "airlight"),
        (Layer::Glow, "glow"),
        (Layer::AirMultiple, "air_multiple"),
        (Layer::Refraction, "refraction"),
        (Layer::Background, "background"),
    ];
}

/// What one path brings to its pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// R, G, B of each layer, indexed by `Layer`.
    pub layers: [[f64; 3]; Layer::ALL.len()],
    /// Transmittance of the camera ray in R, G, B.
    pub transmittance: [f64; 3],
    /// One minus the luminance-weighted transmittance.
    pub opacity: f64,
    /// Sum of distances to the first event, weighted, m.
    pub depth_sum_m: f64,
    /// Sum of those weights.
    pub depth_weight: f64,
}

/// Positions of the sums within a pixel's row; the layers follow, then the spectrum.
mod slot {
    pub const COUNT: usize = 0;
    pub const BEAUTY: usize = 1;
    pub const SQUARES: usize = 4;
    pub const TRANSMITTANCE: usize = 7;
    pub const OPACITY: usize = 10;
    pub const DEPTH: usize = 11;
    pub const DEPTH_WEIGHT: usize = 12;
    pub const LAYERS: usize = 13;
}

/// Sums over samples of every pixel of a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: usize,
    height: usize,
    layers: Vec<Layer>,
    n_spectral: usize,
    sums: Vec<f64>,
}

/// One row of pixels that a thread fills.
pub struct FilmRow<'a> {
    layers: &'a [Layer],
    stride: usize,
    sums: &'a mut [f64],
}

impl Film {
    /// An empty film that keeps the given layers apart, and radiance at `n_spectral` wavelengths.
    pub fn new(width: u32, height: u32, layers: &[Layer], n_spectral: usize) -> Self {
        let (width, height) = (width as usize, height as usize);
        let mut film = Self { width, height, layers: layers.to_vec(), n_spectral, sums: Vec::new() };
        film.sums = vec![0.0; width * height * film.stride()];
        film
    }

    fn stride(&self) -> usize {
        slot::LAYERS + 3 * self.layers.len() + self.n_spectral
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Bytes that the sums take.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.sums[..])
    }

    /// Calls `fill` for every row, in parallel, and returns what the calls return, in the rows' order.
    pub fn par_rows<T: Send>(&mut self, fill: impl Fn(usize, FilmRow<'_>) -> T + Sync) -> Vec<T> {
        let stride = self.stride();
        let layers = &self.layers[..];
        self.sums
            .par_chunks_mut(stride * self.width)
            .enumerate()
            .map(|(row, sums)| fill(row, FilmRow { layers, stride, sums }))
            .collect()
    }

    fn pixels(&self) -> impl Iterator<Item = &[f64]> {
        self.sums.chunks_exact(self.stride())
    }

    /// Mean luminance of the picture.
    pub fn mean_luminance(&self) -> f64 {
        let of = |pixel: &[f64]| luminance(|c| pixel[slot::BEAUTY + c] / pixel[slot::COUNT].max(1.0));
        self.pixels().map(of).sum::<f64>() / (self.width * self.height).max(1) as f64
    }

    /// Standard error of the picture, RMS over pixels of the luminance, relative to its mean; infinite before two
    /// samples, 0 for a black picture.
    pub fn noise(&self) -> f64 {
        let (mut mean, mut variance, mut n) = (0.0, 0.0, 0usize);
        for pixel in self.pixels() {
            let samples = pixel[slot::COUNT];
            if samples < 2.0 {
                return f64::INFINITY;
            }
            mean += luminance(|c| pixel[slot::BEAUTY + c] / samples);
            variance +=
                luminance(|c| mean_variance(pixel[slot::BEAUTY + c], pixel[slot::SQUARES + c], samples).sqrt()).powi(2);
            n += 1;
        }
        if mean == 0.0 { 0.0 } else { (variance * n as f64).sqrt() / mean.abs() }
    }
}

/// Luminance of linear BT.709 (ITU-R BT.709-6, item 3.2).
fn luminance(channel: impl Fn(usize) -> f64) -> f64 {
    0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
}

/// Variance of the mean of `n` samples with the given sum and sum of squares.
fn mean_variance(sum: f64, squares: f64, n: f64) -> f64 {
    if n < 2.0 {
        return 0.0;
    }
    ((squares / n - (sum / n).powi(2)) / (n - 1.0)).max(0.0)
}

impl FilmRow<'_> {
    /// Adds one sample, and its radiance by wavelength where the film keeps it, to the pixel in the given column.
    pub fn add(&mut self, column: usize, sample: &Sample, spectrum: &[f64]) {
        let pixel = &mut self.sums[column * self.stride..(column + 1) * self.stride];
        pixel[slot::COUNT] += 1.0;
        for c in 0..3 {
            let beauty: f64 = sample.layers.iter().map(|layer| layer[c]).sum();
            pixel[slot::BEAUTY + c] += beauty;
            pixel[slot::SQUARES + c] += beauty * beauty;
            pixel[slot::TRANSMITTANCE + c] += sample.transmittance[c];
        }
        pixel[slot::OPACITY] += sample.opacity;
        pixel[slot::DEPTH] += sample.depth_sum_m;
        pixel[slot::DEPTH_WEIGHT] += sample.depth_weight;
        let (layers, spectral) = pixel[slot::LAYERS..].split_at_mut(3 * self.layers.len());
        for (sums, layer) in layers.chunks_exact_mut(3).zip(self.layers) {
            for (sum, value) in sums.iter_mut().zip(sample.layers[*layer as usize]) {
                *sum += value;
            }
        }
        for (sum, value) in spectral.iter_mut().zip(spectrum) {
            *sum += value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(value: f64) -> Sample {
        let mut sample = Sample { opacity: 1.0, ..Sample::default() };
        sample.layers[Layer::Direct as usize] = [value; 3];
        sample
    }

    #[test]
    fn noise_is_the_relative_standard_error() {
        let mut film = Film::new(2, 1, &[], 0);
        assert_eq!(film.noise(), f64::INFINITY);
        film.par_rows(|_, mut row| {
            for value in [1.0, 3.0, 1.0, 3.0] {
                row.add(0, &grey(value), &[]);
                row.add(1, &grey(2.0), &[]);
            }
        });
        // Sample variance 4/3 over 4 samples, in one of two pixels, about a mean of 2.
        assert!((film.noise() - (4.0 / 3.0 / 4.0 / 2.0f64).sqrt() / 2.0).abs() < 1e-12);
    }
}
