//! `mie-cloud render`: a scene in, a picture out.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread::available_parallelism;
use std::time::Duration;

use anyhow::Context;

use super::args::RenderArgs;
use super::busy::Busy;
use super::checkpoint::{self, Checkpoints};
use super::claims::{self, check_outputs};
use super::failure::{Failure, INTERRUPTED};
use super::interrupt::Interrupts;
use super::job::{Job, understand, verbosity};
use super::limits::{Stopwatch, cache_folder, peak_rss_bytes};
use super::memory::MemoryLimit;
use super::output::{self, Wishes};
use super::previews::Previews;
use super::progress::{Kept, Shown, TimeLimit, Verbosity};
use super::say::say;
use super::scene::print_warnings;
use super::stats::{Seconds, Stats};
use crate::image::Attribute;
use crate::image::file::Existing;
use crate::optics::count::{TableCount, TableStore};
use crate::plan::EffectPlan;
use crate::scene::model::Scene;
use crate::transport::need::{Held, Need};
use crate::transport::{Prepared, RenderOutcome, RenderRequest, RenderState, Stage, Until, go_on};

/// Runs the command.
pub fn run(args: &RenderArgs) -> Result<u8, Failure> {
    in_thread_pool(args.threads, || run_here(args))?
}

/// A thread's stack: as much as threads have unless told otherwise. What recurses is bounded.
const STACK_BYTES: usize = 2 << 20;

/// Runs `work` in a thread pool of the given size, or of one thread per processor.
pub fn in_thread_pool<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    // Neither depends on the environment, which may ask for anything.
    let threads = threads.map_or_else(|| available_parallelism().map_or(1, NonZeroUsize::get), usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK_BYTES).build();
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
    claims::outputs(args).spare_files(&scene.files)?;
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
    let kept_rays = state.rays().total();
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
    let limit = args.time_limit.map(|s| TimeLimit { from: watch.began(), length: Duration::from_secs_f64(s) });
    if limit.is_some_and(|limit| limit.is_over()) && job.verbosity > Verbosity::Quiet {
        say!("--time-limit: it is over before the first sample; the picture gets as few as can be");
    }
    let progress = Shown::new(job.verbosity, (&job.request, state.samples()), limit, interrupts, kept_meanwhile);
    let stopped = go_on(&ctx, &job.request, &mut state, &progress);
    progress.finish();
    seconds.render = watch.lap();

    // Each file is written even where another cannot be.
    let kept = progress.keep(&state);
    let part = job.part().filter(|_| !stopped).map(|about| (about, state.clone()));
    let outcome = state.finish(&job.request, stopped);
    let mut picture = output::picture(&outcome.film, &job.about.recipe);
    if let Until::Range { first, end } = job.request.until {
        picture.record("mieCloud:sampleRange", Attribute::Text(format!("{first}..{end}")));
    }
    let part = part.as_ref().map(|(about, state)| (about, state));
    let written = output::write(&args.output, args.preview.as_deref(), &picture, part, existing);
    seconds.write = watch.lap();
    seconds.total = watch.total();
    let rays_now = outcome.rays.total().saturating_sub(kept_rays);
    let stats = stats(args, &job, &prepared, (&outcome, rays_now), seconds);
    let recorded = args.stats.as_ref().map_or(Ok(()), |path| stats.write(path, existing));
    written?;
    if job.verbosity > Verbosity::Quiet {
        say!("{}", stats.summary(&args.output).trim_end());
    }
    recorded?;
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
    let plural = if samples == 1 { "" } else { "s" };
    say!("interrupted: {} keeps {samples} sample{plural} per pixel", args.output.display());
    match &args.checkpoint {
        Some(path) => say!("go on from here with the same flags and `--resume {}`", path.display()),
        None if args.samples.is_some() => say!("it is not a whole part: `merge` will not take it"),
        None => {}
    }
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
    let count = TableCount::default();
    let store = TableStore { cache: cache.as_deref(), count: Some(&count) };
    let mut enter = |stage| match stage {
        Stage::Tables => {
            seconds.load += watch.lap();
            busy.with_next("making tables of how droplets scatter");
        }
        Stage::Bvh => {
            seconds.tables = watch.lap();
            busy.with_next("building the tree of droplets");
        }
        Stage::Ready => seconds.bvh = watch.lap(),
    };
    let prepared = busy.counting(&count, || Prepared::with_store(scene, &job.plan, &job.sampling, store, &mut enter));
    let mut prepared = prepared
        .map_err(|error| Failure::scene(anyhow::Error::new(error).context(args.scene.scene.display().to_string())))?;
    drop(busy);
    prepared.max_order = args.order.unwrap_or(u32::MAX);
    print_warnings(&prepared.warnings, job.verbosity);
    Ok(prepared)
}

/// What is known about a render that is done.
fn stats<'a>(
    args: &RenderArgs,
    job: &'a Job,
    prepared: &'a Prepared,
    (outcome, rays_now): (&'a RenderOutcome, u64),
    seconds: Seconds,
) -> Stats<'a> {
    Stats {
        scene: args.scene.scene.display().to_string(),
        camera: job.camera.clone(),
        prepared,
        plan: &job.plan,
        request: &job.request,
        outcome,
        rays_now,
        noise: outcome.film.noise(),
        seconds,
        peak_rss_bytes: peak_rss_bytes(),
        warnings: [&job.scene_warnings[..], &prepared.warnings].concat(),
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
