//! Flights of a path: from where it is to its next collision, or out of everything.
//!
//! Legend: weight_l, the path's integrand over the mean of all heroes' densities (theory (44), (46)); density_h, those
//! densities over their mean.

use super::collision::{Place, Stretch};
use super::glass::balance;
use super::random::PathRandom;
use super::sample::RenderContext;
use super::scratch::Scratch;
use crate::accel::{Body, BodyKind, Crossing, LocalRay};

/// Where the camera ray meets more than this, later flights look only at what lies before their collision: two short
/// searches then cost less than one through everything. Flights of chains cannot be forced to collide then, which is noise.
const CROWDED: usize = 128;

/// Where it meets more than this at a large optical depth, flights of paths do so too: they end soon.
const MANY: usize = 12;

/// That optical depth. In thinner clouds it matters more that flights are stratified: at a depth of 1 they would have 8 % more noise, and take no less time.
const DEEP: f64 = 4.0;

/// Which flights look only at what is near.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crowd {
    /// Those of paths.
    pub near_flights: bool,
    /// Those of chains.
    pub near_chains: bool,
}

impl Crowd {
    /// By what the camera ray meets: `scratch.crossings` and `scratch.total_depth`.
    pub fn of(scratch: &Scratch) -> Self {
        let n = scratch.crossings.len();
        let is_deep = scratch.total_depth[scratch.hero] > DEEP;
        Self { near_flights: n > CROWDED || n > MANY && is_deep, near_chains: n > CROWDED }
    }
}

/// Marks the flights from surfaces of glass apart from those of collisions, and of chains.
pub(super) const SURFACE_FLIGHTS: u32 = 1 << 30;

/// Fills `scratch.crossings` and `scratch.total_depth` with what a ray meets before `scratch.reach_m`.
pub(super) fn meet(ctx: &RenderContext, ray: &LocalRay, scratch: &mut Scratch) {
    let reach_m = scratch.reach_m;
    gather(ctx, ray, reach_m, scratch);
    let Scratch { crossings, path_depth, total_depth, .. } = scratch;
    total_depth.copy_from_slice(path_depth.past(ctx.media, crossings, reach_m));
}

/// Fills `scratch.crossings` with what a ray meets before a distance, chords cut off there. Glass is met otherwise.
fn gather(ctx: &RenderContext, ray: &LocalRay, to_m: f64, scratch: &mut Scratch) {
    let crossings = &mut scratch.crossings;
    crossings.clear();
    ctx.accel.all(ray, 0.0, to_m, |body, crossing| {
        if body.kind() != BodyKind::Glass {
            crossings.push((*body, crossing.before(to_m)));
        }
    });
}

/// The first collision with what was met, given that there is one (theory (43)).
pub(super) fn force(ctx: &RenderContext, ray: &LocalRay, hero: usize, u: f64, scratch: &mut Scratch) -> bool {
    let opacity = -(-scratch.total_depth[hero]).exp_m1();
    if opacity <= 0.0 {
        return false;
    }
    let Some(place) = place_at(ctx, hero, -(-u * opacity).ln_1p(), scratch) else { return false };
    land(ctx, ray, place, ctx.air_transmittance(ray, place.t_m(&scratch.crossings)), scratch);
    let Scratch { density, total_depth, .. } = scratch;
    for (density, depth) in density.iter_mut().zip(total_depth) {
        let opacity = -(-*depth).exp_m1();
        *density = if opacity > 0.0 { *density / opacity } else { 0.0 };
    }
    normalize(scratch)
}

/// A collision, from everything that the ray meets; `false` where the path leaves all of it behind, its weight then being
/// that of the way out.
pub(super) fn fly(ctx: &RenderContext, ray: &LocalRay, hero: usize, u: f64, scratch: &mut Scratch) -> bool {
    scratch.rays.scatter += 1;
    if let Some(body) = ctx.accel.only_fog() {
        return fly_alone(ctx, ray, body, hero, u, scratch);
    }
    meet(ctx, ray, scratch);
    let place = next_place(ctx, hero, u, scratch);
    arrive(ctx, ray, place, scratch)
}

/// To a collision through air, or out of everything; whether there is a collision that a hero could have drawn.
pub(super) fn arrive(ctx: &RenderContext, ray: &LocalRay, place: Option<Place>, scratch: &mut Scratch) -> bool {
    let end_m = place.map_or(scratch.reach_m, |place| place.t_m(&scratch.crossings));
    go(ctx, ray, place, ctx.air_transmittance(ray, end_m), scratch) && place.is_some()
}

/// The same, given what the air lets pass.
pub(super) fn go(ctx: &RenderContext, ray: &LocalRay, place: Option<Place>, air: f64, scratch: &mut Scratch) -> bool {
    match place {
        Some(place) => land(ctx, ray, place, air, scratch),
        None => escape(air, scratch),
    }
    normalize(scratch)
}

