//! One size bin at one wavelength: cross sections and phase function, whatever the model.

use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex64;

use super::DropletClass;
use super::bins::SizeBin;
use super::cache::{CacheKey, TableCache};
use super::ensemble::CrossSections;
use super::hg_draine::HgDraine;
use super::phase_function::PhaseFunction;
use super::phase_model::PhaseModel;
use super::phase_table::PhaseTable;
use super::size_average::{AverageAccuracy, BLUR_ABOVE_X, SizeAverage, Sizes, average_cross_sections};
use super::size_law::SizeLaw;
use super::tables::OpticsError;
use crate::mie::MieError;
use crate::spectrum::observer::{VISIBLE_MAX_NM, VISIBLE_MIN_NM};

/// Wavelengths at which the largest extinction is looked for: every 12.5 nm of the visible range for distributions,
/// which are smooth, and every 3.1 nm for a single radius, which has ripples.
const Q_MAX_WAVELENGTHS: [usize; 2] = [33, 129];

/// Above the cap Q_ext is 2 + 2 x^(-2/3) (van de Hulst 1957), 2.003 at the default one, and its ripple smaller still. With
/// a lower cap the wavelengths of the picture, which count too, keep the disc large enough for it.
const Q_MAX_WAVELENGTHS_ABOVE_CAP: usize = 3;

/// Radii for that search: the largest of 33 values needs no more than a percent.
const Q_MAX_ACCURACY: AverageAccuracy =
    AverageAccuracy { size_tolerance: 1e-2, angle_tolerance: 1e-2, max_radii: 256, max_terms: 1e6 };

/// Above this size parameter a sphere's waves take megabytes (six numbers per order).
const ONE_AT_A_TIME_X: f64 = 1e5;

/// What a size bin does to light of one wavelength; cross sections are means per droplet.
#[derive(Clone, Debug, PartialEq)]
pub struct BinOptics {
    /// Extinction cross section, m^2.
    pub c_ext_m2: f64,
    /// Scattering cross section, m^2; at most the extinction cross section.
    pub c_sca_m2: f64,
    /// Extinction efficiency: the cross section over the mean of pi r^2.
    pub q_ext: f64,
    /// Scattering efficiency.
    pub q_sca: f64,
    /// Asymmetry parameter of the exact solution, whatever the phase model.
    pub g: f64,
    /// Single-scattering albedo.
    pub albedo: f64,
    /// The phase function.
    pub phase: Arc<PhaseFunction>,
}

/// One bin, ready to be computed at any wavelength.
pub(super) struct BinJob<'a> {
    /// The bin; its sizes divided by `enlarged`.
    pub bin: SizeBin,
    /// Above 1 for droplets larger than the Mie series reaches: their efficiencies are those of smaller ones.
    pub enlarged: f64,
    pub class: &'a DropletClass,
    pub law: SizeLaw,
    /// The class's phase function where it was read from a file.
    pub table: Option<Arc<PhaseFunction>>,
    pub size_parameter_cap: f64,
    pub accuracy: AverageAccuracy,
}

