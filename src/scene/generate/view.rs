//! Where camera and sun stand, so that a generated cloud makes a picture at once.

use glam::{DMat3, DVec3};

use super::error::GenerateError;
use super::shape::CloudShape;
use crate::scene::model::{Camera, Lens, Sun, WORLD_LIMIT_M};

/// Camera and sun of a generated scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the camera stands and looks; `None` frames the cloud from +Z, a cumulus from somewhat below.
    pub camera: Option<CameraPlacement>,
    /// Vertical field of view, degrees; above 0, below 180.
    pub yfov_deg: f64,
    /// Height of the sun above the horizon, degrees.
    pub sun_elevation_deg: f64,
    /// Where the sun stands, degrees: 0 behind the cloud as seen from +Z, 90 to the left, 180 behind that camera.
    pub sun_azimuth_deg: f64,
    /// Illuminance across the sun's rays, lx.
    pub sun_lux: f64,
}

/// A camera that does not frame the whole cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPlacement {
    /// Position, m; the cloud's centre is the origin.
    pub position_m: [f64; 3],
    /// The point in the middle of the picture, m.
    pub target_m: [f64; 3],
}

/// Height of the sun and where it stands, degrees, for each shape's looks: fog and puffs shine with the light behind them,
/// a cumulus needs it from the side to show its billows.
fn sun_of(shape: &CloudShape) -> [f64; 2] {
    match shape {
        CloudShape::Cumulus { .. } => [40.0, 115.0],
        _ => [25.0, 60.0],
    }
}

/// A cumulus is seen from below its base, from this many degrees.
const CUMULUS_BELOW_DEG: f64 = 8.0;

/// Width over height of the picture.
const ASPECT: f64 = 16.0 / 9.0;

/// Free room around the cloud in the picture, relative to its size.
const MARGIN: f64 = 1.15;

impl Default for View {
    /// 40 degrees; a clear morning's sun (1e5 lx is full sunlight), low and from the left, a little behind the cloud.
    fn default() -> Self {
        Self { camera: None, yfov_deg: 40.0, sun_elevation_deg: 25.0, sun_azimuth_deg: 60.0, sun_lux: 1e5 }
    }
}

