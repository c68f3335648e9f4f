//! Builds the tree over groups of particles and lays the particles out along it.

use glam::{DMat3, DVec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use rayon::prelude::*;

use super::body::{Body, BodyKind, BoxShape};
use super::frame::CloudFrame;
use super::group::group_coincident;
use super::walk::Walker;
use super::{Accel, LINEAR_LIMIT, Placed, PlacedBox};

/// Depth of a tree that the walk's stack holds; obvhs' own, of 32, silently forgets what does not fit.
pub(super) const MAX_WIDE_DEPTH: usize = 31;

/// obvhs converts trees by recursion; a balanced tree of 2^32 leaves is half as deep.
const MAX_BINARY_DEPTH: usize = 64;

/// obvhs' preset that builds fastest; slower ones gain nothing on evenly spread spheres.
const PRESET: BvhBuildParams = BvhBuildParams::very_fast_build();

/// Builds in a frame of its own, or in a given one whose bounds hold everything.
pub(super) fn build(particles: Vec<Placed>, fog_boxes: &[PlacedBox], frame: Option<CloudFrame>) -> Accel {
    let frame = frame.unwrap_or_else(|| {
        let (min_m, max_m) = world_bounds(&particles, fog_boxes);
        CloudFrame::new(min_m, max_m)
    });
    let boxes: Vec<BoxShape> = fog_boxes.iter().map(|b| box_shape(b.half_edges_m)).collect();
    let mut bodies = place(particles, fog_boxes, &frame);
    if bodies.len() <= LINEAR_LIMIT {
        return Accel { frame, bodies, boxes, group_start: Vec::new(), tree: None, walker: Walker::detect() };
    }
    let start = group_coincident(&mut bodies, frame.min, frame.max);
    let leaf_boxes = leaf_boxes(&bodies, &start, &boxes, &frame);
    let tree = build_tree(&leaf_boxes);
    let (bodies, group_start) = reorder(&bodies, &start, &tree.primitive_indices);
    Accel {
        frame,
        bodies,
        boxes,
        group_start,
        tree: Some(CwBvh { primitive_indices: Vec::new(), ..tree }),
        walker: Walker::detect(),
    }
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

/// Numbers the bodies, particles first, and takes them to the cloud's frame.
fn place(particles: Vec<Placed>, fog_boxes: &[PlacedBox], frame: &CloudFrame) -> Vec<Body> {
    let n_particles = particles.len() as u32;
    let mut bodies = Vec::with_capacity(particles.len() + fog_boxes.len());
    particles
        .into_par_iter()
        .enumerate()
        .map(|(i, p)| Body::new(frame.local_from_world(p.center_m), p.radius_m, p.load, p.bin, p.kind, i as u32))
        .collect_into_vec(&mut bodies);
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

/// One padded box per group.
fn leaf_boxes(bodies: &[Body], start: &[u32], boxes: &[BoxShape], frame: &CloudFrame) -> Vec<Aabb> {
    start
        .par_windows(2)
        .map(|range| {
            bodies[range[0] as usize..range[1] as usize]
                .iter()
                .map(|body| {
                    let reach = match body.kind() {
                        BodyKind::Box => box_reach(boxes[body.box_index()].half_edges),
                        _ => DVec3::splat(f64::from(body.radius_m)),
                    };
                    let (min, max) = around(body.center, reach);
                    frame.tree_box(min, max)
                })
                .reduce(|a, b| a.union(&b))
                .unwrap_or_else(Aabb::empty)
        })
        .collect()
}

/// A wide tree, by obvhs' clustering where that is shallow enough, otherwise balanced along the Morton curve.
fn build_tree(leaf_boxes: &[Aabb]) -> CwBvh {
    let indices: Vec<u32> = (0..leaf_boxes.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(leaf_boxes.len()).build(
        PRESET.ploc_search_distance,
        leaf_boxes,
        indices,
        PRESET.sort_precision,
        PRESET.search_depth_threshold,
    );
    if binary.max_depth <= 96 {
        ReinsertionOptimizer::default().run(&mut binary, PRESET.reinsertion_batch_ratio, None);
    }
    if binary_depth(&binary) <= MAX_BINARY_DEPTH {
        let wide = widen(&binary);
        if wide_depth(&wide) <= MAX_WIDE_DEPTH {
            return wide;
        }
    }
    widen(&balanced(leaf_boxes))
}

fn widen(binary: &Bvh2) -> CwBvh {
    let mut wide = bvh2_to_cwbvh(binary, PRESET.max_prims_per_leaf.clamp(1, 3), true, false);
    wide.nodes.shrink_to_fit();
    wide
}

/// Depth of a binary tree, without recursion.
fn binary_depth(tree: &Bvh2) -> usize {
    let mut stack = vec![(0usize, 1usize)];
    let mut deepest = 0;
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            stack.extend([0, 1].map(|child| (node.first_index as usize + child, depth + 1)));
        }
    }
    deepest
}

/// Depth of a wide tree, without recursion.
fn wide_depth(tree: &CwBvh) -> usize {
    let mut stack = vec![(0usize, 1usize)];
    let mut deepest = 0;
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index];
        stack.extend((0..node.imask.count_ones() as usize).map(|c| (node.child_base_idx as usize + c, depth + 1)));
    }
    deepest
}

/// A binary tree that halves the leaves in the order given: as deep as the logarithm of their number.
fn balanced(leaf_boxes: &[Aabb]) -> Bvh2 {
    let mut tree = Bvh2 { nodes: vec![Bvh2Node::default()], ..Bvh2::default() };
    tree.primitive_indices = (0..leaf_boxes.len() as u32).collect();
    fill_balanced(&mut tree, leaf_boxes, 0, 0);
    tree.children_are_ordered_after_parents = true;
    tree
}

fn fill_balanced(tree: &mut Bvh2, leaf_boxes: &[Aabb], node: usize, first: usize) -> Aabb {
    if let [only] = leaf_boxes {
        tree.nodes[node] = Bvh2Node::new(*only, 1, first as u32);
        return *only;
    }
    let children = tree.nodes.len();
    tree.nodes.extend([Bvh2Node::default(); 2]);
    let half = leaf_boxes.len() / 2;
    let left = fill_balanced(tree, &leaf_boxes[..half], children, first);
    let right = fill_balanced(tree, &leaf_boxes[half..], children + 1, first + half);
    let both = left.union(&right);
    tree.nodes[node] = Bvh2Node::new(both, 0, children as u32);
    both
}

/// Lays the bodies out in the tree's order; the group table is dropped where every group is one body.
fn reorder(bodies: &[Body], start: &[u32], order: &[u32]) -> (Vec<Body>, Vec<u32>) {
    let mut sorted = Vec::with_capacity(bodies.len());
    let mut group_start = Vec::new();
    let grouped = bodies.len() + 1 != start.len();
    for &group in order {
        if grouped {
            group_start.push(sorted.len() as u32);
        }
        sorted.extend_from_slice(&bodies[start[group as usize] as usize..start[group as usize + 1] as usize]);
    }
    if grouped {
        group_start.push(sorted.len() as u32);
    }
    (sorted, group_start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balanced_tree_is_shallow_and_holds_every_leaf() {
        let leaves: Vec<Aabb> = (0..1000).map(|i| Aabb::from_point(glam::Vec3A::splat(i as f32 * 100.0))).collect();
        let tree = balanced(&leaves);
        assert_eq!(binary_depth(&tree), 11);
        assert_eq!(tree.nodes.iter().filter(|node| node.is_leaf()).count(), 1000);
        assert!(wide_depth(&widen(&tree)) <= 8);
    }
}
