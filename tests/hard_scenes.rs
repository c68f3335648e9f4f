//! Numerically hard scenes: every one is rendered and looked at, and compared with the right answer where it is known.

mod common;

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::time::Instant;

use common::*;
use glam::{DMat3, DVec3};
use mie_cloud::mie;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{Camera, Lens, Particle, Scene};
use mie_cloud::scene::settings::{Effect, Switch};
use mie_cloud::spectrum::SpectralMode;
use mie_cloud::transport::RenderOutcome;
use rand::{RngExt, SeedableRng};

/// Efficiencies of a water droplet at 550 nm, straight from the solver.
fn water(radius_m: f64) -> mie::Efficiencies {
    let index = Material::Water.index(550e-9).expect("visible");
    mie::efficiencies(2.0 * PI * radius_m / 550e-9, index).expect("in range")
}

/// Extinction cross section of a 5 um water droplet at 550 nm, m^2.
fn c_ext_m2() -> f64 {
    PI * 25e-12 * water(5e-6).q_ext
}

/// Number of 5 um droplets that give a ball of fog an optical depth through its centre.
fn count_for(optical_depth: f64, radius_m: f64) -> f64 {
    optical_depth / (2.0 * radius_m * c_ext_m2()) * 4.0 / 3.0 * PI * radius_m.powi(3)
}

/// Looks at every value of every channel, and hands the channels on.
fn sound(outcome: &RenderOutcome) -> BTreeMap<String, Vec<f32>> {
    let channels = channels(outcome);
    for (name, values) in &channels {
        for (i, value) in values.iter().enumerate() {
            assert!(value.is_finite(), "{name} is {value} at {i}");
            assert!(*value >= 0.0, "{name} is {value} at {i}");
            if name == "A" || name.starts_with("transmittance") {
                // Weights of wavelengths add up to 1 within the rounding of f64, far below that of f32.
                assert!(*value <= 1.0, "{name} is {value} at {i}");
            }
        }
    }
    channels
}

/// Renders, looks at everything, and returns means over the picture: transmittance and direct light, with its error.
struct Seen {
    transmittance: f64,
    direct: f64,
    error: f64,
}

fn see(scene: Scene, spp: u32) -> Seen {
    let outcome = render_scene(scene, spp, 1);
    let channels = sound(&outcome);
    let (_, error) = mean_and_error(&outcome);
    Seen { transmittance: mean(&channels["transmittance.G"]), direct: mean(&channels["direct.G"]), error }
}

/// A camera with a perspective lens that looks along -z.
fn perspective(position_m: DVec3, yfov_rad: f64) -> Camera {
    let lens = Lens::Perspective { yfov_rad, aspect: None };
    Camera { name: "test".into(), position_m, world_from_camera: DMat3::IDENTITY, lens }
}

/// A ray along -z, the same for every sample.
fn one_ray(position_m: DVec3) -> Camera {
    orthographic(position_m, 0.0)
}

/// A field of droplets in the square of the given half width, on a grid that is exact in binary.
fn field(n: usize, half_m: f64, radius_m: f64, origin_m: DVec3) -> Vec<Particle> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
    let grid_m = f64::exp2(-32.0);
    let mut at = || (half_m * (2.0 * rng.random::<f64>() - 1.0) / grid_m).round() * grid_m;
    (0..n).map(|_| droplet(origin_m + DVec3::new(at(), at(), at()), radius_m, radius_m)).collect()
}

/// Rationale: doubles resolve 1.2e-10 m at 1e6 m, a ten-thousandth of a droplet of 1 um. Expected: the picture at the
/// origin, but for that.
#[test]
fn micrometre_droplets_look_the_same_a_million_metres_away() {
    let picture = |origin_m: DVec3| {
        let mut scene = empty_scene();
        scene.particles = field(400, 2e-5, 1e-6, origin_m);
        scene.suns = vec![sun(DVec3::new(1.0, -1.0, -1.0))];
        scene.camera = orthographic(origin_m + DVec3::new(0.0, 0.0, 0.01), 2e-5);
        scene.settings.image.resolution = [32, 32];
        see(scene, 8)
    };
    let here = picture(DVec3::ZERO);
    assert!(here.transmittance < 0.9, "there is something to see: {}", here.transmittance);
    for origin_m in [DVec3::new(1e6, -1e6, 1e6), DVec3::new(0.0, 0.0, -1e6)] {
        let there = picture(origin_m);
        assert!((there.transmittance - here.transmittance).abs() < 1e-3, "{}", there.transmittance);
        assert!((there.direct - here.direct).abs() < here.error, "{} {}", there.direct, here.direct);
    }
}

