//! How much two pictures of one scene differ, and whether noise explains it.
//!
//! Legend: a, b values of a pixel and channel; s_a, s_b their recorded standard errors; d = a - b;
//! n the number of pixels compared; Y luminance.

mod layers;
mod map;
mod noise;
mod overlap;
mod report;

use std::collections::BTreeSet;

use thiserror::Error;

use super::picture::Picture;
use super::preview::LUMINANCE;
use layers::channel_difference;
use noise::{mean_ratio, z_scores};
use overlap::{Overlap, Pixel};

pub use map::difference_map;
pub use report::{
    ChannelDifference, Comparison, ErrorSource, LayerDifference, MeanRatio, NonFinitePixel, WorstPixel, ZScores,
};

const COLOURS: [&str; 3] = ["R", "G", "B"];
const ERRORS: [&str; 3] = ["stderr.R", "stderr.G", "stderr.B"];
/// Keeps the relative squared error finite where b is black: Rousselle et al. 2011 (section 5) add a small constant
/// to b^2; here it is this part of the squared mean luminance, so that the unit of the picture does not matter.
const RELATIVE_FLOOR: f64 = 1e-3;

/// Two pictures cannot be compared.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CompareError {
    /// The full frames differ.
    #[error("the frames are {a:?} and {b:?} pixels; only pictures of one frame can be compared")]
    Frame { a: [u32; 2], b: [u32; 2] },
    /// Crops do not overlap.
    #[error("the two crops have no pixel in common")]
    Disjoint,
    /// A colour channel is missing.
    #[error("the {which} picture has no channel `{channel}`; R, G, B are compared")]
    Channel { which: &'static str, channel: &'static str },
    /// A channel's length is not the number of pixels.
    #[error("channel `{0}` does not have one value per pixel")]
    Length(String),
}

/// Compares two pictures where both have pixels; crops are laid over each other by their frames.
///
/// # Errors
/// When the frames differ, crops do not overlap, or R, G, B are missing.
pub fn compare(a: &Picture, b: &Picture) -> Result<Comparison, CompareError> {
    let overlap = Overlap::find(a, b)?;
    let colours_a = channels(a, COLOURS).map_err(|channel| CompareError::Channel { which: "first", channel })?;
    let colours_b = channels(b, COLOURS).map_err(|channel| CompareError::Channel { which: "second", channel })?;
    let pixels: Vec<Pixel> = overlap.pairs().map(|pair| Pixel::gather(pair, &colours_a, &colours_b)).collect();
    let finite: Vec<&Pixel> = pixels.iter().filter(|pixel| pixel.is_finite()).collect();
    let errors = channels(a, ERRORS).ok().zip(channels(b, ERRORS).ok());
    let names =
        |picture: &Picture| picture.channels.iter().map(|channel| channel.name.clone()).collect::<BTreeSet<_>>();
    let (names_a, names_b) = (names(a), names(b));
    let mean_b = mean(&finite, |pixel| luminance(pixel.b));
    let rmse = mean(&finite, |pixel| mean_of(pixel.differences().map(|d| d * d))).sqrt();
    Ok(Comparison {
        n_pixels: pixels.len() as u64,
        n_different: pixels.iter().filter(|pixel| pixel.differs()).count() as u64,
        n_non_finite: (pixels.len() - finite.len()) as u64,
        first_non_finite: pixels.iter().find(|pixel| !pixel.is_finite()).map(|pixel| {
            let [x, y] = place(pixel, a);
            NonFinitePixel { x, y, a: pixel.a, b: pixel.b }
        }),
        rmse,
        relative_rmse: (mean_b > 0.0).then(|| rmse / mean_b),
        relative_mse: relative_mse(&finite, mean_b, rmse),
        mean_ratio: mean_ratio(&finite, errors.as_ref()),
        z: errors.as_ref().and_then(|errors| z_scores(&finite, errors)),
        worst: worst_pixel(&finite, a),
        channels: names_a
            .intersection(&names_b)
            .filter_map(|name| Some(channel_difference(name, &overlap, a.channel(name)?, b.channel(name)?)))
            .collect(),
        only_in_a: names_a.difference(&names_b).cloned().collect(),
        only_in_b: names_b.difference(&names_a).cloned().collect(),
    })
}

fn channels<'a>(picture: &'a Picture, names: [&'static str; 3]) -> Result<[&'a [f32]; 3], &'static str> {
    let get = |name| picture.channel(name).ok_or(name);
    Ok([get(names[0])?, get(names[1])?, get(names[2])?])
}

fn luminance(colour: [f32; 3]) -> f64 {
    colour.iter().zip(LUMINANCE).map(|(value, weight)| weight * f64::from(*value)).sum()
}

fn mean_of(values: [f64; 3]) -> f64 {
    values.iter().sum::<f64>() / 3.0
}

/// Mean over pixels; not a number where there are none.
fn mean(pixels: &[&Pixel], value: impl Fn(&Pixel) -> f64) -> f64 {
    pixels.iter().map(|pixel| value(pixel)).sum::<f64>() / pixels.len() as f64
}

