//! Sunlight that reaches a collision by way of more collisions with small turns: a chain drawn backward from the sun.
//!
//! A path that happens to travel almost toward the sun would find a phase function hundreds of times its mean. So the last
//! turns of a path, if all are small, are drawn from the sun's side: each adds a draw from the common forward lobe to the
//! direction toward it, and the path flies along these directions, the most turned one first. No peak is ever evaluated,
//! only drawn from (theory (47)-(50)).

use glam::DVec3;

use super::flight::{fly_near, force, meet, normalize};
use super::forward::ForwardLobes;
use super::glass::{Ahead, balance};
use super::path::{around, turn_h};
use super::random::{PathRandom, Purpose};
use super::sample::RenderContext;
use super::scratch::Scratch;
use crate::accel::LocalRay;
use crate::film::Layer;

/// Chains per collision where the sun is at least one small turn away.
const CHAINS: f64 = 0.4;

/// From deep inside a cloud little arrives by way of small turns alone: the chance falls by this rate per optical depth.
const CHANCE_DECAY: f64 = 0.05;

/// Chains are never longer. Of more small turns than these in a row the path draws the first itself: a chain this long
/// turns light so much that no peak is left where it begins.
pub(super) const MOST_TURNS: u32 = 24;

/// What a chain needs of the path that it leaves, and its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Aside {
    /// The chain's weight and density while the path goes on, and the path's while the chain does.
    weight: Vec<f64>,
    density: Vec<f64>,
    /// Turns from the sun outward: h of each, and the direction that it turns to the one before.
    turns: Vec<(f64, DVec3)>,
    /// The direction to where on the sun the chain ends.
    to_sun: DVec3,
}

impl Aside {
    pub fn new(n_wavelengths: usize) -> Self {
        Self { weight: vec![0.0; n_wavelengths], density: vec![0.0; n_wavelengths], ..Self::default() }
    }
}

/// How many turns a chain takes: as many collisions as lie toward the sun on average, or a few, since chains from places
/// next to the light can wander into the cloud; `MOST_TURNS` stands for all longer ones.
#[derive(Clone, Copy, Debug)]
struct Lengths {
    /// Mean of the Poisson distribution of the turns beyond the first.
    mean: f64,
}

impl Lengths {
    /// The number of turns, from a uniform number in [0, 1): for half of them Poisson's distribution, for the other half
    /// each further turn with probability 1/2.
    fn draw(self, u: f64) -> u32 {
        let mut turns = 1;
        if u < 0.5 {
            let (mut rest, mut probability) = (2.0 * u, (-self.mean).exp());
            while rest >= probability && turns < MOST_TURNS {
                rest -= probability;
                probability *= self.mean / f64::from(turns);
                turns += 1;
            }
        } else {
            // 2 u - 1 in [0, 1) is below 1/2, 3/4, ..
            let rest = 2.0 - 2.0 * u;
            turns = (1 - rest.log2().ceil() as i32).clamp(1, MOST_TURNS as i32) as u32;
        }
        turns
    }

    fn probability(self, turns: u32) -> f64 {
        if turns == MOST_TURNS {
            return 1.0 - (1..MOST_TURNS).map(|fewer| self.probability(fewer)).sum::<f64>();
        }
        let poisson = (1..turns).fold((-self.mean).exp(), |p, i| p * self.mean / f64::from(i));
        0.5 * (poisson + 0.5f64.powi(turns as i32))
    }
}

/// A collision of a path, as far as chains from it need to know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station<'a> {
    /// The ray along which the path came.
    pub ray: &'a LocalRay,
    /// The wavelength that draws.
    pub hero: usize,
    /// Number of the collision, from 1.
    pub order: u32,
    /// The sun that the chain leads to.
    pub sun: usize,
    /// Optical depth toward it.
    pub sun_depth: f64,
    /// Whether so much is in the way that only the near is looked at.
    pub is_crowded: bool,
    /// Least chance of a chain, whatever the optical depth toward the sun says: light also comes around.
    pub least_chance: f64,
    /// Most turns that a chain may have.
    pub most_turns: u32,
    /// The layer of light that arrives without meeting glass.
    pub layer: Layer,
}

