//! The estimated error of a finished picture, part by part, so that it can be said which knob would make it better.

use super::prepare::Prepared;
use crate::plan::{Decision, EffectPlan};
use crate::scene::settings::{Effect, Switch};

/// A part of the error.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorPart {
    /// What makes it: a knob of `bench accuracy`, or `effects`.
    pub knob: &'static str,
    /// In words.
    pub what: String,
    /// How large it is, relative to the mean luminance, RMS over pixels.
    pub error: f64,
}

/// All parts, the largest first. What somebody set by hand to be wrong (effects, an order, a peak truncation) is not among them.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// The parts that are not zero.
    pub parts: Vec<ErrorPart>,
}

impl ErrorEstimate {
    /// Of a picture of this noise.
    pub fn new(plan: &EffectPlan, prepared: &Prepared, noise: f64) -> Self {
        let left_out = || plan.decisions.iter().filter(|decision| !decision.on && decision.switch == Switch::Auto);
        // Nearly all of them are light that is missing: they add up.
        let left_out_error: f64 = left_out().filter_map(|decision| decision.estimate).sum();
        let names: Vec<&str> = left_out().filter(|decision| decision.matters()).map(|d| d.effect.name()).collect();
        let glow = plan.decisions.iter().find(|decision| decision.effect == Effect::Glow && decision.on);
        let of_picture = |glow: &Decision| glow.estimate.map_or(1.0, |estimate| estimate.min(1.0));
        let glow_error = glow.zip(prepared.glow_tolerance).map_or(0.0, |(glow, e)| e * of_picture(glow));
        let part = |knob, what: &str, error| ErrorPart { knob, what: what.to_owned(), error };
        let mut parts = vec![
            part("spp", "noise", noise),
            part("bands", "few wavelengths", prepared.band_error),
            part(
                "angle_tolerance",
                "phase tables",
                if prepared.counts.size_bins > 0 { prepared.angle_tolerance } else { 0.0 },
            ),
            part("glow_tolerance", "the sum of glow", glow_error),
            part("effects", &format!("leaving out {}", names.join(", ")), left_out_error),
        ];
        parts.retain(|part| part.error > 0.0);
        parts.sort_by(|a, b| b.error.total_cmp(&a.error));
        Self { parts }
    }

    /// All parts together: the root of the sum of their squares.
    pub fn total(&self) -> f64 {
        self.parts.iter().map(|part| part.error * part.error).sum::<f64>().sqrt()
    }

    /// One line of 80 columns at most: the whole, what dominates it and by which knob, and what comes next.
    pub fn line(&self) -> String {
        let percent = |error: f64| format!("{:.2} %", 100.0 * error);
        let [first, rest @ ..] = &self.parts[..] else { return "estimated error 0 %".into() };
        let then = rest.first().map_or(String::new(), |part| format!("; then {} {}", part.what, percent(part.error)));
        let line = format!("estimated error {}, most of it {} ({})", percent(self.total()), first.what, first.knob);
        if line.chars().count() + then.chars().count() <= 80 { line + &then } else { line }
    }
}
