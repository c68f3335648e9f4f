//! Which effects are simulated, and why: a pure function of scene and settings.

mod air;
mod areas;
mod droplets;
mod facts;
mod light;
mod phase_bounds;
mod picture;
mod seen;
mod shade;
mod sources;
mod steps;
mod surroundings;
mod view;
mod work;

use std::collections::BTreeMap;

use crate::scene::keys::ACCURACY_NAMES;
use crate::scene::model::Scene;
use crate::scene::settings::{Effect, Switch};
use crate::warning::Warning;

pub use facts::SceneFacts;
pub use light::Parts;
pub use seen::SeenDepths;
pub use steps::{LAST_OPTICAL_DEPTH, MOST_STEPS, march_steps};

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
    /// How somebody switched it; `Auto` where the plan decides.
    pub switch: Switch,
    /// Whether it is simulated.
    pub on: bool,
    /// The reason in words, with the number it rests on.
    pub reason: String,
    /// Estimated largest relative change of the picture, where there is one.
    pub estimate: Option<f64>,
    /// Predicted share of the time, asked once per sample: of the planned picture's where it is on, else of what that would take with it.
    /// `None` where it has no rays of its own.
    pub time_share: Option<f64>,
}

/// The decisions about all effects, in the order of `Effect::ALL`.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectPlan {
    /// One per effect.
    pub decisions: Vec<Decision>,
    /// Whether suns are looked at: one shines, or somebody switched `direct` on.
    pub follows_suns: bool,
}

/// An estimate of the largest relative change of the picture, and what it rests on.
type Estimate = (Option<f64>, String);

/// An effect is simulated when it may change the picture by more than this share of the accuracy target.
pub const SHARE_OF_TARGET: f64 = 0.1;

/// What is left out may change the picture by at most this share of the target together: with noise of the whole target the error is then
/// (1 + 0.4^2)^(1/2) = 1.08 of it.
const MOST_LEFT_OUT: f64 = 0.4;

/// Decides about every effect. `choices` (flags) override what the scene says.
pub fn plan(scene: &Scene, choices: &BTreeMap<Effect, Switch>, target: f64, n_wavelengths: usize) -> EffectPlan {
    let facts = SceneFacts::of_wanted(scene, &|effect| is_wanted(scene, choices, effect));
    let decide = |(effect, _): &(Effect, &'static str)| {
        let switch = choices.get(effect).or_else(|| scene.settings.effects.get(effect)).copied().unwrap_or_default();
        let (estimate, reason) = estimate(*effect, scene, &facts, n_wavelengths);
        let threshold = SHARE_OF_TARGET * target;
        let (on, reason) = match switch {
            Switch::On if estimate == Some(0.0) => (true, format!("switched on, but {reason}")),
            Switch::On => (true, "switched on".into()),
            Switch::Off => (false, "switched off".into()),
            Switch::Auto => (estimate.is_none_or(|e| e > threshold), reason),
        };
        Decision { effect: *effect, switch, on, reason, estimate, time_share: None }
    };
    let mut decisions: Vec<Decision> = Effect::ALL.iter().map(decide).collect();
    keep_enough(&mut decisions, MOST_LEFT_OUT * target);
    let effects: Vec<(Effect, bool)> = decisions.iter().map(|decision| (decision.effect, decision.on)).collect();
    let shares = work::time_shares(scene, &facts, &effects);
    decisions.iter_mut().zip(shares).for_each(|(decision, share)| decision.time_share = share);
    let mut plan = EffectPlan { decisions, follows_suns: facts.sun_shines };
    plan.follows_suns |= plan.is_on(Effect::Direct);
    plan
}

/// Switches what was left out on again, the largest first, while all of it together might change the picture by more than `most`: nearly
/// all effects are light that would be missing, so that their changes add up.
fn keep_enough(decisions: &mut [Decision], most: f64) {
    let faint = |decision: &Decision| match decision.switch {
        Switch::Auto if !decision.on => decision.estimate.unwrap_or(0.0),
        _ => 0.0,
    };
    while decisions.iter().map(faint).sum::<f64>() > most {
        let Some(largest) = decisions.iter_mut().max_by(|a, b| faint(a).total_cmp(&faint(b))) else { return };
        largest.on = true;
        largest.reason += "; too much with all else that is faint";
    }
}

