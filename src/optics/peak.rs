//! Phase functions without their forward peak: what is scattered by very little counts as not scattered at all.
//!
//! Legend: theta_c, the angle at which the peak is cut; f, the share of the scattered light that is taken away; h = 1 - cos.
//! Inside theta_c the function stays at its value there (Potter 1970), so that it is continuous and outside of theta_c
//! nothing changes: the product of extinction, albedo and phase function is what it was (theory (95), (96)).

use std::collections::BTreeMap;
use std::sync::Arc;

use super::bin_optics::BinOptics;
use super::phase_build::{MAX_NODES, TableAccuracy, build_adaptive};
use super::phase_function::PhaseFunction;
use super::phase_table::PhaseTable;
use super::tables::OpticalTables;

/// Relative error of the table that stands for a function in closed form: below what the cut itself changes.
const CLOSED_FORM_TOLERANCE: f64 = 1e-4;

/// A phase function without its forward peak.
#[derive(Clone, Debug, PartialEq)]
pub struct WithoutPeak {
    /// What is left, normalised to 1 again.
    pub phase: Arc<PhaseFunction>,
    /// Share f of the scattered light that was in the peak, above 0 and below 1.
    pub removed: f64,
}

/// Cuts the forward peak off at an angle in rad, above 0 and below pi; `None` where there is no peak, less light
/// being scattered inside the angle than if all of it were as bright as its edge.
pub fn without_peak(phase: &PhaseFunction, angle_rad: f64) -> Option<WithoutPeak> {
    let (table, removed) = match phase {
        PhaseFunction::Isotropic | PhaseFunction::Rayleigh => None,
        PhaseFunction::HenyeyGreenstein(_) | PhaseFunction::HgDraine(_) => table_of(phase)?.without_peak(angle_rad),
        PhaseFunction::Tabulated(table) => table.without_peak(angle_rad),
    }?;
    Some(WithoutPeak { phase: Arc::new(PhaseFunction::Tabulated(table)), removed })
}

/// A table of a function in closed form.
fn table_of(phase: &PhaseFunction) -> Option<PhaseTable> {
    let values = |theta: &[f64]| -> Result<Vec<f64>, std::convert::Infallible> {
        Ok(theta.iter().map(|theta| phase.eval(2.0 * (0.5 * theta).sin().powi(2))).collect())
    };
    let accuracy = TableAccuracy { tolerance: CLOSED_FORM_TOLERANCE, max_nodes: MAX_NODES };
    let Ok(built) = build_adaptive(1.0 / (1.0 - phase.mean_cosine().abs()), accuracy, values);
    built.map(|built| built.table)
}

impl OpticalTables {
    /// The tables without forward peaks: extinction, albedo and phase function of every bin and wavelength (theory (96)).
    ///
    /// `albedo` says what share of what it removes a droplet scatters, which need not be what its material says.
    pub fn without_peaks(mut self, angle_rad: f64, albedo: impl Fn(&BinOptics) -> f64) -> Self {
        // Bins that share a phase function go on sharing one. The originals are kept until all are done, so that no new
        // function takes the address of an old one.
        let mut known: BTreeMap<usize, (Arc<PhaseFunction>, Option<WithoutPeak>)> = BTreeMap::new();
        for optics in self.bins.iter_mut().flat_map(|bin| &mut bin.optics) {
            let key = Arc::as_ptr(&optics.phase) as usize;
            let cut = || (optics.phase.clone(), without_peak(&optics.phase, angle_rad));
            if let (_, Some(cut)) = known.entry(key).or_insert_with(cut) {
                *optics = optics.scaled(cut, albedo(optics));
            }
        }
        self
    }
}

impl BinOptics {
    /// What is left where the light in the peak counts as not removed.
    fn scaled(&self, cut: &WithoutPeak, albedo: f64) -> Self {
        let left = 1.0 - albedo * cut.removed;
        let albedo = albedo * (1.0 - cut.removed) / left;
        Self {
            c_ext_m2: left * self.c_ext_m2,
            c_sca_m2: albedo * left * self.c_ext_m2,
            q_ext: left * self.q_ext,
            q_sca: albedo * left * self.q_ext,
            g: self.g,
            albedo,
            phase: cut.phase.clone(),
        }
    }
}
