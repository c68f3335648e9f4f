//! How bright the parts of a picture are beside each other, as far as it can be told without a render: bounds of what droplets, air and
//! background send to the camera, theory (132) to (134). What is rightly small beside the rest need not be simulated.

use std::f64::consts::PI;

use glam::DVec3;

use super::droplets::TURNED;
use super::phase_bounds::{PhaseBounds, Spheres};
use super::shade::AirSeen;
use crate::scene::model::{Particle, Scene};
use crate::scene::resolved::middle_wavelength_m;
use crate::scene::settings::{Atmosphere, Effect};
use crate::spectrum::SpectralMode;
use crate::spectrum::color::BT709_LUMINANCE;

/// Luminance of a colour, and RMS over its channels: what it adds to a mean, and what it is worth as an error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Colour {
    pub luminance: f64,
    pub rms: f64,
}

impl Colour {
    fn of(rgb: [f64; 3], is_mono: bool) -> Self {
        let luminance = rgb.iter().zip(BT709_LUMINANCE).map(|(value, weight)| value * weight).sum();
        let rms = (rgb.iter().map(|value| value * value).sum::<f64>() / 3.0).sqrt();
        Self { luminance, rms: if is_mono { luminance } else { rms } }
    }
}

/// A sun, by what scatters all of its light everywhere alike: E / 4 pi, in output units.
struct SunUnit {
    direction: DVec3,
    colour: Colour,
}

/// What shines, and what is known of how it is scattered.
pub(super) struct Light {
    suns: Vec<SunUnit>,
    droplets: Vec<PhaseBounds>,
    /// Whether droplets send on all that they take.
    droplets_are_clear: bool,
    /// Whether they are of something that absorbs, so that they may be black.
    droplets_absorb: bool,
    air_phase: PhaseBounds,
    air: Atmosphere,
    /// What lies behind, where it is of one colour.
    pub background: Colour,
    /// All suns together, E / 4 pi.
    pub sun: Colour,
}

/// What a coarse picture tells of droplets.
pub(super) struct Seen<'a> {
    /// Directions of its rays.
    pub rays: &'a [DVec3],
    /// How far a ray stands for what is beside it, rad.
    pub blur: f64,
    /// Shares of their light that they lose to droplets, and that these scatter.
    pub lost: &'a [f64],
    pub scattered: &'a [f64],
    /// Share of the sunlight on droplets that others do not shade.
    pub sunlit: f64,
    /// Mean optical depth of droplets along the sun's rays.
    pub deep: f64,
    /// What is seen of the air.
    pub air: &'a [AirSeen],
}

/// The parts of a picture, in output units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// Upper bounds of sunlight scattered once by droplets, not shaded: mean over the picture, and RMS.
    pub droplets_most: f64,
    /// RMS over picture and channels of the same.
    pub droplets_rms: f64,
    /// Upper bound of the RMS of what the air scatters once.
    pub air_rms: f64,
    /// RMS of what shade takes from it.
    pub shade_rms: f64,
    /// RMS over the channels of the background, were nothing before it; of a picture nothing is known: 0.
    pub background_rms: f64,
    /// RMS of the share of its light that a ray loses to what scatters.
    pub scattered_rms: f64,
    /// Of all suns, RMS over the channels: E / 4 pi.
    pub sun_rms: f64,
    /// Lower bound of the mean luminance of droplets in sunlight.
    pub droplets_least: f64,
    /// Lower bound of that of air and background.
    pub surroundings_least: f64,
}

impl Light {
    /// Of a scene, without what somebody has switched off.
    pub fn of(scene: &Scene, is_wanted: &dyn Fn(Effect) -> bool) -> Self {
        let mode = scene.settings.spectral_mode;
        let is_mono = matches!(mode, Some(SpectralMode::Mono { .. }));
        let wavelength_m = middle_wavelength_m(&scene.settings);
        let lux = || scene.suns.iter().map(|sun| sun.lux);
        let unit = match mode {
            None | Some(SpectralMode::Bands { .. }) => 0.25 / lux().sum::<f64>(),
            _ => scene.settings.sun.irradiance / (4.0 * PI * lux().fold(0.0, f64::max)),
        };
        let suns: Vec<SunUnit> = scene
            .suns
            .iter()
            .filter(|sun| sun.lux > 0.0)
            .map(|sun| {
                let color = if is_mono { [1.0; 3] } else { sun.color };
                let colour = Colour::of(color.map(|channel| channel * unit * sun.lux), is_mono);
                SunUnit { direction: sun.direction, colour }
            })
            .collect();
        let background = &scene.settings.background;
        let is_plain = background.image.is_none() && is_wanted(Effect::Background);
        let air = scene.settings.atmosphere.clone();
        let (droplets, absorb) = droplet_phases(scene, wavelength_m);
        let sum = |part: fn(&SunUnit) -> f64| suns.iter().map(part).sum();
        Self {
            sun: Colour { luminance: sum(|sun| sun.colour.luminance), rms: sum(|sun| sun.colour.rms) },
            suns,
            droplets_are_clear: !absorb
                && scene.classes.iter().all(|class| class.albedo.is_none_or(|albedo| albedo == 1.0)),
            droplets_absorb: absorb,
            droplets,
            air_phase: PhaseBounds::of_air(&air.phase, wavelength_m),
            air: Atmosphere { sunlight: air.sunlight && is_wanted(Effect::Airlight), ..air },
            background: if is_plain { Colour::of(background.radiance, is_mono) } else { Colour::default() },
        }
    }

