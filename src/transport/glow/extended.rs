//! Bodies of fog seen from nearby: points within them, drawn so that the square of the distance cancels.
//!
//! Legend: omega, solid angle in which directions are drawn; ell, length of the chord along the drawn direction. A point
//! drawn evenly along the chord stands for omega ell d^2 of volume. Theory (65).

use glam::DVec3;

use crate::accel::{Accel, Body, BodyKind, LocalRay};
use crate::transport::path::around;

/// A point of a body of fog and the volume over d^2 for which it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub point: DVec3,
    /// omega ell, m.
    pub spread_m: f64,
}

/// Draws a point of a body of fog as seen from `eye`; `None` where the drawn direction misses it.
pub(super) fn draw(accel: &Accel, body: &Body, eye: DVec3, [u0, u1, u2]: [f64; 3]) -> Option<Seen> {
    let to_center = body.center - eye;
    let reach = accel.half_edges(body);
    let reach_m2 = match body.kind() {
        BodyKind::Box => box_reach_m2(reach),
        BodyKind::Droplet | BodyKind::Glass | BodyKind::Ball => reach.x_axis.length_squared(),
    };
    // 1 - cos of the cone around the sphere that encloses the body; all directions from inside it.
    let ratio = reach_m2 / to_center.length_squared();
    let h_max = if ratio < 1.0 { ratio / (1.0 + (1.0 - ratio).sqrt()) } else { 2.0 };
    let axis = if ratio < 1.0 { to_center.normalize() } else { DVec3::Z };
    let ray = LocalRay { origin: eye, direction: around(axis, u0 * h_max, u1) };
    let (start, end) = accel.chord(&ray, body)?;
    let start = start.max(0.0);
    let distance_m = start + u2 * (end - start);
    let spread_m = std::f64::consts::TAU * h_max * (end - start);
    (end > start).then_some(Seen { point: eye + distance_m * ray.direction, spread_m })
}

/// Square of the distance of the farthest corner.
fn box_reach_m2(edges: glam::DMat3) -> f64 {
    let corner = |y: f64, z: f64| (edges.x_axis + y * edges.y_axis + z * edges.z_axis).length_squared();
    corner(1.0, 1.0).max(corner(1.0, -1.0)).max(corner(-1.0, 1.0)).max(corner(-1.0, -1.0))
}

/// A point drawn evenly from a body of fog.
pub(super) fn point_within(accel: &Accel, body: &Body, [u0, u1, u2]: [f64; 3]) -> DVec3 {
    let edges = accel.half_edges(body);
    body.center
        + match body.kind() {
            BodyKind::Box => edges * (2.0 * DVec3::new(u0, u1, u2) - DVec3::ONE),
            BodyKind::Droplet | BodyKind::Glass | BodyKind::Ball => {
                f64::from(body.radius_m) * u2.cbrt() * around(DVec3::Z, 2.0 * u0, u1)
            }
        }
}
