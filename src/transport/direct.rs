//! `direct`: sunlight that a droplet scatters once, straight to the camera.
//!
//! The first collision is forced: its place is drawn from the hero wavelength's free path, given that there is one
//! (Lafortune & Willems 1996). Wavelength l then counts f_l / (1/n sum_h pdf_h), f the density of its own collisions
//! and h the wavelengths that could have been heroes (Wilkie et al. 2014), which never exceeds n. Legend: sigma, what
//! acts per metre at the place (on a droplet's disc: the probability that it acts); T, transmittance before it.

use glam::DVec3;

use super::collision::{Place, Stretch, find_depth};
use super::random::{PathRandom, Purpose};
use super::sample::{RenderContext, Scratch};
use crate::accel::{BodyKind, Crossing, LocalRay};

/// Adds the light scattered once along a camera ray to the direct layer; `scratch.crossings` holds what the ray meets,
/// `scratch.total_depth` its optical depth.
pub(super) fn add_direct(ctx: &RenderContext, ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    let n = scratch.total_depth.len();
    let hero = ((random.uniform(Purpose::Hero, 0) * n as f64) as usize).min(n - 1);
    let opacity = -(-scratch.total_depth[hero]).exp_m1();
    if opacity <= 0.0 {
        return;
    }
    let target = -(-random.uniform(Purpose::Collision, 0) * opacity).ln_1p();
    scratch.stretches.clear();
    let crossings = scratch.crossings.iter().enumerate();
    scratch.stretches.extend(crossings.filter_map(|(i, crossing)| Stretch::of(ctx.media, hero, i, crossing)));
    let Some(place) = find_depth(&mut scratch.stretches, target) else { return };
    let (t_m, point) = locate(ray, place, scratch);
    act(ctx, place, t_m, scratch);
    weigh(ctx, t_m, scratch);
    note_depth(t_m, scratch);
    add_sunlight(ctx, ray, place, t_m, point, scratch);
}

/// Distance and position of a collision: droplets scatter from their centre, fog where it was met.
fn locate(ray: &LocalRay, place: Place, scratch: &Scratch) -> (f64, DVec3) {
    match place {
        Place::Fog(t) => (t, ray.origin + t * ray.direction),
        Place::Disc(index) => {
            let (body, crossing) = &scratch.crossings[index as usize];
            (crossing.start(), body.center)
        }
    }
}

/// Whether a body takes part in a collision at a place.
#[inline]
fn takes_part(place: Place, t_m: f64, index: usize, crossing: &Crossing) -> bool {
    match (place, crossing) {
        (Place::Disc(disc), Crossing::Point(_)) => disc as usize == index,
        (Place::Fog(_), Crossing::Chord(start, end)) => *start <= t_m && t_m <= *end,
        _ => false,
    }
}

/// Fills `scratch.sigma` with what acts at the place, by wavelength, and `scratch.acting` with the bins that do.
fn act(ctx: &RenderContext, place: Place, t_m: f64, scratch: &mut Scratch) {
    scratch.sigma.fill(0.0);
    scratch.acting.clear();
    for (i, (body, crossing)) in scratch.crossings.iter().enumerate() {
        if !takes_part(place, t_m, i, crossing) {
            continue;
        }
        let (bin, load) = (body.bin(), f64::from(body.load));
        match body.kind() {
            BodyKind::Droplet => {
                for (sigma, depth) in scratch.sigma.iter_mut().zip(ctx.media.disc_depth(bin)) {
                    *sigma = -(-load * depth).exp_m1();
                }
                scratch.acting.push((bin as u32, 1.0));
            }
            BodyKind::Ball | BodyKind::Box => match scratch.acting.iter_mut().find(|(known, _)| *known == bin as u32) {
                Some((_, sum)) => *sum += load,
                None => scratch.acting.push((bin as u32, load)),
            },
        }
    }
    if matches!(place, Place::Fog(_)) {
        scratch.acting.sort_unstable_by_key(|(bin, _)| *bin);
        for (bin, load) in &scratch.acting {
            for (sigma, c_ext_m2) in scratch.sigma.iter_mut().zip(ctx.media.c_ext_m2(*bin as usize)) {
                *sigma += load * c_ext_m2;
            }
        }
    }
}

/// Fills `scratch.weight` with T_l over the mean density of all heroes: what is left is to multiply by what is scattered.
fn weigh(ctx: &RenderContext, t_m: f64, scratch: &mut Scratch) {
    let Scratch { camera_depth, crossings, weight, sigma, total_depth, .. } = scratch;
    let depth = camera_depth.past(ctx.media, crossings, t_m);
    let mut density = 0.0;
    for w in 0..weight.len() {
        weight[w] = (-depth[w]).exp();
        let opacity = -(-total_depth[w]).exp_m1();
        if opacity > 0.0 {
            density += sigma[w] * weight[w] / opacity;
        }
    }
    let scale = if density > 0.0 { weight.len() as f64 / density } else { 0.0 };
    weight.iter_mut().for_each(|w| *w *= scale);
}

/// Counts this collision towards the mean distance of the first one.
fn note_depth(t_m: f64, scratch: &mut Scratch) {
    let n = scratch.weight.len() as f64;
    let real: f64 = scratch.weight.iter().zip(&scratch.sigma).map(|(weight, sigma)| weight * sigma).sum::<f64>() / n;
    scratch.depth_sum += real * t_m;
    scratch.depth_weight += real;
}

/// The sunlight that the collision sends to the camera: albedo, phase function, transmittance on both legs.
fn add_sunlight(ctx: &RenderContext, ray: &LocalRay, place: Place, t_m: f64, point: DVec3, scratch: &mut Scratch) {
    let air = if ctx.switches.air { ctx.lighting.air.transmittance(t_m) } else { 1.0 };
    for sun in &ctx.lighting.suns {
        // 1 - cos of the scattering angle, without cancellation in the forward direction.
        let h = 0.5 * (sun.direction + ray.direction).length_squared();
        let sun_ray = LocalRay { origin: point, direction: -sun.direction };
        scratch.light_sun(ctx, &sun_ray);
        let Scratch { sunlit, weight, direct, acting, sigma, .. } = scratch;
        for (bin, load) in acting {
            let bin = *bin as usize;
            let (albedo, phase, c_ext_m2) = (ctx.media.albedo(bin), ctx.media.phase(bin), ctx.media.c_ext_m2(bin));
            for w in 0..weight.len() {
                let arriving = weight[w] * air * sunlit[w] * sun.irradiance[w];
                if arriving > 0.0 {
                    let extinction = if matches!(place, Place::Disc(_)) { sigma[w] } else { *load * c_ext_m2[w] };
                    direct[w] += arriving * extinction * albedo[w] * phase[w].eval(h);
                }
            }
        }
    }
}
