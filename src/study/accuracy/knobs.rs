//! The knobs that accuracy is bought with, their settings from coarse to fine, and the finest settings of all.

use std::collections::BTreeSet;
use std::str::FromStr;

use crate::optics::phase_model::PhaseModel;
use crate::plan::{EffectPlan, SceneFacts};
use crate::scene::settings::Effect;
use crate::spectrum::SpectralMode;
use crate::study::trial::Trial;
use crate::suggest::no_such;

/// Bands of the reference: those of accuracy `reference`.
const FINEST_BANDS: usize = 32;
/// Size bins of the reference per class: a third more than the program ever chooses by itself.
const FINEST_BINS: usize = 64;
/// Relative error of the reference's phase tables: the least that any target asks for.
const FINEST_ANGLE_TOLERANCE: f64 = 2e-4;
/// Relative error of the reference's glow: a twentieth of the finest row, and half of what a picture of 0.5 % takes.
const FINEST_GLOW_TOLERANCE: f64 = 5e-4;
/// Steps of the reference's march along the radius of the air.
const FINEST_STEPS: f64 = 256.0;
/// The reference's target, from which everything else follows that has no knob.
const FINEST_TARGET: f64 = 0.005;

/// Something that accuracy is bought with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Knob {
    /// Samples per pixel.
    Spp,
    /// Spectral bands.
    Bands,
    /// Size bins per class of droplets.
    SizeBins,
    /// Tolerance of phase tables.
    AngleTolerance,
    /// Angle below which scattering counts as none.
    PeakTruncation,
    /// Largest size parameter of phase tables.
    SizeParameterCap,
    /// Longest step of the march.
    MarchStep,
    /// Tolerance of the glow sum.
    GlowTolerance,
    /// Most times that light is scattered.
    Order,
    /// The phase function's model.
    Phase,
    /// The accuracy that is asked for: everything at once, as `render --accuracy` has it.
    Target,
}

impl Knob {
    /// All knobs with their names.
    pub const ALL: [(Knob, &'static str); 11] = [
        (Knob::Spp, "spp"),
        (Knob::Bands, "bands"),
        (Knob::SizeBins, "size_bins"),
        (Knob::AngleTolerance, "angle_tolerance"),
        (Knob::PeakTruncation, "peak_truncation"),
        (Knob::SizeParameterCap, "size_parameter_cap"),
        (Knob::MarchStep, "march_step"),
        (Knob::GlowTolerance, "glow_tolerance"),
        (Knob::Order, "order"),
        (Knob::Phase, "phase"),
        (Knob::Target, "target"),
    ];

    /// The name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(knob, _)| *knob == self).map_or("", |(_, name)| name)
    }

    /// Whether the error of its rows is a picture's whole error, noise included.
    pub fn has_noise(self) -> bool {
        matches!(self, Self::Spp | Self::Target)
    }
}

impl FromStr for Knob {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|(_, name)| *name == text.trim()).map(|(knob, _)| *knob);
        found.ok_or_else(|| no_such("knob", text, Self::ALL.map(|(_, name)| name)))
    }
}

/// A knob at one of its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    Spp(u32),
    Bands(usize),
    SizeBins(usize),
    AngleTolerance(f64),
    PeakTruncation(f64),
    SizeParameterCap(f64),
    MarchStep(f64),
    GlowTolerance(f64),
    Order(u32),
    Phase(PhaseModel),
    Target(f64),
}

impl Setting {
    /// The setting in short, with its unit.
    pub fn label(&self) -> String {
        match self {
            Self::Spp(n) | Self::Order(n) => n.to_string(),
            Self::Bands(n) | Self::SizeBins(n) => n.to_string(),
            Self::AngleTolerance(e) | Self::GlowTolerance(e) | Self::Target(e) => e.to_string(),
            Self::PeakTruncation(angle_deg) => format!("{angle_deg} deg"),
            Self::SizeParameterCap(x) => x.to_string(),
            Self::MarchStep(step_m) => format!("{} m", format!("{step_m:.2e}").parse().unwrap_or(*step_m)),
            Self::Phase(model) => model.to_string(),
        }
    }