impl BinJob<'_> {
    /// The bin at a wavelength, or over the band around it; `capped` is the phase function at the cap where that is what it takes.
    pub fn optics(
        &self,
        wavelength_m: f64,
        band_m: Option<[f64; 2]>,
        capped: Option<&Arc<PhaseFunction>>,
        cache: Option<&TableCache>,
    ) -> Result<BinOptics, OpticsError> {
        let m = self.class.material.index(wavelength_m)?;
        let exact = self.class.phase == PhaseModel::Mie && capped.is_none();
        let sizes = self.sizes(wavelength_m, band_m);
        let key = self.key(m, wavelength_m, if exact { "mie" } else { "cross sections" });
        let key = if let Sizes::Band { from_m, to_m, .. } = sizes { key.numbers(&[from_m, to_m]) } else { key };
        let (cross_sections, phase) = match cache.and_then(|cache| cache.load(&key)) {
            Some(found) => found,
            None => {
                let found = self.solve(m, wavelength_m, &sizes, exact)?;
                if let Some(cache) = cache {
                    cache.store(&key, &found.0, found.1.as_ref());
                }
                found
            }
        };
        let phase = match (capped, phase) {
            (Some(capped), _) => capped.clone(),
            (None, Some(table)) => Arc::new(PhaseFunction::Tabulated(table)),
            (None, None) => self.modelled_phase(&cross_sections)?,
        };
        Ok(self.finish(&cross_sections, phase))
    }

    fn key(&self, m: Complex64, wavelength_m: f64, kind: &str) -> CacheKey {
        CacheKey::new(kind)
            .numbers(&[m.re, m.im, wavelength_m, self.size_parameter_cap])
            .accuracy(&self.accuracy)
            .distribution(&self.bin.distribution)
    }

    fn solve(
        &self,
        m: Complex64,
        wavelength_m: f64,
        sizes: &Sizes,
        exact: bool,
    ) -> Result<(CrossSections, Option<PhaseTable>), OpticsError> {
        let name = |reason| self.mie_error(wavelength_m, reason);
        let largest_m = self.size_parameter_cap * wavelength_m / (2.0 * PI);
        if !exact || self.bin.distribution.r_max_m > largest_m {
            let cross_sections = average_cross_sections(m, wavelength_m, sizes, self.accuracy).map_err(name)?;
            if !exact {
                return Ok((cross_sections, None));
            }
            // A distribution whose tail is above the cap: the phase function of what is below it.
            let mut below = self.bin.distribution.clone();
            below.r_max_m = largest_m;
            let sizes = Sizes::Law(Box::new(below.law()));
            let average = SizeAverage::new(m, wavelength_m, &sizes, self.accuracy).map_err(name)?;
            let table = average.phase_table(self.accuracy.angle_tolerance).map_err(name)?;
            return Ok((cross_sections, table.map(|built| built.table)));
        }
        let average = SizeAverage::new(m, wavelength_m, sizes, self.accuracy).map_err(name)?;
        let table = average.phase_table(self.accuracy.angle_tolerance).map_err(name)?;
        Ok((average.cross_sections, table.map(|built| built.table)))
    }

    /// What is averaged. The fringes of a single radius are finer than a band of wavelengths, which washes them out; those of
    /// large spheres are blurred over angles instead.
    fn sizes(&self, wavelength_m: f64, band_m: Option<[f64; 2]>) -> Sizes {
        match (band_m, self.law.mono_radius()) {
            (Some([from_m, to_m]), Some(r_m)) if 2.0 * PI * r_m / wavelength_m <= BLUR_ABOVE_X => {
                Sizes::Band { r_m, from_m, to_m }
            }
            _ => Sizes::Law(Box::new(self.law.clone())),
        }
    }

    /// The phase function of a model that is not exact; isotropic where nothing is scattered at all.
    fn modelled_phase(&self, cross_sections: &CrossSections) -> Result<Arc<PhaseFunction>, OpticsError> {
        let function = match &self.class.phase {
            PhaseModel::Mie | PhaseModel::Isotropic => PhaseFunction::Isotropic,
            PhaseModel::Rayleigh => PhaseFunction::Rayleigh,
            PhaseModel::HenyeyGreenstein { g } => PhaseFunction::henyey_greenstein(g.unwrap_or(cross_sections.g)),
            PhaseModel::HgDraine => {
                let diameter_um = 2e6 * self.effective_radius_m();
                let sizes = self.bin.distribution.to_string();
                let function = HgDraine::new(diameter_um).ok_or(OpticsError::HgDraine { sizes, diameter_um })?;
                PhaseFunction::HgDraine(function)
            }
            PhaseModel::Table(table) => {
                return self.table.clone().ok_or_else(|| OpticsError::PhaseTable(table.name.clone()));
            }
        };
        Ok(Arc::new(function))
    }

    fn effective_radius_m(&self) -> f64 {
        self.law.mono_radius().unwrap_or_else(|| self.law.effective_radius_m())
    }

    fn finish(&self, cross_sections: &CrossSections, phase: Arc<PhaseFunction>) -> BinOptics {
        let area = self.enlarged * self.enlarged;
        let c_ext_m2 = area * cross_sections.c_ext_m2;
        let c_sca_m2 = match self.class.albedo {
            Some(albedo) => albedo * c_ext_m2,
            None => (area * cross_sections.c_sca_m2).min(c_ext_m2),
        };
        BinOptics {
            c_ext_m2,
            c_sca_m2,
            q_ext: c_ext_m2 / (area * cross_sections.area_m2),
            q_sca: c_sca_m2 / (area * cross_sections.area_m2),
            g: cross_sections.g,
            albedo: if c_ext_m2 > 0.0 { c_sca_m2 / c_ext_m2 } else { 0.0 },
            phase,
        }
    }

    /// Whether its spheres need so much memory that they are solved one at a time.
    pub fn is_large(&self) -> bool {
        2.0 * PI * self.bin.distribution.r_max_m / (VISIBLE_MIN_NM * 1e-9) > ONE_AT_A_TIME_X
    }

    /// The largest extinction efficiency over 380-780 nm, as far as the material's data reach.
    pub fn visible_q_max(&self) -> Result<f64, OpticsError> {
        let least_x = 2.0 * PI * self.bin.distribution.r_min_m / (VISIBLE_MAX_NM * 1e-9);
        let count = if least_x > self.size_parameter_cap {
            Q_MAX_WAVELENGTHS_ABOVE_CAP
        } else {
            Q_MAX_WAVELENGTHS[usize::from(self.law.mono_radius().is_some())]
        };
        let step_nm = (VISIBLE_MAX_NM - VISIBLE_MIN_NM) / (count - 1) as f64;
        let visible = (0..count).map(|i| (VISIBLE_MIN_NM + step_nm * i as f64) * 1e-9);
        let mut largest = 0.0f64;
        for wavelength_m in visible {
            if let Ok(m) = self.class.material.index(wavelength_m) {
                let sizes = Sizes::Law(Box::new(self.law.clone()));
                let found = average_cross_sections(m, wavelength_m, &sizes, Q_MAX_ACCURACY);
                let found = found.map_err(|reason| self.mie_error(wavelength_m, reason))?;
                largest = largest.max(found.c_ext_m2 / found.area_m2);
            }
        }
        Ok(largest)
    }

    fn mie_error(&self, wavelength_m: f64, reason: MieError) -> OpticsError {
        OpticsError::Mie { sizes: self.bin.distribution.to_string(), wavelength_nm: wavelength_m * 1e9, reason }
    }
}

