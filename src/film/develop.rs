//! Turns sums into the named channels of a picture.

use super::noise::mean_variance;
use super::{Film, Layer, slot};

/// One named channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name as it stands in the file.
    pub name: String,
    /// One value per pixel.
    pub values: Vec<f32>,
}

/// Channels that can be asked for beside R, G, B, A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Wanted {
    /// R, G, B of one class of paths.
    Layer(Layer),
    /// Standard error of the mean of R, G, B.
    StandardError,
    /// Number of samples.
    Samples,
    /// Mean distance to the first event, m; 0 where there is none.
    Depth,
    /// Transmittance in R, G, B.
    Transmittance,
}

impl Wanted {
    /// Every name that can be asked for.
    pub fn all() -> Vec<(Wanted, &'static str)> {
        let layers = Layer::ALL.iter().map(|(layer, name)| (Wanted::Layer(*layer), *name));
        let rest = [
            (Wanted::StandardError, "stderr"),
            (Wanted::Samples, "samples"),
            (Wanted::Depth, "depth"),
            (Wanted::Transmittance, "transmittance"),
        ];
        layers.chain(rest).collect()
    }
}

const RGB: [&str; 3] = ["R", "G", "B"];

/// The picture's channels, each multiplied by `scale` where it holds radiance: R, G, B, A, and what was asked for.
///
/// Colours outside of BT.709, which would need a negative channel, are clipped; radiance by wavelength keeps them. Where
/// the film keeps all layers, they add up to the clipped picture.
pub fn develop(film: &Film, wanted: &[Wanted], scale: f64) -> Vec<Channel> {
    let mut channels = Vec::new();
    for (c, name) in RGB.iter().enumerate() {
        channels.push(channel(film, (*name).into(), |pixel, n| clipped(scale * pixel[slot::BEAUTY + c] / n)));
    }
    channels.push(channel(film, "A".into(), |pixel, n| (pixel[slot::OPACITY] / n).clamp(0.0, 1.0)));
    for wanted in wanted {
        develop_one(film, *wanted, scale, &mut channels);
    }
    channels
}

impl Film {
    /// Mean radiance at one of the wavelengths that the film keeps, times `scale`.
    pub fn spectral_plane(&self, wavelength: usize, scale: f64) -> Vec<f32> {
        let place = slot::LAYERS + 3 * self.layers.len() + wavelength;
        channel(self, String::new(), |pixel, n| scale * pixel[place] / n).values
    }
}

/// Zero for what is negative; NaN stays, to be seen.
fn clipped(value: f64) -> f64 {
    if value < 0.0 { 0.0 } else { value }
}

impl Film {
    /// The clipped sum of one channel of one kept layer of a pixel.
    fn layer(&self, pixel: &[f64], index: usize, c: usize) -> f64 {
        let sum = |i: usize| pixel[slot::LAYERS + 3 * i + c];
        let all = 0..self.layers.len();
        if self.layers.len() < Layer::ALL.len() || all.clone().all(|i| sum(i) >= 0.0) {
            return clipped(sum(index));
        }
        // What one layer lacks, the others give in proportion.
        let positive: f64 = all.map(|i| clipped(sum(i))).sum();
        if positive > 0.0 { clipped(sum(index)) * clipped(pixel[slot::BEAUTY + c]) / positive } else { 0.0 }
    }
}

