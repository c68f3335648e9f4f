//! Arguments of `mie`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};
use num_complex::Complex64;

use super::angles::AngleList;
use crate::cli::values::{file_as, length, number, one_wavelength, parse_index};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    Text,
    Json,
    Csv,
}

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("scatterer").required(true).args(["size_parameter", "radius", "distribution"]))]
pub struct MieArgs {
    /// Size parameter 2 pi r / lambda, 1e-6 to 1e6; with --wavelength the radius follows
    #[arg(long, value_name = "X", value_parser = number, allow_negative_numbers = true, help_heading = "Scatterer (one of these)")]
    pub size_parameter: Option<f64>,
    /// Radius of one sphere with its unit: 5um, 20nm, 1mm
    #[arg(long, value_name = "R", value_parser = length, allow_hyphen_values = true, help_heading = "Scatterer (one of these)")]
    pub radius: Option<f64>,
    /// Size distribution: mono:r=5um, gamma:reff=6um,veff=0.1, modgamma:alpha=6,gamma=1,rc=4um,
    /// lognormal:rg=3um,sigma=0.4 or csv:FILE (radius_um,dn_dr); all take rmin= and rmax=
    #[arg(long, value_name = "D", help_heading = "Scatterer (one of these)")]
    pub distribution: Option<String>,
    /// Vacuum wavelength with its unit [default: 550nm]
    #[arg(long, value_name = "L", value_parser = one_wavelength, allow_hyphen_values = true, help_heading = "Light and material")]
    pub wavelength: Option<f64>,
    /// Material: water, ice, or a CSV file (wavelength_um,n,k) [default: water]
    #[arg(long, value_name = "M", conflicts_with = "index", help_heading = "Light and material")]
    pub material: Option<String>,
    /// Refractive index m = n + ik instead of a material; k >= 0 absorbs
    #[arg(long, value_name = "N,K", value_parser = parse_index, allow_hyphen_values = true, help_heading = "Light and material")]
    pub index: Option<Complex64>,
    /// Scattering angles in degrees, 0 (forward) to 180: A,B,C or FROM:TO:STEP; a plot shows what lies between them
    /// [default: 0:180:10]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, help_heading = "Output")]
    pub angles: Option<AngleList>,
    /// Format of the output; json and csv have all digits
    #[arg(long, default_value = "text", help_heading = "Output")]
    pub format: FormatName,
    /// Also draws the phase function and the polarisation as SVG
    #[arg(long, value_name = "P.svg", value_parser = file_as("svg"), help_heading = "Output")]
    pub plot: Option<PathBuf>,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}
