//! `air-multiple`: light that air and droplets scatter one after the other, in any order, other than airlight and glow.
//!
//! A path like that of `path.rs`, on which the air takes part. At every flight the droplets' next collision is drawn, then whether the air
//! comes before it; a path that has not met the air yet is made to, however thin it is; theory (51), (52). Paths without air, airlight (one
//! collision with the air) and glow (air, then a droplet) are walked past and not counted: they have estimators of their own.

use super::chain::{Station, begin_chain, follow_chain, pick_sun};
use super::collision::Place;
use super::flight::{Crowd, arrive, go, meet, next_place, normalize};
use super::path::{
    LONG_PATH, add_background, add_sunlight, around, pass_glass, survival_of_length, survives, turn, turn_h,
};
use super::random::{PathRandom, Purpose};
use super::sample::RenderContext;
use super::scratch::Scratch;
use crate::accel::LocalRay;
use crate::film::Layer;

/// Paths of less weight play Russian roulette at the air, as others do at droplets. So do all where nothing but air is ahead that scatters less than this.
const ROULETTE_BELOW: f64 = 0.03;

/// Neither air nor droplets are drawn less often than this where both could be next and a path has met the air: air beside a bright droplet is thin and
/// yet matters. By as much less as the path has met droplets, so that weights hardly grow in clouds.
const LEAST_CHANCE: f64 = 0.05;

/// Least chance of a chain. Lit air beside a cloud has nothing between it and the sun, and yet droplets one small turn away.
const LEAST_CHAIN: f64 = 0.3;

/// Numbers draws of these paths apart from those of paths without air.
const DRAWS: u32 = 1 << 20;

/// What a path has met so far.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    air: u32,
    droplets: u32,
    first_was_air: bool,
    /// What the air could have scattered on flights that ended elsewhere, before the path met it.
    passed_by: f64,
}

/// Where a flight ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Arrival {
    /// At droplets: `scratch.event` holds the collision.
    Droplets,
    /// In the air, at `scratch.event.point`.
    Air,
    /// At glass, to which the path's weight belongs then, or nowhere.
    Nothing,
}

impl Met {
    fn note(&mut self, is_air: bool) {
        self.first_was_air |= is_air && self.air + self.droplets == 0;
        self.air += u32::from(is_air);
        self.droplets += u32::from(!is_air);
    }

    /// The chance with which a path that has not met the air yet meets it on this flight, on which the air scatters `in_air`. As much as has
    /// been passed by is taken to be still to come, this flight's at least: so weights grow no faster than the sum of what is passed by.
    fn chance_to_begin(&self, in_air: f64, has_next: bool) -> f64 {
        if has_next { in_air / (in_air + self.passed_by.max(in_air)) } else { 1.0 }
    }

    /// The chance of the air on a flight of a path that has met it: its share of what can come next.
    fn chance_to_go_on(&self, in_air: f64, passed: f64) -> f64 {
        let least = LEAST_CHANCE / f64::from(1 + self.droplets);
        (in_air / (in_air + passed)).clamp(least, 1.0 - least)
    }

    /// Whether sunlight counts that arrives after so many more collisions with droplets.
    fn counts_with(self, more_droplets: u32) -> bool {
        let droplets = self.droplets + more_droplets;
        let is_airlight = self.air == 1 && droplets == 0;
        let is_glow = self.first_was_air && self.air == 1 && droplets == 1;
        self.air > 0 && !is_airlight && !is_glow
    }
}