fn develop_one(film: &Film, wanted: Wanted, scale: f64, channels: &mut Vec<Channel>) {
    let mut rgb = |layer: &str, value: &dyn Fn(&[f64], f64, usize) -> f64| {
        for (c, name) in RGB.iter().enumerate() {
            channels.push(channel(film, format!("{layer}.{name}"), |pixel, n| value(pixel, n, c)));
        }
    };
    match wanted {
        Wanted::Layer(layer) => {
            let name = Layer::ALL[layer as usize].1;
            let place = film.layers.iter().position(|kept| *kept == layer);
            rgb(name, &|pixel, n, c| place.map_or(0.0, |i| scale * film.layer(pixel, i, c) / n));
        }
        Wanted::StandardError => rgb("stderr", &|pixel, _, c| scale * mean_variance(pixel, c).sqrt()),
        Wanted::Transmittance => {
            rgb("transmittance", &|pixel, n, c| (pixel[slot::TRANSMITTANCE + c] / n).clamp(0.0, 1.0))
        }
        Wanted::Samples => channels.push(channel(film, "samples.N".into(), |pixel, _| pixel[slot::COUNT])),
        Wanted::Depth => channels.push(channel(film, "depth.Z".into(), |pixel, _| {
            if pixel[slot::DEPTH_WEIGHT] > 0.0 { pixel[slot::DEPTH] / pixel[slot::DEPTH_WEIGHT] } else { 0.0 }
        })),
    }
}

/// One channel; `value` is given the pixel's sums and its number of samples, at least 1.
fn channel(film: &Film, name: String, value: impl Fn(&[f64], f64) -> f64) -> Channel {
    let values = film.pixels().map(|pixel| value(pixel, pixel[slot::COUNT].max(1.0)) as f32).collect();
    Channel { name, values }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Sample;

    /// Expected: no channel below zero, and layers that still add up to the picture.
    #[test]
    fn colours_outside_of_the_gamut_are_clipped() {
        let layers: Vec<Layer> = Layer::ALL.iter().map(|(layer, _)| *layer).collect();
        let mut film = Film::new(1, 1, &layers, 0);
        let empty = film.tally();
        film.par_tiles(&|| empty.clone(), |tally, _, mut pixels| {
            let mut sample = Sample { opacity: -1e-17, transmittance: [1.1, -0.1, 0.5], ..Sample::default() };
            sample.layers[0] = [3.0, -1.0, -2.0];
            sample.layers[1] = [1.0, 2.0, 1.0];
            sample.layers[2] = [1.0, 2.0, 0.0];
            tally.add(&sample, &[]);
            pixels.pour(0, 0, tally);
        });
        let wanted: Vec<Wanted> = Wanted::all().into_iter().map(|(wanted, _)| wanted).collect();
        let channels = develop(&film, &wanted, 2.0);
        let value = |name: &str| channels.iter().find(|channel| channel.name == name).map(|channel| channel.values[0]);
        assert_eq!([value("R"), value("G"), value("B"), value("A")], [Some(10.0), Some(6.0), Some(0.0), Some(0.0)]);
        assert_eq!([value("direct.G"), value("multiple.G"), value("airlight.G")], [Some(0.0), Some(3.0), Some(3.0)]);
        assert_eq!([value("direct.R"), value("direct.B"), value("multiple.B")], [Some(6.0), Some(0.0), Some(0.0)]);
        assert_eq!([value("transmittance.R"), value("transmittance.G")], [Some(1.0), Some(0.0)]);
    }

    #[test]
    fn layers_add_up_to_the_picture() {
        let layers: Vec<Layer> = Layer::ALL.iter().map(|(layer, _)| *layer).collect();
        let mut film = Film::new(1, 1, &layers, 0);
        let empty = film.tally();
        film.par_tiles(&|| empty.clone(), |tally, _, mut pixels| {
            for i in 0..5 {
                let mut sample = Sample::default();
                for (k, layer) in sample.layers.iter_mut().enumerate() {
                    *layer = [k as f64, f64::from(i), 0.25];
                }
                tally.add(&sample, &[]);
            }
            pixels.pour(0, 0, tally);
        });
        let wanted: Vec<Wanted> = layers.iter().map(|layer| Wanted::Layer(*layer)).collect();
        let channels = develop(&film, &wanted, 2.0);
        for c in RGB {
            let sum: f32 =
                channels.iter().filter(|ch| ch.name.ends_with(&format!(".{c}"))).map(|ch| ch.values[0]).sum();
            let beauty = channels.iter().find(|ch| ch.name == c).map(|ch| ch.values[0]);
            assert_eq!(beauty, Some(sum));
        }
    }
}
