//! Rough facts about a scene that decisions rest on: how much its droplets cover, how deep it is.

use std::f64::consts::PI;

use glam::DVec3;

use super::areas::BodyAreas;
use super::light::Parts;
use super::picture::Picture;
use crate::optics::distribution::SizeDistribution;
use crate::scene::model::{FogBox, Particle, Scene};
use crate::scene::resolved::{Resolution, middle_wavelength_m};
use crate::scene::settings::{AirPhase, Effect};

/// Rough facts about a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneFacts {
    /// Droplets and parcels.
    pub n_particles: usize,
    /// Fog boxes.
    pub n_fog_boxes: usize,
    /// Droplets that can be seen as glass balls.
    pub n_resolved: usize,
    /// Share of the picture that they cover, by their size in its middle; at most 1.
    pub glass_cover: f64,
    /// Largest size parameter among droplets, parcels and fog, from the largest radius that matters in each.
    pub largest_size_parameter: f64,
    /// Whether droplets are so alike, or seen one by one, that the fringes of one radius stay.
    pub has_fringes: bool,
    /// Size parameter of the air's droplets; 0 where it is no Mie haze.
    pub haze_size_parameter: f64,
    /// Whether these are so alike that their fringes stay.
    pub haze_has_fringes: bool,
    /// Mean optical depth along the camera's rays that meet droplets, on a coarse grid; 0 where none does.
    pub seen_depth: f64,
    /// Optical depth that no ray exceeds: extinction over the mean shadow of the box around all particles, along the longest way through it, and
    /// all of every fog box along its diagonal.
    pub deepest_optical_depth: f64,
    /// Share of the light in the picture that droplets take, averaged over the picture.
    pub cover: f64,
    /// Collisions of a path with droplets, averaged over the picture (theory (145)).
    pub collisions: f64,
    /// RMS of that share over its mean, at least 1: how much a change of what droplets send is worth beside a mean over the
    /// whole picture.
    pub concentration: f64,
    /// RMS over the picture of the light that droplets scatter and other droplets meet again, over the mean of what they
    /// scatter.
    pub met_again: f64,
    /// Mean optical depth along the sunlight through the places where droplets meet it, themselves left out.
    pub sunward_depth: f64,
    /// Share of the sunlight that would fall on the droplets, did none shade another, that does.
    pub sunlit: f64,
    /// Whether any sun shines.
    pub sun_shines: bool,
    /// RMS over the picture of what droplets scatter into the air and the air to the camera, over the mean of what both
    /// scatter to it once; theory (103).
    pub glow: f64,
    /// Least size of what shades, m: radius of a particle, half of a box's shortest edge.
    pub least_shade_m: f64,
    /// Longest way from what shades to air that is lit, m.
    pub shade_reach_m: f64,
    /// How bright the parts of the picture are beside each other.
    pub parts: Parts,
}

impl SceneFacts {
    /// Gathers the facts.
    pub fn of(scene: &Scene) -> Self {
        Self::of_wanted(scene, &|_| true)
    }

    /// Gathers the facts where somebody has switched effects off.
    pub fn of_wanted(scene: &Scene, is_wanted: &dyn Fn(Effect) -> bool) -> Self {
        let areas = BodyAreas::of(scene);
        let area_m2: f64 = (0..scene.particles.len()).map(|i| areas.of_particle(scene, i)).sum();
        let (min, max) = scene.particles.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| {
            let r = DVec3::splat(f64::from(p.radius_m));
            (lo.min(p.center_m - r), hi.max(p.center_m + r))
        });
        let size = (max - min).max(DVec3::ZERO);
        // A convex body's mean projected area is a quarter of its surface (Cauchy).
        let projected_m2 = 0.5 * (size.x * size.y + size.y * size.z + size.z * size.x);
        let particles = if projected_m2 > 0.0 { area_m2 / projected_m2 } else { 0.0 };
        let boxes: f64 = scene.fog_boxes.iter().map(|b| areas.box_optical_depth(scene, b)).sum();
        let glass = glass(scene);
        let largest_size_parameter = largest_size_parameter(scene);
        let along =
            |depth: f64| if size.min_element() > 0.0 { depth * size.length() / size.min_element() } else { depth };
        let deepest_optical_depth = along(particles) + boxes;
        let radii_m = scene.particles.iter().map(|particle| f64::from(particle.radius_m));
        let edges_m = scene.fog_boxes.iter().flat_map(|fog| {
            let h = &fog.half_edges_m;
            [h.x_axis, h.y_axis, h.z_axis].map(DVec3::length)
        });
        Self {
            n_particles: scene.particles.len(),
            n_fog_boxes: scene.fog_boxes.len(),
            n_resolved: glass.0,
            glass_cover: glass.1.min(1.0),
            largest_size_parameter,
            has_fringes: has_fringes(scene),
            haze_size_parameter: haze(scene).map_or(0.0, |haze| size_parameter(haze, scene)),
            haze_has_fringes: haze(scene).is_some_and(|haze| is_narrow(haze, scene)),
            deepest_optical_depth,
            least_shade_m: radii_m.chain(edges_m).fold(f64::INFINITY, f64::min),
            ..Picture::of(scene, &areas, is_wanted).facts(scene, largest_size_parameter, deepest_optical_depth)
        }
    }

    /// Whether there is nothing that scatters but air.
    pub fn is_empty(&self) -> bool {
        self.n_particles + self.n_fog_boxes == 0
    }
}

