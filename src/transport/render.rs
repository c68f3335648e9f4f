//! The picture loop: rounds of samples over all pixels, in parallel, until enough are taken.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use super::random::PathRandom;
use super::rounds::Targets;
use super::sample::{RenderContext, take_sample};
use super::scratch::Scratch;
use super::state::RenderState;
use crate::film::{Film, Layer, Tally, nodes_of};

/// Rays traced, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayCounts {
    /// Camera rays.
    pub camera: u64,
    /// Rays from one collision to the next.
    pub scatter: u64,
    /// Camera rays that go on behind glass.
    pub refracted: u64,
    /// Rays toward a sun.
    pub shadow: u64,
    /// Sums over all droplets at a point of the air.
    pub glow_queries: u64,
}

impl RayCounts {
    /// All rays together.
    pub fn total(&self) -> u64 {
        self.camera + self.scatter + self.refracted + self.shadow
    }

    fn add(&mut self, other: &RayCounts) {
        self.camera += other.camera;
        self.scatter += other.scatter;
        self.refracted += other.refracted;
        self.shadow += other.shadow;
        self.glow_queries += other.glow_queries;
    }
}

/// When a picture is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// After this many samples in every pixel.
    Samples(u32),
    /// After these samples in every pixel, a part of a picture. The range must cut no block (`film::is_whole`).
    Range { first: u32, end: u32 },
    /// When the noise (`Film::noise`) is at most `target`, samples being spent where the noise is, or after `at_most`
    /// samples in every noisy pixel. A target of 0 goes on until it is stopped.
    Noise { target: f64, at_most: u32 },
}

impl Until {
    /// The runs of samples that are summed apart, since they do not join in the order in which they are taken.
    pub(super) fn runs(self) -> Vec<Range<u32>> {
        match self {
            Self::Samples(n) => std::iter::once(0..n).collect(),
            Self::Noise { at_most, .. } => std::iter::once(0..at_most).collect(),
            Self::Range { first, end } => nodes_of(first..end),
        }
    }
}

/// What is to be rendered of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderRequest {
    /// Seed of all random numbers.
    pub seed: u64,
    /// When to stop.
    pub until: Until,
    /// Left, top, width, height of the part to render, pixels.
    pub crop: [u32; 4],
    /// Layers to keep apart.
    pub layers: Vec<Layer>,
    /// Whether radiance is kept by wavelength.
    pub spectral: Spectral,
}

/// Whether radiance is kept by wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spectral {
    /// Channels only.
    Discard,
    /// Radiance at every rendered wavelength.
    Keep,
}

/// Hears how far a picture is, and may pause or end it.
pub trait Progress: Sync {
    /// Some pixels have been finished; samples of all pixels together so far, and expected in all. Called from all threads.
    fn samples(&self, _taken: u64, _expected: u64) {}
    /// A round has been finished: samples of all pixels together so far and expected in all, and the picture so far.
    fn round(&self, _taken: u64, _expected: u64, _film: &Film) {}
    /// Whether to stop now; asked at every tile once each pixel has a sample.
    fn should_stop(&self) -> bool {
        false
    }
    /// Whether to pause now; asked at every tile.
    fn should_pause(&self) -> bool {
        false
    }
    /// All threads rest: time to keep a copy of what there is.
    fn pause(&self, _state: &RenderState) {}
}

/// Hears nothing and never stops.
pub struct SilentProgress;

impl Progress for SilentProgress {}

/// A finished or stopped picture.
pub struct RenderOutcome {
    /// The sums.
    pub film: Film,
    /// Samples per pixel that were taken, on average.
    pub samples: u32,
    /// Rays traced.
    pub rays: RayCounts,
    /// Whether it was stopped before it was done.
    pub stopped: bool,
}

/// Renders the picture. The same context, seed and crop give the same sums, whatever the number of threads.
///
/// A round brings every pixel to a number of samples that is settled before it begins. Where the render is stopped within a
/// round, some pixels have more samples than others; their sums are complete all the same.
pub fn render(ctx: &RenderContext, request: &RenderRequest, progress: &dyn Progress) -> RenderOutcome {
    let mut state = RenderState::new(ctx, request);
    let stopped = go_on(ctx, request, &mut state, progress);
    state.finish(request, stopped)
}

