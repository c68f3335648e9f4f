//! The light that falls on the scene, by rendered wavelength, and the way from wavelengths to channels.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;

use super::backdrop::Backdrop;
use super::path::{around, turn_h};
use crate::optics::phase_function::PhaseFunction;
use crate::scene::model::{Scene, Sun};
use crate::spectrum::{Light, SpectralSampling};

/// One sun.
#[derive(Clone, Debug)]
pub struct SunLight {
    /// Unit vector in which the light travels.
    pub direction: DVec3,
    /// Irradiance by wavelength, in the units in which radiance is rendered.
    pub irradiance: Vec<f64>,
    /// 1 - cos of the disc's angular radius; 0 where the sun is a point.
    pub disc_h: f64,
}

impl SunLight {
    /// Whether it is a point.
    #[inline]
    pub fn is_point(&self) -> bool {
        self.disc_h == 0.0
    }

    /// The direction to a point of its disc, even over its solid angle for two even numbers in [0, 1).
    #[inline]
    pub fn toward(&self, [height, turn]: [f64; 2]) -> DVec3 {
        around(-self.direction, height * self.disc_h, turn)
    }

    /// Radiance of the disc over irradiance, theory (76): one over its solid angle, sr^-1; infinite for a point.
    pub fn disc_per_sr(&self) -> f64 {
        1.0 / (TAU * self.disc_h)
    }
}

/// The air between the droplets.
#[derive(Clone, Debug)]
pub struct Air {
    /// Scattering coefficient, 1/m.
    pub scattering_per_m: f64,
    /// Scattering plus absorption, 1/m.
    pub extinction_per_m: f64,
    /// Radius of the ball of air about the camera, m.
    pub depth_m: f64,
    /// Longest march step, m.
    pub step_m: f64,
    /// Whether the suns light it.
    pub is_sunlit: bool,
    /// Phase function by wavelength.
    pub phase: Vec<Arc<PhaseFunction>>,
}

impl Air {
    /// Transmittance of a way through the air, m.
    #[inline]
    pub fn transmittance(&self, way_m: f64) -> f64 {
        (-self.extinction_per_m * way_m).exp()
    }
}

/// Whether suns have the size that they have in the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Discs {
    /// Each sun is a disc of its angular diameter.
    Simulated,
    /// They are points.
    LeftOut,
}

/// Everything that shines, and how wavelengths become channels.
#[derive(Clone, Debug)]
pub struct Lighting {
    /// The suns.
    pub suns: Vec<SunLight>,
    /// What lies behind everything.
    pub backdrop: Backdrop,
    /// Contribution of a unit of radiance at each wavelength to R, G, B.
    pub rgb_weights: Vec<[f64; 3]>,
    /// Share of each wavelength in R, G and B of white light; each sums to 1.
    pub channel_shares: [Vec<f64>; 3],
    /// Share of each wavelength in the luminance; sums to 1.
    pub luminance_weights: Vec<f64>,
    /// The air.
    pub air: Air,
}

impl Lighting {
    /// The light of a scene; `air_phase` holds one phase function per wavelength, or one for all.
    pub fn new(
        scene: &Scene,
        sampling: &SpectralSampling,
        backdrop: Backdrop,
        discs: Discs,
        air_phase: Vec<Arc<PhaseFunction>>,
    ) -> Self {
        let rgb_weights = sampling.rgb_weights.clone();
        let n_wavelengths = sampling.wavelengths_m.len();
        let atmosphere = &scene.settings.atmosphere;
        Self {
            suns: suns(scene, sampling, discs),
            backdrop,
            channel_shares: [0, 1, 2].map(|channel| shares(&rgb_weights, channel)),
            luminance_weights: sampling.luminance_weights.clone(),
            rgb_weights,
            air: Air {
                scattering_per_m: atmosphere.scattering_per_m,
                extinction_per_m: atmosphere.scattering_per_m + atmosphere.absorption_per_m,
                depth_m: atmosphere.depth_m,
                step_m: atmosphere.step_m,
                is_sunlit: atmosphere.sunlight,
                phase: (0..n_wavelengths).map(|w| air_phase[w.min(air_phase.len() - 1)].clone()).collect(),
            },
        }
    }

    /// Fills `out` with the radiance by wavelength that is seen in a direction where nothing is in the way; without the
    /// suns.
    #[inline]
    pub fn background_toward(&self, direction: DVec3, out: &mut [f64]) {
        self.backdrop.toward(direction, out);
    }

    /// Adds the suns' discs that are seen in a direction.
    pub fn add_suns_discs(&self, direction: DVec3, out: &mut [f64]) {
        for sun in self.suns.iter().filter(|sun| !sun.is_point() && turn_h(direction, -sun.direction) <= sun.disc_h) {
            for (radiance, irradiance) in out.iter_mut().zip(&sun.irradiance) {
                *radiance += irradiance * sun.disc_per_sr();
            }
        }
    }

    /// R, G, B of a radiance by wavelength.
    #[inline]
    pub fn rgb(&self, radiance: &[f64]) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for (value, weights) in radiance.iter().zip(&self.rgb_weights) {
            for (channel, weight) in rgb.iter_mut().zip(weights) {
                *channel += weight * value;
            }
        }
        rgb
    }

    /// The mean of a transmittance by wavelength as one channel weighs it.
    #[inline]
    pub fn channel_mean(&self, channel: usize, transmittance: &[f64]) -> f64 {
        self.channel_shares[channel].iter().zip(transmittance).map(|(share, value)| share * value).sum()
    }
}

/// What each wavelength contributes to a channel of white light, as shares of the whole.
fn shares(rgb_weights: &[[f64; 3]], channel: usize) -> Vec<f64> {
    let total: f64 = rgb_weights.iter().map(|weights| weights[channel]).sum();
    rgb_weights.iter().map(|weights| weights[channel] / total).collect()
}

fn suns(scene: &Scene, sampling: &SpectralSampling, discs: Discs) -> Vec<SunLight> {
    let settings = &scene.settings.sun;
    let light =
        |sun: &Sun| Light { spectrum: sun.spectrum.unwrap_or(settings.spectrum), color: sun.color, lux: sun.lux };
    let lights: Vec<Light> = scene.suns.iter().map(light).collect();
    let irradiances = sampling.light_weights(&lights, settings.irradiance);
    let disc_h = |sun: &Sun| match discs {
        Discs::LeftOut => 0.0,
        // 1 - cos(a) of the angular radius a, without cancellation.
        Discs::Simulated => 2.0 * (0.25 * scene.sun_diameter_deg(sun).to_radians()).sin().powi(2),
    };
    let with_direction =
        |(sun, irradiance): (&Sun, Vec<f64>)| SunLight { direction: sun.direction, irradiance, disc_h: disc_h(sun) };
    scene.suns.iter().zip(irradiances).map(with_direction).collect()
}
