//! What accuracy costs: every knob that matters in a scene from coarse to fine against the finest settings, which settings
//! no other beats, and the cheapest ones for an error.
//!
//! The reference is rendered twice with independent seeds. A knob's settings are rendered with the same two seeds, so that
//! what both have in common cancels and the two differences stay independent (`study/difference.rs`): that is the
//! knob's own error, without noise. Samples and targets are rendered with other seeds, against a reference of more samples:
//! there, noise belongs to the error.

mod knobs;
mod price;

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use super::difference::{Difference, Pixels, noise_between};
use super::machine::Machine;
use super::trial::{Shots, Trial};
use crate::transport::{PrepareError, Until};

pub use knobs::{Knob, Setting};
pub use price::{Price, TARGETS};

/// How the measurement is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup<'a> {
    /// Samples per pixel of each of the two renders of a picture.
    pub spp: u32,
    /// Seed of the first render; the others take the next.
    pub seed: u64,
    /// A folder for optical tables.
    pub cache: Option<&'a Path>,
    /// Settings of the knob `target`.
    pub targets: &'a [f64],
}

/// The reference of targets has so many times the least one's noise: the square of a difference has no noise in its mean, and over the
/// 2304 pixels of 64x36 its scatter is a few percent.
const REFERENCE_NOISE: f64 = 1.5;

/// The reference against which noise counts has so many times the samples: its own noise hides that of a fine picture less.
const LONGER: u32 = 8;

/// A knob at one setting, measured.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The knob.
    pub knob: &'static str,
    /// Its setting in short.
    pub setting: String,
    /// The flag of `render` that sets it.
    pub flag: String,
    /// Difference from the reference: for `spp` and `target` with the noise of the picture, for the others without.
    pub error: Difference,
    /// Noise of one picture, RMS over pixels and R, G, B, relative to the mean luminance.
    pub noise: f64,
    /// Error of one picture of this setting, noise included.
    pub total: f64,
    /// Samples per pixel of one picture.
    pub spp: u32,
    /// Processor and wall seconds of tree and one picture, without tables.
    pub cpu_s: f64,
    pub wall_s: f64,
    /// Processor seconds of the tables; next to nothing where the cache had them.
    pub tables_cpu_s: f64,
    /// Bytes of tables, geometry and tree.
    pub bytes: usize,
    /// Whether no other row is both faster and closer (on the Pareto front of `cpu_s` and `total`).
    pub pareto: bool,
    /// The setting itself.
    #[serde(skip)]
    pub value: Option<Setting>,
}

/// All rows of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Where times were measured.
    pub machine: Machine,
    /// Where the reference is from.
    pub reference: String,
    /// Width and height of the pictures, pixels.
    pub resolution: [u32; 2],
    /// The reference: its samples, noise and cost.
    pub finest: Row,
    /// Rows by knob, from coarse to fine.
    pub rows: Vec<Row>,
    /// Knobs that were asked for and do not matter in this scene.
    pub without_effect: Vec<&'static str>,
    /// The cheapest settings for some errors.
    pub prices: Vec<Price>,
}

/// A reference from elsewhere, and the mean square of its noise relative to its mean luminance, as far as it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct External {
    /// Its name.
    pub name: String,
    /// The picture.
    pub pixels: Pixels,
    /// Mean square of its noise.
    pub variance: f64,
}