#[test]
fn a_centimetre_of_cloud_is_seen_from_a_kilometre() {
    let picture = |camera: Camera| {
        let mut scene = empty_scene();
        scene.particles = field(2000, 0.005, 5e-5, DVec3::ZERO);
        scene.particles.push(parcel(DVec3::ZERO, 0.004, count_for(0.5, 0.004)));
        scene.camera = camera;
        scene.settings.image.resolution = [32, 32];
        see(scene, 8)
    };
    let near = picture(orthographic(DVec3::new(0.0, 0.0, 0.1), 0.005));
    let far = picture(perspective(DVec3::new(0.0, 0.0, 1000.0), 2.0 * (5e-6f64).atan()));
    // Rays at the picture's edge lean by 5e-6, which moves them by a thousandth of a droplet's radius in the cloud.
    assert!((far.transmittance - near.transmittance).abs() < 1e-3, "{} {}", far.transmittance, near.transmittance);
    assert!((far.direct / near.direct - 1.0).abs() < 1e-2, "{} {}", far.direct, near.direct);
    assert!(near.transmittance > 0.2 && near.transmittance < 0.8, "{}", near.transmittance);
}

#[test]
fn a_cloud_looks_the_same_at_any_scale() {
    let picture = |scale: f64| {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(8);
        let mut at = |half: f64| half * scale * (2.0 * rng.random::<f64>() - 1.0);
        let mut scene = empty_scene();
        scene.particles = (0..40)
            .map(|i| {
                let center_m = DVec3::new(at(1.0), at(1.0), at(1.0));
                // Optical depth goes with N / R^2.
                let fog = parcel(center_m, 0.5 * scale, count_for(0.3, 0.5) * scale * scale);
                if i % 2 == 0 { fog } else { droplet(center_m, 0.05 * scale, 5e-6) }
            })
            .collect();
        scene.suns = vec![sun(DVec3::new(1.0, -1.0, -1.0))];
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0 * scale), scale);
        scene.settings.image.resolution = [16, 16];
        see(scene, 16)
    };
    let one = picture(1.0);
    for scale in [1e-6, 1e3] {
        let other = picture(scale);
        // Radii and counts are f32; a disc's edge may pass on the other side of a sample.
        assert!((other.transmittance - one.transmittance).abs() < 1e-4, "{scale}: {}", other.transmittance);
        assert!((other.direct - one.direct).abs() < 0.1 * one.error, "{scale}: {} {}", other.direct, one.direct);
    }
}

/// Rationale: neither where a cloud is nor how large it is changes its picture. Set-up: a cloud of droplets and parcels a hundred
/// thousandth as wide as it is far, at the origin and a million times that far from it. Expected: the same within noise.
#[test]
fn a_small_far_cloud_looks_the_same_anywhere_and_at_any_scale() {
    // One length is a centimetre at scale 1: seen from 1 km, and a million metres off.
    let picture = |scale: f64, origin_m: DVec3| {
        let mut scene = empty_scene();
        let half_m = 0.005 * scale;
        let around = field(1000, 0.005, 1.0, DVec3::ZERO);
        let place = |p: &Particle| origin_m + p.center_m * scale;
        scene.particles = around.iter().map(|p| droplet(place(p), 5e-5 * scale, 5e-6)).collect();
        let fog = count_for(0.1, 0.001) * scale * scale;
        scene.particles.extend(around.iter().take(20).map(|p| parcel(place(p), 0.001 * scale, fog)));
        without_refraction(&mut scene);
        scene.suns = vec![sun(DVec3::new(1.0, -1.0, -1.0))];
        scene.camera =
            perspective(origin_m + DVec3::new(0.0, 0.0, 1000.0 * scale), 2.0 * (half_m / (1e3 * scale)).atan());
        scene.settings.image.resolution = [24, 24];
        see(scene, 8)
    };
    let here = picture(1.0, DVec3::ZERO);
    assert!((0.2..0.95).contains(&here.transmittance), "{}", here.transmittance);
    for (scale, origin_m) in [
        (1.0, DVec3::new(1e6, -1e6, 1e6)),
        (1e-6, DVec3::ZERO),
        (1e-6, DVec3::new(-1.0, 1.0, 1.0)),
        (1e3, DVec3::ZERO),
        (1e3, DVec3::new(1e9, 1e9, -1e9)),
    ] {
        let there = picture(scale, origin_m);
        let case = format!("{scale} at {origin_m}");
        // Doubles resolve a millionth of a droplet's drawn radius there; the same samples meet the same droplets.
        assert!((there.transmittance - here.transmittance).abs() < 2e-3, "{case}: {}", there.transmittance);
        assert!((there.direct - here.direct).abs() < here.error.hypot(there.error), "{case}: {}", there.direct);
    }
}

