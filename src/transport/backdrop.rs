//! What lies behind everything: one radiance, or a lat-long picture.

use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use glam::DVec3;
use thiserror::Error;

use crate::excerpt::excerpt;
use crate::image::exr::{self, Limits, ReadError};
use crate::image::{Chromaticities, Picture};
use crate::spectrum::SpectralSampling;
use crate::warning::Warning;

/// A background picture that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BackdropError {
    /// The file is no OpenEXR picture that can be read.
    #[error("background.image: {0}; give a lat-long OpenEXR picture, or use background.radiance")]
    Read(#[from] ReadError),
    /// The picture has no colour.
    #[error("background.image: {} has the channels {found}; save it with R, G and B, or with Y alone", .path.display())]
    Channels { path: PathBuf, found: String },
    /// The picture is a part of a larger one.
    #[error(
        "background.image: {} holds a part of its picture only; save it with a data window as large as the display window",
        .path.display()
    )]
    Cropped { path: PathBuf },
    /// A pixel is no light.
    #[error(
        "background.image: {} is {value} in channel {channel} at pixel ({column}, {row}); every value must be a number of at most 1e12",
        .path.display()
    )]
    NotFinite { path: PathBuf, channel: &'static str, column: usize, row: usize, value: f32 },
}

/// As of `background.radiance`: sums of less than this stay finite in the 32 bits of a picture.
const BRIGHTEST: f32 = 1e12;

/// A picture of all directions: the middle is -Z, right of it is +X, the top is +Y.
#[derive(Clone, Debug, PartialEq)]
pub struct LatLong {
    width: usize,
    height: usize,
    /// Row by row from the top.
    texels: Vec<[f32; 3]>,
}

impl LatLong {
    /// Reads a picture, with warnings about what had to be changed.
    ///
    /// # Errors
    /// When the file cannot be read, needs more than 2 GiB, lacks colour, is cropped, or holds NaN or more than 1e12.
    pub fn read(path: &Path) -> Result<(Self, Vec<Warning>), BackdropError> {
        Self::of(&exr::read(path, Limits::default())?, path)
    }

    /// Takes a picture that has been read, with warnings about what had to be changed; `path` names it in messages.
    ///
    /// # Errors
    /// When it lacks colour, is cropped, or holds NaN or more than 1e12.
    pub fn of(picture: &Picture, path: &Path) -> Result<(Self, Vec<Warning>), BackdropError> {
        let frame = picture.frame;
        let full = [frame.full_width, frame.full_height];
        if [frame.x, frame.y] != [0, 0] || full != [picture.width, picture.height] {
            return Err(BackdropError::Cropped { path: path.into() });
        }
        let channels = channels(picture, path)?;
        let (width, height) = (picture.width as usize, picture.height as usize);
        let mut texels = Vec::with_capacity(width * height);
        let mut negative = 0usize;
        for i in 0..width * height {
            let mut texel = [0.0; 3];
            for (value, (channel, values)) in texel.iter_mut().zip(channels) {
                let found = values.get(i).copied().unwrap_or(0.0);
                if found.is_nan() || found.abs() > BRIGHTEST {
                    let (column, row) = (i % width, i / width);
                    return Err(BackdropError::NotFinite { path: path.into(), channel, column, row, value: found });
                }
                negative += usize::from(found < 0.0);
                *value = found.max(0.0);
            }
            texels.push(texel);
        }
        Ok((Self { width, height, texels }, warnings(path, picture, negative)))
    }

    /// A picture from its texels, row by row from the top; `None` where their number does not fit.
    pub fn from_texels(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Option<Self> {
        (width > 0 && height > 0 && texels.len() == width * height).then_some(Self { width, height, texels })
    }

    /// Red, green and blue in a direction: bilinear between the middles of texels, round the sides, theory (77).
    pub fn look(&self, direction: DVec3) -> [f64; 3] {
        let longitude = direction.x.atan2(-direction.z);
        let colatitude = direction.x.hypot(direction.z).atan2(direction.y);
        let column = (0.5 + longitude / TAU) * self.width as f64 - 0.5;
        let row = (colatitude / PI * self.height as f64 - 0.5).clamp(0.0, self.height as f64 - 1.0);
        let (left, top) = (column.floor(), row.floor());
        let (s, t) = (column - left, row - top);
        let columns = [left, left + 1.0].map(|c| (c as i64).rem_euclid(self.width as i64) as usize);
        let rows = [top as usize, (top as usize + 1).min(self.height - 1)];
        let mut color = [0.0; 3];
        for (row, weight_t) in rows.into_iter().zip([1.0 - t, t]) {
            for (column, weight_s) in columns.into_iter().zip([1.0 - s, s]) {
                let texel = self.texels[row * self.width + column];
                color.iter_mut().zip(texel).for_each(|(sum, v)| *sum += weight_t * weight_s * f64::from(v));
            }
        }
        color
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.texels[..])
    }
}

