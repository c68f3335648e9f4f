//! Renders clouds of droplets with true Lorenz-Mie scattering.
//!
//! Conventions, fixed once: lengths in metres; m = n + ik with k >= 0 for absorption; mu = cos theta = +1 is
//! forward; phase functions integrate to 1 over the sphere; directions `wo`, `wi` point away from the point.
//! The data flow one way: `Settings -> Scene -> EffectPlan -> OpticalTables -> Accel -> render -> Film -> image`.

#![forbid(unsafe_code)]

pub mod accel;
pub mod cli;
pub mod excerpt;
pub mod film;
pub mod image;
pub mod mie;
pub mod optics;
pub mod paper;
pub mod plan;
pub mod scene;
pub mod spectrum;
pub mod study;
pub mod suggest;
pub mod transport;
pub mod units;
pub mod warning;
