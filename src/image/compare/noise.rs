//! Whether noise explains a difference: from recorded standard errors, or from the scatter between pixels.

use super::overlap::Pixel;
use super::report::{ErrorSource, MeanRatio, ZScores};
use super::{luminance, mean};

/// Recorded standard errors of both pictures, channel by channel.
pub(super) type Errors<'a> = ([&'a [f32]; 3], [&'a [f32]; 3]);

/// Ratio r = mean Y_a / mean Y_b. Its error to first order: from recorded errors, var r = (var m_a + r^2 var m_b) / m_b^2;
/// from scatter, where the error of any pixel is missing or no number, the variance of Y_a - r Y_b between pixels over n m_b^2
/// (Cochran 1977, equation 6.13).
pub(super) fn mean_ratio(pixels: &[&Pixel], errors: Option<&Errors<'_>>) -> Option<MeanRatio> {
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

pub(super) fn z_scores(pixels: &[&Pixel], errors: &Errors<'_>) -> Option<ZScores> {
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

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use crate::image::Picture;
    use crate::image::compare::tests::uniform;
    use crate::image::compare::{ERRORS, ErrorSource, compare};

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
