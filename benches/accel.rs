//! Rays per second through clouds of spheres and boxes: `cargo bench --bench accel [-- COUNTS...]`.
//!
//! Random rays in a unit cube whose spheres cover half of it, in millions per second of one core's CPU time, the median of
//! five runs; beside them the published rates of Embree 4.4 with its sphere points in the same cube. Then the cost of one query where
//! few fog boxes are all there is.

use std::hint::black_box;
use std::time::Instant;

use glam::{DMat3, DVec3};
use mie_cloud::accel::{Accel, BodyKind, Crossing, Placed, PlacedBox};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use rand::{RngExt, SeedableRng};

/// Closest hits on sphere points as published for Embree 4.4: spheres and Mray/s of one core.
const EMBREE: [(usize, f64); 4] = [(1_000, 6.5), (100_000, 1.9), (1_000_000, 0.18), (10_000_000, 0.06)];

fn cloud(n: usize) -> Vec<Placed> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let radius_m = (0.5 / (n as f64 * std::f64::consts::PI)).sqrt() as f32;
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    (0..n).map(|_| Placed { center_m: at(), radius_m, load: 1.0, bin: 0, kind: BodyKind::Ball }).collect()
}

fn fog_boxes(n: usize) -> Vec<PlacedBox> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    let half_edges_m = DMat3::from_rotation_z(0.3) * 0.2;
    (0..n).map(|_| PlacedBox { center_m: at(), half_edges_m, number_per_m3: 1.0, bin: 0 }).collect()
}

fn rays(n: usize) -> Vec<(DVec3, DVec3)> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(2);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    (0..n).map(|_| (at() * 3.0 - 1.0, at())).map(|(from, to)| (from, (to - from).normalize())).collect()
}

/// CPU seconds of this process in user mode.
fn cpu_s() -> f64 {
    getrusage(UsageWho::RUSAGE_SELF).map_or(f64::NAN, |usage| usage.user_time().num_microseconds() as f64 * 1e-6)
}

/// Million rays per CPU second, the median of five runs.
fn rate(rays: &[(DVec3, DVec3)], mut trace: impl FnMut(DVec3, DVec3)) -> f64 {
    let mut rates: Vec<f64> = (0..5)
        .map(|_| {
            let start = cpu_s();
            rays.iter().for_each(|(origin, direction)| trace(*origin, *direction));
            rays.len() as f64 / (cpu_s() - start) * 1e-6
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    rates[2]
}

fn closest_rate(accel: &Accel, rays: &[(DVec3, DVec3)]) -> f64 {
    rate(rays, |origin, direction| {
        let ray = accel.local_ray(origin, direction);
        black_box(accel.closest(&ray, 0.0, None, |_, crossing| Some(crossing.start().max(0.0))));
    })
}

fn all_rate(accel: &Accel, rays: &[(DVec3, DVec3)]) -> f64 {
    rate(rays, |origin, direction| {
        let ray = accel.local_ray(origin, direction);
        let mut sum = 0.0;
        accel.all(&ray, 0.0, f64::INFINITY, |_, crossing: Crossing| sum += crossing.start());
        black_box(sum);
    })
}

fn main() {
    let counts: Vec<usize> = std::env::args().filter_map(|arg| arg.parse::<f64>().ok()).map(|n| n as usize).collect();
    let counts = if counts.is_empty() { (3..8).map(|power| 10usize.pow(power)).collect() } else { counts };
    println!("Mray per CPU second:");
    println!("| spheres | build, s | closest | all | Embree, closest | without SIMD, all | bytes each |");
    println!("|---|---|---|---|---|---|---|");
    for n in counts {
        let start = Instant::now();
        let accel = Accel::build(cloud(n), &[]);
        let build_s = start.elapsed().as_secs_f64();
        let rays = rays(if n > 100_000 { 50_000 } else { 200_000 });
        let (closest, all) = (closest_rate(&accel, &rays), all_rate(&accel, &rays));
        let bytes = (accel.geometry_bytes() + accel.tree_bytes()) as f64 / n as f64;
        let plain = all_rate(&accel.without_simd(), &rays);
        let embree = EMBREE.iter().find(|(count, _)| *count == n).map_or("-".into(), |(_, rate)| rate.to_string());
        println!("| {n} | {build_s:.3} | {closest:.3} | {all:.3} | {embree} | {plain:.3} | {bytes:.1} |");
    }
    println!("\nns per query of all that a ray meets:\n| fog boxes | all |\n|---|---|");
    let rays = rays(1_000_000);
    for n in [1, 10, 100] {
        println!("| {n} | {:.1} |", 1e3 / all_rate(&Accel::build(Vec::new(), &fog_boxes(n)), &rays));
    }
}
