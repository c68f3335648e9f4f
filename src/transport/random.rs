//! Random numbers of a path, stateless: neither threads nor the order of a traversal can change a picture.
//!
//! Every number is a function of (seed, pixel, sample) and of what it is drawn for. What decides most about a path, from
//! its place in the pixel to the first few collisions, are coordinates of a Sobol point (theory (90)), so that the samples of
//! a pixel spread evenly; everything else is a hash, the finaliser of SplitMix64 (Steele, Lea & Flood 2014, with the
//! constants of Stafford's variant 13).

use super::sobol::SobolPoint;
use crate::film::block_of;

/// The random numbers of one path.
#[derive(Clone, Debug)]
pub(super) struct PathRandom {
    key: u64,
    point: SobolPoint,
    /// Key of its block, its place there, and the block's length.
    block: (u64, u32, u32),
}

/// What a number is drawn for; numbers of different purposes never share a counter.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub(super) enum Purpose {
    PixelX = 1,
    PixelY,
    Hero,
    Collision,
    Roulette,
    Bin,
    Angle,
    Azimuth,
    March,
    AirChance,
    AirPlace,
    ChainSun,
    ChainChance,
    ChainLength,
    ChainAngle,
    ChainAzimuth,
    ChainCollision,
    /// Which way at a surface.
    Surface,
    /// Whether a camera ray goes on.
    Leg,
    /// Where a flight that a surface has turned ends.
    Flight,
    /// Where on a sun's disc: distance from its middle.
    SunHeight,
    /// Where on a sun's disc: direction from its middle.
    SunTurn,
    /// Free flight: plus the number of the collision, for every body.
    Body,
}

/// What a number is drawn for in glow.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub(super) enum GlowDraw {
    /// Which steps of the march look how far; one per path.
    Phase,
    /// Which part of the sum is shadowed; one per step.
    Pick,
    /// Which droplet of a cluster stands for it; one per step.
    Member,
    /// Where on the suns' discs; two per sun and step.
    Disc,
}

/// Glow draws from keys of its own.
const GLOW: u64 = 0xd6e8_feb8_6659_fd93;
const GLOW_BODY: u64 = 1 << 16;
const GLOW_NEAR: u64 = 1 << 30;

/// Branches draw from keys of their own.
const BRANCH: u64 = 0xa076_1d64_78bd_642f;

/// So do repeated asks, and whose turn it is.
const AGAIN: u64 = 0xe703_7ed1_a0b4_28db;
const TURN: u64 = 0x8ebc_6af0_9c88_c6e3;

/// 2^64 divided by the golden ratio, odd: the increment of SplitMix64.
pub(super) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

#[inline]
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Collisions whose numbers are coordinates of the Sobol point: more gain nothing in any scene that was measured.
const SOBOL_COLLISIONS: u32 = 4;

/// The coordinate of the Sobol point that a number is; `None` for those that are hashes.
///
/// Four at a time are computed together: those of the camera ray and its collision, then those of a turn and the next flight.
#[inline]
fn dimension(purpose: Purpose, index: u32) -> Option<u32> {
    if index > SOBOL_COLLISIONS + 1 {
        return None;
    }
    // Collision k + 1 is the flight after turn k; the first belongs to the camera ray.
    let (set, lane) = match (purpose, index) {
        (Purpose::PixelX, 0) => (0, 0),
        (Purpose::PixelY, 0) => (0, 1),
        (Purpose::Collision, 1..) => (index - 1, 2),
        (Purpose::Hero, 0) => (0, 3),
        (Purpose::Angle, 1..) => (index, 0),
        (Purpose::Azimuth, 1..) => (index, 1),
        (Purpose::ChainChance, 1..) => (index, 3),
        _ => return None,
    };
    (set <= SOBOL_COLLISIONS).then_some(4 * set + lane)
}