/// Measures the knobs; `done` hears each row as it is finished.
///
/// # Errors
/// When the scene cannot be prepared.
pub fn measure(
    trial: &Trial,
    knobs: &BTreeSet<Knob>,
    external: Option<&External>,
    setup: &Setup,
    done: &mut dyn FnMut(&Row),
) -> Result<Report, PrepareError> {
    let bench = Bench::new(trial, knobs, external, setup)?;
    let mut finest = bench.row(None, &bench.base);
    (finest.knob, finest.flag) = ("finest", knobs::flags(&bench.finest));
    done(&finest);
    let plan = bench.finest.plan();
    let (mut rows, mut without_effect) = (Vec::new(), Vec::new());
    for knob in knobs {
        let sweep = match knob {
            Knob::Target => setup.targets.iter().copied().map(Setting::Target).collect(),
            _ => Setting::sweep(*knob, &bench.finest, &plan, bench.base.size_bins, setup.spp),
        };
        if sweep.is_empty() {
            without_effect.push(knob.name());
        }
        for setting in sweep {
            let shots = bench.shoot(&setting)?;
            let row = bench.row(Some(setting), &shots);
            done(&row);
            rows.push(row);
        }
    }
    mark_front(&mut rows);
    let prices = TARGETS.iter().map(|target| price::cheapest(&finest, &rows, *target)).collect();
    let reference = external.map_or_else(|| "the finest settings".to_owned(), |external| external.name.clone());
    let resolution = trial.scene.settings.image.resolution;
    Ok(Report { machine: Machine::here(), reference, resolution, finest, rows, without_effect, prices })
}

/// The reference, and what is rendered against it.
struct Bench<'a> {
    trial: &'a Trial,
    finest: Trial,
    external: Option<&'a External>,
    setup: &'a Setup<'a>,
    /// The reference with the seeds and samples of the settings that are compared with it.
    base: Shots,
    /// The reference of more samples, against which noise counts; none where no such knob is asked for.
    long: Option<Shots>,
    /// The reference of targets, sampled to a noise near the least; none where they are not asked for.
    sharp: Option<Shots>,
}

impl<'a> Bench<'a> {
    fn new(
        trial: &'a Trial,
        knobs: &BTreeSet<Knob>,
        external: Option<&'a External>,
        setup: &'a Setup,
    ) -> Result<Self, PrepareError> {
        let finest = knobs::finest(trial);
        let seeds = [setup.seed, setup.seed.wrapping_add(1)];
        // The first render warms caches up; the others are timed.
        finest.shoot(&seeds[..1], Until::Samples(1), setup.cache)?;
        let base = finest.evenly_asked().shoot(&seeds, Until::Samples(setup.spp), setup.cache)?;
        let others = [4, 5].map(|k| setup.seed.wrapping_add(k));
        let least = setup.targets.iter().copied().fold(1.0, f64::min);
        let longer = Until::Samples(setup.spp.saturating_mul(LONGER));
        let long = match external.is_none() && knobs.contains(&Knob::Spp) {
            true => Some(finest.shoot(&others, longer, setup.cache)?),
            false => None,
        };
        let sharp = match external.is_none() && knobs.contains(&Knob::Target) {
            true => {
                let until = knobs::until_noise(REFERENCE_NOISE * least);
                Some(knobs::sharp(&finest, trial, least).shoot(&others, until, setup.cache)?)
            }
            false => None,
        };
        Ok(Self { trial, finest, external, setup, base, long, sharp })
    }

    fn shoot(&self, setting: &Setting) -> Result<Shots, PrepareError> {
        let [same, other] = [0, 2].map(|k| [0, 1].map(|i| self.setup.seed.wrapping_add(k + i)));
        match setting {
            Setting::Spp(n) => self.finest.shoot(&other, Until::Samples(*n), self.setup.cache),
            Setting::Target(target) => {
                let (trial, until) = knobs::asked(self.trial, *target);
                trial.shoot(&other, until, self.setup.cache)
            }
            _ => setting.apply(&self.finest).evenly_asked().shoot(
                &same,
                Until::Samples(self.setup.spp),
                self.setup.cache,
            ),
        }
    }

