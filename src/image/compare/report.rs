//! What a comparison of two pictures says.

use serde::Serialize;

/// The difference of two pictures, a against b.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels compared: those that both pictures have.
    pub n_pixels: u64,
    /// Pixels that differ in any bit of R, G or B.
    pub n_different: u64,
    /// Pixels where a or b is not finite; they are left out of all that follows.
    pub n_non_finite: u64,
    /// The first of them.
    pub first_non_finite: Option<NonFinitePixel>,
    /// Root mean square of d over pixels and R, G, B; not a number where no pixel is finite.
    pub rmse: f64,
    /// `rmse` over b's mean luminance: the measure of the accuracy target. `None` where b is black.
    pub relative_rmse: Option<f64>,
    /// Mean of d^2 / (b^2 + floor) over pixels and R, G, B; the floor is 1e-3 of b's squared mean luminance.
    /// `None` where b is black and a is not, and where no pixel is finite.
    pub relative_mse: Option<f64>,
    /// Ratio of the mean luminances, a over b.
    pub mean_ratio: Option<MeanRatio>,
    /// How the differences compare with the standard errors that both pictures record.
    pub z: Option<ZScores>,
    /// The pixel where the luminance differs most.
    pub worst: Option<WorstPixel>,
    /// Every channel that both pictures have.
    pub channels: Vec<ChannelDifference>,
    /// Channels of a alone.
    pub only_in_a: Vec<String>,
    /// Channels of b alone.
    pub only_in_b: Vec<String>,
}

/// A pixel that cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NonFinitePixel {
    /// Column in the full frame.
    pub x: i32,
    /// Row in the full frame, from the top.
    pub y: i32,
    /// R, G, B of a.
    pub a: [f32; 3],
    /// R, G, B of b.
    pub b: [f32; 3],
}

/// A ratio of means with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanRatio {
    /// Mean luminance of a over that of b.
    pub ratio: f64,
    /// One standard error of the ratio.
    pub error: f64,
    /// What the error was found from.
    pub error_from: ErrorSource,
}

/// What the error of a mean was found from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorSource {
    /// The standard errors that both pictures record for every pixel; the noise of R, G, B in a pixel is taken as fully correlated,
    /// as channels share their paths, which is the largest that it can be.
    Recorded,
    /// The scatter of the differences between pixels; true if nothing but noise differs.
    Scatter,
}

/// Standardised differences z = d / sqrt(s_a^2 + s_b^2) over pixels and R, G, B.
///
/// Two correct renders with different seeds have mean 0 and standard deviation 1; the mean is biased where one differs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZScores {
    /// Values with a standard error above 0; without any, all that follows but the last is 0.
    pub n: u64,
    /// Mean of z.
    pub mean: f64,
    /// Root mean square of z.
    pub rms: f64,
    /// Largest |z|.
    pub max: f64,
    /// Share with |z| > 3; 0.0027 for normal noise.
    pub share_beyond_3: f64,
    /// Values that differ although both record no error at all, or none that is a number: no recorded noise explains them.
    pub n_unexplained: u64,
}

/// A pixel, in coordinates of the full frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstPixel {
    /// Column.
    pub x: i32,
    /// Row.
    pub y: i32,
    /// R, G, B of a.
    pub a: [f32; 3],
    /// R, G, B of b.
    pub b: [f32; 3],
    /// Difference of the luminances, a - b.
    pub difference: f64,
}

/// The difference of one channel; means and what follows are over the pixels where both are finite, and not numbers where there are none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelDifference {
    /// The channel's name.
    pub name: String,
    /// Pixels that differ in any bit.
    pub n_different: u64,
    /// Pixels where a or b is not finite.
    pub n_non_finite: u64,
    /// Mean of a.
    pub mean_a: f64,
    /// Mean of b.
    pub mean_b: f64,
    /// Root mean square of d.
    pub rmse: f64,
    /// Largest |d|.
    pub max: f64,
}

/// The difference of one layer: the means of its channels that differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerDifference {
    /// The layer's name.
    pub name: String,
    /// Its channels that differ, by their full names.
    pub channels: Vec<String>,
    /// Mean of a.
    pub mean_a: f64,
    /// Mean of b.
    pub mean_b: f64,
    /// Root mean square of d.
    pub rmse: f64,
    /// Values that are not finite in a or b; they are left out of the means.
    pub n_non_finite: u64,
}
