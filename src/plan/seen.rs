//! How deep the droplets lie where the camera looks: for people, no decision rests on it.

use super::areas::BodyAreas;
use super::view::Grid;
use crate::scene::model::Scene;

/// Optical depths along the rays of a coarse picture.
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
        let mut met = grid.depths(scene, &BodyAreas::of(scene)).tau;
        met.retain(|tau| *tau > 0.0);
        Self {
            mean: met.iter().sum::<f64>() / met.len().max(1) as f64,
            deepest: met.iter().copied().fold(0.0, f64::max),
        }
    }
}
