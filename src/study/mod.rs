//! Measurements of the program itself: clouds made to measure, particle counts against time.

mod cloud;
pub mod particles;

pub use cloud::make_cloud;
