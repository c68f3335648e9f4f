//! What the measurements of `bench` have in common: the scene that is measured, its memory, files, and how differences are written.

use std::path::PathBuf;

use serde::Serialize;

use super::bench_args::MeasureArgs;
use super::claims::Outputs;
use super::failure::Failure;
use super::memory::MemoryLimit;
use super::progress::Verbosity;
use super::scene::{load_scene, print_warnings};
use crate::image::file::{Existing, write_atomically};
use crate::spectrum::SpectralSampling;
use crate::study::difference::Difference;
use crate::study::trial::Trial;
use crate::transport::need::{Held, Need};
use crate::transport::{RenderRequest, Spectral, Until};

/// The scene as the arguments have it, none of whose files is an output.
pub fn trial(args: &MeasureArgs, outputs: &Outputs) -> Result<Trial, Failure> {
    let effects = super::effects::chosen(args.scene.effects.as_deref())?;
    let mut scene = load_scene(&args.scene, Some(args.resolution))?;
    outputs.spare_files(&scene.files)?;
    print_warnings(&scene.warnings, Verbosity::Normal);
    if args.accuracy.is_some() {
        scene.settings.accuracy.target = args.accuracy;
    }
    let trial = Trial::new(scene, effects);
    MemoryLimit::new(args.scene.memory_limit).check(&trial_need(&trial, args))?;
    Ok(trial)
}

/// A render with a copy of the scene beside it, and the pictures that are compared.
fn trial_need(trial: &Trial, args: &MeasureArgs) -> Need {
    /// Reference, sums of squares, and two pictures of the setting that is measured, of three numbers a pixel.
    const PICTURES: u64 = 8;
    let [width, height] = args.resolution;
    let request = RenderRequest {
        seed: args.seed,
        until: Until::Samples(args.spp),
        crop: [0, 0, width, height],
        layers: Vec::new(),
        spectral: Spectral::Discard,
    };
    let sampling = SpectralSampling::new(trial.mode(), trial.scene.settings.sun.spectrum);
    let held = Held { n_channels: 0, n_copies: 1, n_threads: rayon::current_num_threads() };
    let mut need = Need::of_render(&trial.scene, &trial.plan(), &sampling, &request, held);
    let copy = (size_of_val(&trial.scene.particles[..]) + size_of_val(&trial.scene.fog_boxes[..])) as u64;
    need.add("a copy of the scene", copy, "use fewer droplets, or parcels that stand for many");
    let pictures = u64::from(width) * u64::from(height) * 24 * PICTURES;
    need.add("pictures to compare", pictures, "lower --resolution");
    need
}

/// Writes a report as JSON, where a file is named.
pub fn write_json(path: &Option<PathBuf>, report: &impl Serialize) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(report).map_err(Failure::other)?;
    write_atomically(path, Existing::Replace, |out| writeln!(out, "{text}")).map_err(Failure::other)
}

/// A difference with its error: `1.23 +- 0.04 %`; below its noise, what it is at most.
pub fn percent(difference: &Difference) -> String {
    if difference.square == 0.0 && difference.square_error == 0.0 {
        return "0 %".into();
    }
    if difference.at_least() > 0.0 {
        return format!("{} +- {} %", digits(difference.rms()), digits(difference.rms_error()));
    }
    format!("below {} %", digits(difference.at_most()))
}

/// A share in percent: three decimals, or two digits where these would be zeros.
fn digits(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 0.01 { format!("{percent:.3}") } else { format!("{percent:.1e}") }
}
