//! Which glTF extensions may be required: those that are understood, and those that only change surfaces.

use super::document::Document;
use crate::excerpt::excerpt;
use crate::scene::error::{SceneError, SceneFault, SceneResult};

/// Read and used.
const UNDERSTOOD: [&str; 5] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_mesh_quantization",
];

/// Change how surfaces and images look, and so nothing that is rendered here.
const HARMLESS_PREFIXES: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "ADOBE_materials_"];
const HARMLESS: [&str; 4] = ["KHR_animation_pointer", "KHR_xmp", "KHR_xmp_json_ld", "EXT_lights_image_based"];

/// Whether an extension is read.
pub fn is_understood(name: &str) -> bool {
    UNDERSTOOD.contains(&name)
}

/// Whether leaving an extension out cannot change droplets, cameras or suns.
pub fn is_harmless(name: &str) -> bool {
    HARMLESS.contains(&name) || HARMLESS_PREFIXES.iter().any(|prefix| name.starts_with(prefix))
}

/// Refuses files that require what is not understood.
///
/// # Errors
/// Names the extension.
pub fn check_required(document: &Document) -> SceneResult<()> {
    let unknown = document.extensions_required.iter().find(|name| !is_understood(name) && !is_harmless(name));
    let Some(name) = unknown else { return Ok(()) };
    let remedy = if name.contains("compression") || name.contains("meshopt") || name.contains("draco") {
        "export without compression"
    } else {
        "export without it"
    };
    Err(SceneError::at("extensionsRequired", SceneFault::Extension { name: excerpt(name), remedy }))
}
