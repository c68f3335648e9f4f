//! Pictures with known answers: transmittance, single scattering, airlight, background, colour, determinism.

mod common;

use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use mie_cloud::mie;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::settings::{Effect, Switch};
use mie_cloud::spectrum::SpectralMode;
use rand::{RngExt, SeedableRng};

/// Extinction cross section of a 5 um water droplet at 550 nm, m^2, straight from the solver.
fn c_ext_m2() -> f64 {
    let index = Material::Water.index(550e-9).unwrap();
    PI * 25e-12 * mie::efficiencies(2.0 * PI * 5e-6 / 550e-9, index).unwrap().q_ext
}

/// Composite Simpson rule.
fn integrate(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let n = 2000;
    let h = (b - a) / f64::from(n);
    let weight = |i: i32| if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=n).map(|i| weight(i) * f(a + f64::from(i) * h)).sum::<f64>() * h / 3.0
}

/// Rationale: N discs of effective area C dropped at random on an area A leave (1 - C/A)^N of a beam, which tends to
/// exp(-N C / A). Set-up: 16 independent fields, magnified 50 times so that 20,000 droplets have an optical depth of
/// about 1. Expected: the mean over fields agrees within four of its standard errors.
#[test]
fn a_random_field_of_droplets_obeys_beer_and_lambert() {
    let (n, half_m, magnification) = (20_000, 0.1, 50.0);
    let area_m2 = 4.0 * half_m * half_m;
    let covered = c_ext_m2() * magnification * magnification / area_m2;
    let expected = (1.0 - covered).powi(n);
    assert!((expected / (-f64::from(n) * covered).exp() - 1.0).abs() < 1e-3, "the limit is reached");
    let fields: Vec<f64> = (0..16)
        .map(|seed| {
            let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
            let mut scene = empty_scene();
            let mut at = || half_m * (2.0 * rng.random::<f64>() - 1.0);
            let one = |_| droplet(DVec3::new(at(), at(), at()), 5e-6 * magnification, 5e-6);
            scene.particles = (0..n).map(one).collect();
            // The edge of the field is kept out of sight.
            scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.9 * half_m);
            scene.settings.image.resolution = [64, 64];
            mean_of(&render_scene(scene, 8, seed), "transmittance.G")
        })
        .collect();
    let mean = fields.iter().sum::<f64>() / 16.0;
    let error = (fields.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / 15.0 / 16.0).sqrt();
    assert!((mean - expected).abs() < 4.0 * error, "{mean} against {expected} +- {error}");
    assert!(error < 0.01 * expected, "the test can tell 4 % apart: {error}");
}

#[test]
fn a_parcel_transmits_exp_of_its_chord() {
    for (radius_m, tau) in [(1.0, 0.3), (1e-3, 2.0), (1e3, 1e-6)] {
        let count = tau / 2.0 / radius_m / c_ext_m2() * 4.0 / 3.0 * PI * f64::powi(radius_m, 3);
        let mut scene = empty_scene();
        scene.particles = vec![parcel(DVec3::ZERO, radius_m, count)];
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 3.0 * radius_m), 1e-6 * radius_m);
        let transmittance = mean_of(&render_scene(scene, 4, 1), "transmittance.G");
        // The drawn radius and the count are f32: 1e-7 each, and the tables' own tolerance is far below.
        assert!((transmittance - f64::exp(-tau)).abs() < 1e-6, "{transmittance} at optical depth {tau}");
    }
}

/// Light from `sun_direction` scattered once in a ball of unit radius toward a camera that looks along -z through its
/// centre: the textbook integral, by quadrature.
fn scattered_once(sigma_per_m: f64, albedo: f64, sun_direction: DVec3, phase: f64) -> f64 {
    let to_sun = -sun_direction.normalize();
    let along = |s: f64| {
        let point = DVec3::new(0.0, 0.0, 1.0 - s);
        let b = point.dot(to_sun);
        let sun_way = -b + (b * b - point.length_squared() + 1.0).max(0.0).sqrt();
        sigma_per_m * albedo * phase * (-sigma_per_m * (s + sun_way)).exp()
    };
    integrate(along, 0.0, 2.0)
}

