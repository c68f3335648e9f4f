//! `mie-cloud bench`: tables of measurements.

use std::io::Write;

use super::args::BenchParticlesArgs;
use super::failure::Failure;
use super::memory::MemoryLimit;
use super::say::say;
use crate::image::file::{Existing, check_writable, write_atomically};
use crate::study::particles::{Row, Setup, columns, measure, median};
use crate::transport::need::Need;

/// Runs `bench particles`.
pub fn particles(args: &BenchParticlesArgs) -> Result<u8, Failure> {
    if let Some(path) = &args.csv {
        check_writable(path, Existing::Replace).map_err(Failure::other)?;
    }
    check_memory(args)?;
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
        let runs = (0..args.repeat).map(|_| measure(count, &setup, folder)).collect::<Result<Vec<_>, _>>();
        let Some(row) = median(runs.map_err(Failure::other)?) else { continue };
        print_row(&row, rows.is_empty()).map_err(Failure::other)?;
        rows.push(row);
    }
    Ok(rows)
}

/// Refuses counts that do not fit before the first is measured, which may take long.
fn check_memory(args: &BenchParticlesArgs) -> Result<(), Failure> {
    let Some(largest) = args.counts.iter().max() else { return Ok(()) };
    /// Tables of the droplets' sizes, the picture and the program (measured: 60 MB).
    const FIXED_BYTES: u64 = 96 << 20;
    /// The file is read before the droplets in it are, and dropped later.
    const FILE_BYTES_EACH: u64 = 24;
    let mut need = Need::default();
    need.add_particles(format!("{largest} droplets"), *largest, rayon::current_num_threads() as u64);
    need.add("the file that they are read from", largest.saturating_mul(FILE_BYTES_EACH), "lower --counts");
    need.add("tables and picture", FIXED_BYTES, "lower --counts");
    MemoryLimit::new(args.memory_limit).check(&need)
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
