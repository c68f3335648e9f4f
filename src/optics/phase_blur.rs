//! The intensity of a large sphere with its finest fringes blurred, so that a table of bounded size can hold it.
//!
//! |S|^2 is a trigonometric polynomial of degree 2N, N about x, so its values on a grid of pi / (4 x) hold all of it;
//! the kernel is a triangle in theta. The light in any few fringes is kept; the first rings about 0 and pi are exact.

use std::f64::consts::PI;

use super::ensemble::Ensemble;
use crate::mie::MieError;

/// Grid steps per fringe pi/x.
const STEPS_PER_FRINGE: f64 = 4.0;

/// Half the base of the triangle, in fringes: at half height it is three periods wide.
const HALF_WIDTH: f64 = 3.0;

/// Rings about 0 and pi that stay sharp, and over which the blur then grows to its full width.
const SHARP_RINGS: f64 = 10.0;

/// Blurred intensities of an ensemble.
pub(super) struct BlurredIntensity<'a> {
    ensemble: &'a Ensemble,
    fringe: f64,
    step: f64,
    /// Intensities at multiples of `step` from 0 to pi.
    grid: Vec<f64>,
}

impl<'a> BlurredIntensity<'a> {
    /// Prepares an ensemble whose largest size parameter is `x`.
    pub(super) fn new(ensemble: &'a Ensemble, x: f64) -> Result<Self, MieError> {
        let count = (STEPS_PER_FRINGE * x).ceil();
        let theta: Vec<f64> = (0..=count as usize).map(|i| (PI * i as f64 / count).min(PI)).collect();
        Ok(Self { ensemble, fringe: PI / x, step: PI / count, grid: ensemble.intensities(&theta)? })
    }

    /// Intensities at angles in rad.
    pub(super) fn at(&self, theta: &[f64]) -> Result<Vec<f64>, MieError> {
        let sharp: Vec<f64> = theta.iter().copied().filter(|theta| self.half_width(*theta) == 0.0).collect();
        let mut sharp = self.ensemble.intensities(&sharp)?.into_iter();
        let value = |theta: &f64| {
            let half_width = self.half_width(*theta);
            if half_width == 0.0 { sharp.next().unwrap_or(0.0) } else { self.blurred(*theta, half_width) }
        };
        Ok(theta.iter().map(value).collect())
    }

    /// Half the base of the kernel at an angle, rad; zero where the rings stay sharp.
    fn half_width(&self, theta: f64) -> f64 {
        let rings = theta.min(PI - theta) / self.fringe;
        let growth = ((rings - SHARP_RINGS) / SHARP_RINGS).clamp(0.0, 1.0);
        // Below one fringe a triangle of few samples would alias.
        if growth * HALF_WIDTH < 1.0 { 0.0 } else { growth * HALF_WIDTH * self.fringe }
    }

    fn blurred(&self, theta: f64, half_width: f64) -> f64 {
        let first = ((theta - half_width) / self.step).ceil().max(0.0) as usize;
        let last = (((theta + half_width) / self.step) as usize).min(self.grid.len() - 1);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (i, value) in self.grid.iter().enumerate().take(last + 1).skip(first) {
            let weight = half_width - (i as f64 * self.step - theta).abs();
            sum += weight * value;
            weights += weight;
        }
        sum / weights
    }
}
