//! Estimators that are asked more or less often than once per sample: the same picture, and honest about its noise.

mod common;

use std::collections::BTreeMap;

use common::*;
use glam::DVec3;
use mie_cloud::scene::model::Scene;
use mie_cloud::spectrum::SpectralMode;
use mie_cloud::transport::Rates;

/// Parcels in lit air before a faint background: every estimator has something to do.
fn misty() -> Scene {
    let mut scene = empty_scene();
    scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 4 });
    scene.settings.background.radiance = [1e-3, 2e-3, 3e-3];
    scene.suns = vec![sun(DVec3::new(0.6, 0.0, -0.8))];
    with_air(&mut scene, 0.01, 1e-3, 30.0, 1.0);
    scene.particles = (0..27)
        .map(|i| parcel(DVec3::new(f64::from(i % 3) - 1.0, f64::from(i / 3 % 3) - 1.0, f64::from(i / 9)), 0.6, 1e9))
        .collect();
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 2.0);
    scene.settings.image.resolution = [16, 16];
    scene
}

const UNEVEN: Rates = Rates { paths: 2, air_paths: -2, airlight: -3, glow: -4 };

/// Rationale: rates change no mean, of no layer. Set-up: the same scene with even and with uneven rates, samples that cut blocks. Expected: every
/// layer's mean over the picture within four standard errors, which are known from eight seeds each.
#[test]
fn rates_keep_the_mean_of_every_layer() {
    let layers = ["direct.G", "multiple.G", "airlight.G", "glow.G", "air_multiple.G", "background.B", "depth.Z"];
    let of = |rates: Rates| -> Vec<(f64, f64)> {
        let mut prepared = prepare_all(misty());
        prepared.rates = rates;
        let pictures: Vec<_> = (0..8).map(|seed| channels(&render_prepared(&prepared, 50, seed))).collect();
        let mean_and_error = |name: &&str| {
            let means: Vec<f64> = pictures.iter().map(|picture| mean(&picture[*name])).collect();
            let middle = means.iter().sum::<f64>() / 8.0;
            (middle, (means.iter().map(|m| (m - middle).powi(2)).sum::<f64>() / 7.0 / 8.0).sqrt())
        };
        layers.iter().map(mean_and_error).collect()
    };
    for ((name, even), uneven) in layers.iter().zip(of(Rates::EVEN)).zip(of(UNEVEN)) {
        let error = even.1.hypot(uneven.1);
        eprintln!("{name}: {even:?} {uneven:?}");
        // Eight seeds know their scatter to a quarter.
        assert!((even.0 - uneven.0).abs() <= 5.0 * error + 1e-12, "{name}: {even:?} {uneven:?}");
        assert!(even.0 > 0.0 && error < 0.05 * even.0, "{name} can be told apart: {error}");
    }
}

/// Expected: the noise that a picture of uneven rates states is what its pictures scatter by, to 10 %.
#[test]
fn noise_is_honest_at_uneven_rates() {
    let mut prepared = prepare_all(misty());
    prepared.rates = UNEVEN;
    let n = 24;
    let outcomes: Vec<_> = (0..n).map(|seed| render_prepared(&prepared, 64, 100 + seed)).collect();
    let stated = (outcomes.iter().map(|o| o.film.noise().powi(2)).sum::<f64>() / n as f64).sqrt();
    let pictures: Vec<_> = outcomes.iter().map(channels).collect();
    let (mut variance, mut luminance) = (0.0, 0.0);
    for (name, weight) in [("R", 0.2126), ("G", 0.7152), ("B", 0.0722)] {
        for pixel in 0..256 {
            let values: Vec<f64> = pictures.iter().map(|picture| f64::from(picture[name][pixel])).collect();
            let middle = values.iter().sum::<f64>() / n as f64;
            variance += values.iter().map(|v| (v - middle).powi(2)).sum::<f64>() / (n - 1) as f64 / 768.0;
            luminance += weight * middle / 256.0;
        }
    }
    let found = variance.sqrt() / luminance;
    assert!((stated / found - 1.0).abs() < 0.1, "stated {stated}, found {found}");
}

/// Rationale: rates are part of the picture, so they may depend on nothing but the scene. Expected: the same with any number of
/// threads; even without air; uneven where glow is dear.
#[test]
fn rates_depend_on_the_scene_only() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| prepare_as_rendered(misty(), &BTreeMap::new()).rates)
    };
    let rates = on(1);
    assert_eq!(rates, on(3));
    assert_ne!(rates, Rates::EVEN, "glow is the dearest and among the steadiest here");
    let mut without_air = misty();
    with_air(&mut without_air, 0.0, 0.0, 30.0, 1.0);
    assert_eq!(prepare_as_rendered(without_air, &BTreeMap::new()).rates, Rates::EVEN);
}
