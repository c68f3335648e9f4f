//! Scenes and their settings.

use std::collections::BTreeMap;
use std::path::Path;

use mie_cloud::plan::plan;
use mie_cloud::scene::model::{Lens, Particle, Scene};
use mie_cloud::scene::{LoadOptions, load_embedded};
use mie_cloud::spectrum::{SpectralMode, SpectralSampling};

use super::check_message;

/// A `.gltf` or `.glb` file.
pub fn scene(bytes: &[u8], folder: &Path) {
    if read(bytes, folder, &LoadOptions::default()) {
        let options = LoadOptions { radius_m: Some(1e-3), droplets_glob: Some("*d*".into()), ..LoadOptions::default() };
        read(bytes, folder, &options);
    }
}

/// Settings: `extras.mie_cloud` where it is JSON, otherwise a `--set KEY=VALUE` on each line.
pub fn settings(bytes: &[u8], folder: &Path) {
    let text = String::from_utf8_lossy(bytes);
    let flags = text.lines().filter_map(|line| line.split_once('='));
    let flags = LoadOptions {
        settings: flags.map(|(key, value)| (key.to_owned(), value.to_owned())).collect(),
        ..LoadOptions::default()
    };
    let is_json = text.trim_start().starts_with('{');
    let (extras, options) = if is_json { (text.as_ref(), LoadOptions::default()) } else { ("{}", flags) };
    let scene = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"extras":{{"mie_cloud":{extras}}},"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"mode":0,"attributes":{{"POSITION":0,"_RADIUS":1}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":1,"type":"VEC3"}},{{"bufferView":0,"componentType":5126,"count":1,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":12}}],"buffers":[{{"byteLength":12,"uri":"b.bin"}}]}}"#
    );
    read(scene.as_bytes(), folder, &options);
}

/// Loads a scene; returns whether it could be.
fn read(bytes: &[u8], folder: &Path, options: &LoadOptions) -> bool {
    let name = folder.join("scene.gltf").display().to_string();
    match load_embedded(&name, bytes, options) {
        Ok(scene) => {
            check_scene(&scene, bytes.len());
            true
        }
        Err(error) => {
            check_message(&error.to_string(), &name);
            false
        }
    }
}

/// 24 MiB are free, every byte of the scene's files justifies 12: `scene::gltf::budget`.
fn check_scene(scene: &Scene, n_bytes: usize) {
    let beside = 256;
    assert!(size_of_val(&scene.particles[..]) <= (24 << 20) + 12 * (n_bytes + beside));
    for (i, particle) in scene.particles.iter().enumerate() {
        // Balls of fog get their droplets with the optical tables.
        let is_fog = scene.fog_balls.iter().any(|balls| balls.particles.contains(&i));
        assert!(
            is_sound(particle, is_fog) && usize::from(particle.class) < scene.classes.len(),
            "particle {i}: {particle:?}"
        );
    }
    for fog in &scene.fog_boxes {
        assert!(fog.center_m.is_finite() && fog.half_edges_m.is_finite(), "{fog:?}");
    }
    let camera = &scene.camera;
    assert!(camera.position_m.is_finite() && camera.world_from_camera.is_finite(), "{camera:?}");
    let lens = match camera.lens {
        Lens::Perspective { yfov_rad, aspect } => [yfov_rad, aspect.unwrap_or(1.0)],
        Lens::Orthographic { xmag_m, ymag_m } => [xmag_m, ymag_m],
    };
    assert!(lens.iter().all(|value| value.is_finite() && *value > 0.0), "{camera:?}");
    for sun in &scene.suns {
        let is_direction = (sun.direction.length() - 1.0).abs() < 1e-9;
        assert!(is_direction && sun.lux.is_finite() && sun.lux >= 0.0, "{sun:?}");
    }
    let said: usize = scene.warnings.iter().map(|warning| warning.to_string().len()).sum();
    assert!(said < 20_000, "{said} bytes of warnings");
    check_plan(scene);
}

fn is_sound(particle: &Particle, is_fog: bool) -> bool {
    let Particle { center_m, radius_m, droplet_radius_m, count, .. } = *particle;
    let sizes = [radius_m, droplet_radius_m];
    center_m.is_finite()
        && sizes.iter().all(|r| r.is_finite() && *r >= 0.0)
        && count.is_finite()
        && (count >= 1.0 || is_fog)
}

/// What was read can be planned for: every estimate is a number.
fn check_plan(scene: &Scene) {
    let mode = scene.settings.spectral_mode.unwrap_or(SpectralMode::Bands { count: 4 });
    let sampling = SpectralSampling::new(mode, scene.settings.sun.spectrum);
    let plan = plan(scene, &BTreeMap::new(), 0.05, sampling.wavelengths_m.len());
    for decision in plan.decisions {
        assert!(decision.estimate.is_none_or(|estimate| !estimate.is_nan()), "{decision:?}");
    }
    assert!(scene.settings.to_json().is_object());
}
