//! `mie-cloud bench effects`: what each effect costs and changes, and whether the plan was right about it.

use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;

use super::bench_args::{EffectsArgs, MeasureArgs};
use super::failure::Failure;
use super::limits::cache_folder;
use super::memory::MemoryLimit;
use super::progress::Verbosity;
use super::render::in_thread_pool;
use super::scene::{load_scene, print_warnings};
use super::wrapped::beside;
use crate::image::file::{Existing, check_writable, write_atomically};
use crate::spectrum::SpectralSampling;
use crate::study::difference::Difference;
use crate::study::effects::{Race, Report, Row, Setup, measure};
use crate::study::trial::Trial;
use crate::transport::need::{Held, Need};
use crate::transport::{RenderRequest, Spectral, Until};
use crate::units::short;

/// Runs `bench effects`.
pub fn run(args: &EffectsArgs) -> Result<u8, Failure> {
    in_thread_pool(args.measure.threads, || run_here(args))?
}

fn run_here(args: &EffectsArgs) -> Result<u8, Failure> {
    let EffectsArgs { measure: args, repeat, to_target } = args;
    check_outputs([&args.csv, &args.json])?;
    let trial = trial(args)?;
    let cache = if args.no_cache { None } else { cache_folder() };
    let setup =
        Setup { spp: args.spp, seed: args.seed, cache: cache.as_deref(), repeat: *repeat, to_target: *to_target };
    let mut out = std::io::stdout().lock();
    let mut printed = writeln!(out, "{}", line(&TITLES.map(String::from)));
    let report = measure(&trial, &setup, &mut |row| {
        let said = writeln!(out, "{}", line(&cells(row))).and_then(|()| out.flush());
        if printed.is_ok() {
            printed = said;
        }
    })
    .map_err(|error| Failure::scene(anyhow::Error::new(error).context(args.scene.scene.display().to_string())))?;
    printed.and_then(|()| print_summary(&report, &mut out)).map_err(Failure::other)?;
    if let Some(path) = &args.csv {
        write_atomically(path, Existing::Replace, |out| write_csv(&report, out)).map_err(Failure::other)?;
    }
    write_json(&args.json, &report)?;
    Ok(0)
}

/// The scene as the arguments have it.
pub fn trial(args: &MeasureArgs) -> Result<Trial, Failure> {
    let effects = args.scene.effects.as_deref().map_or(Ok(Default::default()), super::effects::parse);
    let effects = effects.map_err(Failure::usage)?;
    let mut scene = load_scene(&args.scene, Some(args.resolution))?;
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

/// Outputs are checked before any work is done.
pub fn check_outputs<'a>(paths: impl IntoIterator<Item = &'a Option<PathBuf>>) -> Result<(), Failure> {
    let mut checks = paths.into_iter().flatten().map(|path| check_writable(path, Existing::Replace));
    checks.try_for_each(|check| check.map_err(Failure::other))
}

/// Writes a report as JSON, where a file is named.
pub fn write_json(path: &Option<PathBuf>, report: &impl Serialize) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(report).map_err(Failure::other)?;
    write_atomically(path, Existing::Replace, |out| writeln!(out, "{text}")).map_err(Failure::other)
}

const TITLES: [&str; 8] = ["effect", "plan", "estimate", "change", "CPU s on", "CPU s off", "time (told)", "verdict"];
const WIDTHS: [usize; 8] = [12, 4, 9, 20, 9, 9, 11, 17];

fn line(cells: &[String; 8]) -> String {
    let [name, numbers @ .., verdict] = cells;
    let numbers: Vec<String> = numbers.iter().zip(&WIDTHS[1..]).map(|(cell, w)| format!("{cell:>w$}")).collect();
    format!("{name:<12}  {}  {verdict}", numbers.join("  "))
}

fn cells(row: &Row) -> [String; 8] {
    let estimate = row.estimate.map_or("none".into(), short::percent);
    let beyond = if row.within_estimate == Some(false) { ", beyond the estimate" } else { "" };
    [
        row.effect.into(),
        if row.planned { "on" } else { "off" }.into(),
        estimate,
        row.change.as_ref().map_or("no picture".into(), percent),
        format!("{:.3}", row.cpu_on_s),
        format!("{:.3}", row.cpu_off_s),
        time_shares(row),
        format!("{}{beyond}", row.verdict),
    ]
}

/// Share of the time that it took, and that was told, percent.
fn time_shares(row: &Row) -> String {
    match (row.time_share, row.predicted_share) {
        (Some(took), Some(told)) => format!("{:.0} ({:.0}) %", 100.0 * took.max(0.0), 100.0 * told),
        _ => String::new(),
    }
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

fn print_summary(report: &Report, out: &mut impl Write) -> std::io::Result<()> {
    let change = format!(
        "RMS over pixels and R, G, B, relative to the mean luminance, without the noise of two renders of {} samples ({:.2} % each)",
        report.spp,
        100.0 * report.noise
    );
    let cpu = "processor seconds of tree and one picture, without tables";
    let time = "share of the processor time that the effect takes, every estimator asked once per sample, and that the plan told";
    let (faint, target) = (short::percent(report.threshold), short::percent(report.target));
    let plan = format!("leaves out what changes less than {faint}, a tenth of the target of {target}");
    let notes = [("change  ", change.as_str()), ("CPU s   ", cpu), ("time    ", time), ("plan    ", &plan)];
    let notes: String = notes.iter().map(|(label, note)| beside(label, note)).collect();
    write!(out, "\n{notes}")?;
    let Some(everything) = &report.everything else {
        return writeln!(out, "the picture is black");
    };
    let held = if everything.at_most() <= report.target {
        "within the target"
    } else if everything.at_least() > report.target {
        "BEYOND the target"
    } else {
        "too noisy to tell"
    };
    writeln!(
        out,
        "the plan's picture against everything on: {}, {held}, in {} of the processor time",
        percent(everything),
        ratio(&report.same_samples)
    )?;
    let Some(race) = &report.to_target else { return Ok(()) };
    writeln!(
        out,
        "until the noise is {}: {} of the processor time; {:.3} CPU s and {} spp, everything on {:.3} CPU s and {} spp",
        short::percent(report.target),
        ratio(race),
        race.planned_s.median,
        race.planned_spp,
        race.everything_s.median,
        race.everything_spp
    )
}

/// A ratio of times with its spread over the turns.
fn ratio(race: &Race) -> String {
    format!("{:.2} ({:.2} to {:.2})", race.ratio.median, race.ratio.least, race.ratio.greatest)
}

fn write_csv(report: &Report, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(
        out,
        "effect,planned,estimate,change,change_error,bias,bias_error,cpu_on_s,cpu_off_s,wall_on_s,wall_off_s,verdict,within_estimate,\
         time_share,predicted_share"
    )?;
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.6e}"));
    for row in &report.rows {
        let of = |value: &dyn Fn(&Difference) -> f64| number(row.change.as_ref().map(value));
        writeln!(
            out,
            "{},{},{},{},{},{},{},{:.4},{:.4},{:.4},{:.4},{},{},{},{}",
            row.effect,
            if row.planned { "on" } else { "off" },
            number(row.estimate),
            of(&Difference::rms),
            of(&Difference::rms_error),
            of(&|d| d.bias),
            of(&|d| d.bias_error),
            row.cpu_on_s,
            row.cpu_off_s,
            row.wall_on_s,
            row.wall_off_s,
            row.verdict,
            row.within_estimate.map_or("", |within| if within { "yes" } else { "no" }),
            number(row.time_share),
            number(row.predicted_share),
        )?;
    }
    Ok(())
}
