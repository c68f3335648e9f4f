//! Glow along a camera ray: at every step of the march a sum over all sources, or one that stands for them (`shaded`).

use glam::DVec3;

use super::Glow;
use super::cut::Cut;
use super::exact::{Around, DRAWN_SUNS, Point};
use super::eye::{Bands, Eye};
use super::shaded::{add_one, sum_exactly};
use super::sources::LEAF;
use super::weigh::Item;
use crate::accel::LocalRay;
use crate::film::Layer;
use crate::transport::random::{GlowDraw, PathRandom};
use crate::transport::sample::RenderContext;
use crate::transport::scratch::Scratch;

/// Steps that look at the farthest light, at least: its integral along a ray is that of a smooth function.
const LEAST_STEPS: u32 = 8;

/// Buffers of one thread.
#[derive(Default)]
pub(in crate::transport) struct GlowScratch {
    pub(super) cut: Cut,
    /// Error of a node at which the ray's cuts end.
    pub(super) limit: f32,
    pub(super) bands: Bands,
    /// Added to the step's number, so that every step is as likely to look far.
    phase: u32,
    /// J by wavelength, and one source's.
    pub(super) sum: Vec<f64>,
    pub(super) row: Vec<f64>,
    pub(super) lit: Vec<f32>,
    /// Near droplets of the ray.
    pub(super) near: Vec<usize>,
    pub(super) stack: Vec<u32>,
}

impl Default for Bands {
    fn default() -> Self {
        Self::ALL
    }
}

impl GlowScratch {
    pub fn new(n_wavelengths: usize, n_suns: usize) -> Self {
        Self {
            sum: vec![0.0; n_wavelengths],
            row: vec![0.0; n_wavelengths],
            lit: vec![1.0; n_wavelengths * n_suns],
            ..Self::default()
        }
    }
}

impl GlowScratch {
    /// Begins to count evaluations.
    pub fn begin_count(&mut self) {
        self.cut.evaluations = 0;
    }

    /// Nodes and sources that were looked at since then.
    pub fn evaluations(&self) -> u64 {
        self.cut.evaluations
    }
}

impl<'a> Around<'a> {
    pub fn of(ctx: &RenderContext<'a>) -> Self {
        let camera = ctx.accel.local_ray(ctx.camera.position_m, DVec3::Z).origin;
        Self { accel: ctx.accel, media: ctx.media, lighting: ctx.lighting, camera }
    }
}

impl Glow {
    /// The point as the tree sees it.
    pub(super) fn eye(&self, around: &Around, point: Point, bands: Bands) -> Eye {
        let f32s = |v: DVec3| v.as_vec3().to_array();
        let in_air = (point.at - around.camera) / self.unit_m;
        let depth = around.lighting.air.depth_m / self.unit_m;
        Eye {
            x: f32s((point.at - self.middle) / self.unit_m),
            view: f32s(point.view),
            in_air: f32s(in_air),
            depth_in_air: (in_air.length_squared() - depth * depth) as f32,
            near: (self.near_m / self.unit_m) as f32,
            bands,
            suns: point.suns.map(f32s),
        }
    }
}

/// Prepares the march along a ray from `from_m` to `to_m`: how finely its cuts are made, and how far its steps look.
pub(in crate::transport) fn begin_ray(
    ctx: &RenderContext,
    glow: &Glow,
    ray: &LocalRay,
    [from_m, to_m]: [f64; 2],
    n_steps: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let own = &mut scratch.glow;
    let most = (n_steps / LEAST_STEPS).checked_ilog2().unwrap_or(0);
    let step = (to_m - from_m) / f64::from(n_steps) / glow.unit_m;
    own.bands = Bands { per_unit: (1.0 / step) as f32, last: most as i32, most: most as i32 };
    own.phase = (random.glow(GlowDraw::Phase, 0) * f64::from(1u32 << most)) as u32;
    if glow.n_in_tree == 0 || glow.tolerance == 0.0 {
        return;
    }
    // Where the ray is nearest to the cloud's middle the sum is largest, as a rule.
    let t_m = (glow.middle - ray.origin).dot(ray.direction).clamp(from_m, to_m);
    let around = Around::of(ctx);
    let point = Point::new(ctx.lighting, ray.origin + t_m * ray.direction, ray.direction, |_| 0.0);
    let eye = glow.eye(&around, point, Bands::ALL);
    let tolerance = glow.tolerance as f32;
    own.limit = glow.arch.dispatch(
        #[inline(always)]
        || own.cut.refine(glow, &eye, tolerance),
    );
    scratch.rays.glow_queries += 1;
}

