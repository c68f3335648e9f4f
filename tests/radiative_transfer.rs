//! All orders of scattering against radiative transfer: plane-parallel slabs by discrete ordinates, furnaces, orders.

mod common;

use common::*;
use glam::{DMat3, DVec3};
use mie_cloud::optics::DropletClass;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{FogBox, Lens, Scene};
use mie_cloud::spectrum::SpectralMode;
use serde_json::Value;
use std::collections::BTreeMap;

/// A slab of unit thickness, so wide that its edges do not matter, with its top at z = 0.5 and light coming down.
fn slab(case: &Value) -> Scene {
    let number = |key: &str| case[key].as_f64().unwrap();
    let mut scene = empty_scene();
    let half = DVec3::new(1e3, 1e3, 0.5);
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, half, number("tau"))];
    scene.classes[0].albedo = Some(number("albedo"));
    scene.classes[0].phase = match case["phase"].as_str().unwrap() {
        "iso" => PhaseModel::Isotropic,
        hg => PhaseModel::HenyeyGreenstein { g: Some(hg.trim_start_matches("hg").parse().unwrap()) },
    };
    let zenith = number("sun_zenith_deg").to_radians();
    scene.suns = vec![sun(DVec3::new(zenith.sin(), 0.0, -zenith.cos()))];
    scene
}

/// Looks at the slab against light that travels with the given cosine to +z (reflected) or -z (transmitted).
fn look(scene: &mut Scene, mu: f64, azimuth_deg: f64, reflected: bool) {
    let up = if reflected { mu } else { -mu };
    let (sin, phi) = ((1.0 - mu * mu).sqrt(), azimuth_deg.to_radians());
    let travel = DVec3::new(sin * phi.cos(), sin * phi.sin(), up);
    let (x, y) = travel.any_orthonormal_pair();
    scene.camera = orthographic(travel * 10.0, 0.01);
    scene.camera.world_from_camera = DMat3::from_cols(x, y, travel);
}

/// Rationale: the picture of a wide slab is the solution of the one-dimensional equation of transfer. Set-up: cases of
/// isotropic and Henyey-Greenstein slabs from a discrete-ordinate solver. Expected: radiances within four combined
/// errors; own errors at most 2 % here, so that the test stays short.
#[test]
fn slabs_have_the_radiances_of_discrete_ordinates() {
    let cases: Value = serde_json::from_str(include_str!("data/transport/slabs.json")).unwrap();
    let mut checked = 0;
    for case in cases["cases"].as_array().unwrap() {
        for (key, reflected) in [("reflected_radiance", true), ("transmitted_diffuse_radiance", false)] {
            for (i, mu) in case["view_mu"].as_array().unwrap().iter().enumerate() {
                let azimuths = case["rel_azimuth_deg"].as_array().unwrap();
                // Every third direction, a different azimuth each time.
                let j = i % azimuths.len();
                if (i + usize::from(reflected)) % 3 != 0 {
                    continue;
                }
                let expected = case[key][i][j].as_f64().unwrap();
                let mut scene = slab(case);
                look(&mut scene, mu.as_f64().unwrap(), azimuths[j].as_f64().unwrap(), reflected);
                let (mean, error) = mean_and_error(&render_scene(scene, 1500, 1 + checked));
                let digits = &case[if reflected { "agree_digits_reflected" } else { "agree_digits_transmitted" }][i][j];
                let allowed = 4.0 * (error + 10f64.powf(-digits.as_f64().unwrap()) * expected);
                assert!((mean - expected).abs() < allowed, "{case}\n{key}[{i}][{j}]: {mean} +- {error}");
                assert!(error < 0.02 * expected, "{case}\n{key}[{i}][{j}]: {error} of {expected}");
                checked += 1;
            }
        }
    }
    assert!(checked >= 12, "{checked}");
}

