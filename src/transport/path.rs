//! `direct` and `multiple`: sunlight, and background, that droplets scatter to the camera once or many times.
//!
//! A path goes from the camera from collision to collision, and looks at the sun from each: straight, and along a chain of
//! small turns (`chain.rs`). One wavelength, the hero, draws everything; every wavelength counts its integrand over the mean
//! of the densities that all heroes would have had for the whole path (theory (44), (46)). The first collision is forced
//! (theory (43)).

use glam::DVec3;

use super::chain::{Station, begin_chain, follow_chain, pick_sun};
use super::flight::{fly, fly_near, force, is_crowded, normalize};
use super::random::{PathRandom, Purpose};
use super::sample::{RenderContext, Scratch};
use crate::accel::LocalRay;
use crate::film::Layer;

/// Paths of less weight play Russian roulette.
const ROULETTE_BELOW: f64 = 0.03;

/// Paths of more collisions than this are thinned out, whatever their weight: clouds that people render have few.
const LONG_PATH: u32 = 512;

/// Adds the light of one path to the layers; `scratch.crossings` holds what the camera ray meets.
pub(super) fn add_path(ctx: &RenderContext, camera_ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    let n = scratch.weight.len();
    let hero = ((random.uniform(Purpose::Hero, 0) * n as f64) as usize).min(n - 1);
    scratch.begin_path();
    let mut ray = *camera_ray;
    let is_crowded = is_crowded(scratch);
    for order in 1..=ctx.max_order {
        let u = random.uniform(Purpose::Collision, order);
        let collided = match order {
            1 => force(ctx, &ray, hero, u, scratch),
            _ if is_crowded => fly_near(ctx, &ray, hero, order, random, scratch),
            _ => fly(ctx, &ray, hero, u, scratch),
        };
        if !collided {
            if order > 1 {
                add_background(ctx, scratch);
            }
            return;
        }
        let sun = pick_sun(ctx, order, random);
        let sun_depth = add_sunlight(ctx, &ray, sun, if order == 1 { Layer::Direct } else { Layer::Multiple }, scratch);
        if order == 1 {
            note_depth(scratch);
        }
        if order == ctx.max_order || !survives(random.uniform(Purpose::Roulette, order), order, scratch) {
            return;
        }
        let station = Station { ray: &ray, hero, order, sun, sun_depth, is_crowded };
        let chain = ctx.lobes.filter(|lobes| begin_chain(ctx, lobes, &station, random, scratch));
        let next = turn(ctx, &ray, hero, order, random, scratch);
        if let Some(lobes) = chain {
            follow_chain(ctx, lobes, &station, random, scratch);
        }
        ray = next;
    }
}

/// Counts the first collision towards the mean distance of first ones.
fn note_depth(scratch: &mut Scratch) {
    let Scratch { weight, event, depth_sum, depth_weight, .. } = scratch;
    let real = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).sum::<f64>() / weight.len() as f64;
    *depth_sum += real * event.t_m;
    *depth_weight += real;
}

/// The sunlight that the collision sends back along the path; returns the optical depth toward the sun of the given number.
fn add_sunlight(ctx: &RenderContext, ray: &LocalRay, sun: usize, layer: Layer, scratch: &mut Scratch) -> f64 {
    let mut sun_depth = 0.0;
    if scratch.weight.iter().all(|weight| *weight <= 0.0) {
        return sun_depth;
    }
    for (i, light) in ctx.lighting.suns.iter().enumerate() {
        let sun_ray = LocalRay { origin: scratch.event.point, direction: -light.direction };
        scratch.light_sun(ctx, &sun_ray);
        scratch.look(ctx, turn_h(ray.direction, -light.direction), 0.0);
        let Scratch { weight, sunlit, looked, layers, .. } = scratch;
        for (w, radiance) in layers[layer as usize].iter_mut().enumerate() {
            *radiance += weight[w] * looked[w] * sunlit[w] * light.irradiance[w];
        }
        if i == sun {
            let passed = sunlit.iter().sum::<f64>() / sunlit.len() as f64;
            // Without shadows nothing was asked: one small turn is a fair guess.
            sun_depth = if ctx.switches.shadows { -passed.max(f64::MIN_POSITIVE).ln() } else { 1.0 };
        }
    }
    sun_depth
}

