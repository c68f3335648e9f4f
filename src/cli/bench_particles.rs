//! `mie-cloud bench particles`: every stage's time against the number of particles.

use std::io::{BufRead, IsTerminal, Write};
use std::path::Path;

use serde_json::json;

use super::args::BenchParticlesArgs;
use super::claims::Outputs;
use super::failure::Failure;
use super::limits::peak_rss_bytes;
use super::measured::write_json;
use super::memory::MemoryLimit;
use super::render::in_thread_pool;
use super::say::say;
use crate::image::file::{Existing, write_atomically};
use crate::study::machine::Machine;
use crate::study::particles::{Row, Run, Setup, Spread, columns, deviations, measure, resolution};
use crate::study::plot::{CountLine, Panel, PlotError, counts_plot};
use crate::transport::RayCounts;
use crate::transport::need::Need;
use crate::units::short::percent;

/// Counts that take more memory than this are asked for first, bytes.
const ASK_ABOVE_BYTES: u64 = 1 << 30;

/// Pictures whose means are further apart than this many standard errors are not the same.
const SAME_WITHIN: f64 = 4.0;

/// Runs `bench particles`.
pub fn run(args: &BenchParticlesArgs) -> Result<u8, Failure> {
    in_thread_pool(args.threads, || run_here(args))?
}

