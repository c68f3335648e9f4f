//! The arguments as they are written, grouped for the help text.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::bench_args::{AccuracyArgs, EffectsArgs};
use super::generate_args::GenerateArgs;
use super::help;
use super::manual::{CompletionsArgs, ManArgs};
use super::mie::args::MieArgs;
use super::values::{
    MOST_THREADS, file_as, length, parse_accuracy, parse_count, parse_crop, parse_key_value, parse_memory,
    parse_nonnegative, parse_resolution, parse_samples, parse_share, parse_time,
};

/// Renders clouds of droplets with true Lorenz-Mie scattering.
#[derive(Debug, Parser)]
#[command(
    name = "mie-cloud",
    version,
    about,
    max_term_width = 110,
    after_help = help::PROGRAM,
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
    ///
    /// Droplets, fog, suns, camera and settings come from the scene; flags win over it. Progress, warnings and a summary go to
    /// stderr. Ctrl-C saves what there is and ends with 130; a second one ends at once. The same scene, settings and seed give the
    /// same bytes on any number of threads.
    #[command(after_help = help::RENDER)]
    Render(Box<RenderArgs>),
    /// Writes a cloud of droplets as glTF
    ///
    /// The file holds droplets or balls of fog (parcels), a camera that frames them, a sun, and the recipe they were made by.
    #[command(after_help = help::GENERATE)]
    Generate(Box<GenerateArgs>),
    /// Prints what one sphere or a size distribution does to light
    ///
    /// Efficiencies or cross sections, asymmetry, amplitudes and phase function by Lorenz-Mie theory, for size parameters from
    /// 1e-6 to 1e6 and indices n + ik with n from 0.05 to 20 and k from 0 to 100.
    #[command(after_help = help::MIE)]
    Mie(Box<MieArgs>),
    /// Shows what was understood of a scene and what would be simulated
    ///
    /// Nothing is rendered: particles, sizes, optical depth, light, camera, and each effect with the reason why it is on or off.
    #[command(after_help = help::INSPECT)]
    Inspect(InspectArgs),
    /// Measures speed and accuracy
    #[command(subcommand, after_help = help::BENCH)]
    Bench(BenchCommand),
    /// Compares two EXR pictures
    #[command(after_help = help::DIFF)]
    Diff(DiffArgs),
    /// Combines parts of a picture that were rendered with `render --samples`
    #[command(after_help = help::MERGE)]
    Merge(MergeArgs),
    /// Makes ten figures of a paper by its formulas and by exact Mie, side by side
    #[command(after_help = help::PAPER)]
    Paper(PaperArgs),
    /// Prints the script that completes flags in a shell
    #[command(after_help = help::COMPLETIONS)]
    Completions(CompletionsArgs),
    /// Prints the manual page
    #[command(after_help = help::MAN)]
    Man(ManArgs),
}

#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Times generation, tree, tables and rendering against the number of particles
    #[command(after_help = help::BENCH_PARTICLES)]
    Particles(BenchParticlesArgs),
    /// Switches each effect of a scene on and off: time, change of the picture, and whether the plan was right
    #[command(after_help = help::BENCH_EFFECTS)]
    Effects(EffectsArgs),
    /// Sweeps every knob of accuracy against the finest settings: error, time, memory, and the cheapest settings
    #[command(after_help = help::BENCH_ACCURACY)]
    Accuracy(AccuracyArgs),
}

