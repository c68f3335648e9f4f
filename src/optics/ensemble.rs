//! A weighted set of spheres of one material at one wavelength: summed cross sections and intensities.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::mie::{Angles, IntensitySum, MieError, ScatteringMatrix, Series, Solver};

/// Spheres per unit of parallel work, and of summation: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 32;

/// Angles per unit of parallel work for sets smaller than a chunk.
const ANGLE_CHUNK: usize = 2048;

/// Series are kept between batches of angles while they take no more than this, bytes.
const KEPT_BYTES: f64 = 16e6;

/// Spheres of one material, with the share of droplets that each stands for.
#[derive(Clone, Debug)]
pub struct Ensemble {
    m: Complex64,
    wave_number_per_m: f64,
    /// Radius in m and weight.
    sizes: Vec<(f64, f64)>,
    kept: Vec<Series>,
}

/// Sums over an ensemble; means per droplet if the weights add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrossSections {
    /// Extinction cross section, m^2.
    pub c_ext_m2: f64,
    /// Scattering cross section, m^2.
    pub c_sca_m2: f64,
    /// Absorption cross section, m^2.
    pub c_abs_m2: f64,
    /// Asymmetry parameter, weighted by scattering.
    pub g: f64,
    /// Geometric cross section, m^2.
    pub area_m2: f64,
}

impl Ensemble {
    /// Spheres of index `m` at a vacuum wavelength, of which cross sections are wanted alone: their series are not kept.
    pub fn without_series(m: Complex64, wavelength_m: f64, sizes: Vec<(f64, f64)>) -> Self {
        Self { m, wave_number_per_m: 2.0 * PI / wavelength_m, sizes, kept: Vec::new() }
    }

    /// Spheres of index `m` at a vacuum wavelength; `sizes` are radii in m and weights.
    ///
    /// # Errors
    /// When a sphere is outside the domain of the Mie series.
    pub fn new(m: Complex64, wavelength_m: f64, sizes: Vec<(f64, f64)>) -> Result<Self, MieError> {
        let mut ensemble = Self::without_series(m, wavelength_m, sizes);
        // Two complex numbers per term.
        if ensemble.terms() * 32.0 <= KEPT_BYTES {
            let chunks = ensemble.sizes.par_chunks(CHUNK).map(|chunk| ensemble.solve(chunk));
            ensemble.kept = chunks.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        }
        Ok(ensemble)
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.sizes.len()
    }

    /// Whether there are no spheres.
    pub fn is_empty(&self) -> bool {
        self.sizes.is_empty()
    }

    /// The largest size parameter.
    pub fn largest_x(&self) -> f64 {
        self.sizes.iter().map(|(r_m, _)| r_m * self.wave_number_per_m).fold(0.0, f64::max)
    }

    /// About how many partial waves there are in all spheres.
    pub fn terms(&self) -> f64 {
        self.sizes.iter().map(|(r_m, _)| r_m * self.wave_number_per_m + 20.0).sum()
    }

    fn solve(&self, sizes: &[(f64, f64)]) -> Result<Vec<Series>, MieError> {
        let mut solver = Solver::new();
        sizes.iter().map(|(r_m, _)| solver.series(r_m * self.wave_number_per_m, self.m)).collect()
    }

    /// The summed cross sections.
    ///
    /// # Errors
    /// When a sphere is outside the domain of the Mie series.
    pub fn cross_sections(&self) -> Result<CrossSections, MieError> {
        let starts: Vec<usize> = (0..self.sizes.len()).step_by(CHUNK).collect();
        let sums: Vec<CrossSections> =
            starts.into_par_iter().map(|start| self.chunk_cross_sections(start)).collect::<Result<_, MieError>>()?;
        let mut sum = sums.into_iter().fold(CrossSections::default(), CrossSections::plus);
        sum.g = if sum.c_sca_m2 > 0.0 { sum.g / sum.c_sca_m2 } else { 0.0 };
        Ok(sum)
    }

    fn chunk_cross_sections(&self, start: usize) -> Result<CrossSections, MieError> {
        let end = (start + CHUNK).min(self.sizes.len());
        let mut solver = Solver::new();
        (start..end).try_fold(CrossSections::default(), |sum, i| {
            let (r_m, weight) = self.sizes[i];
            let q = match self.kept.get(i) {
                Some(series) => series.efficiencies(),
                None => solver.efficiencies(r_m * self.wave_number_per_m, self.m)?,
            };
            let area_m2 = weight * PI * r_m * r_m;
            let one = CrossSections {
                c_ext_m2: area_m2 * q.q_ext,
                c_sca_m2: area_m2 * q.q_sca,
                c_abs_m2: area_m2 * q.q_abs,
                g: area_m2 * q.q_sca * q.g,
                area_m2,
            };
            Ok(sum.plus(one))
        })
    }

