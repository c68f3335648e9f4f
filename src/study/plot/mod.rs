//! Plots as SVG texts: one style for all.

mod axis;
mod caption;
mod columns;
mod counts;
mod labels;
mod log_chart;
mod phase;
mod price;
mod style;

use thiserror::Error;

pub use caption::Caption;
pub use counts::{CountLine, Panel, counts_plot};
pub use phase::phase_plot;
pub use price::{Line, Point, price_plot};

/// A plot could not be drawn.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The drawing library refused.
    #[error("cannot draw the plot: {0}")]
    Draw(String),
    /// There is nothing to draw.
    #[error("cannot draw the plot: no value is above zero")]
    Empty,
}
