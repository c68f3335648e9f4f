//! The sum over sources one by one, in f64 and with the phase functions themselves: the reference, and what few sources need.

use glam::DVec3;

use super::Glow;
use super::extended::{Seen, draw};
use crate::accel::{Accel, Body, BodyKind};
use crate::transport::lighting::Lighting;
use crate::transport::media::Media;

/// What surrounds a point that looks.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub accel: &'a Accel,
    pub media: &'a Media,
    pub lighting: &'a Lighting,
    /// The camera, in the cloud's frame.
    pub camera: DVec3,
}

/// A point of the air and the direction of the camera ray that crosses it, in the cloud's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub at: DVec3,
    pub view: DVec3,
    /// Directions of the first suns' light, from a point on each one's disc.
    pub suns: [DVec3; DRAWN_SUNS],
}

/// Suns whose discs are sampled at every point; of more, the rest shine from their middles.
pub(super) const DRAWN_SUNS: usize = 4;

impl Point {
    /// A point with the suns' light from points of their discs, drawn by two numbers each.
    pub fn new(lighting: &Lighting, at: DVec3, view: DVec3, draw: impl Fn(u32) -> f64) -> Self {
        let mut suns = [DVec3::ZERO; DRAWN_SUNS];
        for (i, (to, sun)) in (0..).zip(suns.iter_mut().zip(&lighting.suns)) {
            *to = if sun.is_point() { sun.direction } else { -sun.toward([draw(2 * i), draw(2 * i + 1)]) };
        }
        Self { at, view, suns }
    }

    /// Direction of a sun's light.
    pub fn sun(&self, index: usize, lighting: &Lighting) -> DVec3 {
        self.suns.get(index).copied().unwrap_or(lighting.suns[index].direction)
    }
}

impl Around<'_> {
    /// The air's transmittance from a point in it towards another.
    pub fn air_between(&self, x: DVec3, y: DVec3) -> f64 {
        let way = y - x;
        let d = way.length();
        let from_camera = x - self.camera;
        let b = from_camera.dot(way / d);
        let depth_m = self.lighting.air.depth_m;
        let end = (b * b - from_camera.length_squared() + depth_m * depth_m).max(0.0).sqrt() - b;
        self.lighting.air.transmittance(d.min(end).max(0.0))
    }

    /// Fills `out` with what a unit of scattering cross section times transmittance at `y` sends through the air at a
    /// point, without 1/d^2: sum over suns of p_air E T_sun p T, by wavelength. `lit` has T_sun by sun and wavelength.
    pub fn kernel(&self, point: Point, y: DVec3, body: &Body, lit: &[f32], out: &mut [f64]) {
        out.fill(0.0);
        let e = (point.at - y).normalize();
        let air = &self.lighting.air;
        let h_air = 0.5 * (e + point.view).length_squared();
        let passed = self.air_between(point.at, y);
        let phases = self.media.phase(body.bin());
        for (s, (sun, lit)) in self.lighting.suns.iter().zip(lit.chunks_exact(out.len())).enumerate() {
            let h = 0.5 * (e - point.sun(s, self.lighting)).length_squared();
            for (w, out) in out.iter_mut().enumerate() {
                *out += sun.irradiance[w] * f64::from(lit[w]) * phases[w].eval(h);
            }
        }
        for (w, out) in out.iter_mut().enumerate() {
            *out *= passed * air.phase[w].eval(h_air);
        }
    }
}

impl Glow {
    /// Fills `out` with J of one source; `nearest_m` is the distance within which droplets are left out, `u` draws a point of
    /// fog. `lit` replaces the sun's share that was prepared. Returns the point that stands for the source.
    #[allow(clippy::too_many_arguments)] // one term of the sum, with everything in it
    pub(super) fn source_light(
        &self,
        around: &Around,
        point: Point,
        slot: usize,
        nearest_m: f64,
        seen: Option<Seen>,
        lit: Option<&[f32]>,
        out: &mut [f64],
    ) -> Option<DVec3> {
        let body = around.accel.body(self.slots[slot].body);
        let (y, spread_per_m) = match (body.kind(), seen) {
            (BodyKind::Droplet | BodyKind::Glass, _) => {
                let d2 = (point.at - body.center).length_squared();
                let nearest_m = nearest_m.max(super::drawn_radius_m(around.media, body));
                if d2 < nearest_m * nearest_m || d2 == 0.0 {
                    return None;
                }
                (body.center, f64::from(self.slots[slot].amount) / d2)
            }
            (_, seen) => {
                let seen = seen?;
                (seen.point, f64::from(body.load) * seen.spread_m)
            }
        };
        around.kernel(point, y, body, lit.unwrap_or(self.sun_share.of(slot)), out);
        for (out, row) in out.iter_mut().zip(self.rows.of(body)) {
            *out *= spread_per_m * row;
        }
        Some(y)
    }

    /// Draws a point of a source of fog as seen from another; `None` for droplets, and where nothing is seen.
    pub(super) fn draw_point(&self, around: &Around, point: Point, slot: usize, u: [f64; 3]) -> Option<Seen> {
        let body = around.accel.body(self.slots[slot].body);
        (!body.is_disc()).then(|| draw(around.accel, body, point.at, u)).flatten()
    }
}
