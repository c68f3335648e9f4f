//! Scenes from plain glTF 2.0, and generated clouds to it: the parts of a scene in the order in which they are read.

mod accessors;
mod attributes;
mod budget;
mod buffers;
mod cameras;
mod classes;
mod document;
mod droplets;
mod extensions;
mod glb;
mod instancing;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod particles;
mod unrendered;
mod uri;
pub mod write;

use std::path::PathBuf;

use accessors::Accessors;
use budget::Budget;
use buffers::Buffers;
use cameras::Cameras;
use classes::{Classes, SceneMaterial};
use document::{Document, label};
use droplets::{Collector, Flags};
pub(super) use glb::is_glb;
use materials::Surfaces;
use meshes::Meshes;
use particles::Particles;
use unrendered::Unrendered;

use super::error::{SceneError, SceneFault, SceneResult};
use super::folder::Folder;
use super::keys::SETTINGS;
use super::load::LoadOptions;
use super::model::{Camera, FogBalls, FogBox, Particle, Sun};
use super::settings::Settings;
use super::settings_parse::{apply, entries_of_extras, entries_of_flag};
use crate::optics::DropletClass;
use crate::warning::Warning;

/// What a glTF file brings to a scene.
pub(super) struct Parts {
    pub particles: Vec<Particle>,
    pub fog_balls: Vec<FogBalls>,
    pub fog_boxes: Vec<FogBox>,
    pub classes: Vec<DropletClass>,
    pub camera: Option<Camera>,
    pub suns: Vec<Sun>,
    pub settings: Settings,
    pub warnings: Vec<Warning>,
    pub files: Vec<PathBuf>,
}

/// Reads a `.gltf` or `.glb` file, told apart by content.
///
/// # Errors
/// When anything in it is broken, out of range or not understood.
pub(super) fn read(file: &[u8], folder: &Folder, options: &LoadOptions) -> SceneResult<Parts> {
    let (json, chunk) = if is_glb(file) {
        let glb = glb::split(file).map_err(|fault| SceneError::at("", fault))?;
        (glb.json, glb.bin)
    } else {
        (file, None)
    };
    // glTF forbids a byte order mark and lets readers skip one.
    let document = document::read(json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json))?;
    extensions::check_required(&document)?;
    let scene = choose_scene(&document)?;
    let typed = Folder::of_user();
    let (settings, scene_material) = settings(&scene, [folder, &typed], options)?;
    let most_bytes = options.most_bytes();
    let buffers = Buffers::new(&document, chunk, folder, file.len() as u64, most_bytes);
    let budget = Budget::new(options.memory_limit_bytes.is_none(), most_bytes);
    let accessors = Accessors { document: &document, buffers: &buffers, budget: &budget };
    let mut collector = Collector {
        accessors,
        folder,
        flags: Flags { glob: options.droplets_glob.as_deref(), radius_m: options.radius_m },
        meshes: Meshes::new(&document, folder),
        surfaces: Surfaces::new(&document, folder),
        classes: Classes::new(&settings.droplets, scene_material, folder),
        particles: Particles::default(),
        fog_boxes: Vec::new(),
        notes: Unrendered::default(),
        glob_matches: 0,
    };
    let mut cameras = Cameras::new(options.camera.as_deref());
    let mut suns = Vec::new();
    nodes::walk(&document, &scene.roots, &scene.element, |visit| {
        let marks = collector.take(&visit)?;
        cameras.take(&document, &visit)?;
        lights::take(&document, folder, &visit, marks.light, &mut suns, &mut collector.notes)
    })?;
    let mut warnings = unrendered::top_level(&document, scene.index);
    warnings.extend(unmatched(options, collector.glob_matches));
    warnings.extend(std::mem::take(&mut collector.notes).into_warnings());
    let camera = cameras.finish(&mut warnings)?;
    let Particles { list: particles, fog_balls } = collector.particles;
    let (fog_boxes, classes) = (collector.fog_boxes, collector.classes.into_list());
    let files = [folder.files(), typed.files()].concat();
    Ok(Parts { particles, fog_balls, fog_boxes, classes, camera, suns, settings, warnings, files })
}

/// The scene that is shown.
struct Chosen<'a> {
    index: u32,
    element: String,
    roots: Vec<u32>,
    extras: Option<&'a serde_json::value::RawValue>,
}

/// The file's default scene, or its first.
fn choose_scene<'a>(document: &'a Document<'a>) -> SceneResult<Chosen<'a>> {
    let len = document.scenes.len();
    let wanted = document.scene.unwrap_or(0);
    let Some(index) = u32::try_from(wanted).ok().filter(|index| (*index as usize) < len) else {
        let fault = match document.scene {
            Some(index) => SceneFault::Index { target: "scenes", index, len },
            None => SceneFault::Missing { what: "scene", remedy: "export the objects in a scene" },
        };
        return Err(SceneError::at("", fault));
    };
    let scene: document::Scene = document.scenes.get("scenes", index, "scene")?;
    let element = label("scenes", index, scene.name.as_deref());
    Ok(Chosen { index, element, roots: scene.nodes, extras: scene.extras })
}

/// Defaults, then the scene's own settings, then the flags.
fn settings(
    scene: &Chosen,
    [folder, typed]: [&Folder; 2],
    options: &LoadOptions,
) -> SceneResult<(Settings, SceneMaterial)> {
    let mut settings = Settings::default();
    let entries = entries_of_extras(scene.extras, &scene.element)?;
    apply(&mut settings, &[SETTINGS], &entries, folder, &format!("{}.extras.mie_cloud", scene.element))?;
    let mut named = entries.iter().any(|(key, _)| key == "droplets.material");
    for (key, value) in &options.settings {
        let entries = entries_of_flag(key, value)?;
        apply(&mut settings, &[SETTINGS], &entries, typed, "--set")?;
        named |= entries.iter().any(|(key, _)| key == "droplets.material");
    }
    if let Some(resolution) = options.resolution {
        settings.image.resolution = resolution.map(|side| side.max(1));
    }
    Ok((settings, if named { SceneMaterial::Named } else { SceneMaterial::Open }))
}

/// A pattern that matches nothing is a slip.
fn unmatched(options: &LoadOptions, matches: u64) -> Option<Warning> {
    let pattern = options.droplets_glob.as_ref().filter(|_| matches == 0)?;
    let what = format!("--droplets '{}' matches no node", crate::excerpt::excerpt(pattern));
    Some(Warning::new(what, "* stands for any text and ? for one character; names are case-sensitive"))
}
