//! Arguments of `bench effects` and `bench accuracy`.

use std::path::PathBuf;

use clap::Args;

use super::args::SceneArgs;
use super::values::{MOST_THREADS, file_as, parse_accuracy, parse_resolution};
use crate::study::accuracy::Knob;

/// How measurements on a scene are made, and where they are written.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Target relative error of the picture: draft, standard, fine, reference or a number [default: the scene's, or standard]
    #[arg(long, value_name = "LEVEL", value_parser = parse_accuracy)]
    pub accuracy: Option<f64>,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "64x36", value_parser = parse_resolution)]
    pub resolution: [u32; 2],
    /// Samples per pixel of each of the two renders that every picture is made of
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..))]
    pub spp: u32,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Writes the table as CSV
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Writes the table and the summary as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Threads [default: one per processor]; the pictures do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub threads: Option<u16>,
    /// Neither reads nor writes the table cache
    #[arg(long)]
    pub no_cache: bool,
}

#[derive(Debug, Args)]
pub struct EffectsArgs {
    #[command(flatten)]
    pub measure: MeasureArgs,
    /// Times that the planned picture and the one with everything on are rendered in turns, to compare their times
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub repeat: u32,
    /// Compares their times also until the noise is at the target
    #[arg(long)]
    pub to_target: bool,
}

#[derive(Debug, Args)]
pub struct AccuracyArgs {
    #[command(flatten)]
    pub measure: MeasureArgs,
    /// Knobs, separated by commas: spp, bands, size_bins, angle_tolerance, peak_truncation,
    /// size_parameter_cap, march_step, glow_tolerance, order, phase, target
    /// [default: all that matter in the scene]
    ///
    /// The knob `phase` changes all droplets; the flag `--set droplets.phase=` that stands for it in the table does not reach meshes
    /// with a `phase` of their own.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub knobs: Vec<Knob>,
    /// Targets of the knob `target`, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_accuracy, default_value = "0.1,0.05,0.02")]
    pub targets: Vec<f64>,
    /// OpenEXR picture to compare with [default: a render at the finest settings]
    #[arg(long, value_name = "FILE.exr")]
    pub reference: Option<PathBuf>,
    /// Draws error over time, one line per knob
    #[arg(long, value_name = "FILE.svg", value_parser = file_as("svg"))]
    pub plot: Option<PathBuf>,
}
