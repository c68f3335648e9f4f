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
    n_bins: usize,
    n_wavelengths: usize,
    /// Extinction cross sections, m^2.
    c_ext_m2: Vec<f64>,
    /// Optical depth of a droplet's disc: -ln(1 - p), p the probability that a droplet met there acts.
    disc_depth: Vec<f64>,
    /// Per bin, the least of `disc_depth` and of `c_ext_m2` over the wavelengths.
    least_depth: Vec<(f64, f64)>,
    /// Single-scattering albedo.
    albedo: Vec<f64>,
    phase: Vec<Arc<PhaseFunction>>,
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
        let disc_depth = rows(&|bin, w| -(-(at(bin, w).q_ext / disc_area(bin)).min(1.0)).ln_1p());
        let least = |values: &[f64], bin: usize| {
            values[bin * n_wavelengths..(bin + 1) * n_wavelengths].iter().copied().fold(f64::INFINITY, f64::min)
        };
        Self {
            least_depth: (0..n_bins).map(|bin| (least(&disc_depth, bin), least(&c_ext_m2, bin))).collect(),
            n_wavelengths,
            n_bins,
            c_ext_m2,
            disc_depth,
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

    /// Number of size bins.
    pub fn n_bins(&self) -> usize {
        self.n_bins
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

    /// Optical depths of the disc of one droplet, by wavelength; infinite where it always acts.
    #[inline]
    pub fn disc_depth(&self, bin: usize) -> &[f64] {
        self.row(&self.disc_depth, bin)
    }

    /// Smallest optical depth of any wavelength that a body of the bin adds per droplet met on a disc, or per droplet and
    /// square metre in fog.
    #[inline]
    pub fn least_depth(&self, bin: usize) -> (f64, f64) {
        self.least_depth[bin]
    }

    /// Single-scattering albedos, by wavelength.
    #[inline]
    pub fn albedo(&self, bin: usize) -> &[f64] {
        self.row(&self.albedo, bin)
    }

    /// Scattering efficiency of a droplet against its drawn size.
    #[inline]
    pub fn q_sca(&self, bin: usize, wavelength: usize) -> f64 {
        let at = bin * self.n_wavelengths + wavelength;
        let acts = -(-self.disc_depth[at]).exp_m1();
        self.albedo[at] * acts * self.disc_scale[bin] * self.disc_scale[bin]
    }

    /// Phase functions, by wavelength.
    #[inline]
    pub fn phase(&self, bin: usize) -> &[Arc<PhaseFunction>] {
        self.row(&self.phase, bin)
    }
}