/// Rays that touch a glass ball, or pass by a hair: a white ball in white surroundings is white. Along its very edge next to no light
/// enters, and what does goes round more often than it is followed: of 1e-7 of the radius a thousandth is lost, of all of the
/// ball 1e-9. Where two balls touch, within roundings of both, rays are lost that go from one into the other for ever.
#[test]
fn rays_that_graze_glass_keep_their_light() {
    let seen = |b: f64, two: bool| {
        let mut scene = empty_scene();
        scene.classes[0].albedo = Some(1.0);
        scene.particles = vec![droplet(DVec3::ZERO, 1.0, 1e-3)];
        scene.particles.extend(two.then(|| droplet(DVec3::new(2.0, 0.0, 0.0), 1.0, 1e-3)));
        scene.suns[0].lux = 0.0;
        scene.settings.background.radiance = [1.0; 3];
        scene.settings.image.resolution = [4, 4];
        scene.camera = one_ray(DVec3::new(b, 0.0, 5.0));
        mean(&sound(&render_scene(scene, 64, 1))["G"])
    };
    for b in [0.0, 0.999, 1.0 - 1e-5, 1.0 - 1e-7, 1.0 - 1e-9, 1.0 - 1e-12, 1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.0 + 1e-9] {
        let (one, two) = (seen(b, false), seen(b, true));
        assert!((one - 1.0).abs() < 3e-3, "{b}: {one}");
        assert!(two < 1.02 && (two > 0.98 || (b - 1.0).abs() < 2e-9), "{b}: {two}");
    }
}

#[test]
fn rays_from_inside_from_the_surface_and_along_it_see_what_is_before_them() {
    let tau = 1.2;
    let through = |camera_m: DVec3| {
        let mut scene = empty_scene();
        scene.particles = vec![parcel(DVec3::ZERO, 1.0, count_for(tau, 1.0))];
        scene.camera = one_ray(camera_m);
        see(scene, 2).transmittance
    };
    let cases = [
        ("from the centre", DVec3::ZERO, 0.5 * tau),
        ("from the near surface", DVec3::Z, tau),
        ("from the far surface", DVec3::NEG_Z, 0.0),
        ("from behind", DVec3::new(0.0, 0.0, -3.0), 0.0),
        ("along the surface", DVec3::new(1.0, 0.0, 5.0), 0.0),
        ("a hair inside of it", DVec3::new(1.0 - 1e-12, 0.0, 5.0), tau * (2e-12f64).sqrt()),
        ("from just inside, outward", DVec3::new(0.0, 0.0, -1.0 + 1e-9), 0.5e-9 * tau),
    ];
    for (name, camera_m, depth) in cases {
        // The count is f32.
        assert!((through(camera_m) - f64::exp(-depth)).abs() < 1e-6, "{name}: {}", through(camera_m));
    }
}

#[test]
fn droplets_about_the_camera_and_boxes_around_it_are_no_trouble() {
    for camera_m in [DVec3::ZERO, DVec3::new(0.0, 0.0, 0.01), DVec3::new(0.05, 0.0, 0.0), DVec3::new(0.1, 0.0, 0.0)] {
        for lens in [one_ray(camera_m), perspective(camera_m, 3.1), perspective(camera_m, 1e-9)] {
            let mut scene = empty_scene();
            scene.particles = vec![droplet(DVec3::ZERO, 0.1, 5e-6), droplet(DVec3::ZERO, 1.0, 5e-6)];
            scene.fog_boxes = vec![fog_box(camera_m, DVec3::splat(0.2), 1.0), fog_box(DVec3::ZERO, DVec3::ONE, 0.1)];
            with_air(&mut scene, 0.01, 0.0, 5.0, 1.0);
            scene.suns = vec![sun(DVec3::Z), sun(DVec3::NEG_Z), sun(DVec3::X)];
            scene.camera = lens;
            see(scene, 16);
        }
    }
}

