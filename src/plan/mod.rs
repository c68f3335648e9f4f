//! Which effects are simulated, and why: a pure function of scene and settings.

mod facts;
mod surroundings;

use std::collections::BTreeMap;

use crate::scene::model::Scene;
use crate::scene::settings::{Effect, Switch};

pub use facts::SceneFacts;

/// What the inner loops need to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// Sunlight scattered once by droplets.
    pub direct: bool,
    /// Light scattered by droplets more than once.
    pub multiple: bool,
    /// Droplets shade each other and the air.
    pub shadows: bool,
    /// Sunlight scattered once by the air.
    pub airlight: bool,
    /// Light that air and droplets scatter one after the other.
    pub air_multiple: bool,
    /// The air weakens what crosses it.
    pub air: bool,
    /// What lies behind.
    pub background: bool,
    /// Droplets absorb.
    pub absorption: bool,
    /// Index and phase function of each wavelength.
    pub dispersion: bool,
}

/// What was decided about one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The effect.
    pub effect: Effect,
    /// Whether it is simulated.
    pub on: bool,
    /// The reason in words, with the number it rests on.
    pub reason: String,
    /// Estimated largest relative change of the picture, where there is one.
    pub estimate: Option<f64>,
}

/// The decisions about all effects, in the order of `Effect::ALL`.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectPlan {
    /// One per effect.
    pub decisions: Vec<Decision>,
}

/// An effect is simulated when it may change the picture by more than this share of the accuracy target.
pub const SHARE_OF_TARGET: f64 = 0.1;

/// Decides about every effect. `choices` (flags) override what the scene says.
pub fn plan(scene: &Scene, choices: &BTreeMap<Effect, Switch>, target: f64, n_wavelengths: usize) -> EffectPlan {
    let facts = SceneFacts::of(scene);
    let decide = |(effect, _): &(Effect, &'static str)| {
        let switch = choices.get(effect).or_else(|| scene.settings.effects.get(effect)).copied().unwrap_or_default();
        let airlight = is_wanted(scene, choices, Effect::Airlight);
        let (estimate, reason) = estimate(*effect, scene, &facts, n_wavelengths, airlight);
        let threshold = SHARE_OF_TARGET * target;
        match switch {
            Switch::On => Decision { effect: *effect, on: true, reason: "switched on".into(), estimate },
            Switch::Off => Decision { effect: *effect, on: false, reason: "switched off".into(), estimate },
            Switch::Auto => Decision { effect: *effect, on: estimate.is_none_or(|e| e > threshold), reason, estimate },
        }
    };
    EffectPlan { decisions: Effect::ALL.iter().map(decide).collect() }
}

/// How much an effect could change the picture at most, and on what that rests. `None` always counts as enough.
fn estimate(
    effect: Effect,
    scene: &Scene,
    facts: &SceneFacts,
    n_wavelengths: usize,
    airlight: bool,
) -> (Option<f64>, String) {
    let settings = &scene.settings;
    match effect {
        Effect::Direct if facts.is_empty() => (Some(0.0), "there are no droplets".into()),
        Effect::Direct => (None, format!("optical depth about {:.3}", facts.optical_depth)),
        Effect::Absorption => (None, "costs nothing".into()),
        Effect::Shadows => (
            Some(1.0 - (-facts.deepest_optical_depth).exp()),
            format!("sunlight crosses an optical depth of up to about {:.3}", facts.deepest_optical_depth),
        ),
        Effect::Airlight if !settings.atmosphere.sunlight => (Some(0.0), "atmosphere.sunlight is off".into()),
        Effect::Airlight => {
            let depth = settings.atmosphere.scattering_per_m * settings.atmosphere.depth_m;
            let any = if depth > 0.0 { None } else { Some(0.0) };
            (any, format!("the air's scattering optical depth is {depth:.3}"))
        }
        Effect::Background => surroundings::background(scene),
        Effect::Dispersion if n_wavelengths < 2 => (Some(0.0), "there is one wavelength".into()),
        Effect::Dispersion => (None, format!("{n_wavelengths} wavelengths")),
        Effect::Multiple => (
            Some(1.0 - (-facts.deepest_optical_depth).exp()),
            format!("optical depth up to about {:.3}", facts.deepest_optical_depth),
        ),
        Effect::Glow => glow(scene, facts, airlight),
        Effect::AirMultiple => air_multiple(scene, facts),
        Effect::Refraction => surroundings::refraction(scene, facts),
        Effect::SunDisc => surroundings::sun_disc(scene, facts),
    }
}