/// Rationale: the radiance of single scattering is an integral over the ray. Set-up: one ball of fog, seen through its
/// centre, lit from four sides. Expected: the integral within four standard errors and 1 %.
#[test]
fn single_scattering_by_a_parcel_is_the_analytic_integral() {
    let g: f64 = 0.5;
    for (tau, albedo) in [(0.1, 1.0), (1.0, 0.7), (5.0, 1.0)] {
        for direction in [DVec3::NEG_Z, DVec3::Z, DVec3::X, DVec3::new(1.0, -1.0, 0.5)] {
            let sigma_per_m = 0.5 * tau;
            let mut scene = empty_scene();
            with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(g) });
            scene.classes[0].albedo = Some(albedo);
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, sigma_per_m / c_ext_m2() * 4.0 / 3.0 * PI)];
            scene.suns = vec![sun(direction)];
            let (mean, error) = mean_and_error(&render_once(scene, 1000, 5));
            // Light that travels along +z comes straight to the camera.
            let mu = direction.normalize().z;
            let phase = (1.0 - g * g) / (4.0 * PI) / (1.0 + g * g - 2.0 * g * mu).powf(1.5);
            let expected = scattered_once(sigma_per_m, albedo, direction, phase);
            assert!((mean - expected).abs() < 4.0 * error + 1e-6 * expected, "{mean} +- {error} against {expected}");
            assert!(error < 0.01 * expected, "{error} of {expected}");
        }
    }
}

#[test]
fn boxes_and_overlapping_parcels_of_the_same_density_look_the_same() {
    let sigma_per_m = 0.4;
    let single = |density: &[f64]| {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::Isotropic);
        scene.suns = vec![sun(DVec3::new(1.0, -1.0, 0.0))];
        // So narrow that sunlight leaves the box at an edge for all of it.
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1e-8);
        scene.fog_boxes = density.iter().map(|d| fog_box(DVec3::ZERO, DVec3::ONE, *d)).collect();
        mean_and_error(&render_once(scene, 1000, 3))
    };
    let (one, one_error) = single(&[sigma_per_m]);
    let (five, five_error) =
        single(&[0.5 * sigma_per_m, 0.2 * sigma_per_m, 0.1 * sigma_per_m, 0.1 * sigma_per_m, 0.1 * sigma_per_m]);
    assert!((one - five).abs() < 4.0 * one_error.hypot(five_error), "{one} against {five}");
    // Sunlight at 45 degrees has crossed sqrt(2) of fog at every point of the middle ray; densities are f32.
    let along = |s: f64| sigma_per_m / (4.0 * PI) * (-sigma_per_m * (s + 2f64.sqrt())).exp();
    let expected = integrate(along, 0.0, 2.0);
    assert!((one - expected).abs() < 4.0 * one_error + 1e-6 * expected, "{one} +- {one_error} against {expected}");
}

#[test]
fn airlight_is_the_analytic_integral_whatever_the_step() {
    let (scattering, absorption, depth_m) = (0.3, 0.2, 4.0);
    let extinction: f64 = scattering + absorption;
    let expected = scattering / (4.0 * PI) * (1.0 - (-extinction * depth_m).exp()) / extinction;
    for step_m in [4.0, 1.0, 0.1] {
        let mut scene = empty_scene();
        with_air(&mut scene, scattering, absorption, depth_m, step_m);
        scene.settings.effects.insert(Effect::AirMultiple, Switch::Off);
        let outcome = render_scene(scene, 4, 11);
        let (mean, error) = mean_and_error(&outcome);
        // Air alone has no noise; pixels are f32.
        assert!((mean - expected).abs() < 1e-7 * expected, "step {step_m}: {mean} +- {error} against {expected}");
        assert!((mean_of(&outcome, "transmittance.G") - (-extinction * depth_m).exp()).abs() < 1e-6);
    }
}

