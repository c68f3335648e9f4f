//! `mie-cloud bench accuracy`: what every knob costs and gains, and the cheapest settings for an error.

use std::collections::BTreeSet;
use std::io::Write;

use super::bench_args::AccuracyArgs;
use super::claims::Outputs;
use super::failure::Failure;
use super::limits::cache_folder;
use super::measured::{percent, trial, write_json};
use super::progress::Verbosity;
use super::render::in_thread_pool;
use super::scene::print_warnings;
use super::wrapped::beside;
use crate::image::exr;
use crate::image::file::{Existing, write_atomically};
use crate::study::accuracy::{External, Knob, Report, Row, Setup, TARGETS, measure};
use crate::study::difference::Pixels;
use crate::study::plot::{Line, Point, price_plot};
use crate::warning::Warning;

/// Runs `bench accuracy`.
pub fn run(args: &AccuracyArgs) -> Result<u8, Failure> {
    in_thread_pool(args.measure.threads, || run_here(args))?
}

fn run_here(args: &AccuracyArgs) -> Result<u8, Failure> {
    let files = [("--csv", &args.measure.csv), ("--json", &args.measure.json), ("--plot", &args.plot)];
    let outputs = Outputs::new(files.map(|(flag, path)| (flag, path.as_ref())));
    outputs.spare_scene(&args.measure.scene.scene)?;
    outputs.spare("is the reference", &args.reference)?;
    outputs.check(Existing::Replace)?;
    let external = external(args)?;
    let trial = trial(&args.measure, &outputs)?;
    let cache = if args.measure.no_cache { None } else { cache_folder() };
    let setup =
        Setup { spp: args.measure.spp, seed: args.measure.seed, cache: cache.as_deref(), targets: &args.targets };
    let knobs: BTreeSet<Knob> = args.knobs.iter().copied().collect();
    let knobs = if knobs.is_empty() { Knob::ALL.iter().map(|(knob, _)| *knob).collect() } else { knobs };
    let mut out = std::io::stdout().lock();
    let mut printed = writeln!(out, "{}", line(&TITLES.map(String::from)));
    let report = measure(&trial, &knobs, external.as_ref(), &setup, &mut |row| {
        let said = writeln!(out, "{}", line(&cells(row))).and_then(|()| out.flush());
        if printed.is_ok() {
            printed = said;
        }
    })
    .map_err(|error| {
        Failure::scene(anyhow::Error::new(error).context(args.measure.scene.scene.display().to_string()))
    })?;
    let printed = printed.and_then(|()| print_summary(&report, &mut out));
    // Files are written even where nobody reads the table.
    if let Some(path) = &args.measure.csv {
        write_atomically(path, Existing::Replace, |out| write_csv(&report, out)).map_err(Failure::other)?;
    }
    write_json(&args.measure.json, &report)?;
    if let Some(path) = &args.plot {
        let svg = plot(&report, &trial.scene.name).map_err(Failure::other)?;
        write_atomically(path, Existing::Replace, |out| out.write_all(svg.as_bytes())).map_err(Failure::other)?;
    }
    printed.map_err(Failure::other)?;
    Ok(0)
}

/// The picture of `--reference`; its size is that of all pictures.
fn external(args: &AccuracyArgs) -> Result<Option<External>, Failure> {
    let Some(path) = &args.reference else { return Ok(None) };
    let picture = exr::read(path, exr::Limits::default()).map_err(Failure::other)?;
    let [width, height] = args.measure.resolution;
    if [picture.width, picture.height] != [width, height] {
        let (w, h) = (picture.width, picture.height);
        return Err(Failure::usage(anyhow::anyhow!(
            "--reference {} is {w}x{h} pixels, the pictures are {width}x{height}; add --resolution {w}x{h}",
            path.display()
        )));
    }
    let channels = |names: [&str; 3]| -> Option<Pixels> {
        let [r, g, b] = [picture.channel(names[0])?, picture.channel(names[1])?, picture.channel(names[2])?];
        let rows = r.iter().zip(g).zip(b);
        Some(Pixels(rows.map(|((r, g), b)| [r, g, b].map(|value| f64::from(*value))).collect()))
    };
    let pixels = channels(["R", "G", "B"]).ok_or_else(|| {
        Failure::other(anyhow::anyhow!("{}: has no channels R, G, B, which a reference needs", path.display()))
    })?;
    if let Some(i) = pixels.0.iter().position(|rgb| !rgb.iter().all(|value| value.is_finite())) {
        let (x, y) = (i % width as usize, i / width as usize);
        return Err(Failure::other(anyhow::anyhow!(
            "{}: the pixel ({x}, {y}) is not finite, and nothing can be compared with that; render the reference anew",
            path.display()
        )));
    }
    let mean = pixels.mean_luminance();
    let errors = channels(["stderr.R", "stderr.G", "stderr.B"]);
    if errors.is_none() {
        let problem = format!("{}: records no standard errors, so its noise counts as error", path.display());
        print_warnings(&[Warning::new(problem, "render it with --aov stderr")], Verbosity::Normal);
    }
    let squares = |errors: Pixels| errors.0.iter().flatten().map(|e| e * e).sum::<f64>() / (3 * errors.0.len()) as f64;
    let variance = errors.filter(|_| mean > 0.0).map_or(0.0, |errors| squares(errors) / (mean * mean));
    Ok(Some(External { name: path.display().to_string(), pixels, variance }))
}

