//! Samples of a picture: standard errors that can be believed, samples where the noise is, pictures that are stopped.

mod common;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use common::*;
use glam::DVec3;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::Scene;
use mie_cloud::spectrum::SpectralMode;
use mie_cloud::transport::{Prepared, Progress, RenderOutcome, SilentProgress, Until};

/// A cube of fog of depth 1 from the side, which fills the picture.
fn fog_cube() -> Scene {
    let mut scene = empty_scene();
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.5) });
    scene.suns = vec![sun(DVec3::new(1.0, -0.3, 0.0))];
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::splat(0.5), 1.0)];
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.5);
    scene.settings.image.resolution = [24, 24];
    scene
}

/// A box of fog and overlapping parcels, in colour, with edges and empty pixels.
fn box_and_parcels() -> Scene {
    let mut scene = fog_cube();
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 4 });
    scene.fog_boxes = vec![fog_box(DVec3::new(-0.3, 0.0, 0.0), DVec3::splat(0.3), 1.0)];
    let at = |i: i32| DVec3::new(0.1 * f64::from(i), 0.1 * f64::from(i % 4) - 0.2, 0.05 * f64::from(i % 3));
    scene.particles = (0..6).map(|i| parcel(at(i), 0.15, 1e8)).collect();
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.9);
    scene
}

/// A small bright cloud in a corner of a dark picture.
fn small_cloud() -> Scene {
    let mut scene = fog_cube();
    scene.camera = orthographic(DVec3::new(1.0, -1.5, 10.0), 2.0);
    scene.settings.image.resolution = [48, 48];
    scene
}

/// Small discs that few rays meet, and bright where the light comes straight through: pixels with heavy tails.
fn rare_droplets() -> Scene {
    let mut scene = empty_scene();
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.8) });
    scene.suns = vec![sun(DVec3::new(0.1, 0.0, 1.0))];
    let at = |i: i32| DVec3::new(f64::from(i % 5) - 2.0, f64::from(i / 5) - 2.0, 0.1 * f64::from(i % 3)) * 0.37;
    scene.particles = (0..25).map(|i| droplet(at(i), if i == 7 { 0.06 } else { 0.008 }, 5e-6)).collect();
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1.0);
    scene.settings.image.resolution = [16, 16];
    scene
}

fn ready(scene: Scene) -> Prepared {
    prepare(scene, &BTreeMap::new())
}

fn until(scene: &Prepared, until: Until, seed: u64) -> RenderOutcome {
    render_until(scene, until, seed, &SilentProgress)
}

fn noise(target: f64) -> Until {
    Until::Noise { target, at_most: 65_536 }
}

/// Rationale: two pictures of different seeds differ by their standard errors. Set-up: fixed numbers of samples, aligned
/// with blocks and not, and such that follow the noise. Expected: z has mean 0 within four errors, and the variance of
/// normal deviates whose errors are estimated from some 10 to 40 blocks: 1.02 to 1.25, within four of its own errors.
#[test]
fn two_seeds_differ_by_their_standard_errors() {
    for (name, scene) in [("cube", fog_cube()), ("box and parcels", box_and_parcels())] {
        let scene = ready(scene);
        for rule in [Until::Samples(64), Until::Samples(250), noise(0.02)] {
            let [a, b] = [11, 12].map(|seed| channels(&until(&scene, rule, seed)));
            let z: Vec<f64> = (0..a["G"].len())
                .map(|i| [&a, &b].map(|p| (f64::from(p["G"][i]), f64::from(p["stderr.G"][i]))))
                .filter(|[(_, a), (_, b)]| *a > 0.0 && *b > 0.0)
                .map(|[(a, a_error), (b, b_error)]| (a - b) / a_error.hypot(b_error))
                .collect();
            let n = z.len() as f64;
            let mean = z.iter().sum::<f64>() / n;
            let variance = z.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
            assert!(n > 100.0, "{name} {rule:?}: {n}");
            assert!(mean.abs() < 4.0 * (variance / n).sqrt(), "{name} {rule:?}: mean {mean}");
            // The variance of squares of such deviates is up to 3.
            let error = (3.0 / n).sqrt();
            let range = 1.02 - 4.0 * error..1.25 + 4.0 * error;
            assert!(range.contains(&variance), "{name} {rule:?}: variance {variance} of {n}");
        }
    }
}

