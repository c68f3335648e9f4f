//! Phase functions without their forward peak: an approximation that is off unless asked for, with a bias that is known.

mod common;

use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use mie_cloud::optics::hg_draine::HgDraine;
use mie_cloud::optics::peak::without_peak;
use mie_cloud::optics::phase_function::PhaseFunction;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::optics::phase_table::PhaseTable;
use mie_cloud::scene::model::Scene;

/// h = 1 - cos of an angle in degrees.
fn h(angle_deg: f64) -> f64 {
    2.0 * (0.5 * angle_deg.to_radians()).sin().powi(2)
}

fn peaked() -> Vec<PhaseFunction> {
    let theta: Vec<f64> = [0.0, 0.5, 2.0, 10.0, 40.0, 90.0, 140.0, 180.0].map(f64::to_radians).to_vec();
    let table = PhaseTable::from_samples(&theta, &[2e3, 600.0, 20.0, 5.0, 0.5, 0.1, 0.3, 0.2]).expect("a table");
    vec![
        PhaseFunction::henyey_greenstein(0.85),
        PhaseFunction::henyey_greenstein(0.999),
        PhaseFunction::HgDraine(HgDraine::new(20.0).expect("in the fitted range")),
        PhaseFunction::Tabulated(table),
    ]
}

/// Rationale: theory (95). Expected: the same product of what is left and the new function outside of the cone, one value
/// inside, an integral of 1, and the share that the old integral says.
#[test]
fn only_the_cone_is_changed() {
    for phase in peaked() {
        for angle_deg in [1.0f64, 5.0, 30.0] {
            let cut = without_peak(&phase, angle_deg.to_radians()).expect("there is a peak");
            let (edge, left) = (phase.eval(h(angle_deg)), 1.0 - cut.removed);
            for theta in [0.0, 0.3, 0.999, 1.001, 4.9, 5.1, 29.0, 31.0, 60.0, 120.0, 180.0] {
                let expected = if theta < angle_deg { edge } else { phase.eval(h(theta)) };
                let found = left * cut.phase.eval(h(theta));
                // Closed forms are tabulated to 1e-4.
                assert!((found / expected - 1.0).abs() < 3e-4, "{angle_deg}, {theta}: {found} {expected}");
            }
            let expected = phase.cdf(h(angle_deg)) - 2.0 * PI * h(angle_deg) * edge;
            assert!((cut.removed - expected).abs() < 2e-4, "{angle_deg}: {} {expected}", cut.removed);
            assert!((cut.phase.cdf(2.0) - 1.0).abs() < 1e-9);
            // What is taken away went straight on, nearly: the asymmetry says how much.
            let g = cut.removed + left * cut.phase.mean_cosine();
            assert!((g - phase.mean_cosine()).abs() < 2e-4 + 0.5 * cut.removed * h(angle_deg), "{g}");
        }
    }
}

#[test]
fn what_has_no_peak_stays_as_it_is() {
    for phase in [PhaseFunction::Isotropic, PhaseFunction::Rayleigh, PhaseFunction::henyey_greenstein(-0.5)] {
        assert_eq!(without_peak(&phase, 0.2), None, "{phase:?}");
    }
}

/// A wide slab of depth 4 and g = 0.85, seen from above against a sun 40 degrees from the zenith.
fn slab(peak_truncation_deg: f64) -> Scene {
    let mut scene = empty_scene();
    with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(0.85) });
    scene.classes[0].albedo = Some(0.98);
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 0.5), 4.0)];
    let zenith = 40f64.to_radians();
    scene.suns = vec![sun(DVec3::new(zenith.sin(), 0.0, -zenith.cos()))];
    scene.camera = camera_for(DVec3::new(0.2, 0.4, 0.9).normalize(), 0.01);
    scene.settings.accuracy.peak_truncation_deg = peak_truncation_deg;
    scene
}

fn look(scene: Scene, spp: u32, seed: u64) -> (f64, f64) {
    mean_and_error(&render_scene(scene, spp, seed))
}

/// Rationale: light that is scattered by little is as good as light that was not. Set-up: a slab of optical depth 4 and
/// g = 0.85 by reflected light. Expected: cutting at 5 degrees leaves the radiance within 1 % and the noise; cutting at 30
/// takes a tenth away: the bias is real, and this test can see it.
#[test]
fn small_cones_change_little_and_large_ones_much() {
    let (whole, whole_error) = look(slab(0.0), 4000, 1);
    let (small, small_error) = look(slab(5.0), 2000, 2);
    let error = whole_error.hypot(small_error);
    println!("{whole} +- {whole_error}, 5 degrees {small} +- {small_error}");
    assert!((small - whole).abs() < 4.0 * error + 0.01 * whole, "{small} against {whole} +- {error}");
    let (large, large_error) = look(slab(30.0), 2000, 3);
    println!("30 degrees {large} +- {large_error}");
    assert!(large_error < 0.01 * whole, "{large_error}");
    assert!((-0.16..-0.04).contains(&(large / whole - 1.0)), "{large} against {whole}");
}

/// Light scattered once is not changed outside of the cone, but for how much of it gets through: in thin fog nothing.
#[test]
fn light_scattered_once_is_kept_outside_of_the_cone() {
    let thin = |angle_deg: f64, seed: u64| {
        let mut scene = slab(angle_deg);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(1e3, 1e3, 0.5), 1e-3)];
        mean_and_error(&render_once(scene, 200, seed))
    };
    let ((whole, whole_error), (cut, cut_error)) = (thin(0.0, 1), thin(20.0, 2));
    // Ways through the slab are at most 2.4 thicknesses: 2.4e-3 of the light; tables of closed forms are good to 1e-4.
    assert!((cut / whole - 1.0).abs() < 2.5e-3 + 4.0 * whole_error.hypot(cut_error) / whole, "{cut} against {whole}");
}

/// White clouds still vanish in a furnace, with exact phase functions in bands too, and absorption is what it was.
#[test]
fn cut_phase_functions_conserve_energy() {
    let furnace = |albedo: f64, angle_deg: f64, seed: u64| {
        let mut scene = empty_scene();
        without_refraction(&mut scene);
        scene.settings.spectral_mode = Some(mie_cloud::spectrum::SpectralMode::Bands { count: 4 });
        scene.classes[0].albedo = Some(albedo);
        scene.particles = vec![parcel(DVec3::ZERO, 1.0, 3e10), droplet(DVec3::X * 0.4, 0.3, 5e-6)];
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.8);
        scene.settings.background.radiance = [1.0; 3];
        scene.settings.accuracy.peak_truncation_deg = angle_deg;
        scene.suns[0].lux = 0.0;
        look(scene, 600, seed)
    };
    let (white, error) = furnace(1.0, 10.0, 1);
    assert!((white - 1.0).abs() < 4.0 * error + 1e-6 && error < 0.005, "{white} +- {error}");
    let ((whole, whole_error), (cut, cut_error)) = (furnace(0.7, 0.0, 2), furnace(0.7, 3.0, 3));
    // Light that is scattered by up to 3 degrees comes by nearly the same way: 0.5 % at most in this ball.
    let error = whole_error.hypot(cut_error);
    assert!((cut - whole).abs() < 4.0 * error + 5e-3 * whole, "{cut} against {whole} +- {error}");
}
