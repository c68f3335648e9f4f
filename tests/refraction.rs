//! Refraction by droplets that can be seen: the optics of one ball against closed forms, then balls in pictures.

mod common;

use std::collections::BTreeMap;
use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use mie_cloud::accel::LocalRay;
use mie_cloud::image::{Existing, Picture, exr};
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{Camera, Lens, Scene};
use mie_cloud::scene::settings::{Effect, Switch};
use mie_cloud::spectrum::SpectralMode;
use mie_cloud::transport::{Ball, Branch, Prepared, SurfaceEvent, reflectance};
use num_complex::Complex64;

const BALL: Ball = Ball { center: DVec3::ZERO, radius_m: 1.0 };

/// A ray along -z at a distance from the axis, and the distance to where it meets the unit ball.
fn ray_at(b: f64) -> (LocalRay, f64) {
    (LocalRay { origin: DVec3::new(b, 0.0, 3.0), direction: DVec3::NEG_Z }, 3.0 - (1.0 - b * b).sqrt())
}

/// Angle in degrees by which light is turned that enters, is reflected once inside, and leaves.
fn deviation_deg(m: Complex64, b: f64) -> f64 {
    let (ray, t_m) = ray_at(b);
    let (first, inside) = BALL.strike_outside(&ray, t_m, m).turn(Branch::Refraction);
    let (second, inside) = BALL.strike_inside(&inside, m).turn(Branch::Reflection);
    let (third, out) = BALL.strike_inside(&inside, m).turn(Branch::Refraction);
    let events = [first, second, third];
    assert_eq!(events, [SurfaceEvent::Entered, SurfaceEvent::ReflectedInside, SurfaceEvent::Left]);
    out.direction.dot(ray.direction).acos().to_degrees()
}

/// Rationale: rays of least deviation make the primary bow (Descartes 1637). Expected: D = 180 + 2 i - 4 r with
/// cos^2 i = (n^2 - 1) / 3 (Bohren & Huffman 1983, section 7.2), for water at each wavelength.
#[test]
fn the_primary_bow_stands_where_geometric_optics_puts_it() {
    let mut last = 0.0;
    for nm in [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0] {
        let m = Material::Water.index(nm * 1e-9).expect("in range");
        let least = (1..100_000).map(|i| deviation_deg(m, f64::from(i) / 100_000.0)).fold(f64::INFINITY, f64::min);
        let i = ((m.re * m.re - 1.0) / 3.0).sqrt().acos();
        let r = (i.sin() / m.re).asin();
        let expected = 180.0 + (2.0 * i - 4.0 * r).to_degrees();
        assert!((least - expected).abs() < 1e-6, "{nm} nm: {least} against {expected}");
        // Red lies outside: it is turned less than blue.
        assert!(last == 0.0 || least < last);
        last = least;
    }
    assert!((137.0..138.5).contains(&last), "{last}");
}

/// What a plane surface lets through, by the amplitudes of the transmitted wave (Born & Wolf 1999, section 1.5.2), for
/// light that comes from outside.
fn transmittance(m: Complex64, cos_o: f64) -> f64 {
    let cos_i = (1.0 - (1.0 - cos_o * cos_o) / (m * m)).sqrt();
    let t_s = 2.0 * cos_o / (cos_o + m * cos_i);
    let t_p = 2.0 * cos_o / (m * cos_o + cos_i);
    let s = (m * cos_i).re / cos_o * t_s.norm_sqr();
    let p = (m * cos_i.conj()).re / cos_o * t_p.norm_sqr();
    0.5 * (s + p)
}

#[test]
fn what_is_not_reflected_passes_on_both_sides() {
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    for _ in 0..10_000 {
        let n = 1.0 + 2.0 * uniform();
        let absorbing = Complex64::new(n, 3.0 * uniform());
        let cos_o = uniform().max(1e-3);
        let sum = reflectance(absorbing, cos_o) + transmittance(absorbing, cos_o);
        assert!((sum - 1.0).abs() < 1e-12, "{absorbing} {cos_o}: {sum}");

        // From inside the index is one over n, and the angle any.
        let m = Complex64::new(n, 0.0);
        let (b, turn) = (uniform(), DVec3::new(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5).normalize());
        let ray = LocalRay { origin: DVec3::new(b, 0.0, 0.0), direction: turn };
        let strike = BALL.strike_inside(&ray, m);
        let cos_i = turn.dot(strike.point);
        let passed = if n * n * (1.0 - cos_i * cos_i) < 1.0 { transmittance(m.inv(), cos_i) } else { 0.0 };
        assert!((strike.reflectance + passed - 1.0).abs() < 1e-9, "{n} {cos_i}: {} {passed}", strike.reflectance);
        assert_eq!(strike.refracted.is_none(), passed == 0.0);
    }
}

