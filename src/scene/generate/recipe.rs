//! What a cloud is made from: the recipe, complete, and as it is recorded in the file.

use serde_json::{Map, Value, json};

use super::error::GenerateError;
use super::random;
use super::shape::CloudShape;
use super::view::View;
use super::voxels::Voxels;
use crate::optics::distribution::{Shape, SizeDistribution};
use crate::optics::material::Material;
use crate::scene::model::ParticleKind;

/// Everything that decides the bytes of a generated cloud.
///
/// ```
/// use mie_cloud::scene::generate::{CloudShape, Recipe, generate};
/// let recipe = Recipe { count: 100, ..Recipe::new(CloudShape::new("ball", &[1.0])?) };
/// let cloud = generate(&recipe, &|_radius_m| 2.0)?;
/// assert_eq!(cloud.len(), 100);
/// # Ok::<(), mie_cloud::scene::generate::GenerateError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// What the particles fill.
    pub shape: CloudShape,
    /// Number of particles; 1 or more. A [`CloudShape::Droplet`] is always one.
    pub count: u64,
    /// Droplets, or parcels that hold many.
    pub kind: ParticleKind,
    /// The droplets' own radii.
    pub distribution: SizeDistribution,
    /// What droplets are made of.
    pub material: Material,
    /// How much the cloud holds.
    pub content: Content,
    /// Chooses among all clouds that the rest describes.
    pub seed: u64,
    /// How particles are stored.
    pub form: Form,
    /// Radius of parcels over their mean spacing, 0.62 to 4: each point then lies in 4.2 times its cube of them.
    pub overlap: f64,
    /// 0: even; 1: banks with almost clear air between them.
    pub patchiness: f64,
    /// Camera and sun.
    pub view: View,
    /// Further keys for the file's `extras.mie_cloud`, which win over the generator's own.
    pub settings: Map<String, Value>,
    /// The most that making the particles may take of memory, bytes.
    pub memory_limit_bytes: u64,
}

/// How much a cloud holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content {
    /// Droplets as large as they are; parcels with 0.3 g of liquid water per m^3 of the shape.
    Default,
    /// Liquid water per m^3 of the shape, g/m^3.
    LiquidWaterGPerM3(f64),
    /// Optical depth at 550 nm, straight through the centre along the shortest side.
    OpticalDepth(f64),
}

/// How particles are stored in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Form {
    /// A POINTS primitive with `_RADIUS`.
    #[default]
    Points,
    /// Instances of a small sphere (EXT_mesh_gpu_instancing).
    Instances,
}

impl Form {
    /// The name, as in `--as`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Instances => "instances",
        }
    }
}

/// At 1.5 every point lies in 14 parcels on average: density varies by a quarter from point to point, over lengths that a
/// ray crosses many of.
const OVERLAP: f64 = 1.5;

/// The most that a GLB file holds, bytes.
const LARGEST_FILE_BYTES: u64 = 1 << 32;

impl Recipe {
    /// Ten thousand droplets of 6 um effective radius, even, with a camera that frames them.
    pub fn new(shape: CloudShape) -> Self {
        Self {
            view: View::of(&shape),
            shape,
            count: 10_000,
            kind: ParticleKind::Droplet,
            distribution: SizeDistribution::default(),
            material: Material::Water,
            content: Content::Default,
            seed: 0,
            form: Form::Points,
            overlap: OVERLAP,
            patchiness: 0.0,
            settings: Map::new(),
            memory_limit_bytes: u64::MAX,
        }
    }

    /// Number of particles that the cloud will have.
    pub fn particle_count(&self) -> u64 {
        if matches!(self.shape, CloudShape::Droplet { .. }) { 1 } else { self.count }
    }