#[test]
fn coincident_and_nested_fog_adds_up() {
    let (tau, n) = (0.2, 7);
    let picture = |particles: Vec<Particle>| {
        let mut scene = empty_scene();
        scene.particles = particles;
        scene.suns = vec![sun(DVec3::new(1.0, -1.0, -1.0))];
        scene.camera = one_ray(DVec3::new(0.3, 0.2, 5.0));
        see(scene, 500)
    };
    let one = picture(vec![parcel(DVec3::ZERO, 1.0, f64::from(n) * count_for(tau, 1.0))]);
    let many = picture((0..n).map(|_| parcel(DVec3::ZERO, 1.0, count_for(tau, 1.0))).collect());
    assert!((one.transmittance - many.transmittance).abs() < 1e-6);
    assert!((one.direct - many.direct).abs() < 4.0 * one.error.hypot(many.error), "{} {}", one.direct, many.direct);
    // Shells within each other: chords add up.
    let radii = [1.0, 0.999_999, 0.8, 0.5, 0.37, 1e-3];
    let offset2 = 0.3 * 0.3 + 0.2 * 0.2;
    let chords = radii.iter().map(|r: &f64| tau / r * (r * r - offset2).max(0.0).sqrt());
    let nested = picture(radii.iter().map(|r| parcel(DVec3::ZERO, *r, count_for(tau, *r))).collect());
    assert!((nested.transmittance - (-chords.sum::<f64>()).exp()).abs() < 1e-6, "{}", nested.transmittance);
}

