//! How the contact sheet shows a picture: brightness on a logarithmic scale, colour kept.
//!
//! A preview's curve takes each channel by itself, which whitens what is bright. Here colour is what is to be compared, and
//! the droplet is some hundred times as bright as the air that it lights.

use crate::image::Picture;
use crate::image::preview::{Preview, PreviewError, quantise};

/// Brightness at which the scale turns from linear to logarithmic, as a part of the brightest.
const KNEE: f64 = 0.01;

/// The brightest is what a thousandth of the pixels exceed.
const BRIGHTEST_SHARE: f64 = 0.999;

/// Shows a picture. The brightness of a pixel is its largest channel v; it becomes ln(1 + v/k) / ln(1 + 1/k) with
/// v relative to the brightest and k the knee, and all three channels are scaled by the same factor.
///
/// # Errors
/// When R, G or B is missing.
pub fn show(picture: &Picture) -> Result<Preview, PreviewError> {
    let channel = |name: &'static str| picture.channel(name).ok_or(PreviewError::Channel(name));
    let (red, green, blue) = (channel("R")?, channel("G")?, channel("B")?);
    let pixels: Vec<[f64; 3]> = red
        .iter()
        .zip(green)
        .zip(blue)
        .map(|((r, g), b)| [*r, *g, *b].map(|value| f64::from(value).max(0.0)))
        .collect();
    let mut brightness: Vec<f64> = pixels.iter().map(largest).collect();
    brightness.sort_unstable_by(f64::total_cmp);
    let rank = (BRIGHTEST_SHARE * brightness.len() as f64) as usize;
    let white = brightness.get(rank).copied().unwrap_or_default();
    let rgb = pixels.iter().flat_map(|pixel| pixel.map(|value| quantise(value * scale(largest(pixel), white))));
    Ok(Preview { width: picture.width, height: picture.height, rgb: rgb.collect() })
}

fn largest(pixel: &[f64; 3]) -> f64 {
    pixel.iter().copied().fold(0.0, f64::max)
}

/// What a pixel of brightness `v` is multiplied by.
fn scale(v: f64, white: f64) -> f64 {
    if v <= 0.0 || white <= 0.0 {
        return 0.0;
    }
    let relative = (v / white).min(1.0);
    (relative / KNEE).ln_1p() / (1.0 / KNEE).ln_1p() / v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(pixels: &[[f32; 3]]) -> Vec<u8> {
        let mut picture = Picture::new(pixels.len() as u32, 1);
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            picture.push(name, pixels.iter().map(|pixel| pixel[c]).collect());
        }
        show(&picture).expect("R, G, B are there").rgb
    }

    #[test]
    fn colour_is_kept_at_every_brightness() {
        let rgb = shown(&[[4e-3, 2e-3, 1e-3], [4.0, 2.0, 1.0], [4.0, 4.0, 4.0], [0.0, 0.0, 0.0]]);
        assert_eq!(rgb[3..6], [255, 188, 137]);
        assert_eq!(rgb[6..], [255, 255, 255, 0, 0, 0]);
        assert!(rgb[0] > rgb[1] && rgb[1] > rgb[2] && rgb[2] > 0, "{rgb:?}");
    }

    #[test]
    fn odd_values_show_black_or_white_and_nothing_breaks() {
        assert_eq!(shown(&[[0.0; 3], [-1.0; 3], [f32::NAN; 3]]), [0; 9]);
    }
}
