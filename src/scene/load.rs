//! Loads a scene: reads the file, then adds what it does not bring (camera, sun) and says so.

use std::path::Path;

use super::error::{SceneError, SceneFault, SceneResult};
use super::folder::{Folder, Refusal, read_file, read_start};
use super::frame_cloud::{default_sun, framing_camera};
use super::gltf::{Parts, is_glb, read};
use super::hash::content_hash;
use super::model::{Camera, Lens, Scene};
use super::settings::Settings;
use crate::excerpt::excerpt;
use crate::units::short::number;
use crate::warning::Warning;

/// What the user's flags say about reading a scene; none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// `--set KEY=VALUE`, in order; later ones win, and all win over the file. Files that values name are relative to
    /// the working folder and unrestricted, because the user typed them.
    pub settings: Vec<(String, String)>,
    /// `--camera`: the name of a camera or of its node.
    pub camera: Option<String>,
    /// `--droplets`: a shell pattern for names of nodes whose meshes are droplets.
    pub droplets_glob: Option<String>,
    /// `--radius`: drawn radius of points that bring none, m in the world.
    pub radius_m: Option<f64>,
    /// `--resolution`: wins over `image.resolution`, also for framing; pixels, each at least 1.
    pub resolution: Option<[u32; 2]>,
    /// `--memory-limit`: what files, particles and fog boxes may take together; by default particles and boxes may take 24 MiB
    /// and 12 bytes for each of the files'.
    pub memory_limit_bytes: Option<u64>,
    /// Memory that there is, where the caller knows: nothing may take more, whatever is allowed.
    pub available_bytes: Option<u64>,
}

impl LoadOptions {
    /// What reading may take at most.
    pub(super) fn most_bytes(&self) -> u64 {
        [self.memory_limit_bytes, self.available_bytes].into_iter().flatten().min().unwrap_or(u64::MAX)
    }
}

/// Loads a scene from a `.gltf` or `.glb` file.
///
/// # Errors
/// When the file or something that it names cannot be read, is broken, is out of range or holds nothing to render.
/// Memory stays below 64 MiB and 20 times the size of the files, and nothing outside the scene's folder is read.
///
/// ```
/// use mie_cloud::scene::{LoadOptions, load};
/// let options = LoadOptions { settings: vec![("droplets.material".into(), "ice".into())], ..Default::default() };
/// let scene = load("tests/data/fog_points.gltf".as_ref(), &options)?;
/// assert_eq!(scene.particles.len(), 64);
/// # Ok::<(), mie_cloud::scene::SceneError>(())
/// ```
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    load_parts(path, options).map_err(|e| e.in_file(path))
}

fn load_parts(path: &Path, options: &LoadOptions) -> SceneResult<Scene> {
    let info = std::fs::metadata(path).map_err(|e| SceneError::at("", SceneFault::Unreadable(e)))?;
    // Opening a pipe would wait for its other end.
    if !info.is_file() {
        return Err(SceneError::at("", SceneFault::NotAFile));
    }
    let unreadable =
        |refusal: Refusal| SceneError::at("", SceneFault::Unreadable(std::io::Error::other(refusal.problem)));
    // A long file of another kind is not read to its end.
    if !begins_like_a_scene(&read_start(path, START_BYTES).map_err(unreadable)?) {
        return Err(SceneError::at("", SceneFault::NotAScene));
    }
    let most = options.most_bytes();
    if info.len() > most {
        let what = "its bytes".into();
        return Err(SceneError::at("", SceneFault::Memory { what, bytes: info.len(), limit: most }));
    }
    let file = read_file(path, most).map_err(unreadable)?;
    let parts = read(&file, &Folder::of_scene(path), options)?;
    drop(file);
    let name = path.display().to_string();
    complete(name, parts)
}

/// What is looked at before a file is read.
const START_BYTES: u64 = 4096;

