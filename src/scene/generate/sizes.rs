//! Droplet radii drawn from a size distribution, and the means that decide how many there are.

use std::f64::consts::PI;

use super::error::GenerateError;
use super::random::{Purpose, make_blocks, unit_f64};
use crate::optics::distribution::{Shape, SizeDistribution};
use crate::optics::size_law::SizeLaw;

/// Radii that a droplet may have, m; beyond, cubes of radii leave the range that files can hold.
const RADII_M: std::ops::RangeInclusive<f64> = 1e-12..=1e3;

/// A size distribution, with the extinction efficiency at 550 nm of a droplet of a given radius in metres.
pub(super) struct Sizes<'a> {
    law: SizeLaw,
    limits_m: [f64; 2],
    q_ext: &'a dyn Fn(f64) -> f64,
}

impl<'a> Sizes<'a> {
    pub fn new(distribution: &SizeDistribution, q_ext: &'a dyn Fn(f64) -> f64) -> Result<Self, GenerateError> {
        let limits_m = match distribution.shape {
            Shape::Mono { r_m } => [r_m; 2],
            _ => [distribution.r_min_m, distribution.r_max_m],
        };
        if let Some(radius_m) = limits_m.into_iter().find(|radius_m| !RADII_M.contains(radius_m)) {
            return Err(GenerateError::DropletRadius { radius_m });
        }
        Ok(Self { law: distribution.law(), limits_m, q_ext })
    }

    /// The radius that half of all droplets do not exceed, m.
    pub fn median_m(&self) -> f64 {
        self.law.quantile(0.5)
    }

    /// Random radii, um.
    pub fn sample_um(&self, count: usize, seed: u64) -> Vec<f32> {
        let law = &self.law;
        make_blocks(count, seed, Purpose::Sizes, |_, rng| (law.quantile(unit_f64(rng)) * 1e6) as f32)
    }

    /// Mean volume of a droplet, m^3.
    pub fn mean_volume_m3(&self) -> f64 {
        self.law.mean_volume_m3()
    }

    /// Mean extinction cross section of a droplet, m^2.
    pub fn mean_c_ext_m2(&self) -> Result<f64, GenerateError> {
        let [min_m, max_m] = self.limits_m;
        let table = self.q_ext_table(min_m, max_m)?;
        Ok(self.law.mean(|radius_m| table.c_ext_m2(radius_m)))
    }

    /// Sum of the extinction cross sections of these droplets, m^2.
    pub fn sum_c_ext_m2(&self, radii_um: &[f32]) -> Result<f64, GenerateError> {
        let radii_m = || radii_um.iter().map(|&radius_um| f64::from(radius_um) * 1e-6);
        if radii_um.len() <= N_NODES {
            return radii_m().map(|radius_m| Ok(self.q_ext(radius_m)? * PI * radius_m * radius_m)).sum();
        }
        let (min_m, max_m) = radii_m().fold((f64::INFINITY, 0.0_f64), |(min, max), r| (min.min(r), max.max(r)));
        let table = self.q_ext_table(min_m, max_m)?;
        Ok(radii_m().map(|radius_m| table.c_ext_m2(radius_m)).sum())
    }

    fn q_ext(&self, radius_m: f64) -> Result<f64, GenerateError> {
        let q_ext = (self.q_ext)(radius_m);
        if q_ext.is_finite() && q_ext > 0.0 { Ok(q_ext) } else { Err(GenerateError::Extinction { radius_m, q_ext }) }
    }

    fn q_ext_table(&self, min_m: f64, max_m: f64) -> Result<EfficiencyTable, GenerateError> {
        if min_m == max_m {
            return Ok(EfficiencyTable { min_m, nodes_per_log: 0.0, q_ext: vec![self.q_ext(min_m)?; 2] });
        }
        let log_step = (max_m / min_m).ln() / (N_NODES - 1) as f64;
        let q_ext = (0..N_NODES).map(|i| self.q_ext(min_m * (log_step * i as f64).exp())).collect::<Result<_, _>>()?;
        Ok(EfficiencyTable { min_m, nodes_per_log: 1.0 / log_step, q_ext })
    }
}

/// Radii at which the efficiency of many is tabulated. The steps resolve the interference structure of Q_ext up to a few
/// hundred um; the finer ripple averages out over a thousand droplets and more, to 1e-3 of the sum.
const N_NODES: usize = 1024;

/// Extinction efficiency at radii spaced evenly in their logarithm, linear between them.
struct EfficiencyTable {
    min_m: f64,
    nodes_per_log: f64,
    q_ext: Vec<f64>,
}

impl EfficiencyTable {
    fn c_ext_m2(&self, radius_m: f64) -> f64 {
        let place = ((radius_m / self.min_m).ln() * self.nodes_per_log).max(0.0);
        let index = (place as usize).min(self.q_ext.len() - 2);
        let share = (place - index as f64).min(1.0);
        let q_ext = (1.0 - share) * self.q_ext[index] + share * self.q_ext[index + 1];
        q_ext * PI * radius_m * radius_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The anomalous diffraction of van de Hulst (1957, section 11.22), m = 1.333 at 550 nm: interference without ripple.
    fn anomalous_diffraction(radius_m: f64) -> f64 {
        let rho = 4.0 * PI * radius_m / 550e-9 * 0.333;
        2.0 - 4.0 / rho * rho.sin() + 4.0 / (rho * rho) * (1.0 - rho.cos())
    }

    fn sizes(text: &str) -> Sizes<'static> {
        let distribution = SizeDistribution::parse(text, &|name| Err(name.into())).expect("a valid distribution");
        Sizes::new(&distribution, &anomalous_diffraction).expect("radii of droplets")
    }

    #[test]
    fn the_table_of_efficiencies_gives_the_sum_over_single_droplets() {
        for text in ["gamma:reff=6um,veff=0.1", "lognormal:rg=3um,sigma=0.8", "mono:r=2um"] {
            let sizes = sizes(text);
            let radii_um = sizes.sample_um(20_000, 1);
            let exact = radii_um
                .iter()
                .map(|&r| f64::from(r) * 1e-6)
                .map(|r| anomalous_diffraction(r) * PI * r * r)
                .sum::<f64>();
            let sum = sizes.sum_c_ext_m2(&radii_um).expect("positive efficiencies");
            assert!((sum / exact - 1.0).abs() < 1e-3, "{text}: {sum} against {exact}");
            // Four standard errors of the heaviest-tailed of the three: 4 * 3.6 / sqrt(20000).
            let mean = sizes.mean_c_ext_m2().expect("positive efficiencies");
            assert!((sum / 20_000.0 / mean - 1.0).abs() < 0.1, "{text}");
        }
    }

    #[test]
    fn efficiencies_that_are_no_efficiencies_are_refused() {
        let distribution = SizeDistribution::default();
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let q_ext = |_| bad;
            let sizes = Sizes::new(&distribution, &q_ext).expect("radii of droplets");
            assert!(matches!(sizes.mean_c_ext_m2(), Err(GenerateError::Extinction { .. })));
        }
    }
}