/// Adds what glows at one step of the march, numbered `step` on its path, at `t_m`; `scratch.weight` has how it is seen.
pub(in crate::transport) fn add_step(
    ctx: &RenderContext,
    glow: &Glow,
    ray: &LocalRay,
    t_m: f64,
    step: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    if glow.n_in_tree == 0 {
        return;
    }
    scratch.rays.glow_queries += 1;
    let around = Around::of(ctx);
    let on_disc = |i: u32| random.glow(GlowDraw::Disc, step.wrapping_mul(2 * DRAWN_SUNS as u32).wrapping_add(i));
    let point = Point::new(ctx.lighting, ray.origin + t_m * ray.direction, ray.direction, on_disc);
    scratch.glow.sum.fill(0.0);
    if glow.tolerance == 0.0 {
        sum_exactly(ctx, glow, &around, point, step, random, scratch);
    } else {
        sum_by_cut(ctx, glow, &around, point, step, random, scratch);
    }
    let layer = scratch.layer(Layer::Glow);
    let Scratch { weight, layers, glow: own, .. } = scratch;
    for (w, radiance) in layers[layer].iter_mut().enumerate() {
        *radiance += weight[w] * own.sum[w];
    }
}

fn sum_by_cut(
    ctx: &RenderContext,
    glow: &Glow,
    around: &Around,
    point: Point,
    step: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let own = &mut scratch.glow;
    let last = ((step.wrapping_add(own.phase)).trailing_zeros() as i32).min(own.bands.most);
    let eye = glow.eye(around, point, Bands { last, ..own.bands });
    let limit = own.limit;
    glow.arch.dispatch(
        #[inline(always)]
        || own.cut.take(glow, &eye, limit),
    );
    if glow.shadows {
        let u = [random.glow(GlowDraw::Pick, step), random.glow(GlowDraw::Member, step)];
        add_one(ctx, glow, around, point, &eye, step, random, u, scratch);
    } else {
        add_all(glow, around, point, &eye, step, random, &mut scratch.glow);
    }
}

/// Adds every item of the cut; what is in the way is left out.
fn add_all(
    glow: &Glow,
    around: &Around,
    point: Point,
    eye: &Eye,
    step: u32,
    random: &PathRandom,
    own: &mut GlowScratch,
) {
    let GlowScratch { cut, sum, row, limit, .. } = own;
    glow.arch.dispatch(
        #[inline(always)]
        || glow.sum_items(around, eye, cut, *limit, sum),
    );
    for item in cut.items.iter().filter(|item| item.is_leaf && item.error > *limit) {
        let slot = glow.slot_of(item);
        let seen = glow.draw_point(around, point, slot, fog_draws(glow, around, random, step, slot));
        if glow.source_light(around, point, slot, glow.near_m, seen, None, row).is_some() {
            let thinned = f64::from(band_weight(eye, glow, item));
            sum.iter_mut().zip(&*row).for_each(|(sum, row)| *sum += thinned * row);
        }
    }
}

impl Glow {
    /// Adds J of all items but fog that is too near.
    #[inline(always)]
    pub(super) fn sum_items(&self, around: &Around, eye: &Eye, cut: &Cut, limit: f32, sum: &mut [f64]) {
        let items = || cut.items.iter().filter(|item| !(item.is_leaf && item.error > limit));
        if self.is_plain {
            sum[0] += self.scale * items().map(|item| f64::from(item.light)).sum::<f64>();
            return;
        }
        let before: Vec<f64> = sum.to_vec();
        sum.fill(0.0);
        items().for_each(|item| self.add_light(around.accel, around.lighting, eye, item, sum));
        sum.iter_mut().zip(before).for_each(|(sum, before)| *sum = before + self.scale * *sum);
    }
}

/// How often an item of fog counts for steps that do not look.
pub(super) fn band_weight(eye: &Eye, glow: &Glow, item: &Item) -> f32 {
    let (octet, k) = (&glow.tree.octets[item.node as usize / LEAF], item.node as usize % LEAF);
    let [x, y, z] = [eye.x[0] - octet.x[k], eye.x[1] - octet.y[k], eye.x[2] - octet.z[k]];
    eye.bands.weight((x * x + y * y + z * z).sqrt())
}

/// Three numbers for a place in a parcel or box of fog.
pub(super) fn fog_draws(glow: &Glow, around: &Around, random: &PathRandom, step: u32, slot: usize) -> [f64; 3] {
    let id = around.accel.body(glow.slots[slot].body).id;
    [0, 1, 2].map(|draw| random.glow_body(step, draw, id))
}
