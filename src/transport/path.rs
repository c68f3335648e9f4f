//! `direct` and `multiple`: sunlight, and background, that droplets scatter to the camera once or many times.
//!
//! A path goes from the camera from collision to collision, and looks at the sun from each: straight, and along a chain of
//! small turns (`chain.rs`). One wavelength, the hero, draws everything; every wavelength counts its integrand over the mean
//! of the densities that all heroes would have had for the whole path (theory (44), (46)). The first collision is forced
//! (theory (43)).

use std::f64::consts::TAU;

use glam::DVec3;

use super::chain::{MOST_TURNS, Station, begin_chain, follow_chain, pick_sun};
use super::flight::{Crowd, SURFACE_FLIGHTS, fly, fly_near, force, normalize};
use super::forward::ForwardLobes;
use super::glass::{Ahead, Carried, Ways};
use super::random::{PathRandom, Purpose};
use super::sample::{RenderContext, add_ball_sunlight};
use super::scratch::Scratch;
use super::split;
use crate::accel::LocalRay;
use crate::film::Layer;

/// Least chance of a chain from a collision.
const LEAST_CHANCE: f64 = 0.02;

/// Paths of less weight play Russian roulette.
const ROULETTE_BELOW: f64 = 0.03;

/// Paths of more collisions than this are thinned out, whatever their weight: clouds that people render have few.
pub(super) const LONG_PATH: u32 = 512;

/// Adds the light of one path to the layers; `scratch.crossings` holds what the camera ray meets.
pub(super) fn add_path(ctx: &RenderContext, camera_ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    scratch.begin_path();
    scratch.branches.clear();
    let crowd = Crowd::of(scratch);
    follow_path(ctx, camera_ray, 1, crowd, random, scratch);
    while let Some(branch) = scratch.take_up() {
        follow_path(ctx, &branch.ray, branch.order + 1, crowd, &branch.random, scratch);
    }
}

/// Follows a path from before its collision of the given order to its end; branches that it sends out wait.
fn follow_path(
    ctx: &RenderContext,
    start: &LocalRay,
    first_order: u32,
    crowd: Crowd,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let hero = scratch.hero;
    let mut ray = *start;
    for order in first_order..=ctx.max_order {
        let collided = match order {
            1 => force(ctx, &ray, hero, random.uniform(Purpose::Collision, order), scratch),
            _ => travel(ctx, &mut ray, order, crowd, random, scratch),
        };
        if !collided {
            return;
        }
        let sun = pick_sun(ctx, order, random);
        let layer = match order {
            1 => ctx.switches.direct.then_some(Layer::Direct),
            _ => Some(Layer::Multiple),
        };
        let sun_depth = add_sunlight(ctx, &ray, sun, layer, random, scratch);
        if order == 1 && scratch.leg == 0 {
            note_depth(scratch);
        }
        if order == ctx.max_order || !goes_on(ctx, order, random, scratch) {
            return;
        }
        let most_turns = ctx.max_order - order;
        let layer = Layer::Multiple;
        let station = Station {
            ray: &ray,
            hero,
            order,
            sun,
            sun_depth,
            is_crowded: crowd.near_chains,
            least_chance: LEAST_CHANCE,
            most_turns,
            layer,
        };
        let chain = ctx.lobes.filter(|lobes| {
            let look = |scratch: &mut Scratch, h, rarity, n_turns| scratch.look(ctx, h, rarity, n_turns);
            begin_chain(ctx, lobes, &station, random, scratch, look)
        });
        let next = turn(ctx, &ray, hero, order, random, scratch);
        if let Some(lobes) = chain {
            follow_chain(ctx, lobes, &station, random, scratch);
        }
        ray = next;
        scratch.divide(&ray, order, random);
    }
}

/// Whether a path goes on after a collision.
fn goes_on(ctx: &RenderContext, order: u32, random: &PathRandom, scratch: &mut Scratch) -> bool {
    let u = random.uniform(Purpose::Roulette, order);
    match ctx.guide {
        None => survives(u, order, scratch),
        Some(guide) => split::goes_on(guide.light(scratch.event.point), u, order, LONG_PATH, scratch),
    }
}

