//! Exposure and tone curve: what a picture looks like on a screen, without any setting.
//!
//! Exposure puts the log-average luminance at middle gray (Reinhard et al. 2002, equations 1 and 2), but keeps the
//! bright part of the picture between a light gray and the curve's shoulder. The curve is Reinhard's extended one
//! (equation 4) for each channel, whose white is the brightest percentile: a picture without highlights stays linear.

use thiserror::Error;

use super::picture::Picture;

/// Middle gray of the log-average (Reinhard et al. 2002, section 2.1).
const MIDDLE_GRAY: f64 = 0.18;
/// The bright part of a picture is its 99th percentile: a sun's disc or single bright drops cover less.
const BRIGHT_SHARE: f64 = 0.99;
/// Exposed, the bright part is no darker than this: a gray field appears as a light gray, sRGB 188 of 255.
const LEAST_BRIGHT: f64 = 0.5;
/// And no brighter than this, two stops above white, so that shapes inside it survive the curve.
const MOST_BRIGHT: f64 = 4.0;
/// What the curve turns into white: the luminance that a thousandth of the picture exceeds,
const WHITE_SHARE: f64 = 0.999;
/// but at most four stops above a white surface, or everything else would be dim.
const MOST_WHITE: f64 = 16.0;
/// Pixels below this part of the brightest hundredth count as black background, and do not take part in exposure.
const BLACK: f64 = 1e-5;
/// Luminance of linear BT.709 (ITU-R BT.709-6, item 3.2).
pub(super) const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A picture has nothing to show.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PreviewError {
    /// A colour channel is missing or has a wrong length.
    #[error("a preview needs the channels R, G, B with one value per pixel; `{0}` is not there")]
    Channel(&'static str),
}

/// How a picture is exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Factor from pixel value to exposed value; 1 exposed is a white surface.
    pub scale: f64,
    /// Exposed value that the curve turns into white, at least 1.
    pub white: f64,
}

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preview {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// R, G, B of each pixel, row by row.
    pub rgb: Vec<u8>,
}

/// Exposes and tone-maps a picture's R, G, B. Black stays black; values that are negative or not numbers show black.
///
/// # Errors
/// When R, G or B is missing.
pub fn develop(picture: &Picture) -> Result<Preview, PreviewError> {
    let [red, green, blue] = [colour(picture, "R")?, colour(picture, "G")?, colour(picture, "B")?];
    let exposure = expose(&luminances(red, green, blue));
    let rgb = red
        .iter()
        .zip(green)
        .zip(blue)
        .flat_map(|((red, green), blue)| [*red, *green, *blue].map(|value| quantise(exposure.tone(f64::from(value)))))
        .collect();
    Ok(Preview { width: picture.width, height: picture.height, rgb })
}

impl Exposure {
    /// The tone-mapped linear value of a pixel value, 0 to 1.
    pub fn tone(self, value: f64) -> f64 {
        if value.is_nan() || value <= 0.0 {
            return 0.0;
        }
        let exposed = value * self.scale;
        if exposed >= self.white {
            return 1.0;
        }
        exposed * (1.0 + exposed / (self.white * self.white)) / (1.0 + exposed)
    }
}

/// Finds the exposure for pixels of the given luminances.
pub fn expose(luminances: &[f64]) -> Exposure {
    let mut lit: Vec<f64> = luminances.iter().copied().filter(|value| *value > 0.0 && value.is_finite()).collect();
    lit.sort_unstable_by(f64::total_cmp);
    let floor = BLACK * percentile(&lit, BRIGHT_SHARE);
    lit.drain(..lit.partition_point(|value| *value < floor));
    if lit.is_empty() {
        return Exposure { scale: 1.0, white: 1.0 };
    }
    let log_mean = (lit.iter().map(|value| value.ln()).sum::<f64>() / lit.len() as f64).exp();
    let bright = percentile(&lit, BRIGHT_SHARE);
    let scale = (MIDDLE_GRAY / log_mean).clamp(LEAST_BRIGHT / bright, MOST_BRIGHT / bright);
    Exposure { scale, white: (scale * percentile(&lit, WHITE_SHARE)).clamp(1.0, MOST_WHITE) }
}

