//! A phase function over the scattering angle, its polarisation below, and its forward peak in an inset.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::PlotError;
use super::axis::{Axis, degrees, even, log_label, log_range, logarithmic};
use super::caption::Caption;
use super::columns::{Column, gather};
use super::style::{BAND, CURVE, GRID, centred, draw_svg, failed, font, pt, ruled};
use crate::study::phase_curve::PhaseCurve;
use crate::units::short::number;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width and height, points.
const SIZE: [f64; 2] = [880.0, 740.0];
/// Heights of caption and upper panel, points.
const CAPTION_HEIGHT: f64 = 62.0;
const PHASE_HEIGHT: f64 = 450.0;
/// Left end of the axes, the margin left of their names, and the margin at the right, points.
const LEFT: f64 = 84.0;
const EDGE: f64 = 12.0;
const RIGHT: f64 = 28.0;
/// Columns of fringes that are too fine to be drawn: one per point.
const COLUMNS: usize = 768;
/// Fringes narrower than this are drawn as a band, degrees: three points.
const FINE_FRINGE_DEG: f64 = 0.7;
/// The inset: left, top, right and bottom in degrees and shares of the panel's height.
const INSET_DEG: [f64; 2] = [67.0, 178.0];
const INSET_SHARE: [f64; 2] = [0.03, 0.46];
/// The inset shows the forward peak from and to these multiples of 1/x; the first dark ring is at 3.83.
const INSET_PEAK: [f64; 2] = [0.1, 50.0];
/// Peaks wider than this need no inset, degrees.
const WIDE_PEAK_DEG: f64 = 2.0;

/// Draws a phase function as SVG.
///
/// # Errors
/// When the curve has no positive value, or the drawing library refuses.
pub fn phase_plot(caption: &Caption, curve: &PhaseCurve) -> Result<String, PlotError> {
    let y = log_range(&curve.phase).ok_or(PlotError::Empty)?;
    let [from, to] = shown_deg(curve);
    let fine = curve.fringe_deg.is_some_and(|fringe| fringe < FINE_FRINGE_DEG * (to - from) / 180.0);
    let columns = if fine { Some(gather(curve, COLUMNS)) } else { None };
    draw_svg(SIZE, |root| {
        let (head, body) = root.split_vertically(pt(CAPTION_HEIGHT));
        let (upper, lower) = body.split_vertically(pt(PHASE_HEIGHT));
        draw_caption(&head, caption)?;
        draw_phase(&upper, curve, columns.as_deref(), &y)?;
        draw_polarization(&lower, curve, columns.as_deref())?;
        draw_inset(&upper, curve, &y)
    })
}

fn draw_caption(area: &Area, caption: &Caption) -> Result<(), PlotError> {
    let middle = (pt(LEFT + 0.5 * (SIZE[0] - LEFT - RIGHT))) as i32;
    // Long descriptions of distributions shrink to fit: letters are half as wide as they are high.
    let fit = |text: &str, points: f64| points.min((SIZE[0] - 40.0) / (0.52 * text.chars().count() as f64));
    for (text, points, y) in [(&caption.title, 17.0, 22.0), (&caption.numbers, 13.0, 46.0)] {
        area.draw_text(text, &centred(fit(text, points)), (middle, pt(y) as i32)).map_err(failed)?;
    }
    Ok(())
}

/// First and last angle of a curve, degrees.
fn shown_deg(curve: &PhaseCurve) -> [f64; 2] {
    [curve.theta_deg.first(), curve.theta_deg.last()].map(|end| end.copied().unwrap_or(0.0))
}

/// Six to twelve labels, at 30 degrees where the whole curve is shown, and grid lines between.
fn angle_axis(curve: &PhaseCurve) -> Axis {
    let [from, to] = shown_deg(curve);
    let span = to - from;
    let power = 10f64.powf((span / 6.0).log10().floor());
    let (label, fine) = match span / 6.0 / power {
        _ if span > 120.0 => (30.0, 10.0),
        steps if steps >= 5.0 => (5.0 * power, power),
        steps if steps >= 2.0 => (2.0 * power, 0.5 * power),
        _ => (power, 0.2 * power),
    };
    even(from..to, label, fine)
}

/// How angles are written on an axis that spans so many degrees.
fn angle_label(span: f64) -> impl Fn(&f64) -> String {
    let decimals = (-(span / 6.0).log10().floor()).clamp(0.0, 9.0) as usize;
    move |deg| format!("{deg:.decimals$}")
}

fn logs<'a>(theta: &'a [f64], values: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    theta.iter().zip(values).filter(|(_, value)| **value > 0.0).map(|(theta, value)| (*theta, value.log10()))
}

fn draw_phase(area: &Area, curve: &PhaseCurve, columns: Option<&[Column]>, y: &Range<f64>) -> Result<(), PlotError> {
    let mut chart = ChartBuilder::on(area)
        .margin_left(pt(EDGE))
        .margin_right(pt(RIGHT))
        .margin_bottom(pt(10.0))
        .set_label_area_size(LabelAreaPosition::Left, pt(LEFT - EDGE))
        .build_cartesian_2d(angle_axis(curve), logarithmic(y.clone(), 10))
        .map_err(failed)?;
    ruled(&mut chart.configure_mesh())
        .y_label_formatter(&log_label(y))
        .y_desc("phase function p(θ) (sr⁻¹)")
        .set_tick_mark_size(LabelAreaPosition::Left, pt(5.0))
        .draw()
        .map_err(failed)?;
    let line = CURVE.stroke_width(pt(1.4));
    let Some(columns) = columns else {
        let points = logs(&curve.theta_deg, &curve.phase);
        chart.draw_series(LineSeries::new(points, line)).map_err(failed)?;
        return Ok(());
    };
    let point = |c: &Column, value: f64| (c.theta_deg, value.max(10f64.powf(y.start)).log10());
    let upper = columns.iter().map(|c| point(c, c.high));
    let outline: Vec<_> = upper.chain(columns.iter().rev().map(|c| point(c, c.low))).collect();
    chart.draw_series([Polygon::new(outline, BAND.filled())]).map_err(failed)?;
    chart.draw_series(LineSeries::new(columns.iter().map(|c| point(c, c.mean)), line)).map_err(failed)?;
    let [from, to] = shown_deg(curve);
    let note = format!("line: mean over {}°, band: minimum to maximum", number(2.0 * (to - from) / COLUMNS as f64));
    let place = (pt(LEFT + 10.0) as i32, pt(PHASE_HEIGHT - 30.0) as i32);
    area.draw_text(&note, &font(11.0), place).map_err(failed)
}

