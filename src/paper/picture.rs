//! The paper's renderer: one droplet, one ray per sample, its colour where the ray meets it and the air's elsewhere.
//!
//! The phase function is not normalised and the surface light does not weaken with distance, as published: brightness has no
//! unit, colour and direction are what can be compared.

use glam::DVec3;
use rayon::prelude::*;

use super::formulas::{Efficiencies, phase};
use super::geometry::{Passage, pass_sphere, ray_sphere};
use crate::image::Picture;
use crate::scene::model::{Camera, Lens, Scene};

/// Rays per pixel along each side.
const RAYS: u32 = 2;

/// What a figure is made of, taken from its scene.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Width and height, pixels.
    pub resolution: [u32; 2],
    camera: Camera,
    /// Unit vector in which the white light travels.
    light: DVec3,
    center: DVec3,
    radius: f64,
    /// sigma_s and sigma_a, 1/m.
    sigma_s: f64,
    sigma_a: f64,
    /// Interval of the march, m, and its number of samples.
    interval: f64,
    samples: u32,
}

impl Setting {
    /// The setting of a scene with a droplet and a light; `None` where there is none.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (droplet, sun) = (scene.particles.first()?, scene.suns.first()?);
        let air = &scene.settings.atmosphere;
        Some(Self {
            resolution: scene.settings.image.resolution,
            camera: scene.camera.clone(),
            light: sun.direction,
            center: droplet.center_m,
            radius: f64::from(droplet.radius_m),
            sigma_s: air.scattering_per_m,
            sigma_a: air.absorption_per_m,
            interval: air.step_m,
            samples: (air.depth_m / air.step_m).round() as u32,
        })
    }

    /// The ray of the camera through a point of the picture, which is (0, 0) at the top left.
    fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let [width, height] = self.resolution.map(f64::from);
        let (right, up) = (2.0 * x / width - 1.0, 1.0 - 2.0 * y / height);
        let frame = self.camera.world_from_camera;
        match self.camera.lens {
            Lens::Perspective { yfov_rad, .. } => {
                let half = (0.5 * yfov_rad).tan();
                let local = DVec3::new(right * half * width / height, up * half, -1.0);
                (self.camera.position_m, (frame * local).normalize())
            }
            Lens::Orthographic { xmag_m, ymag_m } => {
                let offset = frame * DVec3::new(right * xmag_m, up * ymag_m, 0.0);
                (self.camera.position_m + offset, frame * DVec3::NEG_Z)
            }
        }
    }
}

/// What a ray met, as the paper records it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RayState {
    /// Nothing but air.
    Missed = 0,
    /// The droplet, which it left again.
    Left = 1,
    /// The droplet, in which it was reflected totally.
    TotalReflection = 2,
}

/// What the droplet does to the three colours.
#[derive(Clone, Copy, Debug)]
pub struct Colours {
    /// Efficiencies of red, green and blue.
    pub efficiencies: [Efficiencies; 3],
    /// Refractive index of red, green and blue.
    pub index: [f64; 3],
}

/// Draws the figure: R, G, B, and the state of the rays in each colour (`state.R`, ..: 0 missed the droplet, 1 left it
/// again, 2 was reflected totally; the highest of a pixel's rays).
pub fn draw(setting: &Setting, colours: &Colours) -> Picture {
    let [width, height] = setting.resolution;
    let row = |y: u32| (0..width).map(move |x| pixel(setting, colours, x, y));
    let pixels: Vec<[(f64, RayState); 3]> = (0..height).into_par_iter().flat_map_iter(row).collect();
    let mut picture = Picture::new(width, height);
    picture.chromaticities = None;
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        picture.push(name, pixels.iter().map(|pixel| pixel[c].0 as f32).collect());
        picture.push(format!("state.{name}"), pixels.iter().map(|pixel| f32::from(pixel[c].1 as u8)).collect());
    }
    picture
}

/// The mean of the pixel's rays.
fn pixel(setting: &Setting, colours: &Colours, x: u32, y: u32) -> [(f64, RayState); 3] {
    let mut sum = [(0.0, RayState::Missed); 3];
    for ray in 0..RAYS * RAYS {
        let offset = |i: u32| (f64::from(i) + 0.5) / f64::from(RAYS);
        let (origin, direction) = setting.ray(f64::from(x) + offset(ray % RAYS), f64::from(y) + offset(ray / RAYS));
        for (sum, (value, state)) in sum.iter_mut().zip(trace(setting, colours, origin, direction)) {
            *sum = (sum.0 + value / f64::from(RAYS * RAYS), sum.1.max(state));
        }
    }
    sum
}

/// A ray that hits the droplet takes the droplet's colour, otherwise the atmosphere's.
fn trace(setting: &Setting, colours: &Colours, origin: DVec3, direction: DVec3) -> [(f64, RayState); 3] {
    match ray_sphere(origin, direction, setting.center, setting.radius) {
        Some((near, _)) if near > 0.0 => {
            let point = origin + near * direction;
            [0, 1, 2].map(|c| surface(setting, &colours.efficiencies[c], colours.index[c], point, direction))
        }
        _ => {
            let lit = atmosphere(setting, origin, direction);
            colours.efficiencies.map(|q| (lit * q.strength(), RayState::Missed))
        }
    }
}

/// The droplet's colour: scattered + refracted.
fn surface(setting: &Setting, q: &Efficiencies, index: f64, point: DVec3, direction: DVec3) -> (f64, RayState) {
    // The light comes along `light` and goes on to the eye, against the ray.
    let scattered = q.intensity(setting.light.dot(-direction));
    match pass_sphere(point, direction, setting.center, setting.radius, index) {
        Passage::Left { point, direction } => {
            // What the refracted ray sees behind: the air. The white light itself is left out.
            let refracted = atmosphere(setting, point, direction) * q.strength();
            (scattered + refracted, RayState::Left)
        }
        Passage::TotalReflection => (scattered, RayState::TotalReflection),
    }
}

/// The atmosphere's light along a ray, theory (89), for a droplet with Q_sca (1 - Q_abs) = 1; it is proportional to that.
///
/// From the farthest sample to the nearest: the droplet's surface light times sigma_s is added, and the sum is multiplied
/// by exp(-sigma_a s), s the interval. What lies behind the droplet is blocked, because no ray gets there unbent.
fn atmosphere(setting: &Setting, origin: DVec3, direction: DVec3) -> f64 {
    let passed = (-setting.sigma_a * setting.interval).exp();
    let mut sum = 0.0;
    for sample in (1..=setting.samples).rev() {
        let point = origin + f64::from(sample) * setting.interval * direction;
        let from_droplet = point - setting.center;
        let distance = from_droplet.length();
        if distance > setting.radius {
            sum += setting.sigma_s * phase(setting.light.dot(from_droplet) / distance);
        }
        sum *= passed;
    }
    sum
}
