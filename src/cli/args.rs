//! The arguments as they are written, grouped for the help text.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use num_complex::Complex64;

use super::bench_args::{AccuracyArgs, EffectsArgs};
use super::mie::angles::AngleList;
use super::values::{
    length, number, parse_accuracy, parse_count, parse_crop, parse_index, parse_key_value, parse_memory,
    parse_nonnegative, parse_point, parse_positive, parse_resolution, parse_samples, parse_share, parse_time,
    parse_water,
};
use crate::scene::generate::CloudShape;

/// Renders clouds of droplets with true Lorenz-Mie scattering.
#[derive(Debug, Parser)]
#[command(
    name = "mie-cloud",
    version,
    about,
    max_term_width = 110,
    subcommand_required = true,
    arg_required_else_help = true
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Renders a glTF scene to an HDR OpenEXR picture
    Render(Box<RenderArgs>),
    /// Writes a cloud of droplets as glTF
    Generate(Box<GenerateArgs>),
    /// Prints what one sphere or a size distribution does to light
    Mie(Box<MieArgs>),
    /// Shows what was understood of a scene and what would be simulated
    Inspect(InspectArgs),
    /// Measures speed and accuracy
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Compares two EXR pictures
    Diff(DiffArgs),
    /// Combines parts of a picture that were rendered with `render --samples`
    Merge(MergeArgs),
    /// Makes ten figures of a paper by its formulas and by exact Mie, side by side
    Paper(PaperArgs),
}

#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Times generation, tree, tables and rendering against the number of particles
    Particles(BenchParticlesArgs),
    /// Switches each effect of a scene on and off: time, change of the picture, and whether the plan was right
    Effects(EffectsArgs),
    /// Sweeps every knob of accuracy against the finest settings: error, time, memory, and the cheapest settings
    Accuracy(AccuracyArgs),
}

