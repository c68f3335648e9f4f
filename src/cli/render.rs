//! `mie-cloud render`: a scene in, a picture out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};

use super::args::RenderArgs;
use super::checkpoint::{self, Checkpoints};
use super::failure::{Failure, INTERRUPTED};
use super::identity::{About, identity};
use super::interrupt::Interrupts;
use super::limits::{Stopwatch, peak_rss_bytes};
use super::memory::MemoryLimit;
use super::output::{self, Recipe, Wishes};
use super::previews::Previews;
use super::progress::{Busy, Kept, Shown, Verbosity};
use super::say::say;
use super::scene::{load_scene, print_warnings};
use super::stats::{Seconds, Stats};
use crate::image::Attribute;
use crate::image::file::{Existing, check_writable};
use crate::plan::{self, EffectPlan};
use crate::scene::model::Scene;
use crate::scene::settings::{Effect, Switch};
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::study::trial::STANDARD_TARGET;
use crate::transport::need::{Held, Need};
use crate::transport::{Prepared, RenderOutcome, RenderRequest, RenderState, Stage, Until, go_on};
use crate::warning::Warning;

/// Samples per pixel when nothing asks for an accuracy.
pub const DEFAULT_SPP: u32 = 64;

/// Sampling to an accuracy ends here, whatever the noise.
const MOST_SPP: u32 = 65_536;

/// Runs the command.
pub fn run(args: &RenderArgs) -> Result<u8, Failure> {
    in_thread_pool(args.threads, || run_here(args))?
}

/// Runs `work` in a thread pool of the given size.
pub fn in_thread_pool<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build();
    Ok(pool
        .context("cannot start threads; end other programs, or try --threads 1")
        .map_err(Failure::other)?
        .install(work))
}

fn run_here(args: &RenderArgs) -> Result<u8, Failure> {
    let mut watch = Stopwatch::start();
    let mut seconds = Seconds::default();
    let existing = if args.no_clobber { Existing::Keep } else { Existing::Replace };
    check_outputs(args, existing)?;
    let busy = Busy::with("reading the scene", verbosity(args));
    let (scene, job) = understand(args)?;
    drop(busy);
    seconds.load = watch.lap();
    print_warnings(&scene.warnings, job.verbosity);
    let need = Need::of_render(&scene, &job.plan, &job.sampling, &job.request, held(args, &job.request));
    MemoryLimit::new(args.scene.memory_limit).check(&need)?;
    let prepared = prepare(args, scene, &job, &mut watch, &mut seconds)?;
    say_plan(&job.plan, job.verbosity);

    let ctx = prepared.context();
    let mut state = RenderState::new(&ctx, &job.request);
    if let Some(path) = &args.resume {
        state = checkpoint::resume(path, &job.about, &state, job.request.until)?;
    }
    let keep = |path: &PathBuf| Checkpoints::new(path, &job.about, args.checkpoint_every);
    let checkpoints = args.checkpoint.as_ref().map(keep).transpose()?;
    // Files that must not be replaced are written once.
    let preview = args.preview.as_ref().filter(|_| existing == Existing::Replace);
    let busy = Busy::with("taking a first look", job.verbosity);
    let previews = preview.map(|path| Previews::begin(path, &job.about.recipe, &ctx, &job.request));
    drop(busy);
    // Before this there is nothing to save: an interrupt ends the program, and the previous picture stays as it is.
    let interrupts = Interrupts::listen().context("cannot listen to interrupts").map_err(Failure::other)?;
    let kept_meanwhile = Kept { checkpoints, previews };
    let progress =
        Shown::new(job.verbosity, (&job.request, state.samples()), args.time_limit, interrupts, kept_meanwhile);
    let stopped = go_on(&ctx, &job.request, &mut state, &progress);
    progress.finish();
    seconds.render = watch.lap();

    // The picture is written even where the checkpoint cannot be.
    let kept = progress.keep(&state);
    let part = job.part().filter(|_| !stopped).map(|about| (about, state.clone()));
    let outcome = state.finish(&job.request, stopped);
    let mut picture = output::picture(&outcome.film, &job.about.recipe);
    if let Until::Range { first, end } = job.request.until {
        picture.record("mieCloud:sampleRange", Attribute::Text(format!("{first}..{end}")));
    }
    let part = part.as_ref().map(|(about, state)| (about, state));
    output::write(&args.output, args.preview.as_deref(), &picture, part, existing)?;
    seconds.write = watch.lap();
    seconds.total = watch.total();
    report(args, &job, &prepared, &outcome, seconds, existing)?;
    kept.map_err(|error| Failure::other(anyhow::Error::new(error).context("--checkpoint")))?;
    // A time limit is a way to be done; an interrupt is not.
    let interrupted = outcome.stopped && progress.interrupted();
    if interrupted {
        say_interrupted(args, outcome.samples);
    }
    Ok(if interrupted { INTERRUPTED } else { 0 })
}

