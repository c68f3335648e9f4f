//! Phase functions of single bins, beside those of the mixture: kept as finely as memory allows.

use rayon::prelude::*;

use super::blur::BlurTable;
use crate::transport::media::Media;

/// Numbers of sharp phase tables that are kept bin by bin; beyond, single droplets too are told apart by deviations.
pub(super) const MOST_TABLED: usize = 1 << 24;

/// Phase functions of single bins on the grid of the mixture's, wavelengths running fastest.
pub(super) struct BinPhases {
    /// Entries per bin: all, the sharp ones, or none, as memory allows.
    pub n_entries: usize,
    /// Whether all entries are there.
    pub is_blurred: bool,
    pub values: Vec<f32>,
}

impl BinPhases {
    /// Those of all bins, blurred where there is room, sharp where there is room for that.
    pub fn new(media: &Media, phases: &BlurTable, step_rad: f64) -> Self {
        let (n_bins, n) = (media.n_bins(), media.n_wavelengths());
        let fits = |n_entries: usize| n_bins >= 2 && n_bins * n * n_entries <= MOST_TABLED;
        let eval = |bin: usize, h: f64, out: &mut [f64]| {
            out.iter_mut().zip(media.phase(bin)).for_each(|(out, phase)| *out = phase.eval(h));
        };
        let of_all = |one: &(dyn Fn(usize) -> Vec<f32> + Sync)| -> Vec<f32> {
            (0..n_bins).into_par_iter().map(one).collect::<Vec<_>>().concat()
        };
        if fits(phases.len()) {
            let one = |bin: usize| BlurTable::new(step_rad, n, &[], |h, out| eval(bin, h, out)).into_values();
            return Self { n_entries: phases.len(), is_blurred: true, values: of_all(&one) };
        }
        if fits(phases.sharp_len()) {
            let h: Vec<f64> = phases.sharp_h().collect();
            let at = |bin: usize, h: f64| media.phase(bin).iter().map(move |phase| phase.eval(h) as f32);
            let one = |bin: usize| h.iter().flat_map(|h| at(bin, *h)).collect();
            return Self { n_entries: phases.sharp_len(), is_blurred: false, values: of_all(&one) };
        }
        Self { n_entries: 0, is_blurred: false, values: Vec::new() }
    }
}
