//! The same scene, settings and seed give the same bytes: for any number of threads, run after run, with any state of the
//! cache, and whatever vector instructions the processor has.

mod common;
mod program;

use common::*;
use glam::DVec3;
use mie_cloud::scene::model::Scene;
use mie_cloud::spectrum::SpectralMode;
use mie_cloud::transport::{Prepared, Until};
use program::Bench;

/// Droplets enough for a tree, fog, glass, glowing air, two suns: every way through the program.
fn everything() -> Scene {
    let mut scene = empty_scene();
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 3 });
    scene.settings.image.resolution = [12, 9];
    scene.settings.background.radiance = [0.1, 0.2, 0.3];
    with_air(&mut scene, 0.05, 0.01, 12.0, 1.0);
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
    for i in 0..300 {
        let own_radius_m = [1e-6, 2e-6, 5e-6][i % 3];
        scene.particles.push(droplet(at(), [0.01, 0.02, 0.1][i % 3], own_radius_m));
    }
    for _ in 0..60 {
        scene.particles.push(parcel(at(), 0.2, 1e7));
    }
    scene.fog_boxes = vec![fog_box(at(), DVec3::splat(0.5), 0.2)];
    scene.suns = vec![sun(DVec3::new(1.0, -1.0, -1.0)), sun(DVec3::new(-0.3, -1.0, 0.4))];
    scene.suns[1].angular_diameter_deg = Some(0.5);
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 5.0), 1.0);
    scene
}

/// Rationale: Mie sums are rounded alike everywhere (unit tests of `mie`), the tree decides only what is looked at, and what
/// glows is summed in one order. Expected: every sum of every pixel, to the last bit.
#[test]
fn pictures_do_not_depend_on_vector_instructions() {
    let fast = prepare_all(everything());
    let there = (fast.glow.is_some(), fast.glass.is_some(), fast.accel.tree_bytes() > 0);
    assert_eq!(there, (true, true, true), "all of it is there");
    let plain = prepare_all(everything()).without_simd();
    let silent = &mie_cloud::transport::SilentProgress;
    for until in [Until::Samples(4), Until::Noise { target: 0.1, at_most: 24 }] {
        let [fast, plain] = [&fast, &plain].map(|prepared: &Prepared| render_until(prepared, until, 3, silent));
        assert!(fast.film == plain.film, "{until:?}");
        assert_eq!(fast.rays, plain.rays);
    }
}

#[test]
fn sums_do_not_depend_on_threads_however_long_it_takes() {
    let prepared = prepare_all(everything());
    let film = |threads: usize, until: Until| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| render_until(&prepared, until, 1, &mie_cloud::transport::SilentProgress).film)
    };
    for until in [Until::Range { first: 2, end: 6 }, Until::Noise { target: 0.1, at_most: 24 }] {
        let one = film(1, until);
        assert!(one == film(2, until) && one == film(7, until), "{until:?}");
    }
}

/// Expected: the same files from one, two and seven threads, twice, with a cold, a warm and no cache: of the picture, its layers, its
/// spectra and its preview, of a part, and of a checkpoint at its end. Tree, tables and glow are made anew each time.
#[test]
fn files_do_not_depend_on_threads_runs_or_cache() {
    let bench = Bench::new();
    bench.ok("generate -o cloud.glb --count 300 --kind droplets --size 1m --optical-depth 0.3 -q --set image.resolution=12x9 \
              --set spectral.mode=bands:3 --set atmosphere.scattering_per_m=0.1 --set droplets.size_bins=4");
    let kinds = [
        "--noise 0.2 --aov all --spectral --preview a.png --checkpoint c",
        "--samples 8..16 --aov all --effects +glow,+refraction",
    ];
    for kind in kinds {
        let files = |flags: &str| {
            for name in ["a.exr", "a.png", "c"] {
                let _ = std::fs::remove_file(bench.path(name));
            }
            bench.ok(&format!("render cloud.glb -o a.exr -q {kind} {flags}"));
            bench.files()
        };
        let _ = std::fs::remove_dir_all(bench.path("cache"));
        let cold = files("--threads 1");
        assert!(cold.len() >= 2);
        for flags in ["--threads 1", "--threads 2", "--threads 7", "--no-cache --threads 7"] {
            let warm = files(flags);
            let differ: Vec<&String> = cold.keys().filter(|name| warm.get(*name) != cold.get(*name)).collect();
            assert!(differ.is_empty() && warm.len() == cold.len(), "{kind} {flags}: {differ:?}");
        }
        let _ = std::fs::remove_dir_all(bench.path("cache"));
        assert!(files("--threads 7") == cold, "cold with seven threads");
    }
}