/// A lat-long picture from a function of column and row.
fn write_lat_long(path: &std::path::Path, [width, height]: [u32; 2], color: impl Fn(u32, u32) -> [f32; 3]) {
    let mut picture = Picture::new(width, height);
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let values = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        picture.push(name, values.map(|(column, row)| color(column, row)[c]).collect());
    }
    exr::write(path, &picture, Existing::Replace).expect("can be written");
}

/// A scene with one real drop of water without absorption, a metre in front of a camera, that fills most of the picture.
fn one_drop() -> Scene {
    let mut scene = empty_scene();
    scene.classes[0].material = Material::Constant { n: 1.33, k: 0.0 };
    // Phase functions of a centimetre take seconds and are not what is looked at.
    with_phase(&mut scene, PhaseModel::Isotropic);
    scene.particles = vec![droplet(DVec3::ZERO, 1e-2, 1e-2)];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 1.0), 1.1e-2);
    scene.settings.image.resolution = [16, 16];
    scene.suns[0].lux = 0.0;
    scene
}

/// Rationale: light that passes a transparent ball keeps its radiance. Expected: a constant background, seen through the
/// ball, by reflection and by total reflection, is as bright as beside it.
#[test]
fn a_transparent_ball_vanishes_in_a_furnace() {
    for n in [1.33, 2.4, 0.7] {
        let mut scene = one_drop();
        scene.classes[0].material = Material::Constant { n, k: 0.0 };
        scene.settings.background.radiance = [0.5; 3];
        let picture = channels(&render_scene(scene, 16, 1));
        for (i, value) in picture["G"].iter().enumerate() {
            // Of rays that keep less than a thousandth of their light a part stands for all: 1e-3 / 16 samples.
            assert!((value - 0.5).abs() < 1e-4, "n = {n}, pixel {i}: {value}");
        }
        assert!((mean(&picture["G"]) - 0.5).abs() < 1e-6, "{}", mean(&picture["G"]));
        assert!(mean(&picture["refraction.G"]) > 0.2 && mean(&picture["background.G"]) > 0.05);
    }
}

/// The same for many touching balls in fog and dispersive water in bands: white stays white.
#[test]
fn glass_in_fog_vanishes_in_a_furnace_at_all_wavelengths() {
    let mut scene = one_drop();
    scene.classes[0].material = Material::Water;
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 8 });
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.8) });
    scene.settings.background.radiance = [0.5; 3];
    let at = |i: i32| DVec3::new(f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)) * 4e-3;
    scene.particles = (0..64).map(|i| droplet(at(i) - DVec3::splat(6e-3), 2e-3, 2e-3)).collect();
    scene.fog_boxes = vec![fog_box(DVec3::Z * 8e-3, DVec3::splat(1e-2), 50.0)];
    let effects = BTreeMap::from([(Effect::Absorption, Switch::Off)]);
    let picture = channels(&render_with(scene, 256, 2, &effects));
    for channel in ["R", "G", "B"] {
        let errors = &picture[&format!("stderr.{channel}")];
        let error = errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>().sqrt() / errors.len() as f64;
        let mean = mean(&picture[channel]);
        assert!((mean - 0.5).abs() < 4.0 * error && error < 0.01, "{channel}: {mean} +- {error}");
    }
}