/// The phase function of the largest sphere that has one of its own.
pub(super) fn capped_table(
    m: Complex64,
    wavelength_m: f64,
    cap: f64,
    accuracy: AverageAccuracy,
    cache: Option<&TableCache>,
) -> Result<Arc<PhaseFunction>, OpticsError> {
    let key = CacheKey::new("cap").numbers(&[m.re, m.im, wavelength_m, cap]).accuracy(&accuracy);
    if let Some((_, Some(table))) = cache.and_then(|cache| cache.load(&key)) {
        return Ok(Arc::new(PhaseFunction::Tabulated(table)));
    }
    let name = |reason| OpticsError::Mie { sizes: format!("x = {cap}"), wavelength_nm: wavelength_m * 1e9, reason };
    let sizes = Sizes::Radii(vec![(cap * wavelength_m / (2.0 * PI), 1.0)]);
    let average = SizeAverage::new(m, wavelength_m, &sizes, accuracy).map_err(name)?;
    let built = average.phase_table(accuracy.angle_tolerance).map_err(name)?;
    let Some(built) = built else { return Ok(Arc::new(PhaseFunction::Isotropic)) };
    if let Some(cache) = cache {
        cache.store(&key, &average.cross_sections, Some(&built.table));
    }
    Ok(Arc::new(PhaseFunction::Tabulated(built.table)))
}
