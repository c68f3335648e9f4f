//! A look at a coarse grid of pixels before the picture: what each estimator costs there, and how much its results scatter.

use rayon::prelude::*;

use super::random::PathRandom;
use super::rates::{Asked, Part, Rates};
use super::sample::{RenderContext, take_sample};
use super::scratch::Scratch;
use crate::film::Sample;

/// Pixels that are looked at, at most: rates are powers of two, so a quarter of the variance or work does not matter.
const MOST_PIXELS: u32 = 512;

/// A grid never has more than one in so many pixels, so that the look takes a few percent of the fewest samples at most.
const EVERY: u32 = 8;

/// Its samples are not those of any picture.
const SEED: u64 = 0x5afe_9119_07d1_7a6b;

/// Work in units of an evaluation in glow's cut (some 4 ns): a ray through a cloud takes 1 to 2 us, a sum 2 us besides its evaluations.
const RAY_WORK: u64 = 400;
const SUM_WORK: u64 = 500;

/// What one pixel has shown of one estimator.
#[derive(Clone, Copy, Default)]
struct Seen {
    squares: f64,
    products: f64,
    work: f64,
}

/// The rates for a scene; even without air, where all work is that of paths.
pub(super) fn find_rates(ctx: &RenderContext) -> Rates {
    let has_parts = ctx.switches.airlight || ctx.glow.is_some() || ctx.max_air_order > 0;
    let pixels = grid(ctx.resolution);
    if !has_parts || ctx.lighting.air.scattering_per_m <= 0.0 || pixels.is_empty() {
        return Rates::EVEN;
    }
    let seen: Vec<[Seen; 5]> =
        pixels.par_iter().map_init(|| Scratch::new(ctx), |scratch, pixel| look(ctx, *pixel, scratch)).collect();
    let of = |i: usize| mean(seen.iter().map(|pixel| pixel[i]));
    Rates::best(of(0), [1, 2, 3, 4].map(of))
}

/// Pixels on a grid over the picture.
fn grid([width, height]: [u32; 2]) -> Vec<[u32; 2]> {
    let most = f64::from(MOST_PIXELS.min(width.saturating_mul(height) / EVERY));
    if most < 1.0 {
        return Vec::new();
    }
    let aspect = f64::from(width) / f64::from(height.max(1));
    let columns = ((most * aspect).sqrt() as u32).clamp(1, width.max(1));
    let rows = ((most / f64::from(columns)) as u32).clamp(1, height.max(1));
    let middle = |i: u32, n: u32, of: u32| ((f64::from(i) + 0.5) * f64::from(of) / f64::from(n)) as u32;
    (0..rows).flat_map(|y| (0..columns).map(move |x| [middle(x, columns, width), middle(y, rows, height)])).collect()
}

/// Two samples of a pixel: of what is always there, and of each estimator besides it.
fn look(ctx: &RenderContext, pixel: [u32; 2], scratch: &mut Scratch) -> [Seen; 5] {
    let number = u64::from(pixel[1]) * u64::from(ctx.resolution[0]) + u64::from(pixel[0]);
    // The first two samples are blocks of their own, so that they are independent.
    let random = [0, 1].map(|sample| PathRandom::new(SEED, number, sample));
    let mut take = |rates: Rates| {
        let ctx = RenderContext { rates, ..*ctx };
        scratch.begin_count();
        let colours = random.each_ref().map(|random| colour(&take_sample(&ctx, pixel, random, scratch)));
        (colours, scratch.work() as f64)
    };
    let (rest, rest_work) = take(Rates::NOTHING);
    let parts = Part::ALL.map(|part| {
        let (both, work) = take(Rates::only(part));
        let own = [0, 1].map(|i| [0, 1, 2].map(|c| both[i][c] - rest[i][c]));
        (own, (work - rest_work).max(0.0))
    });
    let all = [(rest, rest_work), parts[0], parts[1], parts[2], parts[3]];
    all.map(|([first, second], work)| Seen {
        squares: (0..3).map(|c| first[c] * first[c] + second[c] * second[c]).sum::<f64>() / 6.0,
        products: (0..3).map(|c| first[c] * second[c]).sum::<f64>() / 3.0,
        work: 0.5 * work,
    })
}

fn colour(sample: &Sample) -> [f64; 3] {
    [0, 1, 2].map(|c| sample.layers.iter().map(|layer| layer[c]).sum())
}

fn mean(seen: impl ExactSizeIterator<Item = Seen>) -> Asked {
    let n = seen.len() as f64;
    let sum = seen.fold(Asked::default(), |sum, seen| Asked {
        square: sum.square + seen.squares / n,
        mean_square: sum.mean_square + seen.products / n,
        work: sum.work + seen.work / n,
    });
    // The mean of products of two samples can be anything by chance, its expectation cannot.
    Asked { mean_square: sum.mean_square.clamp(0.0, sum.square), ..sum }
}

impl Scratch {
    /// Begins to count work.
    fn begin_count(&mut self) {
        self.rays = super::render::RayCounts::default();
        self.glow.begin_count();
    }

    /// Work since then.
    fn work(&self) -> u64 {
        RAY_WORK * self.rays.total() + SUM_WORK * self.rays.glow_queries + self.glow.evaluations()
    }
}