/// R, G and B, or Y three times.
fn channels<'a>(picture: &'a Picture, path: &Path) -> Result<[(&'static str, &'a [f32]); 3], BackdropError> {
    let named = |name: &'static str| picture.channel(name).map(|values| (name, values));
    match (named("R"), named("G"), named("B"), named("Y")) {
        (Some(r), Some(g), Some(b), _) => Ok([r, g, b]),
        (None, None, None, Some(y)) => Ok([y; 3]),
        _ => {
            let names: Vec<String> = picture.channels.iter().map(|channel| excerpt(&channel.name)).take(20).collect();
            Err(BackdropError::Channels { path: path.into(), found: names.join(", ") })
        }
    }
}

/// Primaries that differ by less are the same: three decimals are often written of BT.709's.
const SAME_COLOUR: f32 = 0.002;

fn is_bt709(colours: &Chromaticities) -> bool {
    let rows = |c: &Chromaticities| [c.red, c.green, c.blue, c.white];
    let pairs = rows(colours).into_iter().flatten().zip(rows(&Chromaticities::BT709).into_iter().flatten());
    pairs.into_iter().all(|(a, b)| (a - b).abs() < SAME_COLOUR)
}

fn warnings(path: &Path, picture: &Picture, negative: usize) -> Vec<Warning> {
    let (mut warnings, [width, height]) = (Vec::new(), [picture.width, picture.height]);
    if picture.chromaticities.is_some_and(|colours| !is_bt709(&colours)) {
        warnings.push(Warning::new(
            format!("{}: the colours are of other primaries than BT.709, and are taken as if of these", path.display()),
            "convert the picture to linear BT.709",
        ));
    }
    if negative > 0 {
        warnings.push(Warning::new(
            format!("{}: {negative} values are negative and count as 0", path.display()),
            "clip the picture to BT.709 with values of at least 0",
        ));
    }
    if u64::from(width) != 2 * u64::from(height) {
        warnings.push(Warning::new(
            format!("{}: {width} x {height} pixels are stretched over all directions", path.display()),
            "use a lat-long picture, twice as wide as high",
        ));
    }
    warnings
}

/// What lies behind everything, by rendered wavelength.
#[derive(Clone, Debug)]
pub struct Backdrop {
    constant: Vec<f64>,
    image: Option<(LatLong, SpectralSampling)>,
}

impl Backdrop {
    /// A picture where there is one, otherwise one radiance in all directions.
    pub fn new(sampling: &SpectralSampling, radiance: [f64; 3], image: Option<LatLong>) -> Self {
        Self { constant: sampling.background_spectrum(radiance), image: image.map(|image| (image, sampling.clone())) }
    }

    /// Fills `out` with the radiance that is seen in a direction.
    #[inline]
    pub fn toward(&self, direction: DVec3, out: &mut [f64]) {
        match &self.image {
            None => out.copy_from_slice(&self.constant),
            Some((image, sampling)) => sampling.background_spectrum_into(image.look(direction), out),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four columns, two rows, each texel its own value in red.
    fn numbered() -> LatLong {
        let texels = (0..8).map(|i| [i as f32, 0.0, 1.0]).collect();
        LatLong::from_texels(4, 2, texels).expect("eight texels")
    }

    #[test]
    fn texels_lie_where_they_are_documented() {
        let up = std::f64::consts::FRAC_1_SQRT_2;
        let toward = |longitude_deg: f64, y: f64| {
            let (sin, cos) = longitude_deg.to_radians().sin_cos();
            DVec3::new(up * sin, y, -up * cos)
        };
        // Middles of the texels: 45 degrees up or down, at -135, -45, 45 and 135 degrees to the right of -Z.
        for (column, longitude_deg) in [-135.0, -45.0, 45.0, 135.0].into_iter().enumerate() {
            for (row, y) in [up, -up].into_iter().enumerate() {
                let [r, g, b] = numbered().look(toward(longitude_deg, y));
                assert!((r - (4 * row + column) as f64).abs() < 1e-12, "{column} {row}: {r}");
                assert!(g == 0.0 && (b - 1.0).abs() < 1e-15);
            }
        }
        // Straight ahead is halfway between the two columns in the middle; behind, between the first and the last.
        assert!((numbered().look(toward(0.0, up))[0] - 1.5).abs() < 1e-12);
        assert!((numbered().look(toward(180.0, up))[0] - 1.5).abs() < 1e-12);
        for pole in [DVec3::Y, DVec3::NEG_Y, DVec3::new(0.0, -1.0, -0.0)] {
            assert!(numbered().look(pole)[0].is_finite());
        }
    }

    #[test]
    fn a_picture_of_one_texel_is_everywhere() {
        let one = LatLong::from_texels(1, 1, vec![[0.25, 0.5, 1.0]]).expect("one texel");
        for d in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::Z, DVec3::NEG_Z] {
            let [r, g, b] = one.look(d);
            assert!((r - 0.25).abs() + (g - 0.5).abs() + (b - 1.0).abs() < 1e-15);
        }
    }
}
