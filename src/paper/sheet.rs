//! The contact sheet: a row per figure, a column per method, with the numbers that belong to each.

use std::convert::Infallible;

use embedded_graphics::mono_font::ascii::{FONT_7X13, FONT_7X13_BOLD, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::{DrawTarget, Drawable, OriginDimensions, Pixel, Point, RgbColor, Size};
use embedded_graphics::text::{Baseline, Text};

use super::figures::WAVELENGTHS_NM;
use super::study::{Column, Method, Numbers, Study};
use super::table::{caption, short};
use super::tone::show;
use crate::image::preview::{Preview, PreviewError};

/// Everything is laid out on this spacing, pixels.
const GAP: u32 = 12;
/// Width of the words beside the pictures.
const WORDS: u32 = 340;
/// Height of title and column heads.
const HEAD: u32 = 134;
/// Height of the two lines of numbers below a picture.
const NUMBERS: u32 = 34;
/// From line to line of the small letters.
const LINE: u32 = 16;

const PAPER: Rgb888 = Rgb888::new(24, 24, 28);
const INK: Rgb888 = Rgb888::new(232, 232, 232);
const GREY: Rgb888 = Rgb888::new(160, 160, 165);
const YES: Rgb888 = Rgb888::new(150, 220, 130);
const NO: Rgb888 = Rgb888::new(255, 150, 90);
/// Numbers of red, green and blue in light tints of these colours.
const TINTS: [Rgb888; 3] = [Rgb888::new(255, 130, 120), Rgb888::new(130, 230, 130), Rgb888::new(130, 170, 255)];

/// Draws the sheet. Every picture is exposed on its own.
///
/// # Errors
/// When a picture lacks a colour.
pub fn contact_sheet(studies: &[Study]) -> Result<Preview, PreviewError> {
    let largest = |side: fn(&Column) -> u32| studies.iter().flat_map(|s| &s.columns).map(side).max().unwrap_or(1);
    let (width, height) = (largest(|c| c.picture.width), largest(|c| c.picture.height));
    let row = height + NUMBERS + GAP;
    let columns = Method::ALL.len() as u32;
    let mut sheet = Canvas::new(GAP + WORDS + columns * (width + GAP), HEAD + studies.len() as u32 * row + GAP);
    let left = |column: u32| GAP + WORDS + column * (width + GAP);
    head(&mut sheet, left, studies);
    for (top, study) in (HEAD..).step_by(row as usize).zip(studies) {
        words(&mut sheet, top, study);
        for (column, made) in (0..).zip(&study.columns) {
            sheet.paste(left(column), top, &show(&made.picture)?);
            let below = top + height + 4;
            line_of_three(&mut sheet, left(column), below, "Q_sca", &made.numbers, |n| format!("{:.4}", n.q_sca));
            let end =
                line_of_three(&mut sheet, left(column), below + LINE, "g", &made.numbers, |n| format!("{:.2}", n.g));
            let ratio = |n: &Numbers| short(n.forward_over_backward);
            line_of_three(&mut sheet, end + 14, below + LINE, "p(0)/p(180)", &made.numbers, ratio);
        }
    }
    Ok(sheet.pixels)
}

/// Title, what is seen, and the heads of the columns.
fn head(sheet: &mut Canvas, left: impl Fn(u32) -> u32, studies: &[Study]) {
    sheet.write(GAP, GAP, "Ten figures of one droplet, three ways", &FONT_10X20, INK);
    let [red, green, blue] = WAVELENGTHS_NM.map(|nm| nm.to_string());
    let lines = [
        format!(
            "Water (n = 1.33), drawn a metre wide; white light (red {red}, green {green}, blue {blue} nm) from the upper \
             left; the air is lit by the droplet alone."
        ),
        "Each picture is exposed on its own, brightness on a logarithmic scale: compare colours and directions.".into(),
    ];
    for (i, line) in (0..).zip(&lines) {
        sheet.write(GAP, GAP + 26 + i * LINE, line, &FONT_7X13, GREY);
    }
    let effects = studies.first().and_then(|study| study.columns.last()).map_or("", |column| column.effects.as_str());
    let heads = [
        ("The paper's code listing", "j_n in place of psi_n; HG phase, g = 0.9".to_owned()),
        ("The paper's equations", "psi_n, xi_n; HG phase, g = 0.9".to_owned()),
        ("Exact Mie", effects.to_owned()),
    ];
    for (column, (name, note)) in (0..).zip(heads) {
        sheet.write(left(column), HEAD - 58, name, &FONT_10X20, INK);
        let letters = (left(1) - left(0) - GAP) / FONT_7X13.character_size.width;
        for (i, line) in (0..).zip(wrap(&note, letters)) {
            sheet.write(left(column), HEAD - 36 + i * LINE, &line, &FONT_7X13, GREY);
        }
    }
}

/// The figure's droplet, caption and verdict.
fn words(sheet: &mut Canvas, top: u32, study: &Study) {
    let title = format!("{}.  {} nm", study.figure.number, study.figure.diameter_nm);
    sheet.write(GAP, top, &title, &FONT_10X20, INK);
    let mut y = top + 28;
    let mut paragraph = |text: &str, font, color| {
        for line in wrap(text, (WORDS - GAP) / FONT_7X13.character_size.width) {
            sheet.write(GAP, y, &line, font, color);
            y += LINE;
        }
        y += 4;
    };
    let (answer, color) = match study.verdict.holds {
        Some(true) => ("In exact Mie: yes", YES),
        Some(false) => ("In exact Mie: no", NO),
        None => (study.verdict.answer(), GREY),
    };
    if let Some(caption) = caption(study) {
        paragraph(&format!("Caption: {caption}"), &FONT_7X13, INK);
    }
    paragraph(answer, &FONT_7X13_BOLD, color);
    paragraph(&study.verdict.evidence, &FONT_7X13, GREY);
}

/// A name and its numbers for red, green and blue; returns where the line ends.
fn line_of_three(
    sheet: &mut Canvas,
    left: u32,
    top: u32,
    name: &str,
    numbers: &[Numbers; 3],
    format: impl Fn(&Numbers) -> String,
) -> u32 {
    let mut x = sheet.write(left, top, name, &FONT_7X13, GREY);
    for (number, tint) in numbers.iter().zip(TINTS) {
        x = sheet.write(x + FONT_7X13.character_size.width, top, &format(number), &FONT_7X13, tint);
    }
    x
}

/// Breaks a text into lines of at most `width` letters, between words.
fn wrap(text: &str, width: u32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= width as usize => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// A picture to draw on.
struct Canvas {
    pixels: Preview,
}

impl Canvas {
    fn new(width: u32, height: u32) -> Self {
        let background = [PAPER.r(), PAPER.g(), PAPER.b()];
        let n_pixels = width as usize * height as usize;
        Self { pixels: Preview { width, height, rgb: background.repeat(n_pixels) } }
    }

    /// Sets a pixel; what lies outside is left out.
    fn set(&mut self, x: u32, y: u32, rgb: &[u8]) {
        if x >= self.pixels.width || y >= self.pixels.height {
            return;
        }
        let place = 3 * (y as usize * self.pixels.width as usize + x as usize);
        if let Some(pixel) = self.pixels.rgb.get_mut(place..place + 3) {
            pixel.copy_from_slice(rgb);
        }
    }

    fn paste(&mut self, left: u32, top: u32, picture: &Preview) {
        for (i, rgb) in (0..).zip(picture.rgb.chunks_exact(3)) {
            self.set(left + i % picture.width, top + i / picture.width, rgb);
        }
    }

    /// Writes a line; returns where it ends.
    fn write(&mut self, left: u32, top: u32, text: &str, font: &MonoFont, color: Rgb888) -> u32 {
        let style = MonoTextStyle::new(font, color);
        let at = Point::new(left as i32, top as i32);
        let end = Text::with_baseline(text, at, style, Baseline::Top).draw(self).unwrap_or(at);
        end.x.max(0) as u32
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.pixels.width, self.pixels.height)
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(at.x), u32::try_from(at.y)) {
                self.set(x, y, &[color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words() {
        assert_eq!(wrap("a bc def", 4), ["a bc", "def"]);
        assert_eq!(wrap("longer than it", 3), ["longer", "than", "it"]);
        assert!(wrap("", 3).is_empty());
    }

    #[test]
    fn what_lies_outside_of_the_canvas_is_left_out() {
        let mut canvas = Canvas::new(20, 10);
        let end = canvas.write(15, 0, "WWWW", &FONT_7X13, INK);
        assert_eq!(end, 15 + 4 * 7);
        canvas.paste(18, 8, &Preview { width: 4, height: 4, rgb: vec![255; 48] });
        assert_eq!(canvas.pixels.rgb.len(), 600);
        assert_eq!(canvas.pixels.rgb[597..], [255; 3]);
    }
}