/// A white furnace: what neither absorbs nor emits cannot be seen in surroundings of one radiance.
#[test]
fn white_clouds_vanish_in_a_furnace() {
    let forms: [fn(&mut Scene); 4] = [
        |scene| scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.5), 3.0)],
        |scene| scene.particles = vec![parcel(DVec3::ZERO, 1.0, 4e10), parcel(DVec3::X * 0.5, 0.7, 1e10)],
        |scene| {
            let at = |i: i32| DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)) / 5.0 - 1.0;
            scene.particles = (0..1000).map(|i| droplet(at(i) * 1.01, 0.1, 5e-6)).collect();
        },
        |scene| {
            scene.fog_boxes = vec![fog_box(DVec3::Y * 0.3, DVec3::ONE, 1.0)];
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, 2e10), droplet(DVec3::Z * 0.2, 0.4, 5e-6)];
        },
    ];
    for (i, form) in forms.into_iter().enumerate() {
        let mut scene = empty_scene();
        form(&mut scene);
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.6) });
        scene.classes[0].albedo = Some(1.0);
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.8);
        scene.settings.background.radiance = [0.5; 3];
        scene.suns[0].lux = 0.0;
        let outcome = render_scene(scene, 400, 5);
        let (mean, error) = mean_and_error(&outcome);
        assert!((mean - 0.5).abs() < 4.0 * error + 1e-6, "form {i}: {mean} +- {error}");
        assert!(error < 0.003, "form {i}: {error}");
    }
}

/// Turns an empty scene into a cloud.
type Form<'a> = &'a dyn Fn(&mut Scene);

/// A white furnace around scenes that take other ways through the program: droplets of their own size, exact phase
/// functions at eight wavelengths, more bodies on a ray than are searched at once, a camera inside.
#[test]
fn white_clouds_vanish_in_a_furnace_whatever_way_they_are_followed() {
    let lattice = |n: i32, radius_m: f64, own_m: f64, scale: f64| -> Vec<_> {
        let at = |i: i32| DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / f64::from(n);
        (0..n * n * n).map(|i| droplet((at(i) - 0.45) * scale, radius_m, own_m)).collect()
    };
    let forms: [(&str, Form); 5] = [
        ("droplets of their own size", &|scene| {
            scene.particles = lattice(10, 5e-6, 5e-6, 1e-4);
            scene.camera = orthographic(DVec3::new(0.0, 0.0, 1e-3), 4e-5);
        }),
        ("magnified droplets of several sizes, exact, in bands", &|scene| {
            scene.particles = lattice(8, 0.08, 2e-6, 1.5);
            scene.particles.iter_mut().step_by(3).for_each(|particle| particle.droplet_radius_m = 1e-6);
            // Not along the lattice: no two discs are met at exactly one distance.
            scene.camera = camera_for(DVec3::new(0.1, 0.2, 1.0).normalize(), 0.8);
            with_phase(scene, PhaseModel::Mie);
            scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 8 });
        }),
        ("parcels and a box, exact, in bands", &|scene| {
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, 3e10), parcel(DVec3::X * 0.4, 0.5, 1e10)];
            scene.particles[1].droplet_radius_m = 1.5e-6;
            scene.fog_boxes = vec![fog_box(DVec3::Y * 0.2, DVec3::splat(0.7), 1.0)];
            with_phase(scene, PhaseModel::Mie);
            scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 8 });
        }),
        ("300 parcels and 300 droplets on every ray", &|scene| {
            let shift = |i: i32| DVec3::new(f64::from(i % 17), f64::from(i % 13), f64::from(i % 11)) * 1e-3;
            scene.particles = (0..300).map(|i| parcel(shift(i), 1.0, 1e8)).collect();
            scene.particles.extend((0..300).map(|i| droplet(shift(i) * 50.0 - 0.4, 0.02, 5e-6)));
            scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.3);
        }),
        ("from inside", &|scene| {
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, 3e10), droplet(DVec3::new(0.1, 0.0, -0.3), 0.1, 5e-6)];
            scene.fog_boxes = vec![fog_box(DVec3::Y * 0.2, DVec3::splat(0.7), 1.0)];
            scene.camera.position_m = DVec3::new(0.1, 0.2, 0.1);
            scene.camera.lens = Lens::Perspective { yfov_rad: 1.5, aspect: None };
        }),
    ];
    for (name, form) in forms {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.6) });
        scene.classes[0].albedo = Some(1.0);
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.8);
        form(&mut scene);
        without_refraction(&mut scene);
        scene.settings.background.radiance = [0.5; 3];
        scene.suns[0].lux = 0.0;
        let outcome = render_scene(scene, 400, 5);
        let (mean, error) = mean_and_error(&outcome);
        println!("{name}: {mean} +- {error}, transmittance {}", mean_of(&outcome, "transmittance.G"));
        assert!((mean - 0.5).abs() < 4.0 * error + 1e-6, "{name}: {mean} +- {error}");
        assert!(error < 0.005, "{name}: {error}");
        assert!(mean_of(&outcome, "transmittance.G") < 0.9, "{name}: there is something to see");
    }
}