/// The background that an escaping path sees.
fn add_background(ctx: &RenderContext, scratch: &mut Scratch) {
    if ctx.switches.background {
        let Scratch { weight, layers, .. } = scratch;
        for (w, radiance) in layers[Layer::Background as usize].iter_mut().enumerate() {
            *radiance += weight[w] * ctx.lighting.background[w];
        }
    }
}

/// Probability that a path of any weight goes on after a collision.
///
/// In fog without end or absorption as many as n^(-1/2) of all paths reach order n, so that their mean length has no
/// bound. Surviving from n - 1 to n with sqrt(1 - 1/n) leaves 1/n of them, whose weights grow as n^(1/2): the mean length and
/// the variance then both grow with ln n alone.
fn survival_of_length(order: u32) -> f64 {
    if order <= LONG_PATH { 1.0 } else { (1.0 - 1.0 / f64::from(order)).sqrt() }
}

/// Keeps a path of small weight with a probability in proportion, heavier by as much; very long ones die out.
fn survives(u: f64, order: u32, scratch: &mut Scratch) -> bool {
    let Scratch { weight, event, .. } = scratch;
    let largest = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).fold(0.0, f64::max);
    let survival = (largest / ROULETTE_BELOW).min(1.0) * survival_of_length(order);
    if u >= survival {
        return false;
    }
    weight.iter_mut().for_each(|weight| *weight /= survival);
    true
}

/// Draws the next direction.
fn turn(
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
    fn begin_path(&mut self) {
        self.weight.fill(1.0);
        self.density.fill(1.0);
        self.small_turns.fill(1.0);
        self.rarity = 0.0;
    }

    /// Fills `looked` with the light that the collision turns by h, where a chain of small turns with the given sum of
    /// rarities follows to the sun: all of it but the forward lobe, which other chains draw. Only where all turns from the
    /// camera to the sun are small does the lobe count, shared among the collisions that could have been the one that is not
    /// drawn (theory (49)).
    pub(super) fn look(&mut self, ctx: &RenderContext, h: f64, chain_rarity: f64) {
        let Self { event, turned, looked, small_turns, rarity, .. } = self;
        event.turn(ctx.media, ctx.lobes, h, turned);
        looked.copy_from_slice(&turned.light);
        if let Some(lobes) = ctx.lobes {
            let own = lobes.rarity(h);
            let share = own / (own + *rarity + chain_rarity);
            for w in 0..looked.len() {
                looked[w] -= turned.lobe[w] * (1.0 - small_turns[w] * share);
            }
        }
    }

    /// Remembers what share of the path still has nothing but small turns.
    fn note_turn(&mut self, turn_rarity: f64) {
        for (share, (lobe, light)) in self.small_turns.iter_mut().zip(self.turned.lobe.iter().zip(&self.turned.light)) {
            *share *= if *light > 0.0 { lobe / light } else { 0.0 };
        }
        self.rarity += turn_rarity;
    }
}

/// h = 1 - cos of the angle between two unit vectors, without cancellation between neighbours.
#[inline]
pub(super) fn turn_h(a: DVec3, b: DVec3) -> f64 {
    0.5 * (a - b).length_squared()
}

/// The unit vector at h = 1 - cos from a unit axis, turned about it by `turns` of a full circle.
pub(super) fn around(axis: DVec3, h: f64, turns: f64) -> DVec3 {
    let (u, v) = axis.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (std::f64::consts::TAU * turns).sin_cos();
    let sin_theta = (h * (2.0 - h)).max(0.0).sqrt();
    ((1.0 - h) * axis + sin_theta * (cos_phi * u + sin_phi * v)).normalize()
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
