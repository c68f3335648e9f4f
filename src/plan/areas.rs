//! Extinction cross sections of particles and coefficients of fog, from droplets that are large against the wavelength.

use std::f64::consts::PI;

use crate::optics::DropletClass;
use crate::scene::fog::ball_volume_m3;
use crate::scene::model::{FogBox, FogDensity, Particle, ParticleKind, Scene};

/// Extinction efficiency of a droplet that is large against the wavelength (van de Hulst 1957).
const LARGE_SPHERE_Q_EXT: f64 = 2.0;

/// What droplets of each class measure on average.
pub(super) struct BodyAreas(Vec<ClassMeans>);

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

impl BodyAreas {
    /// Of a scene's classes.
    pub fn of(scene: &Scene) -> Self {
        Self(scene.classes.iter().map(ClassMeans::of).collect())
    }

    /// Extinction cross section of a particle, m^2.
    pub fn of_particle(&self, scene: &Scene, index: usize) -> f64 {
        let particle = &scene.particles[index];
        // Runs follow each other in the order of particles.
        let run = scene.fog_balls.partition_point(|balls| balls.particles.end <= index);
        match scene.fog_balls.get(run).filter(|balls| balls.particles.contains(&index)) {
            Some(balls) => self.of_fog_ball(scene, particle, balls.density),
            None => self.of_known(particle),
        }
    }

    /// Of a particle whose number of droplets is known.
    fn of_known(&self, particle: &Particle) -> f64 {
        let own_m = f64::from(particle.droplet_radius_m);
        let area_m2 = match particle.kind {
            ParticleKind::Droplet => PI * f64::from(particle.radius_m).powi(2),
            ParticleKind::Parcel if own_m > 0.0 => f64::from(particle.count) * PI * own_m * own_m,
            ParticleKind::Parcel => f64::from(particle.count) * self.0[usize::from(particle.class)].area_m2,
        };
        LARGE_SPHERE_Q_EXT * area_m2
    }

    /// Of a ball of fog whose number of droplets is not known yet.
    fn of_fog_ball(&self, scene: &Scene, particle: &Particle, density: FogDensity) -> f64 {
        let own_m = (particle.droplet_radius_m > 0.0).then_some(f64::from(particle.droplet_radius_m));
        let volume_m3 = ball_volume_m3(f64::from(particle.radius_m));
        volume_m3 * self.extinction_per_m(scene, density, particle.class, own_m)
    }

    /// Optical depth along the longest way through a fog box.
    pub fn box_optical_depth(&self, scene: &Scene, fog: &FogBox) -> f64 {
        let way_m = 2.0 * (fog.half_edges_m.x_axis + fog.half_edges_m.y_axis + fog.half_edges_m.z_axis).length();
        way_m * self.extinction_per_m(scene, fog.density, fog.class, fog.droplet_radius_m)
    }

    /// Extinction coefficient of fog, 1/m.
    pub fn extinction_per_m(&self, scene: &Scene, density: FogDensity, class: u16, own_m: Option<f64>) -> f64 {
        let class = usize::from(class);
        let droplet = self.0[class].with_radius(&scene.classes[class], own_m);
        let area_m2 = LARGE_SPHERE_Q_EXT * droplet.area_m2;
        match density {
            FogDensity::ExtinctionPerM(extinction) => extinction,
            FogDensity::NumberPerM3(number) => number * area_m2,
            FogDensity::LiquidWaterGPerM3(mass_g) => mass_g / droplet.mass_g * area_m2,
        }
    }
}
