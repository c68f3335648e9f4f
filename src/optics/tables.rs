//! What every size bin does to light at every wavelength of a picture.

use std::collections::BTreeSet;
use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;
use thiserror::Error;

use super::DropletClass;
use super::bin_optics::{BinJob, BinOptics, capped_table};
use super::bins::{BinPlan, SizeBin};
use super::cache::TableCache;
use super::count::TableStore;
use super::distribution::Shape;
use super::hg_draine::{MAX_DIAMETER_UM, MIN_DIAMETER_UM};
use super::material::{Material, MaterialError};
use super::phase_function::PhaseFunction;
use super::phase_model::PhaseModel;
use super::phase_table::PhaseTable;
use super::size_average::AverageAccuracy;
use super::turns::in_turns;
use crate::mie::MieError;
use crate::spectrum::observer::VISIBLE_MIN_NM;
use crate::warning::Warning;

/// Tables could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum OpticsError {
    /// The material has no index at a wavelength.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A droplet is outside the domain of the Mie series.
    #[error(
        "droplets `{sizes}` at {wavelength_nm} nm: {reason}; change their radius (rmax of a distribution) or the wavelength"
    )]
    Mie { sizes: String, wavelength_nm: f64, reason: MieError },
    /// The fitted phase function does not reach these droplets.
    #[error(
        "phase model hg-draine: droplets `{sizes}` have an effective diameter of {diameter_um} um; the model was fitted to {MIN_DIAMETER_UM} to {MAX_DIAMETER_UM} um; use mie or hg"
    )]
    HgDraine { sizes: String, diameter_um: f64 },
    /// A phase function's values cannot be normalised.
    #[error("phase function {0}: its values cannot be normalised; they must be finite and one must be above zero")]
    PhaseTable(String),
    /// A bin names a class that is not there.
    #[error("size bin of droplet class {class}, but there are {classes} classes")]
    Class { class: u16, classes: usize },
}

/// What tables are made from, besides bins and classes.
#[derive(Clone, Debug)]
pub struct TableSettings<'a> {
    /// Vacuum wavelengths, m.
    pub wavelengths_m: &'a [f64],
    /// Edges of the bands around them, m, one more than there are wavelengths; empty where each is meant alone.
    pub band_edges_m: &'a [f64],
    /// Above this size parameter phase functions are those at it.
    pub size_parameter_cap: f64,
    /// How well averages and phase tables are made.
    pub accuracy: AverageAccuracy,
    /// Where tables are kept between runs, and who counts them.
    pub store: TableStore<'a>,
}

impl TableSettings<'_> {
    fn band_m(&self, wavelength: usize) -> Option<[f64; 2]> {
        Some([*self.band_edges_m.get(wavelength)?, *self.band_edges_m.get(wavelength + 1)?])
    }
}

/// One bin at all wavelengths.
#[derive(Clone, Debug)]
pub struct BinTables {
    /// Largest extinction efficiency over 380-780 nm and the wavelengths of the picture: sizes a droplet's disc.
    pub q_max: f64,
    /// Mean geometric cross section of a droplet, m^2.
    pub mean_area_m2: f64,
    /// Mean volume of a droplet, m^3.
    pub mean_volume_m3: f64,
    /// One per wavelength.
    pub optics: Vec<BinOptics>,
}

/// What every size bin does to light at every wavelength.
#[derive(Clone, Debug)]
pub struct OpticalTables {
    /// Vacuum wavelengths, m.
    pub wavelengths_m: Vec<f64>,
    /// One per size bin.
    pub bins: Vec<BinTables>,
    /// What was noticed.
    pub warnings: Vec<Warning>,
}

impl OpticalTables {
    /// Makes the tables of all bins; the result does not depend on the number of threads, nor on the cache.
    ///
    /// # Errors
    /// When a material has no index at a wavelength, a droplet is outside the domain of the Mie series, or a phase
    /// model does not reach the droplets.
    pub fn build(plan: &BinPlan, classes: &[DropletClass], settings: &TableSettings) -> Result<Self, OpticsError> {
        let shared = SharedPhases::new(plan, classes, settings)?;
        let jobs: Vec<BinJob> =
            plan.bins.iter().map(|bin| job(bin, plan, classes, settings, &shared)).collect::<Result<_, _>>()?;
        let cache = settings.store.cache.map(TableCache::new);
        let pairs: Vec<(usize, usize)> =
            (0..jobs.len()).flat_map(|bin| (0..settings.wavelengths_m.len()).map(move |w| (bin, w))).collect();
        let compute = |(bin, w): &(usize, usize)| {
            let capped = shared.capped(*bin, *w);
            let optics = jobs[*bin].optics(settings.wavelengths_m[*w], settings.band_m(*w), capped, cache.as_ref());
            settings.store.made_one();
            optics
        };
        // One more for each bin: how large its droplets' discs are takes as long as a table.
        settings.store.want(pairs.len() + jobs.len());
        let mut optics = in_turns(&pairs, |(bin, _)| jobs[*bin].is_large(), compute)?.into_iter();
        let visible_q_max = |job: &BinJob| {
            let q_max = job.visible_q_max();
            settings.store.made_one();
            q_max
        };
        let visible = in_turns(&jobs, BinJob::is_large, visible_q_max)?;
        let mut bins = Vec::with_capacity(jobs.len());
        for (job, visible_q_max) in jobs.iter().zip(visible) {
            let optics: Vec<BinOptics> = optics.by_ref().take(settings.wavelengths_m.len()).collect();
            bins.push(BinTables {
                q_max: optics.iter().map(|optics| optics.q_ext).fold(visible_q_max, f64::max),
                mean_area_m2: job.enlarged.powi(2) * job.law.mean_area_m2(),
                mean_volume_m3: job.enlarged.powi(3) * job.law.mean_volume_m3(),
                optics,
            });
        }
        Ok(Self { wavelengths_m: settings.wavelengths_m.to_vec(), bins, warnings: shared.warnings })
    }

