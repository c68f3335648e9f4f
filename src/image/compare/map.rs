//! The difference of two pictures as a picture: red where the first is lighter, blue where it is darker, black where an eye sees
//! no difference.
//!
//! Both are exposed as the second one's preview is, and their lightness L* (CIE 15:2004, equation 8.3) is compared: equal
//! steps of L* look equal.

use super::overlap::{Overlap, Pixel};
use super::{COLOURS, CompareError, channels, luminance};
use crate::image::picture::Picture;
use crate::image::preview::{Preview, expose};

/// This difference of lightness has full colour; a tenth of it is about the least that side by side can be seen.
const FULL_LIGHTNESS: f64 = 20.0;
/// Blue that looks as bright as red: pure blue on black hardly shows.
const BLUE: [f64; 3] = [0.2, 0.45, 1.0];
const RED: [f64; 3] = [1.0, 0.25, 0.15];

/// Draws the difference where both pictures have pixels; values that are not finite are white.
///
/// # Errors
/// As [`super::compare`].
pub fn difference_map(a: &Picture, b: &Picture) -> Result<Preview, CompareError> {
    let overlap = Overlap::find(a, b)?;
    let colours_a = channels(a, COLOURS).map_err(|channel| CompareError::Channel { which: "first", channel })?;
    let colours_b = channels(b, COLOURS).map_err(|channel| CompareError::Channel { which: "second", channel })?;
    let pixels: Vec<Pixel> = overlap.pairs().map(|pair| Pixel::gather(pair, &colours_a, &colours_b)).collect();
    let scale = expose(&pixels.iter().map(|pixel| luminance(pixel.b)).collect::<Vec<f64>>()).scale;
    let [width, height] = overlap.size();
    Ok(Preview { width, height, rgb: pixels.iter().flat_map(|pixel| colour(pixel, scale)).collect() })
}

fn colour(pixel: &Pixel, scale: f64) -> [u8; 3] {
    if !pixel.is_finite() {
        return [255; 3];
    }
    let difference = lightness(scale * luminance(pixel.a)) - lightness(scale * luminance(pixel.b));
    let share = (difference.abs() / FULL_LIGHTNESS).min(1.0);
    // Code values of sRGB are themselves nearly even steps to the eye.
    let hue = if difference > 0.0 { RED } else { BLUE };
    hue.map(|part| (255.0 * share * part).round() as u8)
}

/// CIE lightness L*, 0 to 100, of a luminance relative to white.
fn lightness(y: f64) -> f64 {
    let y = y.clamp(0.0, 1.0);
    let linear_end = (6.0f64 / 29.0).powi(3);
    if y > linear_end { 116.0 * y.cbrt() - 16.0 } else { (29.0f64 / 3.0).powi(3) * y }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: [f32; 4]) -> Picture {
        let mut picture = Picture::new(4, 1);
        COLOURS.iter().for_each(|name| picture.push(*name, values.to_vec()));
        picture
    }

    #[test]
    fn lighter_is_red_darker_blue_and_equal_black() {
        let map = difference_map(&grey([1.0, 1.5, 0.5, f32::NAN]), &grey([1.0; 4])).unwrap();
        assert_eq!((map.width, map.height, &map.rgb[..3], &map.rgb[9..]), (4, 1, &[0; 3][..], &[255; 3][..]));
        assert!(map.rgb[3] > 3 * map.rgb[5] && map.rgb[8] > 3 * map.rgb[6], "{:?}", map.rgb);
    }

    #[test]
    fn lightness_is_that_of_the_standard() {
        // 18 % grey is L* 49.5; both branches meet at 8.
        for (y, l) in [(0.0, 0.0), (0.18, 49.496), (1.0, 100.0), ((6.0f64 / 29.0).powi(3), 8.0)] {
            assert!((lightness(y) - l).abs() < 1e-3, "{y}");
        }
    }
}
