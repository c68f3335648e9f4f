//! A node of the tree in one line of cache: up to eight boxes, rounded outward to the node's own grid.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;

/// Most children of a node.
pub(super) const WIDTH: usize = 8;

/// Grid of the nodes' own origins, in the tree's units: 2^16 steps that reach beyond the tree on both sides. Every place on
/// it is a whole number below 2^24, so that f32 holds it.
const ORIGIN_STEP: f32 = 17.0;
const ORIGIN_MIN: f32 = -524_400.0;

/// Exponent of the smallest grid. Boxes are padded to a width of 2 (`frame`), so a step is never below 2^-7.
const LEAST_EXPONENT: u32 = 127 - 8;

/// The boxes of a node's children: inner nodes first, then bodies.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// By axis, then lower and upper side, then child.
    planes: [[[u8; WIDTH]; 2]; 3],
    origin: [u16; 3],
    /// Exponent of the grid's step above `LEAST_EXPONENT`; in the two highest bits the axis along which inner nodes are
    /// sorted.
    grid: u8,
    /// Number of inner nodes; in the four highest bits, of bodies.
    counts: u8,
    /// First inner node.
    pub child_base: u32,
    /// First body.
    pub body_base: u32,
}

/// A ray as nodes see it.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeRay {
    pub origin: Vec3A,
    pub inverse: Vec3A,
    /// Whether the ray runs downward along each axis; a fourth makes every index of two bits good.
    pub down: [bool; 4],
    pub tmax: f32,
}

impl NodeRay {
    pub fn new(ray: &Ray) -> Self {
        let [x, y, z] = ray.direction.to_array().map(|component| component < 0.0);
        Self { origin: ray.origin, inverse: ray.inv_direction, down: [x, y, z, false], tmax: ray.tmax }
    }
}

/// Where a ray meets the planes of a node: at `offset` plus `slope` times the plane's number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes<'a> {
    planes: &'a [[[u8; WIDTH]; 2]; 3],
    slope: Vec3A,
    offset: Vec3A,
}

impl Planes<'_> {
    /// The eight planes through which the ray enters (or leaves) along an axis, with their slope and offset.
    #[inline(always)]
    pub fn side(&self, ray: &NodeRay, axis: usize, leaves: bool) -> (&[u8; WIDTH], f32, f32) {
        (&self.planes[axis][usize::from(leaves ^ ray.down[axis])], self.slope[axis], self.offset[axis])
    }
}

impl Node {
    /// A node around boxes, `n_inner` of them inner nodes; `axis` is that along which these are sorted.
    pub fn new(boxes: &[Aabb], n_inner: usize, axis: usize, child_base: u32, body_base: u32) -> Self {
        let bounds = boxes.iter().fold(Aabb::empty(), |sum, aabb| sum.union(aabb));
        let cell = ((bounds.min - ORIGIN_MIN) / ORIGIN_STEP).floor().clamp(Vec3A::ZERO, Vec3A::splat(65_535.0));
        let origin = cell * ORIGIN_STEP + ORIGIN_MIN;
        let extent = (bounds.max - origin).max_element();
        let exponent = (LEAST_EXPONENT + 1..LEAST_EXPONENT + 63)
            .find(|exponent| 255.0 * f32::from_bits(exponent << 23) >= extent)
            .unwrap_or(LEAST_EXPONENT + 63);
        let per_step = 1.0 / f32::from_bits(exponent << 23);
        let mut planes = [[[0; WIDTH]; 2]; 3];
        for (child, aabb) in boxes.iter().take(WIDTH).enumerate() {
            let (lower, upper) = (((aabb.min - origin) * per_step).floor(), ((aabb.max - origin) * per_step).ceil());
            for axis in 0..3 {
                planes[axis][0][child] = lower[axis].clamp(0.0, 255.0) as u8;
                planes[axis][1][child] = upper[axis].clamp(0.0, 255.0) as u8;
            }
        }
        Self {
            planes,
            origin: cell.to_array().map(|c| c as u16),
            grid: (exponent - LEAST_EXPONENT) as u8 | (axis as u8) << 6,
            counts: n_inner as u8 | ((boxes.len() - n_inner) as u8) << 4,
            child_base,
            body_base,
        }
    }

    /// Prepares the test of a ray against all children.
    #[inline(always)]
    pub fn planes(&self, ray: &NodeRay) -> Planes<'_> {
        let [x, y, z] = self.origin.map(f32::from);
        let origin = Vec3A::new(x, y, z) * ORIGIN_STEP + ORIGIN_MIN;
        let step = f32::from_bits((u32::from(self.grid & 63) + LEAST_EXPONENT) << 23);
        Planes { planes: &self.planes, slope: step * ray.inverse, offset: (origin - ray.origin) * ray.inverse }
    }

    /// Splits the children that were met into inner nodes and bodies.
    #[inline(always)]
    pub fn split(&self, met: u32) -> (u32, u32) {
        let (n_inner, n_bodies) = (u32::from(self.counts & 15), u32::from(self.counts >> 4));
        (met & ((1 << n_inner) - 1), met >> n_inner & ((1 << n_bodies) - 1))
    }

    /// Whether the ray meets inner nodes with higher numbers first.
    #[inline(always)]
    pub fn is_reversed(&self, ray: &NodeRay) -> bool {
        ray.down[usize::from(self.grid >> 6)]
    }

    /// The same node in a larger tree.
    pub fn moved(self, nodes: u32, bodies: u32) -> Self {
        Self { child_base: self.child_base + nodes, body_base: self.body_base + bodies, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the node stores encloses what it was given, from the smallest box to the whole tree.
    #[test]
    fn boxes_are_rounded_outward() {
        for size in [2.0f32, 100.0, 1e4, 1_048_578.0] {
            for corner in [-524_289.0f32, -3.25, 0.0, 524_289.0 - size] {
                let boxes = [0.0, 0.3].map(|shift| {
                    let min = Vec3A::new(corner, corner * 0.5, -corner) + shift * size * 0.1;
                    Aabb::new(min.clamp(Vec3A::splat(-524_289.0), Vec3A::splat(524_289.0)), min + 0.9 * size)
                });
                let node = Node::new(&boxes, 1, 0, 0, 0);
                let [x, y, z] = node.origin.map(f32::from);
                let origin = Vec3A::new(x, y, z) * ORIGIN_STEP + ORIGIN_MIN;
                let step = f32::from_bits((u32::from(node.grid & 63) + LEAST_EXPONENT) << 23);
                for (child, aabb) in boxes.iter().enumerate() {
                    for axis in 0..3 {
                        let at = |side: usize| origin[axis] + step * f32::from(node.planes[axis][side][child]);
                        // Half a unit of the padding.
                        assert!(at(0) <= aabb.min[axis] + 0.5 && at(1) >= aabb.max[axis].min(524_289.0) - 0.5);
                        assert!(at(1) - at(0) < 0.9 * size + 34.0 + 0.04 * size, "{size} {corner}");
                    }
                }
                assert_eq!(node.split(0xff), (1, 1));
            }
        }
    }
}
