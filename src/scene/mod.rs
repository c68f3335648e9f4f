//! The scene as plain data: particles, fog boxes, cameras, suns and settings, whatever file they came from.

pub mod generate;
pub mod gltf;
pub mod model;
pub mod settings;
