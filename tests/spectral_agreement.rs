//! Few wavelengths together, many together and each alone: the same colours.

mod common;

use common::*;
use glam::DVec3;
use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::scene::model::Scene;
use mie_cloud::spectrum::color::{apply, xyz_from_bt709};
use mie_cloud::spectrum::sun::SunSpectrum;
use mie_cloud::spectrum::{SpectralMode, SpectralSampling};

/// A wide slab of Mie droplets of about 1 um, whose extinction and phase function change with the wavelength; optical
/// depth 2 at 550 nm, sun at 50 degrees from the zenith, seen from above or from below. All pixels see the same.
fn slab(mode: SpectralMode, to_camera: DVec3) -> Scene {
    let mut scene = empty_scene();
    scene.classes[0].distribution =
        SizeDistribution::parse("gamma:reff=1um,veff=0.05", &|_| Err("no file".into())).expect("a distribution");
    let mut fog = fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 0.5), 2.0);
    fog.droplet_radius_m = None;
    scene.fog_boxes = vec![fog];
    let zenith = 50f64.to_radians();
    scene.suns = vec![sun(DVec3::new(zenith.sin(), 0.0, -zenith.cos()))];
    scene.camera = camera_for(to_camera.normalize(), 0.01);
    scene.settings.spectral_mode = Some(mode);
    scene
}

/// The views: what is reflected sideways, and what comes through near the aureole.
const VIEWS: [DVec3; 2] = [DVec3::new(0.1, 0.5, 0.8), DVec3::new(0.3, 0.3, -0.9)];

/// X, Y, Z of a picture all of whose pixels see the same, with the standard errors from their spread.
fn xyz_of(scene: Scene, spp: u32, seed: u64) -> [(f64, f64); 3] {
    let picture = channels(&render_scene(scene, spp, seed));
    let n = picture["R"].len();
    let pixel = |i: usize| apply(&xyz_from_bt709(), ["R", "G", "B"].map(|channel| f64::from(picture[channel][i])));
    let pixels: Vec<[f64; 3]> = (0..n).map(pixel).collect();
    std::array::from_fn(|c| {
        let mean = pixels.iter().map(|xyz| xyz[c]).sum::<f64>() / n as f64;
        let variance = pixels.iter().map(|xyz| (xyz[c] - mean).powi(2)).sum::<f64>() / (n - 1) as f64;
        (mean, (variance / n as f64).sqrt())
    })
}

/// X, Y, Z of both views from one picture for each wavelength of the bands, alone.
fn xyz_one_by_one(count: usize, spp: u32) -> [[(f64, f64); 3]; 2] {
    let sampling = SpectralSampling::new(SpectralMode::Bands { count }, SunSpectrum::E490);
    let mut sums = [[(0.0, 0.0); 3]; 2];
    for (i, (wavelength_m, weights)) in sampling.wavelengths_m.iter().zip(&sampling.rgb_weights).enumerate() {
        let mut prepared = prepare_all(slab(SpectralMode::Mono { wavelength_m: *wavelength_m }, VIEWS[0]));
        for (sums, to_camera) in sums.iter_mut().zip(VIEWS) {
            prepared.camera = camera_for(to_camera.normalize(), 0.01);
            let (mean, error) = mean_and_error(&render_prepared(&prepared, spp, 100 + i as u64));
            for ((sum, variance), weight) in sums.iter_mut().zip(apply(&xyz_from_bt709(), *weights)) {
                *sum += weight * mean;
                *variance += (weight * error).powi(2);
            }
        }
    }
    sums.map(|sums| sums.map(|(sum, variance)| (sum, variance.sqrt())))
}

/// Whether X, Y and Z agree within four standard errors and `allowed` of their value, which are known to `error`.
fn check(name: &str, one: [(f64, f64); 3], other: [(f64, f64); 3], allowed: f64, largest_error: f64) {
    for (c, ((a, a_error), (b, b_error))) in ["X", "Y", "Z"].iter().zip(one.into_iter().zip(other)) {
        let error = a_error.hypot(b_error);
        println!("{name}, {c}: {:+.4} +- {:.4}", a / b - 1.0, error / b);
        assert!((a - b).abs() < 4.0 * error + allowed * b, "{name}, {c}: {a} +- {a_error}, {b} +- {b_error}");
        assert!(error < largest_error * b, "{name}, {c}: {error} of {b}");
    }
}

/// Rationale: wavelengths that travel one path together are weighed so that each is unbiased by itself. Set-up: all orders of
/// scattering by Mie droplets of 1 um. Expected: 64 bands agree with 64 pictures of one wavelength each, combined with
/// the bands' weights, within four standard errors; 8 bands agree with 64 within as many and the error of their
/// quadrature, 1 % for smooth spectra (theory (39)).
#[test]
fn bands_agree_with_single_wavelengths() {
    check_bands(150, 1500, 0.02);
}

#[test]
#[ignore = "takes minutes: cargo test --release --test spectral_agreement -- --ignored --nocapture"]
fn bands_agree_with_single_wavelengths_closely() {
    check_bands(10_000, 100_000, 0.003);
}

fn check_bands(spp_alone: u32, spp_together: u32, largest_error: f64) {
    for (i, (alone, to_camera)) in xyz_one_by_one(64, spp_alone).into_iter().zip(VIEWS).enumerate() {
        let bands = |count, seed| xyz_of(slab(SpectralMode::Bands { count }, to_camera), spp_together, seed);
        let (eight, many) = (bands(8, 1), bands(64, 2));
        check(&format!("view {i}, 64 bands and 64 pictures"), many, alone, 0.0, largest_error);
        check(&format!("view {i}, 8 bands and 64"), eight, many, 0.01, largest_error);
    }
}
