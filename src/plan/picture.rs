//! What a coarse picture of optical depths says: how much droplets cover, shade each other, and light the air; theory (101) to (103).

use std::f64::consts::PI;

use glam::DVec3;

use super::areas::BodyAreas;
use super::facts::SceneFacts;
use super::view::{Depths, Grid};
use crate::scene::model::{Scene, Sun};
use crate::scene::settings::Atmosphere;

/// 4 pi p of droplets that are large against the wavelength, seen from the side: 0.1 to 0.4 between 60 and 130 degrees for
/// distributions of water droplets of 4 to 20 um. Where they are seen so, they are dark beside the light that they send
/// into the air before them.
const SIDE_VIEW: f64 = 0.25;

/// How much brighter, RMS over a picture, the air is that droplets light which are large against the wavelength than the air about
/// droplets that send their light everywhere alike: half of theirs goes on in a beam. Measured on one droplet: 5.
const BEAM: f64 = 6.0;

/// Least size parameter of droplets that are.
const LARGE: f64 = 3.0;

/// At most so many places stand for the droplets that light the air.
const MOST_SOURCES: usize = 64;

/// Optical depths along the rays of the camera and of the brightest sun.
pub(super) struct Picture {
    camera: Grid,
    seen: Depths,
    sunward: Depths,
    /// Area of the sun's view of the cloud, m^2, per cell.
    cell_m2: f64,
    sources: Vec<DVec3>,
    /// Half the distance between sources, m.
    spread_m: f64,
}

impl Picture {
    /// Of a scene.
    pub fn of(scene: &Scene, areas: &BodyAreas) -> Self {
        let (center_m, radius_m) = bounding_ball(scene);
        let brightest = scene.suns.iter().max_by(|a, b| a.lux.total_cmp(&b.lux));
        let direction = brightest.map_or(DVec3::NEG_Y, |sun| sun.direction);
        let (camera, sun) = (
            Grid::of_camera(&scene.camera, scene.settings.image.resolution),
            Grid::along(direction, center_m, radius_m),
        );
        let (seen, sunward) = (camera.depths(scene, areas), sun.depths(scene, areas));
        let step = scene.particles.len().div_ceil(MOST_SOURCES).max(1);
        let particles = scene.particles.iter().step_by(step).map(|particle| particle.center_m);
        let sources: Vec<DVec3> =
            particles.chain(scene.fog_boxes.iter().take(MOST_SOURCES).map(|b| b.center_m)).collect();
        let cell_m2 = (2.0 * radius_m).powi(2) / sunward.tau.len() as f64;
        let spread_m = radius_m / (sources.len().max(1) as f64).cbrt();
        Self { camera, seen, sunward, cell_m2, sources, spread_m }
    }

    /// What follows from it; all other facts are left at their defaults.
    /// `deepest` is an optical depth that none exceeds, for what the grids are too coarse for.
    pub fn facts(&self, scene: &Scene, largest_size_parameter: f64, deepest: f64) -> SceneFacts {
        let covers: Vec<f64> = self.seen.covers().collect();
        let cover = mean(&covers);
        let taken: f64 = self.sunward.covers().sum();
        // Light goes on from a droplet of the cell through about what lies before it, or as deep as the sun sees.
        let weighted = |values: &mut dyn Iterator<Item = f64>| {
            let sum: f64 = self.sunward.covers().zip(values).map(|(cover, value)| cover * value).sum();
            if taken > 0.0 { sum / taken } else { 0.0 }
        };
        let is_known = !self.sunward.misses_a_box;
        let deep = if is_known { weighted(&mut self.sunward.of_others()) } else { deepest };
        let again: Vec<f64> =
            covers.iter().zip(self.seen.of_others()).map(|(cover, tau)| cover * -(-tau.max(deep)).exp_m1()).collect();
        // The mean of exp(-t) over t from 0 to tau.
        let mean_lit = |tau: f64| if tau > 1e-9 { -(-tau).exp_m1() / tau } else { 1.0 - 0.5 * tau };
        let sunlit = if is_known { weighted(&mut self.sunward.of_others().map(mean_lit)) } else { mean_lit(deepest) };
        // What is too thin for the coarse picture counts as wide as it.
        let over = |rms: f64, otherwise: f64| if cover > 0.0 { rms / cover } else { otherwise };
        SceneFacts {
            cover,
            concentration: over(rms(&covers), 1.0).max(1.0),
            met_again: over(rms(&again), -(-deep).exp_m1()),
            sunward_depth: deep,
            sunlit: if taken > 0.0 || !is_known { sunlit } else { 1.0 },
            sun_shines: scene.suns.iter().any(shines),
            glow: self.glow(&scene.settings.atmosphere, &covers, sunlit, largest_size_parameter),
            ..SceneFacts::default()
        }
    }

    /// Theory (103), all in units of E / 4 pi: droplets c_k, glow sigma_s sum_s A_s / 4 pi integral dt / (d^2 + s^2).
    fn glow(&self, air: &Atmosphere, covers: &[f64], sunlit: f64, largest_size_parameter: f64) -> f64 {
        if air.scattering_per_m <= 0.0 || self.sources.is_empty() {
            return 0.0;
        }
        let taken_m2 = self.cell_m2 * self.sunward.covers().sum::<f64>();
        let of_source = air.scattering_per_m * taken_m2 / (4.0 * PI * self.sources.len() as f64);
        let glows: Vec<f64> = self.camera.rays().map(|ray| of_source * self.lit_way(ray, air.depth_m)).collect();
        let by_air = if air.sunlight { -(-air.scattering_per_m * air.depth_m).exp_m1() } else { 0.0 };
        let (side, beam) = if largest_size_parameter > LARGE { (SIDE_VIEW, BEAM) } else { (1.0, 1.0) };
        let seen = side * mean(covers) * sunlit + by_air;
        if seen > 0.0 { beam * rms(&glows) / (seen + mean(&glows)) } else { f64::INFINITY }
    }

    /// Sum over the sources of the integral of 1 / distance^2 along a ray, 1/m, none nearer than they are spread.
    fn lit_way(&self, (origin_m, direction): (DVec3, DVec3), way_m: f64) -> f64 {
        let from = |source: &DVec3| {
            let to_source = *source - origin_m;
            let foot = to_source.dot(direction);
            let b =
                (to_source.length_squared() - foot * foot).max(0.0).sqrt().hypot(self.spread_m).max(f64::MIN_POSITIVE);
            (((way_m - foot) / b).atan() + (foot / b).atan()) / b
        };
        self.sources.iter().map(from).sum()
    }
}

/// Whether a sun sends any light.
fn shines(sun: &Sun) -> bool {
    sun.lux > 0.0 && sun.color.iter().any(|channel| *channel > 0.0)
}

/// A ball about all particles and fog boxes.
fn bounding_ball(scene: &Scene) -> (DVec3, f64) {
    let reach = |center_m: DVec3, size_m: DVec3| (center_m - size_m, center_m + size_m);
    let particles = scene.particles.iter().map(|p| reach(p.center_m, DVec3::splat(f64::from(p.radius_m))));
    let boxes = scene.fog_boxes.iter().map(|b| {
        let h = &b.half_edges_m;
        reach(b.center_m, h.x_axis.abs() + h.y_axis.abs() + h.z_axis.abs())
    });
    let both = particles.chain(boxes).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let (min, max) = both.unwrap_or((DVec3::ZERO, DVec3::ZERO));
    (0.5 * (min + max), 0.5 * (max - min).length())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