/// The sun that chains of one collision lead to.
pub(super) fn pick_sun(ctx: &RenderContext, order: u32, random: &PathRandom) -> usize {
    let n = ctx.lighting.suns.len();
    ((random.uniform(Purpose::ChainSun, order) * n as f64) as usize).min(n.saturating_sub(1))
}

/// Draws a chain for a collision, and what it is worth there; `false` where there is none. `look` fills `scratch.looked` with what
/// the collision turns by an h toward a chain of the given rarity and number of turns.
pub(super) fn begin_chain(
    ctx: &RenderContext,
    lobes: &ForwardLobes,
    station: &Station,
    random: &PathRandom,
    scratch: &mut Scratch,
    look: impl FnOnce(&mut Scratch, f64, f64, u32),
) -> bool {
    let Station { ray, hero, order, sun, sun_depth, .. } = *station;
    let Some(light) = ctx.lighting.suns.get(sun) else { return false };
    let to_sun = scratch.toward(light, random);
    let small_turns = lobes.share() * sun_depth;
    let chance =
        (CHAINS * small_turns.min(1.0).sqrt() * (-CHANCE_DECAY * sun_depth).exp()).clamp(station.least_chance, 1.0);
    if random.uniform(Purpose::ChainChance, order) >= chance {
        return false;
    }
    let lengths = Lengths { mean: small_turns.min(f64::from(MOST_TURNS)) };
    let n_turns = lengths.draw(random.uniform(Purpose::ChainLength, order));
    if n_turns > station.most_turns {
        return false;
    }
    let mut rarity = 0.0;
    let mut toward = to_sun;
    scratch.aside.to_sun = to_sun;
    scratch.aside.turns.clear();
    for i in 0..n_turns {
        let h = lobes.sample(hero, random.uniform(Purpose::ChainAngle, draw_of(order, i)));
        toward = around(toward, h, random.uniform(Purpose::ChainAzimuth, draw_of(order, i)));
        rarity += lobes.rarity(h);
        scratch.aside.turns.push((h, toward));
    }
    let n_suns = ctx.lighting.suns.len() as f64;
    let factor = n_suns / (chance * lengths.probability(n_turns));
    look(scratch, turn_h(ray.direction, toward), rarity, n_turns);
    let Scratch { aside, weight, density, looked, .. } = scratch;
    for (aside, (weight, looked)) in aside.weight.iter_mut().zip(weight.iter().zip(looked)) {
        *aside = factor * weight * *looked;
    }
    aside.density.copy_from_slice(density);
    aside.weight.iter().any(|weight| *weight > 0.0)
}

/// Follows the chain from the collision to the sun and adds the light that comes along it; the path's own weight stays as it
/// is, its event does not.
pub(super) fn follow_chain(
    ctx: &RenderContext,
    lobes: &ForwardLobes,
    station: &Station,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    scratch.step_aside();
    if fly_chain(ctx, lobes, station, random, scratch) {
        let sun = &ctx.lighting.suns[station.sun];
        let sun_ray = LocalRay { origin: scratch.event.point, direction: scratch.aside.to_sun };
        scratch.light_sun(ctx, &sun_ray);
        let layer = scratch.layer(station.layer);
        let Scratch { weight, sunlit, layers, .. } = scratch;
        for (w, radiance) in layers[layer].iter_mut().enumerate() {
            *radiance += weight[w] * sunlit[w] * sun.irradiance[w];
        }
    }
    scratch.step_aside();
}

