//! The scene as plain data: particles, fog boxes, cameras, suns and settings, whatever file they came from.

pub mod model;
pub mod settings;
