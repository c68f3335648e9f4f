//! Where the light comes from that droplets send into the air: what the sun's rays lose to them, ray by ray, theory (135).

use std::f64::consts::PI;

use glam::DVec3;

use super::view::{Depths, Grid};
use crate::scene::settings::Atmosphere;

/// Rays of the sun's grid along a side that one source stands for.
const BLOCK: usize = 4;

/// One for a block of the sun's rays.
struct Source {
    center_m: DVec3,
    /// Area of sunlight that it scatters, m^2.
    area_m2: f64,
    /// How far it extends, m, RMS.
    spread_m: f64,
}

/// All of them.
pub(super) struct Sources {
    all: Vec<Source>,
    /// Share of what they scatter by small angles that leaves them: the rest lies deep in what is opaque.
    pub beam_passed: f64,
}

impl Sources {
    /// Of what lies along the sun's rays.
    pub fn of(sun: &Grid, depths: &Depths) -> Self {
        let ([columns, _], cell_m2) = (sun.size(), sun.cell_m2());
        let rays: Vec<(DVec3, DVec3)> = sun.rays().collect();
        let areas_m2: Vec<f64> = depths.scattered().map(|share| cell_m2 * share).collect();
        let mut blocks = vec![Vec::new(); columns.div_ceil(BLOCK) * rays.len().div_ceil(columns * BLOCK)];
        for cell in (0..rays.len()).filter(|cell| areas_m2[*cell] > 0.0) {
            let (row, column) = (cell / columns, cell % columns);
            blocks[row / BLOCK * columns.div_ceil(BLOCK) + column / BLOCK].push(cell);
        }
        let all = blocks.iter().filter(|cells| !cells.is_empty()).map(|cells| {
            let area_m2: f64 = cells.iter().map(|cell| areas_m2[*cell]).sum();
            let mean = |value: &dyn Fn(usize) -> DVec3| {
                cells.iter().map(|cell| areas_m2[*cell] * value(*cell)).sum::<DVec3>() / area_m2
            };
            let at = |cell: usize| rays[cell].0 + depths.scattering_place(cell).0 * rays[cell].1;
            let center_m = mean(&at);
            let variance_m2 = mean(&|cell| {
                DVec3::splat((at(cell) - center_m).length_squared() + depths.scattering_place(cell).1 + cell_m2 / 6.0)
            });
            Source { center_m, area_m2, spread_m: variance_m2.x.sqrt() }
        });
        // Light that goes straight on leaves optical depth tau with t exp(-tau) of it at each t.
        let passed = |tau: f64| if tau > 1e-6 { tau / tau.exp_m1() } else { 1.0 };
        let beam: f64 = areas_m2.iter().zip(&depths.tau).map(|(area_m2, tau)| area_m2 * passed(*tau)).sum();
        let total_m2: f64 = areas_m2.iter().sum();
        Self { all: all.collect(), beam_passed: if total_m2 > 0.0 { beam / total_m2 } else { 0.0 } }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Light that they send to a ray, in units of E / 4 pi: sum of A / 4 pi times the integral of 1 / (d^2 + s^2) along it, m.
    pub fn light(&self, (origin_m, direction): (DVec3, DVec3), air: &Atmosphere) -> f64 {
        let (way_m, extinction_per_m) = (air.depth_m, air.scattering_per_m + air.absorption_per_m);
        let from = |source: &Source| {
            let to_source = source.center_m - origin_m;
            let foot = to_source.dot(direction);
            let nearest_m = (to_source.length_squared() - foot * foot).max(0.0).sqrt();
            let b = nearest_m.hypot(source.spread_m).max(f64::MIN_POSITIVE);
            // No way from the source by the ray to the camera is shorter than that straight to it, of which no more lies in the air than
            // its radius.
            let least_m = (to_source.length() - source.spread_m).clamp(0.0, way_m);
            let passed = (-extinction_per_m * least_m).exp();
            source.area_m2 * passed * (((way_m - foot) / b).atan() + (foot / b).atan()) / b
        };
        self.all.iter().map(from).sum::<f64>() / (4.0 * PI)
    }
}
