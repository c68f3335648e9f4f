//! A camera and a sun for scenes that bring none: the whole cloud in view, white light from the upper left.

use glam::{DMat3, DVec3};

use super::model::{Camera, FogBox, Lens, Particle, Sun};

/// Half of the vertical field of view of the camera that frames the cloud, rad: 20 degrees, a moderate wide angle.
const HALF_YFOV_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Air around the cloud, as a factor on its width and height.
const MARGIN: f64 = 1.1;
/// Distance at which an empty scene is looked at, m.
const EMPTY_RADIUS_M: f64 = 1.0;
/// The default sun: a clear sky at noon, lx.
const DEFAULT_SUN_LUX: f64 = 100_000.0;
/// To the right, down, and away from the camera a bit, in the camera's frame.
const DEFAULT_SUN_IN_CAMERA: DVec3 = DVec3::new(1.0, -1.0, -0.5);

/// The box that encloses all particles and fog boxes; `None` where there are none.
pub fn bounds_m(particles: &[Particle], fog_boxes: &[FogBox]) -> Option<(DVec3, DVec3)> {
    let balls = particles.iter().map(|p| (p.center_m, DVec3::splat(f64::from(p.radius_m))));
    let boxes = fog_boxes.iter().map(|b| {
        let edges = b.half_edges_m;
        (b.center_m, edges.x_axis.abs() + edges.y_axis.abs() + edges.z_axis.abs())
    });
    balls
        .chain(boxes)
        .map(|(center, half)| (center - half, center + half))
        .reduce(|(min, max), (low, high)| (min.min(low), max.max(high)))
}

/// A camera on the +Z side that sees the box around the cloud whole, at the given width / height.
pub fn framing_camera(particles: &[Particle], fog_boxes: &[FogBox], width_over_height: f64) -> Camera {
    let (center_m, half_m) = match bounds_m(particles, fog_boxes) {
        Some((min, max)) => (0.5 * (min + max), 0.5 * (max - min)),
        None => (DVec3::ZERO, DVec3::splat(EMPTY_RADIUS_M)),
    };
    // Where the front of the box fits, the rest of it does.
    let to_front_m = half_m.y.max(half_m.x / width_over_height) / HALF_YFOV_RAD.tan();
    let distance_m = half_m.z + MARGIN * to_front_m;
    Camera {
        name: "framing camera".into(),
        position_m: center_m + distance_m * DVec3::Z,
        world_from_camera: DMat3::IDENTITY,
        lens: Lens::Perspective { yfov_rad: 2.0 * HALF_YFOV_RAD, aspect: None },
    }
}

/// White light from the camera's upper left, as in the figures of the paper.
pub fn default_sun(camera: &Camera) -> Sun {
    Sun {
        name: "default sun".into(),
        direction: (camera.world_from_camera * DEFAULT_SUN_IN_CAMERA).normalize(),
        lux: DEFAULT_SUN_LUX,
        color: [1.0; 3],
        spectrum: None,
        angular_diameter_deg: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::model::ParticleKind;

    fn particle(center_m: DVec3, radius_m: f32) -> Particle {
        Particle { center_m, radius_m, droplet_radius_m: radius_m, count: 1.0, class: 0, kind: ParticleKind::Droplet }
    }

    #[test]
    fn every_particle_lies_inside_the_view() {
        let particles = [particle(DVec3::new(1e6, 0.0, 3.0), 0.5), particle(DVec3::new(1e6 + 4.0, 1.0, 0.0), 0.1)];
        for width_over_height in [0.3, 1.0, 2.5] {
            let camera = framing_camera(&particles, &[], width_over_height);
            for p in particles {
                let to = p.center_m - camera.position_m;
                let radius = f64::from(p.radius_m);
                assert!(-to.z > radius);
                // The cone of the view, narrowed by the angle that the sphere takes.
                let slack = (radius / to.length()).asin();
                assert!((to.y.abs() / -to.z).atan() + slack < HALF_YFOV_RAD);
                let half_xfov = (HALF_YFOV_RAD.tan() * width_over_height).atan();
                assert!((to.x.abs() / -to.z).atan() + slack < half_xfov, "{width_over_height}");
            }
        }
    }

    #[test]
    fn the_default_sun_shines_to_the_lower_right_of_the_picture() {
        let sun = default_sun(&framing_camera(&[], &[], 1.0));
        assert!(sun.direction.x > 0.0 && sun.direction.y < 0.0 && sun.direction.z < 0.0);
        assert!((sun.direction.length() - 1.0).abs() < 1e-15);
    }
}
