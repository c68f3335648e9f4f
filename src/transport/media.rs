//! What the size bins do to light, laid out for the inner loops: one row per bin, one column per wavelength.

use std::sync::Arc;

use crate::optics::phase_function::PhaseFunction;
use crate::optics::tables::OpticalTables;

/// Whether droplets absorb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absorption {
    /// As their material does.
    Simulated,
    /// They scatter all that they remove.
    LeftOut,
}

/// Optical numbers of every size bin at every rendered wavelength.
pub struct Media {
    n_wavelengths: usize,
    /// Extinction cross sections, m^2.
    c_ext_m2: Vec<f64>,
    /// Probability that a droplet met on its disc acts.
    event_probability: Vec<f64>,
    /// Single-scattering albedo.
    albedo: Vec<f64>,
    phase: Vec<Arc<PhaseFunction>>,
    /// Largest extinction cross section of each bin over the wavelengths, m^2.
    max_c_ext_m2: Vec<f64>,
    /// Largest event probability of each bin over the wavelengths.
    max_event_probability: Vec<f64>,
    /// Disc radius of each bin's droplets over their drawn radius.
    disc_scale: Vec<f64>,
}

impl Media {
    /// Lays out the tables; droplets act on a disc of sqrt(max(1, Q_max)) times their drawn radius.
    ///
    /// Tables of a single wavelength serve all of them (no dispersion).
    pub fn new(tables: &OpticalTables, n_wavelengths: usize, absorption: Absorption) -> Self {
        let n_bins = tables.bins.len();
        let at = |bin: usize, w: usize| tables.get(bin as u32, w.min(tables.wavelengths_m.len() - 1));
        let disc_area = |bin: usize| tables.bins[bin].q_max.max(1.0);
        let rows = |f: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..n_bins).flat_map(|bin| (0..n_wavelengths).map(move |w| f(bin, w))).collect()
        };
        let c_ext_m2 = rows(&|bin, w| at(bin, w).c_ext_m2);
        let event_probability = rows(&|bin, w| at(bin, w).q_ext / disc_area(bin));
        let row_max =
            |values: &[f64]| values.chunks(n_wavelengths).map(|row| row.iter().copied().fold(0.0, f64::max)).collect();
        Self {
            n_wavelengths,
            max_c_ext_m2: row_max(&c_ext_m2),
            max_event_probability: row_max(&event_probability),
            c_ext_m2,
            event_probability,
            albedo: rows(&|bin, w| match absorption {
                Absorption::Simulated => at(bin, w).albedo,
                Absorption::LeftOut => 1.0,
            }),
            phase: (0..n_bins)
                .flat_map(|bin| (0..n_wavelengths).map(move |w| (bin, w)))
                .map(|(bin, w)| at(bin, w).phase.clone())
                .collect(),
            disc_scale: (0..n_bins).map(|bin| disc_area(bin).sqrt()).collect(),
        }
    }

    /// Number of wavelengths that travel together.
    pub fn n_wavelengths(&self) -> usize {
        self.n_wavelengths
    }

    /// Disc radius over drawn radius.
    pub fn disc_scale(&self, bin: usize) -> f64 {
        self.disc_scale[bin]
    }

    #[inline]
    fn row<'a, T>(&self, values: &'a [T], bin: usize) -> &'a [T] {
        &values[bin * self.n_wavelengths..(bin + 1) * self.n_wavelengths]
    }

    /// Extinction cross sections of one droplet, m^2, by wavelength.
    #[inline]
    pub fn c_ext_m2(&self, bin: usize) -> &[f64] {
        self.row(&self.c_ext_m2, bin)
    }

    /// Probabilities that one droplet acts where its disc is met, by wavelength.
    #[inline]
    pub fn event_probability(&self, bin: usize) -> &[f64] {
        self.row(&self.event_probability, bin)
    }

    /// Single-scattering albedos, by wavelength.
    #[inline]
    pub fn albedo(&self, bin: usize) -> &[f64] {
        self.row(&self.albedo, bin)
    }

    /// Phase functions, by wavelength.
    #[inline]
    pub fn phase(&self, bin: usize) -> &[Arc<PhaseFunction>] {
        self.row(&self.phase, bin)
    }

    /// Largest extinction cross section over the wavelengths, m^2.
    #[inline]
    pub fn max_c_ext_m2(&self, bin: usize) -> f64 {
        self.max_c_ext_m2[bin]
    }

    /// Largest probability over the wavelengths that one droplet acts.
    #[inline]
    pub fn max_event_probability(&self, bin: usize) -> f64 {
        self.max_event_probability[bin]
    }
}
