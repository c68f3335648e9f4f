//! How deep the droplets lie where the camera looks: for people, no decision rests on it.

use super::areas::BodyAreas;
use super::picture::bounding_ball;
use super::view::Grid;
use crate::scene::model::Scene;

/// Optical depths along the rays of a coarse picture that meet droplets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenDepths {
    /// Mean over the rays that meet droplets; 0 where none does.
    pub mean: f64,
    /// The largest.
    pub deepest: f64,
}

impl SeenDepths {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        let grid = Grid::of_camera(&scene.camera, scene.settings.image.resolution);
        Self::along(&grid.depths(scene, &BodyAreas::of(scene)).tau)
    }

    /// Across what the camera sees: of parallel rays from its right to its left, all over the scene.
    pub fn across(scene: &Scene) -> Self {
        let (center_m, radius_m) = bounding_ball(scene);
        let grid = Grid::along(-scene.camera.world_from_camera.x_axis, center_m, radius_m);
        Self::along(&grid.depths(scene, &BodyAreas::of(scene)).tau)
    }

    /// Of the optical depths along rays.
    pub(super) fn along(depths: &[f64]) -> Self {
        let met = || depths.iter().copied().filter(|tau| *tau > 0.0);
        Self { mean: met().sum::<f64>() / met().count().max(1) as f64, deepest: met().fold(0.0, f64::max) }
    }
}