    /// The flag of `render` that sets it.
    pub fn flag(&self) -> String {
        match self {
            Self::Spp(n) => format!("--spp {n}"),
            Self::Bands(n) => format!("--set spectral.mode=bands:{n}"),
            Self::SizeBins(n) => format!("--set droplets.size_bins={n}"),
            Self::AngleTolerance(e) => format!("--set accuracy.angle_tolerance={e}"),
            Self::PeakTruncation(angle_deg) => format!("--set accuracy.peak_truncation_deg={angle_deg}"),
            Self::SizeParameterCap(x) => format!("--set accuracy.size_parameter_cap={x}"),
            Self::MarchStep(step_m) => format!("--set atmosphere.step_m={step_m:.3e}"),
            Self::GlowTolerance(e) => format!("--set accuracy.glow_tolerance={e}"),
            Self::Order(n) => format!("--order {n}"),
            Self::Phase(model) => format!("--set droplets.phase={model}"),
            Self::Target(e) => format!("--accuracy {e}"),
        }
    }

    /// A trial with this setting; samples and targets are not part of a trial.
    pub fn apply(&self, finest: &Trial) -> Trial {
        let mut trial = finest.clone();
        let settings = &mut trial.scene.settings;
        match self {
            Self::Spp(_) | Self::Target(_) => {}
            Self::Bands(count) => settings.spectral_mode = Some(SpectralMode::Bands { count: *count }),
            Self::SizeBins(n) => settings.droplets.size_bins = Some(*n),
            Self::AngleTolerance(tolerance) => settings.accuracy.angle_tolerance = Some(*tolerance),
            Self::PeakTruncation(angle_deg) => settings.accuracy.peak_truncation_deg = *angle_deg,
            Self::SizeParameterCap(x) => settings.accuracy.size_parameter_cap = *x,
            Self::MarchStep(step_m) => settings.atmosphere.step_m = *step_m,
            Self::GlowTolerance(tolerance) => settings.accuracy.glow_tolerance = Some(*tolerance),
            Self::Order(n) => trial.max_order = *n,
            Self::Phase(model) => {
                trial.scene.classes.iter_mut().for_each(|class| class.phase = model.clone());
            }
        }
        trial
    }

    /// The settings of a knob from coarse to fine, where it matters: `finest` is the reference's trial, `plan` its plan,
    /// `n_bins` its number of size bins, `spp` its samples.
    pub fn sweep(knob: Knob, finest: &Trial, plan: &EffectPlan, n_bins: usize, spp: u32) -> Vec<Self> {
        let scene = &finest.scene;
        let air = &scene.settings.atmosphere;
        let has_droplets = !scene.particles.is_empty() || !scene.fog_boxes.is_empty();
        let is_mie = has_droplets && scene.classes.iter().any(|class| class.phase == PhaseModel::Mie);
        let in_bands = matches!(finest.mode(), SpectralMode::Bands { .. });
        let marches = air.scattering_per_m > 0.0 && (plan.is_on(Effect::Airlight) || plan.is_on(Effect::Glow));
        let tolerances = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01];
        match knob {
            Knob::Spp => [1, 2, 4, 8, 16, 32, 64, 128, 256].into_iter().filter(|n| *n <= spp).map(Self::Spp).collect(),
            Knob::Bands if in_bands => [1, 2, 3, 4, 6, 8, 12, 16].map(Self::Bands).into(),
            Knob::SizeBins if n_bins > scene.classes.len() => {
                [1, 2, 4, 8, 16, 32].into_iter().filter(|n| *n < n_bins).map(Self::SizeBins).collect()
            }
            Knob::AngleTolerance if is_mie => tolerances.map(Self::AngleTolerance).into(),
            Knob::PeakTruncation if is_mie => [10.0, 5.0, 2.0, 1.0, 0.5, 0.2].map(Self::PeakTruncation).into(),
            Knob::SizeParameterCap if is_mie => {
                let largest = SceneFacts::of(scene).largest_size_parameter;
                let caps = [10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4];
                caps.into_iter().filter(|x| *x < largest).map(Self::SizeParameterCap).collect()
            }
            Knob::MarchStep if marches => [1.0, 4.0, 16.0, 64.0].map(|n| Self::MarchStep(air.depth_m / n)).into(),
            Knob::GlowTolerance if plan.is_on(Effect::Glow) && air.scattering_per_m > 0.0 => {
                tolerances.map(Self::GlowTolerance).into()
            }
            Knob::Order if has_droplets && plan.is_on(Effect::Multiple) => [1, 2, 4, 8, 16].map(Self::Order).into(),
            Knob::Phase if is_mie => {
                let models = [PhaseModel::Isotropic, PhaseModel::HenyeyGreenstein { g: None }, PhaseModel::HgDraine];
                models.map(Self::Phase).into()
            }
            _ => Vec::new(),
        }
    }
}

