//! Sizes, colours and the canvas of a plot.
//!
//! The drawing library places points on whole numbers. Plots are therefore drawn on a canvas that is [`FINE`] times as
//! large as they are shown, so that curves are smooth.

use plotters::chart::MeshStyle;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PlotError;
use super::axis::Axis;

/// Canvas units per point of the picture.
const FINE: u32 = 10;

/// The curve; dark blue that also prints well in grey.
pub const CURVE: RGBColor = RGBColor(20, 70, 150);
/// Between the minima and maxima of fringes that are too fine to be drawn.
pub const BAND: RGBColor = RGBColor(170, 197, 232);
/// Lines of the grid, at labels and between them.
pub const GRID: RGBColor = RGBColor(215, 215, 215);
pub const FINE_GRID: RGBColor = RGBColor(240, 240, 240);

/// Colours of Okabe & Ito (2008), told apart by all eyes, a grey, a brown and a dark green: one for each knob of accuracy.
pub const COLOURS: [RGBColor; 11] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(150, 130, 20),
    RGBColor(0, 0, 0),
    RGBColor(120, 120, 120),
    RGBColor(140, 60, 20),
    RGBColor(30, 80, 50),
];

/// Points of the picture in canvas units.
pub fn pt(points: f64) -> u32 {
    (points * f64::from(FINE)).round() as u32
}

/// Text of a size in points.
pub fn font(points: f64) -> TextStyle<'static> {
    ("Helvetica, Arial, sans-serif", f64::from(pt(points))).into_font().color(&BLACK)
}

/// The grid, the axes and the letters of every chart.
pub fn ruled<'m, 'a, 'b, B: DrawingBackend>(
    mesh: &'m mut MeshStyle<'a, 'b, Axis, Axis, B>,
) -> &'m mut MeshStyle<'a, 'b, Axis, Axis, B> {
    mesh.bold_line_style(GRID.stroke_width(pt(0.7)))
        .light_line_style(FINE_GRID.stroke_width(pt(0.5)))
        .axis_style(BLACK.stroke_width(pt(1.0)))
        .label_style(font(13.0))
        .axis_desc_style(font(15.0))
}

/// Text that is centred on its place.
pub fn centred(points: f64) -> TextStyle<'static> {
    font(points).pos(Pos::new(HPos::Center, VPos::Center))
}

/// The error of a drawing call.
pub fn failed<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> PlotError {
    PlotError::Draw(error.to_string())
}

/// Draws a picture of a size in points and returns the SVG text.
pub fn draw_svg(
    [width, height]: [f64; 2],
    draw: impl FnOnce(&DrawingArea<SVGBackend, plotters::coord::Shift>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (pt(width), pt(height))).into_drawing_area();
        area.fill(&WHITE).map_err(failed)?;
        draw(&area)?;
        area.present().map_err(failed)?;
    }
    let canvas = format!("width=\"{}\" height=\"{}\"", pt(width), pt(height));
    Ok(svg.replacen(&canvas, &format!("width=\"{width}\" height=\"{height}\""), 1))
}