/// Whether an effect is not switched off by anybody.
fn is_wanted(scene: &Scene, choices: &BTreeMap<Effect, Switch>, effect: Effect) -> bool {
    choices.get(&effect).or_else(|| scene.settings.effects.get(&effect)) != Some(&Switch::Off)
}

/// Glow against the rest of the picture.
///
/// Of the light that the droplets take out of the sun's, c = albedo (1 - exp(-depth)), the air scatters g = 1 - exp(-sigma_s
/// way) on its way; what is seen besides is the light c of the droplets themselves and, where the sun lights the air, as
/// much as g. So glow is c g of about c + g, or of c alone (theory (69)).
fn glow(scene: &Scene, facts: &SceneFacts, airlight: bool) -> (Option<f64>, String) {
    let air = &scene.settings.atmosphere;
    if air.scattering_per_m <= 0.0 {
        return (Some(0.0), "there is no air that scatters".into());
    }
    if facts.is_empty() {
        return (Some(0.0), "there are no droplets to light the air".into());
    }
    let albedo = scene.classes.iter().map(|class| class.albedo.unwrap_or(1.0)).fold(0.0, f64::max);
    let by_droplets = albedo * -(-facts.deepest_optical_depth).exp_m1();
    let by_air = -(-air.scattering_per_m * air.depth_m).exp_m1();
    let lit = if air.sunlight && airlight { by_air } else { 0.0 };
    let share = if by_droplets > 0.0 { by_droplets * by_air / (by_droplets + lit) } else { 0.0 };
    let reason = format!(
        "droplets scatter {:.2} % of the sunlight at an optical depth of up to about {:.3}, the air {:.2} % of that over {} m",
        100.0 * by_droplets,
        facts.deepest_optical_depth,
        100.0 * by_air,
        air.depth_m
    );
    (Some(share), reason)
}

/// Light that the air scatters between other scatterings, against the rest of the picture.
///
/// The air scatters g = 1 - exp(-sigma_s way) of what crosses it. Of sunlight that has been scattered once, by droplets or air, that
/// is g of the picture; where the sun does not light the air, it takes two collisions with droplets, c g (theory (53)).
fn air_multiple(scene: &Scene, facts: &SceneFacts) -> (Option<f64>, String) {
    let air = &scene.settings.atmosphere;
    let by_air = -(-air.scattering_per_m * air.depth_m).exp_m1();
    let by_droplets = -(-facts.deepest_optical_depth).exp_m1();
    let share = if air.sunlight { by_air } else { by_air * by_droplets };
    (Some(share), format!("the air scatters {:.2} % of what crosses its {} m again", 100.0 * by_air, air.depth_m))
}

impl Decision {
    /// Whether leaving the effect out changes anything at all.
    pub fn matters(&self) -> bool {
        self.estimate.is_none_or(|estimate| estimate > 0.0)
    }
}

impl EffectPlan {
    /// Whether an effect is simulated.
    pub fn is_on(&self, effect: Effect) -> bool {
        self.decisions.iter().any(|decision| decision.effect == effect && decision.on)
    }

    /// What the inner loops need to know; `has_air` says whether the air weakens light at all.
    pub fn switches(&self, has_air: bool) -> Switches {
        Switches {
            direct: self.is_on(Effect::Direct),
            multiple: self.is_on(Effect::Multiple),
            shadows: self.is_on(Effect::Shadows),
            airlight: self.is_on(Effect::Airlight),
            air_multiple: self.is_on(Effect::AirMultiple) && has_air,
            air: has_air,
            background: self.is_on(Effect::Background),
            absorption: self.is_on(Effect::Absorption),
            dispersion: self.is_on(Effect::Dispersion),
        }
    }
}

/// A named accuracy level or a number between 0 and 1: the target relative error of the picture.
pub fn accuracy_level(text: &str) -> Option<f64> {
    const LEVELS: [(&str, f64); 4] = [("draft", 0.1), ("standard", 0.05), ("fine", 0.02), ("reference", 0.005)];
    let named = LEVELS.iter().find(|(name, _)| *name == text).map(|(_, target)| *target);
    named.or_else(|| text.parse().ok().filter(|target: &f64| *target > 0.0 && *target < 1.0))
}

/// Number of spectral bands that an accuracy calls for where the scene names none.
pub fn bands_for(target: f64) -> usize {
    match target {
        t if t > 0.03 => 8,
        t if t > 0.01 => 16,
        _ => 32,
    }
}