/// A number in [0, 1) from two counters, the same in every picture: for what is prepared before any path.
pub(super) fn hash_uniform(stream: u64, index: u64) -> f64 {
    unit(mix(mix(stream.wrapping_add(GOLDEN)) ^ index.wrapping_mul(GOLDEN)))
}

impl PathRandom {
    /// The numbers of one sample of one pixel.
    #[inline]
    pub fn new(seed: u64, pixel: u64, sample: u32) -> Self {
        let key = mix(seed.wrapping_add(GOLDEN));
        let key = mix(key ^ pixel.wrapping_mul(GOLDEN));
        let block = block_of(sample);
        let (block, length) = (block.start, block.len() as u32);
        // Numbers of samples are below 2^32, so blocks beyond have keys of their own.
        let block_key = mix(key ^ (1 << 32 | u64::from(block)).wrapping_mul(GOLDEN));
        Self {
            key: mix(key ^ u64::from(sample).wrapping_add(1).wrapping_mul(GOLDEN)),
            point: SobolPoint::new(block_key, sample - block),
            block: (block_key, sample - block, length),
        }
    }

    /// The numbers with which the same sample asks once more: as well stratified as the first, and independent of them.
    pub fn again(&self, time: u32) -> Self {
        let again = |key: u64| mix(key ^ AGAIN.wrapping_add(u64::from(time).wrapping_mul(GOLDEN)));
        Self { key: again(self.key), point: self.point.rescrambled(again(self.block.0)), ..*self }
    }

    /// Whether the sample is one of those that stand for `every` samples, a power of two: a run of neighbours in each block, which are
    /// stratified among themselves, or one sample in several short blocks. `stream` tells apart what takes turns.
    pub fn is_its_turn(&self, stream: u32, every: u32) -> bool {
        let (key, place, length) = self.block;
        let drawn = unit(mix(key ^ TURN.wrapping_add(u64::from(stream).wrapping_mul(GOLDEN))));
        place / (length / every).max(1) == (drawn * f64::from(every)) as u32
    }

    /// The numbers of one of the branches into which a path divides after a collision: the path's own go on with the first.
    pub fn branch(&self, collision: u32, copy: u32) -> Self {
        let key =
            mix(self.key ^ BRANCH.wrapping_add((u64::from(collision) << 32 | u64::from(copy)).wrapping_mul(GOLDEN)));
        Self { key, point: self.point.rescrambled(key), ..*self }
    }

    /// Which of `n` wavelengths leads the path; those of a block take them evenly in turn.
    pub fn hero(&self, n: usize) -> usize {
        ((self.uniform(Purpose::Hero, 0) * n as f64) as usize).min(n - 1)
    }

    /// A number in [0, 1) for the given purpose and its index, which counts from 1 for collisions and from 0 for others.
    #[inline]
    pub fn uniform(&self, purpose: Purpose, index: u32) -> f64 {
        match dimension(purpose, index) {
            Some(dimension) => {
                let high = u64::from(self.point.coordinate(dimension));
                // The sequence decides 32 bits; the sample's key the others.
                unit(high << 32 | (high ^ self.key).wrapping_mul(GOLDEN) >> 32)
            }
            None => self.hash(purpose as u64, u64::from(index)),
        }
    }

    /// A number in [0, 1) for one body on the way to one collision.
    #[inline]
    pub fn body(&self, collision: u32, body_id: u32) -> f64 {
        self.hash(Purpose::Body as u64 + u64::from(collision), u64::from(body_id))
    }

    /// A number in [0, 1) for glow: one of several per draw.
    #[inline]
    pub fn glow(&self, draw: GlowDraw, index: u32) -> f64 {
        self.glow_hash(draw as u64, u64::from(index))
    }

    /// A number in [0, 1) for one body as it is seen from one step of the march: four per body.
    #[inline]
    pub fn glow_body(&self, step: u32, draw: u32, body_id: u32) -> f64 {
        self.glow_hash(GLOW_BODY + 4 * u64::from(step % (1 << 20)) + u64::from(draw), u64::from(body_id))
    }

