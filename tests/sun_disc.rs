//! The sun's disc: seen directly, through fog, and as what blurs all that it lights.

mod common;

use std::collections::BTreeMap;
use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use mie_cloud::optics::phase_function::PhaseFunction;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{Lens, Scene};
use mie_cloud::scene::settings::{Effect, Switch};

/// A camera that looks straight at a sun of two degrees, in a view of `fov_deg`.
fn toward_the_sun(fov_deg: f64) -> Scene {
    let mut scene = empty_scene();
    scene.suns = vec![sun(DVec3::Z)];
    scene.suns[0].angular_diameter_deg = Some(2.0);
    scene.camera.lens = Lens::Perspective { yfov_rad: fov_deg.to_radians(), aspect: None };
    scene.settings.image.resolution = [32, 32];
    scene
}

/// The integral of a picture's radiance over its solid angle.
fn flux(picture: &BTreeMap<String, Vec<f32>>, channel: &str, fov_deg: f64) -> f64 {
    let half = (0.5 * fov_deg.to_radians()).tan();
    let side = 2.0 * half / 32.0;
    let at = |i: usize| (i as f64 + 0.5) * side - half;
    let solid_angle = |x: f64, y: f64| side * side / (1.0 + x * x + y * y).powf(1.5);
    let pixels = (0..32).flat_map(|row| (0..32).map(move |column| (column, row)));
    pixels.map(|(x, y)| f64::from(picture[channel][32 * y + x]) * solid_angle(at(x), at(y))).sum()
}

/// Rationale: a disc of radiance E over its solid angle sends E. Expected: 1 in all, E / (2 pi (1 - cos 1 degree)) in it.
#[test]
fn a_disc_sends_the_suns_irradiance() {
    let picture = channels(&render_scene(toward_the_sun(3.0), 256, 1));
    let sent = flux(&picture, "background.G", 3.0);
    assert!((sent - 1.0).abs() < 5e-3, "{sent}");
    let radiance = 1.0 / (2.0 * PI * (1.0 - 1f64.to_radians().cos()));
    let middle = f64::from(picture["background.G"][32 * 16 + 16]);
    assert!((middle / radiance - 1.0).abs() < 1e-6, "{middle} {radiance}");
    assert_eq!(picture["background.G"][0], 0.0);
}

#[test]
fn fog_dims_the_disc_by_its_transmittance_and_scattered_paths_do_not_see_it() {
    let mut scene = toward_the_sun(3.0);
    scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 1.0)];
    let picture = channels(&render_scene(scene, 256, 1));
    let sent = flux(&picture, "background.G", 3.0);
    assert!((sent / f64::exp(-2.0) - 1.0).abs() < 5e-3, "{sent}");
}

#[test]
fn a_point_is_not_seen_and_a_disc_can_be_left_out() {
    let mut scene = toward_the_sun(3.0);
    let off = BTreeMap::from([(Effect::SunDisc, Switch::Off)]);
    assert_eq!(mean_of(&render_with(scene.clone(), 4, 1, &off), "G"), 0.0);
    scene.suns[0].angular_diameter_deg = None;
    assert_eq!(mean_of(&render_scene(scene.clone(), 4, 1), "G"), 0.0);
    scene.settings.sun.angular_diameter_deg = 2.0;
    assert!(mean_of(&render_scene(scene, 4, 1), "G") > 0.0);
}

/// Rationale: light scattered once by thin fog carries the mean of the phase function over the disc. Set-up: fog with a
/// peak narrower than a disc of 8 degrees, looked at in its middle and beside it. Expected: the mean, summed over rings.
#[test]
fn a_disc_blurs_what_is_scattered() {
    let (g, tau, radius) = (0.98, 1e-3, 4f64.to_radians());
    let phase = PhaseFunction::henyey_greenstein(g);
    for offset_deg in [0.0, 3.0, 8.0f64] {
        let mut scene = empty_scene();
        with_phase(&mut scene, PhaseModel::HenyeyGreenstein { g: Some(g) });
        scene.classes[0].albedo = Some(1.0);
        let (sin, cos) = offset_deg.to_radians().sin_cos();
        scene.suns = vec![sun(DVec3::new(sin, 0.0, cos))];
        scene.suns[0].angular_diameter_deg = Some(8.0);
        scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::ONE, 0.5 * tau)];
        scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1e-3);
        let (rings, turns) = (400, 400);
        let mut sum = 0.0;
        for ring in 0..rings {
            let h = (f64::from(ring) + 0.5) / f64::from(rings) * (1.0 - radius.cos());
            let sin_a = (h * (2.0 - h)).sqrt();
            for turn in 0..turns {
                let phi = (f64::from(turn) + 0.5) / f64::from(turns) * 2.0 * PI;
                let mu = (1.0 - h) * cos + sin_a * phi.cos() * sin;
                sum += phase.eval(1.0 - mu);
            }
        }
        let expected = tau * sum / f64::from(rings * turns);
        let outcome = render_once(scene, 1000, 3);
        // Sunlight and sight cross thin fog: tau of each is lost, at most.
        let picture = channels(&outcome);
        let errors = &picture["stderr.G"];
        let error = errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>().sqrt() / errors.len() as f64;
        let found = mean(&picture["direct.G"]);
        assert!((found - expected).abs() < 4.0 * error + 2.0 * tau * expected, "{offset_deg}: {found} {expected}");
        assert!(offset_deg == 0.0 || error < 0.05 * expected);
    }
}

