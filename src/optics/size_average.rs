//! Mie scattering averaged over the sizes of a bin: cross sections, asymmetry and a phase table.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::ensemble::{CrossSections, Ensemble};
use super::phase_blur::BlurredIntensity;
use super::phase_build::{BuiltTable, MAX_NODES, TableAccuracy, build_adaptive};
use super::size_law::SizeLaw;
use super::size_nodes::SizeStrata;
use crate::mie::MieError;

/// The sizes that an average is taken over.
#[derive(Clone, Debug)]
pub enum Sizes {
    /// A few radii in m with the number of droplets of each, all of them used.
    Radii(Vec<(f64, f64)>),
    /// A distribution.
    Law(Box<SizeLaw>),
    /// One radius in m, over a band of wavelengths: the mean over `from_m` to `to_m`, each as bright. A sphere at another
    /// wavelength is one of another size: theory (121).
    Band { r_m: f64, from_m: f64, to_m: f64 },
}

/// What is summed over.
enum Summed<'a> {
    /// These radii in m with their shares of the droplets, and no more.
    Few(Vec<(f64, f64)>),
    /// As many as it takes.
    Divided(Division<'a>),
}

/// Sizes that are divided ever more finely.
enum Division<'a> {
    Strata(SizeStrata<'a>),
    Band { r_m: f64, wavelength_m: f64, from_m: f64, to_m: f64 },
}

impl<'a> Summed<'a> {
    fn of(sizes: &'a Sizes, wavelength_m: f64) -> Self {
        match sizes {
            Sizes::Radii(radii) => Self::Few(shares(radii.clone())),
            Sizes::Law(law) => match law.mono_radius() {
                Some(r_m) => Self::Few(vec![(r_m, 1.0)]),
                None => Self::Divided(Division::Strata(SizeStrata::new(law))),
            },
            Sizes::Band { r_m, from_m, to_m } => {
                Self::Divided(Division::Band { r_m: *r_m, wavelength_m, from_m: *from_m, to_m: *to_m })
            }
        }
    }
}

impl Division<'_> {
    fn mean_radius_m(&self) -> f64 {
        match self {
            Self::Strata(strata) => strata.mean_radius_m(),
            Self::Band { r_m, .. } => *r_m,
        }
    }

    /// About `count` radii in m with their shares of the droplets.
    fn nodes(&self, count: usize) -> Vec<(f64, f64)> {
        match self {
            Self::Strata(strata) => strata.nodes(count),
            Self::Band { r_m, wavelength_m, from_m, to_m } => {
                let step_m = (to_m - from_m) / count as f64;
                // Middles of equal parts: what is left of fringes that fit a part averages out as it does between nodes.
                let node = |i| {
                    let scale = wavelength_m / (from_m + (f64::from(i) + 0.5) * step_m);
                    (r_m * scale, 1.0 / (scale * scale * count as f64))
                };
                (0..count as u32).map(node).collect()
            }
        }
    }
}

/// How well an average is to be taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AverageAccuracy {
    /// Change of C_ext and g between the last two sets of radii, relative; p may change by twice this in the median
    /// over angles and by ten times this at the worst.
    pub size_tolerance: f64,
    /// Relative error of the phase table between its nodes.
    pub angle_tolerance: f64,
    /// Most radii.
    pub max_radii: usize,
    /// Most partial waves, summed over the radii: bounds the time that wide distributions of large drops take, whose
    /// resonances matter least.
    pub max_terms: f64,
}

impl Default for AverageAccuracy {
    /// The accuracy of published numbers: C_ext and g to better than 1e-3 (hazes 1e-4), p to 1e-2 at the worst angle.
    fn default() -> Self {
        Self { size_tolerance: 2e-4, angle_tolerance: 1e-3, max_radii: 4096, max_terms: 8e6 }
    }
}

impl AverageAccuracy {
    /// The accuracy of pictures: far below their noise; a fog at eight wavelengths takes a fraction of a second.
    pub fn picture() -> Self {
        Self { size_tolerance: 2e-3, angle_tolerance: 2e-3, max_radii: 1024, max_terms: 1e6 }
    }

    /// The same for one of several bins that a scene's sizes are divided into: the noise of their resonances averages
    /// out over the bins as it does over radii, so they share the radii, with at least 128 each.
    pub fn shared_by(self, bins: usize) -> Self {
        Self { max_radii: (self.max_radii / bins.max(1)).max(LEAST_SHARED_RADII).min(self.max_radii), ..self }
    }

    /// Radii that the partial waves allow for a mean size parameter, at least 64.
    fn max_radii_for(&self, mean_x: f64) -> usize {
        ((self.max_terms / mean_x) as usize).max(FIRST_RADII).min(self.max_radii)
    }

