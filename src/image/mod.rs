//! Pictures: named channels of floats with attributes, and the files they are written to and read from.

pub mod compare;
pub mod exr;
pub mod file;
pub mod picture;
pub mod png;
pub mod preview;
pub mod sealed;
pub mod spectral;

pub use file::Existing;
pub use picture::{Attribute, Channel, Chromaticities, Frame, Picture, PictureError};