fn relative_mse(pixels: &[&Pixel], mean_b: f64, rmse: f64) -> Option<f64> {
    let floor = RELATIVE_FLOOR * mean_b * mean_b;
    // Without a finite pixel the floor is no number.
    if floor.is_nan() || floor <= 0.0 {
        return (rmse == 0.0).then_some(0.0);
    }
    Some(mean(pixels, |pixel| {
        let differences = pixel.differences();
        mean_of(std::array::from_fn(|colour| {
            differences[colour].powi(2) / (f64::from(pixel.b[colour]).powi(2) + floor)
        }))
    }))
}

fn worst_pixel(pixels: &[&Pixel], a: &Picture) -> Option<WorstPixel> {
    let difference = |pixel: &Pixel| luminance(pixel.a) - luminance(pixel.b);
    let worst = pixels.iter().max_by(|p, q| difference(p).abs().total_cmp(&difference(q).abs()))?;
    let [x, y] = place(worst, a);
    Some(WorstPixel { x, y, a: worst.a, b: worst.b, difference: difference(worst) })
}

/// Column and row of a pixel in the full frame.
fn place(pixel: &Pixel, a: &Picture) -> [i32; 2] {
    let width = a.width as usize;
    [a.frame.x + (pixel.at.0 % width) as i32, a.frame.y + (pixel.at.0 / width) as i32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::picture::Frame;

    pub(in crate::image::compare) fn uniform(width: u32, height: u32, value: f32) -> Picture {
        let mut picture = Picture::new(width, height);
        for name in COLOURS {
            picture.push(name, vec![value; (width * height) as usize]);
        }
        picture
    }

    #[test]
    fn known_differences_give_known_numbers() {
        let (mut a, b) = (uniform(4, 3, 2.0), uniform(4, 3, 1.0));
        let twice = compare(&a, &b).expect("comparable");
        assert_eq!((twice.rmse, twice.relative_rmse), (1.0, Some(1.0)));
        assert!((twice.relative_mse.expect("b is lit") - 1.0 / 1.001).abs() < 1e-12);
        assert_eq!(twice.mean_ratio.expect("b is lit").ratio, 2.0);
        assert_eq!(twice.mean_ratio.expect("b is lit").error, 0.0);
        a.channels[1].values[6] = 5.0;
        let worst = compare(&a, &b).expect("comparable").worst.expect("there are pixels");
        assert_eq!((worst.x, worst.y, worst.a), (2, 1, [2.0, 5.0, 2.0]));
    }

    #[test]
    fn crops_are_laid_over_the_whole() {
        let mut whole = uniform(6, 5, 0.0);
        for channel in &mut whole.channels {
            channel.values = (0..30).map(|index| index as f32).collect();
        }
        let mut crop = uniform(2, 2, 0.0);
        crop.frame = Frame { x: 3, y: 2, full_width: 6, full_height: 5 };
        for channel in &mut crop.channels {
            channel.values = vec![15.0, 16.0, 21.0, 22.5];
        }
        let difference = compare(&crop, &whole).expect("they overlap");
        assert_eq!((difference.n_pixels, difference.n_different), (4, 1));
        assert_eq!(difference.worst.map(|worst| (worst.x, worst.y)), Some((4, 3)));
        crop.frame.x = 7;
        assert_eq!(compare(&crop, &whole), Err(CompareError::Disjoint));
        assert!(matches!(compare(&uniform(5, 5, 0.0), &whole), Err(CompareError::Frame { .. })));
    }

    #[test]
    fn odd_pictures_are_compared_without_numbers_that_are_none() {
        let black = uniform(3, 3, 0.0);
        let both = compare(&black, &black).expect("comparable");
        assert_eq!((both.relative_mse, both.relative_rmse, both.mean_ratio), (Some(0.0), None, None));
        let against_black = compare(&uniform(3, 3, 1.0), &black).expect("comparable");
        assert_eq!((against_black.rmse, against_black.relative_mse), (1.0, None));
        let mut broken = uniform(3, 3, 1.0);
        broken.channels[0].values[4] = f32::NAN;
        let with_nan = compare(&broken, &uniform(3, 3, 1.0)).expect("comparable");
        assert_eq!((with_nan.n_non_finite, with_nan.n_different, with_nan.rmse), (1, 1, 0.0));
        let all_nan = uniform(3, 3, f32::NAN);
        let nothing = compare(&all_nan, &uniform(3, 3, 1.0)).expect("comparable");
        assert!(nothing.rmse.is_nan() && nothing.worst.is_none() && nothing.z.is_none(), "{nothing:?}");
        assert_eq!((nothing.relative_rmse, nothing.relative_mse, nothing.mean_ratio), (None, None, None));
        broken.channels.remove(2);
        let missing = compare(&black, &broken);
        assert_eq!(missing, Err(CompareError::Channel { which: "second", channel: "B" }));
    }
}