/// The disc softens shadows: behind the edge of an opaque lid, air is lit by half of the sun.
#[test]
fn shadows_of_a_disc_have_soft_edges() {
    let lit = |x_m: f64| {
        let mut scene = empty_scene();
        with_air(&mut scene, 1e-4, 0.0, 20.0, 20.0);
        scene.suns = vec![sun(DVec3::NEG_Y)];
        scene.suns[0].angular_diameter_deg = Some(10.0);
        // The lid's edge is 10 m above what is looked at, at x = 0.
        scene.fog_boxes = vec![fog_box(DVec3::new(-50.0, 10.05, 0.0), DVec3::new(50.0, 0.05, 50.0), 1e4)];
        scene.camera = orthographic(DVec3::new(x_m, 0.0, 10.0), 1e-3);
        mean_of(&render_scene(scene, 400, 1), "airlight.G")
    };
    let (dark, half, bright) = (lit(-2.0), lit(0.0), lit(2.0));
    assert_eq!(dark, 0.0);
    assert!((half / bright - 0.5).abs() < 0.02, "{half} of {bright}");
}

/// Rationale: a droplet that is glass casts the shadow of its extinction, which is wider than the ball, but to the eye it ends at its outline.
/// Set-up: a magnified droplet before the disc, seen by both cameras. Expected: in the ring between, the disc undimmed.
#[test]
fn the_disc_is_seen_right_beside_a_glass_ball() {
    let radius_m = 0.1;
    let radiance = 1.0 / (2.0 * PI * (1.0 - 1f64.to_radians().cos()));
    for (name, lens) in [
        ("perspective", Lens::Perspective { yfov_rad: 2.0 * (0.2f64 / 10.0).atan(), aspect: None }),
        ("orthographic", Lens::Orthographic { xmag_m: 0.2, ymag_m: 0.2 }),
    ] {
        let mut scene = toward_the_sun(3.0);
        scene.particles = vec![droplet(DVec3::ZERO, radius_m, 5e-6)];
        scene.camera.position_m = DVec3::new(0.0, 0.0, 10.0);
        scene.camera.lens = lens;
        let picture = channels(&render_with(scene, 16, 1, &BTreeMap::from([(Effect::Refraction, Switch::On)])));
        let place = |i: usize| (i as f64 + 0.5) * 0.4 / 32.0 - 0.2;
        let distance = |i: usize| place(i % 32).hypot(place(i / 32));
        // A pixel's half diagonal is 0.09 of the radius; the shadow would reach to 1.5.
        let ring: Vec<f64> = (0..32 * 32)
            .filter(|i| (1.12 * radius_m..1.4 * radius_m).contains(&distance(*i)))
            .map(|i| f64::from(picture["background.G"][i]) / radiance)
            .collect();
        assert!(ring.len() > 40 && ring.iter().all(|seen| (seen - 1.0).abs() < 1e-5), "{name} {ring:?}");
        let middle = f64::from(picture["background.G"][32 * 16 + 16]);
        assert!(middle < 1e-6 * radiance, "{name}: {middle}");
    }
}

/// Rationale: what a disc of a part of a pixel sends is known as well as that of a large one. Set-up: the sun's own disc (0.533 degrees) in
/// pixels of several degrees: in the middle of one, on a corner of four, near the corner of a wide view, half out of the picture; without and behind
/// fog. Expected: its irradiance (half of it at the edge) times the fog's transmittance, from few samples.
#[test]
fn a_small_disc_is_found_by_every_sample() {
    for (fov_deg, x, y, tau, share) in [
        (90.0f64, 0.03, 0.03, 0.0, 1.0),
        (90.0, 0.0, 0.0, 0.0, 1.0),
        (90.0, 0.91, -0.85, 0.0, 1.0),
        (90.0, 1.0, 0.2, 0.0, 0.5),
        (60.0, 0.1, 0.2, 2.0, 1.0),
    ] {
        let mut scene = toward_the_sun(fov_deg);
        let half = (0.5 * fov_deg.to_radians()).tan();
        scene.suns = vec![sun(-DVec3::new(x * half, y * half, -1.0).normalize())];
        scene.suns[0].angular_diameter_deg = Some(0.533);
        if tau > 0.0 {
            // A wide layer across the view, half of it before the middle.
            let slant = (1.0 + (x * x + y * y) * half * half).sqrt();
            scene.fog_boxes = vec![fog_box(DVec3::ZERO, DVec3::new(100.0, 100.0, 1.0), 0.5 * tau / slant)];
        }
        let picture = channels(&render_scene(scene, 32, 1));
        let expected = share * (-tau).exp();
        // The disc lies anywhere in its pixel, whose slant changes by percents: that of the disc counts.
        let slant = (1.0 + (x * x + y * y) * half * half).powf(-1.5);
        let sent = channel_sum(&picture["background.G"]) * (2.0 * half / 32.0).powi(2) * slant;
        assert!((sent / expected - 1.0).abs() < 0.01, "{fov_deg} {x} {y} {tau}: {sent} against {expected}");
        // What fog scatters is noisier.
        let noise = channel_sum(&picture["stderr.G"]) / channel_sum(&picture["G"]);
        assert!(tau > 0.0 || noise < 0.03, "{noise}");
    }
}

fn channel_sum(values: &[f32]) -> f64 {
    values.iter().map(|value| f64::from(*value)).sum()
}
