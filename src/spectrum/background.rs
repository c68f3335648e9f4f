//! From the colour of a background to a spectrum that the picture's linear map turns back into that colour.

use super::color::{BT709_LUMINANCE, Matrix3, apply, inverse};

/// How colours become radiances per wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Uplift {
    /// Every wavelength carries the colour's luminance.
    Luminance,
    /// One row per wavelength; the products with red, green and blue add up to its radiance.
    Linear(Vec<[f64; 3]>),
}

impl Uplift {
    pub(super) fn luminance() -> Self {
        Self::Luminance
    }

    /// Three wavelengths that are the channels.
    pub(super) fn identity() -> Self {
        Self::Linear(vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    }

    /// Bands: the smooth basis B, corrected by the 3 by 3 matrix (M B)^-1 so that M maps it back to the colour.
    pub(super) fn bands(rgb_weights: &[[f64; 3]], shares: &[[f64; 3]]) -> Self {
        let product: Matrix3 = std::array::from_fn(|i| {
            std::array::from_fn(|j| rgb_weights.iter().zip(shares).map(|(weights, share)| weights[i] * share[j]).sum())
        });
        match inverse(&product) {
            Some(correction) if rgb_weights.len() >= 3 => {
                let row = |share: &[f64; 3]| std::array::from_fn(|j| (0..3).map(|i| share[i] * correction[i][j]).sum());
                Self::Linear(shares.iter().map(row).collect())
            }
            _ => Self::Luminance,
        }
    }

    /// The radiances that `rgb_weights` map to `rgb`.
    pub(super) fn spectrum(&self, rgb_weights: &[[f64; 3]], rgb: [f64; 3]) -> Vec<f64> {
        match self {
            Self::Luminance => {
                // Differences from red, so that grey stays grey to the last bit.
                let [_, g, b] = BT709_LUMINANCE;
                let luminance = rgb[0] + g * (rgb[1] - rgb[0]) + b * (rgb[2] - rgb[0]);
                let unit: f64 = rgb_weights.iter().map(|weights| weights[0]).sum();
                vec![luminance / unit; rgb_weights.len()]
            }
            Self::Linear(rows) => {
                let smooth: Vec<f64> =
                    rows.iter().map(|row| row.iter().zip(rgb).map(|(row, channel)| row * channel).sum()).collect();
                non_negative(rgb_weights, rgb, &smooth).unwrap_or(smooth)
            }
        }
    }
}

impl Uplift {
    /// As `spectrum`, into a buffer, without allocating where no band turns negative.
    pub(super) fn spectrum_into(&self, rgb_weights: &[[f64; 3]], rgb: [f64; 3], out: &mut [f64]) {
        if let Self::Linear(rows) = self {
            for (out, row) in out.iter_mut().zip(rows) {
                *out = row.iter().zip(rgb).map(|(row, channel)| row * channel).sum();
            }
            if out.iter().all(|value| *value >= 0.0) {
                return;
            }
        }
        out.copy_from_slice(&self.spectrum(rgb_weights, rgb));
    }
}

/// The spectrum nearest to `smooth` with negative bands set to zero and the rest moved so that the colour is kept:
/// the least change of the bands left, repeated while new ones turn negative. `None` where too few bands are left.
fn non_negative(rgb_weights: &[[f64; 3]], rgb: [f64; 3], smooth: &[f64]) -> Option<Vec<f64>> {
    let mut ell = smooth.to_vec();
    let mut is_free = vec![true; ell.len()];
    while ell.iter().any(|value| *value < 0.0) {
        for (value, is_free) in ell.iter_mut().zip(&mut is_free).filter(|(value, _)| **value < 0.0) {
            (*value, *is_free) = (0.0, false);
        }
        let free = || rgb_weights.iter().zip(&is_free).filter(|(_, is_free)| **is_free).map(|(weights, _)| weights);
        let gram: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| free().map(|w| w[i] * w[j]).sum()));
        let mut missing = rgb;
        for (value, weights) in ell.iter().zip(rgb_weights) {
            (0..3).for_each(|i| missing[i] -= value * weights[i]);
        }
        let step = apply(&inverse(&gram)?, missing);
        for ((value, weights), _) in ell.iter_mut().zip(rgb_weights).zip(&is_free).filter(|(_, is_free)| **is_free) {
            *value += (0..3).map(|i| weights[i] * step[i]).sum::<f64>();
        }
    }
    Some(ell)
}
