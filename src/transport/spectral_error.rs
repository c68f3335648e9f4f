//! How far a picture's few wavelengths stand for all of them: what leaving out every other one, and three of four, would change.

use super::lighting::Lighting;
use super::media::Media;

/// Scattering angles that are looked at, degrees: from beside the forward peak to beside the glory.
const ANGLES_DEG: std::ops::RangeInclusive<u32> = 1..=17;

/// Estimated relative error of scattered light for want of wavelengths, RMS over angles and channels; theory (105). `areas_m2` holds
/// what each size bin takes from the light; where droplets are `seen_singly`, bins do not blend.
///
/// With e_2, e_4 the changes that every other wavelength and one of four make: each halving of their distance is taken to
/// lower the error as the last one did, e = e_2^2 / e_4, at most e_2, which is all that is known of two or three. Of one
/// wavelength nothing is known: 0.
pub(super) fn band_error(media: &Media, lighting: &Lighting, areas_m2: &[f64], seen_singly: bool) -> f64 {
    let n = media.n_wavelengths();
    let bins: Vec<usize> = (0..media.n_bins()).filter(|bin| areas_m2[*bin] > 0.0).collect();
    if n < 2 || bins.is_empty() {
        return 0.0;
    }
    let groups: Vec<Vec<usize>> = match seen_singly {
        true => bins.iter().map(|bin| vec![*bin]).collect(),
        false => vec![bins],
    };
    let (mut two, mut four, mut count) = (0.0, 0.0, 0.0);
    for group in &groups {
        for angle_deg in ANGLES_DEG {
            let h = 1.0 - f64::from(10 * angle_deg).to_radians().cos();
            let light: Vec<f64> = (0..n).map(|w| scattered(media, group, areas_m2, w, h)).collect();
            two += thinned(lighting, &light, 2);
            four += thinned(lighting, &light, 4);
            count += 1.0;
        }
    }
    let [two, four] = [two, four].map(|sum: f64| (sum / count).sqrt());
    if n >= 4 && four > two { two * two / four } else { two }
}

/// What bins scatter by h at a wavelength, per sunlight.
fn scattered(media: &Media, bins: &[usize], areas_m2: &[f64], w: usize, h: f64) -> f64 {
    let of_bin = |bin: &usize| areas_m2[*bin] * media.q_sca(*bin, w) * media.phase(*bin)[w].eval(h);
    bins.iter().map(of_bin).sum()
}

/// Mean square over channels of the relative change, were only one of `step` wavelengths there.
fn thinned(lighting: &Lighting, light: &[f64], step: usize) -> f64 {
    let channel = |shares: &[f64]| {
        let all: f64 = shares.iter().zip(light).map(|(share, value)| share * value).sum();
        let part = |first: usize| {
            let chosen = || shares.iter().zip(light).skip(first).step_by(step);
            let weight: f64 = chosen().map(|(share, _)| share).sum();
            chosen().map(|(share, value)| share * value).sum::<f64>() / weight
        };
        let changes = (0..step).map(|first| (part(first) / all - 1.0).powi(2)).filter(|change| change.is_finite());
        changes.sum::<f64>() / step as f64
    };
    lighting.channel_shares.iter().map(|shares| channel(shares)).sum::<f64>() / 3.0
}
