//! Wavelengths and colour: the observer, the sun, the bands, linear BT.709.

mod background;
pub mod basis;
pub mod color;
pub mod mode;
pub mod observer;
pub mod sampling;
pub mod sun;
mod table;

pub use mode::{SpectralMode, SpectrumError};
pub use sampling::{Light, SpectralSampling};
