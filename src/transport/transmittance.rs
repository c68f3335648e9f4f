//! How much light passes between two points: exact along the ray, for fog and for single droplets.

use std::ops::ControlFlow;

use super::media::Media;
use crate::accel::{Accel, Body, BodyKind, Crossing, LocalRay};

/// Where the sun no longer arrives: less than 2e-35 of its light.
const OPAQUE: f64 = 80.0;

/// Optical depth by wavelength, gathered body by body.
///
/// Bodies of one size bin act alike at every wavelength, so what is summed first is a column per bin.
#[derive(Clone, Debug, Default)]
pub(super) struct OpticalDepth {
    columns: Vec<Column>,
    /// Bins with something in their column.
    touched: Vec<u32>,
    depth: Vec<f64>,
}

/// What a ray has met of one size bin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Column {
    /// Droplets per square metre, in fog.
    fog_per_m2: f64,
    /// Discs of single droplets.
    discs: f64,
}

impl OpticalDepth {
    pub fn new(media: &Media) -> Self {
        Self {
            columns: vec![Column::default(); media.n_bins()],
            touched: Vec::new(),
            depth: vec![0.0; media.n_wavelengths()],
        }
    }

    /// Optical depth by wavelength of the ray from distance 0 to `to`, m. Beyond `OPAQUE` at every wavelength it is not
    /// summed further.
    pub fn along(&mut self, accel: &Accel, media: &Media, ray: &LocalRay, to: f64) -> &[f64] {
        let mut least_depth = 0.0;
        accel.all_until(ray, 0.0, to, |body, crossing| {
            let added = self.add(body, crossing, to);
            let (disc, fog) = media.least_depth(body.bin());
            least_depth += added * if body.is_disc() { disc } else { fog };
            if least_depth > OPAQUE { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        self.finish(media)
    }

    /// Optical depth by wavelength from distance 0 up to `to`, past bodies that were found before. What is met exactly
    /// at `to` does not count.
    pub fn past(&mut self, media: &Media, crossings: &[(Body, Crossing)], to: f64) -> &[f64] {
        for (body, crossing) in crossings.iter().filter(|(_, crossing)| crossing.start() < to) {
            self.add(body, *crossing, to);
        }
        self.finish(media)
    }

    /// Adds a body to its bin's column and returns how much.
    #[inline]
    fn add(&mut self, body: &Body, crossing: Crossing, to: f64) -> f64 {
        let load = f64::from(body.load);
        let column = &mut self.columns[body.bin()];
        if *column == Column::default() {
            self.touched.push(body.bin() as u32);
        }
        match body.kind() {
            BodyKind::Droplet | BodyKind::Glass => {
                column.discs += load;
                load
            }
            BodyKind::Ball | BodyKind::Box => {
                let fog_per_m2 = load * (crossing.end().min(to) - crossing.start().max(0.0));
                column.fog_per_m2 += fog_per_m2;
                fog_per_m2
            }
        }
    }

    /// Turns columns into depths and empties them.
    fn finish(&mut self, media: &Media) -> &[f64] {
        self.depth.fill(0.0);
        for bin in self.touched.drain(..) {
            let column = std::mem::take(&mut self.columns[bin as usize]);
            if column.fog_per_m2 > 0.0 {
                for (depth, c_ext_m2) in self.depth.iter_mut().zip(media.c_ext_m2(bin as usize)) {
                    *depth += column.fog_per_m2 * c_ext_m2;
                }
            }
            if column.discs > 0.0 {
                for (depth, disc) in self.depth.iter_mut().zip(media.disc_depth(bin as usize)) {
                    *depth += column.discs * disc;
                }
            }
        }
        &self.depth
    }
}
