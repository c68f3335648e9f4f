//! Paths that divide where an absorbing cloud gets brighter: the same picture as without, with less noise.

mod common;

use common::*;
use glam::{DMat3, DVec3};
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::Scene;
use mie_cloud::spectrum::SpectralMode;

/// A wide slab of the given depth, seen from below; light falls on its top.
fn dark_slab(depth: f64, albedo: f64, phase: PhaseModel) -> Scene {
    let mut scene = empty_scene();
    with_phase(&mut scene, phase);
    scene.classes[0].albedo = Some(albedo);
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 0.5), depth)];
    scene.suns = vec![sun(DVec3::new(0.6, 0.0, -0.8))];
    scene.camera = camera_for(DVec3::new(0.3, 0.1, -0.9).normalize(), 0.01);
    scene
}

/// Means of both estimators, with their errors relative to the plain one's mean.
fn with_and_without(scene: &dyn Fn() -> Scene, spp: u32, plain_spp: u32) -> ([f64; 2], [f64; 2]) {
    let (mean, error) = mean_and_error(&render_prepared(&prepare_all(scene()), spp, 1));
    let (plain, plain_error) = mean_and_error(&render_prepared(&prepare_all(scene()).without_guide(), plain_spp, 2));
    ([mean, plain], [error / plain, plain_error / plain])
}

/// Rationale: dividing changes no mean, whatever else takes part: chains toward the sun, several wavelengths, two suns, a
/// background, droplets and parcels between. Set-up: absorbing clouds over three diffusion lengths thick from their dark side,
/// with and without. Expected: equal within four standard errors, which are at most 3 %.
#[test]
fn dividing_paths_keep_the_mean() {
    let hg = PhaseModel::HenyeyGreenstein { g: Some(0.85) };
    let isotropic = || dark_slab(8.0, 0.8, PhaseModel::Isotropic);
    let forward = || dark_slab(16.0, 0.9, hg.clone());
    let many = || {
        let mut scene = dark_slab(16.0, 0.9, hg.clone());
        scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 4 });
        scene.suns.push(sun(DVec3::new(-0.3, 0.4, -0.6).normalize()));
        scene.settings.background.radiance = [1e-3, 2e-3, 3e-3];
        scene.particles = (0..40)
            .map(|i| parcel(DVec3::new(0.05 * f64::from(i % 8) - 0.2, 0.05 * f64::from(i / 8) - 0.1, -0.1), 0.05, 1e5))
            .collect();
        scene
    };
    let cases: [(&str, &dyn Fn() -> Scene, u32, u32); 3] =
        [("isotropic", &isotropic, 400, 4000), ("forward", &forward, 1200, 6000), ("many", &many, 100, 500)];
    for (name, scene, spp, plain_spp) in cases {
        let ([mean, plain], [error, plain_error]) = with_and_without(scene, spp, plain_spp);
        let both = error.hypot(plain_error);
        eprintln!("{name}: {mean:.4e} {plain:.4e} {error:.4} {plain_error:.4}");
        assert!((mean / plain - 1.0).abs() < 4.0 * both, "{name}: {mean} {plain}, errors {error} {plain_error}");
        assert!(both < 0.03, "{name}: {both}");
    }
}

/// Rationale: light that falls by millions on its way is found all the same. Set-up: transmission of a slab of 64 mean free paths,
/// g = 0.9, albedo 0.9, looked at straight up and at a slant, against discrete ordinates (`slab_reference.json`). Expected: within four standard
/// errors, which are at most 4 % with paths of which one in a million would get through by itself.
#[test]
fn light_that_has_fallen_by_a_million_is_found() {
    for (mu, expected) in [(1.0, 1.522_855_6e-6), (0.9, 1.246_149e-6)] {
        let mut scene = dark_slab(64.0, 0.9, PhaseModel::HenyeyGreenstein { g: Some(0.9) });
        scene.suns = vec![sun(DVec3::NEG_Z)];
        let travel = DVec3::new(f64::sqrt(1.0 - mu * mu), 0.0, -mu);
        let (x, y) = travel.any_orthonormal_pair();
        scene.camera = orthographic(travel * 10.0, 0.01);
        scene.camera.world_from_camera = DMat3::from_cols(x, y, travel);
        let (mean, error) = mean_and_error(&render_scene(scene, 500, 5));
        eprintln!("{mean:.4e} {error:.2e} {expected}");
        assert!((mean - expected).abs() < 4.0 * error, "{mean} +- {error}, {expected}");
        assert!(error < 0.04 * expected, "{error} of {expected}");
    }
}

/// Rationale: water clouds do not absorb, and their paths shall not pay. Expected: the same bytes with and without.
#[test]
fn clouds_that_do_not_absorb_are_not_concerned() {
    let scene = || dark_slab(16.0, 1.0, PhaseModel::Isotropic);
    let with = channels(&render_prepared(&prepare_all(scene()), 8, 1));
    let without = channels(&render_prepared(&prepare_all(scene()).without_guide(), 8, 1));
    assert_eq!(with, without);
}
