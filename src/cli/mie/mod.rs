//! `mie-cloud mie`: what one sphere or a size distribution does to light.

mod angles;
pub mod args;
mod csv;
mod json;
mod request;
mod text;

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::anyhow;

use super::failure::Failure;
use crate::image::file::{Existing, check_writable, write_atomically};
use crate::study::plot::{Caption, phase_plot};
use crate::study::{MieReport, Scatterer};
use angles::AngleList;
use args::{FormatName, MieArgs};

/// Runs the command.
pub fn run(args: &MieArgs) -> Result<u8, Failure> {
    check_outputs(args)?;
    let scatterer = request::solve(args)?;
    let angles = args.angles.clone().unwrap_or_else(AngleList::standard);
    let report = MieReport::new(&scatterer, angles.degrees()).map_err(Failure::usage)?;
    if let Some(path) = &args.plot {
        plot(path, (&scatterer, angles.range_deg()), &Caption::new(&scatterer, request::material_name(args)))?;
    }
    match &args.output {
        Some(path) => {
            write_atomically(path, Existing::Replace, |out| write(out, &report, args.format)).map_err(Failure::other)?
        }
        None => to_stdout(&report, args.format).map_err(Failure::other)?,
    }
    Ok(0)
}

/// Looks at the outputs before any work is done.
fn check_outputs(args: &MieArgs) -> Result<(), Failure> {
    if args.output.is_some() && args.output == args.plot {
        return Err(Failure::usage(anyhow!("--output and --plot name the same file; give each its own")));
    }
    for path in [&args.output, &args.plot].into_iter().flatten() {
        check_writable(path, Existing::Replace).map_err(Failure::other)?;
    }
    Ok(())
}

fn to_stdout(report: &MieReport, format: FormatName) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    write(&mut out, report, format)?;
    out.flush()
}

fn write(out: &mut dyn Write, report: &MieReport, format: FormatName) -> io::Result<()> {
    match format {
        FormatName::Json => json::write(out, report),
        FormatName::Csv => csv::write(out, report),
        FormatName::Text => text::write(out, report),
    }
}

fn plot(path: &Path, (scatterer, range_deg): (&Scatterer, [f64; 2]), caption: &Caption) -> Result<(), Failure> {
    let curve = scatterer.curve_between(range_deg).map_err(Failure::other)?;
    let curve = curve.ok_or_else(|| {
        Failure::usage(anyhow!("--plot: an index of 1 scatters nothing, so there is no phase function; choose another"))
    })?;
    let svg = phase_plot(caption, &curve).map_err(Failure::other)?;
    write_atomically(path, Existing::Replace, |out| out.write_all(svg.as_bytes())).map_err(Failure::other)
}
