//! How much light passes between two points: exact along the ray, for fog and for single droplets.

use super::media::Media;
use crate::accel::{Accel, Body, BodyKind, Crossing, LocalRay};

/// Transmittance by wavelength, gathered body by body.
#[derive(Clone, Debug, Default)]
pub(super) struct Transmittance {
    /// Optical depth of fog.
    depth: Vec<f64>,
    /// Product of what single droplets let through.
    discs: Vec<f64>,
    /// The result.
    value: Vec<f64>,
}

impl Transmittance {
    pub fn new(n_wavelengths: usize) -> Self {
        Self { depth: vec![0.0; n_wavelengths], discs: vec![1.0; n_wavelengths], value: vec![1.0; n_wavelengths] }
    }

    /// The transmittance of the ray from distance 0 to `to`, m.
    pub fn along(&mut self, accel: &Accel, media: &Media, ray: &LocalRay, to: f64) -> &[f64] {
        self.clear();
        accel.all(ray, 0.0, to, |body, crossing| self.add(media, body, crossing, to));
        self.finish()
    }

    /// The transmittance from distance 0 to `to` past bodies that were found before.
    pub fn past(&mut self, media: &Media, crossings: &[(Body, Crossing)], to: f64) -> &[f64] {
        self.clear();
        for (body, crossing) in crossings.iter().filter(|(_, crossing)| crossing.start() < to) {
            self.add(media, body, *crossing, to);
        }
        self.finish()
    }

    fn clear(&mut self) {
        self.depth.fill(0.0);
        self.discs.fill(1.0);
    }

    #[inline]
    fn add(&mut self, media: &Media, body: &Body, crossing: Crossing, to: f64) {
        let load = f64::from(body.load);
        if body.kind() == BodyKind::Droplet {
            for (passed, p) in self.discs.iter_mut().zip(media.event_probability(body.bin())) {
                *passed *= miss_all(*p, load);
            }
        } else {
            let droplets_per_m2 = load * (crossing.end().min(to) - crossing.start().max(0.0));
            for (depth, c_ext_m2) in self.depth.iter_mut().zip(media.c_ext_m2(body.bin())) {
                *depth += droplets_per_m2 * c_ext_m2;
            }
        }
    }

    fn finish(&mut self) -> &[f64] {
        for ((value, depth), discs) in self.value.iter_mut().zip(&self.depth).zip(&self.discs) {
            *value = discs * (-depth).exp();
        }
        &self.value
    }
}

/// Probability that none of `n` coincident droplets acts, each with probability `p`.
#[inline]
pub(super) fn miss_all(p: f64, n: f64) -> f64 {
    if n == 1.0 { 1.0 - p } else { (1.0 - p).powf(n) }
}
