//! Pixels become rays.

use glam::DVec3;

use crate::scene::model::{Camera, Lens};

/// A ray of the camera in world space; `direction` has unit length.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraRay {
    pub origin_m: DVec3,
    pub direction: DVec3,
}

/// The ray through a point of the picture; (0, 0) is the top left corner, (width, height) the bottom right one.
///
/// The vertical field of view is the camera's; the horizontal one follows from the picture's shape.
pub(super) fn camera_ray(camera: &Camera, [width, height]: [u32; 2], x: f64, y: f64) -> CameraRay {
    let (w, h) = (f64::from(width), f64::from(height));
    let (right, up) = (2.0 * x / w - 1.0, 1.0 - 2.0 * y / h);
    match camera.lens {
        Lens::Perspective { yfov_rad, .. } => {
            let half = (0.5 * yfov_rad).tan();
            let local = DVec3::new(right * half * w / h, up * half, -1.0);
            CameraRay { origin_m: camera.position_m, direction: (camera.world_from_camera * local).normalize() }
        }
        Lens::Orthographic { xmag_m, ymag_m } => {
            let offset = camera.world_from_camera * DVec3::new(right * xmag_m, up * ymag_m, 0.0);
            let direction = (camera.world_from_camera * DVec3::NEG_Z).normalize();
            CameraRay { origin_m: camera.position_m + offset, direction }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    #[test]
    fn corners_look_along_the_edges_of_the_field_of_view() {
        let camera = Camera {
            name: "c".into(),
            position_m: DVec3::new(1e6, 0.0, 0.0),
            world_from_camera: DMat3::IDENTITY,
            lens: Lens::Perspective { yfov_rad: std::f64::consts::FRAC_PI_2, aspect: None },
        };
        let ray = camera_ray(&camera, [200, 100], 0.0, 0.0);
        assert!((ray.direction - DVec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-15);
        let center = camera_ray(&camera, [200, 100], 100.0, 50.0);
        assert_eq!(center.direction, DVec3::NEG_Z);
    }
}