fn draw_polarization(area: &Area, curve: &PhaseCurve, columns: Option<&[Column]>) -> Result<(), PlotError> {
    let [from, to] = shown_deg(curve);
    let mut chart = ChartBuilder::on(area)
        .margin_left(pt(EDGE))
        .margin_right(pt(RIGHT))
        .margin_top(pt(10.0))
        .margin_bottom(pt(8.0))
        .set_label_area_size(LabelAreaPosition::Left, pt(LEFT - EDGE))
        .set_label_area_size(LabelAreaPosition::Bottom, pt(48.0))
        .build_cartesian_2d(angle_axis(curve), even(-1.0..1.0, 0.5, 0.25))
        .map_err(failed)?;
    ruled(&mut chart.configure_mesh())
        .x_label_formatter(&angle_label(to - from))
        .y_label_formatter(&|share| if *share < 0.0 { format!("−{:.1}", -share) } else { format!("{share:.1}") })
        .x_desc("scattering angle θ (degrees)")
        .y_desc("polarisation −S₁₂/S₁₁")
        .set_all_tick_mark_size(pt(5.0))
        .draw()
        .map_err(failed)?;
    let zero = [(from, 0.0), (to, 0.0)];
    chart.draw_series(LineSeries::new(zero, BLACK.mix(0.5).stroke_width(pt(0.7)))).map_err(failed)?;
    let points: Vec<(f64, f64)> = match columns {
        Some(columns) => columns.iter().map(|c| (c.theta_deg, c.degree)).collect(),
        None => {
            let values = curve.polarized.iter().zip(&curve.phase);
            let degrees = values.map(|(polarized, phase)| if *phase > 0.0 { polarized / phase } else { 0.0 });
            curve.theta_deg.iter().copied().zip(degrees).collect()
        }
    };
    chart.draw_series(LineSeries::new(points, CURVE.stroke_width(pt(1.4)))).map_err(failed)?;
    Ok(())
}

/// The forward peak over the logarithm of the angle, where it is too narrow to be seen and the panel has room.
fn draw_inset(area: &Area, curve: &PhaseCurve, y: &Range<f64>) -> Result<(), PlotError> {
    let height = y.end - y.start;
    let floor = y.end - INSET_SHARE[1] * height;
    let covered =
        logs(&curve.theta_deg, &curve.phase).any(|(deg, p)| deg > INSET_DEG[0] - 14.0 && p > floor - 0.08 * height);
    if shown_deg(curve) != [0.0, 180.0] || curve.peak_deg > WIDE_PEAK_DEG || covered {
        return Ok(());
    }
    let [from, to] = INSET_PEAK.map(|multiple| (multiple * curve.peak_deg).min(60.0).log10());
    let inside = |deg: &f64| *deg > 0.0 && (from..=to).contains(&deg.log10());
    let points: Vec<(f64, f64)> =
        logs(&curve.theta_deg, &curve.phase).filter(|(deg, _)| inside(deg)).map(|(deg, p)| (deg.log10(), p)).collect();
    let heights: Vec<f64> = points.iter().map(|(_, p)| 10f64.powf(*p)).collect();
    let Some(inset_y) = log_range(&heights) else { return Ok(()) };
    let per_deg = (SIZE[0] - LEFT - RIGHT) / 180.0;
    let [left, right] = INSET_DEG.map(|deg| LEFT + deg * per_deg);
    let [top, bottom] = INSET_SHARE.map(|share| share * (PHASE_HEIGHT - 10.0));
    let (width, height) = (pt(right - left), pt(bottom - top));
    let frame = area.clone().shrink((pt(left), pt(top)), (width, height));
    frame.fill(&WHITE).map_err(failed)?;
    let border = Rectangle::new([(0, 0), (width as i32, height as i32)], GRID.stroke_width(pt(0.7)));
    frame.draw(&border).map_err(failed)?;
    let mut chart = ChartBuilder::on(&frame)
        .margin_top(pt(8.0))
        .margin_right(pt(10.0))
        .set_label_area_size(LabelAreaPosition::Left, pt(38.0))
        .set_label_area_size(LabelAreaPosition::Bottom, pt(22.0))
        .build_cartesian_2d(logarithmic(from..to, 5), logarithmic(inset_y.clone(), 5))
        .map_err(failed)?;
    ruled(&mut chart.configure_mesh())
        .axis_style(BLACK.stroke_width(pt(0.8)))
        .label_style(font(11.0))
        .x_label_formatter(&|power| degrees(*power))
        .y_label_formatter(&log_label(&inset_y))
        .set_all_tick_mark_size(pt(3.0))
        .draw()
        .map_err(failed)?;
    chart.draw_series(LineSeries::new(points, CURVE.stroke_width(pt(1.2)))).map_err(failed)?;
    let place = ((width - pt(100.0)) as i32, pt(20.0) as i32);
    frame.draw_text("forward peak", &font(12.0), place).map_err(failed)
}