/// From one collision to the next, past any glass on the way; `false` where there is none any more.
fn travel(
    ctx: &RenderContext,
    ray: &mut LocalRay,
    order: u32,
    crowd: Crowd,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> bool {
    let hero = scratch.hero;
    let (mut u, mut flight, mut left) = (random.uniform(Purpose::Collision, order), order, None);
    loop {
        let ahead = scratch.look_ahead(ctx, ray, left);
        if !ahead.is_some_and(|ahead| ahead.is_inside) {
            let collided = match crowd.near_flights {
                true => fly_near(ctx, ray, hero, flight, random, scratch),
                false => fly(ctx, ray, hero, u, scratch),
            };
            if collided {
                return true;
            }
        }
        let Some(ahead) = ahead else {
            add_background(ctx, ray, 1.0, scratch);
            return false;
        };
        let Some(next) = pass_glass(ctx, &ahead, ray, Some(Layer::Multiple), random, scratch) else { return false };
        (*ray, left) = (next, Some(ahead.id));
        (u, flight) = (random.uniform(Purpose::Flight, scratch.surfaces), SURFACE_FLIGHTS | scratch.surfaces);
    }
}

/// Past the ball ahead; on the way the path sees the sunlight that it scatters, if it counts in a layer. For chains the path begins anew there: they
/// do not pass glass.
pub(super) fn pass_glass(
    ctx: &RenderContext,
    ahead: &Ahead,
    ray: &LocalRay,
    layer: Option<Layer>,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Option<LocalRay> {
    if let Some(layer) = layer.filter(|_| !ahead.is_inside) {
        let weight = std::mem::take(&mut scratch.weight);
        add_ball_sunlight(ctx, ahead, ray, (layer, &weight), ctx.lobes, random, scratch);
        scratch.weight = weight;
    }
    scratch.is_refracted = true;
    scratch.begin_turns();
    let Scratch { weight, density, surfaces, hero, .. } = scratch;
    let mut carried = Carried { weight, density, hero: *hero, random, surfaces };
    let next = ctx.glass?.pass(ahead, ray, Ways::All, &mut carried)?;
    let survival = survival_of_length(scratch.surfaces, LONG_PATH);
    if random.uniform(Purpose::Surface, scratch.surfaces) >= survival {
        return None;
    }
    scratch.surfaces += 1;
    scratch.weight.iter_mut().for_each(|weight| *weight /= survival);
    Some(next)
}

/// Counts the first collision towards the mean distance of first ones.
fn note_depth(scratch: &mut Scratch) {
    let Scratch { weight, event, depth_sum, depth_weight, .. } = scratch;
    let real = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).sum::<f64>() / weight.len() as f64;
    *depth_sum += real * event.t_m;
    *depth_weight += real;
}

/// The sunlight that the collision sends back along the path, if it counts in a layer; returns the optical depth toward the sun of
/// the given number.
pub(super) fn add_sunlight(
    ctx: &RenderContext,
    ray: &LocalRay,
    sun: usize,
    layer: Option<Layer>,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> f64 {
    let mut sun_depth = 0.0;
    if scratch.weight.iter().all(|weight| *weight <= 0.0) {
        return sun_depth;
    }
    for (i, light) in ctx.lighting.suns.iter().enumerate() {
        let to_sun = scratch.toward(light, random);
        scratch.light_sun(ctx, &LocalRay { origin: scratch.event.point, direction: to_sun });
        if let Some(layer) = layer {
            let layer = scratch.layer(layer);
            scratch.look(ctx, turn_h(ray.direction, to_sun), 0.0, 0);
            let Scratch { weight, sunlit, looked, layers, .. } = scratch;
            for (w, radiance) in layers[layer].iter_mut().enumerate() {
                *radiance += weight[w] * looked[w] * sunlit[w] * light.irradiance[w];
            }
        }
        if i == sun {
            sun_depth = scratch.mean_sun_depth(ctx);
        }
    }
    sun_depth
}

/// The background that an escaping path sees, by a share of its weight.
pub(super) fn add_background(ctx: &RenderContext, ray: &LocalRay, share: f64, scratch: &mut Scratch) {
    if ctx.switches.background {
        let layer = scratch.layer(Layer::Background);
        let Scratch { weight, behind, layers, .. } = scratch;
        ctx.lighting.background_toward(ray.direction, behind);
        for (w, radiance) in layers[layer].iter_mut().enumerate() {
            *radiance += share * weight[w] * behind[w];
        }
    }
}

/// Probability that a path of any weight goes on after a collision.
///
/// In fog without end or absorption as many as n^(-1/2) of all paths reach order n, so that their mean length has no
/// bound. Surviving from n - 1 to n with sqrt(1 - 1/n) leaves 1/n of them, whose weights grow as n^(1/2): the mean length and
/// the variance then both grow with ln n alone.
pub(super) fn survival_of_length(order: u32, long: u32) -> f64 {
    if order <= long { 1.0 } else { (1.0 - 1.0 / f64::from(order)).sqrt() }
}

/// Keeps a path of small weight with a probability in proportion, heavier by as much; very long ones die out.
pub(super) fn survives(u: f64, order: u32, scratch: &mut Scratch) -> bool {
    let Scratch { weight, event, .. } = scratch;
    let largest = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).fold(0.0, f64::max);
    let survival = (largest / ROULETTE_BELOW).min(1.0) * survival_of_length(order, LONG_PATH);
    if u >= survival {
        return false;
    }
    weight.iter_mut().for_each(|weight| *weight /= survival);
    true
}

/// Draws the next direction.
pub(super) fn turn(
    ctx: &RenderContext,
    ray: &LocalRay,
    hero: usize,
    order: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> LocalRay {
    let (u_bin, u_angle) = (random.uniform(Purpose::Bin, order), random.uniform(Purpose::Angle, order));
    let h = scratch.event.sample_h(ctx.media, hero, u_bin, u_angle);
    let direction = around(ray.direction, h, random.uniform(Purpose::Azimuth, order));
    let Scratch { event, weight, density, turned, .. } = scratch;
    event.turn(ctx.media, ctx.lobes, h, turned);
    for w in 0..weight.len() {
        weight[w] *= turned.light[w];
        density[w] *= if event.sigma[w] > 0.0 { turned.drawn[w] / event.sigma[w] } else { 0.0 };
    }
    if let Some(lobes) = ctx.lobes {
        scratch.note_turn(lobes.rarity(h));
    }
    normalize(scratch);
    LocalRay { origin: scratch.event.point, direction }
}

impl Scratch {
    /// A path that has not collided yet.
    pub(super) fn begin_path(&mut self) {
        self.weight.copy_from_slice(&self.seen);
        self.density.copy_from_slice(&self.seen_density);
        self.is_refracted = self.leg > 0;
        self.begin_turns();
    }

    /// No turn yet, so that all may be small.
    fn begin_turns(&mut self) {
        self.small_turns.fill(1.0);
        (self.rarity, self.n_turns) = (0.0, 0);
    }

    /// Fills `looked` with the light that the collision turns by h, where a chain of so many small turns with the given sum of
    /// rarities follows to the sun: all of it but the forward lobe, which longer chains draw; before the longest, all of it. Where all
    /// turns from the camera to the sun are small, and no more than a chain has, the lobe counts too, shared among the collisions
    /// that could have been the one that is not drawn (theory (49), (50)).
    pub(super) fn look(&mut self, ctx: &RenderContext, h: f64, chain_rarity: f64, chain_turns: u32) {
        let Self { event, turned, looked, small_turns, rarity, n_turns, .. } = self;
        event.turn(ctx.media, ctx.lobes, h, turned);
        looked.copy_from_slice(&turned.light);
        if let Some(lobes) = ctx.lobes.filter(|_| chain_turns < MOST_TURNS) {
            let share = share_of_turn(lobes, h, (*rarity + chain_rarity, *n_turns + chain_turns));
            for w in 0..looked.len() {
                looked[w] -= turned.lobe[w] * (1.0 - small_turns[w] * share);
            }
        }
    }

    /// The part of a ball's phase function value that is not left to chains, as `look` has it for droplets.
    pub(super) fn apart_from_chains(&self, lobes: &ForwardLobes, w: usize, h: f64, p: f64) -> f64 {
        let share = share_of_turn(lobes, h, (self.rarity, self.n_turns));
        p - lobes.part(w, h, p) * (1.0 - self.small_turns[w] * share)
    }

    /// Optical depth toward the sun that was looked at last.
    pub(super) fn mean_sun_depth(&self, ctx: &RenderContext) -> f64 {
        let passed = self.sunlit.iter().sum::<f64>() / self.sunlit.len() as f64;
        // Without shadows nothing was asked: one small turn is a fair guess.
        if ctx.switches.shadows { -passed.max(f64::MIN_POSITIVE).ln() } else { 1.0 }
    }

    /// Remembers what share of the path still has nothing but small turns.
    fn note_turn(&mut self, turn_rarity: f64) {
        for (share, (lobe, light)) in self.small_turns.iter_mut().zip(self.turned.lobe.iter().zip(&self.turned.light)) {
            *share *= if *light > 0.0 { lobe / light } else { 0.0 };
        }
        self.rarity += turn_rarity;
        self.n_turns += 1;
    }
}

/// Share of a turn by h that is evaluated, among the other small turns of a path, given the sum of their rarities and their number (theory (49)).
fn share_of_turn(lobes: &ForwardLobes, h: f64, (rarity, n_turns): (f64, u32)) -> f64 {
    let own = lobes.rarity(h);
    if n_turns < MOST_TURNS { own / (own + rarity) } else { 0.0 }
}

/// h = 1 - cos of the angle between two unit vectors, without cancellation between neighbours.
#[inline]
pub(super) fn turn_h(a: DVec3, b: DVec3) -> f64 {
    0.5 * (a - b).length_squared()
}

/// The unit vector at h = 1 - cos from a unit axis, turned about it by `turns` of a full circle.
#[inline]
pub(super) fn around(axis: DVec3, h: f64, turns: f64) -> DVec3 {
    let (u, v) = axis.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (TAU * turns).sin_cos();
    let sin_theta = (h * (2.0 - h)).max(0.0).sqrt();
    let direction = (1.0 - h) * axis + sin_theta * (cos_phi * u + sin_phi * v);
    // One step of Newton's for 1/sqrt of what differs from 1 by rounding: the length stays 1 over any number of turns.
    direction * (1.5 - 0.5 * direction.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_direction_has_the_angle_that_was_asked_for() {
        for axis in [DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 2.0, -3.0).normalize()] {
            for h in [0.0, 1e-14, 1e-6, 0.3, 1.0, 1.9, 2.0] {
                let direction = around(axis, h, 0.37);
                assert!((turn_h(axis, direction) - h).abs() < 1e-9 * h.max(1e-6), "{h}");
            }
        }
    }
}
