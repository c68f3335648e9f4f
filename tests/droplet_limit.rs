//! A field of single droplets tends to the continuous medium: its radiances are those of fog, the closer the more droplets.
//!
//! A droplet's disc of radius a leaves a tube free of other centres around the way that light has come, which the way on
//! shares near the droplet: light that turns by theta meets about a / (l sin(theta)) less optical depth than in fog, l the
//! mean free path (theory (99)). At a given optical depth a falls like the root of the number of droplets.

mod common;

use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use mie_cloud::mie;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::Scene;
use mie_cloud::transport::Prepared;
use rand::{RngExt, SeedableRng};
use serde_json::Value;

/// The slab is one thick and this wide to either side of the middle.
const HALF_WIDTH: f64 = 8.0;

/// Half width of the picture: at the views below it stays five thicknesses away from the slab's edges.
const HALF_PICTURE: f64 = 2.0;

/// What the slab's edges take from the picture at most, as measured in fog of this width.
const EDGES: f64 = 4e-3;

/// Direction in which light travels to the camera: up for what is reflected, with its azimuth from the sun's.
#[derive(Clone, Copy, Debug)]
struct View {
    reflected: bool,
    mu: f64,
    azimuth_deg: f64,
}

/// None nearer than 30 degrees to exact backscatter, where discs have a hot spot.
const VIEWS: [View; 4] = [
    View { reflected: true, mu: 0.9, azimuth_deg: 0.0 },
    View { reflected: true, mu: 0.7, azimuth_deg: 90.0 },
    View { reflected: false, mu: 0.9, azimuth_deg: 180.0 },
    View { reflected: false, mu: 0.7, azimuth_deg: 0.0 },
];

impl View {
    fn travel(self) -> DVec3 {
        let (sin, phi) = ((1.0 - self.mu * self.mu).sqrt(), self.azimuth_deg.to_radians());
        DVec3::new(sin * phi.cos(), sin * phi.sin(), if self.reflected { self.mu } else { -self.mu })
    }
}

fn slab_scene(albedo: f64) -> Scene {
    let mut scene = empty_scene();
    without_refraction(&mut scene);
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.75) });
    scene.classes[0].albedo = Some(albedo);
    // 60 degrees from the zenith.
    scene.suns = vec![sun(DVec3::new(3f64.sqrt(), 0.0, -1.0))];
    scene
}

/// Drawn radius at which a number of droplets gives the slab an optical depth.
fn drawn_radius(optical_depth: f64, count: usize) -> f64 {
    let index = Material::Water.index(550e-9).unwrap();
    let q_ext = mie::efficiencies(2.0 * PI * 5e-6 / 550e-9, index).unwrap().q_ext;
    (optical_depth * 4.0 * HALF_WIDTH * HALF_WIDTH / (count as f64 * q_ext * PI)).sqrt()
}

fn field(optical_depth: f64, albedo: f64, count: usize, seed: u64) -> Prepared {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
    let mut at = |half: f64| half * (2.0 * rng.random::<f64>() - 1.0);
    let radius = drawn_radius(optical_depth, count);
    let mut scene = slab_scene(albedo);
    let one = |_| droplet(DVec3::new(at(HALF_WIDTH), at(HALF_WIDTH), at(0.5)), radius, 5e-6);
    scene.particles = (0..count).map(one).collect();
    prepare_all(scene)
}

fn look(prepared: &mut Prepared, view: View, spp: u32, seed: u64) -> (f64, f64) {
    prepared.camera = camera_for(view.travel(), HALF_PICTURE);
    mean_and_error(&render_prepared(prepared, spp, seed))
}

/// The discrete-ordinate radiance of a Henyey-Greenstein slab (g = 0.75, albedo 0.9, sun 60 degrees from the zenith).
fn reference(optical_depth: f64, view: View) -> f64 {
    let reference: Value = serde_json::from_str(include_str!("data/transport/slab_reference.json")).unwrap();
    let wanted = |case: &&Value| {
        case["phase"] == "hg0.75"
            && case["albedo"] == 0.9
            && case["sun_zenith_deg"].as_f64() == Some(60.0)
            && case["tau"].as_f64() == Some(optical_depth)
    };
    let case = reference["cases"].as_array().unwrap().iter().find(wanted).expect("the slab is in the file");
    let place = |key: &str, value: f64| case[key].as_array().unwrap().iter().position(|v| v.as_f64() == Some(value));
    let key = if view.reflected { "reflected_radiance" } else { "transmitted_diffuse_radiance" };
    let (i, j) = (place("view_mu", view.mu).unwrap(), place("rel_azimuth_deg", view.azimuth_deg).unwrap());
    case[key][i][j].as_f64().unwrap()
}