impl View {
    /// The default for a shape.
    pub fn of(shape: &CloudShape) -> Self {
        let [sun_elevation_deg, sun_azimuth_deg] = sun_of(shape);
        Self { sun_elevation_deg, sun_azimuth_deg, ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<(), GenerateError> {
        let sun = [self.sun_elevation_deg, self.sun_azimuth_deg, self.sun_lux];
        if !(sun.into_iter().all(f64::is_finite) && self.sun_lux > 0.0) {
            return Err(GenerateError::View { what: "the sun" });
        }
        let away = self.camera.is_none_or(|at| {
            let way = DVec3::from(at.position_m) - DVec3::from(at.target_m);
            way.is_finite()
                && way.length() > 0.0
                && DVec3::from(at.target_m).is_finite()
                && is_near(at.position_m.into())
        });
        if !(away && self.yfov_deg > 0.0 && self.yfov_deg < 180.0) {
            return Err(GenerateError::View { what: "the camera" });
        }
        Ok(())
    }

    /// The camera for a cloud of this shape, with particles that reach `beyond_m` over its surface.
    ///
    /// # Errors
    /// When the field of view is so narrow that the camera would stand farther away than readers place it.
    pub(super) fn camera(&self, shape: &CloudShape, beyond_m: f64) -> Result<Camera, GenerateError> {
        let (position_m, target_m) = match self.camera {
            Some(at) => (at.position_m.into(), at.target_m.into()),
            None => (way_of(shape) * self.framing_distance_m(shape, beyond_m), DVec3::ZERO),
        };
        if !is_near(position_m) {
            return Err(GenerateError::View { what: "the camera" });
        }
        Ok(Camera {
            name: "Camera".into(),
            position_m,
            world_from_camera: look_at(position_m, target_m),
            lens: Lens::Perspective { yfov_rad: self.yfov_deg.to_radians(), aspect: Some(ASPECT) },
        })
    }

    /// From here the near face of the shape's box fills the picture, less the margin; grown clouds leave the corners of
    /// their box empty, and may come half of that way nearer.
    fn framing_distance_m(&self, shape: &CloudShape, beyond_m: f64) -> f64 {
        let [x, y, mut z] = shape.size_m().map(|size| 0.5 * size + beyond_m);
        if shape.is_grown() {
            z *= 0.5;
        }
        let half_height = y.max(x / ASPECT);
        MARGIN * half_height / (0.5 * self.yfov_deg.to_radians()).tan() + z
    }

    pub(super) fn sun(&self) -> Sun {
        let (sin_up, cos_up) = self.sun_elevation_deg.to_radians().sin_cos();
        let (sin_left, cos_left) = self.sun_azimuth_deg.to_radians().sin_cos();
        Sun {
            name: "Sun".into(),
            direction: DVec3::new(cos_up * sin_left, -sin_up, cos_up * cos_left).normalize(),
            lux: self.sun_lux,
            color: [1.0; 3],
            spectrum: None,
            angular_diameter_deg: None,
        }
    }
}

fn is_near(position_m: DVec3) -> bool {
    position_m.abs().max_element() <= WORLD_LIMIT_M
}

/// The direction from the cloud to the camera that frames it.
fn way_of(shape: &CloudShape) -> DVec3 {
    match shape {
        CloudShape::Cumulus { .. } => {
            let (sin, cos) = CUMULUS_BELOW_DEG.to_radians().sin_cos();
            DVec3::new(0.0, -sin, cos)
        }
        _ => DVec3::Z,
    }
}

/// Columns right, up, backward of a level camera.
fn look_at(position_m: DVec3, target_m: DVec3) -> DMat3 {
    let backward = (position_m - target_m).normalize_or(DVec3::Z);
    let up = if backward.y.abs() > 0.999_999 { DVec3::NEG_Z * backward.y.signum() } else { DVec3::Y };
    let right = up.cross(backward).normalize_or(DVec3::X);
    DMat3::from_cols(right, backward.cross(right), backward)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_sees_every_corner_of_the_cloud() {
        for lengths in [[1.0, 1.0, 1.0], [20.0, 1.0, 5.0], [1.0, 30.0, 4.0], [1e-6, 2e-6, 9e-6]] {
            let shape = CloudShape::Box { size_m: lengths };
            let camera = View::default().camera(&shape, 0.0).expect("a camera near by");
            let tan = 20_f64.to_radians().tan();
            for corner in 0..8 {
                let side = |axis: usize| if corner >> axis & 1 == 0 { 0.5 } else { -0.5 };
                let world = DVec3::new(side(0) * lengths[0], side(1) * lengths[1], side(2) * lengths[2]);
                let seen = camera.world_from_camera.transpose() * (world - camera.position_m);
                assert!(seen.z < 0.0 && seen.y.abs() <= -seen.z * tan && seen.x.abs() <= -seen.z * tan * ASPECT);
            }
        }
    }

    #[test]
    fn a_camera_looks_at_its_target_and_stands_level() {
        let frame = look_at(DVec3::new(3.0, 4.0, 5.0), DVec3::new(-1.0, 0.5, 0.0));
        assert!((frame * DVec3::NEG_Z).dot(DVec3::new(-4.0, -3.5, -5.0).normalize()) > 1.0 - 1e-12);
        assert!(frame.x_axis.y.abs() < 1e-12 && (frame.determinant() - 1.0).abs() < 1e-12);
        let down = look_at(DVec3::Y, DVec3::ZERO);
        assert!((down.determinant() - 1.0).abs() < 1e-12 && down.z_axis == DVec3::Y);
    }

    #[test]
    fn the_default_sun_shines_from_the_upper_left_and_from_behind() {
        let sun = View::default().sun().direction;
        assert!(sun.x > 0.0 && sun.y < 0.0 && sun.z > 0.0 && (sun.length() - 1.0).abs() < 1e-12);
    }
}
