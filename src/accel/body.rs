//! What a ray can meet, and where exactly it meets it: disc, ball, box, in f64.

use glam::{DMat3, DVec3};

/// How a body removes light from a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum BodyKind {
    /// A droplet: met at one point, on a disc perpendicular to the ray around its centre.
    Droplet,
    /// A ball of fog: met along a chord.
    Ball,
    /// An oriented box of fog: met along a chord.
    Box,
    /// A droplet that can be seen: for sunlight as `Droplet`; other rays meet its ball, which stands in a tree of its own.
    Glass,
}

/// One droplet, parcel or fog box; 40 bytes, since there are millions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Body {
    /// Centre relative to the cloud's origin, m.
    pub center: DVec3,
    /// Disc or ball radius, m. A box keeps the index of its shape here, exact below 2^24.
    pub radius_m: f32,
    /// Droplets: how many coincide; fog: droplets per cubic metre.
    pub load: f32,
    /// Kind in the two highest bits, size bin below.
    tag: u32,
    /// Number in the scene, whatever the tree's order; seeds the body's random numbers.
    pub id: u32,
}

const KIND_SHIFT: u32 = 30;

impl Body {
    pub(super) fn new(center: DVec3, radius_m: f32, load: f32, bin: u32, kind: BodyKind, id: u32) -> Self {
        Self { center, radius_m, load, tag: (kind as u32) << KIND_SHIFT | bin, id }
    }

    /// Index of the size bin.
    #[inline]
    pub fn bin(&self) -> usize {
        (self.tag & ((1 << KIND_SHIFT) - 1)) as usize
    }

    /// What it is.
    #[inline]
    pub fn kind(&self) -> BodyKind {
        match self.tag >> KIND_SHIFT {
            0 => BodyKind::Droplet,
            1 => BodyKind::Ball,
            2 => BodyKind::Box,
            _ => BodyKind::Glass,
        }
    }

    /// Whether it is met at one point, on a disc.
    #[inline]
    pub fn is_disc(&self) -> bool {
        matches!(self.kind(), BodyKind::Droplet | BodyKind::Glass)
    }

    /// Index of a box's shape.
    #[inline]
    pub(super) fn box_index(&self) -> usize {
        self.radius_m as usize
    }

    /// Whether two bodies are the same but for their load and number.
    pub(super) fn coincides(&self, other: &Body) -> bool {
        self.center == other.center && self.radius_m == other.radius_m && self.tag == other.tag
    }

    /// Sorts bodies that coincide next to each other.
    pub(super) fn sort_key(&self) -> (u32, u32, [u64; 3], u32) {
        (self.tag, self.radius_m.to_bits(), self.center.to_array().map(f64::to_bits), self.id)
    }
}

/// The shape of a fog box, which a body refers to.
#[derive(Clone, Copy, Debug)]
pub struct BoxShape {
    pub(super) half_edges: DMat3,
    /// Takes an offset from the centre to the cube [-1, 1]^3.
    pub(super) cube_from_local: DMat3,
}

/// A ray relative to the cloud's origin, in metres; `direction` has unit length.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    /// Start of the ray.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

/// Where a ray meets a body, as distances from its origin, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// A droplet's disc.
    Point(f64),
    /// From entry to exit, not clipped to the ray's start.
    Chord(f64, f64),
}

impl Crossing {
    /// Where it begins.
    #[inline]
    pub fn start(self) -> f64 {
        match self {
            Crossing::Point(t) | Crossing::Chord(t, _) => t,
        }
    }

    /// What lies before a distance.
    #[inline]
    pub fn before(self, t_m: f64) -> Self {
        match self {
            Crossing::Chord(start, end) => Crossing::Chord(start, end.min(t_m)),
            point => point,
        }
    }

    /// Where it ends.
    #[inline]
    pub fn end(self) -> f64 {
        match self {
            Crossing::Point(t) | Crossing::Chord(_, t) => t,
        }
    }
}

/// Where a ray crosses a ball or disc of the given radius about `center`.
///
/// The offset from the ray is formed as a vector before it is squared: the difference of two squares loses a droplet of
/// 1 um at 1 km.
#[inline(always)]
pub(super) fn cross_sphere(ray: &LocalRay, center: DVec3, radius_m: f64) -> Option<(f64, f64)> {
    let to_center = center - ray.origin;
    let t = to_center.dot(ray.direction);
    let offset = to_center - t * ray.direction;
    let rest = radius_m * radius_m - offset.length_squared();
    (rest > 0.0).then_some((t, rest))
}

/// Where a ray crosses an oriented box about `center`.
#[inline(always)]
pub(super) fn cross_box(ray: &LocalRay, center: DVec3, shape: &BoxShape) -> Option<(f64, f64)> {
    let o = shape.cube_from_local * (ray.origin - center);
    let d = shape.cube_from_local * ray.direction;
    let (t0, t1) = slabs(-1.0 - o, 1.0 - o, d)?;
    (t0 < t1).then_some((t0, t1))
}

/// Where a ray from the origin enters and leaves the slabs between two corners, the first below the second; `None` where it
/// runs beside one.
#[inline(always)]
pub(super) fn slabs(lower: DVec3, upper: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let inverse = direction.recip();
    let (a, b) = (lower * inverse, upper * inverse);
    let (mut near, mut far) = (a.min(b), a.max(b));
    let parallel = direction.cmpeq(DVec3::ZERO);
    if parallel.any() {
        if (parallel & (lower.cmpgt(DVec3::ZERO) | upper.cmplt(DVec3::ZERO))).any() {
            return None;
        }
        near = DVec3::select(parallel, DVec3::NEG_INFINITY, near);
        far = DVec3::select(parallel, DVec3::INFINITY, far);
    }
    Some((near.max_element(), far.min_element()))
}
