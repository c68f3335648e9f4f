//! One cloud described in several ways: the pictures agree pixel by pixel within their noise.

mod common;

use std::f64::consts::PI;

use common::*;
use glam::{DMat3, DVec3};
use mie_cloud::mie;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{FogBox, Particle, Scene};
use rand::{RngExt, SeedableRng};

/// Number of 5 um droplets in a ball of 1 m: optical depth 1.6 through its centre at 550 nm.
const BALL: f64 = 2e10;

fn q_ext() -> f64 {
    mie::efficiencies(2.0 * PI * 5e-6 / 550e-9, Material::Water.index(550e-9).unwrap()).unwrap().q_ext
}

/// A picture of 16 by 16 pixels from the side of the sun.
fn scene_of(particles: Vec<Particle>, fog_boxes: Vec<FogBox>) -> Scene {
    let mut scene = empty_scene();
    without_refraction(&mut scene);
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.6) });
    scene.classes[0].albedo = Some(0.95);
    (scene.particles, scene.fog_boxes) = (particles, fog_boxes);
    scene.suns = vec![sun(DVec3::new(0.7, -0.4, -0.3))];
    scene.camera = camera_for(DVec3::new(0.2, 0.3, 0.9).normalize(), 1.3);
    scene.settings.image.resolution = [16, 16];
    scene.settings.background.radiance = [0.02; 3];
    scene
}