#[test]
fn orders_add_up() {
    let scene = |_| {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::Isotropic);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 1.0)];
        scene
    };
    let all = render_scene(scene(()), 200, 3);
    let once = render_once(scene(()), 200, 3);
    assert_eq!(mean_of(&once, "direct.G"), mean_of(&all, "direct.G"), "the first order is drawn alike");
    assert_eq!(mean_of(&once, "multiple.G"), 0.0);
    let (direct, multiple) = (mean_of(&all, "direct.G"), mean_of(&all, "multiple.G"));
    assert!((direct + multiple - mean_of(&all, "G")).abs() < 1e-6);
    assert!(multiple > 0.3 * direct, "{multiple} {direct}");
}

/// A cloud of boxes, parcels and droplets whose phase functions differ: Mie functions of droplets of 0.25 to 2 um, and a sharp and
/// a wide one of Henyey and Greenstein.
fn mixed_cloud() -> Scene {
    let mut scene = empty_scene();
    let class = |g| {
        let phase = PhaseModel::HenyeyGreenstein { g: Some(g) };
        DropletClass { phase, albedo: Some(0.95), ..scene.classes[0].clone() }
    };
    scene.classes.extend([class(0.9), class(0.5)]);
    let at = |i: i32| DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)) / 4.5 - 1.0;
    scene.particles = (0..1000).map(|i| droplet(at(i), 0.07, 0.25e-6 * f64::from(1 + i % 8))).collect();
    let dense = |class, x: f64| FogBox { class, ..fog_box(DVec3::X * x, DVec3::new(0.5, 1.0, 1.0), 1.0) };
    scene.fog_boxes = vec![dense(1, -0.5), dense(2, 0.5)];
    scene.suns = vec![sun(DVec3::new(1.0, -0.4, -0.3)), sun(DVec3::new(0.3, 0.2, 1.0))];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1.0);
    without_refraction(&mut scene);
    scene
}

/// Five pictures: their mean with its error, and the error that a median one of them says for all. Paths of one droplet's peak at another's are so rare and
/// bright here that one picture in some ten is six times as noisy.
fn five_pictures(prepared: &mie_cloud::transport::Prepared, first_seed: u64) -> (f64, f64, f64) {
    let picture = |seed| mean_and_error(&render_prepared(prepared, 400, seed));
    let all: Vec<(f64, f64)> = (first_seed..first_seed + 5).map(picture).collect();
    let mean = all.iter().map(|(mean, _)| mean / 5.0).sum();
    let error = all.iter().map(|(_, error)| (error / 5.0).powi(2)).sum::<f64>().sqrt();
    let mut errors: Vec<f64> = all.iter().map(|(_, error)| *error).collect();
    errors.sort_by(f64::total_cmp);
    (mean, error, errors[2] / 5f64.sqrt())
}

