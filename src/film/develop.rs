//! Turns sums into the named channels of a picture.

use super::{Film, Layer, mean_variance, slot};

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
pub fn develop(film: &Film, wanted: &[Wanted], scale: f64) -> Vec<Channel> {
    let mut channels = Vec::new();
    for (c, name) in RGB.iter().enumerate() {
        channels.push(channel(film, (*name).into(), |pixel, n| scale * pixel[slot::BEAUTY + c] / n));
    }
    channels.push(channel(film, "A".into(), |pixel, n| pixel[slot::OPACITY] / n));
    for wanted in wanted {
        develop_one(film, *wanted, scale, &mut channels);
    }
    channels
}

impl Film {
    /// Mean radiance at one of the wavelengths that the film keeps.
    pub fn spectral_plane(&self, wavelength: usize) -> Vec<f32> {
        let place = slot::LAYERS + 3 * self.layers.len() + wavelength;
        channel(self, String::new(), |pixel, n| pixel[place] / n).values
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
            rgb(name, &|pixel, n, c| place.map_or(0.0, |i| scale * pixel[slot::LAYERS + 3 * i + c] / n));
        }
        Wanted::StandardError => rgb("stderr", &|pixel, n, c| {
            scale * mean_variance(pixel[slot::BEAUTY + c], pixel[slot::SQUARES + c], n).sqrt()
        }),
        Wanted::Transmittance => rgb("transmittance", &|pixel, n, c| pixel[slot::TRANSMITTANCE + c] / n),
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

    #[test]
    fn layers_add_up_to_the_picture() {
        let layers: Vec<Layer> = Layer::ALL.iter().map(|(layer, _)| *layer).collect();
        let mut film = Film::new(1, 1, &layers, 0);
        film.par_rows(|_, mut row| {
            for i in 0..5 {
                let mut sample = Sample::default();
                for (k, layer) in sample.layers.iter_mut().enumerate() {
                    *layer = [k as f64, f64::from(i), 0.25];
                }
                row.add(0, &sample, &[]);
            }
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
