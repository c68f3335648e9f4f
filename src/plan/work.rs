//! What every effect costs: a rough count of rays per sample, from the same facts that the plan rests on; theory (145).
//!
//! A share of the time is good to a factor of two or three: enough to see what a render will be busy with.

use super::facts::SceneFacts;
use super::steps::march_steps;
use crate::scene::model::Scene;
use crate::scene::settings::{Atmosphere, Effect};

/// A look at a sun that nothing can shade, against one along a ray through the cloud.
const FREE_LOOK: f64 = 0.1;

/// A collision besides its rays: where it is, and how it turns.
const COLLISION: f64 = 0.5;

/// Rays of the chain toward the sun that begins at a collision, on average.
const CHAIN: f64 = 0.8;

/// A step of the march besides its looks at suns.
const STEP: f64 = 0.15;

/// A sum over all droplets at a step of the march, by the tree; fewer droplets than this are looked at one by one.
const GLOW_SUM: f64 = 15.0;
const FEW_DROPLETS: usize = 64;

/// What one droplet sends to one point.
const ONE_DROPLET: f64 = 2.0;

/// Points on the way past one droplet that are looked at, at most.
const MOST_POINTS: f64 = 16.0;

/// Flights of a path through air and droplets besides those from droplet to droplet.
const AIR_FLIGHTS: f64 = 2.0;

/// Legs of the way through glass of the share of the picture that it covers.
const GLASS_LEGS: f64 = 8.0;

/// Shares of the time that effects take, were each estimator asked once per sample: of those that are on in what is planned, of others if they
/// were on besides. Parallel to `effects`, each with whether it is on; `None` where an effect has no rays of its own.
pub(super) fn time_shares(scene: &Scene, facts: &SceneFacts, effects: &[(Effect, bool)]) -> Vec<Option<f64>> {
    let is_on = |effect: Effect| effects.iter().any(|(other, on)| *other == effect && *on);
    let total = |is_on: &dyn Fn(Effect) -> bool| {
        let of = |(effect, _): &(Effect, bool)| if is_on(*effect) { rays(*effect, scene, facts, is_on) } else { 0.0 };
        1.0 + effects.iter().map(of).sum::<f64>()
    };
    let share = |(effect, _): &(Effect, bool)| {
        if matches!(effect, Effect::Absorption | Effect::Background | Effect::Dispersion | Effect::SunDisc) {
            return None;
        }
        let with = total(&|other| other == *effect || is_on(other));
        let without = total(&|other| other != *effect && is_on(other));
        Some((with - without) / with)
    };
    effects.iter().map(share).collect()
}

/// Rays per sample that an effect adds to others.
fn rays(effect: Effect, scene: &Scene, facts: &SceneFacts, is_on: &dyn Fn(Effect) -> bool) -> f64 {
    let air = &scene.settings.atmosphere;
    let n_suns = if facts.sun_shines { scene.suns.len() as f64 } else { 0.0 };
    let looks = n_suns * if is_on(Effect::Shadows) { 1.0 } else { FREE_LOOK };
    let has_suns = if n_suns > 0.0 { 1.0 } else { 0.0 };
    let further = (facts.collisions - facts.cover).max(0.0);
    match effect {
        Effect::Direct => facts.cover * (looks + COLLISION),
        // Each collision but the first comes after a flight, and of all there may be chains.
        Effect::Multiple => {
            facts.cover * (1.0 + CHAIN * has_suns) + further * (1.0 + looks + COLLISION + CHAIN * has_suns)
        }
        Effect::Airlight => steps(air) * (looks + STEP),
        Effect::Glow => glow(facts, steps(air), is_on(Effect::Shadows)) * has_suns,
        Effect::AirMultiple if air.scattering_per_m <= 0.0 => 0.0,
        Effect::AirMultiple => (AIR_FLIGHTS + further) * (1.0 + looks + COLLISION + CHAIN * has_suns),
        Effect::Refraction => facts.glass_cover * GLASS_LEGS * (1.0 + looks),
        // Shadows, absorption, dispersion, the background and the disc: in what the others are said to take.
        _ => 0.0,
    }
}

fn glow(facts: &SceneFacts, steps: f64, shadows: bool) -> f64 {
    let shade = if shadows { 1.0 } else { 0.0 };
    match facts.n_particles + facts.n_fog_boxes {
        _ if steps == 0.0 => 0.0,
        0 => 0.0,
        n if n <= FEW_DROPLETS => (n as f64 * MOST_POINTS).min(steps.max(n as f64)) * (ONE_DROPLET + shade),
        _ => steps * (GLOW_SUM + shade),
    }
}

/// Steps of the march through the air.
fn steps(air: &Atmosphere) -> f64 {
    if air.scattering_per_m <= 0.0 {
        return 0.0;
    }
    let extinction_per_m = air.scattering_per_m + air.absorption_per_m;
    f64::from(march_steps(extinction_per_m, air.step_m, air.depth_m).0)
}