/// Fields of one number of droplets, seen from one side.
struct Fields {
    /// Radiance over that of the continuous medium, minus 1: mean over the fields.
    deviation: f64,
    /// Standard error of the mean, from the fields' spread where there are several.
    error: f64,
    /// Root mean square deviation of one field's radiance from the continuous medium's, without the paths' noise.
    spread: f64,
}

fn compare(optical_depth: f64, views: &[(View, u32)], count: usize, fields: u64) -> Vec<Fields> {
    let mut radiances = vec![Vec::new(); views.len()];
    for seed in 0..fields {
        let mut droplets = field(optical_depth, 0.9, count, seed);
        for (radiances, (view, spp)) in radiances.iter_mut().zip(views) {
            radiances.push(look(&mut droplets, *view, *spp, seed));
        }
    }
    radiances.iter().zip(views).map(|(found, (view, _))| summary(found, reference(optical_depth, *view))).collect()
}

/// Of radiances with their errors, one per field.
fn summary(radiances: &[(f64, f64)], expected: f64) -> Fields {
    let n = radiances.len() as f64;
    let mean = |f: &dyn Fn(f64, f64) -> f64| {
        radiances.iter().map(|(l, e)| f(l / expected - 1.0, e / expected)).sum::<f64>() / n
    };
    let deviation = mean(&|d, _| d);
    let (squares, noise) = (mean(&|d, _| d * d), mean(&|_, e| e * e));
    let variance = (squares - deviation * deviation) * n / (n - 1.0).max(1.0);
    Fields { deviation, error: (variance.max(noise) / n).sqrt(), spread: (squares - noise).max(0.0).sqrt() }
}

/// Rationale: independent droplets at random places remove and scatter light as fog does. Set-up: a slab of a million
/// magnified droplets, optical depth 1 (discs of 0.009, spacing 0.063, thickness 1), seen from above and below. Expected:
/// the discrete ordinates' radiance of the continuous slab within 2 %, and within four standard errors.
#[test]
fn a_million_droplets_have_the_radiance_of_the_continuous_slab() {
    let views = [(VIEWS[1], 5000), (VIEWS[3], 1500)];
    for (Fields { deviation, error, .. }, (view, _)) in compare(1.0, &views, 1_000_000, 1).into_iter().zip(views) {
        println!("{view:?}: {deviation:+.4} +- {error:.4}");
        assert!(deviation.abs() < 0.02, "{view:?}: {deviation} +- {error}");

        assert!(deviation.abs() < 4.0 * error + EDGES, "{view:?}: {deviation} +- {error}");
        assert!(error < 0.01, "{view:?}: the test can tell 4 % apart: {error}");
    }
}

/// Rationale: how far one field is from the continuum depends on how many droplets the picture sees. Set-up: fields of
/// 1000, 10,000 and 100,000 droplets, each of the same depth. Expected: the mean over fields is that of the continuum
/// at every count; one field's deviation falls like the root of the number, 3.2 times per step.
#[test]
fn one_field_comes_closer_to_the_continuum_with_the_root_of_its_number() {
    let steps = [(1000, 24, 300), (10_000, 16, 800), (100_000, 8, 2000)];
    let found = steps.map(|(count, fields, spp)| compare(1.0, &[(VIEWS[3], spp)], count, fields).remove(0));
    for (Fields { deviation, error, spread }, step) in found.iter().zip(steps) {
        println!("{step:?}: {deviation:+.4} +- {error:.4}, one field {spread:.4}");
        assert!(deviation.abs() < 4.0 * error + EDGES, "{step:?}: {deviation} +- {error}");
    }
    for pair in found.windows(2) {
        // A spread from 8 fields is itself known to a quarter.
        let ratio = pair[0].spread / pair[1].spread;
        assert!((2.0..5.0).contains(&ratio), "{} to {}", pair[0].spread, pair[1].spread);
    }
}

/// All views, optical depths 0.1 and 1, 1e4 to 1e6 droplets.
#[test]
#[ignore = "takes minutes: cargo test --release --test droplet_limit -- --ignored --nocapture"]
fn fields_of_every_number_agree_with_the_continuous_slab_from_every_side() {
    for optical_depth in [0.1, 1.0] {
        for (count, fields, spp) in [(10_000, 64, 1000), (100_000, 16, 4000), (1_000_000, 4, 16_000)] {
            let found = compare(optical_depth, &VIEWS.map(|view| (view, spp)), count, fields);
            for (Fields { deviation, error, spread }, view) in found.into_iter().zip(VIEWS) {
                println!("{optical_depth} {count} {view:?}: {deviation:+.4} +- {error:.4}, one field {spread:.4}");
                assert!(deviation.abs() < 0.02, "{view:?}: {deviation} +- {error}");
                assert!(deviation.abs() < 4.0 * error + EDGES, "{view:?}: {deviation} +- {error}");
            }
        }
    }
}