    /// What a picture with a target relative error needs: a fiftieth of it, between the two above.
    pub fn for_target(error: f64) -> Self {
        let tolerance = (error / 50.0).clamp(2e-4, 2e-3);
        if tolerance < 1e-3 {
            Self { size_tolerance: tolerance, angle_tolerance: tolerance, max_radii: 4096, max_terms: 8e6 }
        } else {
            Self { size_tolerance: tolerance, angle_tolerance: tolerance, ..Self::picture() }
        }
    }
}

/// Mie scattering averaged over sizes; cross sections are means per droplet.
#[derive(Clone, Debug)]
pub struct SizeAverage {
    /// Mean cross sections and the asymmetry of the scattered light.
    pub cross_sections: CrossSections,
    /// How much the last doubling of the radii changed the averages.
    pub change: Change,
    /// The spheres that were used.
    pub ensemble: Ensemble,
}

/// How much averages changed when the radii were doubled; an estimate of the error, zero for a list of radii.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Relative change of C_ext.
    pub c_ext: f64,
    /// Change of g.
    pub g: f64,
    /// Median relative change of p over the probe angles.
    pub p_median: f64,
    /// Largest relative change of p over the probe angles.
    pub p_worst: f64,
}

impl Change {
    fn is_within(&self, tolerance: f64) -> bool {
        self.c_ext <= tolerance
            && self.g <= tolerance
            && self.p_median <= 2.0 * tolerance
            && self.p_worst <= 10.0 * tolerance
    }
}

/// The first set of radii.
const FIRST_RADII: usize = 64;

/// Least radii of a bin that shares them: across 10 % of x = 100 they are 0.08 apart, a tenth of the ripples' period.
const LEAST_SHARED_RADII: usize = 128;

/// Fewer radii than this do not wash out each other's fringes.
const FEW_RADII: usize = 16;

/// Partial waves times angles that a phase table may cost: about a second on one core (0.25 ns each).
const TABLE_BUDGET: f64 = 3e9;

/// Nodes that every table may have, whatever they cost.
const ALWAYS_NODES: usize = 512;

/// Above this size parameter the fringes of a single sphere would need more nodes than a table has: they are blurred.
pub(super) const BLUR_ABOVE_X: f64 = 2000.0;

/// Nodes and tolerance of blurred tables: what is left has the width of the bow's own structure, and a table of
/// 16 384 nodes is half a megabyte.
const BLURRED: TableAccuracy = TableAccuracy { tolerance: 1e-2, max_nodes: 16_384 };

impl SizeAverage {
    /// Averages over sizes, doubling the number of radii until the averages stand still.
    ///
    /// # Errors
    /// When a sphere is outside the domain of the Mie series.
    pub fn new(m: Complex64, wavelength_m: f64, sizes: &Sizes, accuracy: AverageAccuracy) -> Result<Self, MieError> {
        let division = match Summed::of(sizes, wavelength_m) {
            Summed::Few(radii) => return Self::over_radii(m, wavelength_m, radii),
            Summed::Divided(division) => division,
        };
        let probes = probe_angles();
        let max_radii = accuracy.max_radii_for(division.mean_radius_m() * 2.0 * PI / wavelength_m);
        let mut radii = FIRST_RADII.min(max_radii / 2).max(2);
        let mut coarse = Probe::new(m, wavelength_m, division.nodes(radii), &probes)?;
        loop {
            radii *= 2;
            let fine = Probe::new(m, wavelength_m, division.nodes(radii), &probes)?;
            let change = coarse.change(&fine);
            if change.is_within(accuracy.size_tolerance) || 2 * radii > max_radii {
                return Ok(Self { cross_sections: fine.cross_sections, change, ensemble: fine.ensemble });
            }
            coarse = fine;
        }
    }

    fn over_radii(m: Complex64, wavelength_m: f64, radii: Vec<(f64, f64)>) -> Result<Self, MieError> {
        let ensemble = Ensemble::new(m, wavelength_m, radii)?;
        Ok(Self { cross_sections: ensemble.cross_sections()?, change: Change::default(), ensemble })
    }

    /// The phase function at angles in rad, sr^-1: the exact sum, no table.
    ///
    /// # Errors
    /// When an angle is not in 0 ..= pi.
    pub fn phase(&self, theta_rad: &[f64]) -> Result<Vec<f64>, MieError> {
        let scale = self.ensemble.phase_scale(self.cross_sections.c_sca_m2);
        let mut values = self.ensemble.intensities(theta_rad)?;
        values.iter_mut().for_each(|value| *value *= scale);
        Ok(values)
    }

