//! The scene's droplets, parcels and fog boxes become bodies: disc radii, densities and size bins filled in.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::media::Media;
use crate::accel::{BodyKind, Placed, PlacedBox};
use crate::optics::bins::{BinPlan, DropletSize};
use crate::scene::model::{FogBox, FogDensity, Particle, ParticleKind, Scene};
use crate::scene::resolved::Resolution;

/// The size bins of everything in the scene.
pub(super) fn bin_plan(scene: &Scene) -> BinPlan {
    let sizes = scene.particles.iter().map(droplet_size).chain(scene.fog_boxes.iter().map(fog_size));
    BinPlan::new(&scene.classes, sizes, scene.settings.droplets.size_bins)
}

/// A droplet without a radius of its own is as large as it is drawn; a parcel holds its class's distribution.
fn droplet_size(particle: &Particle) -> DropletSize {
    let as_drawn = particle.kind == ParticleKind::Droplet && particle.droplet_radius_m == 0.0;
    let radius_m = if as_drawn { particle.radius_m } else { particle.droplet_radius_m };
    DropletSize { class: particle.class, radius_m, count: f64::from(particle.count) }
}

fn fog_size(fog: &FogBox) -> DropletSize {
    DropletSize { class: fog.class, radius_m: fog.droplet_radius_m.unwrap_or(0.0) as f32, count: 1.0 }
}

/// Bodies of droplets and parcels; those that `resolution` resolves are glass. `scene.fill_fog` must have been called. They
/// take the place of the particles in memory, being as large.
pub(super) fn place_particles(
    particles: Vec<Particle>,
    bins: &BinPlan,
    media: &Media,
    resolution: Option<&Resolution>,
) -> Vec<Placed> {
    let place = |particle: Particle| {
        let is_glass = resolution.is_some_and(|resolution| resolution.is_resolved(&particle));
        let placed = place_particle(&particle, bins, media);
        if is_glass { Placed { kind: BodyKind::Glass, ..placed } } else { placed }
    };
    particles.into_iter().map(place).collect()
}

/// Balls of the droplets that are resolved. Their load is the ratio of own to drawn radius.
pub(super) fn place_balls(particles: &[Particle], bins: &BinPlan, resolution: &Resolution) -> Vec<Placed> {
    let ball = |particle: &Particle| {
        let size = droplet_size(particle);
        Placed {
            center_m: particle.center_m,
            radius_m: particle.radius_m,
            load: size.radius_m / particle.radius_m,
            bin: bins.bin_of(size.class, size.radius_m),
            kind: BodyKind::Ball,
        }
    };
    particles.par_iter().filter(|particle| resolution.is_resolved(particle)).map(ball).collect()
}

fn place_particle(particle: &Particle, bins: &BinPlan, media: &Media) -> Placed {
    let size = droplet_size(particle);
    let bin = bins.bin_of(size.class, size.radius_m);
    let radius_m = f64::from(particle.radius_m);
    match particle.kind {
        ParticleKind::Droplet => {
            let disc_m = radius_m * media.disc_scale(bin as usize);
            Placed { center_m: particle.center_m, radius_m: disc_m as f32, load: 1.0, bin, kind: BodyKind::Droplet }
        }
        ParticleKind::Parcel => {
            let volume_m3 = 4.0 / 3.0 * PI * radius_m.powi(3);
            Placed {
                center_m: particle.center_m,
                radius_m: particle.radius_m,
                // Denser than f32 reaches is opaque all the same.
                load: (f64::from(particle.count) / volume_m3).min(f64::from(f32::MAX)) as f32,
                bin,
                kind: BodyKind::Ball,
            }
        }
    }
}

/// Extinction cross section of everything in each size bin, m^2, at the middle wavelength.
pub(super) fn bin_areas(media: &Media, placed: &[Placed], fog_boxes: &[PlacedBox]) -> Vec<f64> {
    let middle = media.n_wavelengths() / 2;
    let mut areas_m2 = vec![0.0; media.n_bins()];
    for body in placed {
        let (bin, radius_m, load) = (body.bin as usize, f64::from(body.radius_m), f64::from(body.load));
        areas_m2[bin] += match body.kind {
            // No path collides with glass.
            BodyKind::Glass => 0.0,
            BodyKind::Droplet => disc_area_m2(media, body),
            BodyKind::Ball | BodyKind::Box => 4.0 / 3.0 * PI * radius_m.powi(3) * load * media.c_ext_m2(bin)[middle],
        };
    }
    for fog in fog_boxes {
        let volume_m3 = 8.0 * fog.half_edges_m.determinant().abs();
        areas_m2[fog.bin as usize] += volume_m3 * fog.number_per_m3 * media.c_ext_m2(fog.bin as usize)[middle];
    }
    areas_m2
}

/// The same of glass in each size bin.
pub(super) fn glass_areas(media: &Media, placed: &[Placed]) -> Vec<f64> {
    let mut areas_m2 = vec![0.0; media.n_bins()];
    let glass = placed.iter().filter(|body| body.kind == BodyKind::Glass);
    glass.for_each(|body| areas_m2[body.bin as usize] += disc_area_m2(media, body));
    areas_m2
}

/// What a droplet takes from the light at the middle wavelength, m^2.
fn disc_area_m2(media: &Media, body: &Placed) -> f64 {
    let depth = f64::from(body.load) * media.disc_depth(body.bin as usize)[media.n_wavelengths() / 2];
    -PI * f64::from(body.radius_m).powi(2) * (-depth).exp_m1()
}

/// Bodies of fog boxes.
pub(super) fn place_boxes(fog_boxes: &[FogBox], bins: &BinPlan) -> Vec<PlacedBox> {
    let number = |density| match density {
        FogDensity::NumberPerM3(number) => number,
        // Filled before; a box that was not holds nothing.
        FogDensity::LiquidWaterGPerM3(_) | FogDensity::ExtinctionPerM(_) => 0.0,
    };
    fog_boxes
        .iter()
        .map(|fog| PlacedBox {
            center_m: fog.center_m,
            half_edges_m: fog.half_edges_m,
            number_per_m3: number(fog.density),
            bin: bins.bin_of(fog.class, fog_size(fog).radius_m),
        })
        .collect()
}
