//! The plan: estimates against what is known exactly, and effects that are left out because they cannot change anything.

mod common;

use std::collections::BTreeMap;

use common::{
    channels, droplet, empty_scene, fog_box, mean_of, orthographic, parcel, prepare, render_prepared, with_air,
};
use glam::DVec3;
use mie_cloud::plan::{self, Decision, EffectPlan, SceneFacts};
use mie_cloud::scene::model::Scene;
use mie_cloud::scene::settings::{Effect, Switch};
use mie_cloud::spectrum::{SpectralMode, SpectralSampling};
use mie_cloud::transport::Prepared;

fn plan_of(scene: &Scene, target: f64) -> EffectPlan {
    plan::plan(scene, &BTreeMap::new(), target, 1)
}

fn decision(scene: &Scene, effect: Effect) -> Decision {
    let plan = plan_of(scene, 0.05);
    plan.decisions.into_iter().find(|decision| decision.effect == effect).expect("every effect is decided about")
}

/// A box of fog that fills the picture, 2 m deep along the camera's rays and the sun's.
fn slab(depth: f64) -> Scene {
    let mut scene = empty_scene();
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 0.5);
    scene.fog_boxes.push(fog_box(DVec3::ZERO, DVec3::ONE, 0.5 * depth));
    scene
}

#[test]
fn optical_depths_of_a_slab_are_those_of_its_fog() {
    for depth in [1e-6, 0.1, 5.0f64] {
        let facts = SceneFacts::of(&slab(depth));
        let taken = -(-depth).exp_m1();
        let close =
            |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 1e-6, "{value}, not {expected}");
        close(facts.cover, taken);
        close(facts.concentration, 1.0);
        close(facts.met_again, taken);
        close(facts.sunward_depth, depth);
        close(1.0 - facts.sunlit, 1.0 - taken / depth);
    }
}

/// A ball of optical depth tau across its middle covers pi/4 of the picture; thin, its light is in proportion to its chords, whose
/// mean square over mean squared is 9/8, and what it meets again is at most the whole chord.
#[test]
fn a_thin_ball_is_concentrated_as_its_chords_are() {
    let mut scene = empty_scene();
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1.0);
    // 2 pi r^2 N / (pi R^2) is 4/3 of the mean chord's depth.
    scene.particles.push(parcel(DVec3::ZERO, 1.0, 1e-3 / (2.0 * 25e-12)));
    let facts = SceneFacts::of(&scene);
    let square = 9.0 / 8.0 * 4.0 / std::f64::consts::PI;
    // Cells are a sixteenth of the radius.
    assert!((facts.concentration.powi(2) / square - 1.0).abs() < 0.02, "{facts:?}");
    assert!((facts.cover / (1e-3 * 0.25 * std::f64::consts::PI) - 1.0).abs() < 0.02, "{facts:?}");
    assert!((1e-3..2.5e-3).contains(&facts.met_again), "{facts:?}");
}

/// What a droplet scatters does not meet it again, and it does not shade itself; a second one in its place does both.
#[test]
fn a_lone_droplet_meets_nothing_of_its_own() {
    let mut scene = empty_scene();
    scene.camera = orthographic(DVec3::new(0.0, 0.0, 10.0), 1.0);
    scene.particles.push(droplet(DVec3::ZERO, 0.2, 5e-6));
    for effect in [Effect::Multiple, Effect::Shadows] {
        assert_eq!(decision(&scene, effect).estimate, Some(0.0), "{effect:?}");
    }
    // Drawn in its own outline, not on a disc of twice the area, whatever lies behind.
    let refraction = decision(&scene, Effect::Refraction);
    assert!(refraction.on && refraction.estimate.is_some_and(|e| e > 1.0), "{refraction:?}");
    scene.particles.push(droplet(DVec3::ZERO, 0.2, 5e-6));
    for effect in [Effect::Multiple, Effect::Shadows] {
        assert!(decision(&scene, effect).estimate.is_some_and(|e| e > 0.5), "{effect:?}");
    }
}

/// The sun sees a sheet of fog from its edge, thinner than the grid: it is not taken for nothing.
#[test]
fn what_the_grid_is_too_coarse_for_is_not_left_out() {
    let mut scene = slab(1.0);
    scene.suns = vec![common::sun(DVec3::NEG_Z)];
    scene.camera.world_from_camera = glam::DMat3::from_cols(DVec3::NEG_Z, DVec3::Y, DVec3::X);
    scene.fog_boxes = vec![fog_box(DVec3::new(0.01, 0.0, 0.0), DVec3::new(1e-3, 1.0, 1.0), 1.0)];
    assert!(decision(&scene, Effect::Shadows).on);
}

