//! The sum at single points of the air, by the cut and one by one: for tests and measurements.

use glam::DVec3;

use super::Glow;
use super::cut::Cut;
use super::exact::{Around, Point};
use super::eye::Bands;
use crate::transport::random::hash_uniform;
use crate::transport::sample::RenderContext;

/// Sums up what glows at points of the air, without what is in the way and without what the air scatters.
pub struct GlowProbe<'a> {
    glow: &'a Glow,
    around: Around<'a>,
    cut: Cut,
    row: Vec<f64>,
}

impl<'a> GlowProbe<'a> {
    /// A probe of what a picture's samples read; `None` where nothing glows.
    pub fn new(ctx: &RenderContext<'a>) -> Option<Self> {
        let row = vec![0.0; ctx.media.n_wavelengths()];
        Some(Self { glow: ctx.glow?, around: Around::of(ctx), cut: Cut::default(), row })
    }

    /// J by wavelength, sr^-1 times irradiance per unit of length and the air's scattering coefficient, at a point in world
    /// space seen along the unit vector `view`, to the given relative error; and how many nodes and sources that took.
    pub fn by_cut(&mut self, point_m: DVec3, view: DVec3, tolerance: f64) -> (Vec<f64>, u64) {
        let point = self.point(point_m, view);
        let Self { glow, around, cut, row, .. } = self;
        let mut eye = glow.eye(around, point, Bands::ALL);
        eye.near = 0.0;
        cut.evaluations = 0;
        row.fill(0.0);
        glow.arch.dispatch(
            #[inline(always)]
            || {
                if glow.n_in_tree > 0 {
                    cut.refine(glow, &eye, tolerance as f32);
                    glow.sum_items(around, &eye, cut, f32::INFINITY, row);
                }
            },
        );
        let mut sum = row.clone();
        self.add_exact(self.glow.n_in_tree..self.glow.slots.len(), point, &mut sum);
        (sum, self.cut.evaluations + (self.glow.slots.len() - self.glow.n_in_tree) as u64)
    }

    /// The same by a sum over all sources, in f64 and with the phase functions themselves.
    pub fn exact(&mut self, point_m: DVec3, view: DVec3) -> Vec<f64> {
        let point = self.point(point_m, view);
        let mut sum = vec![0.0; self.row.len()];
        self.add_exact(0..self.glow.slots.len(), point, &mut sum);
        sum
    }

    /// The same over all sources, by the code that looks at the tree's leaves: what an exact sum costs at best.
    pub fn all_leaves(&mut self, point_m: DVec3, view: DVec3) -> Vec<f64> {
        let point = self.point(point_m, view);
        let Self { glow, around, cut, row, .. } = self;
        let mut eye = glow.eye(around, point, Bands::ALL);
        eye.near = 0.0;
        row.fill(0.0);
        glow.arch.dispatch(
            #[inline(always)]
            || {
                cut.take_leaves(glow, &eye, |cut| glow.sum_items(around, &eye, cut, f32::INFINITY, row));
            },
        );
        row.clone()
    }

    fn point(&self, point_m: DVec3, view: DVec3) -> Point {
        Point::new(self.around.lighting, self.around.accel.local_ray(point_m, view).origin, view, |_| 0.0)
    }

    fn add_exact(&mut self, slots: std::ops::Range<usize>, point: Point, sum: &mut [f64]) {
        let Self { glow, around, row, .. } = self;
        for slot in slots {
            let u = [0, 1, 2].map(|axis| hash_uniform(slot as u64, axis));
            let seen = glow.draw_point(around, point, slot, u);
            if glow.source_light(around, point, slot, 0.0, seen, None, row).is_some() {
                sum.iter_mut().zip(&*row).for_each(|(sum, row)| *sum += row);
            }
        }
    }
}
