//! Glow of clouds of droplets: time, evaluations and error of the cut against the exact sum.
//!
//! `cargo bench --bench glow -- points [COUNTS...]`: single points within and around a uniform cloud, one size bin and sixty.
//! `cargo bench --bench glow -- pictures [COUNT]`: a picture of 640x360, with what is shared between the steps of a ray.
//! One thread; ratios of times in one run.

#[path = "../tests/common/mod.rs"]
mod common;

use std::collections::BTreeMap;
use std::hint::black_box;

use common::*;
use glam::DVec3;
use mie_cloud::scene::model::Scene;
use mie_cloud::scene::settings::{AirPhase, Effect, Switch};
use mie_cloud::transport::GlowProbe;
use mie_cloud::transport::{RenderRequest, SilentProgress, Spectral, Until, render};
use nix::sys::resource::{UsageWho, getrusage};
use rand::{RngExt, SeedableRng};

/// A unit cube of droplets of 5 um or of sixty sizes, in air, drawn large enough to cover a tenth of it.
fn cloud(n: usize, n_bins: usize) -> Scene {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let mut scene = empty_scene();
    with_air(&mut scene, 0.1, 0.0, 10.0, 0.05);
    scene.settings.atmosphere.phase = AirPhase::HenyeyGreenstein { g: 0.7 };
    let drawn_m = (0.1 / (n as f64 * std::f64::consts::PI)).sqrt();
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random()) - 0.5;
    let size = |i: usize| if n_bins == 1 { 5e-6 } else { 2e-6 * 10f64.powf((i % n_bins) as f64 / (n_bins - 1) as f64) };
    scene.particles = (0..n).map(|i| droplet(at(), drawn_m, size(i))).collect();
    scene.suns = vec![sun(DVec3::new(0.3, -1.0, -0.2))];
    scene
}

fn points(n: usize) -> Vec<(DVec3, DVec3)> {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(2);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random()) - 0.5;
    (0..n).map(|_| (2.0 * at(), at().normalize())).collect()
}

/// Seconds of processor time.
fn seconds<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let used = || {
        let usage = getrusage(UsageWho::RUSAGE_SELF).expect("the system counts time");
        let time = usage.user_time();
        time.tv_sec() as f64 + 1e-6 * time.tv_usec() as f64
    };
    let start = used();
    let result = run();
    (used() - start, result)
}

fn measure_points(n: usize, n_bins: usize, tolerance: f64) {
    let (prepare_s, prepared) = seconds(|| prepare(cloud(n, n_bins), &BTreeMap::new()));
    let ctx = prepared.context();
    let Some(mut probe) = GlowProbe::new(&ctx) else { return };
    let points = points(1000);
    let checked = (20_000_000 / n).clamp(5, 1000);
    let (cut_s, cuts) = seconds(|| -> Vec<(f64, u64)> {
        let one = |(x, v): &(DVec3, DVec3)| probe.by_cut(*x, *v, tolerance);
        points.iter().map(one).map(|(sum, evaluations)| (sum[0], evaluations)).collect()
    });
    let (exact_s, exact) =
        seconds(|| -> Vec<f64> { points[..checked].iter().map(|(x, v)| probe.exact(*x, *v)[0]).collect() });
    let (leaves_s, _) = seconds(|| points[..checked].iter().for_each(|(x, v)| _ = black_box(probe.all_leaves(*x, *v))));
    let mut errors: Vec<f64> = cuts.iter().zip(&exact).map(|((cut, _), exact)| (cut / exact - 1.0).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let evaluations = cuts.iter().map(|(_, n)| *n as f64).sum::<f64>() / cuts.len() as f64;
    let per = |s: f64, n: usize| 1e6 * s / n as f64;
    let (cut_us, exact_us, leaves_us) = (per(cut_s, points.len()), per(exact_s, checked), per(leaves_s, checked));
    println!(
        "{n:>9} {n_bins:>5} {prepare_s:>9.2} {evaluations:>11.0} {cut_us:>9.1} {exact_us:>11.1} {leaves_us:>11.1} {:>8.0} {:>8.0} {:>7.3} {:>7.3}",
        exact_us / cut_us,
        leaves_us / cut_us,
        100.0 * rms,
        100.0 * errors[errors.len() * 99 / 100],
    );
}

/// One sample per pixel of a strip of a picture of 640x360, glow only: time per query with all that a query needs.
fn measure_picture(n: usize) {
    let mut scene = cloud(n, 1);
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 2.0), 1.0);
    scene.settings.image.resolution = [640, 360];
    scene.settings.atmosphere.depth_m = 4.0;
    scene.settings.atmosphere.step_m = 0.02;
    scene.settings.atmosphere.sunlight = false;
    scene.settings.accuracy.glow_tolerance = Some(0.01);
    scene.settings.effects = [Effect::Shadows, Effect::Direct, Effect::Multiple].map(|e| (e, Switch::Off)).into();
    let prepared = prepare(scene, &BTreeMap::new());
    let ctx = prepared.context();
    let crop = [0, 178, 640, 4];
    let request =
        RenderRequest { seed: 1, until: Until::Samples(1), crop, layers: vec![], spectral: Spectral::Discard };
    let (picture_s, outcome) = seconds(|| render(&ctx, &request, &SilentProgress));
    let queries = outcome.rays.glow_queries as f64;
    let Some(mut probe) = GlowProbe::new(&ctx) else { return };
    let points = points(5);
    let (exact_s, _) = seconds(|| points.iter().for_each(|(x, v)| _ = black_box(probe.exact(*x, *v))));
    let (leaves_s, _) = seconds(|| points.iter().for_each(|(x, v)| _ = black_box(probe.all_leaves(*x, *v))));
    let (cut_s, _) = seconds(|| points.iter().for_each(|(x, v)| _ = black_box(probe.by_cut(*x, *v, 0.01))));
    let per = points.len() as f64;
    let per_query_us = 1e6 * picture_s / queries;
    println!(
        "{n} droplets, 4 of 360 rows: {picture_s:.1} s, {queries:.0} queries, {per_query_us:.2} us each; single cuts {:.1} us, \
         x exact {:.0}, x leaves {:.0}; the whole picture about {:.0} s",
        1e6 * cut_s / per,
        exact_s / per * 1e6 / per_query_us,
        leaves_s / per * 1e6 / per_query_us,
        picture_s * 90.0
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let numbers: Vec<usize> = arguments.iter().filter_map(|a| a.parse::<f64>().ok()).map(|n| n as usize).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    pool.install(|| {
        if arguments.iter().any(|argument| argument == "pictures") {
            let counts = if numbers.is_empty() { vec![1_000_000] } else { numbers.clone() };
            counts.iter().for_each(|n| measure_picture(*n));
            return;
        }
        let counts = if numbers.is_empty() { vec![1_000, 10_000, 100_000, 1_000_000] } else { numbers.clone() };
        println!(
            "{:>9} {:>5} {:>9} {:>11} {:>9} {:>11} {:>11} {:>8} {:>8} {:>7} {:>7}",
            "droplets",
            "bins",
            "prepare s",
            "evaluations",
            "cut us",
            "exact us",
            "leaves us",
            "x exact",
            "x leaves",
            "RMS %",
            "p99 %"
        );
        for n_bins in [1, 60] {
            for n in &counts {
                measure_points(*n, n_bins, 0.01);
            }
        }
    });
}