    fn row(&self, value: Option<Setting>, shots: &Shots) -> Row {
        let knob = value.as_ref().map(Setting::knob);
        let noise = match &shots.pictures[..] {
            [a, b] => noise_between(a, b),
            _ => shots.noise,
        };
        let noise_counts = knob.is_some_and(Knob::has_noise);
        let error = self.error(shots, knob).unwrap_or_default();
        let total = if noise_counts { error.rms().max(noise) } else { error.rms().hypot(noise) };
        Row {
            knob: knob.map_or("", Knob::name),
            setting: value.as_ref().map_or("all".into(), Setting::label),
            flag: value.as_ref().map_or_else(String::new, Setting::flag),
            error,
            noise,
            total,
            spp: shots.spp,
            cpu_s: shots.took.cpu_s,
            wall_s: shots.took.wall_s,
            tables_cpu_s: shots.tables_cpu_s,
            bytes: shots.bytes,
            pareto: false,
            value,
        }
    }

    /// Difference from the reference. Where noise counts, each picture alone stands against both references, whose noise
    /// is all that is taken off; the mean of both is their error.
    fn error(&self, shots: &Shots, knob: Option<Knob>) -> Option<Difference> {
        let noise_counts = knob.is_some_and(Knob::has_noise);
        let [a1, a2] = &shots.pictures[..] else { return None };
        let (reference, variance) = match self.external {
            Some(external) => ([&external.pixels, &external.pixels], external.variance),
            None => {
                let other = match knob {
                    Some(Knob::Spp) => &self.long,
                    Some(Knob::Target) => &self.sharp,
                    _ => &None,
                };
                let shots = other.as_ref().unwrap_or(&self.base);
                ([shots.pictures.first()?, shots.pictures.get(1)?], 0.0)
            }
        };
        let both = Difference::of([a1, a2], reference, variance)?;
        if !noise_counts {
            return Some(both);
        }
        let each = [a1, a2].map(|a| Difference::of([a, a], reference, variance));
        let [Some(first), Some(second)] = each else { return None };
        Some(Difference {
            square: 0.5 * (first.square + second.square),
            square_error: 0.5 * first.square_error.hypot(second.square_error),
            ..both
        })
    }
}

impl Setting {
    /// The knob that is set.
    pub fn knob(&self) -> Knob {
        match self {
            Self::Spp(_) => Knob::Spp,
            Self::Bands(_) => Knob::Bands,
            Self::SizeBins(_) => Knob::SizeBins,
            Self::AngleTolerance(_) => Knob::AngleTolerance,
            Self::PeakTruncation(_) => Knob::PeakTruncation,
            Self::SizeParameterCap(_) => Knob::SizeParameterCap,
            Self::MarchStep(_) => Knob::MarchStep,
            Self::GlowTolerance(_) => Knob::GlowTolerance,
            Self::Order(_) => Knob::Order,
            Self::Phase(_) => Knob::Phase,
            Self::Target(_) => Knob::Target,
        }
    }
}

/// Marks the rows that no other row beats in both time and error.
fn mark_front(rows: &mut [Row]) {
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (row.cpu_s, row.total)).collect();
    for row in rows {
        let beats = |(cpu_s, total): &(f64, f64)| {
            *cpu_s <= row.cpu_s && *total <= row.total && (*cpu_s < row.cpu_s || *total < row.total)
        };
        row.pareto = !points.iter().any(beats);
    }
}

#[cfg(test)]
pub(super) fn test_row(setting: Setting, error: f64, noise: f64, cpu_s: f64) -> Row {
    Row {
        knob: setting.knob().name(),
        setting: setting.label(),
        flag: setting.flag(),
        error: Difference { square: error * error, ..Difference::default() },
        noise,
        total: error.hypot(noise),
        spp: 64,
        cpu_s,
        wall_s: cpu_s,
        tables_cpu_s: 0.0,
        bytes: 0,
        pareto: false,
        value: Some(setting),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let mut rows = [(0.1, 4.0), (0.2, 2.0), (0.3, 3.0), (0.4, 1.0), (0.4, 1.5)]
            .map(|(cpu_s, error)| test_row(Setting::Bands(8), error, 0.0, cpu_s));
        mark_front(&mut rows);
        assert_eq!(rows.map(|row| row.pareto), [true, true, false, true, false]);
    }
}