fn colour<'a>(picture: &'a Picture, name: &'static str) -> Result<&'a [f32], PreviewError> {
    picture.channel(name).filter(|values| values.len() as u64 == picture.n_pixels()).ok_or(PreviewError::Channel(name))
}

fn luminances(red: &[f32], green: &[f32], blue: &[f32]) -> Vec<f64> {
    let weigh = |((red, green), blue): ((&f32, &f32), &f32)| {
        LUMINANCE[0] * f64::from(*red) + LUMINANCE[1] * f64::from(*green) + LUMINANCE[2] * f64::from(*blue)
    };
    red.iter().zip(green).zip(blue).map(weigh).collect()
}

/// The value that the given share of sorted values do not exceed; 0 where there are none.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

/// Encodes a linear value with the sRGB curve (IEC 61966-2-1) in 8 bits.
pub fn quantise(linear: f64) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: Vec<f32>) -> Picture {
        let mut picture = Picture::new(values.len() as u32, 1);
        for name in ["R", "G", "B"] {
            picture.push(name, values.clone());
        }
        picture
    }

    /// The first of the three equal bytes of each pixel.
    fn shown(values: Vec<f32>) -> Vec<u8> {
        let preview = develop(&gray(values)).expect("R, G, B are there");
        preview.rgb.chunks(3).map(|pixel| pixel[0]).collect()
    }

    #[test]
    fn black_stays_black_and_nothing_breaks_on_odd_values() {
        assert_eq!(shown(vec![0.0; 4]), [0; 4]);
        assert_eq!(shown(vec![-1.0, f32::NAN, 0.0]), [0; 3]);
        assert_eq!(shown(vec![f32::INFINITY, 0.0])[1], 0);
        assert_eq!(shown(vec![f32::MAX, f32::MIN_POSITIVE])[0], 188);
    }

    #[test]
    fn the_scale_of_the_values_does_not_matter() {
        let ramp: Vec<f32> = (1..=100).map(|step| step as f32).collect();
        let faint = ramp.iter().map(|value| value * 2f32.powi(-40)).collect();
        assert_eq!(shown(ramp), shown(faint));
    }

    #[test]
    fn a_tiny_bright_sun_does_not_darken_the_picture() {
        let mut values = vec![0.2_f32; 10_000];
        let plain = shown(values.clone())[0];
        values[5000] = 1e6;
        let with_sun = shown(values);
        assert_eq!(with_sun[5000], 255);
        assert!(with_sun[0].abs_diff(plain) <= 1, "{} and {plain}", with_sun[0]);
    }

    #[test]
    fn a_black_background_does_not_blow_out_what_is_lit() {
        let lit: Vec<f32> = (0..1000).map(|step| 1.0 + step as f32 / 250.0).collect();
        let mut with_background = lit.clone();
        with_background.extend(vec![0.0; 100_000]);
        assert_eq!(shown(with_background)[..1000], shown(lit)[..]);
    }

    #[test]
    fn the_curve_rises_from_black_to_white() {
        for exposure in [Exposure { scale: 1.0, white: 1.0 }, Exposure { scale: 0.3, white: 7.0 }] {
            let tones: Vec<f64> = (0..=1000).map(|step| exposure.tone(f64::from(step) * 0.03)).collect();
            assert!(tones.is_sorted());
            assert_eq!((tones[0], tones[1000]), (0.0, 1.0));
            // The curve meets white without a step: at the white point its formula gives exactly 1.
            assert!((exposure.tone(exposure.white / exposure.scale * (1.0 - 1e-9)) - 1.0).abs() < 1e-8);
        }
    }

    #[test]
    fn the_srgb_curve_has_its_known_values() {
        assert_eq!([0.0, 0.18, 0.5, 1.0].map(quantise), [0, 118, 188, 255]);
    }

    #[test]
    fn a_missing_channel_is_named() {
        let mut picture = gray(vec![1.0]);
        picture.channels.remove(1);
        assert_eq!(develop(&picture), Err(PreviewError::Channel("G")));
    }
}
