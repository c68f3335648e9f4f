//! How bright a cloud is inside, roughly: where paths are worth following, and where they are not.
//!
//! A path from the dark side of a thick absorbing cloud hardly ever finds the light. A coarse solution of the diffusion equation tells
//! how much light there is at every place; paths divide where they come to brighter places, and are thinned out where they come
//! to darker ones (`split.rs`). However wrong the solution is, the picture is right: only its noise and its time depend on it.

mod cells;
mod diffusion;

use glam::DVec3;

use super::lighting::Lighting;
use super::media::Media;
use crate::accel::Accel;
use cells::{Cells, reduced_areas};
use diffusion::Light;

/// Diffusion lengths across the cloud above which it is worth knowing: light then falls by e^3 = 20. In clouds that do not
/// absorb, light falls too slowly for a gain.
const WORTH_LENGTHS: f64 = 3.0;

/// Darker places than this share of the brightest count as this bright. Rounding and the iteration's end decide below.
const DARKEST: f64 = 1e-12;

/// How bright a cloud is inside.
#[derive(Debug)]
pub struct Guide {
    cells: Cells,
    /// Fluence in each cell over that of the brightest.
    light: Vec<f32>,
}

impl Guide {
    /// Solves for the light in a cloud; none where it absorbs little, or is dark. `areas_m2` is the extinction cross section of everything
    /// in each size bin.
    pub fn new(accel: &Accel, media: &Media, lighting: &Lighting, areas_m2: &[f64]) -> Option<Self> {
        let (min, max) = accel.local_bounds()?;
        if diffusion_lengths(media, areas_m2, max - min) < WORTH_LENGTHS {
            return None;
        }
        let cells = Cells::new(accel, media, min, max)?;
        let mut light = diffusion::fluence(&cells, &mean_light(lighting));
        let brightest = light.iter().copied().fold(0.0, f64::max);
        if !(brightest > 0.0 && brightest.is_finite()) {
            return None;
        }
        light.iter_mut().for_each(|light| *light = (*light / brightest).max(DARKEST));
        Some(Self { cells, light: light.into_iter().map(|light| light as f32).collect() })
    }

    /// How bright a place in the cloud's frame is, against the brightest.
    #[inline]
    pub fn light(&self, point: DVec3) -> f64 {
        f64::from(self.light[self.cells.index_at(point)])
    }
}

/// What falls on the cloud, in the mean over the wavelengths.
fn mean_light(lighting: &Lighting) -> Light {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let suns = lighting.suns.iter().map(|sun| (sun.direction, mean(&sun.irradiance))).collect();
    Light { suns, surroundings: mean_background(lighting) }
}

/// Radiance of the surroundings, in the mean over six directions and all wavelengths.
fn mean_background(lighting: &Lighting) -> f64 {
    let mut behind = vec![0.0; lighting.luminance_weights.len()];
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let mut sum = 0.0;
    for axis in axes {
        lighting.background_toward(axis, &mut behind);
        sum += behind.iter().sum::<f64>();
    }
    sum / (axes.len() * behind.len()) as f64
}

/// Diffusion lengths across the shortest edge of a box, were all that is in it spread evenly.
fn diffusion_lengths(media: &Media, areas_m2: &[f64], edges_m: DVec3) -> f64 {
    let middle = media.n_wavelengths() / 2;
    let (mut extinction_m2, mut absorption_m2) = (0.0, 0.0);
    for (bin, area_m2) in areas_m2.iter().enumerate() {
        // Share of what the bin takes from the light.
        let [reduced, scattering] = reduced_areas(media, bin).map(|area| area / media.c_ext_m2(bin)[middle]);
        extinction_m2 += area_m2 * reduced;
        absorption_m2 += area_m2 * (reduced - scattering);
    }
    let lengths =
        (3.0 * extinction_m2 * absorption_m2).max(0.0).sqrt() / edges_m.element_product() * edges_m.min_element();
    // Without volume there are no cells.
    if lengths.is_finite() { lengths } else { 0.0 }
}