    /// A number in [0, 1) for one part of the ray past a body that is close to it.
    #[inline]
    pub fn glow_near(&self, part: u32, body_id: u32) -> f64 {
        self.glow_hash(GLOW_NEAR + u64::from(part), u64::from(body_id))
    }

    #[inline]
    fn glow_hash(&self, stream: u64, index: u64) -> f64 {
        unit(mix((self.key ^ GLOW).wrapping_add((stream << 32 ^ index).wrapping_mul(GOLDEN))))
    }

    #[inline]
    fn hash(&self, stream: u64, index: u64) -> f64 {
        unit(mix(self.key.wrapping_add((stream << 32 ^ index).wrapping_mul(GOLDEN))))
    }
}

/// The top 53 of 64 bits as a number in [0, 1).
#[inline]
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_over_each_counter() {
        let by_index = |i: u32| PathRandom::new(1, 2, 3).uniform(Purpose::March, i);
        let by_body = |i: u32| PathRandom::new(1, 2, 3).body(4, i);
        let by_collision = |i: u32| PathRandom::new(1, 2, 3).body(i, 7);
        let by_sample = |i: u32| PathRandom::new(1, 2, i).uniform(Purpose::Bin, 1);
        let starts: Vec<u32> =
            std::iter::successors(Some(0), |start| Some(block_of(*start).end)).take(64_001).collect();
        let by_block = |i: u32| PathRandom::new(1, 2, starts[i as usize]).uniform(Purpose::PixelX, 0);
        let by_pixel = |i: u32| PathRandom::new(1, u64::from(i), 3).uniform(Purpose::PixelX, 0);
        let by_seed = |i: u32| PathRandom::new(u64::from(i), 5, 3).uniform(Purpose::Azimuth, 4);
        let by_copy = |i: u32| PathRandom::new(1, 2, 3).branch(2, i).uniform(Purpose::Collision, 3);
        let by_time = |i: u32| PathRandom::new(1, 2, 3).again(i).uniform(Purpose::Collision, 3);
        let by_division = |i: u32| PathRandom::new(1, 2, 3).branch(i, 1).uniform(Purpose::Angle, 9);
        let draws = [
            &by_index as &dyn Fn(u32) -> f64,
            &by_body,
            &by_collision,
            &by_sample,
            &by_block,
            &by_pixel,
            &by_seed,
            &by_copy,
            &by_division,
            &by_time,
        ];
        for draw in draws {
            let (cells, n) = (64, 64_000u32);
            let mut count = vec![0.0; cells];
            let mut product = 0.0;
            for i in 0..n {
                count[(draw(i) * cells as f64) as usize] += 1.0;
                product += (draw(i) - 0.5) * (draw(i + 1) - 0.5);
            }
            let expected = f64::from(n) / cells as f64;
            let chi2: f64 = count.iter().map(|c: &f64| (c - expected).powi(2) / expected).sum();
            // 63 degrees of freedom: 1e-4 of all uniform sequences exceed 113.
            assert!(chi2 < 113.0, "chi-square {chi2}");
            // The correlation of neighbours has a standard deviation of 1/12/sqrt(n); five of them.
            assert!((product / f64::from(n)).abs() < 5.0 / 12.0 / f64::from(n).sqrt());
        }
    }

    /// The samples of a block have one number in each interval of its length, for everything that the Sobol point decides;
    /// no two purposes share a coordinate.
    #[test]
    fn the_samples_of_a_block_are_stratified() {
        let mut asked = vec![(Purpose::PixelX, 0), (Purpose::PixelY, 0), (Purpose::Hero, 0)];
        for k in 1..=SOBOL_COLLISIONS {
            asked.extend([Purpose::Collision, Purpose::Angle, Purpose::Azimuth, Purpose::ChainChance].map(|p| (p, k)));
        }
        let block = block_of(100);
        assert_eq!(block, 96..112);
        for (purpose, index) in &asked {
            let of_sample = |s| PathRandom::new(7, 8, s).uniform(*purpose, *index);
            let mut strata: Vec<u32> = block.clone().map(|s| (of_sample(s) * 16.0) as u32).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..16).collect::<Vec<u32>>(), "{purpose:?} {index}");
        }
        let mut dimensions: Vec<_> = asked.iter().map(|(purpose, index)| dimension(*purpose, *index)).collect();
        dimensions.sort_unstable();
        dimensions.dedup();
        assert_eq!(dimensions.len(), asked.len());
        assert_eq!(dimension(Purpose::Azimuth, SOBOL_COLLISIONS + 1), None);
    }

    #[test]
    fn samples_of_a_block_take_all_wavelengths_in_turn() {
        for (pixel, n) in [(0, 8usize), (1, 8), (2, 16), (7, 4)] {
            let mut heroes: Vec<usize> = block_of(64).map(|s| PathRandom::new(3, pixel, s).hero(n)).collect();
            heroes.sort_unstable();
            assert_eq!(heroes, (0..16).map(|i| i * n / 16).collect::<Vec<_>>());
        }
        let mut count = [0; 3];
        (0..3000).for_each(|s| count[PathRandom::new(3, 5, s).hero(3)] += 1);
        // Each of some 80 blocks is off by less than one: a standard deviation of 5.
        assert!(count.iter().all(|c| (975..=1025).contains(c)), "{count:?}");
        // Pixels begin anywhere.
        let first: std::collections::BTreeSet<usize> = (0..100).map(|p| PathRandom::new(3, p, 0).hero(8)).collect();
        assert_eq!(first.len(), 8);
    }

    /// Expected: in a block of 16, one of four has one run of four samples, in each pixel another; runs are as likely everywhere, and
    /// independent between streams.
    #[test]
    fn turns_are_taken_evenly() {
        let (block, n) = (block_of(64), 8000);
        let mut count = [0u32; 16];
        let mut both = 0;
        for pixel in 0..n {
            let is_on = |stream: u32| -> Vec<u32> {
                block.clone().filter(|s| PathRandom::new(5, pixel, *s).is_its_turn(stream, 4)).map(|s| s - 64).collect()
            };
            let turns = is_on(0);
            assert!(turns.len() == 4 && turns[0].is_multiple_of(4) && turns[3] == turns[0] + 3, "{turns:?}");
            turns.iter().for_each(|s| count[*s as usize] += 1);
            both += u32::from(turns == is_on(1));
        }
        let near_quarter =
            |count: u32| (f64::from(count) - 0.25 * n as f64).abs() < 5.0 * (n as f64 * 3.0 / 16.0).sqrt();
        assert!(count.iter().all(|c| near_quarter(*c)) && near_quarter(both), "{count:?} {both}");
    }

    /// Expected: what is asked once more is stratified within the block as the first time was, with other numbers.
    #[test]
    fn asking_again_is_stratified_too() {
        for time in [1, 2, 7] {
            let of_sample = |s| PathRandom::new(7, 8, s).again(time).uniform(Purpose::Collision, 1);
            let mut strata: Vec<u32> = block_of(100).map(|s| (of_sample(s) * 16.0) as u32).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..16).collect::<Vec<u32>>(), "{time}");
            let first = PathRandom::new(7, 8, 100).uniform(Purpose::Roulette, 3);
            assert_ne!(PathRandom::new(7, 8, 100).again(time).uniform(Purpose::Roulette, 3), first);
        }
    }

    #[test]
    fn numbers_are_frozen() {
        let random = PathRandom::new(1, 2, 3);
        assert_eq!(random.uniform(Purpose::Roulette, 1), FROZEN[0]);
        assert_eq!(random.uniform(Purpose::March, 6), FROZEN[1]);
    }

    /// From an independent implementation in Python: pictures of a seed must not change by accident.
    const FROZEN: [f64; 2] = [0.19804488397006403, 0.2734205527106903];
}
