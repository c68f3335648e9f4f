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
    /// The bin that was met last, and its column: neighbours often share one.
    bin: usize,
    column: Column,
    /// Columns of the bins that were met before.
    columns: Vec<Column>,
    /// Bins with something in `columns`.
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
            depth: vec![0.0; media.n_wavelengths()],
            ..Self::default()
        }
    }

    /// Optical depth by wavelength of the ray from distance 0 to `to`, m. Beyond `OPAQUE` at every wavelength it is not
    /// summed further.
    pub fn along(&mut self, accel: &Accel, media: &Media, ray: &LocalRay, to: f64) -> &[f64] {
        if let Some(body) = accel.only_fog() {
            let way_m = accel.chord(ray, body).map_or(0.0, |(start, end)| (end.min(to) - start.max(0.0)).max(0.0));
            let fog_per_m2 = f64::from(body.load) * way_m;
            for (depth, c_ext_m2) in self.depth.iter_mut().zip(media.c_ext_m2(body.bin())) {
                *depth = fog_per_m2 * c_ext_m2;
            }
            return &self.depth;
        }
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
        self.past_discs(media, crossings, to, 0)
    }

    /// The same up to the disc of the given number at `to`: of discs that are met at one distance the lower numbers are first.
    pub fn past_discs(&mut self, media: &Media, crossings: &[(Body, Crossing)], to: f64, id: u32) -> &[f64] {
        let is_before = |body: &Body, start: f64| start < to || start == to && body.id < id && body.is_disc();
        for (body, crossing) in crossings.iter().filter(|(body, crossing)| is_before(body, crossing.start())) {
            self.add(body, *crossing, to);
        }
        self.finish(media)
    }

    /// Adds a body to its bin's column and returns how much.
    #[inline]
    fn add(&mut self, body: &Body, crossing: Crossing, to: f64) -> f64 {
        if body.bin() != self.bin {
            self.put_column_away();
            self.bin = body.bin();
        }
        let load = f64::from(body.load);
        match body.kind() {
            BodyKind::Droplet | BodyKind::Glass => {
                self.column.discs += load;
                load
            }
            BodyKind::Ball | BodyKind::Box => {
                let fog_per_m2 = load * (crossing.end().min(to) - crossing.start().max(0.0));
                self.column.fog_per_m2 += fog_per_m2;
                fog_per_m2
            }
        }
    }

    /// Adds the last bin's column to what was met of that bin before.
    fn put_column_away(&mut self) {
        let column = std::mem::take(&mut self.column);
        if column == Column::default() {
            return;
        }
        let sum = &mut self.columns[self.bin];
        if *sum == Column::default() {
            self.touched.push(self.bin as u32);
        }
        sum.fog_per_m2 += column.fog_per_m2;
        sum.discs += column.discs;
    }

    /// Turns columns into depths and empties them.
    fn finish(&mut self, media: &Media) -> &[f64] {
        if self.touched.is_empty() && self.column == Column::default() {
            // Nothing was met; there may be no size bins at all.
            self.depth.fill(0.0);
            return &self.depth;
        }
        if self.touched.is_empty() {
            let column = std::mem::take(&mut self.column);
            let row = media.c_ext_m2(self.bin).iter().zip(media.disc_depth(self.bin));
            for (depth, (c_ext_m2, disc)) in self.depth.iter_mut().zip(row) {
                *depth = column.depth(*c_ext_m2, *disc);
            }
            return &self.depth;
        }
        self.put_column_away();
        self.depth.fill(0.0);
        for bin in self.touched.drain(..) {
            let column = std::mem::take(&mut self.columns[bin as usize]);
            let row = media.c_ext_m2(bin as usize).iter().zip(media.disc_depth(bin as usize));
            for (depth, (c_ext_m2, disc)) in self.depth.iter_mut().zip(row) {
                *depth += column.depth(*c_ext_m2, *disc);
            }
        }
        &self.depth
    }
}

impl Column {
    /// Optical depth of the column. A disc's can be infinite, and no discs are none of it.
    #[inline]
    fn depth(self, c_ext_m2: f64, disc: f64) -> f64 {
        let fog = self.fog_per_m2 * c_ext_m2;
        if self.discs > 0.0 { fog + self.discs * disc } else { fog }
    }
}
