//! The phase functions that a renderer evaluates and samples.
//!
//! Legend: mu = cos theta, +1 forward; h = 1 - mu in [0, 2], which keeps its digits at forward angles where mu does
//! not; p per steradian, with 2 pi times the integral of p over h equal to 1; u in [0, 1).

use std::f64::consts::{FRAC_1_PI, PI};

use super::hg_draine::HgDraine;
use super::phase_table::PhaseTable;

/// A phase function; `eval` is the density of `sample`, per steradian.
#[derive(Clone, Debug, PartialEq)]
pub enum PhaseFunction {
    /// The same in every direction.
    Isotropic,
    /// Rayleigh (1871): 3 (1 + mu^2) / (16 pi).
    Rayleigh,
    /// Henyey & Greenstein (1941).
    HenyeyGreenstein(HenyeyGreenstein),
    /// Jendersie & d'Eon (2023).
    HgDraine(HgDraine),
    /// A table over the angle.
    Tabulated(PhaseTable),
}

impl PhaseFunction {
    /// The Henyey-Greenstein function of an asymmetry strictly between -1 and 1.
    pub fn henyey_greenstein(g: f64) -> Self {
        Self::HenyeyGreenstein(HenyeyGreenstein { g })
    }

    /// Value at h = 1 - cos theta, sr^-1.
    #[inline]
    pub fn eval(&self, h: f64) -> f64 {
        match self {
            Self::Isotropic => 0.25 * FRAC_1_PI,
            Self::Rayleigh => 3.0 / 16.0 * FRAC_1_PI * (1.0 + (1.0 - h) * (1.0 - h)),
            Self::HenyeyGreenstein(function) => function.eval(h),
            Self::HgDraine(function) => function.eval(h),
            Self::Tabulated(table) => table.eval(h),
        }
    }

    /// h = 1 - cos theta of a scattered direction, from a uniform number in [0, 1).
    #[inline]
    pub fn sample(&self, u: f64) -> f64 {
        match self {
            Self::Isotropic => 2.0 * u,
            Self::Rayleigh => sample_rayleigh(u),
            Self::HenyeyGreenstein(function) => function.sample(u),
            Self::HgDraine(function) => function.sample(u),
            Self::Tabulated(table) => table.sample(u),
        }
    }

    /// Probability of scattering by less than h.
    pub fn cdf(&self, h: f64) -> f64 {
        match self {
            Self::Isotropic => 0.5 * h,
            Self::Rayleigh => h * (6.0 - h * (3.0 - h)) / 8.0,
            Self::HenyeyGreenstein(function) => function.cdf(h),
            Self::HgDraine(function) => function.cdf(h),
            Self::Tabulated(table) => table.cdf(h),
        }
    }

    /// The asymmetry parameter, mean cos theta.
    pub fn mean_cosine(&self) -> f64 {
        match self {
            Self::Isotropic | Self::Rayleigh => 0.0,
            Self::HenyeyGreenstein(function) => function.g,
            Self::HgDraine(function) => function.mean_cosine(),
            Self::Tabulated(table) => table.mean_cosine(),
        }
    }

    /// The largest value over all angles, sr^-1.
    pub fn max_value(&self) -> f64 {
        match self {
            Self::Isotropic => self.eval(0.0),
            Self::Rayleigh | Self::HenyeyGreenstein(_) | Self::HgDraine(_) => self.eval(0.0).max(self.eval(2.0)),
            Self::Tabulated(table) => table.max_value(),
        }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let heap = if let Self::Tabulated(table) = self { table.heap_bytes() } else { 0 };
        size_of::<Self>() + heap
    }
}

/// Inverts (mu^3 + 3 mu + 4) / 8 = 1 - u by Cardano's formula.
fn sample_rayleigh(u: f64) -> f64 {
    let z = 2.0 - 4.0 * u;
    let root = (z + (z * z + 1.0).sqrt()).cbrt();
    (1.0 - (root - 1.0 / root)).clamp(0.0, 2.0)
}

/// The Henyey-Greenstein function (1 - g^2) / (4 pi ((1-g)^2 + 2 g h)^(3/2)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    /// Asymmetry, strictly between -1 and 1.
    pub g: f64,
}

impl HenyeyGreenstein {
    /// Distance (1 + g^2 - 2 g mu)^(1/2), without cancellation for g near 1 and forward angles.
    fn distance(self, h: f64) -> f64 {
        ((1.0 - self.g) * (1.0 - self.g) + 2.0 * self.g * h).sqrt()
    }

    /// Value at h, sr^-1.
    #[inline]
    pub fn eval(self, h: f64) -> f64 {
        let q = self.distance(h);
        0.25 / PI * (1.0 - self.g) * (1.0 + self.g) / (q * q * q)
    }

    /// Probability of scattering by less than h.
    pub fn cdf(self, h: f64) -> f64 {
        let q = self.distance(h);
        ((1.0 + self.g) * h / (q * (q + 1.0 - self.g))).clamp(0.0, 1.0)
    }

    /// The inverse of `cdf`, rearranged so that nothing cancels.
    #[inline]
    pub fn sample(self, u: f64) -> f64 {
        let g = self.g;
        let d = 1.0 + g - 2.0 * g * u;
        let step = (1.0 - g) / d;
        (step * (1.0 - g) * u * ((1.0 + g) / d + 1.0)).clamp(0.0, 2.0)
    }
}
