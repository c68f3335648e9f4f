//! `mie-cloud bench`: tables of measurements.

use std::io::Write;

use super::args::BenchParticlesArgs;
use super::failure::Failure;
use super::say::say;
use crate::image::file::{Existing, check_writable, write_atomically};
use crate::study::particles::{Row, Setup, columns, measure, median};

/// Bytes that one droplet takes at the peak of a run, measured: positions, radii, the file, bodies and tree being built.
const PEAK_BYTES_PER_PARTICLE: u64 = 600;

/// Runs `bench particles`.
pub fn particles(args: &BenchParticlesArgs) -> Result<u8, Failure> {
    if let Some(path) = &args.csv {
        check_writable(path, Existing::Replace).map_err(Failure::other)?;
    }
    let folder = std::env::temp_dir().join(format!("mie-cloud-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(Failure::other)?;
    let rows = measure_all(args, &folder);
    let _ = std::fs::remove_dir_all(&folder);
    let rows = rows?;
    if let Some(path) = &args.csv {
        write_atomically(path, Existing::Replace, |out| write_csv(&rows, out)).map_err(Failure::other)?;
    }
    Ok(0)
}

fn measure_all(args: &BenchParticlesArgs, folder: &std::path::Path) -> Result<Vec<Row>, Failure> {
    let setup = Setup::default();
    let [width, height] = setup.resolution;
    say!(
        "{width}x{height}, {} spp, 8 wavelengths, optical depth {}, {} threads",
        setup.spp,
        setup.optical_depth,
        rayon::current_num_threads()
    );
    let mut rows = Vec::new();
    for &count in &args.counts {
        if let Some(free) =
            available_memory_bytes().filter(|free| count.saturating_mul(PEAK_BYTES_PER_PARTICLE) > *free)
        {
            say!(
                "{count} particles: skipped, they need about {} MiB and {} MiB are free",
                (count * PEAK_BYTES_PER_PARTICLE) >> 20,
                free >> 20
            );
            continue;
        }
        let runs = (0..args.repeat).map(|_| measure(count, &setup, folder)).collect::<Result<Vec<_>, _>>();
        let Some(row) = median(runs.map_err(Failure::other)?) else { continue };
        print_row(&row, rows.is_empty()).map_err(Failure::other)?;
        rows.push(row);
    }
    Ok(rows)
}

/// Memory that can be had without swapping, where the system tells.
fn available_memory_bytes() -> Option<u64> {
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

fn print_row(row: &Row, first: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    let columns = columns(row);
    let width = |name: &str, value: &str| name.len().max(value.len()).max(9);
    if first {
        let names: Vec<String> =
            columns.iter().map(|(name, value)| format!("{name:>w$}", w = width(name, value))).collect();
        writeln!(out, "{}", names.join("  "))?;
    }
    let values: Vec<String> =
        columns.iter().map(|(name, value)| format!("{value:>w$}", w = width(name, value))).collect();
    writeln!(out, "{}", values.join("  "))?;
    out.flush()
}

fn write_csv(rows: &[Row], out: &mut dyn Write) -> std::io::Result<()> {
    for (i, row) in rows.iter().enumerate() {
        let columns = columns(row);
        if i == 0 {
            writeln!(out, "{}", columns.each_ref().map(|(name, _)| *name).join(","))?;
        }
        writeln!(out, "{}", columns.each_ref().map(|(_, value)| value.as_str()).join(","))?;
    }
    Ok(())
}
