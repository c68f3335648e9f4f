//! What all sources are together: where they lie, how finely they scatter, and how much.

use glam::DVec3;

use super::blur::step_for;
use super::sources::{OpticalRows, Slot};
use crate::accel::Accel;
use crate::transport::lighting::Lighting;
use crate::transport::media::Media;

/// Middle of all centres, m, and half their extent (or the largest radius, where they are one point).
pub(super) fn extent(accel: &Accel) -> Option<(DVec3, f64)> {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = accel.bodies().iter().fold(none, |(a, b), body| (a.min(body.center), b.max(body.center)));
    if accel.is_empty() {
        return None;
    }
    let widest = |body| accel.half_edges(body).x_axis.length();
    let own_m = accel.bodies().iter().map(widest).fold(f64::MIN_POSITIVE, f64::max);
    let half_m = 0.5 * (high - low).max_element();
    Some((0.5 * (low + high), if half_m > 1e-3 * own_m { half_m } else { own_m }))
}

/// Finest step that any bin's phase function needs.
pub(super) fn media_step(media: &Media) -> f64 {
    let phases = (0..media.n_bins()).flat_map(|bin| media.phase(bin));
    phases.map(|phase| step_for(phase.max_value())).fold(f64::INFINITY, f64::min)
}

/// What every bin scatters in all, one row of wavelengths per bin.
pub(super) fn scattering_by_bin(accel: &Accel, media: &Media, rows: &OpticalRows, slots: &[Slot]) -> Vec<f64> {
    let n = media.n_wavelengths();
    let mut sums = vec![0.0; media.n_bins() * n];
    for slot in slots {
        let body = accel.body(slot.body);
        let sums = &mut sums[body.bin() * n..(body.bin() + 1) * n];
        sums.iter_mut().zip(rows.of(body)).for_each(|(sum, c)| *sum += f64::from(slot.amount) * c);
    }
    sums
}

/// What scatters with a row of cross sections, as decisions weigh wavelengths, were it in the light of all suns.
pub(super) fn full_light(row: &[f64], lighting: &Lighting) -> f64 {
    let of = |irradiance: &[f64]| -> f64 {
        let shares = &lighting.luminance_weights;
        row.iter().zip(irradiance).zip(shares).map(|((c, e), share)| c * e * share).sum()
    };
    lighting.suns.iter().map(|sun| of(&sun.irradiance)).sum()
}

/// What all sources scatter, weighed likewise.
pub(super) fn total_scattering(accel: &Accel, rows: &OpticalRows, lighting: &Lighting, slots: &[Slot]) -> f64 {
    slots.iter().map(|slot| full_light(rows.of(accel.body(slot.body)), lighting) * f64::from(slot.amount)).sum()
}
