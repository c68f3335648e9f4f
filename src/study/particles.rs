//! Times every stage against the number of particles: the same cloud, the same optical depth, the same view.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use thiserror::Error;

use super::make_cloud;
use crate::plan;
use crate::scene::generate::{CameraPlacement, CloudShape, Content, GenerateError, Recipe, View};
use crate::scene::gltf::write;
use crate::scene::model::ParticleKind;
use crate::scene::settings::{Effect, Switch};
use crate::scene::{LoadOptions, SceneError, load};
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::transport::{
    PrepareError, Prepared, RayCounts, RenderRequest, SilentProgress, Spectral, Stage, Until, render,
};

/// What is measured at each count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setup {
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Samples per pixel.
    pub spp: u32,
    /// Optical depth of the cloud at 550 nm, whatever the count. A thousand droplets of optical depth 1 are so large that the picture
    /// shows it.
    pub optical_depth: f64,
}

impl Default for Setup {
    fn default() -> Self {
        Self { resolution: [320, 180], spp: 4, optical_depth: 0.1 }
    }
}

/// What one run took.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Run {
    /// Seconds on the wall: generating, writing, reading, tables, tree, rendering.
    pub generate_s: f64,
    pub write_s: f64,
    pub load_s: f64,
    pub tables_s: f64,
    pub bvh_s: f64,
    pub render_s: f64,
    /// Rays traced.
    pub rays: RayCounts,
    /// Bytes of geometry and tree per droplet.
    pub geometry_bytes_per_particle: f64,
    pub bvh_bytes_per_particle: f64,
    /// Mean of the picture, and its standard error from the samples alone.
    pub mean_luminance: f64,
    pub sampling_error: f64,
}

/// A measurement could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The cloud could not be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The scene could not be written.
    #[error("cannot write the measured scene: {0}")]
    Write(#[from] write::WriteError),
    /// The scene could not be kept between writing and reading.
    #[error("cannot keep the measured scene in {folder}: {source}; set TMPDIR to a folder that can be written")]
    Store { folder: std::path::PathBuf, source: std::io::Error },
    /// The scene could not be read back.
    #[error("cannot read the measured scene: {0}")]
    Load(#[from] SceneError),
    /// The scene could not be prepared.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
}

/// Measures one count once, through a file in `folder` as a user's scene would come. Every repeat has another cloud.
///
/// # Errors
/// When any stage fails.
pub fn measure(count: u64, setup: &Setup, repeat: u32, folder: &Path) -> Result<Run, StudyError> {
    let mut row = Run::default();
    let seed = 1 + u64::from(repeat);
    let mut last = Instant::now();
    let mut lap = || {
        let now = Instant::now();
        std::mem::replace(&mut last, now).elapsed().as_secs_f64() - now.elapsed().as_secs_f64()
    };
    let cloud = make_cloud(&recipe(count, setup, seed)?)?;
    row.generate_s = lap();
    let path = folder.join("particles.glb");
    let store = |source| StudyError::Store { folder: folder.into(), source };
    let mut file = std::io::BufWriter::new(std::fs::File::create(&path).map_err(store)?);
    write::write_glb(&cloud, &mut file)?;
    file.flush().map_err(store)?;
    drop((file, cloud));
    row.write_s = lap();
    let mut scene = load(&path, &LoadOptions::default())?;
    scene.settings.image.resolution = setup.resolution;
    row.load_s = lap();
    let sampling = SpectralSampling::new(SpectralMode::Bands { count: 8 }, scene.settings.sun.spectrum);
    let plan = plan::plan(&scene, &choices(), 0.05, sampling.wavelengths_m.len());
    let prepared = Prepared::new(scene, &plan, &sampling, None, &mut |stage| match stage {
        Stage::Tables => drop(lap()),
        Stage::Bvh => row.tables_s = lap(),
        Stage::Ready => row.bvh_s = lap(),
    })?;
    let outcome = render(&prepared.context(), &request(setup, seed), &SilentProgress);
    row.render_s = lap();
    row.rays = outcome.rays;
    row.geometry_bytes_per_particle = prepared.accel.geometry_bytes() as f64 / count as f64;
    row.bvh_bytes_per_particle = prepared.accel.tree_bytes() as f64 / count as f64;
    row.mean_luminance = outcome.film.mean_luminance();
    let pixels = f64::from(setup.resolution[0]) * f64::from(setup.resolution[1]);
    row.sampling_error = row.mean_luminance * outcome.film.noise() / pixels.sqrt();
    Ok(row)
}

/// From here a box of 1 m fills the picture.
const DISTANCE_M: f64 = 2.1;

fn recipe(count: u64, setup: &Setup, seed: u64) -> Result<Recipe, GenerateError> {
    let shape = CloudShape::new("box", &[1.0])?;
    let default = Recipe::new(shape);
    // Framed by itself a cloud is seen from farther away, the larger its droplets are.
    let camera = Some(CameraPlacement { position_m: [0.0, 0.0, DISTANCE_M], target_m: [0.0; 3] });
    Ok(Recipe {
        count,
        kind: ParticleKind::Droplet,
        content: Content::OpticalDepth(setup.optical_depth),
        seed,
        view: View { camera, ..default.view },
        ..default
    })
}

/// Few droplets are drawn large and could be seen as glass, many could not: that would not be the same picture.
fn choices() -> BTreeMap<Effect, Switch> {
    BTreeMap::from([(Effect::Refraction, Switch::Off)])
}

fn request(setup: &Setup, seed: u64) -> RenderRequest {
    let [width, height] = setup.resolution;
    RenderRequest {
        seed,
        until: Until::Samples(setup.spp),
        crop: [0, 0, width, height],
        layers: Vec::new(),
        spectral: Spectral::Discard,
    }
}

/// A value over several runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The middle one, or the mean of the two in the middle.
    pub median: f64,
    /// The least and the greatest.
    pub least: f64,
    pub greatest: f64,
}

