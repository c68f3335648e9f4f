//! A chart both of whose axes are logarithmic, with its grid and labels.

use std::ops::Range;

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::PlotError;
use super::axis::{Axis, log_label, logarithmic};
use super::style::{failed, pt, ruled};

/// A chart over powers of ten.
pub type LogChart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Axis, Axis>>;

/// Draws the empty chart over ranges of powers of ten; `left` is the width of the vertical axis' labels, points.
pub fn log_chart<'a>(
    area: &DrawingArea<SVGBackend<'a>, Shift>,
    [x, y]: [&Range<f64>; 2],
    [x_title, y_title]: [&str; 2],
    left: f64,
) -> Result<LogChart<'a>, PlotError> {
    let mut chart = ChartBuilder::on(area)
        .margin_left(pt(12.0))
        .margin_right(pt(24.0))
        .margin_bottom(pt(8.0))
        .set_label_area_size(LabelAreaPosition::Left, pt(left))
        .set_label_area_size(LabelAreaPosition::Bottom, pt(48.0))
        .build_cartesian_2d(logarithmic(x.clone(), 10), logarithmic(y.clone(), 10))
        .map_err(failed)?;
    ruled(&mut chart.configure_mesh())
        .x_label_formatter(&log_label(x))
        .y_label_formatter(&log_label(y))
        .x_desc(x_title)
        .y_desc(y_title)
        .set_all_tick_mark_size(pt(5.0))
        .draw()
        .map_err(failed)?;
    Ok(chart)
}
