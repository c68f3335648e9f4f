//! Scenes from and to plain glTF 2.0.

pub mod write;
