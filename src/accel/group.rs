//! Groups particles that the tree cannot tell apart: obvhs' builder is quadratic in coincident centres, and its tree a
//! list.

use glam::DVec3;
use rayon::prelude::*;

use super::body::{Body, BodyKind};

/// Bits per axis of the grid on which centres count as coincident: the padding of the tree's boxes.
const BITS: u32 = 20;

/// Sorts bodies along a Morton curve, merges identical ones, and returns the first body of each group, one more at the
/// end. Works in place: there may be as many bodies as memory holds.
pub(super) fn group_coincident(bodies: &mut Vec<Body>, min: DVec3, max: DVec3) -> Vec<u32> {
    let mut keys: Vec<(u64, u32)> =
        bodies.par_iter().enumerate().map(|(i, body)| (morton_key(body.center, min, max), i as u32)).collect();
    keys.par_sort_unstable_by(|a, b| {
        let by_body = || bodies[a.1 as usize].sort_key().cmp(&bodies[b.1 as usize].sort_key());
        a.0.cmp(&b.0).then_with(by_body)
    });
    permute(bodies, &mut keys);
    let mut group_start: Vec<u32> = Vec::with_capacity(keys.len() + 1);
    let mut last_key = None;
    // A million f32 additions would lose a percent.
    let mut load = 0.0f64;
    let mut kept = 0;
    for (read, (key, _)) in keys.iter().enumerate() {
        let body = bodies[read];
        if last_key != Some(key) {
            group_start.push(kept as u32);
            last_key = Some(key);
        } else if mergeable(&bodies[kept - 1], &body) {
            load += f64::from(body.load);
            bodies[kept - 1].load = load.min(f64::from(f32::MAX)) as f32;
            continue;
        }
        load = f64::from(body.load);
        bodies[kept] = body;
        kept += 1;
    }
    bodies.truncate(kept);
    group_start.push(kept as u32);
    group_start
}

/// Brings the bodies into the order of the indices beside the keys, cycle by cycle; the indices are used up.
fn permute(bodies: &mut [Body], keys: &mut [(u64, u32)]) {
    for first in 0..keys.len() {
        let displaced = bodies[first];
        let mut to = first;
        loop {
            let from = std::mem::replace(&mut keys[to].1, to as u32) as usize;
            if from == first {
                bodies[to] = displaced;
                break;
            }
            bodies[to] = bodies[from];
            to = from;
        }
    }
}

/// Place of a centre on the Morton curve through the cells on which centres coincide.
pub(super) fn morton_key(center: DVec3, min: DVec3, max: DVec3) -> u64 {
    let cells_per_m =
        f64::from(1u32 << BITS) / (max - min).max_element().max(f64::from(1u32 << BITS) * f64::MIN_POSITIVE);
    morton((center - min) * cells_per_m)
}

/// Identical droplets are one that is met several times; identical balls are one as dense as all of them.
fn mergeable(a: &Body, b: &Body) -> bool {
    a.kind() != BodyKind::Box && a.coincides(b)
}

/// Interleaves the cell's three coordinates.
fn morton(cell: DVec3) -> u64 {
    let limit = f64::from((1u32 << BITS) - 1);
    let [x, y, z] = cell.to_array().map(|c| spread(c.clamp(0.0, limit) as u64));
    x | y << 1 | z << 2
}

/// Puts two zero bits between the low 21 bits (Warren, Hacker's Delight 2nd ed. 2012, 7-2).
fn spread(v: u64) -> u64 {
    let v = (v | v << 32) & 0x001f_0000_0000_ffff;
    let v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    let v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    let v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    fn droplet(x: f64, id: u32) -> Body {
        Body::new(DVec3::new(x, 0.0, 0.0), 0.1, 1.0, 3, BodyKind::Droplet, id)
    }

    #[test]
    fn identical_droplets_become_one_with_their_number() {
        let mut bodies: Vec<Body> = (0..1000).map(|id| droplet(0.0, id)).chain([droplet(1.0, 1000)]).collect();
        let start = group_coincident(&mut bodies, DVec3::splat(-1.0), DVec3::splat(1.0));
        assert_eq!(start, [0, 1, 2]);
        assert_eq!((bodies[0].load, bodies[1].load), (1000.0, 1.0));
    }

    #[test]
    fn the_sum_of_a_million_densities_is_exact_to_f32() {
        let mut bodies: Vec<Body> = (0..1_000_000).map(|id| droplet(0.0, id)).collect();
        bodies.iter_mut().for_each(|body| body.load = 0.1);
        group_coincident(&mut bodies, DVec3::splat(-1.0), DVec3::splat(1.0));
        assert_eq!((bodies.len(), bodies[0].load), (1, (1e6 * f64::from(0.1f32)) as f32));
    }

    #[test]
    fn coincident_but_different_droplets_share_a_group() {
        let mut wider = droplet(0.0, 1);
        wider.radius_m = 0.2;
        let mut bodies = vec![droplet(0.0, 0), wider, droplet(1.0, 2)];
        let start = group_coincident(&mut bodies, DVec3::splat(-1.0), DVec3::splat(1.0));
        assert_eq!(start, [0, 2, 3]);
    }
}