/// Adds the light of one path to the layers. It begins along a leg of the camera's way, behind a ball that was just left.
pub(super) fn add_air_path(
    ctx: &RenderContext,
    leg: &LocalRay,
    left: Option<u32>,
    crowd: Crowd,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let hero = scratch.hero;
    scratch.begin_path();
    let (mut ray, mut left, mut met) = (*leg, left, Met::default());
    for order in 1..=ctx.max_air_order {
        let draw = DRAWS | order;
        let Some(is_air) = travel(ctx, &mut ray, &mut left, draw, &mut met, random, scratch) else { return };
        met.note(is_air);
        if met.droplets > ctx.max_order {
            return;
        }
        if met.air == 0 {
            // Nothing that the sun sends here counts.
            if order == ctx.max_air_order || !goes_on(is_air, draw, order, random, scratch) {
                return;
            }
            (ray, left) = (turn(ctx, &ray, hero, draw, random, scratch), None);
            continue;
        }
        let sun = pick_sun(ctx, draw, random);
        let sun_depth = match is_air {
            true => scratch.add_sunlight_in_air(ctx, &ray, sun, met.counts_with(0), random),
            false => {
                let layer = met.counts_with(0).then_some(Layer::AirMultiple);
                add_sunlight(ctx, &ray, sun, layer, random, scratch)
            }
        };
        if order == ctx.max_air_order || !goes_on(is_air, draw, order, random, scratch) {
            return;
        }
        let most_turns = (ctx.max_air_order - order).min(ctx.max_order - met.droplets);
        let station = Station {
            ray: &ray,
            hero,
            order: draw,
            sun,
            sun_depth,
            is_crowded: crowd.near_chains,
            least_chance: LEAST_CHAIN,
            most_turns,
            layer: Layer::AirMultiple,
        };
        let chain = ctx.lobes.filter(|lobes| {
            begin_chain(ctx, lobes, &station, random, scratch, |scratch, h, rarity, n_turns| match is_air {
                _ if !met.counts_with(n_turns) => scratch.looked.fill(0.0),
                true => scratch.look_in_air(ctx, h),
                false => scratch.look(ctx, h, rarity, n_turns),
            })
        });
        let next = match is_air {
            true => turn_in_air(ctx, &ray, draw, random, scratch),
            false => turn(ctx, &ray, hero, draw, random, scratch),
        };
        if let Some(lobes) = chain {
            follow_chain(ctx, lobes, &station, random, scratch);
        }
        (ray, left) = (next, None);
    }
}

