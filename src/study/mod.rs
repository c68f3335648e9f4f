//! Measurements of the program itself and of what it computes: clouds made to measure, particle counts against time, what
//! each effect and each setting costs and changes, what one sphere or a size distribution does to light, and plots of them.

pub mod accuracy;
mod clock;
mod cloud;
pub mod difference;
pub mod effects;
pub mod machine;
pub mod mie_report;
pub mod particles;
pub mod phase_curve;
pub mod plot;
pub mod scatterer;
pub mod trial;

pub use cloud::make_cloud;
pub use mie_report::MieReport;
pub use scatterer::Scatterer;
