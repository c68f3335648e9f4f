//! Times every stage against the number of particles: the same cloud, the same optical depth, the same view.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use thiserror::Error;

use super::make_cloud;
use crate::plan;
use crate::scene::generate::{CloudShape, Content, GenerateError, Recipe};
use crate::scene::gltf::write;
use crate::scene::model::ParticleKind;
use crate::scene::{LoadOptions, SceneError, load};
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::transport::{
    PrepareError, Prepared, RayCounts, RenderRequest, SilentProgress, Spectral, Stage, Until, render,
};

/// What is measured at each count.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Samples per pixel.
    pub spp: u32,
    /// Optical depth of the cloud at 550 nm, whatever the count.
    pub optical_depth: f64,
}

impl Default for Setup {
    fn default() -> Self {
        Self { resolution: [320, 180], spp: 4, optical_depth: 1.0 }
    }
}

/// What one run took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Number of droplets.
    pub count: u64,
    /// Seconds: generating, writing, reading, tables, tree, rendering.
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
    /// Mean of the picture, which must not depend on the count.
    pub mean_luminance: f64,
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

/// Measures one count, through a file in `folder` as a user's scene would come.
///
/// # Errors
/// When any stage fails.
pub fn measure(count: u64, setup: &Setup, folder: &Path) -> Result<Row, StudyError> {
    let mut row = Row { count, ..Row::default() };
    let mut last = Instant::now();
    let mut lap = || {
        let now = Instant::now();
        std::mem::replace(&mut last, now).elapsed().as_secs_f64() - now.elapsed().as_secs_f64()
    };
    let cloud = make_cloud(&recipe(count, setup)?)?;
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
    let plan = plan::plan(&scene, &Default::default(), 0.05, sampling.wavelengths_m.len());
    let prepared = Prepared::new(scene, &plan, &sampling, None, &mut |stage| match stage {
        Stage::Tables => drop(lap()),
        Stage::Bvh => row.tables_s = lap(),
        Stage::Ready => row.bvh_s = lap(),
    })?;
    let outcome = render(&prepared.context(), &request(setup), &SilentProgress);
    row.render_s = lap();
    row.rays = outcome.rays;
    row.geometry_bytes_per_particle = prepared.accel.geometry_bytes() as f64 / count as f64;
    row.bvh_bytes_per_particle = prepared.accel.tree_bytes() as f64 / count as f64;
    row.mean_luminance = outcome.film.mean_luminance();
    Ok(row)
}

fn recipe(count: u64, setup: &Setup) -> Result<Recipe, GenerateError> {
    Ok(Recipe {
        count,
        kind: ParticleKind::Droplet,
        content: Content::OpticalDepth(setup.optical_depth),
        seed: 1,
        ..Recipe::new(CloudShape::new("box", &[1.0])?)
    })
}

fn request(setup: &Setup) -> RenderRequest {
    let [width, height] = setup.resolution;
    RenderRequest {
        seed: 1,
        until: Until::Samples(setup.spp),
        crop: [0, 0, width, height],
        layers: Vec::new(),
        spectral: Spectral::Discard,
    }
}

/// The run of median render time.
pub fn median(mut rows: Vec<Row>) -> Option<Row> {
    rows.sort_by(|a, b| a.render_s.total_cmp(&b.render_s));
    let middle = rows.len() / 2;
    rows.into_iter().nth(middle)
}

/// Names, units and values of a row's columns: one list for the text table and the CSV.
pub fn columns(row: &Row) -> [(&'static str, String); 14] {
    let s = |value: f64| format!("{value:.4}");
    let rate = |rays: u64| format!("{:.4}", rays as f64 / row.render_s.max(1e-9) * 1e-6);
    [
        ("particles", row.count.to_string()),
        ("generate_s", s(row.generate_s)),
        ("write_s", s(row.write_s)),
        ("load_s", s(row.load_s)),
        ("tables_s", s(row.tables_s)),
        ("bvh_s", s(row.bvh_s)),
        ("render_s", s(row.render_s)),
        ("camera_Mrays_per_s", rate(row.rays.camera)),
        ("scatter_Mrays_per_s", rate(row.rays.scatter)),
        ("shadow_Mrays_per_s", rate(row.rays.shadow)),
        ("all_Mrays_per_s", rate(row.rays.total())),
        ("geometry_B_each", format!("{:.1}", row.geometry_bytes_per_particle)),
        ("bvh_B_each", format!("{:.1}", row.bvh_bytes_per_particle)),
        ("mean_luminance", format!("{:.5}", row.mean_luminance)),
    ]
}