/// Rationale: parcels in one point add up to one parcel of all their droplets.
#[test]
fn a_million_parcels_in_one_point_are_one() {
    let tau = 1.0;
    let picture = |particles: Vec<Particle>| {
        let mut scene = empty_scene();
        scene.particles = particles;
        scene.camera = one_ray(DVec3::new(0.0, 0.0, 5.0));
        see(scene, 100)
    };
    let one = picture(vec![parcel(DVec3::ZERO, 1.0, count_for(tau, 1.0))]);
    let start = Instant::now();
    let million = picture(vec![parcel(DVec3::ZERO, 1.0, 1e-6 * count_for(tau, 1.0)); 1_000_000]);
    // Sums of a million f32 densities.
    assert!((one.transmittance - million.transmittance).abs() < 1e-4, "{}", million.transmittance);
    assert!((one.direct - million.direct).abs() < 4.0 * one.error.hypot(million.error) + 1e-4 * one.direct);
    // A tree over a million spheres of one centre would take hours.
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

/// Rationale: each of n droplets in one point lets 1 - p of the light pass. Set-up: droplets so small that p is their
/// extinction efficiency, 1e-6 or so.
#[test]
fn a_million_droplets_in_one_point_each_let_their_share_pass() {
    let (n, radius_m) = (1_000_000, 5e-9);
    let mut scene = empty_scene();
    scene.particles = vec![droplet(DVec3::ZERO, radius_m, radius_m); n];
    scene.camera = one_ray(DVec3::new(0.0, 0.0, 1.0));
    let seen = see(scene, 4);
    let expected = (1.0 - water(radius_m).q_ext).powi(n as i32);
    assert!(expected > 0.01 && expected < 0.99, "{expected}");
    assert!((seen.transmittance - expected).abs() < 1e-4, "{} {expected}", seen.transmittance);
}

#[test]
fn a_hundred_thousand_shells_about_one_centre_do_not_take_for_ever() {
    let start = Instant::now();
    let n = 100_000;
    let mut scene = empty_scene();
    let radius_m = |i: usize| 0.5 + 0.5 * i as f64 / n as f64;
    scene.particles =
        (0..n).map(|i| parcel(DVec3::ZERO, radius_m(i), count_for(1.0 / n as f64, radius_m(i)))).collect();
    scene.camera = one_ray(DVec3::new(0.0, 0.0, 5.0));
    let seen = see(scene, 1);
    assert!((seen.transmittance - (-1.0f64).exp()).abs() < 1e-4, "{}", seen.transmittance);
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

#[test]
fn scenes_of_one_particle_or_none_render() {
    let mut one = empty_scene();
    one.particles = vec![droplet(DVec3::ZERO, 5e-6, 5e-6)];
    one.camera = one_ray(DVec3::Z);
    let p = water(5e-6).q_ext;
    let passed = see(one, 64).transmittance;
    // p over the largest Q of the visible range, which is a little above the one at 550 nm.
    assert!((0.0..0.2).contains(&passed), "{passed} {p}");
    let mut air = empty_scene();
    with_air(&mut air, 0.1, 0.05, 10.0, 0.1);
    let outcome = render_scene(air, 16, 1);
    let channels = sound(&outcome);
    let expected = 0.1 / 0.15 * (1.0 - f64::exp(-1.5)) / (4.0 * PI);
    assert!((mean(&channels["airlight.G"]) / expected - 1.0).abs() < 1e-3, "{}", mean(&channels["airlight.G"]));
    let mut background = empty_scene();
    background.settings.background.radiance = [0.25; 3];
    assert!(sound(&render_scene(background, 1, 1))["G"].iter().all(|value| *value == 0.25));
}

#[test]
fn parcels_of_radii_over_nine_decades_add_up() {
    let radii: Vec<f64> = (0..10).map(|i| f64::powi(10.0, i - 6)).collect();
    let mut scene = empty_scene();
    scene.particles = radii.iter().map(|r| parcel(DVec3::ZERO, *r, count_for(0.1, *r).max(1e-30))).collect();
    scene.camera = one_ray(DVec3::new(0.0, 0.0, 3e3));
    let seen = see(scene, 16);
    assert!((seen.transmittance - (-1.0f64).exp()).abs() < 1e-5, "{}", seen.transmittance);
}

#[test]
fn droplets_of_radii_over_nine_decades_render_side_by_side() {
    let radii: Vec<f64> = (0..10).map(|i| f64::powi(10.0, i - 9)).collect();
    let center_m = |i: usize| DVec3::new(3.0 * i as f64, 0.0, 0.0);
    for (i, radius_m) in radii.iter().enumerate() {
        let mut scene = empty_scene();
        // Isotropic: what is tested is geometry, and tables of ten sizes take long.
        with_phase(&mut scene, PhaseModel::Isotropic);
        scene.particles = radii.iter().enumerate().map(|(k, r)| droplet(center_m(k), *r, *r)).collect();
        scene.camera = orthographic(center_m(i) + DVec3::new(0.0, 0.0, 2.0), 0.1 * radius_m);
        scene.settings.image.resolution = [2, 2];
        let passed = see(scene, 4).transmittance;
        if *radius_m < 2e-8 {
            assert!((1.0 - passed - water(*radius_m).q_ext).abs() < 1e-7, "{radius_m}: {passed}");
        } else {
            assert!(passed < 0.9, "{radius_m}: {passed}");
        }
    }
}

#[test]
fn almost_no_fog_is_linear() {
    for tau in [1e-8, 1e-15] {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::Isotropic);
        scene.classes[0].albedo = Some(1.0);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 0.5 * tau)];
        let seen = see(scene, 16);
        // Densities are f32; the first collision is forced, so that every path counts.
        assert!((seen.direct / (tau / (4.0 * PI)) - 1.0).abs() < 1e-5, "{tau}: {}", seen.direct);
    }
}

/// Lit from the camera's side, the light of single scattering from an endless depth is half of p.
#[test]
fn fog_of_an_optical_depth_of_ten_thousand_renders_in_bounded_time() {
    let start = Instant::now();
    for (albedo, tau) in [(1.0, 1e4), (0.5, 1e4), (1.0, 1e9)] {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::Isotropic);
        scene.classes[0].albedo = Some(albedo);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 1.0), 0.5 * tau)];
        let seen = see(scene, 64);
        let expected = albedo / (8.0 * PI);
        assert!((seen.direct - expected).abs() < 0.05 * expected, "{tau}: {} {expected}", seen.direct);
        assert_eq!(seen.transmittance, if tau > 1e5 { 0.0 } else { seen.transmittance });
        assert!(seen.transmittance < 1e-30);
    }
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

