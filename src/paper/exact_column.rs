//! The exact column: a figure's scene through the ordinary program, with the effects that the plan finds.

use std::collections::BTreeMap;

use super::study::PaperError;
use crate::film::develop;
use crate::image::{Attribute, Picture};
use crate::plan::plan;
use crate::scene::model::Scene;
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::transport::{Prepared, RenderRequest, SilentProgress, Spectral, Until, render};

/// What the plan is made for: the program's standard.
const ACCURACY: f64 = 0.05;

/// Noise at which a picture is good enough to be looked at, and where sampling ends whatever the noise.
const NOISE: f64 = 0.02;
const MOST_SPP: u32 = 16;

/// Renders a scene. Returns the picture and the names of the effects that were simulated.
pub(super) fn draw(scene: Scene) -> Result<(Picture, Vec<&'static str>), PaperError> {
    let mode = scene.settings.spectral_mode.unwrap_or(SpectralMode::Rgb { wavelengths_m: wavelengths_m() });
    let sampling = SpectralSampling::new(mode, scene.settings.sun.spectrum);
    let plan = plan(&scene, &BTreeMap::new(), ACCURACY, sampling.wavelengths_m.len());
    let effects = plan.decisions.iter().filter(|decision| decision.on).map(|decision| decision.effect.name()).collect();
    let [width, height] = scene.settings.image.resolution;
    let request = RenderRequest {
        seed: 0,
        until: Until::Noise { target: NOISE, at_most: MOST_SPP },
        crop: [0, 0, width, height],
        layers: Vec::new(),
        spectral: Spectral::Discard,
    };
    let prepared = Prepared::new(scene, &plan, &sampling, None, &mut |_| {})?;
    let outcome = render(&prepared.context(), &request, &SilentProgress);
    let mut picture = Picture::new(width, height);
    picture.chromaticities = None;
    for channel in develop(&outcome.film, &[], 1.0) {
        picture.push(channel.name, channel.values);
    }
    picture.record("mieCloud:samples", Attribute::Int(outcome.samples as i32));
    Ok((picture, effects))
}

fn wavelengths_m() -> [f64; 3] {
    super::figures::WAVELENGTHS_NM.map(|nm| nm * 1e-9)
}
