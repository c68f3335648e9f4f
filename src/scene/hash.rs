//! The content hash of a scene: two scenes that render alike by construction have one hash, wherever they were read.

use std::fmt::Write;

use xxhash_rust::xxh3::Xxh3;

use super::model::{Particle, ParticleKind, Scene};

/// XXH3 (128 bits) over all numbers of the scene in a fixed order and byte order, hexadecimal. Names, warnings and the
/// path of the scene do not count; of a background image its name counts, not where it lies.
pub fn content_hash(scene: &Scene) -> String {
    let mut hasher = Xxh3::new();
    hasher.update(b"mie-cloud scene 1");
    hasher.update(&(scene.particles.len() as u64).to_le_bytes());
    for particle in &scene.particles {
        hasher.update(&particle_bytes(particle));
    }
    // The rest is small; Rust prints floats in the shortest form that reads back the same, on every machine.
    hasher.update(description(scene).as_bytes());
    format!("{:032x}", hasher.digest128())
}

fn particle_bytes(particle: &Particle) -> [u8; 39] {
    let mut bytes = [0; 39];
    let mut at = 0;
    let mut put = |part: &[u8]| {
        bytes[at..at + part.len()].copy_from_slice(part);
        at += part.len();
    };
    particle.center_m.to_array().iter().for_each(|c| put(&c.to_le_bytes()));
    [particle.radius_m, particle.droplet_radius_m, particle.count].iter().for_each(|c| put(&c.to_le_bytes()));
    put(&particle.class.to_le_bytes());
    put(&[match particle.kind {
        ParticleKind::Droplet => 0,
        ParticleKind::Parcel => 1,
    }]);
    bytes
}

fn description(scene: &Scene) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let mut line = |part: &dyn std::fmt::Debug| {
        let _ = writeln!(text, "{part:?}");
    };
    line(&scene.fog_balls);
    for fog in &scene.fog_boxes {
        line(&(fog.center_m, fog.half_edges_m, fog.density, fog.class, fog.droplet_radius_m));
    }
    line(&scene.classes);
    let camera = &scene.camera;
    line(&(camera.position_m, camera.world_from_camera, camera.lens));
    for sun in &scene.suns {
        line(&(sun.direction, sun.lux, sun.color, sun.spectrum, sun.angular_diameter_deg));
    }
    let mut settings = scene.settings.clone();
    settings.background.image = settings.background.image.and_then(|path| path.file_name().map(Into::into));
    line(&settings);
    text
}
