//! What a coarse picture of optical depths says: how much droplets cover, shade each other, and light the air; theory (101) to (103).

use glam::DVec3;

use super::areas::BodyAreas;
use super::facts::SceneFacts;
use super::light::{Colour, Light, Parts, Seen};
use super::phase_bounds::LARGE;
use super::seen::SeenDepths;
use super::shade::air_seen;
use super::sources::Sources;
use super::view::{Depths, Grid};
use crate::scene::frame_cloud::bounds_m;
use crate::scene::model::{Scene, Sun};
use crate::scene::settings::{Atmosphere, Effect};

/// How much brighter, RMS over a picture, the air is that droplets light which are large against the wavelength than the air about
/// droplets that send their light everywhere alike: half of theirs goes on in a beam. Measured on one droplet: 5.
const BEAM: f64 = 6.0;

/// Optical depths along the rays of the camera and of the brightest sun.
pub(super) struct Picture {
    camera: Grid,
    sun: Grid,
    seen: Depths,
    sunward: Depths,
    light: Light,
    /// Radius of the widest sun's disc, rad.
    disc_rad: f64,
    /// Longest way from a droplet to air, m.
    reach_m: f64,
}

impl Picture {
    /// Of a scene, without what somebody has switched off.
    pub fn of(scene: &Scene, areas: &BodyAreas, is_wanted: &dyn Fn(Effect) -> bool) -> Self {
        let (center_m, radius_m) = bounding_ball(scene);
        let brightest = scene.suns.iter().max_by(|a, b| a.lux.total_cmp(&b.lux));
        let direction = brightest.map_or(DVec3::NEG_Y, |sun| sun.direction);
        let (camera, sun) = (
            Grid::of_camera(&scene.camera, scene.settings.image.resolution),
            Grid::along(direction, center_m, radius_m),
        );
        let (seen, sunward) = (camera.depths(scene, areas), sun.depths(scene, areas));
        let diameter_deg = scene.suns.iter().map(|sun| scene.sun_diameter_deg(sun)).fold(0.0, f64::max);
        let disc_rad = 0.5 * diameter_deg.to_radians();
        let reach_m = (center_m - scene.camera.position_m).length() + radius_m + scene.settings.atmosphere.depth_m;
        Self { camera, sun, seen, sunward, light: Light::of(scene, is_wanted), disc_rad, reach_m }
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
        let sunlit = if taken > 0.0 || !is_known { sunlit } else { 1.0 };
        // What is too thin for the coarse picture counts as wide as it.
        let over = |rms: f64, otherwise: f64| if cover > 0.0 { rms / cover } else { otherwise };
        let parts = self.parts(&scene.settings.atmosphere, &covers, [sunlit, deep, deepest]);
        SceneFacts {
            seen_depth: SeenDepths::along(&self.seen.tau).mean,
            collisions: mean(&self.seen.collisions().collect::<Vec<f64>>()),
            cover,
            concentration: over(rms(&covers), 1.0).max(1.0),
            met_again: over(rms(&again), -(-deep).exp_m1()),
            sunward_depth: deep,
            sunlit,
            sun_shines: scene.suns.iter().any(shines),
            glow: self.glow(&scene.settings.atmosphere, &parts, largest_size_parameter),
            shade_reach_m: self.reach_m,
            parts,
            ..SceneFacts::default()
        }
    }

    /// How bright the parts of the picture are; `deep` is how deep the droplets lie along the sun's rays.
    fn parts(&self, air: &Atmosphere, covers: &[f64], [sunlit, deep, deepest]: [f64; 3]) -> Parts {
        let rays: Vec<DVec3> = self.camera.rays().map(|(_, direction)| direction).collect();
        let scattered: Vec<f64> = self.seen.scattered().collect();
        let air = air_seen((&self.camera, &self.seen), (&self.sun, &self.sunward, self.disc_rad), air, deepest);
        let blur = self.camera.blur_rad();
        self.light.parts(&Seen { rays: &rays, blur, lost: covers, scattered: &scattered, air: &air, sunlit, deep })
    }

    /// Theory (103).
    fn glow(&self, air: &Atmosphere, parts: &Parts, largest_size_parameter: f64) -> f64 {
        let sources = Sources::of(&self.sun, &self.sunward);
        let Colour { luminance, rms: sun_rms } = self.light.sun;
        if air.scattering_per_m <= 0.0 || sources.is_empty() || luminance <= 0.0 {
            return 0.0;
        }
        let glows: Vec<f64> = self.camera.rays().map(|ray| air.scattering_per_m * sources.light(ray, air)).collect();
        let beam = if largest_size_parameter > LARGE { 1.0 + (BEAM - 1.0) * sources.beam_passed } else { 1.0 };
        beam * rms(&glows) * sun_rms / (parts.least() + mean(&glows) * luminance)
    }
}

/// Whether a sun sends any light.
fn shines(sun: &Sun) -> bool {
    sun.lux > 0.0 && sun.color.iter().any(|channel| *channel > 0.0)
}

/// A ball about all particles and fog boxes.
pub(super) fn bounding_ball(scene: &Scene) -> (DVec3, f64) {
    let (min, max) = bounds_m(&scene.particles, &scene.fog_boxes).unwrap_or((DVec3::ZERO, DVec3::ZERO));
    (0.5 * (min + max), 0.5 * (max - min).length())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
