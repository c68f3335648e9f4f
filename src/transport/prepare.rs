//! From a planned scene to what the picture loop reads: tables, bodies, tree, light.

use std::path::Path;

use thiserror::Error;

use super::lighting::{Air, Lighting, SunLight};
use super::media::Media;
use super::place::{place_boxes, place_particles};
use super::sample::RenderContext;
use crate::accel::Accel;
use crate::optics::OpticsError;
use crate::optics::bins::BinPlan;
use crate::optics::tables::OpticalTables;
use crate::plan::{EffectPlan, Switches};
use crate::scene::model::{Camera, ParticleKind, Scene};
use crate::scene::settings::{AirPhase, Effect};
use crate::spectrum::{Light, SpectralSampling};
use crate::warning::Warning;

/// A stage that begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Optical tables are computed.
    Tables,
    /// The tree is built.
    Bvh,
    /// Everything is ready to render.
    Ready,
}

/// A scene could not be prepared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// The optical tables could not be made.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// Something that this version cannot render was asked for.
    #[error("{0} is not in this version yet: {1}")]
    NotYet(&'static str, &'static str),
}

/// How much there is of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Droplets and parcels.
    pub particles: usize,
    /// Droplets.
    pub droplets: usize,
    /// Parcels.
    pub parcels: usize,
    /// Fog boxes.
    pub fog_boxes: usize,
    /// Size bins.
    pub size_bins: usize,
    /// Bytes of phase functions and cross sections.
    pub table_bytes: usize,
}

/// A scene that is ready to be rendered.
pub struct Prepared {
    /// Everything that a ray can meet.
    pub accel: Accel,
    /// What it does to light.
    pub media: Media,
    /// The light.
    pub lighting: Lighting,
    /// The camera.
    pub camera: Camera,
    /// What the inner loops simulate.
    pub switches: Switches,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// How much there is of everything.
    pub counts: Counts,
    /// What was noticed on the way.
    pub warnings: Vec<Warning>,
}

impl Prepared {
    /// Prepares a scene; `cache` is a folder for optical tables, `enter` hears which stage begins.
    ///
    /// # Errors
    /// When a material is not known at a wavelength, or a size or phase model is out of range.
    pub fn new(
        mut scene: Scene,
        plan: &EffectPlan,
        sampling: &SpectralSampling,
        cache: Option<&Path>,
        enter: &mut dyn FnMut(Stage),
    ) -> Result<Self, PrepareError> {
        if scene.settings.background.image.is_some() && plan.is_on(Effect::Background) {
            return Err(PrepareError::NotYet("background.image", "use background.radiance or --effects -background"));
        }
        enter(Stage::Tables);
        let wavelengths_m = table_wavelengths(plan, sampling);
        fill_fog(&mut scene)?;
        let bins = bin_plan(&scene)?;
        let tables = OpticalTables::build(&bins, &scene.classes, &wavelengths_m, &scene.settings.accuracy.tables(), cache)?;
        let n_wavelengths = sampling.wavelengths_m.len();
        let media = Media::new(&tables, n_wavelengths, plan.is_on(Effect::Absorption).into());
        let lighting = lighting(&scene, sampling, &wavelengths_m, cache)?;
        let has_air = lighting.air.extinction_per_m > 0.0;

        enter(Stage::Bvh);
        let counts = counts(&scene, &tables);
        let fog_boxes = place_boxes(&scene.fog_boxes, &bins);
        let placed = place_particles(std::mem::take(&mut scene.particles), &bins, &media);
        let accel = Accel::build(placed, &fog_boxes);
        enter(Stage::Ready);
        Ok(Self {
            accel,
            media,
            lighting,
            camera: scene.camera,
            switches: plan.switches(has_air),
            resolution: scene.settings.image.resolution,
            counts,
            warnings: [bins.warnings(), tables.warnings()].concat(),
        })
    }

    /// What every sample reads.
    pub fn context(&self) -> RenderContext<'_> {
        RenderContext {
            accel: &self.accel,
            media: &self.media,
            lighting: &self.lighting,
            camera: &self.camera,
            switches: self.switches,
            resolution: self.resolution,
        }
    }
}
