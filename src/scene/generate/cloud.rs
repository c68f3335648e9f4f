//! A generated cloud: particles in units of their own, and what surrounds them.

use glam::DVec3;
use serde_json::{Map, Value};

use super::recipe::Form;
use crate::scene::model::{Camera, Particle, ParticleKind, Sun};
use crate::warning::Warning;

/// Particles, camera, sun and settings, ready to be written or to be taken as a scene.
///
/// The vectors are equally long and in one order.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// Centres in cloud units; the longest half side of the shape is 50 to 100.
    pub positions: Vec<[f32; 3]>,
    /// Drawn radii, cloud units.
    pub radii: Vec<f32>,
    /// The droplets' own radii, um; `None` where parcels hold the whole distribution.
    pub droplet_radii_um: Option<Vec<f32>>,
    /// Droplets in each parcel; `None` for droplets.
    pub droplet_counts: Option<Vec<f32>>,
    /// Metres in a cloud unit: a power of two, so that it rounds nothing.
    pub metres_per_unit: f64,
    /// Droplets or parcels.
    pub kind: ParticleKind,
    /// How they are stored.
    pub form: Form,
    /// The camera.
    pub camera: Camera,
    /// The sun.
    pub sun: Sun,
    /// What stands in the scene's `extras.mie_cloud`.
    pub settings: Map<String, Value>,
    /// What stands in the file's `asset.extras.mie_cloud_generator`.
    pub recipe: Value,
    /// What was made.
    pub summary: Summary,
    /// What the recipe left unsaid or asked in vain.
    pub warnings: Vec<Warning>,
}

/// What a cloud came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Number of droplets that the particles stand for.
    pub droplets: f64,
    /// Drawn radius over own radius of droplets; 1 for real droplets and for parcels.
    pub magnification: f64,
    /// Sum of all extinction cross sections at 550 nm, m^2.
    pub extinction_m2: f64,
    /// Optical depth at 550 nm through the centre along the shortest side, averaged over all seeds.
    pub optical_depth: f64,
    /// Optical depth at 550 nm averaged over the shape's shadow along the shortest side.
    pub mean_optical_depth: f64,
    /// Liquid water in the shape that the droplets stand for, g/m^3.
    pub liquid_water_g_per_m3: f64,
}

impl Cloud {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are no particles; never for a cloud that [`generate`](super::generate) made.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The particles in world space, all of class 0.
    pub fn particles(&self) -> impl ExactSizeIterator<Item = Particle> + '_ {
        (0..self.len()).map(|i| Particle {
            center_m: DVec3::from(self.positions[i].map(f64::from)) * self.metres_per_unit,
            radius_m: (f64::from(self.radii[i]) * self.metres_per_unit) as f32,
            droplet_radius_m: self.droplet_radii_um.as_ref().map_or(0.0, |radii| (f64::from(radii[i]) * 1e-6) as f32),
            count: self.droplet_counts.as_ref().map_or(1.0, |counts| counts[i]),
            class: 0,
            kind: self.kind,
        })
    }
}
