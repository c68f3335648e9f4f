//! What a render is asked to do, as flags and scene say it together.

use anyhow::anyhow;

use super::args::RenderArgs;
use super::effects;
use super::failure::Failure;
use super::identity::{About, identity};
use super::output::{Recipe, Wishes};
use super::progress::Verbosity;
use super::scene::load_scene;
use crate::image::spectral::channel_name;
use crate::plan::{self, EffectPlan};
use crate::scene::model::Scene;
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::study::trial::{MOST_SPP, STANDARD_TARGET};
use crate::transport::{RenderRequest, Spectral, Until};
use crate::warning::Warning;

/// Samples per pixel when nothing asks for an accuracy.
pub const DEFAULT_SPP: u32 = 64;

/// What is to be done.
pub struct Job {
    pub verbosity: Verbosity,
    pub sampling: SpectralSampling,
    pub plan: EffectPlan,
    pub request: RenderRequest,
    pub about: About,
    pub camera: String,
    pub scene_warnings: Vec<Warning>,
}

impl Job {
    /// What is recorded with a part of a picture; none where it is a whole one.
    pub fn part(&self) -> Option<serde_json::Value> {
        let Until::Range { first, end } = self.request.until else { return None };
        serde_json::to_value(About { part: Some([first, end]), ..self.about.clone() }).ok()
    }
}

/// Reads the scene and settles everything that flags and settings decide.
pub fn understand(args: &RenderArgs) -> Result<(Scene, Job), Failure> {
    // What the flags say is checked before a large scene is read.
    let effects = effects::chosen(args.scene.effects.as_deref())?;
    let wishes = Wishes::new(args.aov.as_deref(), args.spectral, args.absolute).map_err(Failure::usage)?;
    let mut scene = load_scene(&args.scene, args.resolution)?;
    // Tables and glow are as accurate as the picture is asked to be.
    scene.settings.accuracy.target = args.accuracy.or(scene.settings.accuracy.target);
    let crop = crop(args, scene.settings.image.resolution)?;
    let accuracy = scene.settings.accuracy.target;
    let (target, sampling) = target_and_sampling(&scene);
    check_absolute(args, &sampling)?;
    check_spectral(&wishes, &sampling)?;
    let plan = plan::plan(&scene, &effects, target, sampling.wavelengths_m.len());
    scene.warnings.extend(plan.warnings());
    let request = RenderRequest {
        seed: args.seed,
        until: until(args, accuracy),
        crop,
        layers: wishes.film_layers(),
        spectral: wishes.spectral,
    };
    let recipe = Recipe::new(&scene, (&plan, args.order), &sampling, &request, &wishes);
    let identity = identity(&scene, &sampling, &plan, &request, (target, args.order)).map_err(Failure::scene)?;
    let about = About { identity, recipe, part: None };
    let (camera, scene_warnings) = (scene.camera.name.clone(), scene.warnings.clone());
    let verbosity = verbosity(args);
    Ok((scene, Job { verbosity, sampling, plan, request, about, camera, scene_warnings }))
}

/// The picture's relative error that is aimed at, and how the spectrum is sampled for it.
pub fn target_and_sampling(scene: &Scene) -> (f64, SpectralSampling) {
    let target = scene.settings.accuracy.target.unwrap_or(STANDARD_TARGET);
    let mode = scene.settings.spectral_mode.unwrap_or(SpectralMode::Bands { count: plan::bands_for(target) });
    (target, SpectralSampling::new(mode, scene.settings.sun.spectrum))
}

fn crop(args: &RenderArgs, [width, height]: [u32; 2]) -> Result<[u32; 4], Failure> {
    let Some([x, y, w, h]) = args.crop else { return Ok([0, 0, width, height]) };
    let inside = |start: u32, size: u32, full: u32| start.checked_add(size).is_some_and(|end| end <= full);
    if inside(x, w, width) && inside(y, h, height) {
        return Ok([x, y, w, h]);
    }
    Err(Failure::usage(anyhow!(
        "--crop {x},{y},{w},{h} reaches outside the picture of {width}x{height} pixels; X+W may be {width} at most, Y+H {height}"
    )))
}

fn check_absolute(args: &RenderArgs, sampling: &SpectralSampling) -> Result<(), Failure> {
    if args.absolute && !matches!(sampling.mode(), SpectralMode::Bands { .. }) {
        return Err(Failure::usage(anyhow!(
            "--absolute needs the `bands` mode: {} has no luminance; use --set spectral.mode=bands:8",
            sampling.mode()
        )));
    }
    Ok(())
}

/// One channel of the picture is named after each wavelength.
fn check_spectral(wishes: &Wishes, sampling: &SpectralSampling) -> Result<(), Failure> {
    if wishes.spectral == Spectral::Discard {
        return Ok(());
    }
    let names: Vec<String> = sampling.wavelengths_m.iter().map(|m| channel_name(m * 1e9)).collect();
    match names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        None => Ok(()),
        Some((_, name)) => Err(Failure::usage(anyhow!(
            "--spectral needs wavelengths that differ: {} has two of the channel `{name}`; change spectral.mode, or leave out --spectral",
            sampling.mode()
        ))),
    }
}

fn until(args: &RenderArgs, accuracy: Option<f64>) -> Until {
    if let Some([first, end]) = args.samples {
        return Until::Range { first, end };
    }
    match (args.spp, args.noise.or(accuracy)) {
        (Some(spp), _) => Until::Samples(spp),
        (None, Some(target)) => Until::Noise { target, at_most: MOST_SPP },
        (None, None) if args.time_limit.is_some() => Until::Noise { target: 0.0, at_most: MOST_SPP },
        (None, None) => Until::Samples(DEFAULT_SPP),
    }
}

/// How much is said.
pub fn verbosity(args: &RenderArgs) -> Verbosity {
    match (args.quiet, args.verbose) {
        (true, _) => Verbosity::Quiet,
        (_, true) => Verbosity::Verbose,
        _ => Verbosity::Normal,
    }
}