/// Compares two pictures of the same cloud: root mean square and mean of the pixels' deviations over their errors.
fn check_same(name: &str, one: Scene, other: Scene, spp: u32) {
    let (one, other) = (channels(&render_scene(one, spp, 1)), channels(&render_scene(other, spp, 2)));
    let z: Vec<f64> = (0..one["G"].len())
        .map(|i| {
            let value = |channel: &str| [f64::from(one[channel][i]), f64::from(other[channel][i])];
            let ([a, b], [a_error, b_error]) = (value("G"), value("stderr.G"));
            // Pixels beside the cloud hold nothing but the background, without noise.
            (a - b) / a_error.hypot(b_error).max(1e-7)
        })
        .collect();
    let seen: Vec<f64> = z.into_iter().filter(|z| *z != 0.0).collect();
    let n = seen.len() as f64;
    let (mean_z, square) = (seen.iter().sum::<f64>() / n, seen.iter().map(|z| z * z).sum::<f64>() / n);
    println!("{name}: {n} pixels, mean z {mean_z:+.3}, mean z^2 {square:.3}");
    assert!(n > 100.0, "{name}: {n} pixels see the cloud");
    // The mean of n standard normals has deviation n^(-1/2), that of their squares (2/n)^(1/2).
    assert!(mean_z.abs() < 4.0 / n.sqrt(), "{name}: mean z {mean_z}");
    assert!((square - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{name}: mean z^2 {square}");
    let (one, other) = (mean(&one["transmittance.G"]), mean(&other["transmittance.G"]));
    assert!((one - other).abs() < 2e-3 * one, "{name}: transmittances {one} and {other}");
}

/// A box with half edges 1, 0.8 and 0.6 of optical depth 3 along x.
fn whole_box(density: f64) -> FogBox {
    fog_box(DVec3::ZERO, DVec3::new(1.0, 0.8, 0.6), 1.5 * density)
}

#[test]
fn a_box_is_the_sum_of_overlapping_boxes_and_of_its_octants() {
    let one = || scene_of(Vec::new(), vec![whole_box(1.0)]);
    let two = scene_of(Vec::new(), vec![whole_box(0.7), whole_box(0.3)]);
    check_same("two boxes of partial density", one(), two, 600);
    let octant = |i: i32| {
        let half = DVec3::new(0.5, 0.4, 0.3);
        let sign = DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - 1.0;
        fog_box(sign * half, half, 1.5)
    };
    check_same("eight octants", one(), scene_of(Vec::new(), (0..8).map(octant).collect()), 600);
    // The same box by another orientation and order of its axes.
    let mut turned = whole_box(1.0);
    turned.half_edges_m = DMat3::from_cols(DVec3::Y * 0.8, DVec3::Z * -0.6, DVec3::X);
    // Two boxes that overlap in part, and the two pieces and the overlap apart.
    check_same("turned axes", one(), scene_of(Vec::new(), vec![turned]), 600);
    let x_box = |from: f64, to: f64, density: f64| {
        fog_box(DVec3::X * 0.5 * (from + to), DVec3::new(0.5 * (to - from), 0.8, 0.6), density)
    };
    let overlapping = scene_of(Vec::new(), vec![x_box(-1.0, 0.4, 1.0), x_box(-0.3, 1.0, 2.0)]);
    let apart = vec![x_box(-1.0, -0.3, 1.0), x_box(-0.3, 0.4, 3.0), x_box(0.4, 1.0, 2.0)];
    check_same("overlap in part", overlapping, scene_of(Vec::new(), apart), 600);
}

#[test]
fn a_parcel_is_the_sum_of_its_parts() {
    let one = || scene_of(vec![parcel(DVec3::ZERO, 1.0, BALL)], Vec::new());
    let coincident = (0..50).map(|_| parcel(DVec3::ZERO, 1.0, BALL / 50.0)).collect();
    check_same("50 coincident parcels", one(), scene_of(coincident, Vec::new()), 600);
    // So near each other that nothing shows, but not one body: more of them than short searches are made for.
    let near = |i: i32| parcel(DVec3::new(f64::from(i), -f64::from(i), 0.0) * 1e-6, 1.0, BALL / 200.0);
    check_same("200 parcels a micrometre apart", one(), scene_of((0..200).map(near).collect(), Vec::new()), 150);
    let outer = |share: f64| parcel(DVec3::ZERO, 1.0, share * BALL);
    let inner = |share: f64| parcel(DVec3::new(0.2, 0.1, 0.0), 0.6, share * BALL);
    let nested = scene_of(vec![outer(1.0), inner(1.0)], Vec::new());
    let split = scene_of(vec![inner(0.1), outer(0.6), inner(0.5), outer(0.4), inner(0.4)], Vec::new());
    check_same("nested parcels in parts", nested, split, 600);
}

/// A box of half edges 1, 0.8 and 0.6 with one droplet at random in each cell of a lattice, optical depth 0.2 along x.
fn jittered_lattice(seed: u64) -> Vec<Particle> {
    let cells = [50, 40, 30];
    let half = DVec3::new(1.0, 0.8, 0.6);
    let edge = 2.0 * half.x / f64::from(cells[0]);
    let radius = (0.1 * edge.powi(3) / (q_ext() * PI)).sqrt();
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
    let one = |cell: i32| {
        let corner = [cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]].map(f64::from);
        let jitter = DVec3::new(rng.random(), rng.random(), rng.random());
        droplet((DVec3::from_array(corner) + jitter) * edge - half, radius, 5e-6)
    };
    (0..cells.iter().product()).map(one).collect()
}

/// Rationale: at low depth a lattice removes light as evenly as fog. Set-up: eight lattices of 60,000 magnified droplets
/// against a box of fog. Expected: the mean over lattices within five of its standard errors (Student's t of 7 degrees of
/// freedom exceeds 5 once in 600 times), which are at most 0.7 %.
#[test]
fn droplets_in_a_jittered_lattice_look_like_thin_fog() {
    let look = |particles: Vec<Particle>, fog_boxes: Vec<FogBox>, spp: u32, seed: u64| {
        let mut scene = scene_of(particles, fog_boxes);
        scene.settings.background.radiance = [0.0; 3];
        scene.camera = camera_for(DVec3::new(0.2, 0.3, 0.9).normalize(), 0.5);
        mean_and_error(&render_scene(scene, spp, seed))
    };
    let (fog, fog_error) = look(Vec::new(), vec![fog_box(DVec3::ZERO, DVec3::new(1.0, 0.8, 0.6), 0.1)], 4000, 99);
    let lattices: Vec<f64> = (0..8).map(|seed| look(jittered_lattice(seed), Vec::new(), 300, seed).0).collect();
    let mean = lattices.iter().sum::<f64>() / 8.0;
    let error = (lattices.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / 7.0 / 8.0).sqrt().hypot(fog_error);
    println!("{mean} and {fog} +- {error}");
    assert!((mean - fog).abs() < 5.0 * error, "{mean} and {fog} +- {error}");
    assert!(error < 0.007 * fog, "{error} of {fog}");
}
