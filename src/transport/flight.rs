//! Free flight: where a ray meets its next event, with the largest extinction over the wavelengths.

use super::media::Media;
use super::random::PathRandom;
use super::transmittance::miss_all;
use crate::accel::{Accel, Body, BodyKind, Crossing, Hit, LocalRay};

/// Where the search for the next event starts: after an event, or at the ray's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub t_m: f64,
    pub after_id: Option<u32>,
}

impl Start {
    pub const ORIGIN: Start = Start { t_m: 0.0, after_id: None };

    /// The search goes on beyond an event that did nothing.
    pub fn after(hit: &Hit) -> Self {
        Self { t_m: hit.t_m, after_id: Some(hit.id) }
    }
}

/// The next tentative event: the nearest over all bodies of independent draws, which is the event of their sum.
pub(super) fn next_event(
    accel: &Accel,
    media: &Media,
    ray: &LocalRay,
    start: Start,
    random: &PathRandom,
    segment: u32,
) -> Option<Hit> {
    accel.closest(ray, start.t_m, start.after_id, |body, crossing| {
        let u = random.body(segment, body.id);
        let load = f64::from(body.load);
        match crossing {
            Crossing::Point(t) => (u < 1.0 - miss_all(media.max_event_probability(body.bin()), load)).then_some(t),
            Crossing::Chord(t0, t1) => {
                let extinction_per_m = load * media.max_c_ext_m2(body.bin());
                let t = t0.max(start.t_m) - (-u).ln_1p() / extinction_per_m;
                (t < t1).then_some(t)
            }
        }
    })
}

/// Share of tentative events on a body that are real, by wavelength.
pub(super) fn real_share(media: &Media, body: &Body, share: &mut [f64]) {
    let bin = body.bin();
    if body.kind() == BodyKind::Droplet {
        let load = f64::from(body.load);
        let tentative = 1.0 - miss_all(media.max_event_probability(bin), load);
        for (share, p) in share.iter_mut().zip(media.event_probability(bin)) {
            *share = (1.0 - miss_all(*p, load)) / tentative;
        }
    } else {
        let tentative = media.max_c_ext_m2(bin);
        for (share, c_ext_m2) in share.iter_mut().zip(media.c_ext_m2(bin)) {
            *share = c_ext_m2 / tentative;
        }
    }
}