    /// The optics of a bin at a wavelength.
    pub fn get(&self, bin: u32, wavelength: usize) -> &BinOptics {
        &self.bins[bin as usize].optics[wavelength]
    }

    /// Memory of the tables, bytes; shared phase functions are counted once.
    pub fn bytes(&self) -> usize {
        let mut seen = BTreeSet::new();
        let phases = self.bins.iter().flat_map(|bin| &bin.optics).map(|optics| &optics.phase);
        let phase_bytes: usize =
            phases.filter(|phase| seen.insert(Arc::as_ptr(phase) as usize)).map(|phase| phase.bytes()).sum();
        let rows: usize = self.bins.iter().map(|bin| bin.optics.len()).sum();
        phase_bytes + rows * size_of::<BinOptics>() + self.bins.len() * size_of::<BinTables>()
    }
}

/// Bytes that the tables of a plan's bins will take, about, and rather too many.
///
/// A single sphere's fringes take 380 bytes times x (measured) up to the nodes of a blurred table, or those of the finest; where
/// many sizes wash them out, tens of kilobytes are left.
pub fn predicted_bytes(plan: &BinPlan, classes: &[DropletClass], wavelengths_m: &[f64]) -> u64 {
    const FIXED: f64 = 4096.0;
    const PER_X: f64 = 400.0;
    const FINEST: f64 = 1.4e6;
    const WASHED_OUT: f64 = 65_536.0;
    let one = |bin: &SizeBin, wavelength_m: f64| {
        if classes.get(usize::from(bin.class)).is_some_and(|class| class.phase != PhaseModel::Mie) {
            return FIXED;
        }
        let fringes = FIXED + PER_X * 2.0 * std::f64::consts::PI * bin.distribution.r_max_m / wavelength_m;
        let is_mono = matches!(bin.distribution.shape, Shape::Mono { .. });
        fringes.min(if is_mono { FINEST } else { WASHED_OUT })
    };
    plan.bins.iter().flat_map(|bin| wavelengths_m.iter().map(move |l_m| one(bin, *l_m))).sum::<f64>() as u64
}

/// Largest radius that the Mie series reaches at a wavelength, x = 1e6, with a margin for rounding.
fn largest_radius_m(wavelength_m: f64) -> f64 {
    0.999 * 1e6 * wavelength_m / (2.0 * std::f64::consts::PI)
}

/// The bin with radii that the Mie series reaches at all wavelengths, and the factor by which they were divided.
fn within_reach(bin: &SizeBin, wavelengths_m: &[f64]) -> (SizeBin, f64) {
    let shortest_m = wavelengths_m.iter().copied().fold(VISIBLE_MIN_NM * 1e-9, f64::min);
    let enlarged = (bin.distribution.r_max_m / largest_radius_m(shortest_m)).max(1.0);
    if enlarged == 1.0 {
        return (bin.clone(), 1.0);
    }
    (SizeBin { class: bin.class, distribution: bin.distribution.divided_by(enlarged) }, enlarged)
}

fn job<'a>(
    bin: &SizeBin,
    plan: &BinPlan,
    classes: &'a [DropletClass],
    settings: &TableSettings,
    shared: &SharedPhases,
) -> Result<BinJob<'a>, OpticsError> {
    let class = find_class(bin, classes)?;
    let sharing = plan.bins.iter().filter(|other| other.class == bin.class && other.is_slice()).count();
    let table = shared.files[usize::from(bin.class)].clone();
    let accuracy = if bin.is_slice() { settings.accuracy.shared_by(sharing) } else { settings.accuracy };
    let (bin, enlarged) = within_reach(bin, settings.wavelengths_m);
    Ok(BinJob {
        law: bin.distribution.law(),
        bin,
        enlarged,
        class,
        table,
        size_parameter_cap: settings.size_parameter_cap,
        accuracy,
    })
}