/// Before an even background the picture is known: fog of albedo 1 sends on what it takes, so that the picture is the background's, and
/// `multiple` is the light that it takes; air of depth t adds exp(t) - 1 of it by scattering twice.
#[test]
fn before_an_even_background_estimates_are_what_is_missing() {
    for depth in [1e-3, 0.1, 2.0f64] {
        let mut scene = slab(depth);
        scene.suns[0].lux = 0.0;
        scene.settings.background.radiance = [0.7; 3];
        let estimate = decision(&scene, Effect::Multiple).estimate.expect("a number");
        assert!((estimate / -(-depth).exp_m1() - 1.0).abs() < 1e-6, "{estimate} at {depth}");
    }
    let mut scene = empty_scene();
    scene.suns[0].lux = 0.0;
    scene.settings.background.radiance = [0.7; 3];
    with_air(&mut scene, 0.01, 0.0, 20.0, 1.0);
    let estimate = decision(&scene, Effect::AirMultiple).estimate.expect("a number");
    // What air takes from a background is not counted as seen: exp(0.2) more.
    assert!((estimate / (0.2f64.exp_m1() * 0.2f64.exp()) - 1.0).abs() < 1e-6, "{estimate}");
}

/// The sun's light on a thin fog changes a picture of a bright sky by less, the brighter the sky; with a black background all
/// stays as it was.
#[test]
fn what_is_faint_beside_a_sky_is_left_out() {
    let before = |radiance: f64, effect| {
        let mut scene = slab(0.02);
        scene.settings.background.radiance = [radiance; 3];
        // Seen from the side, where droplets send little: the sun from above.
        scene.suns = vec![common::sun(DVec3::new(0.0, -1.0, 0.01))];
        decision(&scene, effect)
    };
    for effect in [Effect::Direct, Effect::Shadows] {
        let estimates = [0.1, 1.0, 1e3].map(|radiance| before(radiance, effect).estimate.expect("a number"));
        assert!(estimates[0] > estimates[1] && estimates[1] > 100.0 * estimates[2], "{effect:?} {estimates:?}");
        assert!(before(0.0, effect).on && !before(1e3, effect).on, "{effect:?}");
    }
}

/// Bodies that take light and send none on are no sources of glow, however deep they are.
#[test]
fn black_bodies_light_no_air() {
    let mut scene = slab(0.5);
    with_air(&mut scene, 1e-3, 0.0, 20.0, 1.0);
    let fog = decision(&scene, Effect::Glow).estimate.expect("a number");
    assert!(fog > 0.0);
    scene.classes[0].albedo = Some(0.0);
    scene.fog_boxes[0].density = mie_cloud::scene::model::FogDensity::ExtinctionPerM(1e4);
    assert_eq!(decision(&scene, Effect::Glow).estimate, Some(0.0));
}

fn prepared(scene: Scene, choices: &BTreeMap<Effect, Switch>) -> Prepared {
    let sampling = SpectralSampling::new(SpectralMode::Mono { wavelength_m: 550e-9 }, scene.settings.sun.spectrum);
    let plan = plan::plan(&scene, choices, 0.05, 1);
    Prepared::new(scene, &plan, &sampling, None, &mut |_| {}).expect("the scene can be prepared")
}

/// Nobody looks for a sun that does not shine, and fog still scatters what lies behind: the picture is to the bit that with
/// everything on.
#[test]
fn without_sunlight_no_shadow_ray_is_traced() {
    let mut scene = slab(2.0);
    scene.settings.background.radiance = [0.5; 3];
    scene.suns[0].lux = 0.0;
    let everything = Effect::ALL.map(|(effect, _)| (effect, Switch::On));
    let planned = render_prepared(&prepared(scene.clone(), &BTreeMap::new()), 16, 3);
    let all = render_prepared(&prepared(scene, &everything.into()), 16, 3);
    assert_eq!(planned.rays.shadow, 0);
    assert!(all.rays.shadow > 0 && planned.rays.scatter > 0);
    // The slab hides 86 % of the background, and sends most of it on.
    assert!(mean_of(&planned, "G") > 0.3, "{}", mean_of(&planned, "G"));
    let difference = (mean_of(&planned, "G") / mean_of(&all, "G") - 1.0).abs();
    assert!(difference < 1e-6, "{difference}");
}

/// `direct` is light scattered once: without it, light scattered more often stays as it is.
#[test]
fn without_direct_light_multiple_stays() {
    let picture = |choices: &[(Effect, Switch)]| {
        channels(&render_prepared(&prepare(slab(1.0), &choices.iter().copied().collect()), 8, 5))
    };
    let (all, without) = (picture(&[]), picture(&[(Effect::Direct, Switch::Off)]));
    assert_eq!(all["multiple.G"], without["multiple.G"]);
    assert!(
        without["direct.G"].iter().all(|value| *value == 0.0) && without["multiple.G"].iter().any(|value| *value > 0.0)
    );
}

/// Evenly lit air has a closed form, sigma_s / sigma (1 - exp(-sigma d)) p E, and takes one step without noise: theory (107).
#[test]
fn air_that_nothing_shades_is_one_step() {
    let mut scene = empty_scene();
    with_air(&mut scene, 0.05, 0.02, 10.0, 0.01);
    let outcome = render_prepared(&prepared(scene, &BTreeMap::from([(Effect::AirMultiple, Switch::Off)])), 4, 1);
    let expected = 0.05 / 0.07 * -(-0.07f64 * 10.0).exp_m1() / (4.0 * std::f64::consts::PI);
    let got = mean_of(&outcome, "airlight.G");
    assert!((got / expected - 1.0).abs() < 1e-6, "{got}, not {expected}");
    assert!(outcome.film.noise() < 1e-6, "{}", outcome.film.noise());
}
