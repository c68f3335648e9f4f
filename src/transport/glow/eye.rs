//! The point of the air that looks at the glow, and how far it looks: light from afar is looked for by few steps of a march.

use super::Glow;
use super::exact::DRAWN_SUNS;

/// A point that looks, in the tree's units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    pub x: [f32; 3],
    /// Direction of the camera ray.
    pub view: [f32; 3],
    /// From the middle of the ball of air to the point.
    pub in_air: [f32; 3],
    /// |in_air|^2 minus the ball's radius squared.
    pub depth_in_air: f32,
    /// Droplets nearer than this are left out.
    pub near: f32,
    pub bands: Bands,
    /// Directions of the first suns' light.
    pub suns: [[f32; 3]; DRAWN_SUNS],
}

impl Eye {
    /// Direction of a sun's light.
    #[inline(always)]
    pub fn sun(&self, glow: &Glow, index: usize) -> [f32; 3] {
        if index < DRAWN_SUNS { self.suns[index] } else { glow.suns[index].direction }
    }
}

/// How far a step of the march looks: light from afar varies slowly, so that few steps look for it and count it several
/// times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bands {
    /// One over the distance at which the second band begins.
    pub per_unit: f32,
    /// The last band that this step looks at.
    pub last: i32,
    /// The last band that there is.
    pub most: i32,
}

impl Bands {
    /// Everything, once.
    pub const ALL: Self = Self { per_unit: 0.0, last: 0, most: 0 };

    /// The band of a distance: its power of two.
    #[inline(always)]
    pub fn of(self, d: f32) -> i32 {
        (((d * self.per_unit).max(1.0).to_bits() >> 23) as i32 - 127).min(self.most)
    }

    /// How often light from a distance counts: not at all, or for all steps that do not look.
    #[inline(always)]
    pub fn weight(self, d: f32) -> f32 {
        let band = self.of(d);
        if band > self.last { 0.0 } else { f32::from_bits(((127 + band) as u32) << 23) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over all steps of a march, light from any distance counts as often as there are steps.
    #[test]
    fn bands_count_every_distance_once_per_step() {
        for distance in [0.0, 0.5, 1.0, 3.0, 100.0, 1e9] {
            let weight = |step: u32| {
                let last = step.trailing_zeros().min(3) as i32;
                Bands { per_unit: 1.0, last, most: 3 }.weight(distance)
            };
            let total: f32 = (0..64).map(weight).sum();
            assert_eq!(total, 64.0, "{distance}");
        }
    }
}
