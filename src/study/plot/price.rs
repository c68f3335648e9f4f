//! What accuracy costs, drawn: the error of every setting over its time, one line per knob, both axes logarithmic.

use plotters::prelude::*;

use super::PlotError;
use super::axis::log_range;
use super::labels::Labels;
use super::log_chart::{LogChart, log_chart};
use super::style::{COLOURS, centred, draw_svg, failed, font, pt};

/// A knob's line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The knob's name.
    pub name: String,
    /// Its settings.
    pub points: Vec<Point>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What stands beside the point.
    pub label: String,
    /// Processor seconds.
    pub cpu_s: f64,
    /// Relative error, or what it is at most.
    pub error: f64,
    /// Whether the error is measured; otherwise noise hides it and `error` is what it is at most.
    pub is_measured: bool,
}

/// Width and height, points.
const SIZE: [f64; 2] = [960.0, 640.0];
/// Height of the caption, width of the legend, points.
const CAPTION: f64 = 66.0;
const LEGEND: f64 = 170.0;

/// Draws the lines as SVG; `caption` is two lines, `marks` are errors to be shown as dashed lines.
///
/// # Errors
/// When no error is above zero, or the drawing library refuses.
pub fn price_plot(caption: [&str; 2], lines: &[Line], marks: &[f64]) -> Result<String, PlotError> {
    let points = || lines.iter().flat_map(|line| &line.points).filter(|point| point.error > 0.0);
    let times: Vec<f64> = points().map(|point| point.cpu_s).collect();
    let errors: Vec<f64> = points().map(|point| point.error).collect();
    let (x, y) = (log_range(&times).ok_or(PlotError::Empty)?, log_range(&errors).ok_or(PlotError::Empty)?);
    draw_svg(SIZE, |root| {
        let (head, body) = root.split_vertically(pt(CAPTION));
        let (panel, legend) = body.split_horizontally(pt(SIZE[0] - LEGEND));
        let middle = pt(0.5 * SIZE[0]) as i32;
        head.draw_text(caption[0], &centred(16.0), (middle, pt(22.0) as i32)).map_err(failed)?;
        head.draw_text(caption[1], &centred(11.5), (middle, pt(47.0) as i32)).map_err(failed)?;
        let titles = ["processor seconds of one picture", "error relative to the mean luminance (RMS)"];
        let mut chart = log_chart(&panel, [&x, &y], titles, 70.0)?;
        for mark in marks.iter().filter(|mark| y.contains(&mark.log10())) {
            let line = DashedLineSeries::new(
                [(x.start, mark.log10()), (x.end, mark.log10())],
                pt(5.0),
                pt(4.0),
                BLACK.mix(0.55).stroke_width(pt(0.8)),
            );
            chart.draw_series(line).map_err(failed)?;
            let offset = (-(pt(40.0) as i32), -(pt(13.0) as i32));
            let grey = BLACK.mix(0.55);
            let text = Text::new(format!("{} %", 100.0 * mark), offset, font(10.0).color(&grey));
            chart.draw_series([EmptyElement::at((x.end, mark.log10())) + text]).map_err(failed)?;
        }
        let place = |chart: &LogChart, point: &Point| {
            let (x, y) = chart.backend_coord(&(point.cpu_s.log10(), point.error.log10()));
            [x, y].map(|pixels| f64::from(pixels) / f64::from(pt(1.0)))
        };
        let mut labels = Labels::default();
        points().for_each(|point| labels.keep_off(place(&chart, point)));
        for (number, line) in lines.iter().enumerate() {
            let colour = COLOURS[number % COLOURS.len()];
            let shown: Vec<&Point> = line.points.iter().filter(|point| point.error > 0.0).collect();
            let at = |point: &Point| (point.cpu_s.log10(), point.error.log10());
            let path = LineSeries::new(shown.iter().map(|point| at(point)), colour.stroke_width(pt(1.4)));
            chart.draw_series(path).map_err(failed)?;
            for point in &shown {
                let filled = if point.is_measured { colour.filled() } else { WHITE.filled() };
                let circles = [
                    Circle::new(at(point), pt(3.5), filled),
                    Circle::new(at(point), pt(3.5), colour.stroke_width(pt(1.3))),
                ];
                chart.draw_series(circles).map_err(failed)?;
            }
            for point in &shown {
                let Some(offset) = labels.place(place(&chart, point), &point.label) else { continue };
                let offset = offset.map(|points| (points * f64::from(pt(1.0))) as i32);
                let text = Text::new(point.label.clone(), (offset[0], offset[1]), font(9.5).color(&colour));
                chart.draw_series([EmptyElement::at(at(point)) + text]).map_err(failed)?;
            }
            draw_entry(&legend, number, &line.name, colour)?;
        }
        let below = 40.0 + 22.0 * lines.len() as f64;
        for (row, text) in ["filled: measured", "open: at most, noise", "hides the rest"].iter().enumerate() {
            let place = (pt(8.0) as i32, pt(below + 16.0 * row as f64) as i32);
            legend.draw_text(text, &font(11.0), place).map_err(failed)?;
        }
        Ok(())
    })
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw_entry(legend: &Area, number: usize, name: &str, colour: RGBColor) -> Result<(), PlotError> {
    let y = 20.0 + 22.0 * number as f64;
    let line = [(pt(8.0) as i32, pt(y) as i32), (pt(32.0) as i32, pt(y) as i32)];
    legend.draw(&PathElement::new(line, colour.stroke_width(pt(2.0)))).map_err(failed)?;
    legend.draw_text(name, &font(13.0).color(&colour), (pt(38.0) as i32, pt(y - 8.0) as i32)).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_and_setting_is_named_and_nothing_to_draw_is_an_error() {
        let point = |label: &str, cpu_s, error| Point { label: label.into(), cpu_s, error, is_measured: true };
        let line = Line { name: "bands".into(), points: vec![point("four", 0.1, 0.05), point("eight", 0.2, 0.01)] };
        let svg = price_plot(["title", "numbers"], std::slice::from_ref(&line), &[0.02]).unwrap();
        for text in ["title", "numbers", "bands", "four", "eight", "processor seconds"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(matches!(price_plot(["", ""], &[], &[]), Err(PlotError::Empty)));
    }
}
