//! Particle counts against time and against rays per second: two panels, all axes logarithmic.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::PlotError;
use super::axis::log_range;
use super::log_chart::log_chart;
use super::style::{COLOURS, centred, draw_svg, failed, font, pt};

/// A line of a panel: a value for each count, with its least and greatest.
#[derive(Clone, Debug, PartialEq)]
pub struct CountLine {
    /// Its name.
    pub name: String,
    /// Count; median, least, greatest.
    pub points: Vec<(f64, [f64; 3])>,
}

/// Lines that share an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What the axis shows.
    pub title: String,
    /// The lines.
    pub lines: Vec<CountLine>,
}

/// Width and height, points.
const SIZE: [f64; 2] = [1080.0, 560.0];
/// Height of the caption, of the legend, points.
const CAPTION: f64 = 66.0;
const LEGEND: f64 = 66.0;
/// Entries of a legend in a row, and the width of one, points.
const IN_A_ROW: usize = 4;
const ENTRY: f64 = 122.0;

/// Draws two panels side by side as SVG; `caption` is two lines.
///
/// # Errors
/// When no value of a panel is above zero, or the drawing library refuses.
pub fn counts_plot(caption: [&str; 2], panels: &[Panel; 2]) -> Result<String, PlotError> {
    draw_svg(SIZE, |root| {
        let (head, body) = root.split_vertically(pt(CAPTION));
        let middle = pt(0.5 * SIZE[0]) as i32;
        head.draw_text(caption[0], &centred(16.0), (middle, pt(22.0) as i32)).map_err(failed)?;
        head.draw_text(caption[1], &centred(11.0), (middle, pt(47.0) as i32)).map_err(failed)?;
        let (left, right) = body.split_horizontally(pt(0.5 * SIZE[0]));
        draw_panel(&left, &panels[0])?;
        draw_panel(&right, &panels[1])
    })
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn draw_panel(area: &Area, panel: &Panel) -> Result<(), PlotError> {
    let all = || panel.lines.iter().flat_map(|line| &line.points).filter(|(_, [median, ..])| *median > 0.0);
    let counts: Vec<f64> = all().map(|(count, _)| *count).collect();
    let values: Vec<f64> = all().flat_map(|(_, three)| *three).collect();
    let x = log_range(&counts).ok_or(PlotError::Empty)?;
    let y = log_range(&values).ok_or(PlotError::Empty)?;
    let (legend, plot) = area.split_vertically(pt(LEGEND));
    let mut chart = log_chart(&plot, [&x, &y], ["droplets", &panel.title], 64.0)?;
    for (number, line) in panel.lines.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let shown: Vec<_> = line.points.iter().filter(|(_, [median, ..])| *median > 0.0).collect();
        let middles = shown.iter().map(|(count, [median, ..])| (count.log10(), median.log10()));
        chart.draw_series(LineSeries::new(middles.clone(), colour.stroke_width(pt(1.4)))).map_err(failed)?;
        chart.draw_series(middles.map(|at| Circle::new(at, pt(3.0), colour.filled()))).map_err(failed)?;
        let bars = shown.iter().map(|(count, [_, least, greatest])| bar(*count, *least..*greatest, &y, colour));
        chart.draw_series(bars).map_err(failed)?;
        draw_entry(&legend, number, &line.name, colour)?;
    }
    Ok(())
}

/// From the least to the greatest.
fn bar(count: f64, values: Range<f64>, y: &Range<f64>, colour: RGBColor) -> PathElement<(f64, f64)> {
    let log = |value: f64| value.log10().clamp(y.start, y.end);
    PathElement::new(
        [(count.log10(), log(values.start)), (count.log10(), log(values.end))],
        colour.stroke_width(pt(1.2)),
    )
}

fn draw_entry(legend: &Area, number: usize, name: &str, colour: RGBColor) -> Result<(), PlotError> {
    let (row, column) = (number / IN_A_ROW, number % IN_A_ROW);
    let (x, y) = (40.0 + ENTRY * column as f64, 16.0 + 22.0 * row as f64);
    let line = [(pt(x) as i32, pt(y) as i32), (pt(x + 22.0) as i32, pt(y) as i32)];
    legend.draw(&PathElement::new(line, colour.stroke_width(pt(2.0)))).map_err(failed)?;
    legend.draw_text(name, &font(13.0).color(&colour), (pt(x + 27.0) as i32, pt(y - 8.0) as i32)).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_name_their_lines_and_nothing_to_draw_is_an_error() {
        let line =
            |name: &str| CountLine { name: name.into(), points: vec![(1e3, [0.1, 0.09, 0.2]), (1e4, [1.0, 0.9, 1.2])] };
        let panel = |title: &str| Panel { title: title.into(), lines: vec![line("tree"), line("render")] };
        let svg = counts_plot(["above", "below"], &[panel("seconds"), panel("rays")]).unwrap();
        for text in ["above", "below", "tree", "render", "seconds", "rays", "droplets"] {
            assert!(svg.contains(text), "{text}");
        }
        let empty = Panel { title: String::new(), lines: Vec::new() };
        assert!(matches!(counts_plot(["", ""], &[empty.clone(), empty]), Err(PlotError::Empty)));
    }
}
