//! `direct` and `multiple`: sunlight, and background, that droplets scatter to the camera once or many times.
//!
//! A path goes from the camera from collision to collision, and looks at the sun from each. One wavelength, the hero,
//! draws everything; every wavelength counts its integrand over the mean of the densities that all heroes would have had
//! for the whole path (theory (44), (46)). Legend: weight_l, that ratio for wavelength l; density_h, the hero's densities
//! over their mean. The first collision is forced (theory (43)).

use glam::DVec3;

use super::collision::{Place, Stretch};
use super::glass::{Ahead, Carried, Ways, balance};
use super::random::{PathRandom, Purpose};
use super::sample::{RenderContext, Scratch, add_ball_sunlight};
use crate::accel::{BodyKind, Crossing, LocalRay};
use crate::film::Layer;

/// Share of directions that are drawn around the sun's instead of the path's at the first collision.
const SUN_LOBE: f64 = 0.2;

/// That share falls by this factor from collision to collision: a path's weight can grow by the product of
/// 1 / (1 - share), which stays below 2.1 however long it gets.
const SUN_LOBE_DECAY: f64 = 0.7;

/// Paths of less weight play Russian roulette. The next phase function may be a thousand times an average one, so what
/// looks negligible is not: with 0.05 the variance is ten times higher.
const ROULETTE_BELOW: f64 = 5e-4;

/// Where the camera ray meets more than this, later flights look only at what lies before their collision: two short
/// searches then cost less than one through everything.
const CROWDED: usize = 128;

/// Paths of more collisions than this are thinned out, whatever their weight: clouds that people render have few.
const LONG_PATH: u32 = 512;

/// Adds the light of one path to the layers; `scratch.crossings` holds what the camera ray meets.
pub(super) fn add_path(ctx: &RenderContext, camera_ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    let hero = scratch.hero;
    scratch.weight.copy_from_slice(&scratch.seen);
    scratch.density.copy_from_slice(&scratch.seen_density);
    let mut ray = *camera_ray;
    let crowded = scratch.crossings.len() > CROWDED;
    for order in 1..=ctx.max_order {
        let collided = match order {
            1 => force(ctx, &ray, hero, random.uniform(Purpose::Collision, order), scratch),
            _ => travel(ctx, &mut ray, order, crowded, random, scratch),
        };
        if !collided {
            return;
        }
        add_sunlight(ctx, &ray, if order == 1 { Layer::Direct } else { Layer::Multiple }, random, scratch);
        if order == 1 && scratch.leg == 0 {
            note_depth(scratch);
        }
        if order == ctx.max_order || !survives(random.uniform(Purpose::Roulette, order), order, scratch) {
            return;
        }
        ray = turn(ctx, &ray, hero, order, random, scratch);
    }
}

