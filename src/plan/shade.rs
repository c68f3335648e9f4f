//! How much of the air along the rays of a coarse picture is seen, and how much of that droplets shade: a march of a few steps, theory (133).

use glam::DVec3;

use super::view::{Depths, Grid};
use crate::scene::settings::Atmosphere;

/// Steps of the march.
const STEPS: usize = 16;

/// What has this many standard deviations of its distance before it is taken to lie behind all of it: an even layer's edge.
const EDGE: f64 = 1.7;

/// Of the light that air scatters to the camera along one ray, were nothing in its way: shares that are left.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AirSeen {
    /// Not hidden behind droplets.
    pub seen: f64,
    /// Seen, but for the shade of droplets.
    pub shaded: f64,
}

/// Along the camera's rays; `seen` and `sunward` are what lies along those and along the sun's, whose disc has the radius `disc_rad`, `deepest` an optical depth that none
/// exceeds.
pub(super) fn air_seen(
    (camera, seen): (&Grid, &Depths),
    (sun, sunward, disc_rad): (&Grid, &Depths, f64),
    air: &Atmosphere,
    deepest: f64,
) -> Vec<AirSeen> {
    let extinction_per_m = air.scattering_per_m + air.absorption_per_m;
    if air.scattering_per_m <= 0.0 {
        return vec![AirSeen::default(); seen.tau.len()];
    }
    let sheet = if sunward.misses_a_box { -(-deepest).exp_m1() } else { 0.0 };
    let all = -(-extinction_per_m * air.depth_m).exp_m1();
    let shade = |point: DVec3| shade_at(sun, sunward, disc_rad, point).max(sheet);
    let of_ray = |(cell, (origin_m, direction)): (usize, (DVec3, DVec3))| {
        let (middle_m, variance_m2) = seen.place(cell);
        let (hidden_from_m, passed) = (middle_m - EDGE * variance_m2.sqrt(), (-seen.tau[cell]).exp());
        let mut sum = AirSeen::default();
        for step in 0..STEPS {
            // The middle of each part of the air that scatters as much as the others.
            let u = (step as f64 + 0.5) / STEPS as f64;
            let t_m = -(-u * all).ln_1p() / extinction_per_m;
            let weight = if t_m > hidden_from_m { passed } else { 1.0 } / STEPS as f64;
            sum.seen += weight;
            sum.shaded += weight * shade(origin_m + t_m * direction);
        }
        sum
    };
    camera.rays().enumerate().map(of_ray).collect()
}

/// Share of the sunlight that droplets before a point take, at most: within a cell of it and the sun's disc, of radius `disc_rad`.
fn shade_at(sun: &Grid, sunward: &Depths, disc_rad: f64, point: DVec3) -> f64 {
    let t_m = sun.along_m(point);
    let shade = |cell: usize| {
        let (middle_m, variance_m2) = sunward.place(cell);
        if t_m > middle_m - EDGE * variance_m2.sqrt() { -(-sunward.tau[cell]).exp_m1() } else { 0.0 }
    };
    sun.cells_about(point, disc_rad * t_m.max(0.0)).map(shade).fold(0.0, f64::max)
}
