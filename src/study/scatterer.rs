//! One sphere or a size distribution, solved once and then asked at any angles.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::mie::{MieError, ScatteringMatrix, Series};
use crate::optics::distribution::SizeDistribution;
use crate::optics::size_average::{AverageAccuracy, SizeAverage, Sizes};

/// What scatters, in air taken as vacuum.
#[derive(Clone, Debug)]
pub enum Scatterer {
    /// One sphere.
    Sphere(Sphere),
    /// Spheres of many sizes, averaged.
    Cloud(Box<Cloud>),
}

/// One sphere.
#[derive(Clone, Debug)]
pub struct Sphere {
    /// Its coefficients.
    pub series: Series,
    /// Its size, where that is known and not only its ratio to the wavelength.
    pub dimensions: Option<Dimensions>,
}

/// The two lengths behind a size parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimensions {
    /// Radius, m.
    pub radius_m: f64,
    /// Vacuum wavelength, m.
    pub wavelength_m: f64,
}

/// A size distribution.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// The sizes.
    pub distribution: SizeDistribution,
    /// Refractive index.
    pub m: Complex64,
    /// Vacuum wavelength, m.
    pub wavelength_m: f64,
    /// The average over the sizes.
    pub average: SizeAverage,
}

impl Dimensions {
    /// 2 pi r / lambda.
    pub fn size_parameter(&self) -> f64 {
        2.0 * PI * self.radius_m / self.wavelength_m
    }
}

impl Scatterer {
    /// A sphere of size parameter `x`.
    ///
    /// # Errors
    /// When the sphere is outside the domain of the Mie series.
    pub fn relative_sphere(x: f64, m: Complex64) -> Result<Self, MieError> {
        Ok(Self::Sphere(Sphere { series: Series::new(x, m)?, dimensions: None }))
    }

    /// A sphere of known size.
    ///
    /// # Errors
    /// As [`Scatterer::relative_sphere`].
    pub fn sphere(dimensions: Dimensions, m: Complex64) -> Result<Self, MieError> {
        let series = Series::new(dimensions.size_parameter(), m)?;
        Ok(Self::Sphere(Sphere { series, dimensions: Some(dimensions) }))
    }

    /// A size distribution, averaged to the accuracy of published numbers.
    ///
    /// # Errors
    /// When a sphere is outside the domain of the Mie series.
    pub fn cloud(distribution: SizeDistribution, wavelength_m: f64, m: Complex64) -> Result<Self, MieError> {
        Self::cloud_to(AverageAccuracy::default(), distribution, wavelength_m, m)
    }

    fn cloud_to(
        accuracy: AverageAccuracy,
        distribution: SizeDistribution,
        wavelength_m: f64,
        m: Complex64,
    ) -> Result<Self, MieError> {
        let average = SizeAverage::new(m, wavelength_m, &Sizes::Law(Box::new(distribution.law())), accuracy)?;
        Ok(Self::Cloud(Box::new(Cloud { distribution, m, wavelength_m, average })))
    }

    /// The same with as few radii as a picture needs, far fewer partial waves where drops are large.
    ///
    /// # Errors
    /// As [`Scatterer::cloud`].
    pub(super) fn for_picture(&self) -> Result<Self, MieError> {
        let Self::Cloud(cloud) = self else { return Ok(self.clone()) };
        Self::cloud_to(AverageAccuracy::picture(), cloud.distribution.clone(), cloud.wavelength_m, cloud.m)
    }

    /// Scattering matrices at angles in rad; of a distribution, the mean per droplet.
    ///
    /// # Errors
    /// When an angle is not in 0 ..= pi.
    pub fn matrices(&self, theta_rad: &[f64]) -> Result<Vec<ScatteringMatrix>, MieError> {
        match self {
            Self::Cloud(cloud) => cloud.average.ensemble.scattering_matrices(theta_rad),
            Self::Sphere(sphere) => {
                let (s1, s2) = sphere.amplitudes(theta_rad)?;
                Ok(s1.iter().zip(&s2).map(|(s1, s2)| ScatteringMatrix::from_amplitudes(*s1, *s2)).collect())
            }
        }
    }

    /// What S11 is multiplied by to become the phase function, sr^-1; `None` where nothing is scattered.
    pub fn phase_scale(&self) -> Option<f64> {
        match self {
            Self::Sphere(Sphere { series, .. }) => {
                let q_sca = series.efficiencies().q_sca;
                (q_sca > 0.0).then(|| 1.0 / (PI * series.x * series.x * q_sca))
            }
            Self::Cloud(cloud) => {
                let c_sca_m2 = cloud.average.cross_sections.c_sca_m2;
                (c_sca_m2 > 0.0).then(|| cloud.average.ensemble.phase_scale(c_sca_m2))
            }
        }
    }

    /// The refractive index.
    pub fn index(&self) -> Complex64 {
        match self {
            Self::Sphere(sphere) => sphere.series.m,
            Self::Cloud(cloud) => cloud.m,
        }
    }

    /// The size parameter; of a distribution, that of its effective radius.
    pub fn size_parameter(&self) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.series.x,
            Self::Cloud(cloud) => {
                let radius_m = cloud.distribution.law().effective_radius_m();
                Dimensions { radius_m, wavelength_m: cloud.wavelength_m }.size_parameter()
            }
        }
    }

    /// About how many partial waves there are at each angle.
    pub fn terms(&self) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.series.a.len() as f64,
            Self::Cloud(cloud) => cloud.average.ensemble.terms(),
        }
    }
}

impl Sphere {
    /// The amplitudes S1 and S2 at angles in rad.
    ///
    /// # Errors
    /// When an angle is not in 0 ..= pi.
    pub fn amplitudes(&self, theta_rad: &[f64]) -> Result<(Vec<Complex64>, Vec<Complex64>), MieError> {
        let mut s1 = vec![Complex64::default(); theta_rad.len()];
        let mut s2 = s1.clone();
        self.series.amplitudes(theta_rad, &mut s1, &mut s2)?;
        Ok((s1, s2))
    }
}