/// A collision where one body of fog is all that there is: as `fly`, without lists.
fn fly_alone(ctx: &RenderContext, ray: &LocalRay, body: &Body, hero: usize, u: f64, scratch: &mut Scratch) -> bool {
    let (start, end) = ctx.accel.chord(ray, body).unwrap_or_default();
    let (start, end) = (start.max(0.0), end.min(scratch.reach_m));
    let (load, c_ext_m2) = (f64::from(body.load), ctx.media.c_ext_m2(body.bin()));
    let t_m = start - (1.0 - u).ln() / (load * c_ext_m2[hero]);
    if t_m < end {
        scratch.event.gather_one(ctx.media, ray, t_m, body);
        let air = ctx.air_transmittance(ray, t_m);
        let Scratch { event, weight, density, .. } = scratch;
        for w in 0..weight.len() {
            let passed = (-(t_m - start) * event.sigma[w]).exp();
            weight[w] *= passed * air;
            density[w] *= passed * event.sigma[w];
        }
        return normalize(scratch);
    }
    let way_m = (end - start).max(0.0);
    scratch.total_depth.iter_mut().zip(c_ext_m2).for_each(|(depth, c_ext_m2)| *depth = load * c_ext_m2 * way_m);
    arrive(ctx, ray, None, scratch)
}

/// Where the next collision with what was met is; `None` where the path leaves all of it behind.
pub(super) fn next_place(ctx: &RenderContext, hero: usize, u: f64, scratch: &mut Scratch) -> Option<Place> {
    // 1 - u is exact.
    let target = -(1.0 - u).ln();
    if target < scratch.total_depth[hero] { place_at(ctx, hero, target, scratch) } else { None }
}

/// A collision where much is in the way: the nearest of independent draws for each body, which is the collision of their
/// sum, so that only what lies before it is looked at. `flight` numbers the draws.
pub(super) fn fly_near(
    ctx: &RenderContext,
    ray: &LocalRay,
    hero: usize,
    flight: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> bool {
    scratch.rays.scatter += 1;
    let (media, reach_m) = (ctx.media, scratch.reach_m);
    let hit = ctx.accel.closest(ray, 0.0, None, |body, crossing| {
        if body.kind() == BodyKind::Glass || crossing.start() >= reach_m {
            return None;
        }
        let (u, load) = (random.body(flight, body.id), f64::from(body.load));
        match crossing {
            Crossing::Point(t) => (u < -(-load * media.disc_depth(body.bin())[hero]).exp_m1()).then_some(t),
            Crossing::Chord(t0, t1) => {
                let (start, per_m) = (t0.max(0.0), load * media.c_ext_m2(body.bin())[hero]);
                // 1 - exp(-x) is below x: most bodies are done without a logarithm.
                let t = if u < per_m * (t1 - start) { start - (-u).ln_1p() / per_m } else { f64::INFINITY };
                (t < t1.min(reach_m)).then_some(t)
            }
        }
    });
    let Some(hit) = hit else {
        meet(ctx, ray, scratch);
        return arrive(ctx, ray, None, scratch);
    };
    gather(ctx, ray, hit.t_m.next_up(), scratch);
    let is_disc = ctx.accel.body(hit.index).kind() == BodyKind::Droplet;
    let disc = scratch.crossings.iter().position(|(body, _)| is_disc && body.id == hit.id);
    let place = disc.map_or(Place::Fog(hit.t_m), |index| Place::Disc(index as u32));
    arrive(ctx, ray, Some(place), scratch)
}

/// The weight of a path that meets nothing more before `scratch.reach_m`, given what the air lets pass.
fn escape(air: f64, scratch: &mut Scratch) {
    let Scratch { weight, density, total_depth, .. } = scratch;
    for w in 0..weight.len() {
        let passed = (-total_depth[w]).exp();
        weight[w] *= passed * air;
        density[w] *= passed;
    }
}

/// The place at a hero's optical depth.
fn place_at(ctx: &RenderContext, hero: usize, target: f64, scratch: &mut Scratch) -> Option<Place> {
    let Scratch { crossings, finder, .. } = scratch;
    finder.stretches.clear();
    finder.stretches.extend(crossings.iter().enumerate().filter_map(|(i, met)| Stretch::of(ctx.media, hero, i, met)));
    finder.find(target)
}

/// Multiplies a collision's transmittance and density in, given what the air lets pass.
fn land(ctx: &RenderContext, ray: &LocalRay, place: Place, air: f64, scratch: &mut Scratch) {
    let Scratch { crossings, event, path_depth, weight, density, .. } = scratch;
    event.gather(ctx.media, ray, place, crossings);
    let depth = path_depth.past_discs(ctx.media, crossings, event.t_m, event.disc_id);
    for w in 0..weight.len() {
        let passed = (-depth[w]).exp();
        weight[w] *= passed * air;
        density[w] *= passed * event.sigma[w];
    }
}

/// Divides by the mean density; `false` where no hero could have drawn the path.
pub(super) fn normalize(scratch: &mut Scratch) -> bool {
    balance(&mut scratch.weight, &mut scratch.density)
}
