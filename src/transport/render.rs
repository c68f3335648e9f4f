//! The picture loop: rounds of samples over all pixels, in parallel, until enough are taken.

use super::random::PathRandom;
use super::sample::{RenderContext, Scratch, take_sample};
use crate::film::{Film, Layer};

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
    /// After this many samples per pixel.
    Samples(u32),
    /// When the noise (`Film::noise`) is at most `target`, or after `at_most` samples per pixel.
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
    /// A row has been finished; `rows` of `of` in this round.
    fn row(&self, _rows: usize, _of: usize) {}
    /// A round has been finished: samples per pixel so far and expected in all, and the picture so far.
    fn round(&self, _samples: u32, _of: u32, _film: &Film) {}
    /// Whether to stop after this round.
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
    /// Samples per pixel that were taken.
    pub samples: u32,
    /// Rays traced.
    pub rays: RayCounts,
    /// Whether it was stopped before it was done.
    pub stopped: bool,
}

/// The first round is short, so that there is something to show and to save at once.
const FIRST_ROUND: u32 = 1;

/// Rounds double up to this many samples per pixel, so that stopping never takes long.
const LONGEST_ROUND: u32 = 16;

/// A handful of samples cannot tell how noisy they are.
const LEAST_FOR_NOISE: u32 = 8;

/// Renders the picture. The same context, seed and crop give the same sums, whatever the number of threads.
pub fn render(ctx: &RenderContext, request: &RenderRequest, progress: &dyn Progress) -> RenderOutcome {
    let n_wavelengths = ctx.media.n_wavelengths();
    let n_spectral = if request.spectral == Spectral::Keep { n_wavelengths } else { 0 };
    let [_, _, width, height] = request.crop;
    let film = Film::new(width, height, &request.layers, n_spectral);
    let mut outcome = RenderOutcome { film, samples: 0, rays: RayCounts::default(), stopped: false };
    let mut round = FIRST_ROUND;
    while !is_done(&outcome, request.until) {
        if outcome.samples > 0 && progress.should_stop() {
            outcome.stopped = true;
            break;
        }
        let last = outcome.samples.saturating_add(round).min(most_samples(request.until));
        let rays = render_round(ctx, request, outcome.samples..last, &mut outcome.film, progress);
        outcome.rays.add(&rays);
        outcome.samples = last;
        let expected = expected_samples(&outcome, request.until);
        round = (2 * round).min(LONGEST_ROUND).min(expected.saturating_sub(outcome.samples).max(1));
        progress.round(outcome.samples, expected, &outcome.film);
    }
    outcome
}

fn most_samples(until: Until) -> u32 {
    match until {
        Until::Samples(n) | Until::Noise { at_most: n, .. } => n,
    }
}

/// Samples per pixel that the picture will take, as far as can be told: noise falls like the root of their number.
fn expected_samples(outcome: &RenderOutcome, until: Until) -> u32 {
    let Until::Noise { target, at_most } = until else { return most_samples(until) };
    let excess = outcome.film.noise() / target;
    let expected = f64::from(outcome.samples) * excess * excess;
    (expected.ceil().min(f64::from(at_most)) as u32).max(LEAST_FOR_NOISE)
}

fn is_done(outcome: &RenderOutcome, until: Until) -> bool {
    outcome.samples >= most_samples(until)
        || match until {
            Until::Samples(_) => false,
            Until::Noise { target, .. } => outcome.samples >= LEAST_FOR_NOISE && outcome.film.noise() <= target,
        }
}

/// Adds the given samples to every pixel.
fn render_round(
    ctx: &RenderContext,
    request: &RenderRequest,
    samples: std::ops::Range<u32>,
    film: &mut Film,
    progress: &dyn Progress,
) -> RayCounts {
    let [left, top, width, height] = request.crop;
    let rows_done = std::sync::atomic::AtomicUsize::new(0);
    let counts = film.par_rows(|row, mut film_row| {
        let mut scratch = Scratch::new(ctx);
        let y = top + row as u32;
        for column in 0..width {
            let x = left + column;
            let pixel = u64::from(y) * u64::from(ctx.resolution[0]) + u64::from(x);
            for sample in samples.clone() {
                let random = PathRandom::new(request.seed, pixel, u64::from(sample));
                let taken = take_sample(ctx, [x, y], &random, &mut scratch);
                film_row.add(column as usize, &taken, &scratch.spectrum);
            }
        }
        let done = rows_done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        progress.row(done, height as usize);
        scratch.rays
    });
    let mut total = RayCounts::default();
    counts.iter().for_each(|rays| total.add(rays));
    total
}