#[test]
fn fog_shades_the_air_behind_it() {
    let mut scene = empty_scene();
    with_air(&mut scene, 0.1, 0.0, 20.0, 0.5);
    scene.suns = vec![sun(DVec3::NEG_Y)];
    // An opaque lid over the whole view: no sunlight reaches the air below it.
    scene.fog_boxes = vec![fog_box(DVec3::new(0.0, 5.0, 0.0), DVec3::new(50.0, 1.0, 50.0), 1e3)];
    assert_eq!(mean_of(&render_scene(scene, 4, 1), "airlight.G"), 0.0);
}

/// Rationale: where shade begins inside a step, the step is noise and no bias. Set-up: a ray through air whose far part, a half-space, lies
/// under a lid that lets a tenth of the sunlight through; steps longer than the lit part and shorter. Expected: the two parts'
/// integrals, within four errors of 2 % at most.
#[test]
fn a_shaded_half_space_is_the_analytic_integral_whatever_the_step() {
    let (scattering, absorption, depth_m, lit_m, through) = (0.3, 0.2, 4.0, 1.3, 0.1f64);
    let extinction: f64 = scattering + absorption;
    let until = |s: f64| -(-extinction * s).exp_m1() / extinction;
    let expected = scattering / (4.0 * PI) * (until(lit_m) + through * (until(depth_m) - until(lit_m)));
    for step_m in [4.0, 1.0, 0.1] {
        let mut scene = empty_scene();
        with_air(&mut scene, scattering, absorption, depth_m, step_m);
        scene.settings.effects.insert(Effect::AirMultiple, Switch::Off);
        scene.suns = vec![sun(DVec3::NEG_Y)];
        scene.camera = orthographic(DVec3::ZERO, 1e-9);
        let lid = DVec3::new(0.0, 5.0, -lit_m - 50.0);
        scene.fog_boxes = vec![fog_box(lid, DVec3::new(50.0, 0.5, 50.0), -through.ln())];
        let outcome = render_scene(scene, 400, 12);
        let mean = mean_of(&outcome, "airlight.G");
        let error = mean_and_error(&outcome).1;
        assert!((mean / expected - 1.0).abs() < 4.0 * error / mean + 1e-6, "{step_m}: {mean} +- {error}, {expected}");
        assert!(error < 0.02 * expected, "{step_m}: {error} of {expected}");
    }
}

#[test]
fn the_background_shines_through_in_every_mode() {
    let modes = [
        SpectralMode::Mono { wavelength_m: 550e-9 },
        SpectralMode::Rgb { wavelengths_m: [650e-9, 550e-9, 450e-9] },
        SpectralMode::Bands { count: 1 },
        SpectralMode::Bands { count: 8 },
        SpectralMode::Bands { count: 33 },
    ];
    for mode in modes {
        let mut scene = empty_scene();
        scene.settings.spectral_mode = Some(mode);
        scene.settings.background.radiance = [0.7; 3];
        let picture = channels(&render_scene(scene, 2, 1));
        for channel in ["R", "G", "B", "background.R", "background.B"] {
            assert!((mean(&picture[channel]) - 0.7).abs() < 1e-6, "{mode:?} {channel} {}", mean(&picture[channel]));
        }
        assert!(mean(&picture["A"]).abs() < 1e-6);
    }
}

/// A white, isotropic scatterer of no depth has radiance tau / (4 pi) in every band; a white diffuser has 1 / pi and
/// pixel value 1, so the fog has luminance tau / 4.
#[test]
fn bands_are_normalised_to_a_white_diffuser() {
    let mut scene = empty_scene();
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 16 });
    with_phase(&mut scene, PhaseModel::Isotropic);
    scene.classes[0].albedo = Some(1.0);
    let tau = 1e-4;
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 0.5 * tau)];
    let picture = channels(&render_scene(scene, 20_000, 1));
    let luminance = 0.2126 * mean(&picture["R"]) + 0.7152 * mean(&picture["G"]) + 0.0722 * mean(&picture["B"]);
    // A path meets this fog once in ten thousand: 1.3 million paths leave 9 % of noise.
    assert!((luminance / (tau / 4.0) - 1.0).abs() < 0.3, "{luminance}");
}