    /// The parts of a picture.
    pub fn parts(&self, seen: &Seen) -> Parts {
        let Seen { rays, blur, lost, scattered, sunlit, deep, air: air_seen } = *seen;
        let air = &self.air;
        let extinction_per_m = air.scattering_per_m + air.absorption_per_m;
        let passed = (-extinction_per_m * air.depth_m).exp();
        let is_lit = air.sunlight && air.scattering_per_m > 0.0;
        let by_air = if is_lit { air.scattering_per_m / extinction_per_m * (1.0 - passed) } else { 0.0 };
        let n = rays.len().max(1) as f64;
        let (mut parts, mut squares) = (Parts::default(), [0.0; 4]);
        let diffuse = if self.droplets_are_clear { diffuse_least(deep) } else { 0.0 };
        for (((ray, lost), cover), air_seen) in rays.iter().zip(lost).zip(scattered).zip(air_seen) {
            let [mut droplets_rms, mut air_rms, mut shade_rms] = [0.0; 3];
            for sun in &self.suns {
                let Colour { luminance, rms } = sun.colour;
                // Light travels on along -ray.
                let h = 1.0 + sun.direction.dot(*ray);
                let most = |bounds: &[PhaseBounds]| bounds.iter().map(|b| b.most(h, blur)).fold(0.0, f64::max);
                let least = |bounds: &[PhaseBounds]| bounds.iter().map(|b| b.least(h)).reduce(f64::min).unwrap_or(0.0);
                let of_droplets = if *cover > 0.0 { cover * most(&self.droplets) } else { 0.0 };
                droplets_rms += of_droplets * rms;
                parts.droplets_most += of_droplets * luminance / n;
                let least = if self.droplets_absorb { 0.0 } else { least(&self.droplets) * sunlit + diffuse };
                parts.droplets_least += cover * least * passed * luminance / n;
                if is_lit {
                    let AirSeen { seen, shaded } = *air_seen;
                    let most = by_air * self.air_phase.most(h, blur) * rms;
                    air_rms += seen * most;
                    shade_rms += shaded * most;
                    let least = by_air * self.air_phase.least(h) * luminance;
                    parts.surroundings_least += (seen - shaded) * least / n;
                }
            }
            // What clear droplets take from a background that is the same everywhere, they send on.
            let taken = if self.droplets_are_clear { lost - cover } else { *lost };
            parts.surroundings_least += self.background.luminance * (1.0 - taken) * passed / n;
            squares[0] += droplets_rms * droplets_rms;
            squares[1] += air_rms * air_rms;
            squares[2] += cover * cover;
            squares[3] += shade_rms * shade_rms;
        }
        let [droplets_rms, air_rms, cover_rms, shade_rms] = squares.map(|sum| (sum / n).sqrt());
        Parts {
            droplets_rms,
            air_rms,
            shade_rms,
            background_rms: self.background.rms,
            scattered_rms: cover_rms,
            sun_rms: self.sun.rms,
            ..parts
        }
    }
}

impl Parts {
    /// Lower bound of the picture's mean luminance.
    pub fn least(&self) -> f64 {
        self.droplets_least + self.surroundings_least
    }

    /// An error in output units, relative to the picture's mean luminance; `None` where the picture may be black without it.
    pub fn relative(&self, error: f64) -> Option<f64> {
        match self.least() {
            _ if error == 0.0 => Some(0.0),
            least if least > 0.0 => Some(error / least),
            _ => None,
        }
    }

    /// Upper bound of the droplets' share of the picture: a change of what they send is worth so much less; theory (134).
    pub fn droplets_share(&self) -> f64 {
        match self.surroundings_least {
            0.0 => 1.0,
            _ if self.droplets_most.is_infinite() => 1.0,
            surroundings => self.droplets_most / (self.droplets_most + surroundings),
        }
    }
}

/// Lower bound of what clear droplets of optical depth tau send anywhere after many scatterings, E / 4 pi: the lesser of what a layer reflects
/// and lets through (two streams; Meador & Weaver 1980) of light that falls on it at a cosine of 1/4.
fn diffuse_least(tau: f64) -> f64 {
    let through = 1.0 / (1.0 + 0.75 * TURNED * tau);
    through.min(1.0 - through)
}

/// Bounds for every class that occurs and for the smallest and the largest radius among particles that have one of their own; and
/// whether any of them absorbs.
fn droplet_phases(scene: &Scene, wavelength_m: f64) -> (Vec<PhaseBounds>, bool) {
    let (mut phases, mut absorb) = (Vec::new(), false);
    for (index, class) in scene.classes.iter().enumerate().filter(|(_, class)| class.albedo != Some(0.0)) {
        let particles = scene.particles.iter().filter(|particle| usize::from(particle.class) == index);
        let boxes = scene.fog_boxes.iter().filter(|fog| usize::from(fog.class) == index);
        let own_m = particles.map(Particle::own_radius_m).chain(boxes.map(|fog| fog.droplet_radius_m));
        let (mut extent, mut is_mixed) = (None, false);
        for radius_m in own_m {
            match radius_m {
                Some(r_m) => {
                    let (least, most) = extent.unwrap_or((r_m, r_m));
                    extent = Some((r_m.min(least), r_m.max(most)));
                }
                None => is_mixed = true,
            }
        }
        let mut add = |spheres: Spheres| {
            let spheres = spheres.made_of(&class.material, wavelength_m);
            absorb |= spheres.absorb() && class.albedo.is_none();
            phases.push(PhaseBounds::of_droplets(&class.phase, spheres));
        };
        if is_mixed {
            add(Spheres::of_distribution(&class.distribution, wavelength_m));
        }
        if let Some((least_m, most_m)) = extent {
            add(Spheres::of_radius(least_m, wavelength_m));
            add(Spheres::of_radius(most_m, wavelength_m));
        }
    }
    (phases, absorb)
}