/// From collision to collision along the chain's directions; `false` where nothing arrives.
fn fly_chain(
    ctx: &RenderContext,
    lobes: &ForwardLobes,
    station: &Station,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> bool {
    let Station { hero, order, is_crowded, .. } = *station;
    let mut origin = scratch.event.point;
    for i in (0..scratch.aside.turns.len()).rev() {
        let (h, direction) = scratch.aside.turns[i];
        let ray = LocalRay { origin, direction };
        let draw = draw_of(order, i as u32);
        // What lies behind glass is not on a straight way to the sun.
        match scratch.look_ahead(ctx, &ray, None) {
            Some(ahead) if ahead.is_inside => return false,
            Some(ahead) if i == 0 => end_at_ball(ctx, lobes, station, (&ray, h), &ahead, scratch),
            _ => {}
        }
        let collided = if is_crowded {
            fly_near(ctx, &ray, hero, CHAIN_FLIGHTS | draw, random, scratch)
        } else {
            scratch.rays.scatter += 1;
            meet(ctx, &ray, scratch);
            force(ctx, &ray, hero, random.uniform(Purpose::ChainCollision, draw), scratch)
        };
        if !collided {
            return false;
        }
        let Scratch { event, turned, weight, density, .. } = scratch;
        event.turn(ctx.media, Some(lobes), h, turned);
        for w in 0..weight.len() {
            weight[w] *= turned.lobe[w];
            density[w] *= lobes.density(w, h);
        }
        if !normalize(scratch) || scratch.weight.iter().all(|weight| *weight <= 0.0) {
            return false;
        }
        origin = scratch.event.point;
    }
    true
}

/// Adds the sunlight that a ball ahead turns by the last h into the chain, where nothing stops it before.
fn end_at_ball(
    ctx: &RenderContext,
    lobes: &ForwardLobes,
    station: &Station,
    (ray, h): (&LocalRay, f64),
    ahead: &Ahead,
    scratch: &mut Scratch,
) {
    scratch.rays.scatter += 1;
    meet(ctx, ray, scratch);
    let air = ctx.air_transmittance(ray, ahead.t_m);
    let phase = ctx.media.phase(ahead.bin);
    let Scratch { weight, density, total_depth, turned, .. } = scratch;
    for w in 0..weight.len() {
        let peak = ctx.media.q_sca(ahead.bin, w) * lobes.part(w, h, phase[w].eval(h));
        turned.light[w] = weight[w] * (-total_depth[w]).exp() * air * peak;
        turned.drawn[w] = density[w] * lobes.density(w, h);
    }
    if !balance(&mut turned.light, &mut turned.drawn) {
        return;
    }
    let sun = &ctx.lighting.suns[station.sun];
    scratch.light_sun(ctx, &LocalRay { origin: ahead.ball.center, direction: scratch.aside.to_sun });
    let layer = scratch.layer(station.layer);
    let Scratch { turned, sunlit, layers, .. } = scratch;
    for (w, radiance) in layers[layer].iter_mut().enumerate() {
        *radiance += turned.light[w] * sunlit[w] * sun.irradiance[w];
    }
}

/// Numbers the draws of chains apart from each other; orders beyond 2^23 share theirs with much lower ones.
fn draw_of(order: u32, turn: u32) -> u32 {
    ((order << 8) | turn) & !CHAIN_FLIGHTS
}

/// Marks the flights of chains apart from those of paths.
const CHAIN_FLIGHTS: u32 = 1 << 31;

impl Scratch {
    /// Exchanges the path's weight with the chain's.
    fn step_aside(&mut self) {
        std::mem::swap(&mut self.weight, &mut self.aside.weight);
        std::mem::swap(&mut self.density, &mut self.aside.density);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_drawn_as_likely_as_they_say() {
        for mean in [0.0, 0.3, 4.0, f64::from(MOST_TURNS)] {
            let (lengths, n) = (Lengths { mean }, 200_000u32);
            let mut count = [0u32; 300];
            (0..n).for_each(|i| count[lengths.draw((f64::from(i) + 0.5) / f64::from(n)) as usize] += 1);
            for turns in 1..=MOST_TURNS {
                let expected = lengths.probability(turns) * f64::from(n);
                assert!((f64::from(count[turns as usize]) - expected).abs() <= 2.0, "{mean} {turns} {expected}");
            }
            let sum: f64 = (1..=MOST_TURNS).map(|turns| lengths.probability(turns)).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }
}
