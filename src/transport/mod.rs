//! Light through droplets and air: free flight, scattering of sunlight, the march through the air, the picture loop.

mod air_path;
mod backdrop;
mod ball;
mod camera;
mod chain;
mod collision;
mod event;
mod flight;
mod forward;
mod glass;
mod glow;
pub mod keep;
mod lighting;
mod march;
mod media;
mod path;
mod place;
mod prepare;
mod random;
mod render;
mod rounds;
mod sample;
mod scratch;
mod sobol;
mod state;
mod transmittance;

pub use backdrop::{Backdrop, BackdropError, LatLong};
pub use ball::{Ball, Branch, Strike, SurfaceEvent, reflectance};
pub use glass::Glass;
pub use glow::{Glow, GlowProbe};
pub use lighting::{Discs, Lighting, SunLight};
pub use media::{Absorption, Media};
pub use prepare::{Counts, PrepareError, Prepared, Stage};
pub use render::{Progress, RayCounts, RenderOutcome, RenderRequest, SilentProgress, Spectral, Until, go_on, render};
pub use sample::RenderContext;
pub use state::RenderState;
