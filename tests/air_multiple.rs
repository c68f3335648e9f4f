//! Light that air and droplets scatter one after the other: furnaces, air against fog, chains against none.

mod common;

use std::collections::BTreeMap;

use common::*;
use glam::DVec3;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{FogBalls, FogDensity, Scene};
use mie_cloud::scene::settings::{AirPhase, Effect, Switch};

/// Rationale: what neither absorbs nor emits cannot be seen in surroundings of one radiance, whatever takes turns to scatter.
/// Set-up: white air, alone and with a box, parcels and droplets in it, a constant background, no sun. Expected: the background.
#[test]
fn white_air_and_clouds_vanish_in_a_furnace() {
    let forms: [fn(&mut Scene); 3] = [
        |_| {},
        |scene| scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.5), 2.0)],
        |scene| {
            let at = |i: i32| DVec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) / 2.5 - 1.0;
            scene.particles = (0..125).map(|i| droplet(at(i), 0.1, 5e-6)).collect();
            scene.particles.push(parcel(DVec3::ZERO, 1.0, 2e10));
        },
    ];
    for (i, form) in forms.into_iter().enumerate() {
        let mut scene = empty_scene();
        form(&mut scene);
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.8) });
        with_air(&mut scene, 0.2, 0.0, 12.0, 2.0);
        scene.settings.atmosphere.phase = AirPhase::HenyeyGreenstein { g: 0.5 };
        scene.classes[0].albedo = Some(1.0);
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.8);
        scene.settings.background.radiance = [0.5; 3];
        scene.suns[0].lux = 0.0;
        let (mean, error) = mean_and_error(&render_scene(scene, 800, 3));
        assert!((mean - 0.5).abs() < 4.0 * error, "form {i}: {mean} +- {error}");
        assert!(error < 0.004, "form {i}: {error}");
    }
}

/// Rationale: sunlight reaches the air unweakened, so air is a ball of fog whose droplets cast no shadows. Set-up: both, about the
/// camera, with the same coefficients. Expected: the same radiance, in the air's and in the droplets' layers.
#[test]
fn air_is_a_ball_of_fog_without_shadows() {
    let (radius_m, scattering_per_m, absorption_per_m) = (2.0, 0.6, 0.2);
    let mut air = empty_scene();
    with_air(&mut air, scattering_per_m, absorption_per_m, radius_m, 0.5);
    air.settings.atmosphere.phase = AirPhase::HenyeyGreenstein { g: 0.4 };
    air.camera = orthographic(DVec3::ZERO, 0.01);
    let mut fog = air.clone();
    fog.settings.atmosphere.scattering_per_m = 0.0;
    fog.settings.atmosphere.absorption_per_m = 0.0;
    with_phase(&mut fog, PhaseModel::HenyeyGreenstein { g: Some(0.4) });
    fog.classes[0].albedo = Some(scattering_per_m / (scattering_per_m + absorption_per_m));
    let density = FogDensity::ExtinctionPerM(scattering_per_m + absorption_per_m);
    fog.particles = vec![parcel(DVec3::ZERO, radius_m, 1.0)];
    fog.fog_balls = vec![FogBalls { particles: 0..1, density }];
    let no_shadows = BTreeMap::from([(Effect::Shadows, Switch::Off)]);
    let of_air = render_with(air, 4000, 1, &no_shadows);
    let of_fog = render_with(fog, 4000, 2, &no_shadows);
    let ((air_mean, air_error), (fog_mean, fog_error)) = (mean_and_error(&of_air), mean_and_error(&of_fog));
    let error = air_error.hypot(fog_error);
    assert!((air_mean - fog_mean).abs() < 4.0 * error, "{air_mean} {fog_mean} +- {error}");
    assert!(error < 0.01 * fog_mean, "{error} of {fog_mean}");
    for (in_air, in_fog) in [("airlight.G", "direct.G"), ("air_multiple.G", "multiple.G")] {
        let (a, b) = (mean_of(&of_air, in_air), mean_of(&of_fog, in_fog));
        assert!((a / b - 1.0).abs() < 0.02, "{in_air} {a}, {in_fog} {b}");
    }
}