fn find_class<'a>(bin: &SizeBin, classes: &'a [DropletClass]) -> Result<&'a DropletClass, OpticsError> {
    let missing = OpticsError::Class { class: bin.class, classes: classes.len() };
    classes.get(usize::from(bin.class)).ok_or(missing)
}

/// Phase functions that several bins have in common.
struct SharedPhases {
    /// Per class, the function that was read from a file.
    files: Vec<Option<Arc<PhaseFunction>>>,
    /// Functions at the cap, by index and wavelength.
    at_cap: Vec<((Complex64, f64), Arc<PhaseFunction>)>,
    /// Per bin and wavelength, which of them it takes.
    takes: Vec<Vec<Option<usize>>>,
    warnings: Vec<Warning>,
}

impl SharedPhases {
    fn new(plan: &BinPlan, classes: &[DropletClass], settings: &TableSettings) -> Result<Self, OpticsError> {
        let files = classes.iter().map(file_phase).collect::<Result<Vec<_>, _>>()?;
        let mut shared = Self { files, at_cap: Vec::new(), takes: Vec::new(), warnings: Vec::new() };
        let (mut keys, mut largest_x) = (Vec::<(Complex64, f64)>::new(), 0.0);
        for bin in &plan.bins {
            let class = find_class(bin, classes)?;
            let law = bin.distribution.law();
            let reff_m = law.mono_radius().unwrap_or_else(|| law.effective_radius_m());
            let mut takes = vec![None; settings.wavelengths_m.len()];
            for (take, wavelength_m) in takes.iter_mut().zip(settings.wavelengths_m) {
                let x = 2.0 * std::f64::consts::PI * reff_m / wavelength_m;
                if x > settings.size_parameter_cap && class.phase == PhaseModel::Mie {
                    largest_x = x.max(largest_x);
                    let key = (class.material.index(*wavelength_m)?, *wavelength_m);
                    *take = Some(keys.iter().position(|known| *known == key).unwrap_or(keys.len()));
                    if *take == Some(keys.len()) {
                        keys.push(key);
                    }
                }
            }
            shared.takes.push(takes);
        }
        let cache = settings.store.cache.map(TableCache::new);
        let make = |(m, wavelength_m): &(Complex64, f64)| {
            let table = capped_table(*m, *wavelength_m, settings.size_parameter_cap, settings.accuracy, cache.as_ref());
            settings.store.made_one();
            table
        };
        settings.store.want(keys.len());
        let tables = keys.par_iter().map(make).collect::<Result<Vec<_>, _>>()?;
        shared.at_cap = keys.into_iter().zip(tables).collect();
        let coarse = classes.iter().filter_map(coarse_warning);
        shared.warnings = cap_warning(largest_x, settings.size_parameter_cap).into_iter().chain(coarse).collect();
        shared.warnings.dedup();
        Ok(shared)
    }

    fn capped(&self, bin: usize, wavelength: usize) -> Option<&Arc<PhaseFunction>> {
        self.takes[bin][wavelength].map(|i| &self.at_cap[i].1)
    }
}

fn file_phase(class: &DropletClass) -> Result<Option<Arc<PhaseFunction>>, OpticsError> {
    let PhaseModel::Table(table) = &class.phase else { return Ok(None) };
    let phase = PhaseTable::from_samples(&table.theta_rad, &table.value);
    let phase = phase.ok_or_else(|| OpticsError::PhaseTable(table.name.clone()))?;
    Ok(Some(Arc::new(PhaseFunction::Tabulated(phase))))
}

/// A table whose angles miss a peak is normalised to what it shows of it: all other angles are then too bright or too dark.
const COARSE: f64 = 0.01;

fn coarse_warning(class: &DropletClass) -> Option<Warning> {
    let PhaseModel::Table(table) = &class.phase else { return None };
    let error = PhaseTable::step_error(&table.theta_rad, &table.value)?;
    (error > COARSE).then(|| {
        Warning::new(
            format!(
                "{}: the angles of this phase function are too far apart: without every other one its integral changes by {:.2} %",
                table.name,
                300.0 * error
            ),
            "give more angles where it is steep, above all near 0 degrees",
        )
    })
}

fn cap_warning(largest_x: f64, cap: f64) -> Option<Warning> {
    (largest_x > cap).then(|| {
        Warning::new(
            format!(
                "droplets of size parameters up to {largest_x:.3e} scatter with the phase function at {cap:e}; they differ \
                 inside the forward diffraction peak only"
            ),
            "raise accuracy.size_parameter_cap if that peak matters (tables take longer)",
        )
    })
}

/// The index of a class's material, for effects that need it per wavelength.
///
/// # Errors
/// When the material has no index at a wavelength.
pub fn indices(material: &Material, wavelengths_m: &[f64]) -> Result<Vec<Complex64>, MaterialError> {
    wavelengths_m.iter().map(|wavelength_m| material.index(*wavelength_m)).collect()
}