/// An index of one neither turns nor reflects: with and without the ball, a checkered background behind fog and air is the
/// same. The ball displaces 4e-3 m of 5 m of air, 1e-4 of its light.
#[test]
fn a_droplet_of_index_one_cannot_be_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("checker.exr");
    write_lat_long(&path, [512, 256], |column, row| if (column + row) % 2 == 0 { [1.0, 0.5, 0.2] } else { [0.1; 3] });
    let picture = |with_ball: bool| {
        let mut scene = one_drop();
        scene.classes[0].material = Material::Constant { n: 1.0, k: 0.0 };
        scene.classes[0].albedo = Some(1.0);
        scene.suns[0].lux = 1e5;
        scene.settings.sun.irradiance = 3.0;
        scene.settings.background.image = Some(path.clone());
        let yfov_rad = 0.03;
        scene.camera.lens = Lens::Perspective { yfov_rad, aspect: None };
        with_air(&mut scene, 0.05, 0.01, 5.0, 0.5);
        let fog = mie_cloud::optics::DropletClass { material: Material::Water, ..scene.classes[0].clone() };
        scene.classes.push(fog);
        let fog = fog_box(DVec3::NEG_Z * 2.0, DVec3::new(1.0, 1.0, 0.5), 0.5);
        scene.fog_boxes = vec![mie_cloud::scene::model::FogBox { class: 1, ..fog }];
        if with_ball {
            scene.particles[0] = droplet(DVec3::ZERO, 2e-3, 2e-3);
        } else {
            scene.particles.clear();
        }
        channels(&render_scene(scene, 256, 3))
    };
    let (with, without) = (picture(true), picture(false));
    assert!(mean(&with["refraction.G"]) > 0.0 && mean(&without["refraction.G"]) == 0.0);
    let (mut z2, mut worst) = (0.0f64, 0.0f64);
    for (i, seen) in with["G"].iter().enumerate() {
        let error = f64::from(with["stderr.G"][i]).hypot(without["stderr.G"][i].into()) + 1e-4;
        let z = f64::from(seen - without["G"][i]) / error;
        z2 += z * z / 256.0;
        worst = worst.max(z.abs());
    }
    assert!(worst < 4.5 && z2 < 1.3, "worst z {worst}, mean square {z2}");
    let (a, b) = (mean(&with["G"]), mean(&without["G"]));
    assert!((a / b - 1.0).abs() < 0.01, "{a} against {b}");
}

/// From the middle of a ball all rays leave at once; near its surface those beyond the critical angle never do.
#[test]
fn a_camera_inside_sees_out_as_far_as_light_comes_in() {
    let n: f64 = 1.33;
    let share_seen = |offset: f64| {
        let mut scene = one_drop();
        scene.settings.background.radiance = [1.0; 3];
        scene.settings.image.resolution = [64, 64];
        let lens = Lens::Perspective { yfov_rad: PI / 2.0, aspect: None };
        scene.camera = Camera { position_m: DVec3::new(0.0, 0.0, offset * 1e-2), lens, ..scene.camera };
        let picture = channels(&render_scene(scene, 16, 1));
        assert!(picture["background.G"].iter().all(|v| *v == 0.0) && picture["A"].iter().all(|v| *v == 1.0));
        mean(&picture["refraction.G"])
    };
    assert!((share_seen(0.0) - 1.0).abs() < 1e-6);
    assert!((share_seen(0.7) - 1.0).abs() < 1e-6, "0.7 of the radius is below 1 / 1.33");
    // At 0.95 R looking through the centre: rays turned by psi meet the surface at sin i = 0.95 sin psi < 1 / n.
    let sin = 1.0 / (n * 0.95);
    let tan = sin / (1.0 - sin * sin).sqrt();
    // The picture is 2 x 2 in tangents; the circle of radius `tan` cuts its sides.
    let inside = |x: f64, y: f64| f64::from(x.hypot(y) < tan);
    let steps = 2000;
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(steps);
    let expected: f64 =
        (0..steps).flat_map(|i| (0..steps).map(move |j| inside(at(i), at(j)))).sum::<f64>() / f64::from(steps).powi(2);
    let found = share_seen(0.95);
    assert!(expected < 0.99 && (found - expected).abs() < 5e-3, "{found} against {expected}");
}