#[test]
fn layers_add_up_and_threads_do_not_matter() {
    let picture = |threads: usize| {
        let mut scene = empty_scene();
        scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 4 });
        scene.settings.background.radiance = [0.1, 0.2, 0.3];
        with_air(&mut scene, 0.05, 0.01, 12.0, 2.0);
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1.5);
        let at = |i: i32| DVec3::new(f64::from(i % 7) - 3.0, f64::from(i % 5) - 2.0, f64::from(i % 3)) * 0.3;
        scene.particles =
            (0..40).map(|i| parcel(at(i), 0.4, 1e9)).chain((0..40).map(|i| droplet(at(i), 0.1, 5e-6))).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| channels(&render_scene(scene, 8, 9)))
    };
    let one = picture(1);
    assert_eq!(one, picture(2));
    assert_eq!(one, picture(7));
    for c in ["R", "G", "B"] {
        for (i, beauty) in one[c].iter().enumerate() {
            let layers = ["direct", "multiple", "airlight", "glow", "air_multiple", "refraction", "background"];
            let sum: f32 = layers.iter().map(|layer| one[&format!("{layer}.{c}")][i]).sum();
            assert!((sum - beauty).abs() <= 1e-6 * beauty.abs(), "{sum} {beauty}");
        }
    }
}

/// Air within the ball about the camera weakens the background on every leg of a path: surroundings of radiance 1 seen
/// through absorbing air and white, isotropic fog far smaller than the ball are exp(-absorption * depth) dark all over.
#[test]
fn air_weakens_scattered_background_too() {
    let mut scene = empty_scene();
    with_air(&mut scene, 0.0, 0.2, 5.0, 5.0);
    with_phase(&mut scene, PhaseModel::Isotropic);
    scene.classes[0].albedo = Some(1.0);
    scene.settings.background.radiance = [1.0; 3];
    scene.suns[0].lux = 0.0;
    let radius_m = 1e-3;
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::splat(radius_m), 1.0 / radius_m)];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 2.0 * radius_m), 0.5 * radius_m);
    let (mean, error) = mean_and_error(&render_scene(scene, 400, 2));
    // Ways differ from the ball's radius by millimetres: 1e-3 at most.
    assert!((mean - f64::exp(-1.0)).abs() < 4.0 * error + 1e-3, "{mean} +- {error}");
}

/// The air is a ball about the camera, also for an orthographic one: its ray at offset b crosses sqrt(depth^2 - b^2) of
/// it, and one that starts outside of the ball and misses it crosses none.
#[test]
fn orthographic_rays_cross_a_chord_of_the_air() {
    let (depth_m, absorption): (f64, f64) = (2.0, 0.5);
    let mut scene = empty_scene();
    with_air(&mut scene, 0.0, absorption, depth_m, 1.0);
    scene.camera = orthographic(DVec3::new(3.0, -1.0, 10.0), 3.0);
    scene.settings.image.resolution = [600, 1];
    scene.camera.lens = mie_cloud::scene::model::Lens::Orthographic { xmag_m: 3.0, ymag_m: 1e-6 };
    let transmittance = &channels(&render_scene(scene, 1, 1))["transmittance.G"];
    for (column, found) in transmittance.iter().enumerate() {
        // Somewhere in the pixel, 0.01 m wide.
        let chord = |b: f64| (-absorption * (depth_m * depth_m - b * b).max(0.0).sqrt()).exp();
        let (left, right) = (0.01 * column as f64 - 3.0, 0.01 * column as f64 - 2.99);
        let (low, high) = (chord(left).min(chord(right)), chord(left).max(chord(right)));
        assert!((low - 1e-4..=high + 1e-4).contains(&f64::from(*found)), "{column}: {found} in {low} .. {high}");
    }
}