/// Chandrasekhar's H(1) for isotropic scattering, by iteration of 1/H(mu) = sqrt(1 - w) + w/2 int mu' H(mu') / (mu + mu') dmu'
/// (Chandrasekhar 1960, section 38).
fn h_at_one(albedo: f64) -> f64 {
    // The midpoint rule's error falls with the square of the step: 1e-6.
    const N: usize = 1000;
    let mu = |i: usize| (i as f64 + 0.5) / N as f64;
    let step = |at: f64, h: &[f64]| {
        let integral: f64 = (0..N).map(|i| mu(i) * h[i] / (at + mu(i))).sum::<f64>() / N as f64;
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * integral)
    };
    let mut h = vec![1.0; N];
    for _ in 0..200 {
        // Halfway each time: the conservative case swings.
        h = (0..N).map(|i| 0.5 * (h[i] + step(mu(i), &h))).collect();
    }
    step(1.0, &h)
}

/// Rationale: fog of an optical depth of 1e4 is as good as endless. Set-up: lit and seen straight from above. Expected: by Chandrasekhar
/// (1960) the radiance w H(1)^2 / (8 pi) of isotropic scattering, and in surroundings of radiance 1 the albedo of
/// the whole, 1 - sqrt(1 - w) H(1).
#[test]
fn fog_of_an_optical_depth_of_ten_thousand_is_semi_infinite() {
    assert!((h_at_one(1.0) - 2.907_8).abs() < 1e-3, "Chandrasekhar's table XI: {}", h_at_one(1.0));
    for albedo in [0.3, 0.9, 1.0] {
        let slab = || {
            let mut scene = empty_scene();
            with_phase(&mut scene, PhaseModel::Isotropic);
            scene.classes[0].albedo = Some(albedo);
            scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 1.0), 5e3)];
            scene
        };
        let h = h_at_one(albedo);
        let mut surrounded = slab();
        surrounded.suns[0].lux = 0.0;
        surrounded.settings.background.radiance = [1.0; 3];
        for (scene, expected) in [(slab(), albedo * h * h / (8.0 * PI)), (surrounded, 1.0 - (1.0 - albedo).sqrt() * h)]
        {
            let outcome = render_scene(scene, 64, 6);
            sound(&outcome);
            let (mean, error) = mean_and_error(&outcome);
            assert!((mean - expected).abs() < 4.0 * error + 1e-4 * expected, "{albedo}: {mean} +- {error}, {expected}");
            assert!(error < 0.04 * expected, "{albedo}: {error} of {expected}");
        }
    }
}

/// Rationale: in surroundings of radiance 1 everything that absorbs nothing has radiance 1. Set-up: fog so deep that
/// one path in twenty is longer than those that are thinned out. Expected: 1 within four standard errors.
#[test]
fn deep_white_fog_in_white_surroundings_cannot_be_seen() {
    let mut scene = empty_scene();
    with_phase(&mut scene, PhaseModel::Isotropic);
    scene.classes[0].albedo = Some(1.0);
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::splat(1.0), 5e3)];
    scene.suns[0].lux = 0.0;
    scene.settings.background.radiance = [1.0; 3];
    let outcome = render_scene(scene, 256, 4);
    sound(&outcome);
    let (mean, error) = mean_and_error(&outcome);
    assert!((mean - 1.0).abs() < 4.0 * error, "{mean} +- {error}");
    assert!(error < 0.03, "{error}");
}

#[test]
fn dense_clouds_of_overlapping_parcels_and_droplets_stay_sound() {
    let mut scene = empty_scene();
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(2);
    let mut at = || 2.0 * rng.random::<f64>() - 1.0;
    scene.particles = (0..500)
        .map(|i| {
            let center_m = DVec3::new(at(), at(), at());
            if i % 2 == 0 { parcel(center_m, 0.7, count_for(1e3, 0.7)) } else { droplet(center_m, 0.2, 5e-6) }
        })
        .collect();
    scene.camera = perspective(DVec3::new(0.0, 0.0, 3.0), 0.7);
    see(scene, 4);
}

