//! Droplets close to a camera ray: each is looked at by itself, at points drawn evenly by the angle at the droplet.
//!
//! 1/d^2 along the ray is then no longer in the sum, however close the ray comes (Kulla & Fajardo 2012, eq. 9), and the
//! sum over the rest is smooth. A droplet does not light the air within its drawn radius: there is none.
//!
//! Legend: b, distance of the droplet from the ray; tau, distance along the ray from its foot; phi = atan(tau / b). Theory (67).

use glam::DVec3;

use super::Glow;
use super::exact::{Around, Point};
use super::gather::GlowScratch;
use super::shaded::shade;
use super::sources::{LEAF, drawn_radius_m};
use crate::accel::LocalRay;
use crate::film::Layer;
use crate::transport::random::PathRandom;
use crate::transport::sample::RenderContext;
use crate::transport::scratch::Scratch;

/// Parts of the angle that are looked at for a single droplet, at most; many share their ray.
const MOST_PARTS: u32 = 16;

/// Least distance of a droplet from the ray, in its drawn radii, that the density of points is made for.
const LEAST_OFFSET: f64 = 1e-4;

/// Stretches of a ray on which a droplet is looked at: before and behind its drawn ball.
type Stretches = [(f64, f64); 2];

/// Adds the light of droplets near a ray on its way from `from_m` to `to_m`.
pub(in crate::transport) fn add_near(
    ctx: &RenderContext,
    glow: &Glow,
    ray: &LocalRay,
    way_m: [f64; 2],
    n_steps: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let around = Around::of(ctx);
    let n_single = glow.slots.len() - glow.n_in_tree;
    let parts = (n_steps / n_single.max(1) as u32).clamp(1, MOST_PARTS);
    for slot in glow.n_in_tree..glow.slots.len() {
        add_droplet(ctx, glow, &around, ray, way_m, slot, (f64::INFINITY, parts), random, scratch);
    }
    if glow.near_m > 0.0 && glow.n_in_tree > 0 {
        glow.find_near(&around, ray, way_m, &mut scratch.glow);
        for i in 0..scratch.glow.near.len() {
            let slot = scratch.glow.near[i];
            add_droplet(ctx, glow, &around, ray, way_m, slot, (glow.near_m, 1), random, scratch);
        }
    }
}

impl Glow {
    /// Fills `near` with the tree's sources closer than `near_m` to the ray.
    fn find_near(&self, around: &Around, ray: &LocalRay, [from_m, to_m]: [f64; 2], own: &mut GlowScratch) {
        let GlowScratch { near, stack, .. } = own;
        near.clear();
        stack.clear();
        stack.push(0);
        let distance_m = |center: DVec3| {
            let to_center = center - ray.origin;
            let t_m = to_center.dot(ray.direction).clamp(from_m, to_m);
            (to_center - t_m * ray.direction).length()
        };
        while let Some(place) = stack.pop() {
            let octet = &self.tree.octets[place as usize];
            for k in 0..usize::from(octet.count).min(LEAF) {
                if octet.is_leaf {
                    let slot = octet.child[k] as usize;
                    let body = around.accel.body(self.slots[slot].body);
                    if body.is_disc() && distance_m(body.center) < self.near_m {
                        near.push(slot);
                    }
                    continue;
                }
                let center = DVec3::new(f64::from(octet.x[k]), f64::from(octet.y[k]), f64::from(octet.z[k]));
                // Reaches are f32: a part in 1e5 more loses nothing.
                let reach_m = f64::from(octet.reach[k]) * self.unit_m * 1.00001 + self.near_m;
                if distance_m(self.middle + center * self.unit_m) < reach_m {
                    stack.push(octet.child[k]);
                }
            }
        }
    }
}

#[allow(clippy::too_many_arguments)] // one estimate, with everything it draws
fn add_droplet(
    ctx: &RenderContext,
    glow: &Glow,
    around: &Around,
    ray: &LocalRay,
    way_m: [f64; 2],
    slot: usize,
    (within_m, parts): (f64, u32),
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let body = around.accel.body(glow.slots[slot].body);
    let to_center = body.center - ray.origin;
    let foot_m = to_center.dot(ray.direction);
    let offset_m = (to_center - foot_m * ray.direction).length();
    let drawn_m = drawn_radius_m(around.media, body);
    if within_m <= drawn_m {
        return;
    }
    let stretches = stretches(offset_m, drawn_m, within_m, [way_m[0] - foot_m, way_m[1] - foot_m]);
    let b = offset_m.max(LEAST_OFFSET * drawn_m);
    let angle = |tau: f64| (tau / b).atan();
    let turns = stretches.map(|(start, end)| (angle(end) - angle(start)).max(0.0));
    let total = turns[0] + turns[1];
    if total <= 0.0 {
        return;
    }
    scratch.rays.glow_queries += u64::from(parts);
    for part in 0..parts {
        let part = part + (scratch.leg % 4096) * MOST_PARTS;
        let u = random.glow_near(part, body.id);
        let turn = (f64::from(part % MOST_PARTS) + u) / f64::from(parts) * total;
        let (start, end, turn) = match turn < turns[0] {
            true => (stretches[0].0, stretches[0].1, turn),
            false => (stretches[1].0, stretches[1].1, turn - turns[0]),
        };
        let tau = (b * (angle(start) + turn).tan()).clamp(start, end);
        // d tau = (b^2 + tau^2) / b d phi.
        let length_m = (b * b + tau * tau) / b * total / f64::from(parts);
        let t_m = foot_m + tau;
        let on_disc = |i: u32| random.glow_near(part + ((1 + i) << 16), body.id);
        let point = Point::new(ctx.lighting, ray.origin + t_m * ray.direction, ray.direction, on_disc);
        let row = &mut scratch.glow.row;
        let Some(source) = glow.source_light(around, point, slot, 0.0, None, None, row) else { continue };
        if glow.shadows {
            shade(ctx, point.at, source, scratch);
        }
        let air = &ctx.lighting.air;
        let seen = air.scattering_per_m * air.transmittance(t_m - way_m[0]) * length_m;
        let layer = scratch.layer(Layer::Glow);
        let Scratch { path_depth, crossings, layers, glow: own, seen: from_start, .. } = scratch;
        let depth = path_depth.past(ctx.media, crossings, t_m);
        for (w, radiance) in layers[layer].iter_mut().enumerate() {
            *radiance += from_start[w] * seen * (-depth[w]).exp() * own.row[w];
        }
    }
}

/// Where along the ray, from the droplet's foot, it is nearer than `within_m` but outside of its drawn ball.
fn stretches(offset_m: f64, drawn_m: f64, within_m: f64, [from, to]: [f64; 2]) -> Stretches {
    let half = |radius: f64| (radius * radius - offset_m * offset_m).max(0.0).sqrt();
    let (inner, outer) = (half(drawn_m), half(within_m));
    let clip = |start: f64, end: f64| {
        let (start, end) = (start.max(from), end.min(to));
        if start < end { (start, end) } else { (0.0, 0.0) }
    };
    [clip(-outer, -inner), clip(inner, outer)]
}