/// Which part of the scene is taken, and what overrides it.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// glTF scene (.gltf or .glb)
    pub scene: PathBuf,
    /// Overrides a setting of the scene, e.g. `atmosphere.scattering_per_m=0.025`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = parse_key_value, help_heading = "Scene")]
    pub set: Vec<(String, String)>,
    /// Camera to use, by name [default: the scene's first]
    #[arg(long, value_name = "NAME", help_heading = "Scene")]
    pub camera: Option<String>,
    /// Nodes whose meshes are droplets, by name with * and ?
    #[arg(long, value_name = "GLOB", help_heading = "Scene")]
    pub droplets: Option<String>,
    /// Radius of points that have none, with its unit: 5um, 1mm
    #[arg(long, value_name = "LENGTH", value_parser = length, help_heading = "Scene")]
    pub radius: Option<f64>,
    /// Effects: `auto`, `+name`, `-name`, separated by commas
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, help_heading = "Scene")]
    pub effects: Option<String>,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, help_heading = "Running")]
    pub memory_limit: Option<u64>,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// OpenEXR file to write
    #[arg(short, long, value_name = "OUT.exr", help_heading = "Output")]
    pub output: PathBuf,
    /// Also writes an exposed and tone-mapped PNG
    #[arg(long, value_name = "OUT.png", help_heading = "Output")]
    pub preview: Option<PathBuf>,
    /// Extra layers, separated by commas, or `all`: direct, multiple, airlight, glow, air_multiple, refraction,
    /// background, stderr, samples, depth, transmittance
    #[arg(long, value_name = "LIST", help_heading = "Output")]
    pub aov: Option<String>,
    /// Adds radiance by wavelength (layout of Fichet et al. 2021)
    #[arg(long, help_heading = "Output")]
    pub spectral: bool,
    /// Writes cd/m^2 instead of multiples of a white diffuser in the sun (`bands` mode only)
    #[arg(long, help_heading = "Output")]
    pub absolute: bool,
    /// Writes times, rays, effects and memory as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    pub stats: Option<PathBuf>,
    /// Refuses to overwrite files
    #[arg(long, help_heading = "Output")]
    pub no_clobber: bool,
    /// Size of the picture in pixels [default: the scene's, or 640x360]
    #[arg(long, value_name = "WxH", value_parser = parse_resolution, help_heading = "Output")]
    pub resolution: Option<[u32; 2]>,
    /// Renders a part of the picture: left, top, width, height in pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop, help_heading = "Output")]
    pub crop: Option<[u32; 4]>,
    /// Samples in every pixel [default: 64, or the scene's accuracy target]
    #[arg(long, value_name = "N", conflicts_with_all = ["noise", "accuracy"], value_parser = clap::value_parser!(u32).range(1..), help_heading = "Sampling")]
    pub spp: Option<u32>,
    /// Renders samples A to B-1 of every pixel, a part for `merge`; 0..64, 64..128, .. make one picture
    #[arg(long, value_name = "A..B", conflicts_with_all = ["spp", "noise", "accuracy", "time_limit"], value_parser = parse_samples, help_heading = "Sampling")]
    pub samples: Option<[u32; 2]>,
    /// Samples where the noise is, until the standard error is this share of the mean luminance
    #[arg(long, value_name = "E", conflicts_with = "accuracy", value_parser = parse_share, help_heading = "Sampling")]
    pub noise: Option<f64>,
    /// Stops after this time: 90s, 3m, 1h30m, or seconds (the picture then depends on the machine)
    #[arg(long, value_name = "TIME", value_parser = parse_time, help_heading = "Sampling")]
    pub time_limit: Option<f64>,
    /// Target relative error: draft (0.1), standard (0.05), fine (0.02), reference (0.005) or a number
    #[arg(long, value_name = "LEVEL", value_parser = parse_accuracy, help_heading = "Sampling")]
    pub accuracy: Option<f64>,
    /// Most times that light is scattered by droplets [default: unlimited]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Sampling")]
    pub order: Option<u32>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Sampling")]
    pub seed: u64,
    /// Threads [default: one per processor]; the picture does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), help_heading = "Running")]
    pub threads: Option<u16>,
    /// Keeps all sums in this file, every minute and at the end, to go on from with --resume
    #[arg(long, value_name = "FILE", help_heading = "Running")]
    pub checkpoint: Option<PathBuf>,
    /// Time from one checkpoint to the next: 30s, 10m, or seconds
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "checkpoint", value_parser = parse_time, help_heading = "Running")]
    pub checkpoint_every: f64,
    /// Goes on from a checkpoint of the same scene and flags, to the same picture as without interruption
    #[arg(long, value_name = "FILE", help_heading = "Running")]
    pub resume: Option<PathBuf>,
    /// Neither reads nor writes the table cache
    #[arg(long, help_heading = "Running")]
    pub no_cache: bool,
    /// Prints errors only
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Running")]
    pub quiet: bool,
    /// Prints more
    #[arg(short, long, help_heading = "Running")]
    pub verbose: bool,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Parts of one picture, in any order
    #[arg(required = true, value_name = "PART.exr")]
    pub parts: Vec<PathBuf>,
    /// OpenEXR file to write
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Also writes an exposed and tone-mapped PNG
    #[arg(long, value_name = "OUT.png")]
    pub preview: Option<PathBuf>,
    /// Merges what is there although samples are missing in between
    #[arg(long)]
    pub allow_gaps: bool,
    /// Refuses to overwrite files
    #[arg(long)]
    pub no_clobber: bool,
    /// Prints errors only
    #[arg(short, long)]
    pub quiet: bool,
}

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
    #[arg(long, help_heading = "Output")]
    pub no_clobber: bool,
    /// How droplets are stored
    #[arg(long = "as", value_name = "FORM", default_value = "points", help_heading = "Output")]
    pub form: FormName,
    /// Prints errors only
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,
    /// Shape of the cloud
    #[arg(long, default_value = "ball", value_parser = PossibleValuesParser::new(CloudShape::NAMES), help_heading = "Cloud")]
    pub shape: String,
    /// Diameter or edge with its unit, or the three edges x, y (up), z: 2m or 20m,2m,20m
    #[arg(long, value_name = "L[,L,L]", default_value = "1m", value_parser = length, value_delimiter = ',', num_args = 1, help_heading = "Cloud")]
    pub size: Vec<f64>,
    /// Number of droplets or parcels
    #[arg(long, value_name = "N", default_value = "10000", value_parser = parse_count, help_heading = "Cloud")]
    pub count: u64,
    /// Single droplets, or balls of fog
    #[arg(long, default_value = "parcels", help_heading = "Cloud")]
    pub kind: KindName,
    /// Droplet sizes: mono:r=5um, gamma:reff=6um,veff=0.1, lognormal:rg=3um,sigma=0.4, modgamma:.., csv:FILE
    #[arg(long, value_name = "D", default_value = "gamma:reff=6um,veff=0.1", help_heading = "Cloud")]
    pub distribution: String,
    /// Water in the air, e.g. 0.3g/m3
    #[arg(long, value_name = "W", conflicts_with = "optical_depth", value_parser = parse_water, help_heading = "Cloud")]
    pub liquid_water: Option<f64>,
    /// Optical depth at 550 nm, through the centre along the shortest side
    #[arg(long, value_name = "T", value_parser = parse_positive, help_heading = "Cloud")]
    pub optical_depth: Option<f64>,
    /// 0 fills the shape evenly, 1 gathers the fog in banks with almost clear air between
    #[arg(long, value_name = "P", default_value_t = 0.0, help_heading = "Cloud")]
    pub patchiness: f64,
    /// Radius of parcels over their mean spacing [default: chosen for smooth fog]
    #[arg(long, value_name = "R", value_parser = parse_positive, help_heading = "Cloud")]
    pub overlap: Option<f64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Cloud")]
    pub seed: u64,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, help_heading = "Output")]
    pub memory_limit: Option<u64>,
    /// Height of the sun above the horizon, degrees [default: 25; cumulus 40]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, help_heading = "View")]
    pub sun_elevation: Option<f64>,
    /// Where the sun stands, degrees: 0 behind the cloud, 90 to the left, 180 behind the camera [default: 60; cumulus 115]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, help_heading = "View")]
    pub sun_azimuth: Option<f64>,
    /// Position of the camera with its unit [default: one that frames the cloud]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at", help_heading = "View")]
    pub camera_position: Option<[f64; 3]>,
    /// Point in the middle of the picture, with its unit
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "camera_position", help_heading = "View")]
    pub look_at: Option<[f64; 3]>,
    /// Vertical field of view, degrees
    #[arg(long, value_name = "DEG", default_value_t = 40.0, help_heading = "View")]
    pub yfov: f64,
    /// Puts a setting into the file, e.g. `accuracy.target=0.05`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = parse_key_value, help_heading = "View")]
    pub set: Vec<(String, String)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    Text,
    Json,
    Csv,
}

