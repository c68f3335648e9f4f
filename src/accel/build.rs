//! Places particles and fog boxes in the cloud's frame, builds the tree over them and lays them out along it.

use glam::{DMat3, DVec3};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use super::body::{Body, BodyKind, BoxShape};
use super::frame::CloudFrame;
use super::group::{group_coincident, morton_key};
use super::node::Node;
use super::tree::{Tree, parts};
use super::walk::Walker;
use super::{Accel, LINEAR_LIMIT, Placed, PlacedBox};

/// Builds in a frame of its own, or in a given one whose bounds hold everything.
pub(super) fn build(particles: Vec<Placed>, fog_boxes: &[PlacedBox], frame: Option<CloudFrame>) -> Accel {
    let frame = frame.unwrap_or_else(|| {
        let (min_m, max_m) = world_bounds(&particles, fog_boxes);
        CloudFrame::new(min_m, max_m)
    });
    let boxes: Vec<BoxShape> = fog_boxes.iter().map(|b| box_shape(b.half_edges_m)).collect();
    let mut bodies = place(particles, fog_boxes, &frame);
    let (mut group_start, mut nodes) = (Vec::new(), Vec::new());
    if bodies.len() > LINEAR_LIMIT {
        group_start = group_coincident(&mut bodies, frame.min, frame.max);
        nodes = build_tree(&mut bodies, &mut group_start, &boxes, &frame);
    }
    if group_start.len() == bodies.len() + 1 {
        group_start = Vec::new();
    }
    Accel { frame, bodies, boxes, group_start, nodes, walker: Walker::detect() }
}

/// Bounds of all discs, balls and boxes in world space.
fn world_bounds(particles: &[Placed], fog_boxes: &[PlacedBox]) -> (DVec3, DVec3) {
    let empty = (DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY));
    let unite = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
    let (min, max) = particles
        .par_iter()
        .map(|p| around(p.center_m, DVec3::splat(f64::from(p.radius_m))))
        .chain(fog_boxes.par_iter().map(|b| around(b.center_m, box_reach(b.half_edges_m))))
        .reduce(|| empty, unite);
    if min.x > max.x { (DVec3::ZERO, DVec3::ZERO) } else { (min, max) }
}

fn around(center: DVec3, reach: DVec3) -> (DVec3, DVec3) {
    (center - reach, center + reach)
}

/// Half the axis-aligned extent of an oriented box.
fn box_reach(half_edges: DMat3) -> DVec3 {
    half_edges.x_axis.abs() + half_edges.y_axis.abs() + half_edges.z_axis.abs()
}

fn box_shape(half_edges: DMat3) -> BoxShape {
    BoxShape { half_edges, cube_from_local: half_edges.inverse() }
}

/// Numbers the bodies, particles first, and takes them to the cloud's frame: in place, since both are of one size.
fn place(particles: Vec<Placed>, fog_boxes: &[PlacedBox], frame: &CloudFrame) -> Vec<Body> {
    let n_particles = particles.len() as u32;
    let placed = particles.into_iter().enumerate();
    let mut bodies: Vec<Body> = placed
        .map(|(i, p)| Body::new(frame.local_from_world(p.center_m), p.radius_m, p.load, p.bin, p.kind, i as u32))
        .collect();
    bodies.extend(fog_boxes.iter().zip(n_particles..).map(|(b, id)| {
        let shape = (id - n_particles) as f32;
        Body::new(
            frame.local_from_world(b.center_m),
            shape,
            b.number_per_m3.min(f64::from(f32::MAX)) as f32,
            b.bin,
            BodyKind::Box,
            id,
        )
    }));
    bodies
}

/// Builds the tree part by part, and sorts each part's groups, and the table of their first bodies, along it.
fn build_tree(bodies: &mut [Body], group_start: &mut [u32], boxes: &[BoxShape], frame: &CloudFrame) -> Vec<Node> {
    let key = |group: usize| morton_key(bodies[group_start[group] as usize].center, frame.min, frame.max);
    let ranges = parts(0..group_start.len() - 1, &key);
    let firsts: Vec<u32> = ranges.iter().map(|range| range.start as u32).collect();
    let mut rest = (bodies, group_start);
    let mut work = Vec::with_capacity(ranges.len());
    for range in ranges {
        let (starts, later_starts) = std::mem::take(&mut rest.1).split_at_mut(range.len());
        let n_bodies = later_starts[0] - starts[0];
        let (part, later) = std::mem::take(&mut rest.0).split_at_mut(n_bodies as usize);
        work.push((part, starts, n_bodies));
        rest = (later, later_starts);
    }
    let trees: Vec<Tree> = work
        .into_par_iter()
        .map(|(bodies, starts, n_bodies)| {
            let first = starts[0];
            let groups: Vec<&[Body]> = starts
                .iter()
                .zip(starts.iter().skip(1).chain([&(first + n_bodies)]))
                .map(|(start, end)| &bodies[(start - first) as usize..(end - first) as usize])
                .collect();
            let leaf_boxes: Vec<Aabb> = groups.iter().map(|group| group_box(group, boxes, frame)).collect();
            let tree = Tree::new(&leaf_boxes);
            let sorted: Vec<Body> = tree.order.iter().flat_map(|group| groups[*group as usize]).copied().collect();
            let mut new_starts = vec![first];
            new_starts.extend(tree.order.iter().scan(first, |end, group| {
                *end += groups[*group as usize].len() as u32;
                Some(*end)
            }));
            new_starts.pop();
            bodies.copy_from_slice(&sorted);
            starts.copy_from_slice(&new_starts);
            Tree { order: Vec::new(), ..tree }
        })
        .collect();
    Tree::join(trees.into_iter().zip(firsts).collect())
}

/// The padded box of a group.
fn group_box(group: &[Body], boxes: &[BoxShape], frame: &CloudFrame) -> Aabb {
    group.iter().fold(Aabb::empty(), |sum, body| {
        let reach = match body.kind() {
            BodyKind::Box => box_reach(boxes[body.box_index()].half_edges),
            _ => DVec3::splat(f64::from(body.radius_m)),
        };
        let (min, max) = around(body.center, reach);
        sum.union(&frame.tree_box(min, max))
    })
}