/// What is in memory beside one film and its picture.
fn held(args: &RenderArgs, request: &RenderRequest) -> Held {
    let wanted = Wishes::new(args.aov.as_deref(), args.spectral, args.absolute).map_or(0, |wishes| wishes.wanted.len());
    let is_part = matches!(request.until, Until::Range { .. });
    Held {
        // R, G, B, A, and at most three for each that is asked for.
        n_channels: 4 + 3 * wanted,
        n_copies: 1 + u64::from(args.resume.is_some()) + u64::from(is_part),
        n_threads: rayon::current_num_threads(),
    }
}

/// What was saved, and how to go on from it.
fn say_interrupted(args: &RenderArgs, samples: u32) {
    say!("interrupted: {} keeps {samples} samples per pixel", args.output.display());
    match &args.checkpoint {
        Some(path) => say!("go on from here with the same flags and `--resume {}`", path.display()),
        None if args.samples.is_some() => say!("it is not a whole part: `merge` will not take it"),
        None => {}
    }
}

/// What is to be done, as flags and scene say it together.
struct Job {
    verbosity: Verbosity,
    sampling: SpectralSampling,
    plan: EffectPlan,
    request: RenderRequest,
    about: About,
    camera: String,
    scene_warnings: Vec<Warning>,
}

impl Job {
    /// What is recorded with a part of a picture; none where it is a whole one.
    fn part(&self) -> Option<serde_json::Value> {
        let Until::Range { first, end } = self.request.until else { return None };
        serde_json::to_value(About { part: Some([first, end]), ..self.about.clone() }).ok()
    }
}

