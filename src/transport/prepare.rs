//! From a planned scene to what the picture loop reads: tables, bodies, tree, light.

use std::path::Path;

use thiserror::Error;

use super::backdrop::{Backdrop, BackdropError, LatLong};
use super::forward::ForwardLobes;
use super::glass::Glass;
use super::glow::Glow;
use super::guide::Guide;
use super::lighting::{Air, Discs, Lighting};
use super::media::{Absorption, Media};
use super::pilot::find_rates;
use super::place::{bin_areas, bin_plan, glass_areas, place_balls, place_boxes, place_particles};
use super::rates::Rates;
use super::sample::RenderContext;
use super::spectral_error::band_error;
use super::wanted_tables::{
    Wavelengths, air_phases, build_tables, cut_peaks, fill_fog, table_settings, table_wavelengths,
};
use crate::accel::Accel;
use crate::optics::count::TableStore;
use crate::optics::tables::{OpticalTables, OpticsError};
use crate::plan::{EffectPlan, Switches, march_steps};
use crate::scene::model::{Camera, ParticleKind, Scene};
use crate::scene::resolved::Resolution;
use crate::scene::settings::{Accuracy, Effect};
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::warning::Warning;

/// The picture's target where the scene sets none.
const DEFAULT_TARGET: f64 = 0.05;

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
    /// The picture behind everything cannot be used.
    #[error(transparent)]
    Backdrop(#[from] BackdropError),
    /// A ball of fog is filled with more droplets than a number can say.
    #[error(
        "particle {index}, a ball of fog, would hold more droplets than can be counted (3e38); lower its density or its radius"
    )]
    FullBall { index: usize },
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
    /// Droplets that are glass, coincident ones counted once.
    pub glass_balls: usize,
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
    /// Droplets that can be seen, where they are glass.
    pub glass: Option<Glass>,
    /// The light.
    pub lighting: Lighting,
    /// What glows, where glow is simulated.
    pub glow: Option<Glow>,
    /// The camera.
    pub camera: Camera,
    /// What the inner loops simulate.
    pub switches: Switches,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Most times that light is scattered by droplets; unlimited unless set.
    pub max_order: u32,
    /// Relative error that was allowed to phase tables.
    pub angle_tolerance: f64,
    /// Relative error that is allowed to glow; none where it is not simulated.
    pub glow_tolerance: Option<f64>,
    /// Estimated relative error of scattered light for want of wavelengths (theory (105)).
    pub band_error: f64,
    /// How often each estimator is asked per sample.
    pub rates: Rates,
    lobes: Option<ForwardLobes>,
    guide: Option<Guide>,
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
        scene: Scene,
        plan: &EffectPlan,
        sampling: &SpectralSampling,
        cache: Option<&Path>,
        enter: &mut dyn FnMut(Stage),
    ) -> Result<Self, PrepareError> {
        Self::with_store(scene, plan, sampling, TableStore { cache, count: None }, enter)
    }

    /// `new`, with a count of the tables that are made.
    ///
    /// # Errors
    /// As `new`.
    pub fn with_store(
        mut scene: Scene,
        plan: &EffectPlan,
        sampling: &SpectralSampling,
        store: TableStore,
        enter: &mut dyn FnMut(Stage),
    ) -> Result<Self, PrepareError> {
        let (backdrop, backdrop_warnings) = backdrop(&scene, plan, sampling)?;
        enter(Stage::Tables);
        let wavelengths = table_wavelengths(plan, sampling);
        fill_fog(&mut scene)?;
        if let Some(index) = scene.particles.iter().position(|particle| !particle.count.is_finite()) {
            return Err(PrepareError::FullBall { index });
        }
        let bins = bin_plan(&scene);
        let angle_tolerance = table_settings(&scene.settings.accuracy, Wavelengths::default(), TableStore::default())
            .accuracy
            .angle_tolerance;
        let absorption = if plan.is_on(Effect::Absorption) { Absorption::Simulated } else { Absorption::LeftOut };
        let tables = build_tables(&scene, &bins, wavelengths, store)?;
        let tables = cut_peaks(tables, scene.settings.accuracy.peak_truncation_deg, absorption);
        let media = Media::new(&tables, sampling.wavelengths_m.len(), absorption);
        let discs = if plan.is_on(Effect::SunDisc) { Discs::Simulated } else { Discs::LeftOut };
        let mut lighting = Lighting::new(&scene, sampling, backdrop, discs, air_phases(&scene, wavelengths, store)?);
        if !plan.follows_suns {
            lighting.suns.clear();
        }
        let has_air = lighting.air.extinction_per_m > 0.0;

        enter(Stage::Bvh);
        let mut counts = counts(&scene, &tables);
        let fog_boxes = place_boxes(&scene.fog_boxes, &bins);
        let resolution = plan.is_on(Effect::Refraction).then(|| Resolution::of(&scene));
        let balls = resolution.as_ref().map_or(Vec::new(), |r| place_balls(&scene.particles, &bins, r));
        let placed = place_particles(std::mem::take(&mut scene.particles), &bins, &media, resolution.as_ref());
        let areas_m2 = bin_areas(&media, &placed, &fog_boxes);
        // Only chains toward a sun draw from it.
        let with_glass: Vec<f64> = areas_m2.iter().zip(glass_areas(&media, &placed)).map(|(a, b)| a + b).collect();
        let lobes = if lighting.suns.is_empty() { None } else { forward_lobes(&media, &with_glass) };
        let in_bands = matches!(sampling.mode(), SpectralMode::Bands { .. }) && plan.is_on(Effect::Dispersion);
        let band_error = if in_bands { band_error(&media, &lighting, &areas_m2, !balls.is_empty()) } else { 0.0 };
        let accel = Accel::build(placed, &fog_boxes);
        let is_lit = plan.is_on(Effect::Glow) && lighting.air.scattering_per_m > 0.0;
        let tolerance = glow_tolerance(&scene.settings.accuracy);
        let shadows = plan.is_on(Effect::Shadows);
        let glow = is_lit.then(|| Glow::new(&accel, &media, &lighting, tolerance, shadows)).flatten();
        let guide = plan.is_on(Effect::Multiple).then(|| Guide::new(&accel, &media, &lighting, &areas_m2)).flatten();
        let glass = Glass::new(&accel, balls, &bins, &scene.classes, &tables, absorption).map_err(OpticsError::from)?;
        let warnings =
            [tables.warnings, backdrop_warnings, march_warning(&lighting.air).into_iter().collect()].concat();
        counts.glass_balls = glass.as_ref().map_or(0, Glass::len);
        let mut prepared = Self {
            accel,
            media,
            glass,
            lighting,
            glow,
            camera: scene.camera,
            switches: plan.switches(has_air),
            resolution: scene.settings.image.resolution,
            max_order: u32::MAX,
            angle_tolerance,
            glow_tolerance: is_lit.then_some(tolerance),
            band_error,
            rates: Rates::EVEN,
            lobes,
            guide,
            counts,
            warnings,
        };
        prepared.rates = find_rates(&prepared.context());
        enter(Stage::Ready);
        Ok(prepared)
    }

    /// Which estimators there is anything to ask, in the order of `Rates::per_sample`.
    pub fn is_asked(&self) -> [bool; 4] {
        let Switches { direct, multiple, airlight, air_multiple, .. } = self.switches;
        [direct || multiple, air_multiple, airlight, self.glow.is_some()]
    }

    /// The same scene without chains of small turns toward the sun: the plain estimator, for comparison.
    pub fn without_chains(self) -> Self {
        Self { lobes: None, ..self }
    }

    /// The same scene without paths that divide where it gets brighter: the plain estimator, for comparison.
    pub fn without_guide(self) -> Self {
        Self { guide: None, ..self }
    }

    /// The same scene, rendered as on a processor without vector instructions; for tests.
    pub fn without_simd(self) -> Self {
        let (glow, glass) = (self.glow.map(Glow::without_simd), self.glass.map(Glass::without_simd));
        Self { accel: self.accel.without_simd(), glow, glass, ..self }
    }

    /// What every sample reads.
    pub fn context(&self) -> RenderContext<'_> {
        RenderContext {
            accel: &self.accel,
            media: &self.media,
            glass: self.glass.as_ref(),
            lobes: self.lobes.as_ref(),
            guide: self.guide.as_ref(),
            lighting: &self.lighting,
            glow: self.glow.as_ref(),
            camera: &self.camera,
            switches: self.switches,
            resolution: self.resolution,
            rates: self.rates,
            max_order: if self.switches.multiple { self.max_order } else { 1 },
            max_air_order: if self.switches.air_multiple { self.max_order } else { 0 },
        }
    }
}

