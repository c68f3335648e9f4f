//! How much two pictures of one scene differ, and whether noise explains it.
//!
//! Legend: a, b values of a pixel and channel; s_a, s_b their recorded standard errors; d = a - b;
//! n the number of pixels compared; Y luminance.

mod layers;
mod map;
mod overlap;
mod report;

use std::collections::BTreeSet;

use thiserror::Error;

use super::picture::Picture;
use super::preview::LUMINANCE;
use layers::channel_difference;
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

/// Recorded standard errors of both pictures, channel by channel.
type Errors<'a> = ([&'a [f32]; 3], [&'a [f32]; 3]);

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

/// Ratio r = mean Y_a / mean Y_b. Its error to first order: from recorded errors, var r = (var m_a + r^2 var m_b) / m_b^2;
/// from scatter, where any pixel's error is missing or no number, the variance of Y_a - r Y_b between pixels over n m_b^2 (Cochran 1977, equation 6.13).
fn mean_ratio(pixels: &[&Pixel], errors: Option<&Errors<'_>>) -> Option<MeanRatio> {
    let n = pixels.len() as f64;
    let (mean_a, mean_b) = (mean(pixels, |pixel| luminance(pixel.a)), mean(pixels, |pixel| luminance(pixel.b)));
    if mean_b.is_nan() || mean_b <= 0.0 {
        return None;
    }
    let ratio = mean_a / mean_b;
    let is_known = |errors: &&Errors| pixels.iter().all(|pixel| pixel.errors(errors).iter().all(|e| e.is_finite()));
    let (variance, error_from) = match errors.filter(is_known) {
        Some((a, b)) => {
            let variance = |errors: &[&[f32]; 3], index: usize| luminance(errors.map(|values| values[index])).powi(2);
            let sum = mean(pixels, |pixel| variance(a, pixel.at.0) + ratio * ratio * variance(b, pixel.at.1));
            (sum / n, ErrorSource::Recorded)
        }
        None => {
            let scatter = mean(pixels, |pixel| (luminance(pixel.a) - ratio * luminance(pixel.b)).powi(2));
            (scatter / (n - 1.0).max(1.0), ErrorSource::Scatter)
        }
    };
    Some(MeanRatio { ratio, error: variance.sqrt() / mean_b, error_from })
}

fn z_scores(pixels: &[&Pixel], errors: &Errors<'_>) -> Option<ZScores> {
    let (mut z, mut n_unexplained) = (Vec::new(), 0);
    for pixel in pixels {
        for (difference, error) in pixel.differences().into_iter().zip(pixel.errors(errors)) {
            if error > 0.0 && error.is_finite() {
                z.push(difference / error);
            } else if difference != 0.0 {
                n_unexplained += 1;
            }
        }
    }
    if z.is_empty() && n_unexplained == 0 {
        return None;
    }
    let n = z.len().max(1) as f64;
    Some(ZScores {
        n: z.len() as u64,
        // The sum of nothing is -0.
        mean: z.iter().sum::<f64>() / n + 0.0,
        rms: (z.iter().map(|z| z * z).sum::<f64>() / n + 0.0).sqrt(),
        max: z.iter().fold(0.0, |max, z| max.max(z.abs())),
        share_beyond_3: z.iter().filter(|z| z.abs() > 3.0).count() as f64 / n,
        n_unexplained,
    })
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
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::image::picture::Frame;

    fn uniform(width: u32, height: u32, value: f32) -> Picture {
        let mut picture = Picture::new(width, height);
        for name in COLOURS {
            picture.push(name, vec![value; (width * height) as usize]);
        }
        picture
    }

    /// Gray with independent noise of the given standard error, which is recorded.
    fn noisy(side: u32, value: f32, error: f32, seed: u64) -> Picture {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut picture = uniform(side, side, value);
        // The sum of 12 uniform numbers less 6 has variance 1 and is close to normal.
        let mut normal = || (0..12).map(|_| rng.random::<f32>()).sum::<f32>() - 6.0;
        for pixel in 0..(side * side) as usize {
            let noise = error * normal();
            picture.channels.iter_mut().for_each(|channel| channel.values[pixel] += noise);
        }
        for name in ERRORS {
            picture.push(name, vec![error; (side * side) as usize]);
        }
        picture
    }

    #[test]
    fn a_picture_equals_itself() {
        let picture = noisy(8, 1.0, 0.1, 1);
        let same = compare(&picture, &picture).expect("comparable");
        assert_eq!((same.n_different, same.rmse, same.relative_mse), (0, 0.0, Some(0.0)));
        assert_eq!(same.z.map(|z| (z.max, z.n_unexplained)), Some((0.0, 0)));
        assert_eq!(same.mean_ratio.map(|mean| mean.ratio), Some(1.0));
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
    fn noise_is_recognised_as_noise_and_a_bias_as_a_bias() {
        let (a, b) = (noisy(100, 1.0, 0.1, 1), noisy(100, 1.0, 0.2, 2));
        let noise = compare(&a, &b).expect("comparable");
        let z = noise.z.expect("errors are recorded");
        // 10^4 independent z: the root mean square is 1 within 4 sigma = 4 / sqrt(2 * 10^4).
        assert!((z.rms - 1.0).abs() < 0.029, "{z:?}");
        assert!(z.share_beyond_3 < 0.006, "{z:?}");
        let ratio = noise.mean_ratio.expect("b is lit");
        assert!((ratio.ratio - 1.0).abs() < 4.0 * ratio.error, "{ratio:?}");
        // sqrt(0.1^2 + 0.2^2) / 100, within the noise of the means.
        assert!((ratio.error / 0.002_236 - 1.0).abs() < 0.02, "{ratio:?}");
        let biased = compare(&noisy(100, 1.02, 0.1, 1), &b).expect("comparable").mean_ratio.expect("b is lit");
        assert!(biased.ratio - 1.0 > 4.0 * biased.error, "{biased:?}");
    }

    #[test]
    fn without_recorded_errors_the_scatter_tells() {
        let strip = |mut picture: Picture| {
            picture.channels.truncate(3);
            picture
        };
        let ratio = compare(&strip(noisy(100, 1.0, 0.1, 1)), &strip(noisy(100, 1.0, 0.2, 2))).expect("comparable");
        let ratio = ratio.mean_ratio.expect("b is lit");
        assert_eq!(ratio.error_from, ErrorSource::Scatter);
        assert!((ratio.error / 0.002_236 - 1.0).abs() < 0.05, "{ratio:?}");
    }

    #[test]
    fn where_an_error_is_no_number_the_scatter_tells_too() {
        let (mut a, b) = (noisy(100, 1.0, 0.1, 1), noisy(100, 1.0, 0.2, 2));
        a.channels[3].values[7] = f32::NAN;
        let broken = compare(&a, &b).expect("comparable");
        let ratio = broken.mean_ratio.expect("b is lit");
        assert_eq!(ratio.error_from, ErrorSource::Scatter);
        assert!((ratio.error / 0.002_236 - 1.0).abs() < 0.05, "{ratio:?}");
        // The other values are explained as before.
        assert_eq!(broken.z.map(|z| (z.n, z.n_unexplained)), Some((29_999, 1)));
        // The errors of pixels that are left out do not matter.
        a.channels[0].values[7] = f32::NAN;
        let left_out = compare(&a, &b).expect("comparable").mean_ratio.expect("b is lit");
        assert_eq!(left_out.error_from, ErrorSource::Recorded);
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

    #[test]
    fn a_difference_without_any_error_is_unexplained() {
        let with_errors = |value: f32| {
            let mut picture = uniform(2, 2, value);
            ERRORS.into_iter().for_each(|name| picture.push(name, vec![0.0; 4]));
            picture
        };
        let z = compare(&with_errors(1.0), &with_errors(1.5)).expect("comparable").z.expect("errors are recorded");
        assert_eq!((z.n, z.n_unexplained), (0, 12));
        assert!(z.mean.is_sign_positive() && z.rms == 0.0, "{z:?}");
    }
}
