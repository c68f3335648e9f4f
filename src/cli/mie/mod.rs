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

use super::claims::Outputs;
use super::failure::Failure;
use crate::image::file::{Existing, write_atomically};
use crate::scene::folder::Folder;
use crate::study::plot::{Caption, phase_plot};
use crate::study::{MieReport, Scatterer};
use angles::AngleList;
use args::{FormatName, MieArgs};

/// Runs the command.
pub fn run(args: &MieArgs) -> Result<u8, Failure> {
    let outputs = Outputs::new([("--output", args.output.as_ref()), ("--plot", args.plot.as_ref())]);
    outputs.check(Existing::Replace)?;
    let typed = Folder::of_user();
    let scatterer = request::solve(args, &typed)?;
    outputs.spare("is read as a table", typed.files())?;
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