/// Goes on with a render of the same context and request, and returns whether it was stopped before it was done. The state
/// at the end does not depend on how often it was paused or stopped on the way.
pub fn go_on(ctx: &RenderContext, request: &RenderRequest, state: &mut RenderState, progress: &dyn Progress) -> bool {
    let runs = request.until.runs();
    while let Some(run) = runs.get(state.current()) {
        if !finish_run(ctx, request, run, state, progress) {
            return true;
        }
        if state.current() + 1 == runs.len() {
            break;
        }
        state.begin_run();
    }
    false
}

/// Takes the samples of a run, round by round; false where it was stopped.
fn finish_run(
    ctx: &RenderContext,
    request: &RenderRequest,
    run: &Range<u32>,
    state: &mut RenderState,
    progress: &dyn Progress,
) -> bool {
    while let Some(round) = state.begin_round(request.until, run) {
        loop {
            let stoppable = state.is_covered();
            if stoppable && progress.should_stop() {
                return false;
            }
            let hears = Hears::new(progress, stoppable, state.samples(), round.expected);
            let rays = render_round(ctx, request, run.start, &round.targets, state.film(), &hears);
            state.rays.add(&rays);
            if !hears.broke_off.into_inner() {
                break;
            }
            if progress.should_pause() {
                progress.pause(state);
            }
        }
        state.end_round();
        progress.round(state.samples(), round.expected, state.film());
        // Within a round a pause comes between tiles; a picture may have one only.
        if progress.should_pause() {
            progress.pause(state);
        }
    }
    true
}

/// What a round tells and asks on the way.
struct Hears<'a> {
    progress: &'a dyn Progress,
    stoppable: bool,
    taken: AtomicU64,
    expected: u64,
    /// Whether a tile has been done: a pause comes after some work, however often it is asked for.
    worked: AtomicBool,
    /// Whether a tile has been left out.
    broke_off: AtomicBool,
}

impl<'a> Hears<'a> {
    fn new(progress: &'a dyn Progress, stoppable: bool, taken: u64, expected: u64) -> Self {
        let (worked, broke_off) = (AtomicBool::new(false), AtomicBool::new(false));
        Self { progress, stoppable, taken: AtomicU64::new(taken), expected, worked, broke_off }
    }

    fn breaks_off(&self) -> bool {
        let stop = self.stoppable && self.progress.should_stop();
        stop || self.worked.load(Ordering::Relaxed) && self.progress.should_pause()
    }
}

/// Brings every pixel to its target, unless it is broken off.
fn render_round(
    ctx: &RenderContext,
    request: &RenderRequest,
    first: u32,
    targets: &Targets,
    film: &mut Film,
    hears: &Hears,
) -> RayCounts {
    let empty = film.tally();
    let tools = || (Scratch::new(ctx), empty.clone());
    let counts = film.par_tiles(&tools, |(scratch, tally), tile, mut pixels| {
        // A tile that has been begun is finished.
        let break_off = hears.breaks_off();
        let mut taken = 0;
        for (x, y) in tile.pixels() {
            let samples = pixels.samples(x, y)..targets.of(tile.index, x, y);
            if samples.is_empty() {
                continue;
            }
            if break_off {
                hears.broke_off.store(true, Ordering::Relaxed);
                break;
            }
            taken += samples.len() as u64;
            let samples = first.saturating_add(samples.start)..first.saturating_add(samples.end);
            tally.start(samples.start);
            add_samples(ctx, request, [x as u32, y as u32], samples, (scratch, tally));
            pixels.pour(x, y, tally);
        }
        if taken > 0 {
            hears.worked.store(true, Ordering::Relaxed);
        }
        let so_far = taken + hears.taken.fetch_add(taken, Ordering::Relaxed);
        hears.progress.samples(so_far, hears.expected);
        std::mem::take(&mut scratch.rays)
    });
    let mut total = RayCounts::default();
    counts.iter().for_each(|rays| total.add(rays));
    total
}

/// Takes samples of a pixel of the crop.
fn add_samples(
    ctx: &RenderContext,
    request: &RenderRequest,
    [column, row]: [u32; 2],
    samples: Range<u32>,
    (scratch, tally): (&mut Scratch, &mut Tally),
) {
    let [left, top, ..] = request.crop;
    let (x, y) = (left + column, top + row);
    let pixel = u64::from(y) * u64::from(ctx.resolution[0]) + u64::from(x);
    for sample in samples {
        let random = PathRandom::new(request.seed, pixel, sample);
        let taken = take_sample(ctx, [x, y], &random, scratch);
        tally.add(&taken, &scratch.spectrum);
    }
}
