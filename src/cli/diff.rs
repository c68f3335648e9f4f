//! `mie-cloud diff`: how much two pictures differ.

use super::args::DiffArgs;
use super::claims::Outputs;
use super::diff_report::print;
use super::failure::{FAILURE, Failure};
use super::memory::MemoryLimit;
use super::say::say;
use crate::image::compare::{Comparison, compare, difference_map};
use crate::image::file::Existing;
use crate::image::{Attribute, Picture, exr, png};
use crate::transport::need::Need;

/// Runs the command.
pub fn run(args: &DiffArgs) -> Result<u8, Failure> {
    let read = |path| -> Result<Picture, Failure> { exr::read(path, exr::Limits::default()).map_err(Failure::other) };
    let outputs = Outputs::new([("--picture", args.picture.as_ref())]);
    outputs.spare("is one of the pictures", [&args.a, &args.b])?;
    outputs.check(Existing::Replace)?;
    MemoryLimit::new(args.memory_limit).check(&need(args))?;
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let comparison = compare(&a, &b).map_err(Failure::other)?;
    for line in unlike(&a, &b) {
        say!("warning: {line}");
    }
    print(&comparison).map_err(Failure::other)?;
    if let Some(path) = &args.picture {
        let map = difference_map(&a, &b).map_err(Failure::other)?;
        let software = concat!("mie-cloud ", env!("CARGO_PKG_VERSION"));
        png::write(path, &map, software, Existing::Replace).map_err(Failure::other)?;
    }
    let too_much = args.max_rel.is_some_and(|limit| !within(&comparison, limit));
    Ok(if too_much { FAILURE } else { 0 })
}

/// Both pictures, and what is worked out of them.
fn need(args: &DiffArgs) -> Need {
    /// Squares and worst pixels of the difference, and its picture (measured: 46 and 8 for both).
    const BYTES_PER_PIXEL: u64 = 24;
    const BYTES_PER_PIXEL_DRAWN: u64 = 28;
    let each = if args.picture.is_some() { BYTES_PER_PIXEL_DRAWN } else { BYTES_PER_PIXEL };
    let mut need = Need::of_program();
    need.add_picture("the first picture", &args.a, each);
    need.add_picture("the second picture", &args.b, each);
    need
}

/// Whether the relative RMSE is at most the limit; two black pictures are equal.
fn within(comparison: &Comparison, limit: f64) -> bool {
    let relative = comparison.relative_rmse.unwrap_or(if comparison.rmse == 0.0 { 0.0 } else { f64::INFINITY });
    comparison.n_non_finite == 0 && relative <= limit
}

/// In what the numbers of the pictures differ by their headers, so that they cannot be compared.
fn unlike(a: &Picture, b: &Picture) -> Vec<String> {
    let mode = |picture: &Picture| match picture.attribute("mieCloud:spectralMode") {
        Some(Attribute::Text(mode)) => Some(mode.clone()),
        _ => None,
    };
    let white = |picture: &Picture| picture.white_luminance_cd_m2;
    // However many bands there are, they add up to the same colours.
    let is_same = |a: &str, b: &str| a == b || [a, b].iter().all(|mode| mode.starts_with("bands"));
    let modes = mode(a)
        .zip(mode(b))
        .filter(|(a, b)| !is_same(a, b))
        .map(|(a, b)| format!("the first picture is in the spectral mode {a}, the second in {b}"));
    // Lights of other lux are other scenes in the same unit, unless one of the pictures is in cd/m^2.
    let whites = white(a).zip(white(b)).filter(|(a, b)| a != b && (*a == 1.0 || *b == 1.0)).map(|(a, b)| {
        let remedy = "render both with --absolute or both without";
        format!("1.0 is {a} cd/m^2 in the first picture, {b} in the second (whiteLuminance); {remedy}")
    });
    modes.into_iter().chain(whites).collect()
}