/// From one collision to the next, past any glass on the way; `false` where there is none any more.
fn travel(
    ctx: &RenderContext,
    ray: &mut LocalRay,
    order: u32,
    crowded: bool,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> bool {
    let (hero, mut flight, mut left) = (scratch.hero, (Purpose::Collision, order), None);
    loop {
        let ahead = scratch.look_ahead(ctx, ray, left);
        if !ahead.is_some_and(|ahead| ahead.is_inside) {
            let collided = match crowded {
                true => fly_near(ctx, ray, hero, flight, random, scratch),
                false => fly(ctx, ray, hero, random.uniform(flight.0, flight.1), scratch),
            };
            if collided {
                return true;
            }
        }
        let Some(ahead) = ahead else {
            add_background(ctx, ray, scratch);
            return false;
        };
        let Some(next) = pass_glass(ctx, &ahead, ray, random, scratch) else { return false };
        (*ray, left, flight) = (next, Some(ahead.id), (Purpose::Flight, scratch.surfaces));
    }
}

/// Past the ball ahead; on the way the path sees the sunlight that it scatters.
fn pass_glass(
    ctx: &RenderContext,
    ahead: &Ahead,
    ray: &LocalRay,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Option<LocalRay> {
    if !ahead.is_inside {
        let weight = std::mem::take(&mut scratch.weight);
        add_ball_sunlight(ctx, ahead, ray, (Layer::Multiple, &weight), random, scratch);
        scratch.weight = weight;
    }
    scratch.is_refracted = true;
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

/// Fills `scratch.crossings` and `scratch.total_depth` with what a ray meets on its way to `scratch.reach_m`.
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

/// The first collision, given that there is one.
fn force(ctx: &RenderContext, ray: &LocalRay, hero: usize, u: f64, scratch: &mut Scratch) -> bool {
    let opacity = -(-scratch.total_depth[hero]).exp_m1();
    if opacity <= 0.0 || !collide(ctx, ray, hero, -(-u * opacity).ln_1p(), scratch) {
        return false;
    }
    let Scratch { density, total_depth, .. } = scratch;
    for (density, depth) in density.iter_mut().zip(total_depth) {
        let opacity = -(-*depth).exp_m1();
        *density = if opacity > 0.0 { *density / opacity } else { 0.0 };
    }
    normalize(scratch)
}

/// A later collision, from everything that the ray meets; `false` where the path leaves all of it behind, its weight
/// then being that of the way out.
fn fly(ctx: &RenderContext, ray: &LocalRay, hero: usize, u: f64, scratch: &mut Scratch) -> bool {
    scratch.rays.scatter += 1;
    meet(ctx, ray, scratch);
    let target = -(-u).ln_1p();
    if target < scratch.total_depth[hero] && collide(ctx, ray, hero, target, scratch) {
        return normalize(scratch);
    }
    escape(ctx, ray, scratch);
    false
}

/// A later collision where much is in the way: the nearest of independent draws for each body, which is the collision of
/// their sum, so that only what lies before it is looked at.
fn fly_near(
    ctx: &RenderContext,
    ray: &LocalRay,
    hero: usize,
    (purpose, number): (Purpose, u32),
    random: &PathRandom,
    scratch: &mut Scratch,
) -> bool {
    scratch.rays.scatter += 1;
    let (media, reach_m) = (ctx.media, scratch.reach_m);
    let hit = ctx.accel.closest(ray, 0.0, None, |body, crossing| {
        if body.kind() == BodyKind::Glass || crossing.start() >= reach_m {
            return None;
        }
        let (u, load) = (random.body(purpose, number, body.id), f64::from(body.load));
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
        escape(ctx, ray, scratch);
        return false;
    };
    gather(ctx, ray, hit.t_m.next_up(), scratch);
    let is_disc = ctx.accel.body(hit.index).kind() == BodyKind::Droplet;
    let disc = scratch.crossings.iter().position(|(body, _)| is_disc && body.id == hit.id);
    let place = disc.map_or(Place::Fog(hit.t_m), |index| Place::Disc(index as u32));
    land(ctx, ray, place, scratch);
    normalize(scratch)
}

/// The weight of a path that meets nothing more before `scratch.reach_m`.
fn escape(ctx: &RenderContext, ray: &LocalRay, scratch: &mut Scratch) {
    let Scratch { weight, density, total_depth, reach_m, .. } = scratch;
    let air = ctx.air_transmittance(ray, *reach_m);
    for w in 0..weight.len() {
        let passed = (-total_depth[w]).exp();
        weight[w] *= passed * air;
        density[w] *= passed;
    }
    normalize(scratch);
}

/// Finds the collision at a hero's optical depth.
fn collide(ctx: &RenderContext, ray: &LocalRay, hero: usize, target: f64, scratch: &mut Scratch) -> bool {
    let Scratch { crossings, finder, .. } = scratch;
    finder.stretches.clear();
    finder.stretches.extend(crossings.iter().enumerate().filter_map(|(i, met)| Stretch::of(ctx.media, hero, i, met)));
    let Some(place) = finder.find(target) else { return false };
    land(ctx, ray, place, scratch);
    true
}

/// Multiplies a collision's transmittance and density in.
fn land(ctx: &RenderContext, ray: &LocalRay, place: Place, scratch: &mut Scratch) {
    let Scratch { crossings, event, path_depth, weight, density, .. } = scratch;
    event.gather(ctx.media, ray, place, crossings);
    let depth = path_depth.past(ctx.media, crossings, event.t_m);
    let air = ctx.air_transmittance(ray, event.t_m);
    for w in 0..weight.len() {
        let passed = (-depth[w]).exp();
        weight[w] *= passed * air;
        density[w] *= passed * event.sigma[w];
    }
}

/// Divides by the mean density; `false` where no hero could have drawn the path.
fn normalize(scratch: &mut Scratch) -> bool {
    balance(&mut scratch.weight, &mut scratch.density)
}

/// Counts the first collision towards the mean distance of first ones.
fn note_depth(scratch: &mut Scratch) {
    let Scratch { weight, event, depth_sum, depth_weight, .. } = scratch;
    let real = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).sum::<f64>() / weight.len() as f64;
    *depth_sum += real * event.t_m;
    *depth_weight += real;
}

/// The sunlight that the collision sends back along the path.
fn add_sunlight(ctx: &RenderContext, ray: &LocalRay, layer: Layer, random: &PathRandom, scratch: &mut Scratch) {
    if scratch.weight.iter().all(|weight| *weight <= 0.0) {
        return;
    }
    let layer = scratch.layer(layer);
    for sun in &ctx.lighting.suns {
        let to_sun = scratch.toward(sun, random);
        scratch.light_sun(ctx, &LocalRay { origin: scratch.event.point, direction: to_sun });
        let Scratch { event, weight, sunlit, scattered, layers, .. } = scratch;
        event.scatter(ctx.media, turn_h(ray.direction, to_sun), scattered);
        for (w, radiance) in layers[layer].iter_mut().enumerate() {
            *radiance += weight[w] * scattered[w] * sunlit[w] * sun.irradiance[w];
        }
    }
}

/// The background that an escaping path sees.
fn add_background(ctx: &RenderContext, ray: &LocalRay, scratch: &mut Scratch) {
    if ctx.switches.background {
        let layer = scratch.layer(Layer::Background);
        let Scratch { weight, behind, layers, .. } = scratch;
        ctx.lighting.background_toward(ray.direction, behind);
        for (w, radiance) in layers[layer].iter_mut().enumerate() {
            *radiance += weight[w] * behind[w];
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
fn survives(u: f64, order: u32, scratch: &mut Scratch) -> bool {
    let Scratch { weight, event, .. } = scratch;
    let largest = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).fold(0.0, f64::max);
    let survival = (largest / ROULETTE_BELOW).min(1.0) * survival_of_length(order, LONG_PATH);
    if u >= survival {
        return false;
    }
    weight.iter_mut().for_each(|weight| *weight /= survival);
    true
}

/// Draws the next direction: around the path's own, or around the sun's, so that paths that happen to travel toward the
/// sun before they look at it are no surprise.
fn turn(
    ctx: &RenderContext,
    ray: &LocalRay,
    hero: usize,
    order: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> LocalRay {
    let suns = &ctx.lighting.suns;
    let lobe = SUN_LOBE * SUN_LOBE_DECAY.powi(order as i32 - 1);
    let u_lobe = random.uniform(Purpose::Lobe, order);
    let axis = if u_lobe < lobe {
        -suns[((u_lobe / lobe * suns.len() as f64) as usize).min(suns.len() - 1)].direction
    } else {
        ray.direction
    };
    let (u_bin, u_angle) = (random.uniform(Purpose::Bin, order), random.uniform(Purpose::Angle, order));
    let h = scratch.event.sample_h(ctx.media, hero, u_bin, u_angle);
    let direction = around(axis, h, random.uniform(Purpose::Azimuth, order));

    let Scratch { event, weight, density, scattered, lobes, .. } = scratch;
    let h = turn_h(ray.direction, direction);
    event.density(ctx.media, h, scattered);
    lobes.iter_mut().zip(&*scattered).for_each(|(sum, density)| *sum = (1.0 - lobe) * density);
    for sun in suns {
        event.density(ctx.media, turn_h(-sun.direction, direction), scattered);
        lobes.iter_mut().zip(&*scattered).for_each(|(sum, density)| *sum += lobe / suns.len() as f64 * density);
    }
    event.scatter(ctx.media, h, scattered);
    for w in 0..weight.len() {
        weight[w] *= scattered[w];
        density[w] *= lobes[w];
    }
    normalize(scratch);
    LocalRay { origin: scratch.event.point, direction }
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

    /// The longest path's weight grows by less than 2.1 through the sun's lobe.
    #[test]
    fn the_suns_lobe_keeps_weights_bounded() {
        let growth: f64 = (0..1000).map(|n| 1.0 / (1.0 - SUN_LOBE * SUN_LOBE_DECAY.powi(n))).product();
        assert!(growth < 2.1, "{growth}");
    }
}
