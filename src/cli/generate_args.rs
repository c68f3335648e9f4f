//! Arguments of `generate`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};

use super::values::{length, parse_count, parse_key_value, parse_memory, parse_point, parse_positive, parse_water};
use crate::scene::generate::CloudShape;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KindName {
    Droplets,
    Parcels,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormName {
    Points,
    Instances,
}

#[derive(Debug, Args)]
pub struct GenerateArgs {
    /// File to write: .glb, or .gltf with its data inside
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: PathBuf,
    /// Refuses to overwrite files
    #[arg(hide_short_help = true, long, help_heading = "Output")]
    pub no_clobber: bool,
    /// How droplets are stored
    #[arg(hide_short_help = true, long = "as", value_name = "FORM", default_value = "points", help_heading = "Output")]
    pub form: FormName,
    /// Prints errors only
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,
    /// Shape of the cloud
    #[arg(long, default_value = "ball", value_parser = PossibleValuesParser::new(CloudShape::NAMES), help_heading = "Cloud")]
    pub shape: String,
    /// Diameter or edge with its unit, or the three edges x, y (up), z: 2m or 20m,2m,20m
    ///
    /// A cumulus or a puff may be up to ten times as long as its shortest side.
    #[arg(long, value_name = "L[,L,L]", default_value = "1m", value_parser = length, value_delimiter = ',', num_args = 1, allow_hyphen_values = true, help_heading = "Cloud")]
    pub size: Vec<f64>,
    /// Number of droplets or parcels [default: 10000]
    #[arg(long, value_name = "N", value_parser = parse_count, help_heading = "Cloud")]
    pub count: Option<u64>,
    /// Single droplets, or balls of fog
    #[arg(long, default_value = "parcels", help_heading = "Cloud")]
    pub kind: KindName,
    /// Droplet sizes: mono:r=5um, gamma:reff=6um,veff=0.1, lognormal:rg=3um,sigma=0.4, modgamma:.., csv:FILE
    #[arg(long, value_name = "D", default_value = "gamma:reff=6um,veff=0.1", help_heading = "Cloud")]
    pub distribution: String,
    /// Water in the air, e.g. 0.3g/m3
    #[arg(long, value_name = "W", conflicts_with = "optical_depth", value_parser = parse_water, allow_hyphen_values = true, help_heading = "Cloud")]
    pub liquid_water: Option<f64>,
    /// Optical depth at 550 nm, through the centre along the shortest side
    #[arg(long, value_name = "T", value_parser = parse_positive, allow_hyphen_values = true, help_heading = "Cloud")]
    pub optical_depth: Option<f64>,
    /// 0 fills the shape evenly, 1 gathers the fog in banks with almost clear air between
    #[arg(long, value_name = "P", default_value_t = 0.0, help_heading = "Cloud")]
    pub patchiness: f64,
    /// Radius of parcels over their mean spacing [default: chosen for smooth fog]
    #[arg(hide_short_help = true, long, value_name = "R", value_parser = parse_positive, help_heading = "Cloud")]
    pub overlap: Option<f64>,
    /// Seed of the random numbers
    #[arg(hide_short_help = true, long, value_name = "N", default_value_t = 0, help_heading = "Cloud")]
    pub seed: u64,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(hide_short_help = true, long, value_name = "SIZE", value_parser = parse_memory, help_heading = "Output")]
    pub memory_limit: Option<u64>,
    /// Height of the sun above the horizon, degrees [default: 25; cumulus 40]
    #[arg(hide_short_help = true, long, value_name = "DEG", allow_negative_numbers = true, help_heading = "View")]
    pub sun_elevation: Option<f64>,
    /// Where the sun stands, degrees: 0 behind the cloud, 90 to the left, 180 behind the camera [default: 60; cumulus 115]
    #[arg(hide_short_help = true, long, value_name = "DEG", allow_negative_numbers = true, help_heading = "View")]
    pub sun_azimuth: Option<f64>,
    /// Position of the camera with its unit [default: one that frames the cloud]
    #[arg(hide_short_help = true, long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at", help_heading = "View")]
    pub camera_position: Option<[f64; 3]>,
    /// Point in the middle of the picture, with its unit
    #[arg(hide_short_help = true, long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "camera_position", help_heading = "View")]
    pub look_at: Option<[f64; 3]>,
    /// Vertical field of view, degrees
    #[arg(hide_short_help = true, long, value_name = "DEG", default_value_t = 40.0, help_heading = "View")]
    pub yfov: f64,
    /// Puts a setting into the file, e.g. `accuracy.target=0.05`; may be repeated
    #[arg(hide_short_help = true, long = "set", value_name = "KEY=VALUE", value_parser = parse_key_value, help_heading = "View")]
    pub set: Vec<(String, String)>,
}