/// Number of glass balls, and how many pictures they would cover if none hid another.
fn glass(scene: &Scene) -> (usize, f64) {
    let resolution = Resolution::of(scene);
    let [width, height] = scene.settings.image.resolution.map(f64::from);
    let all = width * height;
    let cover = |particle: &Particle| {
        let pixels = resolution.diameter_pixels(particle.center_m, f64::from(particle.radius_m));
        (0.25 * PI * pixels * pixels).min(all) / all
    };
    let resolved = scene.particles.iter().filter(|particle| resolution.is_resolved(particle));
    resolved.fold((0, 0.0), |(n, sum), particle| (n + 1, sum + cover(particle)))
}

/// Size parameter of the largest droplets: of a distribution, those at its effective radius, where most light is scattered.
fn largest_size_parameter(scene: &Scene) -> f64 {
    let effective_m = |class: u16| {
        let law = scene.classes[usize::from(class)].distribution.law();
        law.moment(3) / law.moment(2)
    };
    let effective_m: Vec<f64> = (0..scene.classes.len() as u16).map(effective_m).collect();
    let of_particle = |particle: &Particle| particle.own_radius_m().unwrap_or(effective_m[usize::from(particle.class)]);
    let of_box = |fog: &FogBox| fog.droplet_radius_m.unwrap_or(effective_m[usize::from(fog.class)]);
    let largest_m = scene.particles.iter().map(of_particle).chain(scene.fog_boxes.iter().map(of_box));
    2.0 * PI * largest_m.fold(0.0, f64::max) / middle_wavelength_m(&scene.settings)
}

/// The droplets of the air, if it is a Mie haze.
fn haze(scene: &Scene) -> Option<&SizeDistribution> {
    match &scene.settings.atmosphere.phase {
        AirPhase::Haze(distribution) => Some(distribution),
        _ => None,
    }
}

/// Size parameter at the effective radius, where most light is scattered.
fn size_parameter(distribution: &SizeDistribution, scene: &Scene) -> f64 {
    2.0 * PI * distribution.law().effective_radius_m() / middle_wavelength_m(&scene.settings)
}

/// Whether droplets have one radius, or radii so near to each other that their fringes, 1/x apart, do not wash out.
fn is_narrow(distribution: &SizeDistribution, scene: &Scene) -> bool {
    let law = distribution.law();
    law.mono_radius().is_some() || size_parameter(distribution, scene) * law.effective_variance().sqrt() < 1.0
}

/// Whether the fringes of any droplets stay.
fn has_fringes(scene: &Scene) -> bool {
    let narrow: Vec<bool> = scene.classes.iter().map(|class| is_narrow(&class.distribution, scene)).collect();
    let of_particle = |particle: &Particle| particle.own_radius_m().is_some() || narrow[usize::from(particle.class)];
    let of_box = |fog: &FogBox| fog.droplet_radius_m.is_some() || narrow[usize::from(fog.class)];
    scene.particles.iter().any(of_particle) || scene.fog_boxes.iter().any(of_box)
}