/// Rationale: a pixel whose bright sample earned it more samples would be too dark. Set-up: droplets that one ray in
/// hundreds meets, so coarse pictures that chance decides where samples go, many seeds. Expected: the mean of all is that
/// of a long render with the same number of samples everywhere, within four errors.
#[test]
fn samples_that_follow_the_noise_leave_no_bias() {
    let (reference, reference_error) = mean_and_error(&render_scene(rare_droplets(), 16_384, 999));
    let (seeds, scene) = (200, ready(rare_droplets()));
    let outcomes: Vec<RenderOutcome> = (0..seeds).map(|seed| until(&scene, noise(0.3), seed)).collect();
    let means: Vec<f64> = outcomes.iter().map(|outcome| mean_of(outcome, "G")).collect();
    let mean = means.iter().sum::<f64>() / seeds as f64;
    let error = (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>()).sqrt() / seeds as f64;
    assert!((mean - reference).abs() < 4.0 * error.hypot(reference_error), "{mean} +- {error} against {reference}");
    assert!(error < 0.03 * reference, "{error} of {reference}");
    let uneven = outcomes.iter().filter(|outcome| {
        let samples = &channels(outcome)["samples.N"];
        samples.iter().any(|n| *n != samples[0])
    });
    assert!(uneven.count() > seeds as usize / 2, "samples do follow the noise");
}

/// Expected: the noise that was asked for, by less than half of the samples that an even spread takes; no more than the
/// pilot's for pixels far from the cloud.
#[test]
fn samples_go_where_the_noise_is() {
    let target = 0.03;
    let scene = ready(small_cloud());
    let outcome = until(&scene, noise(target), 5);
    assert!(outcome.film.noise() <= target, "{}", outcome.film.noise());
    assert!(outcome.film.noise() > 0.8 * target, "not far more than asked for: {}", outcome.film.noise());
    let even = until(&scene, Until::Samples(256), 5);
    let even_samples = even.film.samples() as f64 * (even.film.noise() / target).powi(2);
    assert!((outcome.film.samples() as f64) < 0.5 * even_samples, "{} {even_samples}", outcome.film.samples());
    let samples = &channels(&outcome)["samples.N"];
    assert!(samples[47 * 48 + 47] < 0.2 * samples.iter().fold(0.0, |a, b| f32::max(a, *b)));
}

#[test]
fn threads_do_not_matter_where_samples_follow_the_noise() {
    let scene = ready(box_and_parcels());
    let picture = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| channels(&until(&scene, noise(0.05), 9)))
    };
    let one = picture(1);
    assert_eq!(one, picture(2));
    assert_eq!(one, picture(7));
}

#[test]
fn a_fixed_number_of_samples_is_the_same_everywhere() {
    let scene = ready(small_cloud());
    for spp in [1, 2, 7, 100] {
        let samples = &channels(&until(&scene, Until::Samples(spp), 1))["samples.N"];
        assert!(samples.iter().all(|n| *n == spp as f32), "{spp}");
    }
}

/// Stops as soon as so many samples have been taken.
struct StopAfter(u64, AtomicU64);

impl Progress for StopAfter {
    fn samples(&self, taken: u64, _expected: u64) {
        self.1.fetch_max(taken, Ordering::Relaxed);
    }

    fn should_stop(&self) -> bool {
        self.1.load(Ordering::Relaxed) >= self.0
    }
}

/// Expected: wherever a render is stopped, every pixel has a sample, and the picture is that of the scene.
#[test]
fn a_stopped_picture_is_a_picture() {
    let (reference, reference_error) = mean_and_error(&render_scene(fog_cube(), 512, 77));
    let scene = ready(fog_cube());
    for after in [1, 3000, 40_000, 60_001] {
        for rule in [Until::Samples(4096), Until::Noise { target: 0.0, at_most: 4096 }] {
            let progress = StopAfter(after, AtomicU64::new(0));
            let outcome = render_until(&scene, rule, 8, &progress);
            assert!(outcome.stopped);
            let picture = channels(&outcome);
            assert!(picture["samples.N"].iter().all(|n| *n >= 1.0));
            let taken = outcome.film.samples();
            // Tiles that were begun are finished, each of 16 pixels of at most 64 samples here.
            let begun = 1024 * rayon::current_num_threads() as u64;
            assert!(taken >= after && taken <= after + begun, "{taken} after {after}");
            let mean = mean(&picture["G"]);
            // One sample of this scene scatters by less than its mean.
            let error = reference / (taken as f64 / 2.0).sqrt();
            assert!((mean - reference).abs() < 4.0 * error.hypot(reference_error), "{mean} {reference} after {after}");
        }
    }
}
