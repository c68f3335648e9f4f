//! What each effect costs and changes, beside what the plan had said of it.

use std::fmt;
use std::path::Path;

use serde::Serialize;

use super::difference::Difference;
use super::machine::Machine;
use super::particles::Spread;
use super::trial::{MOST_SPP, Shots, Trial};
use crate::plan::{Decision, SHARE_OF_TARGET};
use crate::scene::settings::Effect;
use crate::transport::{PrepareError, Until};

/// How the measurement is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup<'a> {
    /// Samples per pixel of each of the two renders of a picture.
    pub spp: u32,
    /// Seed of the first render; the second takes the next.
    pub seed: u64,
    /// A folder for optical tables.
    pub cache: Option<&'a Path>,
    /// Times that the planned picture and the one with everything are rendered in turns.
    pub repeat: u32,
    /// Whether they are also rendered until the noise is at the target.
    pub to_target: bool,
}

/// The planned picture and the one with everything, rendered in turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Race {
    /// Processor seconds of tree and picture.
    pub planned_s: Spread,
    pub everything_s: Spread,
    /// The first over the second, turn by turn.
    pub ratio: Spread,
    /// Samples per pixel, on average.
    pub planned_spp: u32,
    pub everything_spp: u32,
}

/// Whether a decision of the plan holds against the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// On, and it changes the picture by more than the plan's threshold.
    Needed,
    /// On, and it changes the picture by less: time was spent for nothing, no accuracy lost.
    Spare,
    /// Off, and it changes the picture by less.
    RightlyOff,
    /// Off, and it changes the picture by more than the threshold: the plan was wrong.
    Missed,
    /// The noise hides which; more samples tell.
    Unclear,
    /// Somebody switched it; the plan had no say.
    ByHand,
}

impl Verdict {
    /// Judges a decision; `change` is what the effect does to the picture, `None` where there is no picture to change.
    pub fn of(decision: &Decision, by_hand: bool, change: Option<&Difference>, threshold: f64) -> Self {
        let Some(change) = change.filter(|_| !by_hand) else {
            return if by_hand { Self::ByHand } else { Self::Unclear };
        };
        match decision.on {
            true if change.at_least() > threshold => Self::Needed,
            true if change.at_most() <= threshold => Self::Spare,
            false if change.at_most() <= threshold => Self::RightlyOff,
            false if change.at_least() > threshold => Self::Missed,
            _ => Self::Unclear,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Needed => "right: needed",
            Self::Spare => "could be off",
            Self::RightlyOff => "right: not needed",
            Self::Missed => "WRONG: needed",
            Self::Unclear => "noise hides it",
            Self::ByHand => "by hand",
        })
    }
}

/// One effect.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub effect: &'static str,
    /// Whether the plan has it on.
    pub planned: bool,
    /// The plan's estimate of the largest relative change; `None` where it makes none.
    pub estimate: Option<f64>,
    /// The plan's reason.
    pub reason: String,
    /// Change of the picture, relative to the one with the effect; `None` where that is black.
    pub change: Option<Difference>,
    /// The plan's prediction of its share of the time, and the share that it took; `None` where it has no rays of its own.
    pub predicted_share: Option<f64>,
    pub time_share: Option<f64>,
    /// Processor seconds of tree and picture with the effect and without.
    pub cpu_on_s: f64,
    pub cpu_off_s: f64,
    /// Seconds on the wall.
    pub wall_on_s: f64,
    pub wall_off_s: f64,
    /// Whether the plan was right.
    pub verdict: Verdict,
    /// Whether the measured change is within the estimate; `None` where there is none, or noise hides it.
    pub within_estimate: Option<bool>,
}

/// All effects, and the plan as a whole.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Where times were measured.
    pub machine: Machine,
    /// Target relative error of the picture.
    pub target: f64,
    /// An effect is on where it may change the picture by more than this.
    pub threshold: f64,
    /// Samples per pixel of each of the two renders.
    pub spp: u32,
    /// Noise of one planned render, relative to the mean luminance.
    pub noise: f64,
    /// One per effect.
    pub rows: Vec<Row>,
    /// The planned picture against the one with everything on that nobody switched off by hand.
    pub everything: Option<Difference>,
    /// Both with the same samples.
    pub same_samples: Race,
    /// Both until the noise is at the target; none where that was not asked for.
    pub to_target: Option<Race>,
}