    /// A table of the phase function; `None` where nothing is scattered.
    ///
    /// Fringes of single spheres above x = 2000 are blurred over three periods, except near 0 and pi.
    ///
    /// # Errors
    /// When a sphere is outside the domain of the Mie series.
    pub fn phase_table(&self, angle_tolerance: f64) -> Result<Option<BuiltTable>, MieError> {
        let x = self.ensemble.largest_x();
        if x > BLUR_ABOVE_X && self.ensemble.len() < FEW_RADII {
            let blurred = BlurredIntensity::new(&self.ensemble, x)?;
            let accuracy = TableAccuracy { tolerance: angle_tolerance.max(BLURRED.tolerance), ..BLURRED };
            return build_adaptive(x, accuracy, |theta| blurred.at(theta));
        }
        // Every node is measured together with the middle beside it.
        let affordable = (0.5 * TABLE_BUDGET / self.ensemble.terms()) as usize;
        let max_nodes = affordable.clamp(ALWAYS_NODES, MAX_NODES);
        let accuracy = TableAccuracy { tolerance: angle_tolerance, max_nodes };
        build_adaptive(x, accuracy, |theta| self.ensemble.intensities(theta))
    }
}

/// Weights that add up to 1.
fn shares(mut radii: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let total: f64 = radii.iter().map(|(_, weight)| weight).sum();
    radii.iter_mut().for_each(|(_, weight)| *weight /= total);
    radii
}

/// Cross sections alone, without intensities: the radii are doubled until C_ext and g stand still.
///
/// # Errors
/// When a sphere is outside the domain of the Mie series.
pub fn average_cross_sections(
    m: Complex64,
    wavelength_m: f64,
    sizes: &Sizes,
    accuracy: AverageAccuracy,
) -> Result<CrossSections, MieError> {
    let over = |radii| Ensemble::without_series(m, wavelength_m, radii).cross_sections();
    let division = match Summed::of(sizes, wavelength_m) {
        Summed::Few(radii) => return over(radii),
        Summed::Divided(division) => division,
    };
    let max_radii = accuracy.max_radii_for(division.mean_radius_m() * 2.0 * PI / wavelength_m);
    let average = |radii: usize| over(division.nodes(radii));
    let mut radii = FIRST_RADII.min(max_radii / 2).max(2);
    let mut coarse = average(radii)?;
    loop {
        radii *= 2;
        let fine = average(radii)?;
        let change = (coarse.c_ext_m2 / fine.c_ext_m2 - 1.0).abs().max((coarse.g - fine.g).abs());
        if change <= accuracy.size_tolerance || 2 * radii > max_radii {
            return Ok(fine);
        }
        coarse = fine;
    }
}

/// An ensemble with its averages and its intensities at the probe angles.
struct Probe {
    ensemble: Ensemble,
    cross_sections: CrossSections,
    phase: Vec<f64>,
}

impl Probe {
    fn new(m: Complex64, wavelength_m: f64, sizes: Vec<(f64, f64)>, theta: &[f64]) -> Result<Self, MieError> {
        let ensemble = Ensemble::new(m, wavelength_m, sizes)?;
        let cross_sections = ensemble.cross_sections()?;
        let scale = ensemble.phase_scale(cross_sections.c_sca_m2);
        let phase = ensemble.intensities(theta)?.into_iter().map(|value| value * scale).collect();
        Ok(Self { ensemble, cross_sections, phase })
    }

    fn change(&self, finer: &Self) -> Change {
        let relative = |coarse: f64, fine: f64| if coarse == fine { 0.0 } else { (coarse / fine - 1.0).abs() };
        let mut changes: Vec<f64> = self.phase.iter().zip(&finer.phase).map(|(a, b)| relative(*a, *b)).collect();
        changes.sort_by(f64::total_cmp);
        Change {
            c_ext: relative(self.cross_sections.c_ext_m2, finer.cross_sections.c_ext_m2),
            g: (self.cross_sections.g - finer.cross_sections.g).abs(),
            p_median: changes[changes.len() / 2],
            p_worst: changes[changes.len() - 1],
        }
    }
}

/// Where p is watched while the radii are doubled, rad: the forward peak, the sides, the bows and the glory.
fn probe_angles() -> Vec<f64> {
    let forward = [0.0, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 15.0];
    let sides = (2..=12).map(|i| 10.0 * f64::from(i));
    let bows = (0..12).map(|i| 125.0 + 2.5 * f64::from(i));
    let glory = (0..20).map(|i| 161.0 + f64::from(i));
    forward.into_iter().chain(sides).chain(bows).chain(glory).map(f64::to_radians).collect()
}
