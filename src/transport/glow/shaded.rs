//! One source of glow that stands for all, through what is in its way.
//!
//! Where particles shade each other, light from source i arrives with the transmittance T_i of the way. One i is drawn in
//! proportion to what it brings, and its T_i and light over that probability stand for the sum (theory (66)): one ray per
//! step, and no noise where nothing is in the way but that of colour.

use glam::DVec3;

use super::Glow;
use super::exact::{Around, Point};
use super::extended::point_within;
use super::eye::Eye;
use super::gather::{GlowScratch, band_weight, fog_draws};
use super::sources::LEAF;
use super::weigh::Item;
use crate::accel::LocalRay;
use crate::transport::random::PathRandom;
use crate::transport::sample::RenderContext;
use crate::transport::scratch::Scratch;

/// Adds one item, drawn in proportion to its light, over its probability, through what is in its way.
#[allow(clippy::too_many_arguments)] // one estimate, with everything it draws
pub(super) fn add_one(
    ctx: &RenderContext,
    glow: &Glow,
    around: &Around,
    point: Point,
    eye: &Eye,
    step: u32,
    random: &PathRandom,
    [u_pick, u_member]: [f64; 2],
    scratch: &mut Scratch,
) {
    let items = &scratch.glow.cut.items;
    let total: f64 = items.iter().map(|item| f64::from(item.light)).sum();
    let mut rest = u_pick * total;
    let chosen = items.iter().filter(|item| item.light > 0.0).find(|item| {
        rest -= f64::from(item.light);
        rest < 0.0
    });
    // Rounding can leave a rest behind the last.
    let Some(item) = chosen.or(items.iter().rfind(|item| item.light > 0.0)).copied() else { return };
    let over_probability = total / f64::from(item.light);
    let slot = glow.member(&item, u_member);
    let body = around.accel.body(glow.slots[slot].body);
    let draws = fog_draws(glow, around, random, step, slot);
    let source = if item.is_leaf && item.error > scratch.glow.limit {
        let Some(seen) = glow.draw_point(around, point, slot, draws) else { return };
        light_point(ctx, &point, seen.point, scratch);
        let GlowScratch { row, lit, .. } = &mut scratch.glow;
        let source = glow.source_light(around, point, slot, glow.near_m, Some(seen), Some(lit), row);
        let thinned = f64::from(band_weight(eye, glow, &item));
        row.iter_mut().for_each(|row| *row *= thinned * over_probability);
        source
    } else {
        let row = &mut scratch.glow.row;
        row.fill(0.0);
        glow.add_light(around.accel, around.lighting, eye, &item, row);
        row.iter_mut().for_each(|row| *row *= glow.scale * over_probability);
        let is_fog = !body.is_disc();
        Some(if is_fog { point_within(around.accel, body, draws) } else { body.center })
    };
    if let Some(source) = source {
        shade(ctx, point.at, source, scratch);
        let GlowScratch { sum, row, .. } = &mut scratch.glow;
        sum.iter_mut().zip(&*row).for_each(|(sum, row)| *sum += row);
    }
}

impl Glow {
    /// A source below an item, drawn by weight.
    fn member(&self, item: &Item, mut u: f64) -> usize {
        let (mut octet, mut k) = (&self.tree.octets[item.node as usize / LEAF], item.node as usize % LEAF);
        while !octet.is_leaf {
            octet = &self.tree.octets[octet.child[k] as usize];
            let weights = &octet.weight[..usize::from(octet.count)];
            let total: f64 = weights.iter().map(|weight| f64::from(*weight)).sum();
            let mut rest = u * total;
            k = weights.len() - 1;
            for (i, weight) in weights.iter().enumerate() {
                let weight = f64::from(*weight);
                if rest < weight {
                    k = i;
                    // What is left of the number is uniform again.
                    u = (rest / weight).clamp(0.0, 1.0 - f64::EPSILON);
                    break;
                }
                rest -= weight;
            }
        }
        octet.child[k] as usize
    }
}

/// Fills `scratch.glow.lit` with the transmittance toward the suns from a point of fog.
fn light_point(ctx: &RenderContext, point: &Point, origin: DVec3, scratch: &mut Scratch) {
    let n = ctx.media.n_wavelengths();
    for s in 0..ctx.lighting.suns.len() {
        let direction = -point.sun(s, ctx.lighting);
        scratch.light_sun(ctx, &LocalRay { origin, direction });
        let Scratch { glow, sunlit, .. } = scratch;
        glow.lit[s * n..(s + 1) * n].iter_mut().zip(&*sunlit).for_each(|(lit, sunlit)| *lit = *sunlit as f32);
    }
}

/// Multiplies `scratch.glow.row` with the transmittance of the particles between a source and a point.
pub(super) fn shade(ctx: &RenderContext, point: DVec3, source: DVec3, scratch: &mut Scratch) {
    let way = point - source;
    let distance_m = way.length();
    if distance_m == 0.0 {
        return;
    }
    scratch.rays.shadow += 1;
    // From the source outwards: a droplet does not meet what it scattered.
    let ray = LocalRay { origin: source, direction: way / distance_m };
    let depth = scratch.sun_depth.along(ctx.accel, ctx.media, &ray, distance_m);
    scratch.glow.row.iter_mut().zip(depth).for_each(|(row, depth)| *row *= (-depth).exp());
}

/// Sums over all sources of the tree one by one; where they shade each other, one stands for all.
pub(super) fn sum_exactly(
    ctx: &RenderContext,
    glow: &Glow,
    around: &Around,
    point: Point,
    step: u32,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    let (mut total, mut kept) = (0.0, None);
    for slot in 0..glow.n_in_tree {
        let seen = glow.draw_point(around, point, slot, fog_draws(glow, around, random, step, slot));
        let GlowScratch { row, sum, lit, .. } = &mut scratch.glow;
        // Where fog is in the sun is found out when it is drawn.
        lit.fill(1.0);
        let full = seen.map(|_| &lit[..]);
        let Some(source) = glow.source_light(around, point, slot, glow.near_m, seen, full, row) else { continue };
        if !glow.shadows {
            sum.iter_mut().zip(&*row).for_each(|(sum, row)| *sum += row);
            continue;
        }
        let light: f64 = row.iter().zip(&ctx.lighting.luminance_weights).map(|(row, share)| row * share).sum();
        total += light;
        let id = around.accel.body(glow.slots[slot].body).id;
        if light > 0.0 && random.glow_body(step, 3, id) * total < light {
            kept = Some((slot, seen, source, light));
        }
    }
    let Some((slot, seen, source, light)) = kept else { return };
    if seen.is_some() {
        light_point(ctx, &point, source, scratch);
    }
    let GlowScratch { row, lit, .. } = &mut scratch.glow;
    let at_point = seen.map(|_| &lit[..]);
    glow.source_light(around, point, slot, glow.near_m, seen, at_point, row);
    row.iter_mut().for_each(|row| *row *= total / light);
    shade(ctx, point.at, source, scratch);
    let GlowScratch { sum, row, .. } = &mut scratch.glow;
    sum.iter_mut().zip(&*row).for_each(|(sum, row)| *sum += row);
}
