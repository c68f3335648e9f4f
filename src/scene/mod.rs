//! The scene as plain data: particles, fog boxes, cameras, suns and settings, whatever file they came from.

pub mod error;
pub mod fog;
pub mod folder;
pub mod frame_cloud;
pub mod generate;
pub mod given;
pub mod glob;
pub mod gltf;
pub mod hash;
mod hints;
pub mod keys;
pub mod load;
pub mod marks;
pub mod model;
pub mod resolved;
pub mod settings;
mod settings_json;
pub mod settings_parse;

pub use error::{SceneError, SceneFault};
pub use load::{LoadOptions, load, load_embedded};