/// A ball shows what lies behind it upside down and left-right reversed.
#[test]
fn a_ball_shows_the_world_upside_down() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("halves.exr");
    write_lat_long(&path, [64, 32], |column, row| [f32::from(row < 16), f32::from(column >= 32), 0.0]);
    let mut scene = one_drop();
    scene.settings.spectral_mode = Some(SpectralMode::Rgb { wavelengths_m: [650e-9, 550e-9, 450e-9] });
    scene.settings.background.image = Some(path);
    let picture = channels(&render_scene(scene, 64, 1));
    let at = |channel: &str, x: usize, y: usize| f64::from(picture[channel][16 * y + x]);
    // A quarter of the way from the middle to the edge; 1 % is reflected from in front.
    let (left, right) = (at("G", 4, 8), at("G", 11, 8));
    assert!(left > 0.9 && right < 0.05, "{left} {right}");
    assert!(at("R", 8, 4) < 0.05 && at("R", 8, 11) > 0.9, "{} {}", at("R", 8, 4), at("R", 8, 11));
}

/// Rationale: what a ball scatters is the mean over its disc. Set-up: one magnified droplet, refracting or not. Expected:
/// the same sunlight in the whole picture, and E Q_sca p all over the ball.
#[test]
fn a_ball_scatters_as_much_sunlight_as_a_disc() {
    let scene = || {
        let mut scene = empty_scene();
        scene.particles = vec![droplet(DVec3::ZERO, 1.0, 5e-6)];
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.5) });
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 2.0);
        scene.settings.image.resolution = [64, 64];
        scene
    };
    let with = |switch| render_with(scene(), 64, 1, &BTreeMap::from([(Effect::Refraction, switch)]));
    let (ball, disc) = (with(Switch::On), with(Switch::Off));
    let (ball_mean, disc_mean) = (mean_of(&ball, "direct.G"), mean_of(&disc, "direct.G"));
    let error = mean_and_error(&disc).1.hypot(mean_and_error(&ball).1);
    assert!((ball_mean - disc_mean).abs() < 4.0 * error, "{ball_mean} {disc_mean} +- {error}");
    assert_eq!(mean_of(&ball, "G"), ball_mean, "there is nothing else");
    let picture = channels(&ball);
    let middle = picture["direct.G"][64 * 32 + 32];
    assert!(picture["direct.G"][64 * 25 + 40] == middle, "the same all over it");
    assert!((f64::from(middle) * PI / 16.0 / ball_mean - 1.0).abs() < 0.01);
    assert!((picture["depth.Z"][64 * 32 + 32] - 9.0).abs() < 0.01, "the sphere, not its middle");
}

/// Absorption: a thick absorbing ball seen through its middle lets exp(-4 pi k 2 R / lambda) of what enters through.
#[test]
fn absorption_follows_the_way_through_the_ball() {
    let (n, k) = (1.33, 2e-6);
    let mut scene = one_drop();
    scene.classes[0].material = Material::Constant { n, k };
    scene.settings.background.radiance = [1.0; 3];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 1.0), 1e-5);
    let through = |scene: Scene| mean_and_error(&render_scene(scene, 1000, 1));
    let r = ((n - 1.0) / (n + 1.0)).powi(2);
    let a = |own_m: f64| f64::exp(-4.0 * PI * k * 2.0 * own_m / 550e-9);
    // Reflected in front, through, and every further crossing of the ball, which adds up.
    let expected = |own_m: f64| r + (1.0 - r).powi(2) * a(own_m) / (1.0 - r * a(own_m));
    let (mean, error) = through(scene.clone());
    assert!(expected(1e-2) < 0.7 && (mean - expected(1e-2)).abs() < 4.0 * error, "{mean} {}", expected(1e-2));
    // A magnified droplet absorbs as it does, not as it is drawn.
    scene.particles = vec![droplet(DVec3::ZERO, 1e-2, 1e-3)];
    let (mean, error) = through(scene);
    assert!((mean - expected(1e-3)).abs() < 4.0 * error + 1e-6, "{mean} {}", expected(1e-3));
}

