//! The picture loop: rounds of samples over all pixels, in parallel, until enough are taken.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use super::random::PathRandom;
use super::rounds::{Targets, next_round};
use super::sample::{RenderContext, Scratch, take_sample};
use crate::film::{Film, Layer, Tally};

/// Rays traced, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// When the noise (`Film::noise`) is at most `target`, samples being spent where the noise is, or after `at_most`
    /// samples in every noisy pixel. A target of 0 goes on until it is stopped.
    Noise { target: f64, at_most: u32 },
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

/// Hears how far a picture is, and may end it.
pub trait Progress: Sync {
    /// Some pixels have been finished; samples of all pixels together so far, and expected in all. Called from all threads.
    fn samples(&self, _taken: u64, _expected: u64) {}
    /// A round has been finished: samples of all pixels together so far and expected in all, and the picture so far.
    fn round(&self, _taken: u64, _expected: u64, _film: &Film) {}
    /// Whether to stop now; asked at every tile once each pixel has a sample.
    fn should_stop(&self) -> bool {
        false
    }
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
    let n_wavelengths = ctx.media.n_wavelengths();
    let n_spectral = if request.spectral == Spectral::Keep { n_wavelengths } else { 0 };
    let [_, _, width, height] = request.crop;
    let film = Film::new(width, height, &request.layers, n_spectral);
    let mut outcome = RenderOutcome { film, samples: 0, rays: RayCounts::default(), stopped: false };
    let mut taken = 0;
    while let Some(round) = next_round(&outcome.film, taken, request.until) {
        let stoppable = taken > 0;
        if stoppable && progress.should_stop() {
            outcome.stopped = true;
            break;
        }
        let hears = Hears { progress, stoppable, taken: AtomicU64::new(taken), expected: round.expected };
        outcome.rays.add(&render_round(ctx, request, &round.targets, &mut outcome.film, &hears));
        taken = hears.taken.into_inner();
        progress.round(taken, round.expected, &outcome.film);
    }
    let pixels = u64::from(width) * u64::from(height);
    outcome.samples = u32::try_from((taken + pixels / 2) / pixels.max(1)).unwrap_or(u32::MAX);
    outcome
}

/// What a round tells and asks on the way.
struct Hears<'a> {
    progress: &'a dyn Progress,
    stoppable: bool,
    taken: AtomicU64,
    expected: u64,
}

/// Brings every pixel to its target.
fn render_round(
    ctx: &RenderContext,
    request: &RenderRequest,
    targets: &Targets,
    film: &mut Film,
    hears: &Hears,
) -> RayCounts {
    let empty = film.tally();
    let tools = || (Scratch::new(ctx), empty.clone());
    let counts = film.par_tiles(&tools, |(scratch, tally), tile, mut pixels| {
        // A tile that has been begun is finished.
        let stop = hears.stoppable && hears.progress.should_stop();
        let mut taken = 0;
        for (x, y) in tile.pixels() {
            let samples = pixels.samples(x, y)..targets.of(tile.index, x, y);
            if stop || samples.is_empty() {
                continue;
            }
            taken += samples.len() as u64;
            tally.start(samples.start);
            add_samples(ctx, request, [x as u32, y as u32], samples, (scratch, tally));
            pixels.pour(x, y, tally);
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