/// Which part of the scene is taken, and what overrides it.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// glTF scene (.gltf or .glb)
    pub scene: PathBuf,
    /// Overrides a setting of the scene, e.g. `atmosphere.scattering_per_m=0.025`; may be repeated
    ///
    /// Keys, units, defaults and ranges are listed in docs/scene-format.md; later flags win over earlier ones. Files named here are
    /// relative to the working folder.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = parse_key_value, help_heading = "Scene")]
    pub set: Vec<(String, String)>,
    /// Camera to use, by name [default: the scene's first]
    #[arg(long, value_name = "NAME", help_heading = "Scene")]
    pub camera: Option<String>,
    /// Nodes whose meshes are droplets, by name with * and ?
    ///
    /// For scenes whose meshes carry no `extras.mie_cloud.kind`: each such mesh is a sphere about its middle.
    #[arg(hide_short_help = true, long, value_name = "GLOB", help_heading = "Scene")]
    pub droplets: Option<String>,
    /// Radius of points that have none, with its unit: 5um, 1mm
    ///
    /// For POINTS without the attribute `_RADIUS`: a length in the world, which nodes do not scale.
    #[arg(hide_short_help = true, long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true, help_heading = "Scene")]
    pub radius: Option<f64>,
    /// Effects: `auto`, `+name`, `-name`, separated by commas
    ///
    /// direct, multiple, absorption, shadows, airlight, glow, air-multiple, refraction, dispersion, background and sun-disc. `auto`
    /// simulates what can change the picture by a tenth of the accuracy target; `mie-cloud inspect` shows the choice and its reasons.
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
    ///
    /// It is there early, and rewritten while the picture gets better.
    #[arg(long, value_name = "OUT.png", value_parser = file_as("png"), help_heading = "Output")]
    pub preview: Option<PathBuf>,
    /// Extra layers, separated by commas, or `all`: direct, multiple, airlight, glow, air_multiple, refraction,
    /// background, stderr, samples, depth, transmittance
    #[arg(long, value_name = "LIST", help_heading = "Output")]
    pub aov: Option<String>,
    /// Adds radiance by wavelength (layout of Fichet et al. 2021)
    ///
    /// One channel for each wavelength, e.g. `S0.550,000000nm` (see docs/exr.md).
    #[arg(hide_short_help = true, long, help_heading = "Output")]
    pub spectral: bool,
    /// Writes cd/m^2 instead of multiples of a white diffuser in the sun (`bands` mode only)
    #[arg(hide_short_help = true, long, help_heading = "Output")]
    pub absolute: bool,
    /// Writes times, rays, effects and memory as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    pub stats: Option<PathBuf>,
    /// Refuses to overwrite files
    #[arg(hide_short_help = true, long, help_heading = "Output")]
    pub no_clobber: bool,
    /// Size of the picture in pixels [default: the scene's, or 640x360]
    #[arg(long, value_name = "WxH", value_parser = parse_resolution, help_heading = "Output")]
    pub resolution: Option<[u32; 2]>,
    /// Renders a part of the picture: left, top, width, height in pixels
    #[arg(hide_short_help = true, long, value_name = "X,Y,W,H", value_parser = parse_crop, help_heading = "Output")]
    pub crop: Option<[u32; 4]>,
    /// Samples in every pixel [default: 64, or the scene's accuracy target]
    ///
    /// Half the noise takes four times the samples. Powers of two are best.
    #[arg(long, value_name = "N", conflicts_with_all = ["noise", "accuracy"], value_parser = clap::value_parser!(u32).range(1..), help_heading = "Sampling")]
    pub spp: Option<u32>,
    /// Renders samples A to B-1 of every pixel, a part for `merge`; 0..64, 64..128, .. make one picture
    #[arg(hide_short_help = true, long, value_name = "A..B", conflicts_with_all = ["spp", "noise", "accuracy", "time_limit"], value_parser = parse_samples, help_heading = "Sampling")]
    pub samples: Option<[u32; 2]>,
    /// Samples where the noise is, until the standard error is this share of the mean luminance
    ///
    /// The error is the root mean square over pixels and R, G, B.
    /// 0.05 is visibly noisy, 0.02 is clean, 0.005 a reference.
    #[arg(long, value_name = "E", conflicts_with = "accuracy", allow_negative_numbers = true, value_parser = parse_share, help_heading = "Sampling")]
    pub noise: Option<f64>,
    /// Stops after this time: 90s, 3m, 1h30m, or seconds (the picture then depends on the machine)
    ///
    /// Counted from the program's start. Tables and the first sample of every pixel are made however long they take.
    #[arg(long, value_name = "TIME", value_parser = parse_time, help_heading = "Sampling")]
    pub time_limit: Option<f64>,
    /// Target relative error: draft (0.1), standard (0.05), fine (0.02), reference (0.005) or a number
    ///
    /// Sets noise, bands, tables and effects together; `mie-cloud bench accuracy` measures what it costs.
    #[arg(long, value_name = "LEVEL", value_parser = parse_accuracy, allow_negative_numbers = true, help_heading = "Sampling")]
    pub accuracy: Option<f64>,
    /// Most times that light is scattered by droplets [default: unlimited]
    ///
    /// 1 is fast and leaves thick fog too dark.
    #[arg(hide_short_help = true, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Sampling")]
    pub order: Option<u32>,
    /// Seed of the random numbers
    #[arg(hide_short_help = true, long, value_name = "N", default_value_t = 0, help_heading = "Sampling")]
    pub seed: u64,
    /// Threads [default: one per processor]; the picture does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS), help_heading = "Running")]
    pub threads: Option<u16>,
    /// Keeps all sums in this file, every minute and at the end, to go on from with --resume
    #[arg(long, value_name = "FILE", help_heading = "Running")]
    pub checkpoint: Option<PathBuf>,
    /// Time from one checkpoint to the next: 30s, 10m, or seconds
    #[arg(hide_short_help = true, long, value_name = "TIME", default_value = "60s", requires = "checkpoint", value_parser = parse_time, help_heading = "Running")]
    pub checkpoint_every: f64,
    /// Goes on from a checkpoint of the same scene and flags, to the same picture as without interruption
    #[arg(long, value_name = "FILE", help_heading = "Running")]
    pub resume: Option<PathBuf>,
    /// Neither reads nor writes the table cache
    ///
    /// Tables are kept in $XDG_CACHE_HOME/mie-cloud, or ~/.cache/mie-cloud, a file of some kilobytes to a megabyte for each size bin
    /// and wavelength. They are never removed: empty that folder at any time, even while the program runs.
    #[arg(hide_short_help = true, long, help_heading = "Running")]
    pub no_cache: bool,
    /// Prints errors only
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Running")]
    pub quiet: bool,
    /// Prints more: each effect, and why it is on or off
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
    #[arg(long, value_name = "OUT.png", value_parser = file_as("png"))]
    pub preview: Option<PathBuf>,
    /// Merges what is there although samples are missing in between
    #[arg(long)]
    pub allow_gaps: bool,
    /// Refuses to overwrite files
    #[arg(long)]
    pub no_clobber: bool,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    pub memory_limit: Option<u64>,
    /// Prints errors only
    #[arg(short, long)]
    pub quiet: bool,
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
    #[arg(long, value_name = "FILE.svg", value_parser = file_as("svg"))]
    pub plot: Option<PathBuf>,
    /// Uses much memory without asking
    #[arg(short, long)]
    pub yes: bool,
    /// Threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
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
    #[arg(long, value_name = "FILE.png", value_parser = file_as("png"))]
    pub picture: Option<PathBuf>,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    pub memory_limit: Option<u64>,
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS), help_heading = "Running")]
    pub threads: Option<u16>,
    /// Most memory to take: 500MB, 4GB, 2GiB [default: what the machine can give without swapping]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, help_heading = "Running")]
    pub memory_limit: Option<u64>,
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
