//! The field of a grown cloud: depth below its surface and water, from billows and noise.
//!
//! Lengths are in units of the longest half side while the cloud grows; then the box around it is stretched to the sizes
//! asked for, which changes it little. Noise carves and swells what the billows leave too smooth (Gardner 1985; Ebert et
//! al. 2003, section 9).

use glam::DVec3;
use rand::Rng;

use super::billows::{self, Billow};
use super::noise::fractal_noise;
use super::random::{Purpose, stream};
use super::shape::CloudShape;

/// Billows in the box around them, and the seed of the noise that roughens them.
pub(super) struct Grown {
    kind: Kind,
    billows: Vec<Billow>,
    low: DVec3,
    high: DVec3,
    metres_per_unit: f64,
    noise_seed: u64,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Cumulus,
    Puff,
}

/// Noise moves the surface of a cumulus by at most this, in waves this many to a unit.
const CUMULUS_ROUGHNESS: f64 = 0.035;
const CUMULUS_WAVES: f64 = 9.0;

/// A cumulus mixes with dry air in a skin this thick.
const CUMULUS_SKIN: f64 = 0.025;

/// The same of a puff, which is all skin: steam thins out as it mixes.
const PUFF_ROUGHNESS: f64 = 0.16;
const PUFF_WAVES: f64 = 3.0;
const PUFF_SKIN: f64 = 0.22;

/// Noise shifts the places where a puff looks up its noise: eddies.
const PUFF_SWIRL: f64 = 0.25;

/// Logarithm of the contrast between thick and thin places inside a puff.
const PUFF_CONTRAST: f64 = 1.6;

/// Where there is less water than this, relative to the wettest place, is outside.
const FAINTEST: f64 = 1e-3;

impl Grown {
    /// Grows the cloud of a shape and a seed.
    pub fn new(shape: &CloudShape, seed: u64) -> Self {
        let mut rng = stream(seed, Purpose::Billows);
        let half = DVec3::from(shape.size_m()) / shape.longest_m();
        let (kind, billows) = match shape {
            CloudShape::Cumulus { .. } => (Kind::Cumulus, billows::cumulus(half, &mut rng)),
            _ => (Kind::Puff, billows::puff(half, &mut rng)),
        };
        let [mut low, high] = billows::bounds(&billows);
        if kind == Kind::Cumulus {
            low.y = -half.y;
        }
        let stretch = 2.0 * half / (high - low);
        let metres_per_unit = 0.5 * shape.longest_m() * (stretch.x * stretch.y * stretch.z).cbrt();
        Self { kind, billows, low, high, metres_per_unit, noise_seed: rng.next_u64() }
    }

    /// Metres to which a unit is stretched, on average over the axes.
    pub fn metres_per_unit(&self) -> f64 {
        self.metres_per_unit
    }

    /// A point given in half sizes of the box.
    pub fn place(&self, point: [f64; 3]) -> DVec3 {
        self.low + (self.high - self.low) * (0.5 * (DVec3::from(point) + 1.0))
    }

    /// All billows.
    pub fn billows(&self) -> &[Billow] {
        &self.billows
    }

    /// Those of `billows` that come near the plane at `value` on an axis.
    pub fn near(&self, billows: &[Billow], axis: usize, value: f64) -> Vec<Billow> {
        let reach = match self.kind {
            Kind::Cumulus => CUMULUS_ROUGHNESS,
            Kind::Puff => PUFF_ROUGHNESS,
        };
        let is_near = |billow: &&Billow| (billow.center[axis] - value).abs() < billow.radius + reach;
        billows.iter().filter(is_near).copied().collect()
    }

    /// Depth below the surface, and water relative to its largest value; `None` outside. `billows` are all that come near.
    pub fn look(&self, billows: &[Billow], place: DVec3) -> Option<(f64, f64)> {
        let depth = billows.iter().map(|billow| billow.depth(place)).fold(f64::NEG_INFINITY, f64::max);
        let (depth, water) = match self.kind {
            Kind::Cumulus => self.cumulus(depth, place)?,
            Kind::Puff => self.puff(depth, place)?,
        };
        (depth > 0.0 && water > FAINTEST).then_some((depth, water))
    }

    /// Rounded swellings with creases between them; adiabatic water, which grows evenly with the height above the base
    /// (Albrecht, Fairall, Thomson & White 1990), less what the skin mixes away.
    fn cumulus(&self, depth: f64, place: DVec3) -> Option<(f64, f64)> {
        if depth < -CUMULUS_ROUGHNESS {
            return None;
        }
        let height = place.y - self.low.y;
        let swelling = if depth < CUMULUS_ROUGHNESS + CUMULUS_SKIN {
            (2.0 * self.noise(place * CUMULUS_WAVES, 3).abs() - 0.5).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let depth = (depth + CUMULUS_ROUGHNESS * swelling).min(height);
        let water = height / (self.high.y - self.low.y) * smooth_step(depth / CUMULUS_SKIN);
        Some((depth, water))
    }

    fn puff(&self, depth: f64, place: DVec3) -> Option<(f64, f64)> {
        if depth < -PUFF_ROUGHNESS {
            return None;
        }
        let swirl = DVec3::new(
            self.noise(place * PUFF_WAVES + 31.7, 2),
            self.noise(place * PUFF_WAVES + 67.3, 2),
            self.noise(place * PUFF_WAVES + 93.1, 2),
        );
        let noise = self.noise((place + PUFF_SWIRL * swirl) * PUFF_WAVES, 5);
        let depth = depth + PUFF_ROUGHNESS * (1.6 * noise - 0.2).clamp(-1.0, 1.0);
        let water = smooth_step(depth / PUFF_SKIN) * (PUFF_CONTRAST * (noise - 0.5)).exp();
        Some((depth, water))
    }

    fn noise(&self, place: DVec3, n_octaves: i32) -> f64 {
        fractal_noise(place.to_array(), self.noise_seed, n_octaves)
    }
}

/// From 0 at 0 to 1 at 1, without corners.
fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
