//! What exact Lorenz-Mie theory says of a figure's droplet, per colour: the numbers that captions are judged by.

use num_complex::Complex64;

use super::formulas::size_parameter;
use crate::mie::{MieError, Series};
use crate::optics::quadrature::GaussLegendre;

/// Points of the rule per interval of the cosine. The intensity is a polynomial of degree 2N in it, and N is 52 orders
/// for the largest droplet (x = 24): 128 points are exact.
const POINTS: usize = 128;

/// One droplet in one colour.
#[derive(Clone, Debug)]
pub struct ExactSphere {
    series: Series,
    rule: GaussLegendre,
}

impl ExactSphere {
    /// The droplet of a diameter and index in light of a wavelength, nm both.
    ///
    /// # Errors
    /// When the sphere is outside the solver's domain.
    pub fn new(diameter_nm: f64, wavelength_nm: f64, index: Complex64) -> Result<Self, MieError> {
        let series = Series::new(size_parameter(diameter_nm, wavelength_nm), index)?;
        Ok(Self { series, rule: GaussLegendre::new(POINTS) })
    }

    /// Size parameter.
    pub fn x(&self) -> f64 {
        self.series.x
    }

    /// Scattering efficiency.
    pub fn q_sca(&self) -> f64 {
        self.series.efficiencies().q_sca
    }

    /// Absorption efficiency.
    pub fn q_abs(&self) -> f64 {
        self.series.efficiencies().q_abs
    }

    /// Mean cosine of the scattering angle.
    pub fn g(&self) -> f64 {
        self.series.efficiencies().g
    }

    /// p at scattering angles in rad, each in 0 ..= pi, sr^-1; theory (19).
    ///
    /// # Errors
    /// When an angle is out of range.
    pub fn phase(&self, theta_rad: &[f64]) -> Result<Vec<f64>, MieError> {
        let mut p = vec![0.0; theta_rad.len()];
        self.series.intensities(theta_rad, &mut p)?;
        let area = std::f64::consts::PI * self.series.x * self.series.x * self.q_sca();
        p.iter_mut().for_each(|p| *p /= area);
        Ok(p)
    }

    /// p(0) / p(180 degrees).
    ///
    /// # Errors
    /// Never in the solver's domain.
    pub fn forward_over_backward(&self) -> Result<f64, MieError> {
        let p = self.phase(&[0.0, std::f64::consts::PI])?;
        Ok(p.first().zip(p.last()).map_or(f64::NAN, |(forward, backward)| forward / backward))
    }

    /// The share of the scattered light whose cosine lies between `low` and `high`.
    ///
    /// # Errors
    /// When a bound is outside -1 ..= 1.
    pub fn share(&self, low: f64, high: f64) -> Result<f64, MieError> {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let theta: Vec<f64> = self.rule.points.iter().map(|(node, _)| (middle + half * node).acos()).collect();
        let p = self.phase(&theta)?;
        let sum: f64 = self.rule.points.iter().zip(p).map(|((_, weight), p)| weight * p).sum();
        Ok(2.0 * std::f64::consts::PI * half * sum)
    }

    /// What goes into the forward hemisphere over what goes into the backward one.
    ///
    /// # Errors
    /// Never in the solver's domain.
    pub fn hemispheres(&self) -> Result<f64, MieError> {
        Ok(self.share(0.0, 1.0)? / self.share(-1.0, 0.0)?)
    }
}