const TITLES: [&str; 9] = ["knob", "setting", "error", "mean bias", "noise", "spp", "CPU s", "tables s", "MiB"];
const WIDTHS: [usize; 9] = [15, 12, 20, 18, 9, 6, 9, 8, 7];

fn line(cells: &[String; 9]) -> String {
    let [knob, setting, rest @ ..] = cells;
    let rest: Vec<String> = rest.iter().zip(&WIDTHS[2..]).map(|(cell, w)| format!("{cell:>w$}")).collect();
    format!("{knob:<15} {setting:<12} {}", rest.join(" "))
}

fn cells(row: &Row) -> [String; 9] {
    [
        row.knob.into(),
        row.setting.clone(),
        percent(&row.error),
        format!("{:+.3} +- {:.3} %", 100.0 * row.error.bias, 100.0 * row.error.bias_error),
        format!("{:.2} %", 100.0 * row.noise),
        row.spp.to_string(),
        format!("{:.3}", row.cpu_s),
        format!("{:.3}", row.tables_cpu_s),
        format!("{:.1}", row.bytes as f64 / f64::from(1 << 20)),
    ]
}

fn print_summary(report: &Report, out: &mut impl Write) -> std::io::Result<()> {
    let [width, height] = report.resolution;
    writeln!(out, "\n{width}x{height} against {}", report.reference)?;
    let error = "RMS over pixels and R, G, B, relative to the mean luminance, with the picture's noise for spp and target (from two \
                 renders with seeds of their own), without it for the other knobs (two renders with the reference's seeds)";
    let cpu = "processor seconds of tree and one picture, tables apart";
    write!(out, "{}{}", beside("error   ", error), beside("CPU s   ", cpu))?;
    if !report.without_effect.is_empty() {
        writeln!(out, "without effect in this scene: {}", report.without_effect.join(", "))?;
    }
    for row in report.rows.iter().filter(|row| row.pareto) {
        writeln!(
            out,
            "nothing faster is closer: {} {} ({:.2} % with noise, {:.3} CPU s)",
            row.knob,
            row.setting,
            100.0 * row.total,
            row.cpu_s
        )?;
    }
    for row in report.rows.iter().filter(|row| row.knob == Knob::Target.name()) {
        let asked: f64 = row.setting.parse().unwrap_or(f64::NAN);
        let kept = if row.error.at_most() <= 1.1 * asked {
            "kept"
        } else if row.error.at_least() > 1.1 * asked {
            "NOT kept"
        } else {
            "too noisy to tell"
        };
        writeln!(out, "asked for {:.1} %, got {}: {kept} to a tenth", 100.0 * asked, percent(&row.error))?;
    }
    writeln!(out, "the finest settings: {}", report.finest.flag)?;
    for price in &report.prices {
        let settings = if price.flags.is_empty() { "the finest of every knob".into() } else { price.flags.join(" ") };
        writeln!(
            out,
            "cheapest for {:.1} %: {settings} --spp {} (predicted: {:.2} %, {:.3} CPU s at this size)",
            100.0 * price.target,
            price.spp,
            100.0 * price.error,
            price.cpu_s
        )?;
    }
    Ok(())
}

fn write_csv(report: &Report, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(
        out,
        "knob,setting,error,error_error,bias,bias_error,noise,total,spp,cpu_s,wall_s,tables_cpu_s,bytes,pareto"
    )?;
    for row in std::iter::once(&report.finest).chain(&report.rows) {
        let e = &row.error;
        writeln!(
            out,
            "{},{},{:.6e},{:.6e},{:.6e},{:.6e},{:.6e},{:.6e},{},{:.4},{:.4},{:.4},{},{}",
            row.knob,
            row.setting,
            e.rms(),
            e.rms_error(),
            e.bias,
            e.bias_error,
            row.noise,
            row.total,
            row.spp,
            row.cpu_s,
            row.wall_s,
            row.tables_cpu_s,
            row.bytes,
            row.pareto
        )?;
    }
    Ok(())
}

fn plot(report: &Report, scene: &str) -> Result<String, crate::study::plot::PlotError> {
    let mut lines: Vec<Line> = Vec::new();
    for row in &report.rows {
        let is_measured = row.error.at_least() > 0.0;
        let error = if is_measured { row.error.rms() } else { row.error.at_most() };
        let point = Point { label: row.setting.clone(), cpu_s: row.cpu_s, error, is_measured };
        match lines.last_mut().filter(|line| line.name == row.knob) {
            Some(line) => line.points.push(point),
            None => lines.push(Line { name: row.knob.into(), points: vec![point] }),
        }
    }
    let [width, height] = report.resolution;
    let title = format!("What accuracy costs: {scene}, {width}x{height}");
    let numbers = format!(
        "against {}; {} samples per pixel; spp and target with the picture's noise, the other knobs' own error without it",
        report.reference, report.finest.spp
    );
    price_plot([&title, &numbers], &lines, &TARGETS)
}
