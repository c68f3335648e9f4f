//! `mie-cloud paper`: the ten figures, three ways, as pictures and tables.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};

use super::args::PaperArgs;
use super::failure::Failure;
use super::memory::MemoryLimit;
use super::render::in_thread_pool;
use super::say::say;
use crate::image::file::{Existing, check_writable, write_atomically};
use crate::image::{exr, png};
use crate::paper::{self, FIGURES, Figure, Method, Study, contact_sheet};
use crate::transport::need::Need;

const SHEET: &str = "contact.png";
const CSV: &str = "table.csv";
const TEXT: &str = "table.txt";

/// Runs the command.
pub fn run(args: &PaperArgs) -> Result<u8, Failure> {
    in_thread_pool(args.threads, || run_here(args))?
}

fn run_here(args: &PaperArgs) -> Result<u8, Failure> {
    let existing = if args.no_clobber { Existing::Keep } else { Existing::Replace };
    let folder = args.output.as_path();
    MemoryLimit::new(args.memory_limit).check(&need(args))?;
    prepare_folder(folder, existing)?;
    let studies = make_all(args)?;
    let text = paper::text(&studies).map_err(Failure::other)?;
    write_files(folder, &studies, &text, existing)?;
    if !args.quiet {
        say!("{}: {SHEET}, {CSV}, {TEXT} and {} pictures", folder.display(), pictures().count());
    }
    std::io::stdout().lock().write_all(text.as_bytes()).map_err(Failure::other)?;
    Ok(0)
}

/// All pictures are kept for the sheet.
fn need(args: &PaperArgs) -> Need {
    /// The scenes' own size.
    const OWN: [u32; 2] = [320, 180];
    /// Thirty pictures of three or four channels, the sheet, and one film (measured: 890).
    const BYTES_PER_PIXEL: u64 = 960;
    let [width, height] = args.resolution.unwrap_or(OWN);
    let mut need = Need::of_program();
    let bytes = u64::from(width) * u64::from(height) * BYTES_PER_PIXEL;
    need.add(format!("{} pictures of {width}x{height} pixels", pictures().count()), bytes, "lower --resolution");
    need
}

/// Makes the output's folder if it is not there, and checks every file before any work is done.
fn prepare_folder(folder: &Path, existing: Existing) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::usage(anyhow!("--output {}: is a file; name a folder", folder.display())));
    }
    if !folder.exists() {
        std::fs::create_dir(folder)
            .with_context(|| format!("--output {}: cannot make this folder; make the one it lies in", folder.display()))
            .map_err(Failure::other)?;
    }
    let fixed = [SHEET, CSV, TEXT].map(|name| folder.join(name));
    let all = fixed.into_iter().chain(pictures().map(|(figure, method)| picture_path(folder, &figure, method)));
    for path in all {
        check_writable(&path, existing)
            .map_err(|error| Failure::other(anyhow::Error::new(error).context("--output")))?;
    }
    Ok(())
}

/// Every picture that is written.
fn pictures() -> impl Iterator<Item = (Figure, Method)> {
    FIGURES.into_iter().flat_map(|figure| Method::ALL.map(|method| (figure, method)))
}

fn picture_path(folder: &Path, figure: &Figure, method: Method) -> PathBuf {
    folder.join(format!("fig{:02}-{}.exr", figure.number, method.name()))
}

fn make_all(args: &PaperArgs) -> Result<Vec<Study>, Failure> {
    let make = |figure: &Figure| {
        if !args.quiet {
            say!("figure {} of {}: {} nm", figure.number, FIGURES.len(), figure.diameter_nm);
        }
        paper::make(figure, args.resolution).map_err(Failure::other)
    };
    FIGURES.iter().map(make).collect()
}

fn write_files(folder: &Path, studies: &[Study], text: &str, existing: Existing) -> Result<(), Failure> {
    for study in studies {
        for column in &study.columns {
            let path = picture_path(folder, &study.figure, column.method);
            exr::write(&path, &column.picture, existing).map_err(Failure::other)?;
        }
    }
    let sheet = contact_sheet(studies).map_err(Failure::other)?;
    let software = concat!("mie-cloud ", env!("CARGO_PKG_VERSION"));
    png::write(&folder.join(SHEET), &sheet, software, existing).map_err(Failure::other)?;
    write_atomically(&folder.join(CSV), existing, |out| paper::write_csv(studies, out)).map_err(Failure::other)?;
    write_atomically(&folder.join(TEXT), existing, |out| out.write_all(text.as_bytes())).map_err(Failure::other)?;
    Ok(())
}