/// To the next collision, past any glass on the way: whether it is with the air, or `None` where there is none. What lies
/// behind the first glass belongs to the next leg of the camera's way.
fn travel(
    ctx: &RenderContext,
    ray: &mut LocalRay,
    left: &mut Option<u32>,
    draw: u32,
    met: &mut Met,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Option<bool> {
    let mut flight = draw;
    loop {
        let ahead = scratch.look_ahead(ctx, ray, *left);
        if !ahead.is_some_and(|ahead| ahead.is_inside) {
            match fly(ctx, ray, flight, met, random, scratch) {
                Arrival::Air => return Some(true),
                Arrival::Droplets => return Some(false),
                Arrival::Nothing => {}
            }
        }
        let ahead = ahead.filter(|_| met.air + met.droplets > 0)?;
        // A ball that scatters sunlight is one more droplet.
        let layer = met.counts_with(1).then_some(Layer::AirMultiple);
        *ray = pass_glass(ctx, &ahead, ray, layer, random, scratch)?;
        *left = Some(ahead.id);
        flight = DRAWS << 1 | scratch.surfaces;
    }
}

/// A flight that ends in the air, at droplets, or leaves both behind (theory (51), (52)).
fn fly(
    ctx: &RenderContext,
    ray: &LocalRay,
    draw: u32,
    met: &mut Met,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Arrival {
    scratch.rays.scatter += 1;
    meet(ctx, ray, scratch);
    let place = next_place(ctx, scratch.hero, random.uniform(Purpose::Collision, draw), scratch);
    let end_m = place.map_or(scratch.reach_m, |place| place.t_m(&scratch.crossings));
    let air = &ctx.lighting.air;
    let (enter_m, leave_m) = ctx.way_in_air(ray);
    let way_m = (leave_m.min(end_m) - enter_m).max(0.0);
    let opacity = -(-air.extinction_per_m * way_m).exp_m1();
    let in_air = opacity * air.scattering_per_m / air.extinction_per_m;
    let has_next = place.is_some() || (scratch.reach_m.is_finite() && met.air + met.droplets > 0);
    let leaves = met.air > 0 && !has_next;
    let chance = match met.air {
        _ if in_air == 0.0 => 0.0,
        0 => met.chance_to_begin(in_air, has_next),
        _ if leaves => (in_air / ROULETTE_BELOW).min(1.0),
        _ => met.chance_to_go_on(in_air, 1.0 - opacity),
    };
    let takes_air = random.uniform(Purpose::AirChance, draw) < chance;
    if leaves {
        // Nothing else is ahead: the background is seen, and the path may go on in the air all the same.
        go(ctx, ray, None, 1.0, scratch);
        add_background(ctx, ray, 1.0 - opacity, scratch);
        if !takes_air {
            return Arrival::Nothing;
        }
        scratch.weight.iter_mut().for_each(|weight| *weight *= in_air / chance);
    } else if takes_air {
        go_to_air(ctx, ray, place, in_air / chance, scratch);
    } else {
        met.passed_by += in_air;
        scratch.weight.iter_mut().for_each(|weight| *weight /= 1.0 - chance);
        return if arrive(ctx, ray, place, scratch) { Arrival::Droplets } else { Arrival::Nothing };
    }
    let u = random.uniform(Purpose::AirPlace, draw);
    let t_m = enter_m + (-(-u * opacity).ln_1p() / air.extinction_per_m).min(way_m);
    scratch.event.point = ray.origin + t_m * ray.direction;
    Arrival::Air
}

/// To a place in the air before the droplets' next collision. That collision has been drawn, and so belongs to the path, although nothing
/// comes from it: its density stands for what the droplets let pass (theory (51)).
fn go_to_air(ctx: &RenderContext, ray: &LocalRay, place: Option<Place>, factor: f64, scratch: &mut Scratch) {
    if go(ctx, ray, place, factor, scratch) && place.is_some() {
        let Scratch { weight, event, .. } = scratch;
        weight.iter_mut().zip(&event.sigma).for_each(|(weight, sigma)| *weight *= sigma);
    }
}

fn goes_on(is_air: bool, draw: u32, order: u32, random: &PathRandom, scratch: &mut Scratch) -> bool {
    let u = random.uniform(Purpose::Roulette, draw);
    if !is_air {
        return survives(u, order, scratch);
    }
    let largest = scratch.weight.iter().copied().fold(0.0, f64::max);
    let survival = (largest / ROULETTE_BELOW).min(1.0) * survival_in_air(order);
    scratch.weight.iter_mut().for_each(|weight| *weight /= survival);
    u < survival
}

/// Probability that a path of any weight goes on in the air. The camera is in the middle of it: from deep air that takes nothing next to no path
/// leaves by itself, so that 1 - 1/n is needed for a mean length that grows with ln n alone.
fn survival_in_air(order: u32) -> f64 {
    survival_of_length(order, LONG_PATH).powi(2)
}

/// Draws the next direction by the air's phase function. No turn before counts as a small one of droplets any more.
fn turn_in_air(ctx: &RenderContext, ray: &LocalRay, draw: u32, random: &PathRandom, scratch: &mut Scratch) -> LocalRay {
    let phase = &ctx.lighting.air.phase;
    let h = phase[scratch.hero].sample(random.uniform(Purpose::Angle, draw));
    let direction = around(ray.direction, h, random.uniform(Purpose::Azimuth, draw));
    let Scratch { weight, density, small_turns, event, .. } = scratch;
    for (w, phase) in phase.iter().enumerate() {
        let p = phase.eval(h);
        weight[w] *= p;
        density[w] *= p;
    }
    small_turns.fill(0.0);
    let origin = event.point;
    normalize(scratch);
    LocalRay { origin, direction }
}

impl Scratch {
    /// Fills `looked` with what the air turns by h.
    fn look_in_air(&mut self, ctx: &RenderContext, h: f64) {
        for (looked, phase) in self.looked.iter_mut().zip(&ctx.lighting.air.phase) {
            *looked = phase.eval(h);
        }
    }

    /// The sunlight that the air sends back along the path, if it counts; returns the optical depth toward the sun of the given
    /// number.
    fn add_sunlight_in_air(
        &mut self,
        ctx: &RenderContext,
        ray: &LocalRay,
        sun: usize,
        counts: bool,
        random: &PathRandom,
    ) -> f64 {
        let (mut sun_depth, layer) = (0.0, self.layer(Layer::AirMultiple));
        for (i, light) in ctx.lighting.suns.iter().enumerate() {
            let to_sun = self.toward(light, random);
            self.light_sun(ctx, &LocalRay { origin: self.event.point, direction: to_sun });
            if counts && ctx.lighting.air.is_sunlit {
                self.look_in_air(ctx, turn_h(ray.direction, to_sun));
                let Scratch { weight, sunlit, looked, layers, .. } = self;
                for (w, radiance) in layers[layer].iter_mut().enumerate() {
                    *radiance += weight[w] * looked[w] * sunlit[w] * light.irradiance[w];
                }
            }
            if i == sun {
                sun_depth = self.mean_sun_depth(ctx);
            }
        }
        sun_depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_without_an_estimator_of_their_own_count() {
        let met = |kinds: &str| {
            let mut met = Met::default();
            kinds.chars().for_each(|kind| met.note(kind == 'A'));
            met
        };
        for (kinds, counts) in [
            ("A", false),
            ("AD", false),
            ("D", false),
            ("DD", false),
            ("AA", true),
            ("DA", true),
            ("ADD", true),
            ("ADA", true),
            ("DAD", true),
            ("AAD", true),
        ] {
            assert_eq!(met(kinds).counts_with(0), counts, "{kinds}");
        }
        assert!(!met("A").counts_with(1) && met("A").counts_with(2) && met("AD").counts_with(1));
    }
}
