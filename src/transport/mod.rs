//! Light through droplets and air: free flight, scattering of sunlight, the march through the air, the picture loop.

mod camera;
mod chain;
mod collision;
mod event;
mod flight;
mod forward;
mod lighting;
mod march;
mod media;
mod path;
mod place;
mod prepare;
mod random;
mod render;
mod sample;
mod transmittance;

pub use lighting::Lighting;
pub use media::{Absorption, Media};
pub use prepare::{Counts, PrepareError, Prepared, Stage};
pub use render::{Progress, RayCounts, RenderOutcome, RenderRequest, SilentProgress, Spectral, Until, render};
pub use sample::RenderContext;
