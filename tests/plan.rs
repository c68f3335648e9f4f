//! The plan: estimates against what is known exactly, and effects that are left out because they cannot change anything.

mod common;

use std::collections::BTreeMap;

use common::{
    channels, droplet, empty_scene, fog_box, mean_of, orthographic, parcel, prepare, render_prepared, render_with,
    with_air,
};
use glam::DVec3;
use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::plan::{self, Decision, EffectPlan, SceneFacts, SeenDepths};
use mie_cloud::scene::model::{Lens, Scene};
use mie_cloud::scene::settings::{AirPhase, Effect, Switch};
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

/// Rationale: a box that is 2 m deep along the view is as deep across as it is wide. Expected: its extinction times that width, wherever the
/// camera stands, and with a box beside it the mean of both.
#[test]
fn depths_across_are_those_from_side_to_side() {
    let mut scene = slab(1.0);
    scene.fog_boxes[0].half_edges_m.x_axis *= 3.0;
    let across = SeenDepths::across(&scene);
    assert!((across.mean / 3.0 - 1.0).abs() < 1e-6 && (across.deepest / 3.0 - 1.0).abs() < 1e-6, "{across:?}");
    scene.fog_boxes.push(fog_box(DVec3::new(0.0, 4.0, 0.0), DVec3::ONE, 2.5));
    let both = SeenDepths::across(&scene);
    // Rays of a coarse grid.
    assert!((both.mean / 4.0 - 1.0).abs() < 0.05 && (both.deepest / 5.0 - 1.0).abs() < 1e-6, "{both:?}");
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

/// Droplets above the picture light the air in it. Rationale: what one order sends into the air meets the droplets again, however few of
/// them are seen. Expected: `multiple` changes a render by no more than its estimate, which is not small.
#[test]
fn droplets_that_are_not_seen_light_the_air_with_all_orders() {
    let mut scene = empty_scene();
    scene.camera.lens = Lens::Perspective { yfov_rad: 0.7, aspect: None };
    scene.camera.position_m = DVec3::new(0.0, 0.0, 10.0);
    scene.suns[0].direction = DVec3::NEG_Y;
    scene.particles.push(parcel(DVec3::new(0.0, 24.0, -12.0), 16.0, 16.0 * std::f64::consts::PI * 256.0 / 1e-10));
    with_air(&mut scene, 0.01, 0.0, 30.0, 0.5);
    let multiple = decision(&scene, Effect::Multiple);
    assert_eq!(SceneFacts::of(&scene).cover, 0.0);
    assert!(multiple.on && multiple.reason.contains("not seen"), "{multiple:?}");
    let mean = |switch| {
        let effects = BTreeMap::from([(Effect::Multiple, switch)]);
        mean_of(&render_with(scene.clone(), 64, 3, &effects), "G")
    };
    let (all, once) = (mean(Switch::On), mean(Switch::Off));
    let change = 1.0 - once / all;
    // 23 % was measured with more samples; these two pictures are known to some 2 %.
    assert!(change > 0.1 && multiple.estimate.is_some_and(|estimate| change < estimate), "{change}: {multiple:?}");
}

/// A disc blurs the haze's own glory, and nothing where there is nothing with structure.
#[test]
fn the_disc_blurs_a_haze_as_it_does_droplets() {
    let disc = |phase: AirPhase| {
        let mut scene = empty_scene();
        scene.camera.lens = Lens::Perspective { yfov_rad: 0.1, aspect: None };
        scene.suns[0].direction = DVec3::NEG_Z;
        scene.settings.sun.angular_diameter_deg = 0.533;
        with_air(&mut scene, 0.002, 0.0, 30.0, 1.0);
        scene.settings.atmosphere.phase = phase;
        decision(&scene, Effect::SunDisc)
    };
    let haze = |text: &str| AirPhase::Haze(SizeDistribution::parse(text, &|_| Err("no file".into())).expect(text));
    for text in ["mono:r=20um", "gamma:reff=20um,veff=0.01", "mono:r=100um"] {
        let decision = disc(haze(text));
        // 14, 6 and 7 % were measured.
        assert!(decision.on && decision.estimate.is_some_and(|estimate| estimate > 0.06), "{text}: {decision:?}");
        assert!(decision.reason.contains("haze of size parameter"), "{decision:?}");
    }
    let fine = disc(haze("mono:r=0.1um"));
    assert!(!fine.on && fine.estimate.is_some_and(|estimate| estimate < 1e-4), "{fine:?}");
    let none = disc(AirPhase::Rayleigh);
    assert!(none.estimate == Some(0.0) && none.reason.ends_with("blurs nothing that is seen"), "{none:?}");
}

/// What lies beside the picture may be any number of times as bright as what is in it.
#[test]
fn before_a_background_picture_nothing_is_taken_for_faint() {
    let mut scene = slab(1e-3);
    with_air(&mut scene, 1e-6, 0.0, 10.0, 1.0);
    scene.settings.background.image = Some("sky.exr".into());
    for effect in [Effect::Multiple, Effect::AirMultiple] {
        assert!(decision(&scene, effect).on, "{effect:?}");
    }
}