/// Rationale: chains of small turns toward the sun start at collisions with the air too. Set-up: parcels with a sharp phase function in
/// air, with and without chains. Expected: the same light between air and droplets.
#[test]
fn chains_from_the_air_change_the_noise_and_not_the_mean() {
    let mut scene = empty_scene();
    scene.particles = vec![parcel(DVec3::ZERO, 1.0, 3e10), parcel(DVec3::new(1.0, 0.5, -1.0), 0.8, 2e10)];
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.8) });
    with_air(&mut scene, 0.1, 0.02, 15.0, 2.0);
    scene.suns = vec![sun(DVec3::new(1.0, -0.5, 0.2))];
    let effects = BTreeMap::from([(Effect::Glow, Switch::Off)]);
    let with = render_prepared(&prepare(scene.clone(), &effects), 4000, 1);
    let without = render_prepared(&prepare(scene, &effects).without_chains(), 8000, 2);
    let light = |outcome| mean_of(outcome, "air_multiple.G");
    let (a, b) = (mean_and_error(&with), mean_and_error(&without));
    let error = a.1.hypot(b.1);
    assert!((light(&with) - light(&without)).abs() < 4.0 * error, "{} {} +- {error}", light(&with), light(&without));
    assert!(error < 0.02 * light(&with), "{error} of {}", light(&with));
}

/// Rationale: a path in a thick cloud passes thin air by many times before it meets it; were it drawn with an even chance each time, weights would double from
/// collision to collision. Set-up: fog of depth 30 in two airs of which one is ten times as thin. Expected: light in proportion to the air, and as steady.
#[test]
fn paths_through_thick_fog_meet_thin_air_with_weights_alike() {
    let of_air = |scattering_per_m: f64| {
        let mut scene = empty_scene();
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(5.0, 5.0, 5.0), 3.0)];
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.5) });
        scene.classes[0].albedo = Some(1.0);
        with_air(&mut scene, scattering_per_m, 0.0, 40.0, 5.0);
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 20.0), 4.0);
        let prepared = prepare_all(scene);
        let light = |seed| mean_of(&render_prepared(&prepared, 64, seed), "air_multiple.G");
        let values: Vec<f64> = (1..=12).map(light).collect();
        let mean = values.iter().sum::<f64>() / 12.0;
        (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 11.0 / 12.0).sqrt())
    };
    let ((thin, thin_error), (dense, dense_error)) = (of_air(1e-5), of_air(1e-4));
    let (ratio, error) = (dense / thin, (dense_error / dense).hypot(thin_error / thin));
    println!("{ratio} +- {error} relative; {} and {} of the mean", thin_error / thin, dense_error / dense);
    // Ten times the air also weakens light by 40 m of it, and scatters a little twice: less than 1 %.
    assert!((ratio / 10.0 - 1.0).abs() < 5.0 * error + 0.01, "{ratio} +- {error}");
    // The thinner air's paths are so light that most end by roulette.
    assert!(dense_error < 0.03 * dense && thin_error < 0.08 * thin, "{error}");
}

/// Rationale: a path that leaves everything behind sees the background and yet goes on in the air, so that neither is left to chance. Set-up: lit air behind a bar
/// that shades most of it, before black and before a background too dim to see. Expected: the same light and the same noise.
#[test]
fn a_dim_background_makes_no_noise() {
    let picture = |background: f64| {
        let mut scene = empty_scene();
        scene.fog_boxes = vec![fog_box(DVec3::new(0.0, 3.0, 0.0), DVec3::new(4.0, 0.2, 4.0), 20.0)];
        scene.classes[0].albedo = Some(0.0);
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.5) });
        with_air(&mut scene, 0.02, 0.0, 10.0, 1.0);
        scene.suns = vec![sun(DVec3::new(0.3, -1.0, 0.0))];
        scene.camera = orthographic(DVec3::ZERO, 1.0);
        scene.settings.background.radiance = [background; 3];
        mean_and_error(&render_prepared(&prepare_all(scene), 256, 1))
    };
    let ((black, black_error), (dim, dim_error)) = (picture(0.0), picture(1e-9));
    let error = black_error.hypot(dim_error);
    assert!((black - dim).abs() < 4.0 * error && error < 0.02 * black, "{black} {dim} +- {error}");
    assert!(dim_error < 1.1 * black_error, "{dim_error} {black_error}");
}
