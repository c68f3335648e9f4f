//! Which scatterer the flags describe.

use std::f64::consts::PI;

use anyhow::{Context, anyhow};
use num_complex::Complex64;

use super::args::MieArgs;
use crate::cli::failure::Failure;
use crate::mie::MieError;
use crate::optics::distribution::SizeDistribution;
use crate::optics::material::Material;
use crate::scene::folder::Folder;
use crate::study::Scatterer;
use crate::study::scatterer::Dimensions;
use crate::units::format_in;

/// Vacuum wavelength where none is given, m: the middle of the visible.
const DEFAULT_WAVELENGTH_M: f64 = 550e-9;

/// Solves the scatterer of the flags; whatever is wrong with it is wrong with them.
pub fn solve(args: &MieArgs, typed: &Folder) -> Result<Scatterer, Failure> {
    scatterer(args, typed).map_err(Failure::usage)
}

fn scatterer(args: &MieArgs, typed: &Folder) -> anyhow::Result<Scatterer> {
    let m = index(args, typed)?;
    let wavelength_m = wavelength_m(args);
    if let Some(text) = &args.distribution {
        let distribution =
            SizeDistribution::parse(text, &|name| typed.read_typed_text(name)).context("--distribution")?;
        return Scatterer::cloud(distribution, wavelength_m, m)
            .map_err(|error| match error {
                MieError::SizeParameter(_) if !text.trim_start().starts_with("mono") => {
                    anyhow!("{error}; end the distribution with rmin= or rmax=, e.g. rmax=50um")
                }
                other => other.into(),
            })
            .with_context(|| format!("--distribution {text} at {}", nm(wavelength_m)));
    }
    if let Some(radius_m) = args.radius {
        return Scatterer::sphere(Dimensions { radius_m, wavelength_m }, m)
            .with_context(|| format!("--radius {} at {}", um(radius_m), nm(wavelength_m)));
    }
    let x = args.size_parameter.ok_or_else(|| anyhow!("--size-parameter, --radius or --distribution is needed"))?;
    let Some(wavelength_m) = args.wavelength else { return Ok(Scatterer::relative_sphere(x, m)?) };
    let radius_m = x * wavelength_m / (2.0 * PI);
    let mut scatterer = Scatterer::relative_sphere(x, m)?;
    if let Scatterer::Sphere(sphere) = &mut scatterer {
        sphere.dimensions = Some(Dimensions { radius_m, wavelength_m });
    }
    Ok(scatterer)
}

/// The name of what the scatterer is made of, where it has one.
pub fn material_name(args: &MieArgs) -> Option<&str> {
    if args.index.is_some() { None } else { Some(args.material.as_deref().unwrap_or("water").trim()) }
}

fn wavelength_m(args: &MieArgs) -> f64 {
    args.wavelength.unwrap_or(DEFAULT_WAVELENGTH_M)
}

fn index(args: &MieArgs, typed: &Folder) -> anyhow::Result<Complex64> {
    if let Some(index) = args.index {
        return Ok(index);
    }
    let material = match &args.material {
        Some(text) => Material::parse(text, &|name| typed.read_typed_text(name)).context("--material")?,
        None if args.size_parameter.is_some() => {
            return Err(anyhow!("--size-parameter needs an index: add --index N,K, or --material M at a --wavelength"));
        }
        None => Material::Water,
    };
    material.index(wavelength_m(args)).context("--material")
}

/// In micrometres; very small and very large ones without their zeros.
fn um(radius_m: f64) -> String {
    let um = format_in(radius_m, 1e6);
    if um.len() > 20 { format!("{radius_m:e} m") } else { format!("{um}um") }
}

fn nm(wavelength_m: f64) -> String {
    format_in(wavelength_m, 1e9) + " nm"
}