/// What `mie` can be asked, as it is written.
const MIE_EXAMPLES: &str = "\
Examples:
  mie-cloud mie --size-parameter 10 --index 1.33,0
  mie-cloud mie --radius 5um --wavelength 450nm --angles 130:145:0.1 --format csv -o bow.csv
  mie-cloud mie --radius 10um --material ice --format json --plot ice.svg
  mie-cloud mie --distribution gamma:reff=6um,veff=0.1 --plot fog.svg
  mie-cloud mie --distribution lognormal:rg=0.1um,sigma=0.7,rmax=10um --index 1.45,0.01

Phase functions integrate to 1 over the sphere (sr^-1); the medium is air, taken as vacuum.
A CSV whose angles go from 0 to 180 serves as a scene's phase model, table:FILE.csv.";

#[derive(Debug, Args)]
#[command(after_help = MIE_EXAMPLES, group = ArgGroup::new("scatterer").required(true).args(["size_parameter", "radius", "distribution"]))]
pub struct MieArgs {
    /// Size parameter 2 pi r / lambda, 1e-6 to 1e6; with --wavelength the radius follows
    #[arg(long, value_name = "X", value_parser = number, allow_negative_numbers = true, help_heading = "Scatterer (one of these)")]
    pub size_parameter: Option<f64>,
    /// Radius of one sphere with its unit: 5um, 20nm, 1mm
    #[arg(long, value_name = "R", value_parser = length, help_heading = "Scatterer (one of these)")]
    pub radius: Option<f64>,
    /// Size distribution: mono:r=5um, gamma:reff=6um,veff=0.1, modgamma:alpha=6,gamma=1,rc=4um,
    /// lognormal:rg=3um,sigma=0.4 or csv:FILE (radius_um,dn_dr); all take rmin= and rmax=
    #[arg(long, value_name = "D", help_heading = "Scatterer (one of these)")]
    pub distribution: Option<String>,
    /// Vacuum wavelength with its unit [default: 550nm]
    #[arg(long, value_name = "L", value_parser = length, help_heading = "Light and material")]
    pub wavelength: Option<f64>,
    /// Material: water, ice, or a CSV file (wavelength_um,n,k) [default: water]
    #[arg(long, value_name = "M", conflicts_with = "index", help_heading = "Light and material")]
    pub material: Option<String>,
    /// Refractive index m = n + ik instead of a material; k >= 0 absorbs
    #[arg(long, value_name = "N,K", value_parser = parse_index, allow_hyphen_values = true, help_heading = "Light and material")]
    pub index: Option<Complex64>,
    /// Scattering angles in degrees, 0 (forward) to 180: A,B,C or FROM:TO:STEP
    #[arg(long, value_name = "LIST", default_value = "0:180:10", allow_hyphen_values = true, help_heading = "Output")]
    pub angles: AngleList,
    /// Format of the output; json and csv have all digits
    #[arg(long, default_value = "text", help_heading = "Output")]
    pub format: FormatName,
    /// Also draws the phase function and the polarisation as SVG
    #[arg(long, value_name = "P.svg", help_heading = "Output")]
    pub plot: Option<PathBuf>,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct InspectArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Prints JSON
    #[arg(long, help_heading = "Output")]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct BenchParticlesArgs {
    /// Particle counts, separated by commas
    #[arg(long, value_name = "LIST", default_value = "1e3,1e4,1e5,1e6,1e7", value_parser = parse_count, value_delimiter = ',')]
    pub counts: Vec<u64>,
    /// Repeats of each count, each with a cloud of its own; medians are shown
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub repeat: u32,
    /// Writes the table as CSV
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    pub memory_limit: Option<u64>,
    /// Writes every run as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Draws times and rays per second over the count
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    /// Uses much memory without asking
    #[arg(short, long)]
    pub yes: bool,
    /// Threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

#[derive(Debug, Args)]
pub struct DiffArgs {
    /// First picture
    pub a: PathBuf,
    /// Second picture, the reference
    pub b: PathBuf,
    /// Largest relative RMSE that counts as equal; above it the exit code is 1
    #[arg(long, value_name = "E", value_parser = parse_nonnegative)]
    pub max_rel: Option<f64>,
    /// Draws the difference of lightness: red where the first picture is lighter, blue where it is darker
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct PaperArgs {
    /// Folder for contact.png, table.csv, table.txt and the pictures; it is made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "paper", help_heading = "Output")]
    pub output: PathBuf,
    /// Refuses to overwrite files
    #[arg(long, help_heading = "Output")]
    pub no_clobber: bool,
    /// Size of each picture in pixels [default: the scenes', 320x180]
    #[arg(long, value_name = "WxH", value_parser = parse_resolution, help_heading = "Output")]
    pub resolution: Option<[u32; 2]>,
    /// Threads [default: one per processor]; the pictures do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), help_heading = "Running")]
    pub threads: Option<u16>,
    /// Prints errors and the table only
    #[arg(short, long, help_heading = "Running")]
    pub quiet: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_of_the_arguments_is_sound() {
        Cli::command().debug_assert();
    }
}