/// Rationale: chains of small turns toward the sun only change who draws a path. Set-up: `mixed_cloud`, with and without them, one
/// sun at the side and one ahead. Expected: the same mean within four errors, of 3 % at most as a rule, whatever the order, and
/// noise of one kind: where phase functions differ as much as here, chains rather lose.
#[test]
fn chains_toward_the_sun_change_the_noise_and_not_the_mean() {
    for max_order in [2, 3, u32::MAX] {
        let prepared = || {
            let mut prepared = prepare(mixed_cloud(), &BTreeMap::new());
            prepared.max_order = max_order;
            prepared
        };
        let (mean, error, typical) = five_pictures(&prepared(), 1);
        let (plain, plain_error, plain_typical) = five_pictures(&prepared().without_chains(), 6);
        let both = error.hypot(plain_error);
        assert!((mean - plain).abs() < 4.0 * both, "order {max_order}: {mean} +- {error}, {plain} +- {plain_error}");
        let both = typical.hypot(plain_typical);
        assert!(both < 0.03 * mean, "order {max_order}: {both} of {mean}");
        // All orders of this cloud of differing phase functions cost more, 1.6 times when it was written.
        let most = if max_order < 4 { 1.5 } else { 2.5 };
        assert!(typical < most * plain_typical, "order {max_order}: {typical} {plain_typical}");
    }
}

/// Rationale: the orders of scattering are a geometric series in the end. Set-up: pictures up to order 1, 2, .. of a slab
/// of optical depth 2, grey and isotropic. Expected: each adds light, the orders add up to the unlimited picture, and
/// what is missing falls by one ratio; the direct layer is the same in all.
#[test]
fn pictures_of_more_orders_converge() {
    let mut scene = empty_scene();
    with_phase(&mut scene, PhaseModel::Isotropic);
    scene.classes[0].albedo = Some(0.9);
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 0.5), 2.0)];
    scene.camera = camera_for(DVec3::new(0.3, 0.1, 0.9).normalize(), 0.01);
    let mut prepared = prepare_all(scene);
    let mut up_to = |order: u32| {
        prepared.max_order = order;
        let outcome = render_prepared(&prepared, 4000, 1);
        let (mean, error) = mean_and_error(&outcome);
        let (direct, multiple) = (mean_of(&outcome, "direct.G"), mean_of(&outcome, "multiple.G"));
        assert!((direct + multiple - mean).abs() < 1e-6 * mean, "the layers add up");
        (mean, error, direct)
    };
    let (all, all_error, direct) = up_to(u32::MAX);
    let missing: Vec<f64> = (1..=10).map(|order| all - up_to(order).0).collect();
    println!("{all} +- {all_error}: {missing:?}");
    for pair in missing.windows(2) {
        assert!(0.0 < pair[1] && pair[1] < pair[0], "{missing:?}");
    }
    assert!((up_to(7).2 - direct).abs() < 4.0 * all_error, "one first order in all");
    assert!((up_to(60).0 - all).abs() < 1e-3 * all, "60 orders are nearly all");
    let ratios: Vec<f64> = missing[3..].windows(2).map(|pair| pair[1] / pair[0]).collect();
    let (least, most) = ratios.iter().fold((1.0f64, 0.0f64), |(least, most), r| (least.min(*r), most.max(*r)));
    // Random numbers are common to the pictures; from the fourth order on the ratio is that of the slowest mode.
    assert!(most - least < 0.06 && most < 0.9, "{ratios:?}");
}

/// Rationale: of discs that a ray meets at one distance, one is first, for every wavelength the same. Set-up: a lattice of overlapping
/// droplets of two sizes, seen along its rows, white, in a furnace. Expected: its radiance, in colours that each draw by themselves.
#[test]
fn discs_at_one_distance_are_met_one_after_the_other() {
    let mut scene = empty_scene();
    let at = |i: i32| DVec3::new(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64)) / 4.0 - 0.875;
    let own_radius_m = |i: i32| if (i + i / 8 + i / 64) % 2 == 0 { 0.3e-6 } else { 1e-6 };
    scene.particles = (0..512).map(|i| droplet(at(i), 0.2, own_radius_m(i))).collect();
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 8 });
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.6) });
    scene.classes[0].albedo = Some(1.0);
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.8);
    scene.settings.background.radiance = [0.5; 3];
    scene.suns[0].lux = 0.0;
    without_refraction(&mut scene);
    let (mean, error) = mean_and_error(&render_scene(scene, 500, 7));
    assert!((mean - 0.5).abs() < 4.0 * error, "{mean} +- {error}");
    assert!(error < 0.003, "{error}");
}
