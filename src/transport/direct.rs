//! `direct`: sunlight that a droplet scatters once, straight to the camera.
//!
//! All wavelengths share the tentative events of the largest extinction. At each, every wavelength contributes its
//! share of real events and goes on with the rest (ratio tracking: Kutz et al. 2017), so no wavelength is drawn.

use glam::DVec3;

use super::flight::{Start, next_event, real_share};
use super::random::{PathRandom, Purpose};
use super::sample::{RenderContext, Scratch};
use crate::accel::{Body, BodyKind, Hit, LocalRay};
use crate::plan::Switches;

/// Weights below this play Russian roulette; what they could still add is a twentieth of the first event's light, and
/// the phase function is the same all along the ray.
const ROULETTE_BELOW: f64 = 0.05;

/// Adds the light scattered once along a camera ray to the direct layer; notes where it came from.
pub(super) fn add_direct(ctx: &RenderContext, ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    scratch.weight.fill(1.0);
    let mut start = Start::ORIGIN;
    for segment in 0.. {
        scratch.rays.scatter += 1;
        let Some(hit) = next_event(ctx.accel, ctx.media, ray, start, random, segment) else {
            return;
        };
        let body = ctx.accel.body(hit.index);
        real_share(ctx.media, body, &mut scratch.share);
        note_depth(&hit, scratch);
        add_sunlight(ctx, ray, body, &hit, scratch);
        for (weight, share) in scratch.weight.iter_mut().zip(&scratch.share) {
            *weight *= 1.0 - share;
        }
        if !survives_roulette(&mut scratch.weight, random.uniform(Purpose::Roulette, segment)) {
            return;
        }
        start = Start::after(&hit);
    }
}

/// Keeps a path of small weight with a probability in proportion, heavier by as much.
fn survives_roulette(weight: &mut [f64], u: f64) -> bool {
    let largest = weight.iter().copied().fold(0.0, f64::max);
    if largest >= ROULETTE_BELOW {
        return true;
    }
    let survival = largest / ROULETTE_BELOW;
    if u >= survival {
        return false;
    }
    weight.iter_mut().for_each(|w| *w /= survival);
    true
}

/// Counts this event towards the mean distance of the first one.
fn note_depth(hit: &Hit, scratch: &mut Scratch) {
    let n = scratch.weight.len() as f64;
    let real: f64 = scratch.weight.iter().zip(&scratch.share).map(|(weight, share)| weight * share).sum::<f64>() / n;
    scratch.depth_sum += real * hit.t_m;
    scratch.depth_weight += real;
}

/// The sunlight that this event sends to the camera: albedo, phase function, transmittance on both legs.
fn add_sunlight(ctx: &RenderContext, ray: &LocalRay, body: &Body, hit: &Hit, scratch: &mut Scratch) {
    let point = scattering_point(ray, body, hit);
    let air = if ctx.switches.air { ctx.lighting.air.transmittance(hit.t_m) } else { 1.0 };
    let (albedo, phase) = (ctx.media.albedo(body.bin()), ctx.media.phase(body.bin()));
    for sun in &ctx.lighting.suns {
        // 1 - cos of the scattering angle, without cancellation in the forward direction.
        let h = 0.5 * (sun.direction + ray.direction).length_squared();
        let sun_ray = LocalRay { origin: point, direction: -sun.direction };
        let Scratch { transmittance, weight, share, direct, rays, .. } = scratch;
        let lit = sunlit(ctx, &sun_ray, transmittance, rays);
        for w in 0..weight.len() {
            let passed = lit.map_or(1.0, |lit| lit[w]) * weight[w] * share[w] * air;
            if passed > 0.0 {
                direct[w] += passed * albedo[w] * phase[w].eval(h) * sun.irradiance[w];
            }
        }
    }
}

/// Droplets scatter from their centre, fog where it was met.
fn scattering_point(ray: &LocalRay, body: &Body, hit: &Hit) -> DVec3 {
    match body.kind() {
        BodyKind::Droplet => body.center,
        BodyKind::Ball | BodyKind::Box => ray.origin + hit.t_m * ray.direction,
    }
}

/// Transmittance toward the sun by wavelength; `None` where droplets cast no shadows.
pub(super) fn sunlit<'a>(
    ctx: &RenderContext,
    sun_ray: &LocalRay,
    transmittance: &'a mut super::transmittance::Transmittance,
    rays: &mut super::render::RayCounts,
) -> Option<&'a [f64]> {
    let Switches { shadows: true, .. } = ctx.switches else {
        return None;
    };
    rays.shadow += 1;
    Some(transmittance.along(ctx.accel, ctx.media, sun_ray, f64::INFINITY))
}