    /// The summed intensities (|S1|^2 + |S2|^2) / 2 at angles in rad.
    ///
    /// # Errors
    /// When a sphere or an angle is out of range.
    pub fn intensities(&self, theta_rad: &[f64]) -> Result<Vec<f64>, MieError> {
        if self.sizes.len() < CHUNK && theta_rad.len() > ANGLE_CHUNK {
            return self.intensities_by_angle(theta_rad);
        }
        let angles = Angles::new(theta_rad)?;
        let starts: Vec<usize> = (0..self.sizes.len()).step_by(CHUNK).collect();
        let parts: Vec<Vec<f64>> =
            starts.into_par_iter().map(|start| self.chunk_intensities(start, &angles)).collect::<Result<_, _>>()?;
        let mut sum = vec![0.0; theta_rad.len()];
        for part in parts {
            sum.iter_mut().zip(part).for_each(|(sum, value)| *sum += value);
        }
        Ok(sum)
    }

    /// Few spheres at many angles: the angles are what is divided.
    fn intensities_by_angle(&self, theta_rad: &[f64]) -> Result<Vec<f64>, MieError> {
        let parts: Vec<Vec<f64>> =
            theta_rad.par_chunks(ANGLE_CHUNK).map(|theta| self.intensities(theta)).collect::<Result<_, _>>()?;
        Ok(parts.concat())
    }

    fn chunk_intensities(&self, start: usize, angles: &Angles) -> Result<Vec<f64>, MieError> {
        let end = (start + CHUNK).min(self.sizes.len());
        let mut sum = IntensitySum::new(angles);
        let mut solver = Solver::new();
        for i in start..end {
            let (r_m, weight) = self.sizes[i];
            match self.kept.get(i) {
                Some(series) => sum.add(series, weight),
                None => sum.add(&solver.series(r_m * self.wave_number_per_m, self.m)?, weight),
            }
        }
        let mut out = vec![0.0; angles.len()];
        sum.write(&mut out)?;
        Ok(out)
    }

    /// The summed scattering matrices at angles in rad.
    ///
    /// # Errors
    /// When a sphere or an angle is out of range.
    pub fn scattering_matrices(&self, theta_rad: &[f64]) -> Result<Vec<ScatteringMatrix>, MieError> {
        let batches: Vec<Vec<ScatteringMatrix>> = theta_rad
            .par_chunks(ANGLE_CHUNK)
            .map(|theta| self.batch_matrices(&Angles::new(theta)?))
            .collect::<Result<_, MieError>>()?;
        Ok(batches.concat())
    }

    /// The sum at a batch of angles, few enough for a sum per chunk of spheres to be kept.
    fn batch_matrices(&self, angles: &Angles) -> Result<Vec<ScatteringMatrix>, MieError> {
        let starts: Vec<usize> = (0..self.sizes.len()).step_by(CHUNK).collect();
        let parts: Vec<Vec<ScatteringMatrix>> =
            starts.into_par_iter().map(|start| self.chunk_matrices(start, angles)).collect::<Result<_, _>>()?;
        let mut sum = vec![ScatteringMatrix::default(); angles.len()];
        for part in parts {
            sum.iter_mut().zip(part).for_each(|(sum, value)| *sum = sum.plus(1.0, value));
        }
        Ok(sum)
    }

    fn chunk_matrices(&self, start: usize, angles: &Angles) -> Result<Vec<ScatteringMatrix>, MieError> {
        let end = (start + CHUNK).min(self.sizes.len());
        let mut solver = Solver::new();
        let mut sum = vec![ScatteringMatrix::default(); angles.len()];
        let mut s1 = vec![Complex64::default(); angles.len()];
        let mut s2 = s1.clone();
        for i in start..end {
            let (r_m, weight) = self.sizes[i];
            match self.kept.get(i) {
                Some(series) => series.amplitudes_at(angles, &mut s1, &mut s2)?,
                None => solver.series(r_m * self.wave_number_per_m, self.m)?.amplitudes_at(angles, &mut s1, &mut s2)?,
            }
            for ((sum, s1), s2) in sum.iter_mut().zip(&s1).zip(&s2) {
                *sum = sum.plus(weight, ScatteringMatrix::from_amplitudes(*s1, *s2));
            }
        }
        Ok(sum)
    }

    /// What intensities are multiplied by to become a phase function: 1 / (k^2 C_sca), sr^-1.
    pub fn phase_scale(&self, c_sca_m2: f64) -> f64 {
        1.0 / (self.wave_number_per_m * self.wave_number_per_m * c_sca_m2)
    }
}

impl CrossSections {
    fn plus(self, other: Self) -> Self {
        Self {
            c_ext_m2: self.c_ext_m2 + other.c_ext_m2,
            c_sca_m2: self.c_sca_m2 + other.c_sca_m2,
            c_abs_m2: self.c_abs_m2 + other.c_abs_m2,
            g: self.g + other.g,
            area_m2: self.area_m2 + other.area_m2,
        }
    }
}
