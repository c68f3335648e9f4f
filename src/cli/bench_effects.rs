//! `mie-cloud bench effects`: what each effect costs and changes, and whether the plan was right about it.

use std::io::Write;

use super::bench_args::EffectsArgs;
use super::claims::Outputs;
use super::failure::Failure;
use super::limits::cache_folder;
use super::measured::{percent, trial, write_json};
use super::render::in_thread_pool;
use super::wrapped::beside;
use crate::image::file::{Existing, write_atomically};
use crate::study::difference::Difference;
use crate::study::effects::{Race, Report, Row, Setup, measure};
use crate::units::short;

/// Runs `bench effects`.
pub fn run(args: &EffectsArgs) -> Result<u8, Failure> {
    in_thread_pool(args.measure.threads, || run_here(args))?
}

fn run_here(args: &EffectsArgs) -> Result<u8, Failure> {
    let EffectsArgs { measure: args, repeat, to_target } = args;
    let outputs = Outputs::new([("--csv", args.csv.as_ref()), ("--json", args.json.as_ref())]);
    outputs.spare_scene(&args.scene.scene)?;
    outputs.check(Existing::Replace)?;
    let trial = trial(args, &outputs)?;
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
    let printed = printed.and_then(|()| print_summary(&report, &mut out));
    // Files are written even where nobody reads the table.
    if let Some(path) = &args.csv {
        write_atomically(path, Existing::Replace, |out| write_csv(&report, out)).map_err(Failure::other)?;
    }
    write_json(&args.json, &report)?;
    printed.map_err(Failure::other)?;
    Ok(0)
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
