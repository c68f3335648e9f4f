//! Rough facts about a scene that decisions rest on: how much its droplets cover, how deep it is.

use std::f64::consts::PI;

use glam::DVec3;

use crate::optics::DropletClass;
use crate::scene::model::{FogBalls, FogBox, FogDensity, Particle, ParticleKind, Scene};
use crate::scene::resolved::{Resolution, middle_wavelength_m};

/// Extinction efficiency of a droplet that is large against the wavelength (van de Hulst 1957).
const LARGE_SPHERE_Q_EXT: f64 = 2.0;

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
    /// Mean optical depth across the cloud: extinction area over projected area.
    pub optical_depth: f64,
    /// Optical depth along the longest way through it.
    pub deepest_optical_depth: f64,
}

impl SceneFacts {
    /// Gathers the facts.
    pub fn of(scene: &Scene) -> Self {
        let means: Vec<ClassMeans> = scene.classes.iter().map(ClassMeans::of).collect();
        let known_m2: f64 = scene.particles.iter().map(|p| extinction_area_m2(&means, p)).sum();
        let area_m2 = known_m2 + fog_balls_area_m2(scene, &means);
        let (min, max) = scene.particles.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| {
            let r = DVec3::splat(f64::from(p.radius_m));
            (lo.min(p.center_m - r), hi.max(p.center_m + r))
        });
        let size = (max - min).max(DVec3::ZERO);
        // A convex body's mean projected area is a quarter of its surface (Cauchy).
        let projected_m2 = 0.5 * (size.x * size.y + size.y * size.z + size.z * size.x);
        let particles = if projected_m2 > 0.0 { area_m2 / projected_m2 } else { 0.0 };
        let boxes: f64 = scene.fog_boxes.iter().map(|b| box_optical_depth(scene, &means, b)).sum();
        let glass = glass(scene);
        let along =
            |depth: f64| if size.min_element() > 0.0 { depth * size.length() / size.min_element() } else { depth };
        Self {
            n_particles: scene.particles.len(),
            n_fog_boxes: scene.fog_boxes.len(),
            n_resolved: glass.0,
            glass_cover: glass.1.min(1.0),
            largest_size_parameter: largest_size_parameter(scene),
            optical_depth: particles + boxes,
            deepest_optical_depth: along(particles) + boxes,
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
    let of_particle = |particle: &Particle| match (f64::from(particle.droplet_radius_m), particle.kind) {
        (own_m, _) if own_m > 0.0 => own_m,
        (_, ParticleKind::Droplet) => f64::from(particle.radius_m),
        (_, ParticleKind::Parcel) => effective_m[usize::from(particle.class)],
    };
    let of_box = |fog: &FogBox| fog.droplet_radius_m.unwrap_or(effective_m[usize::from(fog.class)]);
    let largest_m = scene.particles.iter().map(of_particle).chain(scene.fog_boxes.iter().map(of_box));
    2.0 * PI * largest_m.fold(0.0, f64::max) / middle_wavelength_m(&scene.settings)
}

/// What one droplet of a class measures on average.
struct ClassMeans {
    area_m2: f64,
    mass_g: f64,
}

impl ClassMeans {
    fn of(class: &DropletClass) -> Self {
        let law = class.distribution.law();
        let mass_g = 1e3 * class.material.density_kg_per_m3() * law.mean_volume_m3();
        Self { area_m2: law.mean_area_m2(), mass_g }
    }

    /// Means of droplets of one radius, or of the class's distribution.
    fn with_radius(&self, class: &DropletClass, own_radius_m: Option<f64>) -> Self {
        let Some(r) = own_radius_m else { return Self { ..*self } };
        let mass_g = 1e3 * class.material.density_kg_per_m3() * 4.0 / 3.0 * PI * r.powi(3);
        Self { area_m2: PI * r * r, mass_g }
    }
}

/// Extinction cross section of a particle, m^2.
fn extinction_area_m2(means: &[ClassMeans], particle: &Particle) -> f64 {
    let radius_m = f64::from(particle.radius_m);
    let own_radius_m = f64::from(particle.droplet_radius_m);
    let area_m2 = match particle.kind {
        ParticleKind::Droplet => PI * radius_m * radius_m,
        ParticleKind::Parcel if own_radius_m > 0.0 => f64::from(particle.count) * PI * own_radius_m * own_radius_m,
        ParticleKind::Parcel => f64::from(particle.count) * means[usize::from(particle.class)].area_m2,
    };
    LARGE_SPHERE_Q_EXT * area_m2
}

/// Extinction cross section of balls of fog whose number of droplets is not known yet, m^2.
fn fog_balls_area_m2(scene: &Scene, means: &[ClassMeans]) -> f64 {
    let one = |balls: &FogBalls| -> f64 {
        let ball = |particle: &Particle| {
            let own = (particle.droplet_radius_m > 0.0).then_some(f64::from(particle.droplet_radius_m));
            let volume_m3 = 4.0 / 3.0 * PI * f64::from(particle.radius_m).powi(3);
            volume_m3 * extinction_per_m(scene, means, balls.density, particle.class, own)
        };
        scene.particles[balls.particles.clone()].iter().map(ball).sum()
    };
    scene.fog_balls.iter().map(one).sum()
}

/// Optical depth along the longest way through a fog box.
fn box_optical_depth(scene: &Scene, means: &[ClassMeans], fog: &FogBox) -> f64 {
    let way_m = 2.0 * (fog.half_edges_m.x_axis + fog.half_edges_m.y_axis + fog.half_edges_m.z_axis).length();
    way_m * extinction_per_m(scene, means, fog.density, fog.class, fog.droplet_radius_m)
}

/// Extinction coefficient of fog, 1/m.
fn extinction_per_m(scene: &Scene, means: &[ClassMeans], density: FogDensity, class: u16, own: Option<f64>) -> f64 {
    let class = usize::from(class);
    let droplet = means[class].with_radius(&scene.classes[class], own);
    let area_m2 = LARGE_SPHERE_Q_EXT * droplet.area_m2;
    match density {
        FogDensity::ExtinctionPerM(extinction) => extinction,
        FogDensity::NumberPerM3(number) => number * area_m2,
        FogDensity::LiquidWaterGPerM3(mass_g) => mass_g / droplet.mass_g * area_m2,
    }
}
