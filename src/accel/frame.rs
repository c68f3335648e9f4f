//! The cloud's own frame: centred and scaled so that f32 boxes, conservatively padded, hold every particle.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;

use super::body::{LocalRay, slabs};

/// Size of the cloud in the tree's units. At 2^20, the distance of 1e-4 below which obvhs drops hits is 1e-10 of the
/// cloud, far inside the padding.
const TREE_EXTENT: f64 = 1_048_576.0;

/// Padding of every box in the tree's units, 2^-20 of the cloud: four f32 roundings of a coordinate (2^-24 each), the
/// slope of 2^-23 that obvhs gives to directions parallel to an axis, and as much again.
const PADDING: f64 = 1.0;

/// Relates world space, the cloud's local frame (metres about its origin) and the tree (scaled, f32).
#[derive(Clone, Copy, Debug)]
pub(super) struct CloudFrame {
    origin_m: DVec3,
    tree_per_m: f64,
    /// Bounds in the local frame, m.
    pub min: DVec3,
    pub max: DVec3,
}

impl CloudFrame {
    /// The frame of a cloud with the given world bounds.
    pub fn new(min_m: DVec3, max_m: DVec3) -> Self {
        let origin_m = 0.5 * (min_m + max_m);
        // A cloud without any extent must not be scaled by infinity.
        let extent_m = (max_m - min_m).max_element().max(TREE_EXTENT * f64::MIN_POSITIVE);
        Self { origin_m, tree_per_m: TREE_EXTENT / extent_m, min: min_m - origin_m, max: max_m - origin_m }
    }

    pub fn local_from_world(&self, p_m: DVec3) -> DVec3 {
        p_m - self.origin_m
    }

    pub fn world_from_local(&self, p: DVec3) -> DVec3 {
        p + self.origin_m
    }

    /// A padded f32 box that encloses the local box.
    pub fn tree_box(&self, min: DVec3, max: DVec3) -> Aabb {
        let padding = DVec3::splat(PADDING);
        Aabb::new((min * self.tree_per_m - padding).as_vec3a(), (max * self.tree_per_m + padding).as_vec3a())
    }

    /// The part of `from..to` along the ray that lies in the cloud's bounds, with a margin.
    #[inline(always)]
    pub fn clip(&self, ray: &LocalRay, from: f64, to: f64) -> Option<(f64, f64)> {
        let margin = DVec3::splat(PADDING / self.tree_per_m);
        let (lower, upper) = (self.min - margin - ray.origin, self.max + margin - ray.origin);
        let (near, far) = slabs(lower, upper, ray.direction)?;
        let (t0, t1) = (from.max(near), to.min(far));
        (t0 <= t1).then_some((t0, t1))
    }

    /// The tree's ray from distance `from` to distance `to`, m.
    #[inline(always)]
    pub fn tree_ray(&self, ray: &LocalRay, from: f64, to: f64) -> Ray {
        let origin = ((ray.origin + from * ray.direction) * self.tree_per_m).as_vec3a();
        // Adding zero turns -0.0 into 0.0: obvhs takes the sign of the inverse from one and the order of the planes
        // from the other, and loses every box on -0.0.
        let direction = ray.direction.as_vec3a() + Vec3A::ZERO;
        Ray::new(origin, direction, 0.0, self.tree_distance(to - from))
    }

    /// A distance in the tree's units, rounded up past the padding so that nothing nearer is lost.
    pub fn tree_distance(&self, t_m: f64) -> f32 {
        (t_m * self.tree_per_m + 2.0 * PADDING) as f32 * (1.0 + 4.0 * f32::EPSILON)
    }
}
