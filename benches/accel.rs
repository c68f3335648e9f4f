//! Rays per second through clouds of spheres: `cargo bench --bench accel [-- COUNTS...]`.
//!
//! Random rays in a unit cube whose spheres cover half of it. One thread; each figure is the median of five runs.

use std::hint::black_box;
use std::time::Instant;

use glam::DVec3;
use mie_cloud::accel::{Accel, BodyKind, Crossing, Placed};
use rand::{RngExt, SeedableRng};

fn cloud(n: usize) -> Vec<Placed> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let radius_m = (0.5 / (n as f64 * std::f64::consts::PI)).sqrt() as f32;
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    (0..n).map(|_| Placed { center_m: at(), radius_m, load: 1.0, bin: 0, kind: BodyKind::Ball }).collect()
}

fn rays(n: usize) -> Vec<(DVec3, DVec3)> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(2);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    (0..n).map(|_| (at() * 3.0 - 1.0, at())).map(|(from, to)| (from, (to - from).normalize())).collect()
}

/// Million rays per second, the median of five runs.
fn rate(rays: &[(DVec3, DVec3)], mut trace: impl FnMut(DVec3, DVec3)) -> f64 {
    let mut rates: Vec<f64> = (0..5)
        .map(|_| {
            let start = Instant::now();
            rays.iter().for_each(|(origin, direction)| trace(*origin, *direction));
            rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    rates[2]
}

fn main() {
    let counts: Vec<usize> = std::env::args().filter_map(|arg| arg.parse::<f64>().ok()).map(|n| n as usize).collect();
    let counts = if counts.is_empty() { vec![1_000, 10_000, 100_000, 1_000_000] } else { counts };
    println!(
        "{:>10} {:>10} {:>14} {:>14} {:>10} {:>10}",
        "spheres", "build s", "closest Mray/s", "all Mray/s", "SIMD gain", "bytes each"
    );
    for n in counts {
        let particles = cloud(n);
        let start = Instant::now();
        let accel = Accel::build(particles, &[]);
        let build_s = start.elapsed().as_secs_f64();
        let rays = rays(if n > 100_000 { 50_000 } else { 200_000 });
        let closest = rate(&rays, |origin, direction| {
            let ray = accel.local_ray(origin, direction);
            black_box(accel.closest(&ray, 0.0, None, |_, crossing| Some(crossing.start().max(0.0))));
        });
        let all = rate(&rays, |origin, direction| {
            let ray = accel.local_ray(origin, direction);
            let mut sum = 0.0;
            accel.all(&ray, 0.0, f64::INFINITY, |_, crossing: Crossing| sum += crossing.start());
            black_box(sum);
        });
        let bytes = (accel.geometry_bytes() + accel.tree_bytes()) as f64 / n as f64;
        let plain = accel.without_simd();
        let plain_all = rate(&rays, |origin, direction| {
            let ray = plain.local_ray(origin, direction);
            let mut sum = 0.0;
            plain.all(&ray, 0.0, f64::INFINITY, |_, crossing: Crossing| sum += crossing.start());
            black_box(sum);
        });
        let gain = all / plain_all;
        println!("{n:>10} {build_s:>10.3} {closest:>14.3} {all:>14.3} {gain:>10.2} {bytes:>10.1}");
    }
}