/// Whether a file begins like GLB or JSON: with a magic, or a brace behind white space and perhaps a byte order mark.
fn begins_like_a_scene(start: &[u8]) -> bool {
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start).trim_ascii_start();
    text.is_empty() || text[0] == b'{' || is_glb(start)
}

/// Loads a scene from the bytes of a `.gltf` or `.glb` file that is built into the program; `name` says where it would lie.
///
/// # Errors
/// As [`load`].
pub fn load_embedded(name: &str, file: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = Path::new(name);
    let scene = read(file, &Folder::of_scene(path), options).and_then(|parts| complete(name.into(), parts));
    scene.map_err(|e| e.in_file(path))
}

/// Adds camera and sun where there are none, and the hash.
fn complete(name: String, parts: Parts) -> SceneResult<Scene> {
    let Parts { particles, fog_balls, fog_boxes, classes, camera, mut suns, settings, mut warnings, files } = parts;
    if particles.is_empty() && fog_boxes.is_empty() {
        if is_dark(&settings) {
            return Err(SceneError::at("", SceneFault::Empty { found: found(&warnings) }));
        }
        warnings.push(Warning::new(
            "the scene holds no droplets and no fog",
            "mark meshes with kind = \"droplet\" or \"fog\", give points a _RADIUS, or use --droplets or --radius",
        ));
    }
    warnings.extend(camera.as_ref().and_then(|camera| stretched(camera, settings.image.resolution)));
    let camera = camera.unwrap_or_else(|| {
        warnings.push(Warning::new("no camera: one that frames the cloud is used", "add a camera to the scene"));
        let [width, height] = settings.image.resolution.map(f64::from);
        framing_camera(&particles, &fog_boxes, width / height)
    });
    if suns.is_empty() {
        let what = "no directional light: white light of 100000 lx from the upper left is used";
        warnings.push(Warning::new(what, "add a sun (KHR_lights_punctual, directional) to the scene"));
        suns.push(default_sun(&camera));
    } else if suns.iter().all(|sun| sun.lux == 0.0) {
        warnings.push(Warning::new("no directional light has an intensity above 0", "set it in lux"));
    }
    let hash = String::new();
    let mut scene =
        Scene { name, particles, fog_balls, fog_boxes, classes, camera, suns, settings, warnings, files, hash };
    scene.hash = content_hash(&scene);
    Ok(scene)
}

/// The view of an orthographic camera fills the picture whatever its shape.
fn stretched(camera: &Camera, resolution: [u32; 2]) -> Option<Warning> {
    /// Whole pixels cannot match every shape.
    const UNSEEN: f64 = 0.01;
    let Lens::Orthographic { xmag_m, ymag_m } = camera.lens else { return None };
    let [width, height] = resolution.map(f64::from);
    let stretch = width / height * ymag_m / xmag_m;
    let matching = format!("{width}x{:.0}", (width * ymag_m / xmag_m).clamp(1.0, 65_536.0));
    ((stretch - 1.0).abs() > UNSEEN).then(|| {
        Warning::new(
            format!(
                "camera {}: xmag and ymag are not as the picture's {width} to {height}: it is stretched {} times across",
                excerpt(&camera.name),
                number(stretch)
            ),
            format!("set image.resolution to {matching}, say, or change xmag or ymag"),
        )
    })
}

/// What there is where there is nothing to render, as the first warnings say it.
fn found(warnings: &[Warning]) -> String {
    const SAID: usize = 3;
    let said: Vec<&str> = warnings.iter().take(SAID).map(|warning| warning.what.as_str()).collect();
    if said.is_empty() { String::new() } else { format!("; instead there are {}", said.join(", ")) }
}

/// Whether a scene without droplets would be black everywhere.
fn is_dark(settings: &Settings) -> bool {
    let background = &settings.background;
    settings.atmosphere.scattering_per_m == 0.0 && background.radiance == [0.0; 3] && background.image.is_none()
}
