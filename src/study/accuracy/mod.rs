//! What accuracy costs: every knob that matters in a scene from coarse to fine against the finest settings, which settings
//! no other beats, and the cheapest ones for an error.
//!
//! The reference is rendered twice with independent seeds. A knob's settings are rendered with the same two seeds, so that
//! what both have in common cancels and the two differences stay independent (`study/difference.rs`): that is the
//! knob's own error, without noise. To the error of samples and targets noise belongs: two pictures with other seeds tell how much,
//! and its square adds to that of what the settings themselves do.

mod knobs;
mod price;

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use super::difference::{Difference, Noise, Pixels};
use super::machine::Machine;
use super::trial::{MOST_SPP, Shots, Trial};
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

/// A knob at one setting, measured.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The knob.
    pub knob: &'static str,
    /// Its setting in short.
    pub setting: String,
    /// The flag of `render` that sets it.
    pub flag: String,
    /// Difference from the reference: for `spp` and `target` with the noise of one picture, for the others without.
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
    let mut finest = bench.row(None, &bench.base)?;
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
            let row = bench.row(Some(setting), &shots)?;
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
    /// The reference.
    base: Shots,
}

impl<'a> Bench<'a> {
    fn new(
        trial: &'a Trial,
        knobs: &BTreeSet<Knob>,
        external: Option<&'a External>,
        setup: &'a Setup,
    ) -> Result<Self, PrepareError> {
        let finest = knobs::finest(trial, knobs);
        let seeds = [setup.seed, setup.seed.wrapping_add(1)];
        // The first render warms caches up; the others are timed.
        finest.shoot(&seeds[..1], Until::Samples(1), setup.cache)?;
        let base = finest.evenly_asked().shoot(&seeds, Until::Samples(setup.spp), setup.cache)?;
        Ok(Self { trial, finest, external, setup, base })
    }

    /// Pictures of a setting: with other seeds where their noise counts, else with those of the reference.
    fn shoot(&self, setting: &Setting) -> Result<Shots, PrepareError> {
        let other = [2, 3].map(|k| self.setup.seed.wrapping_add(k));
        match setting {
            Setting::Spp(n) => self.finest.shoot(&other, Until::Samples(*n), self.setup.cache),
            Setting::Target(target) => {
                let until = Until::Noise { target: *target, at_most: MOST_SPP };
                knobs::asked(self.trial, *target).shoot(&other, until, self.setup.cache)
            }
            _ => self.shoot_as_the_reference(&setting.apply(&self.finest)),
        }
    }

    /// Pictures with the seeds and samples of the reference.
    fn shoot_as_the_reference(&self, trial: &Trial) -> Result<Shots, PrepareError> {
        let seeds = [0, 1].map(|k| self.setup.seed.wrapping_add(k));
        trial.evenly_asked().shoot(&seeds, Until::Samples(self.setup.spp), self.setup.cache)
    }

    fn row(&self, value: Option<Setting>, shots: &Shots) -> Result<Row, PrepareError> {
        let noise = match &shots.pictures[..] {
            [a, b] => Noise::between(a, b),
            _ => Noise::default(),
        };
        let noise_counts = value.as_ref().is_some_and(|value| value.knob().has_noise());
        let error = match &value {
            Some(value) => self.error(value, shots, noise)?.unwrap_or_default(),
            None => Difference::default(),
        };
        Ok(Row {
            knob: value.as_ref().map_or("", |value| value.knob().name()),
            setting: value.as_ref().map_or("all".into(), Setting::label),
            flag: value.as_ref().map_or_else(String::new, Setting::flag),
            error,
            noise: noise.rms(),
            total: if noise_counts { error.rms().max(noise.rms()) } else { error.rms().hypot(noise.rms()) },
            spp: shots.spp,
            cpu_s: shots.took.cpu_s,
            wall_s: shots.took.wall_s,
            tables_cpu_s: shots.tables_cpu_s,
            bytes: shots.bytes,
            pareto: false,
            value,
        })
    }

    /// Difference from the reference, `None` where that is black. The noise of samples and targets is known from their own two
    /// pictures, whatever the reference's: it is added to what the settings do, which samples alone do nothing to.
    fn error(&self, value: &Setting, shots: &Shots, noise: Noise) -> Result<Option<Difference>, PrepareError> {
        let own = || self.difference(&shots.pictures);
        Ok(match (value, self.external) {
            (Setting::Spp(_) | Setting::Target(_), Some(external)) => match &shots.pictures[..] {
                [a1, a2] => Difference::with_noise_from([a1, a2], &external.pixels, external.variance),
                _ => None,
            },
            (Setting::Spp(_), None) => {
                own().map(|all| Difference { square: 0.0, square_error: 0.0, ..all }.with(noise))
            }
            (Setting::Target(target), None) => {
                let alike = self.shoot_as_the_reference(&knobs::asked(self.trial, *target))?;
                self.difference(&alike.pictures).map(|own| own.with(noise))
            }
            _ => own(),
        })
    }

    /// What two pictures differ by from the reference, without noise.
    fn difference(&self, pictures: &[Pixels]) -> Option<Difference> {
        let ([a1, a2], [b1, b2]) = (pictures, &self.base.pictures[..]) else { return None };
        match self.external {
            Some(external) => Difference::of([a1, a2], [&external.pixels; 2], external.variance),
            None => Difference::of([a1, a2], [b1, b2], 0.0),
        }
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
