//! The cloud averaged over a coarse grid, as isotropic scatterers that spread light alike.
//!
//! Legend: sigma', reduced extinction sigma_t - g sigma_s; sigma_s', reduced scattering (1 - g) sigma_s (van de Hulst 1980,
//! similarity): theory (122).

use std::f64::consts::PI;

use glam::{DVec3, UVec3};

use crate::accel::{Accel, Body, BodyKind};
use crate::transport::media::Media;

/// Cells along each axis. Light falls by e over some cells in anything that paths can cross.
pub(super) const N: usize = 24;

/// Places where all bodies together are felt for, at most.
const MOST_PLACES: f64 = 2e6;

/// Places per cell and axis.
const PLACES_PER_CELL: f64 = 2.0;

/// The averaged cloud.
#[derive(Debug)]
pub(super) struct Cells {
    min: DVec3,
    /// Edges of a cell, m.
    pub size_m: DVec3,
    per_m: DVec3,
    /// sigma' and sigma_s' by cell, 1/m; x runs fastest.
    pub reduced: Vec<[f64; 2]>,
}

impl Cells {
    /// Averages everything over the cells of a box; none where it has no volume.
    pub fn new(accel: &Accel, media: &Media, min: DVec3, max: DVec3) -> Option<Self> {
        let size_m = (max - min) / N as f64;
        if !(size_m.min_element() > 0.0 && size_m.is_finite()) {
            return None;
        }
        let mut cells = Self::of(min, size_m, vec![[0.0; 2]; N * N * N]);
        let areas: Vec<[f64; 2]> = (0..media.n_bins()).map(|bin| reduced_areas(media, bin)).collect();
        let most = (MOST_PLACES / accel.bodies().len() as f64).max(1.0).cbrt();
        for body in accel.bodies() {
            cells.add(accel, media, body, areas[body.bin()], most);
        }
        let volume_m3 = size_m.element_product();
        cells.reduced.iter_mut().flatten().for_each(|area| *area /= volume_m3);
        Some(cells)
    }

    /// Cells from a corner on.
    pub fn of(min: DVec3, size_m: DVec3, reduced: Vec<[f64; 2]>) -> Self {
        Self { min, size_m, per_m: size_m.recip(), reduced }
    }

    /// Adds the areas of one body, spread over the places of a lattice in it.
    fn add(&mut self, accel: &Accel, media: &Media, body: &Body, [extinction, scattering]: [f64; 2], most: f64) {
        let edges = accel.half_edges(body);
        let load = f64::from(body.load);
        let amount = match body.kind() {
            BodyKind::Glass => return,
            BodyKind::Droplet => {
                let radius_m = f64::from(body.radius_m);
                let depth = media.disc_depth(body.bin())[media.n_wavelengths() / 2];
                let c_ext_m2 = media.c_ext_m2(body.bin())[media.n_wavelengths() / 2];
                -PI * radius_m * radius_m * (-load * depth).exp_m1() / c_ext_m2
            }
            BodyKind::Ball => 4.0 / 3.0 * PI * f64::from(body.radius_m).powi(3) * load,
            BodyKind::Box => 8.0 * edges.determinant().abs() * load,
        };
        let places = match body.is_disc() {
            true => UVec3::ONE,
            false => {
                let along = [edges.x_axis, edges.y_axis, edges.z_axis].map(|edge| {
                    (2.0 * PLACES_PER_CELL * edge * self.per_m).abs().max_element().min(most).ceil() as u32
                });
                UVec3::from_array(along).max(UVec3::ONE)
            }
        };
        let is_round = body.kind() == BodyKind::Ball;
        let lattice = || {
            let at = |i: u32, n: u32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
            let rows = (0..places.z).flat_map(move |z| (0..places.y).map(move |y| (y, z)));
            rows.flat_map(move |(y, z)| (0..places.x).map(move |x| (x, y, z)))
                .map(move |(x, y, z)| DVec3::new(at(x, places.x), at(y, places.y), at(z, places.z)))
                .filter(move |place| !is_round || place.length_squared() <= 1.0)
        };
        // A lattice of two along each axis has no place inside the ball.
        let n = lattice().count();
        if n == 0 {
            self.put(body.center, amount, [extinction, scattering]);
            return;
        }
        for place in lattice() {
            self.put(body.center + edges * place, amount / n as f64, [extinction, scattering]);
        }
    }

    fn put(&mut self, point: DVec3, amount: f64, areas_m2: [f64; 2]) {
        let index = self.index_at(point);
        for (sum, area_m2) in self.reduced[index].iter_mut().zip(areas_m2) {
            *sum += amount * area_m2;
        }
    }

    /// The cell that holds a place, or is nearest to it.
    #[inline]
    pub fn index_at(&self, point: DVec3) -> usize {
        let at = ((point - self.min) * self.per_m).clamp(DVec3::ZERO, DVec3::splat(N as f64 - 0.5)).as_uvec3();
        (at.x as usize) + N * (at.y as usize + N * at.z as usize)
    }
}

/// Reduced extinction and scattering cross sections of a droplet, m^2, in the mean over the wavelengths.
pub(super) fn reduced_areas(media: &Media, bin: usize) -> [f64; 2] {
    let (areas_m2, albedos, phases) = (media.c_ext_m2(bin), media.albedo(bin), media.phase(bin));
    let mut sums = [0.0; 2];
    for ((area_m2, albedo), phase) in areas_m2.iter().zip(albedos).zip(phases) {
        let g = phase.mean_cosine();
        sums[0] += area_m2 * (1.0 - albedo * g);
        sums[1] += area_m2 * albedo * (1.0 - g);
    }
    sums.map(|sum| sum / areas_m2.len() as f64)
}