/// Reads the scene and settles everything that flags and settings decide.
fn understand(args: &RenderArgs) -> Result<(Scene, Job), Failure> {
    // What the flags say is checked before a large scene is read.
    let effects = chosen_effects(args)?;
    let wishes = Wishes::new(args.aov.as_deref(), args.spectral, args.absolute).map_err(Failure::usage)?;
    let mut scene = load_scene(&args.scene, args.resolution)?;
    // Tables and glow are as accurate as the picture is asked to be.
    scene.settings.accuracy.target = args.accuracy.or(scene.settings.accuracy.target);
    let crop = crop(args, scene.settings.image.resolution)?;
    let accuracy = scene.settings.accuracy.target;
    let (target, sampling) = target_and_sampling(&scene);
    check_absolute(args, &sampling)?;
    let plan = plan::plan(&scene, &effects, target, sampling.wavelengths_m.len());
    let request = RenderRequest {
        seed: args.seed,
        until: until(args, accuracy),
        crop,
        layers: wishes.film_layers(),
        spectral: wishes.spectral,
    };
    let recipe = Recipe::new(&scene, &sampling, &request, &wishes);
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

/// Makes tables and tree, and prints what was noticed on the way.
fn prepare(
    args: &RenderArgs,
    scene: Scene,
    job: &Job,
    watch: &mut Stopwatch,
    seconds: &mut Seconds,
) -> Result<Prepared, Failure> {
    let cache = if args.no_cache { None } else { cache_folder() };
    let busy = Busy::with("sorting droplets by size", job.verbosity);
    let mut prepared = Prepared::new(scene, &job.plan, &job.sampling, cache.as_deref(), &mut |stage| match stage {
        Stage::Tables => {
            seconds.load += watch.lap();
            busy.with_next("making tables of how droplets scatter");
        }
        Stage::Bvh => {
            seconds.tables = watch.lap();
            busy.with_next("building the tree of droplets");
        }
        Stage::Ready => seconds.bvh = watch.lap(),
    })
    .map_err(|error| Failure::scene(anyhow::Error::new(error).context(args.scene.scene.display().to_string())))?;
    drop(busy);
    prepared.max_order = args.order.unwrap_or(u32::MAX);
    print_warnings(&prepared.warnings, job.verbosity);
    Ok(prepared)
}

/// Writes the statistics and prints the summary.
fn report(
    args: &RenderArgs,
    job: &Job,
    prepared: &Prepared,
    outcome: &RenderOutcome,
    seconds: Seconds,
    existing: Existing,
) -> Result<(), Failure> {
    let stats = Stats {
        scene: args.scene.scene.display().to_string(),
        camera: job.camera.clone(),
        prepared,
        plan: &job.plan,
        request: &job.request,
        outcome,
        noise: outcome.film.noise(),
        seconds,
        peak_rss_bytes: peak_rss_bytes(),
        warnings: &[&job.scene_warnings[..], &prepared.warnings].concat(),
    };
    if let Some(path) = &args.stats {
        stats.write(path, existing)?;
    }
    if job.verbosity > Verbosity::Quiet {
        say!("{}", stats.summary(&args.output).trim_end());
    }
    Ok(())
}

fn verbosity(args: &RenderArgs) -> Verbosity {
    match (args.quiet, args.verbose) {
        (true, _) => Verbosity::Quiet,
        (_, true) => Verbosity::Verbose,
        _ => Verbosity::Normal,
    }
}

/// Outputs are checked before any work is done.
fn check_outputs(args: &RenderArgs, existing: Existing) -> Result<(), Failure> {
    output::check_kind(&args.output).map_err(Failure::usage)?;
    let outputs: Vec<(&str, &PathBuf)> =
        [("--output", Some(&args.output)), ("--preview", args.preview.as_ref()), ("--stats", args.stats.as_ref())]
            .into_iter()
            .chain([("--checkpoint", args.checkpoint.as_ref())])
            .filter_map(|(flag, path)| path.map(|path| (flag, path)))
            .collect();
    for (i, (flag, path)) in outputs.iter().enumerate() {
        // A checkpoint is there to be replaced.
        let existing = if *flag == "--checkpoint" { Existing::Replace } else { existing };
        check_writable(path, existing).map_err(|error| Failure::other(anyhow::Error::new(error).context(*flag)))?;
        if same_file(path, &args.scene.scene) {
            return Err(Failure::usage(anyhow!("{flag} {}: is the scene itself; name another file", path.display())));
        }
        if *flag != "--checkpoint" && args.resume.as_ref().is_some_and(|resume| same_file(path, resume)) {
            return Err(Failure::usage(anyhow!(
                "{flag} {}: is the checkpoint to go on from; name another file",
                path.display()
            )));
        }
        if let Some((other, _)) = outputs[..i].iter().find(|(_, earlier)| names_same_file(earlier, path)) {
            let error = anyhow!("{other} and {flag} both name {}; give each a file of its own", path.display());
            return Err(Failure::usage(error));
        }
    }
    args.checkpoint.iter().try_for_each(|path| checkpoint::check_kept(path, args.resume.as_deref()))
}

/// Whether two outputs, which need not exist yet, are one file. Devices such as `/dev/null` may be named twice.
pub fn names_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().ok().zip(path.file_name().map(ToOwned::to_owned))
    };
    let is_device = a.metadata().is_ok_and(|metadata| !metadata.is_file());
    !is_device && (same_file(a, b) || (place(a).is_some() && place(a) == place(b)))
}

/// Where optical tables are kept between runs: `$XDG_CACHE_HOME/mie-cloud`, or `~/.cache/mie-cloud`.
pub fn cache_folder() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = folder("XDG_CACHE_HOME").or_else(|| folder("HOME").map(|home| home.join(".cache")));
    base.map(|base| base.join("mie-cloud"))
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
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

fn chosen_effects(args: &RenderArgs) -> Result<BTreeMap<Effect, Switch>, Failure> {
    args.scene.effects.as_deref().map_or(Ok(BTreeMap::new()), super::effects::parse).map_err(Failure::usage)
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

/// What is left out, in a line each; everything with `-v`.
fn say_plan(plan: &EffectPlan, verbosity: Verbosity) {
    if verbosity == Verbosity::Quiet {
        return;
    }
    for decision in &plan.decisions {
        let name = decision.effect.name();
        if verbosity == Verbosity::Verbose {
            let state = if decision.on { "on" } else { "off" };
            say!("effect {name}: {state} ({})", decision.reason);
        } else if !decision.on && decision.matters() {
            say!("left out: {name} ({})", decision.reason);
        }
    }
}