/// What lies behind everything, read only where it is shown.
fn backdrop(
    scene: &Scene,
    plan: &EffectPlan,
    sampling: &SpectralSampling,
) -> Result<(Backdrop, Vec<Warning>), BackdropError> {
    let background = &scene.settings.background;
    let path = background.image.as_ref().filter(|_| plan.is_on(Effect::Background));
    let (image, warnings) = match path.map(|path| LatLong::read(path)).transpose()? {
        Some((image, warnings)) => (Some(image), warnings),
        None => (None, Vec::new()),
    };
    Ok((Backdrop::new(sampling, background.radiance, image), warnings))
}

/// Glow may be wrong by a fifth of the picture's target where none is set for it: it is one of several errors, and
/// rarely the whole picture.
fn glow_tolerance(accuracy: &Accuracy) -> f64 {
    accuracy.glow_tolerance.unwrap_or(0.2 * accuracy.target.unwrap_or(DEFAULT_TARGET))
}

/// Said where the air's march takes longer steps than were asked for.
fn march_warning(air: &Air) -> Option<Warning> {
    let (n_steps, step_m) = march_steps(air.extinction_per_m, air.step_m, air.depth_m);
    (air.scattering_per_m > 0.0 && step_m > air.step_m).then(|| {
        Warning::new(
            format!("the air is marched in {n_steps} steps of {step_m:.3e} m, as many as there may be"),
            "raise atmosphere.step_m or lower atmosphere.depth_m",
        )
    })
}

/// The forward lobe that all droplets have in common, by how much each size bin takes from the light.
fn forward_lobes(media: &Media, areas_m2: &[f64]) -> Option<ForwardLobes> {
    let bins = || (0..media.n_bins()).filter(|bin| areas_m2[*bin] > 0.0);
    let mixture = |w: usize| bins().map(|bin| (areas_m2[bin], &*media.phase(bin)[w])).collect();
    let mixtures: Vec<Vec<_>> = (0..media.n_wavelengths()).map(mixture).collect();
    ForwardLobes::new(&mixtures)
}

fn counts(scene: &Scene, tables: &OpticalTables) -> Counts {
    let droplets = scene.particles.iter().filter(|particle| particle.kind == ParticleKind::Droplet).count();
    Counts {
        particles: scene.particles.len(),
        droplets,
        parcels: scene.particles.len() - droplets,
        fog_boxes: scene.fog_boxes.len(),
        glass_balls: 0,
        size_bins: tables.bins.len(),
        table_bytes: tables.bytes(),
    }
}