/// Measures every effect of a scene; `done` hears each as it is finished.
///
/// # Errors
/// When the scene cannot be prepared.
pub fn measure(trial: &Trial, setup: &Setup, done: &mut dyn FnMut(&Row)) -> Result<Report, PrepareError> {
    let seeds = [setup.seed, setup.seed.wrapping_add(1)];
    let shoot = |trial: &Trial| trial.shoot(&seeds, Until::Samples(setup.spp), setup.cache);
    let plan = trial.plan();
    let planned = trial.with_effects(|effect| plan.is_on(effect));
    // Pictures that share seeds share noise only if they ask alike; the race is between pictures as they are rendered.
    let [even_trial, even_planned] = [trial, &planned].map(Trial::evenly_asked);
    // The first render warms caches up; the second is the one that is timed.
    even_planned.shoot(&seeds[..1], Until::Samples(1), setup.cache)?;
    let base = shoot(&even_planned)?;
    let threshold = SHARE_OF_TARGET * trial.target();
    let mut rows = Vec::new();
    for decision in &plan.decisions {
        let other = shoot(&even_trial.with_effects(|effect| plan.is_on(effect) != (effect == decision.effect)))?;
        let (with, without) = if decision.on { (&base, &other) } else { (&other, &base) };
        let row = row(decision, trial.is_by_hand(decision.effect), with, without, threshold);
        done(&row);
        rows.push(row);
    }
    let is_off_by_hand = |effect: Effect| trial.is_by_hand(effect) && !plan.is_on(effect);
    let all = trial.with_effects(|effect| !is_off_by_hand(effect));
    let everything = shoot(&all.evenly_asked())?;
    let race = |until| race(&planned, &all, until, setup);
    let until_noise = Until::Noise { target: trial.target(), at_most: MOST_SPP };
    Ok(Report {
        machine: Machine::here(),
        target: trial.target(),
        threshold,
        spp: setup.spp,
        noise: base.noise,
        rows,
        everything: change(&base, &everything),
        same_samples: race(Until::Samples(setup.spp))?,
        to_target: setup.to_target.then(|| race(until_noise)).transpose()?,
    })
}

/// Renders both in turns, so that what else the machine does meets both alike; every turn has seeds of its own.
fn race(planned: &Trial, all: &Trial, until: Until, setup: &Setup) -> Result<Race, PrepareError> {
    let (mut ours, mut theirs, mut spp) = (Vec::new(), Vec::new(), [0.0; 2]);
    for turn in 0..setup.repeat.max(1) {
        let seed = setup.seed.wrapping_add(u64::from(turn));
        let [one, other] = [planned.shoot(&[seed], until, setup.cache)?, all.shoot(&[seed], until, setup.cache)?];
        ours.push(one.took.cpu_s);
        theirs.push(other.took.cpu_s);
        [one.spp, other.spp].iter().zip(&mut spp).for_each(|(n, sum)| *sum += f64::from(*n));
    }
    let ratios = ours.iter().zip(&theirs).map(|(a, b)| a / b.max(1e-9));
    let [planned_spp, everything_spp] = spp.map(|sum| (sum / f64::from(setup.repeat.max(1))).round() as u32);
    Ok(Race {
        ratio: Spread::of(ratios),
        planned_s: Spread::of(ours.iter().copied()),
        everything_s: Spread::of(theirs.iter().copied()),
        planned_spp,
        everything_spp,
    })
}

fn change(a: &Shots, b: &Shots) -> Option<Difference> {
    let pair = |shots: &'_ Shots| Some([shots.pictures.first()?.clone(), shots.pictures.get(1)?.clone()]);
    let (a, b) = (pair(a)?, pair(b)?);
    Difference::of([&a[0], &a[1]], [&b[0], &b[1]], 0.0)
}

fn row(decision: &Decision, by_hand: bool, with: &Shots, without: &Shots, threshold: f64) -> Row {
    let change = change(without, with);
    let within = |(estimate, change): (f64, &Difference)| match () {
        () if change.at_least() > estimate => Some(false),
        () if change.at_most() <= estimate.max(threshold) => Some(true),
        () => None,
    };
    Row {
        effect: decision.effect.name(),
        planned: decision.on,
        estimate: decision.estimate,
        reason: decision.reason.clone(),
        predicted_share: decision.time_share,
        time_share: decision.time_share.map(|_| 1.0 - without.took.cpu_s / with.took.cpu_s.max(1e-9)),
        cpu_on_s: with.took.cpu_s,
        cpu_off_s: without.took.cpu_s,
        wall_on_s: with.took.wall_s,
        wall_off_s: without.took.wall_s,
        verdict: Verdict::of(decision, by_hand, change.as_ref(), threshold),
        within_estimate: decision.estimate.zip(change.as_ref()).and_then(within),
        change,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::settings::Switch;

    #[test]
    fn verdicts_follow_the_measurement_and_admit_noise() {
        let decision = |on| Decision {
            effect: Effect::Glow,
            switch: Switch::Auto,
            on,
            reason: String::new(),
            estimate: Some(0.1),
            time_share: None,
        };
        let change = |rms: f64, error: f64| Difference { square: rms * rms, square_error: error, ..Default::default() };
        let verdict = |on, change: Difference| Verdict::of(&decision(on), false, Some(&change), 0.005);
        assert_eq!(verdict(true, change(0.1, 1e-6)), Verdict::Needed);
        assert_eq!(verdict(true, change(0.001, 1e-6)), Verdict::Spare);
        assert_eq!(verdict(false, change(0.001, 1e-6)), Verdict::RightlyOff);
        assert_eq!(verdict(false, change(0.1, 1e-6)), Verdict::Missed);
        assert_eq!(verdict(false, change(0.006, 1e-4)), Verdict::Unclear);
        assert_eq!(Verdict::of(&decision(true), true, None, 0.005), Verdict::ByHand);
        assert_eq!(Verdict::of(&decision(true), false, None, 0.005), Verdict::Unclear);
    }
}
