//! What glows: every droplet, parcel and fog box with how much it scatters and how much sun reaches it.

use glam::DVec3;
use rayon::prelude::*;

use super::extended::point_within;
use crate::accel::{Accel, Body, BodyKind, LocalRay};
use crate::transport::lighting::Lighting;
use crate::transport::media::Media;
use crate::transport::random::hash_uniform;
use crate::transport::transmittance::OpticalDepth;

/// Sources of one leaf of the tree, and those that share a row of sunlight where there are many.
pub(super) const LEAF: usize = 8;

/// Numbers of sunlight that are kept source by source; beyond, one source of each leaf speaks for all of it.
const MOST_LIT: usize = 1 << 24;

/// Points of a body of fog at which the sun is looked for.
const FOG_POINTS: u32 = 4;

/// Points of a sun's disc to which single droplets look, where they are few enough for each to matter.
const DISC_POINTS: u32 = 16;
const FEW_LIT: usize = 4096;

/// One source.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    /// Place of the body in the tree of particles.
    pub body: u32,
    /// What its optical row is multiplied with: a droplet's disc area or a fog's number of droplets.
    pub amount: f32,
}

/// Light scattered per unit of `amount`: one row of wavelengths per size bin and kind.
pub(super) struct OpticalRows {
    n_wavelengths: usize,
    values: Vec<f64>,
}

impl OpticalRows {
    pub fn new(media: &Media) -> Self {
        let n = media.n_wavelengths();
        let mut values = Vec::with_capacity(2 * n * media.n_bins());
        for bin in 0..media.n_bins() {
            let albedo = media.albedo(bin);
            values.extend(media.disc_depth(bin).iter().zip(albedo).map(|(depth, albedo)| -(-depth).exp_m1() * albedo));
            values.extend(media.c_ext_m2(bin).iter().zip(albedo).map(|(c_ext_m2, albedo)| c_ext_m2 * albedo));
        }
        Self { n_wavelengths: n, values }
    }

    /// Scattering cross section per unit of amount, m^2, by wavelength.
    #[inline]
    pub fn of(&self, body: &Body) -> &[f64] {
        let row = 2 * body.bin() + usize::from(!body.is_disc());
        &self.values[row * self.n_wavelengths..(row + 1) * self.n_wavelengths]
    }
}

/// Amount of a body. N coincident droplets act together with 1 - (1-p)^N, p averaged over the wavelengths.
pub(super) fn amount_of(accel: &Accel, media: &Media, body: &Body) -> f64 {
    let (radius_m, load) = (f64::from(body.radius_m), f64::from(body.load));
    match body.kind() {
        BodyKind::Droplet | BodyKind::Glass => {
            let disc_m2 = std::f64::consts::PI * radius_m * radius_m;
            let acting = |n: f64| media.disc_depth(body.bin()).iter().map(|depth| -(-n * depth).exp_m1()).sum::<f64>();
            if load == 1.0 { disc_m2 } else { disc_m2 * acting(load) / acting(1.0) }
        }
        BodyKind::Ball => load * 4.0 / 3.0 * std::f64::consts::PI * radius_m.powi(3),
        BodyKind::Box => load * 8.0 * accel.half_edges(body).determinant().abs(),
    }
}

/// The radius within which a droplet does not light the air, m: what it is drawn with, which is no air. None for fog.
pub(super) fn drawn_radius_m(media: &Media, body: &Body) -> f64 {
    match body.kind() {
        BodyKind::Droplet | BodyKind::Glass => f64::from(body.radius_m) / media.disc_scale(body.bin()),
        BodyKind::Ball | BodyKind::Box => 0.0,
    }
}

/// Variance per axis of where a body's droplets are, m^2.
pub(super) fn own_variance_m2(accel: &Accel, body: &Body) -> f64 {
    match body.kind() {
        BodyKind::Droplet | BodyKind::Glass => 0.0,
        BodyKind::Ball => f64::from(body.radius_m).powi(2) / 5.0,
        BodyKind::Box => {
            let edges = accel.half_edges(body);
            (edges.x_axis.length_squared() + edges.y_axis.length_squared() + edges.z_axis.length_squared()) / 9.0
        }
    }
}

/// Transmittance toward every sun by wavelength, for every source or every leaf of them.
pub(super) struct SunShare {
    /// Sources per row; 0 where all are in full light.
    sources_per_row: usize,
    n_lights: usize,
    values: Vec<f32>,
}

impl SunShare {
    /// Looks toward the suns from the sources, in the tree's order; from none if `shadows` are off.
    pub fn new(accel: &Accel, media: &Media, lighting: &Lighting, slots: &[Slot], shadows: bool) -> Self {
        let n_lights = lighting.suns.len() * media.n_wavelengths();
        if !shadows {
            return Self { sources_per_row: 0, n_lights, values: vec![1.0; n_lights] };
        }
        let sources_per_row = if slots.len() * n_lights <= MOST_LIT { 1 } else { LEAF };
        let all_points = lighting.suns.iter().all(|sun| sun.is_point());
        let disc_points = if all_points || slots.len() > FEW_LIT { 1 } else { DISC_POINTS };
        let mut values = vec![0.0; slots.len().div_ceil(sources_per_row) * n_lights];
        values.par_chunks_mut(n_lights).enumerate().for_each_init(
            || OpticalDepth::new(media),
            |depth, (row, lit)| {
                let first = row * sources_per_row;
                let group = &slots[first..slots.len().min(first + sources_per_row)];
                // Any of the leaf, so that none is preferred.
                let chosen = (hash_uniform(row as u64, 0) * group.len() as f64) as usize;
                look_at_suns(accel, media, lighting, &group[chosen.min(group.len() - 1)], disc_points, depth, lit);
            },
        );
        Self { sources_per_row, n_lights, values }
    }

    /// Transmittance toward the suns, one row of wavelengths after the other.
    #[inline]
    pub fn of(&self, slot: usize) -> &[f32] {
        let row = slot.checked_div(self.sources_per_row).unwrap_or(0);
        &self.values[row * self.n_lights..(row + 1) * self.n_lights]
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }
}

fn look_at_suns(
    accel: &Accel,
    media: &Media,
    lighting: &Lighting,
    slot: &Slot,
    disc_points: u32,
    depth: &mut OpticalDepth,
    lit: &mut [f32],
) {
    let body = accel.body(slot.body);
    let is_disc = body.is_disc();
    let points = if is_disc { disc_points } else { FOG_POINTS };
    for i in 0..points {
        let u = [0, 1, 2].map(|axis| hash_uniform(u64::from(body.id), u64::from(1 + 3 * i + axis)));
        let origin: DVec3 = if is_disc { body.center } else { point_within(accel, body, u) };
        for (sun, lit) in lighting.suns.iter().zip(lit.chunks_exact_mut(media.n_wavelengths())) {
            let on_disc = [100 + 2 * i, 101 + 2 * i].map(|draw| hash_uniform(u64::from(body.id), u64::from(draw)));
            let ray = LocalRay { origin, direction: sun.toward(on_disc) };
            let depth = depth.along(accel, media, &ray, f64::INFINITY);
            lit.iter_mut().zip(depth).for_each(|(lit, depth)| *lit += (-depth).exp() as f32 / points as f32);
        }
    }
}