/// The march through the air ends where a ball begins.
#[test]
fn air_ends_at_a_ball_and_goes_on_behind_it() {
    let (scattering, depth_m) = (0.3, 8.0);
    let mut scene = one_drop();
    scene.classes[0].material = Material::Constant { n: 1.0, k: 0.0 };
    scene.classes[0].albedo = Some(1.0);
    scene.suns[0].lux = 1e5;
    with_air(&mut scene, scattering, 0.0, depth_m, 0.1);
    // A ball of index 1 from 2 m to 4 m before the camera: 2 m of air, a gap, 4 m of air.
    scene.particles = vec![droplet(DVec3::ZERO, 1.0, 1.0)];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 3.0), 1e-3);
    // What the air scatters again is another matter.
    let once = BTreeMap::from([(Effect::AirMultiple, Switch::Off)]);
    let picture = channels(&render_with(scene, 400, 4, &once));
    let light = |from_m: f64, to_m: f64| ((-scattering * from_m).exp() - (-scattering * to_m).exp()) / (4.0 * PI);
    let (near, far) = (mean(&picture["airlight.G"]), mean(&picture["refraction.G"]));
    assert!((near / light(0.0, 2.0) - 1.0).abs() < 1e-5, "{near} {}", light(0.0, 2.0));
    assert!((far / light(2.0, 6.0) - 1.0).abs() < 1e-5, "{far} {}", light(2.0, 6.0));
}

#[test]
fn droplets_that_cannot_be_seen_do_not_refract() {
    let mut scene = one_drop();
    scene.settings.background.radiance = [1.0; 3];
    scene.particles = vec![droplet(DVec3::ZERO, 5e-4, 5e-4)];
    let picture = channels(&render_scene(scene, 16, 1));
    assert_eq!(mean(&picture["refraction.G"]), 0.0);
}

/// Rationale: sunlight that finds a collision by way of chains of small turns must not be counted twice, or lost, where balls
/// and a sun's disc are in the way. Expected: the same picture as by the plain estimator.
#[test]
fn chains_toward_the_sun_and_glass_agree_with_the_plain_estimator() {
    let scene = || {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.8) });
        scene.classes[0].albedo = Some(1.0);
        scene.suns = vec![sun(DVec3::new(0.5, -0.3, 1.0))];
        scene.suns[0].angular_diameter_deg = Some(20.0);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 1.0)];
        let at = |i: i32| DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)) * 0.6 - 0.6;
        scene.particles = (0..27).map(|i| droplet(at(i), 0.2, 5e-6)).collect();
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.9);
        prepare(scene, &BTreeMap::new())
    };
    let with = render_prepared(&scene(), 1000, 1);
    let without = render_prepared(&scene().without_chains(), 1000, 2);
    // The layers' own errors are smaller than those of their sum.
    let error = mean_and_error(&with).1.hypot(mean_and_error(&without).1);
    assert!(error < 0.03 * mean_of(&without, "G"), "{error}");
    for layer in ["multiple.G", "refraction.G", "direct.G", "G"] {
        let (a, b) = (mean_of(&with, layer), mean_of(&without, layer));
        assert!((a - b).abs() < 4.0 * error, "{layer}: {a} against {b} +- {error}");
    }
}

/// Rationale: light that one bright ball sends forward into the air, and the air to the camera by way of more air, is found by chains that end at the
/// ball. Set-up: balls in thin air, with chains and without, eight seeds each. Expected: the same mean of light that both scatter.
#[test]
fn chains_that_end_at_a_ball_keep_the_mean() {
    let scene = || {
        let mut scene = empty_scene();
        with_air(&mut scene, 0.002, 0.0, 20.0, 1.0);
        scene.suns = vec![sun(DVec3::new(0.4, -0.2, 1.0))];
        scene.particles = [-1.0, 0.0, 1.0].map(|x| droplet(DVec3::new(x, 0.3 * x, 0.5 * x), 0.15, 5e-6)).into();
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 6.0), 2.0);
        scene.settings.image.resolution = [16, 16];
        prepare(scene, &BTreeMap::new())
    };
    let measure = |prepared: &Prepared| {
        let of = |seed| mean_of(&render_prepared(prepared, 200, seed), "air_multiple.G");
        let means: Vec<f64> = (0..8).map(of).collect();
        let middle = means.iter().sum::<f64>() / 8.0;
        (middle, (means.iter().map(|mean| (mean - middle).powi(2)).sum::<f64>() / 7.0 / 8.0).sqrt())
    };
    let (with, plain) = (measure(&scene()), measure(&scene().without_chains()));
    // Eight seeds know their scatter to a quarter.
    assert!((with.0 - plain.0).abs() < 5.0 * with.1.hypot(plain.1), "{with:?} {plain:?}");
    assert!(with.1 < 0.01 * with.0 && plain.1 < 0.01 * plain.0, "{with:?} {plain:?}");
}
