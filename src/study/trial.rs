//! One scene with given settings, rendered once or twice for a measurement: the pictures, their noise, what they cost.

use std::collections::BTreeMap;
use std::path::Path;

use super::clock::{Clock, Took};
use super::difference::Pixels;
use crate::film::develop;
use crate::plan::{self, EffectPlan};
use crate::scene::model::Scene;
use crate::scene::settings::{Effect, Switch};
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::transport::{PrepareError, Prepared, Rates, RenderRequest, SilentProgress, Spectral, Stage, Until, render};

/// The picture's target where neither flag nor scene sets one: accuracy `standard`.
pub const STANDARD_TARGET: f64 = 0.05;

/// Sampling to an accuracy ends here, whatever the noise.
pub const MOST_SPP: u32 = 1 << 20;

/// Everything that decides about a picture but its samples.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The scene with its settings.
    pub scene: Scene,
    /// Effects that are switched by hand.
    pub choices: BTreeMap<Effect, Switch>,
    /// Most times that light is scattered by droplets.
    pub max_order: u32,
    /// How often estimators are asked; as is best for the scene unless given.
    pub rates: Option<Rates>,
}

/// Pictures of one trial with different seeds, and what one of them took.
#[derive(Clone, Debug)]
pub struct Shots {
    /// One picture per seed.
    pub pictures: Vec<Pixels>,
    /// Processor and wall time of the tree and one picture. Tables are kept between runs and are not in it.
    pub took: Took,
    /// Processor seconds of the tables; next to nothing where they were found in the cache.
    pub tables_cpu_s: f64,
    /// Bytes of tables, geometry and tree.
    pub bytes: usize,
    /// Size bins.
    pub size_bins: usize,
    /// Samples per pixel of one picture.
    pub spp: u32,
    /// Standard error, RMS over pixels and R, G, B, relative to the mean luminance, as the pictures record it.
    pub noise: f64,
}

impl Trial {
    /// A scene as it stands.
    pub fn new(scene: Scene, choices: BTreeMap<Effect, Switch>) -> Self {
        Self { scene, choices, max_order: u32::MAX, rates: None }
    }

    /// The same with every estimator asked once per sample.
    pub fn evenly_asked(&self) -> Self {
        Self { rates: Some(Rates::EVEN), ..self.clone() }
    }

    /// The target relative error of the picture.
    pub fn target(&self) -> f64 {
        self.scene.settings.accuracy.target.unwrap_or(STANDARD_TARGET)
    }

    /// How the spectrum is sampled.
    pub fn mode(&self) -> SpectralMode {
        self.scene.settings.spectral_mode.unwrap_or(SpectralMode::Bands { count: plan::bands_for(self.target()) })
    }

    fn sampling(&self) -> SpectralSampling {
        SpectralSampling::new(self.mode(), self.scene.settings.sun.spectrum)
    }

    /// What is simulated.
    pub fn plan(&self) -> EffectPlan {
        plan::plan(&self.scene, &self.choices, self.target(), self.sampling().wavelengths_m.len())
    }

    /// Whether somebody switched an effect on or off. `atmosphere.sunlight` is a switch of the airlight.
    pub fn is_by_hand(&self, effect: Effect) -> bool {
        if effect == Effect::Airlight && !self.scene.settings.atmosphere.sunlight {
            return true;
        }
        let switch = self.choices.get(&effect).or_else(|| self.scene.settings.effects.get(&effect));
        switch.is_some_and(|switch| *switch != Switch::Auto)
    }

    /// The same with every effect switched as `state` says.
    pub fn with_effects(&self, state: impl Fn(Effect) -> bool) -> Self {
        let switch = |effect| if state(effect) { Switch::On } else { Switch::Off };
        Self { choices: Effect::ALL.iter().map(|(effect, _)| (*effect, switch(*effect))).collect(), ..self.clone() }
    }

    /// Renders a picture for each seed; `cache` is a folder for optical tables.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    pub fn shoot(&self, seeds: &[u64], until: Until, cache: Option<&Path>) -> Result<Shots, PrepareError> {
        let scene = self.scene.clone();
        let (mut clock, mut tables_cpu_s) = (Clock::start(), 0.0);
        let mut prepared = Prepared::new(scene, &self.plan(), &self.sampling(), cache, &mut |stage| match stage {
            Stage::Tables => clock = Clock::start(),
            Stage::Bvh => {
                tables_cpu_s = clock.took().cpu_s;
                clock = Clock::start();
            }
            Stage::Ready => {}
        })?;
        prepared.max_order = self.max_order;
        prepared.rates = self.rates.unwrap_or(prepared.rates);
        let tree = clock.took();
        let clock = Clock::start();
        let outcomes: Vec<_> = seeds
            .iter()
            .map(|seed| render(&prepared.context(), &self.request(*seed, until), &SilentProgress))
            .collect();
        let (renders, n) = (clock.took(), seeds.len().max(1) as f64);
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / n;
        Ok(Shots {
            took: Took { cpu_s: tree.cpu_s + renders.cpu_s / n, wall_s: tree.wall_s + renders.wall_s / n },
            tables_cpu_s,
            bytes: prepared.counts.table_bytes + prepared.accel.geometry_bytes() + prepared.accel.tree_bytes(),
            size_bins: prepared.counts.size_bins,
            spp: mean(outcomes.iter().map(|o| f64::from(o.samples)).collect()).round() as u32,
            noise: mean(outcomes.iter().map(|o| o.film.noise().powi(2)).collect()).sqrt(),
            pictures: outcomes.iter().map(|o| Pixels::from_channels(&develop(&o.film, &[], 1.0))).collect(),
        })
    }

    fn request(&self, seed: u64, until: Until) -> RenderRequest {
        let [width, height] = self.scene.settings.image.resolution;
        RenderRequest { seed, until, crop: [0, 0, width, height], layers: Vec::new(), spectral: Spectral::Discard }
    }
}