impl Spread {
    /// Of values; zeros where there are none.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let (Some(least), Some(greatest)) = (values.first(), values.last()) else { return Self::default() };
        let n = values.len();
        Self { median: 0.5 * (values[(n - 1) / 2] + values[n / 2]), least: *least, greatest: *greatest }
    }

    /// Half the way from the least to the greatest.
    pub fn half_range(&self) -> f64 {
        0.5 * (self.greatest - self.least)
    }
}

/// All runs of one count.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Number of droplets.
    pub count: u64,
    /// One per repeat.
    pub runs: Vec<Run>,
    /// Peak memory of the program so far, bytes; 0 where the system does not tell.
    pub peak_rss_bytes: u64,
}

impl Row {
    /// A value over the runs.
    pub fn over(&self, value: impl Fn(&Run) -> f64) -> Spread {
        Spread::of(self.runs.iter().map(value))
    }

    /// Million rays of a kind per second of rendering.
    pub fn rate(&self, rays: impl Fn(&RayCounts) -> u64) -> Spread {
        self.over(|run| rays(&run.rays) as f64 / run.render_s.max(1e-9) * 1e-6)
    }

    /// Mean of the pictures, and its standard error: from the scatter of the runs, whose clouds differ, and at least what
    /// samples make.
    pub fn mean_luminance(&self) -> [f64; 2] {
        let n = self.runs.len().max(1) as f64;
        let mean = self.runs.iter().map(|run| run.mean_luminance).sum::<f64>() / n;
        let scatter = self.runs.iter().map(|run| (run.mean_luminance - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let sampling = self.runs.iter().map(|run| run.sampling_error.powi(2)).sum::<f64>() / n;
        [mean, (scatter.max(sampling) / n).sqrt()]
    }
}

/// How far the mean picture of each row is from that of the last, in standard errors.
pub fn deviations(rows: &[Row]) -> Vec<f64> {
    let Some([last, last_error]) = rows.last().map(Row::mean_luminance) else { return Vec::new() };
    let deviation = |[mean, error]: [f64; 2]| (mean - last) / error.hypot(last_error).max(f64::MIN_POSITIVE);
    let others = rows.iter().take(rows.len() - 1).map(|row| deviation(row.mean_luminance()));
    others.chain([0.0]).collect()
}

/// The largest relative standard error of such a difference: what it would not show.
pub fn resolution(rows: &[Row]) -> f64 {
    let Some([last, last_error]) = rows.last().map(Row::mean_luminance) else { return 0.0 };
    let errors = rows.iter().take(rows.len() - 1).map(|row| row.mean_luminance()[1].hypot(last_error));
    errors.fold(0.0, f64::max) / last.max(f64::MIN_POSITIVE)
}

/// Names with units, and values of a row's columns: what the CSV holds.
pub fn columns(row: &Row) -> Vec<(String, f64)> {
    let [mean, error] = row.mean_luminance();
    let last = row.runs.last();
    let bytes = |value: fn(&Run) -> f64| last.map_or(0.0, value);
    let times: [(&str, Spread); 6] = [
        ("generate_s", row.over(|run| run.generate_s)),
        ("write_s", row.over(|run| run.write_s)),
        ("load_s", row.over(|run| run.load_s)),
        ("tables_s", row.over(|run| run.tables_s)),
        ("bvh_s", row.over(|run| run.bvh_s)),
        ("render_s", row.over(|run| run.render_s)),
    ];
    let rates: [(&str, Spread); 4] = [
        ("camera_Mrays_per_s", row.rate(|rays| rays.camera)),
        ("scatter_Mrays_per_s", row.rate(|rays| rays.scatter)),
        ("shadow_Mrays_per_s", row.rate(|rays| rays.shadow)),
        ("all_Mrays_per_s", row.rate(RayCounts::total)),
    ];
    let three = |(name, spread): &(&str, Spread)| {
        let named = |suffix: &str| format!("{name}{suffix}");
        [(named(""), spread.median), (named("_least"), spread.least), (named("_greatest"), spread.greatest)]
    };
    let one = |name: &str, value: f64| [(name.to_owned(), value)];
    let mut columns: Vec<(String, f64)> = Vec::new();
    columns.extend(one("particles", row.count as f64));
    columns.extend(one("repeats", row.runs.len() as f64));
    columns.extend(times.iter().chain(&rates).flat_map(three));
    columns.extend(one("geometry_B_each", bytes(|run| run.geometry_bytes_per_particle)));
    columns.extend(one("bvh_B_each", bytes(|run| run.bvh_bytes_per_particle)));
    columns.extend(one("peak_B", row.peak_rss_bytes as f64));
    columns.extend(one("mean_luminance", mean));
    columns.extend(one("mean_luminance_error", error));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_spreads_are_those_of_the_runs() {
        let spread = Spread::of([3.0, 1.0, 10.0].into_iter());
        assert_eq!((spread.median, spread.least, spread.greatest, spread.half_range()), (3.0, 1.0, 10.0, 4.5));
        assert_eq!(Spread::of([1.0, 2.0].into_iter()).median, 1.5);
        assert_eq!(Spread::of(std::iter::empty()), Spread::default());
    }

    #[test]
    fn means_know_their_error_and_rows_their_distance() {
        let run = |mean_luminance, sampling_error| Run { mean_luminance, sampling_error, ..Run::default() };
        let row = |runs: &[Run]| Row { runs: runs.to_vec(), ..Row::default() };
        // Scatter of variance 2 over two runs; then samples alone.
        assert_eq!(row(&[run(9.0, 0.1), run(11.0, 0.1)]).mean_luminance(), [10.0, 1.0]);
        assert_eq!(row(&[run(10.0, 2.0)]).mean_luminance(), [10.0, 2.0]);
        let rows = [row(&[run(15.0, 3.0)]), row(&[run(10.0, 4.0)])];
        assert_eq!(deviations(&rows), [1.0, 0.0]);
        assert_eq!(resolution(&rows), 0.5);
        assert_eq!(columns(&rows[0]).len(), 37);
    }
}
