//! What a scene is, once it has been read: everything in world space, metres, f64 where positions need it.

use std::ops::Range;
use std::path::PathBuf;

use glam::{DMat3, DVec3};

use super::settings::Settings;
use crate::optics::DropletClass;
use crate::warning::Warning;

/// Beyond this, double precision no longer resolves a droplet of 100 um, m.
pub const WORLD_LIMIT_M: f64 = 1e12;

/// Radii below this are no droplets but slips of the unit: an atom, m.
pub const SMALLEST_RADIUS_M: f64 = 1e-10;

/// Most droplets that a particle may stand for: their sums stay finite in 32 bits.
pub const MOST_DROPLETS: f64 = 1e36;

/// One droplet or parcel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Centre in world space, m.
    pub center_m: DVec3,
    /// Drawn radius R, m; > 0.
    pub radius_m: f32,
    /// The droplets' own radius r, m; 0 where none is given: a parcel then has the class's distribution, a droplet its drawn
    /// radius.
    pub droplet_radius_m: f32,
    /// Number of droplets; 1 for a droplet, any positive number for a parcel. In balls of fog that are filled by mass or
    /// extinction it is 0 until [`Scene::fill_fog`] has turned these into a number.
    pub count: f32,
    /// Index into `Scene::classes`.
    pub class: u16,
    /// Droplet or parcel.
    pub kind: ParticleKind,
}

impl Particle {
    /// The radius of its droplets, m; none where they have their class's distribution.
    pub fn own_radius_m(&self) -> Option<f64> {
        match self.kind {
            _ if self.droplet_radius_m > 0.0 => Some(f64::from(self.droplet_radius_m)),
            ParticleKind::Droplet => Some(f64::from(self.radius_m)),
            ParticleKind::Parcel => None,
        }
    }
}

/// How a particle removes light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParticleKind {
    /// One droplet, met on its extinction disc.
    Droplet,
    /// A ball filled evenly with droplets.
    Parcel,
}

/// An oriented box filled evenly with droplets.
#[derive(Clone, Debug, PartialEq)]
pub struct FogBox {
    /// Name of the node it came from, shortened.
    pub name: String,
    /// Centre in world space, m.
    pub center_m: DVec3,
    /// Columns are the half edges of the box in world space, m; not necessarily orthogonal.
    pub half_edges_m: DMat3,
    /// How much fog it holds.
    pub density: FogDensity,
    /// Index into `Scene::classes`.
    pub class: u16,
    /// The droplets' own radius, m; `None` takes the class's distribution.
    pub droplet_radius_m: Option<f64>,
}

/// A run of particles (parcels) that are balls of fog, filled evenly to one density.
#[derive(Clone, Debug, PartialEq)]
pub struct FogBalls {
    /// Indices into `Scene::particles`.
    pub particles: Range<usize>,
    /// How much fog each holds per volume.
    pub density: FogDensity,
}

/// How densely a fog body is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FogDensity {
    /// Droplets per cubic metre.
    NumberPerM3(f64),
    /// Grams of condensed matter per cubic metre of air.
    LiquidWaterGPerM3(f64),
    /// Extinction coefficient at 550 nm, 1/m.
    ExtinctionPerM(f64),
}

/// A camera: a frame and a lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the node it came from.
    pub name: String,
    /// Position in world space, m.
    pub position_m: DVec3,
    /// Orthonormal columns: right, up, backward (the camera looks along minus the third).
    pub world_from_camera: DMat3,
    /// The lens.
    pub lens: Lens,
}

/// How pixels become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Vertical field of view, rad. `aspect` (width / height) is kept as the file has it; rays follow the picture's shape.
    Perspective { yfov_rad: f64, aspect: Option<f64> },
    /// Half width and half height of the view, m, which fill the picture whatever its shape.
    Orthographic { xmag_m: f64, ymag_m: f64 },
}

/// A distant light.
#[derive(Clone, Debug, PartialEq)]
pub struct Sun {
    /// Name of the node or light it came from, shortened.
    pub name: String,
    /// Unit vector in which the light travels.
    pub direction: DVec3,
    /// Illuminance on a plane perpendicular to `direction`, lx.
    pub lux: f64,
    /// Linear BT.709 colour of the light; multiplies the channels.
    pub color: [f64; 3],
    /// Spectrum of this light; `None` takes the scene's.
    pub spectrum: Option<crate::spectrum::sun::SunSpectrum>,
    /// Angular diameter in degrees; `None` takes the scene's.
    pub angular_diameter_deg: Option<f64>,
}

/// A scene, ready to be planned and rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where it was read from, as shown to people.
    pub name: String,
    /// Droplets and parcels.
    pub particles: Vec<Particle>,
    /// Balls of fog among the particles that wait for [`Scene::fill_fog`], in the order of particles; empty where all are given by
    /// number.
    pub fog_balls: Vec<FogBalls>,
    /// Fog boxes.
    pub fog_boxes: Vec<FogBox>,
    /// What particles and boxes refer to; never empty.
    pub classes: Vec<DropletClass>,
    /// The camera that takes the picture.
    pub camera: Camera,
    /// The suns; never empty.
    pub suns: Vec<Sun>,
    /// Everything that can be set.
    pub settings: Settings,
    /// What the reader noticed.
    pub warnings: Vec<Warning>,
    /// The files that it needs beside its own: buffers, tables, the background.
    pub files: Vec<PathBuf>,
    /// Content hash of the scene as it was read, with its settings (hexadecimal).
    pub hash: String,
}

impl Scene {
    /// Angular diameter of a sun, degrees: its own, or that of all that name none.
    pub fn sun_diameter_deg(&self, sun: &Sun) -> f64 {
        sun.angular_diameter_deg.unwrap_or(self.settings.sun.angular_diameter_deg)
    }
}