/// How much an effect could change the picture at most, and on what that rests. `None` always counts as enough.
fn estimate(effect: Effect, scene: &Scene, facts: &SceneFacts, n_wavelengths: usize) -> Estimate {
    match effect {
        Effect::Direct | Effect::Airlight | Effect::Glow | Effect::Shadows | Effect::SunDisc if !facts.sun_shines => {
            (Some(0.0), "no sun shines".into())
        }
        Effect::Direct => droplets::direct(facts),
        Effect::Absorption => (None, "costs nothing".into()),
        Effect::Shadows => droplets::shadows(facts),
        Effect::Airlight => air::airlight(scene, facts),
        Effect::Background => surroundings::background(scene),
        Effect::Dispersion if n_wavelengths < 2 => (Some(0.0), "there is one wavelength".into()),
        Effect::Dispersion => (None, format!("{n_wavelengths} wavelengths")),
        Effect::Multiple => droplets::multiple(scene, facts),
        Effect::Glow => air::glow(scene, facts),
        Effect::AirMultiple => air::air_multiple(scene, facts),
        Effect::Refraction => droplets::refraction(facts),
        Effect::SunDisc => surroundings::sun_disc(scene, facts),
    }
}

/// Whether an effect is not switched off by anybody.
fn is_wanted(scene: &Scene, choices: &BTreeMap<Effect, Switch>, effect: Effect) -> bool {
    choices.get(&effect).or_else(|| scene.settings.effects.get(&effect)) != Some(&Switch::Off)
}

impl Decision {
    /// Whether leaving the effect out changes anything at all.
    pub fn matters(&self) -> bool {
        self.estimate.is_none_or(|estimate| estimate > 0.0)
    }
}

impl EffectPlan {
    /// Effects that somebody switched on and that can do nothing, each with the reason.
    pub fn warnings(&self) -> Vec<Warning> {
        let in_vain = |decision: &&Decision| decision.switch == Switch::On && decision.estimate == Some(0.0);
        let warning = |decision: &Decision| {
            Warning::new(format!("effect {} does nothing: {}", decision.effect.name(), decision.reason), "")
        };
        self.decisions.iter().filter(in_vain).map(warning).collect()
    }

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

/// A named accuracy level or a number above 0 and at most 1: the target relative error of the picture.
pub fn accuracy_level(text: &str) -> Option<f64> {
    let named = ACCURACY_NAMES.iter().find(|(name, _)| *name == text).map(|(_, target)| *target);
    named.or_else(|| text.parse().ok().filter(|target: &f64| *target > 0.0 && *target <= 1.0))
}

/// Number of spectral bands that an accuracy calls for where the scene names none.
pub fn bands_for(target: f64) -> usize {
    match target {
        t if t > 0.03 => 8,
        t if t > 0.01 => 16,
        _ => 32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_that_are_faint_alone_are_not_all_left_out_together() {
        let decision = |effect, estimate| Decision {
            effect,
            switch: Switch::Auto,
            on: false,
            reason: String::new(),
            estimate: Some(estimate),
            time_share: None,
        };
        let effects = [Effect::Glow, Effect::Shadows, Effect::Multiple, Effect::Airlight, Effect::AirMultiple];
        let mut decisions: Vec<Decision> = effects.map(|effect| decision(effect, 0.08)).into();
        decisions[2].estimate = Some(0.09);
        keep_enough(&mut decisions, 0.4);
        let on: Vec<Effect> = decisions.iter().filter(|d| d.on).map(|d| d.effect).collect();
        assert_eq!(on, [Effect::Multiple]);
        keep_enough(&mut decisions, 0.0);
        assert!(decisions.iter().all(|decision| decision.on));
    }
}