fn run_here(args: &BenchParticlesArgs) -> Result<u8, Failure> {
    let files = [("--csv", &args.csv), ("--json", &args.json), ("--plot", &args.plot)];
    Outputs::new(files.map(|(flag, path)| (flag, path.as_ref()))).check(Existing::Replace)?;
    // Counts that do not fit are refused before the first is measured, which may take long.
    let largest = args.counts.iter().copied().max().unwrap_or(0);
    MemoryLimit::new(args.memory_limit).check(&need(largest))?;
    let folder = std::env::temp_dir().join(format!("mie-cloud-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(Failure::other)?;
    let (setup, machine) = (Setup::default(), Machine::here());
    let measured = measure_all(args, &setup, &machine, &folder);
    let _ = std::fs::remove_dir_all(&folder);
    let Measured { rows, stopped, printed } = measured?;
    // Files are written even where nobody reads the table.
    if let Some(path) = &args.csv {
        write_atomically(path, Existing::Replace, |out| write_csv(&rows, out)).map_err(Failure::other)?;
    }
    let report = json!({
        "machine": machine, "setup": setup, "rows": rows, "stopped": stopped,
        "deviations": deviations(&rows),
        "columns": rows.iter().map(|row| columns(row).into_iter().map(|(name, value)| (name, json!(value))).collect::<serde_json::Map<_, _>>()).collect::<Vec<_>>(),
    });
    write_json(&args.json, &report)?;
    if let Some(path) = &args.plot {
        let svg = plot(&rows, &setup, &machine).map_err(Failure::other)?;
        write_atomically(path, Existing::Replace, |out| out.write_all(svg.as_bytes())).map_err(Failure::other)?;
    }
    printed.map_err(Failure::other)?;
    Ok(0)
}

/// What came of it.
struct Measured {
    rows: Vec<Row>,
    /// Where and why it stopped before the last count.
    stopped: Option<String>,
    /// Whether the rows could be printed.
    printed: std::io::Result<()>,
}

/// Measures one count after the other, and prints its row.
fn measure_all(
    args: &BenchParticlesArgs,
    setup: &Setup,
    machine: &Machine,
    folder: &Path,
) -> Result<Measured, Failure> {
    let [width, height] = setup.resolution;
    say!("{machine}");
    say!(
        "{width}x{height}, {} spp, 8 wavelengths, droplets of optical depth {} without glass; medians of {} (+- half their range), seconds \
         on the wall",
        setup.spp,
        setup.optical_depth,
        args.repeat
    );
    let mut counts = args.counts.clone();
    counts.sort_unstable();
    let (mut rows, mut printed, mut stopped) = (Vec::new(), Ok(()), None);
    for count in counts {
        if let Some(why) = refuse(count, args) {
            say!("stopped before {count} particles: {why}");
            stopped = Some(format!("before {count} particles: {why}"));
            break;
        }
        let runs = (0..args.repeat).map(|repeat| measure(count, setup, repeat, folder));
        let runs: Vec<Run> = runs.collect::<Result<_, _>>().map_err(Failure::other)?;
        let row = Row { count, runs, peak_rss_bytes: peak_rss_bytes() };
        printed = printed.and(print_row(&row, rows.is_empty()));
        rows.push(row);
    }
    say_same(&rows);
    Ok(Measured { rows, stopped, printed })
}

/// Says whether the pictures are the same.
fn say_same(rows: &[Row]) {
    let furthest = deviations(rows).into_iter().fold(0.0f64, |a, b| if b.abs() > a.abs() { b } else { a });
    if rows.len() > 1 {
        let same = if furthest.abs() <= SAME_WITHIN { "the same picture" } else { "NOT the same picture" };
        say!(
            "{same} at each count: means differ by at most {:.1} standard errors from the last, the largest of which is {}",
            furthest.abs(),
            percent(resolution(rows))
        );
    }
}

/// What a count takes: tables of the droplets' sizes, the picture and the program are 60 MB as measured.
fn need(count: u64) -> Need {
    const FIXED_BYTES: u64 = 96 << 20;
    /// The file is read before the droplets in it are, and dropped later.
    const FILE_BYTES_EACH: u64 = 24;
    let mut need = Need::default();
    need.add_particles(format!("{count} droplets"), count, rayon::current_num_threads() as u64);
    need.add("the file that they are read from", count.saturating_mul(FILE_BYTES_EACH), "lower --counts");
    need.add("tables and picture", FIXED_BYTES, "lower --counts");
    need
}

/// Why a count is not measured: nobody says that so much memory may be used.
fn refuse(count: u64, args: &BenchParticlesArgs) -> Option<String> {
    let needed = need(count).total();
    if needed <= ASK_ABOVE_BYTES || args.yes || args.memory_limit.is_some() {
        return None;
    }
    let gib = needed as f64 / f64::from(1 << 30);
    if !std::io::stdin().is_terminal() {
        return Some(format!("they need about {gib:.1} GiB; add --yes"));
    }
    say!("{count} particles need about {gib:.1} GiB. Go on? [y/N]");
    let mut answer = String::new();
    let read = std::io::stdin().lock().read_line(&mut answer);
    let agreed = read.is_ok() && matches!(answer.trim(), "y" | "Y" | "yes");
    (!agreed).then(|| "as you say".into())
}

/// Titles and cells of the table.
fn cells(row: &Row) -> [(&'static str, String); 15] {
    let time = |value: fn(&Run) -> f64| format!("{:.3}", row.over(value).median);
    let rate = |value: fn(&RayCounts) -> u64| format!("{:.3}", row.rate(value).median);
    let render = row.over(|run| run.render_s);
    let bytes = |value: fn(&Run) -> f64| format!("{:.1}", row.over(value).median);
    let [mean, error] = row.mean_luminance();
    [
        ("particles", row.count.to_string()),
        ("generate_s", time(|run| run.generate_s)),
        ("write_s", time(|run| run.write_s)),
        ("load_s", time(|run| run.load_s)),
        ("tables_s", time(|run| run.tables_s)),
        ("bvh_s", time(|run| run.bvh_s)),
        ("render_s", format!("{:.3}", render.median)),
        ("+-", format!("{:.3}", render.half_range())),
        ("camera_M/s", rate(|rays| rays.camera)),
        ("scatter_M/s", rate(|rays| rays.scatter)),
        ("shadow_M/s", rate(|rays| rays.shadow)),
        ("geometry_B", bytes(|run| run.geometry_bytes_per_particle)),
        ("bvh_B", bytes(|run| run.bvh_bytes_per_particle)),
        ("mean", format!("{mean:.5}")),
        ("+-", format!("{error:.5}")),
    ]
}

fn print_row(row: &Row, first: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    let cells = cells(row);
    let line = |texts: [&str; 15]| {
        let padded = texts
            .iter()
            .zip(&cells)
            .map(|(text, (name, value))| format!("{text:>w$}", w = name.len().max(value.len()).max(6)));
        padded.collect::<Vec<_>>().join(" ")
    };
    if first {
        writeln!(out, "{}", line(cells.each_ref().map(|(name, _)| *name)))?;
    }
    writeln!(out, "{}", line(cells.each_ref().map(|(_, value)| value.as_str())))?;
    out.flush()
}

fn write_csv(rows: &[Row], out: &mut dyn Write) -> std::io::Result<()> {
    for (i, row) in rows.iter().enumerate() {
        let columns = columns(row);
        if i == 0 {
            writeln!(out, "{}", columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(","))?;
        }
        writeln!(out, "{}", columns.iter().map(|(_, value)| value.to_string()).collect::<Vec<_>>().join(","))?;
    }
    Ok(())
}

fn plot(rows: &[Row], setup: &Setup, machine: &Machine) -> Result<String, PlotError> {
    let line = |name: &str, value: &dyn Fn(&Row) -> Spread| CountLine {
        name: name.into(),
        points: rows
            .iter()
            .map(|row| (row.count as f64, value(row)))
            .map(|(count, s)| (count, [s.median, s.least, s.greatest]))
            .collect(),
    };
    let time = |name: &str, value: fn(&Run) -> f64| line(name, &|row| row.over(value));
    let rate = |name: &str, value: fn(&RayCounts) -> u64| line(name, &|row| row.rate(value));
    let [width, height] = setup.resolution;
    let title = format!(
        "The same cloud of {} droplets: optical depth {}, {width}x{height} pixels, {} samples each",
        range(rows),
        setup.optical_depth,
        setup.spp
    );
    let numbers = format!("{machine}; points: medians, bars: least to greatest of the repeats");
    let times = Panel {
        title: "seconds on the wall".into(),
        lines: vec![
            time("generate", |run| run.generate_s),
            time("write", |run| run.write_s),
            time("load", |run| run.load_s),
            time("tables", |run| run.tables_s),
            time("tree", |run| run.bvh_s),
            time("render", |run| run.render_s),
        ],
    };
    let rates = Panel {
        title: "million rays per second".into(),
        lines: vec![
            rate("camera", |rays| rays.camera),
            rate("scatter", |rays| rays.scatter),
            rate("shadow", |rays| rays.shadow),
            rate("all", RayCounts::total),
        ],
    };
    counts_plot([&title, &numbers], &[times, rates])
}

/// The counts in words.
fn range(rows: &[Row]) -> String {
    match (rows.first(), rows.last()) {
        (Some(first), Some(last)) if first.count < last.count => format!("{:e} to {:e}", first.count, last.count),
        (Some(first), _) => format!("{:e}", first.count),
        _ => "no".into(),
    }
}