/// The finest settings of a scene, with everything simulated that could change anything and that nobody switched off: effects whose
/// estimate is 0 would take random numbers, and hide differences behind noise. The march is in finest steps where these are asked
/// about; elsewhere in the scene's own, which are noise and never a bias.
pub fn finest(trial: &Trial, knobs: &BTreeSet<Knob>) -> Trial {
    let plan = trial.plan();
    let could_change = |effect| plan.decisions.iter().any(|made| made.effect == effect && made.estimate != Some(0.0));
    let mut finest =
        trial.with_effects(|effect| plan.is_on(effect) || (could_change(effect) && !trial.is_by_hand(effect)));
    let mode = trial.mode();
    let settings = &mut finest.scene.settings;
    settings.accuracy.target = Some(FINEST_TARGET);
    settings.accuracy.angle_tolerance = Some(FINEST_ANGLE_TOLERANCE);
    settings.accuracy.glow_tolerance = Some(FINEST_GLOW_TOLERANCE);
    settings.accuracy.peak_truncation_deg = 0.0;
    settings.droplets.size_bins = Some(FINEST_BINS);
    if knobs.contains(&Knob::MarchStep) {
        settings.atmosphere.step_m = settings.atmosphere.step_m.min(settings.atmosphere.depth_m / FINEST_STEPS);
    }
    settings.spectral_mode = Some(match mode {
        SpectralMode::Bands { count } => SpectralMode::Bands { count: count.max(FINEST_BANDS) },
        other => other,
    });
    finest
}

/// The flags of `render` that give the finest settings.
pub fn flags(finest: &Trial) -> String {
    let settings = &finest.scene.settings;
    format!(
        "--accuracy {FINEST_TARGET} --set spectral.mode={} --set accuracy.angle_tolerance={FINEST_ANGLE_TOLERANCE} --set \
         accuracy.glow_tolerance={FINEST_GLOW_TOLERANCE} --set droplets.size_bins={FINEST_BINS} --set atmosphere.step_m={:.3e}",
        finest.mode(),
        settings.atmosphere.step_m
    )
}

/// The scene as `render --accuracy TARGET` takes it.
pub fn asked(trial: &Trial, target: f64) -> Trial {
    let mut asked = trial.clone();
    asked.scene.settings.accuracy.target = Some(target);
    asked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_is_read_by_its_name_and_slips_are_pointed_out() {
        for (knob, name) in Knob::ALL {
            assert_eq!((name.parse(), knob.name()), (Ok(knob), name));
        }
        let said = "size_bin".parse::<Knob>().unwrap_err();
        assert!(said.contains("size_bins") && said.contains("march_step"), "{said}");
    }
}
