//! Finds the particles that a ray meets: an obvhs BVH over droplets, parcels and fog boxes.
//!
//! The tree works in f32 in a frame of its own (`frame`); every crossing is then computed in f64 (`body`), so the
//! tree decides only what is looked at, never what is found. Particles are reordered along the tree.

mod body;
mod build;
mod frame;
mod group;
mod node;
mod query;
mod tree;
mod walk;

pub use body::{Body, BodyKind, BoxShape, Crossing, LocalRay};
pub use query::Hit;

use frame::CloudFrame;
use glam::{DMat3, DVec3};
use node::Node;
use walk::Walker;

/// A body before it is placed: what the rest of the program knows of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Centre in world space, m.
    pub center_m: DVec3,
    /// Radius of the extinction disc (droplet) or of the ball (parcel), m.
    pub radius_m: f32,
    /// Droplets: how many coincide here (1). Parcels: droplets per cubic metre.
    pub load: f32,
    /// Index of the size bin.
    pub bin: u32,
    /// Droplet or parcel.
    pub kind: BodyKind,
}

/// An oriented fog box before it is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedBox {
    /// Centre in world space, m.
    pub center_m: DVec3,
    /// Columns are the half edges, m.
    pub half_edges_m: DMat3,
    /// Droplets per cubic metre.
    pub number_per_m3: f64,
    /// Index of the size bin.
    pub bin: u32,
}

/// Everything that a ray can meet.
pub struct Accel {
    frame: CloudFrame,
    bodies: Vec<Body>,
    boxes: Vec<BoxShape>,
    /// First body of each primitive of the tree, one more at the end; empty where every primitive is one body.
    group_start: Vec<u32>,
    /// The tree, its root first; empty where so few bodies exist that testing them all is faster.
    nodes: Vec<Node>,
    walker: Walker,
}

/// At most this many bodies are tested one by one: entering a tree of two nodes costs as much as 30 sphere tests, or ten
/// of boxes.
const LINEAR_LIMIT: usize = 16;

impl Accel {
    /// The same, walked as on a processor without vector instructions; for tests and measurements.
    pub fn without_simd(self) -> Self {
        Self { walker: Walker::Plain, ..self }
    }

    /// Builds the tree. The order of `particles` numbers them for the random numbers of free flight.
    pub fn build(particles: Vec<Placed>, fog_boxes: &[PlacedBox]) -> Self {
        build::build(particles, fog_boxes, None)
    }

    /// Builds a second tree in the frame of this one, so that one ray serves both. Its particles must lie within the bounds
    /// of this one.
    pub fn build_beside(&self, particles: Vec<Placed>) -> Self {
        build::build(particles, &[], Some(self.frame))
    }

    /// Number of bodies, coincident identical ones counted once.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there is nothing to meet.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// A body by its place in the tree, as `Hit` names it.
    pub fn body(&self, index: u32) -> &Body {
        &self.bodies[index as usize]
    }

    /// All bodies, in the tree's order.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Where a ray crosses a body of fog, as distances from its origin, m.
    pub fn chord(&self, ray: &LocalRay, body: &Body) -> Option<(f64, f64)> {
        self.cross(ray, body).map(|crossing| (crossing.start(), crossing.end()))
    }

    /// Half edges of a fog box, m, as columns; of what surrounds a droplet or ball as closely.
    pub fn half_edges(&self, body: &Body) -> DMat3 {
        match body.kind() {
            BodyKind::Box => self.boxes[body.box_index()].half_edges,
            BodyKind::Droplet | BodyKind::Glass | BodyKind::Ball => {
                DMat3::from_diagonal(DVec3::splat(f64::from(body.radius_m)))
            }
        }
    }

    /// Bytes held by the particles' geometry.
    pub fn geometry_bytes(&self) -> usize {
        size_of_val(&self.bodies[..]) + size_of_val(&self.boxes[..]) + size_of_val(&self.group_start[..])
    }

    /// Bytes held by the tree.
    pub fn tree_bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
    }

    /// World-space bounds of everything, m; `None` where there is nothing.
    pub fn bounds_m(&self) -> Option<(DVec3, DVec3)> {
        (!self.is_empty())
            .then(|| (self.frame.world_from_local(self.frame.min), self.frame.world_from_local(self.frame.max)))
    }

    /// Bounds of everything in the cloud's own frame, m; `None` where there is nothing.
    pub fn local_bounds(&self) -> Option<(DVec3, DVec3)> {
        (!self.is_empty()).then_some((self.frame.min, self.frame.max))
    }

    /// World-space centre of a body, m.
    pub fn center_m(&self, body: &Body) -> DVec3 {
        self.frame.world_from_local(body.center)
    }
}