    /// Checks everything that can be checked before any work is done.
    ///
    /// # Errors
    /// When a value is out of range, or the particles would not fit into a file, or into the memory that may be taken.
    pub fn check(&self) -> Result<(), GenerateError> {
        self.shape.check()?;
        if self.count == 0 {
            return Err(GenerateError::NoParticles);
        }
        match self.content {
            Content::LiquidWaterGPerM3(value) => check_positive("--liquid-water", value)?,
            Content::OpticalDepth(value) => check_positive("--optical-depth", value)?,
            Content::Default => {}
        }
        if !(0.0..=1.0).contains(&self.patchiness) {
            return Err(GenerateError::Patchiness { value: self.patchiness });
        }
        // At 0.62 parcels hold as much space as there is; at 4, a ray crosses a hundred times more than it needs.
        if !(0.62..=4.0).contains(&self.overlap) {
            return Err(GenerateError::Overlap { value: self.overlap });
        }
        self.view.check()?;
        self.check_file()?;
        self.check_memory()
    }

    /// Bytes of memory that making the cloud takes at its peak.
    pub fn memory_bytes(&self) -> u64 {
        // Measured with a margin.
        const FIXED: u64 = 24 << 20;
        let count = self.particle_count();
        let bytes = match self.kind {
            // Cells are there twice while they are gathered, and then beside the particles.
            _ if self.shape.is_grown() => {
                let cells = Voxels::bytes(&self.shape, count);
                cells.saturating_add(cells.max(count.saturating_mul(96)))
            }
            ParticleKind::Droplet => count.saturating_mul(32),
            ParticleKind::Parcel => count.saturating_mul(48),
        };
        bytes.saturating_add(FIXED)
    }

    fn check_memory(&self) -> Result<(), GenerateError> {
        let (count, bytes, limit_bytes) = (self.particle_count(), self.memory_bytes(), self.memory_limit_bytes);
        if bytes > limit_bytes {
            return Err(GenerateError::Memory { count, bytes, limit_bytes });
        }
        Ok(())
    }

    fn check_file(&self) -> Result<(), GenerateError> {
        let count = self.particle_count();
        let bytes_each = match self.form {
            Form::Points => 24,
            Form::Instances => 32,
        };
        // What the JSON of a GLB file and its chunk headers may take of its 4 GiB.
        const RESERVE_BYTES: u64 = 1 << 20;
        let limit_bytes = LARGEST_FILE_BYTES - RESERVE_BYTES;
        let bytes = u128::from(count) * u128::from(bytes_each);
        if bytes > u128::from(limit_bytes) {
            return Err(GenerateError::TooLarge { count, bytes, limit_bytes, max_count: limit_bytes / bytes_each });
        }
        Ok(())
    }

    /// The recipe as it is recorded in `asset.extras.mie_cloud_generator`.
    pub fn to_json(&self) -> Value {
        let mut record = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "random": random::GENERATOR,
            "shape": self.shape.name(),
            "size_m": self.shape.lengths_m(),
            "count": self.particle_count(),
            "kind": kind_name(self.kind),
            "seed": self.seed,
            "as": self.form.name(),
            "overlap": self.overlap,
            "patchiness": self.patchiness,
            "material": self.material.name(),
        });
        if let Some(text) = distribution_text(&self.distribution) {
            record["distribution"] = text.into();
        }
        match self.content {
            Content::Default => {}
            Content::LiquidWaterGPerM3(value) => record["liquid_water_g_per_m3"] = value.into(),
            Content::OpticalDepth(value) => record["optical_depth"] = value.into(),
        }
        record
    }
}

/// The name of a kind, as in `--kind`.
pub fn kind_name(kind: ParticleKind) -> &'static str {
    match kind {
        ParticleKind::Droplet => "droplets",
        ParticleKind::Parcel => "parcels",
    }
}

fn check_positive(flag: &'static str, value: f64) -> Result<(), GenerateError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(GenerateError::Content { flag, value }) }
}

/// A distribution as it is written in settings; `None` for a table, which lives in a file of its own.
pub(super) fn distribution_text(distribution: &SizeDistribution) -> Option<String> {
    match distribution.shape {
        Shape::Table { .. } => None,
        _ => Some(distribution.to_string()),
    }
}
