//! Droplet radii drawn from a size distribution, and the means that decide how many there are.

use std::f64::consts::{FRAC_PI_2, PI};

use super::error::GenerateError;
use super::random::{Purpose, stream, unit_f64};
use crate::optics::distribution::SizeDistribution;

/// Radii that a droplet may have, m; beyond, cubes of radii leave the range that files can hold.
const RADII_M: std::ops::RangeInclusive<f64> = 1e-12..=1e3;

/// A size distribution, with the extinction efficiency at 550 nm of a droplet of a given radius in metres.
#[derive(Clone, Copy)]
pub(super) struct Sizes<'a> {
    pub distribution: &'a SizeDistribution,
    pub q_ext: &'a dyn Fn(f64) -> f64,
}

impl Sizes<'_> {
    /// The radius that a share `u` of all droplets do not exceed, m.
    pub fn radius_m(&self, u: f64) -> Result<f64, GenerateError> {
        let radius_m = quantile(self.distribution, u);
        if RADII_M.contains(&radius_m) { Ok(radius_m) } else { Err(GenerateError::DropletRadius { radius_m }) }
    }

    /// Random radii, um.
    pub fn sample_um(&self, count: usize, seed: u64) -> Result<Vec<f32>, GenerateError> {
        let mut rng = stream(seed, Purpose::Sizes);
        (0..count).map(|_| Ok((self.radius_m(unit_f64(&mut rng))? * 1e6) as f32)).collect()
    }

    /// Extinction cross section of one droplet, m^2.
    pub fn c_ext_m2(&self, radius_m: f64) -> Result<f64, GenerateError> {
        let q_ext = (self.q_ext)(radius_m);
        if !(q_ext.is_finite() && q_ext > 0.0) {
            return Err(GenerateError::Extinction { radius_m, q_ext });
        }
        Ok(q_ext * PI * radius_m * radius_m)
    }

    /// Mean extinction cross section of a droplet, m^2.
    pub fn mean_c_ext_m2(&self) -> Result<f64, GenerateError> {
        self.mean(|radius_m| self.c_ext_m2(radius_m))
    }

    /// Mean volume of a droplet, m^3.
    pub fn mean_volume_m3(&self) -> Result<f64, GenerateError> {
        self.mean(|radius_m| Ok(4.0 / 3.0 * PI * radius_m.powi(3)))
    }

    /// The mean over all droplets, by tanh-sinh quadrature (Takahasi & Mori 1974) over their rank: it crowds towards both
    /// ends, where few but large droplets hold much of the water.
    fn mean(&self, f: impl Fn(f64) -> Result<f64, GenerateError>) -> Result<f64, GenerateError> {
        const STEP: f64 = 1.0 / 64.0;
        const N_SIDE: i32 = 200; // to 1 - u = 4e-16 on either side
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in -N_SIDE..=N_SIDE {
            let t = f64::from(i) * STEP;
            let weight = t.cosh() / (FRAC_PI_2 * t.sinh()).cosh().powi(2);
            let u = 1.0 / (1.0 + (-PI * t.sinh()).exp());
            sum += weight * f(self.radius_m(u)?)?;
            weights += weight;
        }
        Ok(sum / weights)
    }

    /// Sum of the extinction cross sections of these droplets, m^2.
    pub fn sum_c_ext_m2(&self, radii_um: &[f32]) -> Result<f64, GenerateError> {
        if radii_um.len() <= N_NODES {
            return radii_um.iter().map(|&r| self.c_ext_m2(f64::from(r) * 1e-6)).sum();
        }
        let (min, max) = radii_um.iter().fold((f32::INFINITY, 0.0_f32), |(min, max), &r| (min.min(r), max.max(r)));
        let table = self.q_ext_table(f64::from(min) * 1e-6, f64::from(max) * 1e-6)?;
        Ok(radii_um.iter().map(|&r| table.c_ext_m2(f64::from(r) * 1e-6)).sum())
    }

    fn q_ext_table(&self, min_m: f64, max_m: f64) -> Result<EfficiencyTable, GenerateError> {
        let log_step = (max_m / min_m).ln() / (N_NODES - 1) as f64;
        let q_ext = (0..N_NODES)
            .map(|i| {
                let radius_m = min_m * (log_step * i as f64).exp();
                Ok(self.c_ext_m2(radius_m)? / (PI * radius_m * radius_m))
            })
            .collect::<Result<_, _>>()?;
        Ok(EfficiencyTable { min_m, log_step, q_ext })
    }
}

/// Radii at which many droplets' efficiency is tabulated; the ripple that falls between them averages out over a thousand
/// droplets and more, to 1e-3 of the sum.
const N_NODES: usize = 1024;

/// Extinction efficiency at radii spaced evenly in their logarithm, linear between them.
struct EfficiencyTable {
    min_m: f64,
    log_step: f64,
    q_ext: Vec<f64>,
}

impl EfficiencyTable {
    fn c_ext_m2(&self, radius_m: f64) -> f64 {
        let place = if self.log_step > 0.0 { ((radius_m / self.min_m).ln() / self.log_step).max(0.0) } else { 0.0 };
        let index = (place as usize).min(self.q_ext.len() - 2);
        let share = (place - index as f64).min(1.0);
        let q_ext = (1.0 - share) * self.q_ext[index] + share * self.q_ext[index + 1];
        q_ext * PI * radius_m * radius_m
    }
}

fn quantile(distribution: &SizeDistribution, u: f64) -> f64 {
    use crate::optics::distribution::Shape;
    match &distribution.shape {
        Shape::Mono { r_m } => *r_m,
        _ => {
            let [a, b] = [distribution.r_min_m, distribution.r_max_m];
            a * (b / a).powf(u)
        }
    }
}