#[test]
fn an_albedo_of_nothing_is_black_and_of_one_the_brightest() {
    let direct = |albedo: f64| {
        let mut scene = empty_scene();
        scene.classes[0].albedo = Some(albedo);
        scene.particles = vec![parcel(DVec3::ZERO, 1.0, count_for(1.0, 1.0)), droplet(DVec3::X, 1.0, 5e-6)];
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0), 1.0);
        see(scene, 8).direct
    };
    assert_eq!(direct(0.0), 0.0);
    assert!((direct(0.5) / direct(1.0) - 0.5).abs() < 1e-6);
}

/// Thin fog lit so that the camera sees the peak: radiance is tau p(peak), whatever the peak.
#[test]
fn sharp_peaks_are_seen_at_their_full_height() {
    let tau = 1e-6;
    // g = 0.99996 has a forward value of 1e8.
    for (g, direction) in [(0.9999, DVec3::Z), (-0.9999, DVec3::NEG_Z), (0.999_96, DVec3::Z)] {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(g) });
        scene.classes[0].albedo = Some(1.0);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 0.5 * tau)];
        scene.suns = vec![sun(direction)];
        let a: f64 = g.abs();
        let peak = (1.0 + a) / (4.0 * PI * (1.0 - a).powi(2));
        let seen = see(scene, 16);
        assert!((seen.direct / (tau * peak) - 1.0).abs() < 1e-4, "{g}: {} {}", seen.direct, tau * peak);
    }
    // Seen from the side and from a little beside the peak, thick.
    for g in [0.9999, -0.9999] {
        for direction in [DVec3::X, DVec3::new(1e-3, 0.0, 1.0), DVec3::new(1e-3, 0.0, -1.0)] {
            let mut scene = empty_scene();
            with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(g) });
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, count_for(10.0, 1.0))];
            scene.suns = vec![sun(direction)];
            scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0), 1.5);
            see(scene, 16);
        }
    }
}

/// p(0) = |S(0)|^2 / (k^2 C_sca), and Re S(0) = x^2 Q_ext / 4 by the optical theorem; the rest of S(0) is below 1 %.
#[test]
fn millimetre_drops_seen_straight_against_the_sun_shine_by_the_optical_theorem() {
    let (tau, radius_m) = (1e-6, 1e-3);
    let mut scene = empty_scene();
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 0.5 * tau)];
    scene.fog_boxes[0].droplet_radius_m = Some(radius_m);
    scene.suns = vec![sun(DVec3::Z)];
    let (q, x) = (water(radius_m), 2.0 * PI * radius_m / 550e-9);
    let expected = tau * q.q_sca / q.q_ext * x * x * q.q_ext * q.q_ext / (16.0 * PI * q.q_sca);
    let seen = see(scene, 16);
    assert!((seen.direct / expected - 1.0).abs() < 0.02, "{} {expected}", seen.direct);
}

#[test]
fn a_droplet_of_a_metre_renders() {
    let mut scene = empty_scene();
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 3 });
    // The cap keeps the table small; the sphere itself is far beyond the Mie series.
    scene.settings.accuracy.size_parameter_cap = 500.0;
    scene.particles = vec![droplet(DVec3::ZERO, 1.0, 1.0)];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0), 0.5);
    assert!(see(scene, 4).transmittance < 0.01, "Q_ext is 2, and so is the disc's area");
}

#[test]
fn thick_and_boundless_air_stays_sound_in_bounded_time() {
    let start = Instant::now();
    for (scattering, absorption, depth_m, step_m) in
        [(1e6, 0.0, 10.0, 0.05), (0.0, 1e12, 1e12, 1e9), (1e12, 1e12, 1e12, 1e12), (1e-9, 0.0, 1e12, 0.05)]
    {
        let mut scene = empty_scene();
        with_air(&mut scene, scattering, absorption, depth_m, step_m);
        scene.particles = vec![parcel(DVec3::ZERO, 1.0, 1e9)];
        scene.settings.background.radiance = [1e12; 3];
        scene.settings.image.resolution = [2, 2];
        see(scene, 1);
    }
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

/// A path in deep air that takes nothing has no reason to end but its length.
#[test]
fn deep_white_air_renders_in_bounded_time() {
    let start = Instant::now();
    for depth_m in [1e5, 1e12] {
        let mut scene = empty_scene();
        with_air(&mut scene, 0.05, 0.0, depth_m, 1.0);
        scene.settings.effects.insert(Effect::AirMultiple, Switch::On);
        scene.settings.image.resolution = [2, 2];
        see(scene, 16);
    }
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

#[test]
fn the_largest_coordinates_of_a_scene_stay_sound() {
    for origin_m in [DVec3::splat(1e12), DVec3::new(-1e12, 0.0, 1e12)] {
        let mut scene = empty_scene();
        scene.particles = vec![
            parcel(origin_m, 1e3, count_for(1.0, 1e3)),
            parcel(-origin_m, 1e12, 1e30),
            droplet(origin_m, 1.0, 5e-6),
            droplet(DVec3::ZERO, 1e-9, 1e-9),
        ];
        scene.camera = orthographic(origin_m + DVec3::new(0.0, 0.0, 1e4), 1e3);
        see(scene, 8);
    }
}

/// The largest count and density that a scene may give, in the smallest ball.
#[test]
fn the_densest_fog_that_a_scene_can_ask_for_is_opaque() {
    let mut scene = empty_scene();
    scene.particles = vec![parcel(DVec3::ZERO, 1e-10, 1e36), parcel(DVec3::ZERO, 1e-10, 1e36)];
    scene.fog_boxes = vec![fog_box(DVec3::Z, DVec3::ONE, 1e12)];
    scene.fog_boxes[0].droplet_radius_m = Some(1e-10);
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0), 1e-11);
    assert_eq!(see(scene, 8).transmittance, 0.0);
}

#[test]
fn every_spectral_mode_and_size_of_picture_is_sound() {
    let modes = [
        SpectralMode::Mono { wavelength_m: 380e-9 },
        SpectralMode::Mono { wavelength_m: 780e-9 },
        SpectralMode::Rgb { wavelengths_m: [650e-9, 550e-9, 450e-9] },
        SpectralMode::Bands { count: 1 },
        SpectralMode::Bands { count: 2 },
        SpectralMode::Bands { count: 33 },
    ];
    for mode in modes {
        for resolution in [[1, 1], [1, 9], [9, 1]] {
            let mut scene = empty_scene();
            scene.settings.spectral_mode = Some(mode);
            scene.settings.image.resolution = resolution;
            scene.settings.background.radiance = [0.0, 1.0, 0.0];
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, count_for(2.0, 1.0)), droplet(DVec3::X, 0.5, 5e-6)];
            with_air(&mut scene, 0.01, 0.01, 9.0, 3.0);
            scene.suns = vec![sun(DVec3::new(1.0, -2.0, -1.0))];
            scene.camera = perspective(DVec3::new(0.0, 0.0, 4.0), 0.6);
            see(scene, 4);
        }
    }
}

/// Saturated bows, coronas and coloured lamps: every wavelength shines, and so must every channel.
#[test]
fn saturated_colours_stay_sound() {
    for color in [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.2], [0.0, 0.0, 0.0]] {
        for count in [3, 8, 33] {
            let mut scene = empty_scene();
            scene.settings.spectral_mode = Some(SpectralMode::Bands { count });
            scene.settings.image.resolution = [24, 24];
            scene.particles = vec![parcel(DVec3::ZERO, 1.0, count_for(0.5, 1.0))];
            scene.suns = vec![sun(DVec3::new(0.3, -0.2, 1.0))];
            scene.suns[0].color = color;
            scene.camera = perspective(DVec3::new(0.0, 0.0, 1.5), 1.2);
            see(scene, 2);
        }
    }
}

#[test]
fn light_of_several_suns_adds_up() {
    let directions = [DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, -1.0, 0.5), DVec3::Z];
    let direct = |suns: &[DVec3]| {
        let mut scene = empty_scene();
        scene.particles = vec![parcel(DVec3::ZERO, 1.0, count_for(1.0, 1.0))];
        scene.suns = suns.iter().map(|direction| sun(*direction)).collect();
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0), 0.7);
        see(scene, 16).direct
    };
    let apart: f64 = directions.iter().map(|direction| direct(&[*direction])).sum();
    // The same random numbers look at every sun from the same places.
    assert!((direct(&directions) / apart - 1.0).abs() < 1e-6, "{} {apart}", direct(&directions));
}
