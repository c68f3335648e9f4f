//! Random numbers from counters: stateless, so that neither threads nor the order of a traversal can change a picture.
//!
//! Every number is a hash of (seed, pixel, sample) and of what it is drawn for. The hash is the finaliser of SplitMix64
//! (Steele, Lea & Flood 2014, with the constants of Stafford's variant 13).

/// The random numbers of one path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathRandom {
    key: u64,
    pixel_key: u64,
    sample: u64,
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

/// Makes a number in [0, 1) of 53 bits.
const UNIT: f64 = 1.0 / (1u64 << 53) as f64;

/// 2^64 divided by the golden ratio, odd: the increment of SplitMix64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl PathRandom {
    /// The numbers of one sample of one pixel.
    pub fn new(seed: u64, pixel: u64, sample: u64) -> Self {
        let key = mix(seed.wrapping_add(GOLDEN));
        let pixel_key = mix(key ^ pixel.wrapping_mul(GOLDEN));
        Self { key: mix(pixel_key ^ sample.wrapping_add(1).wrapping_mul(GOLDEN)), pixel_key, sample }
    }

    /// Which of `n` wavelengths leads the path. Samples of a pixel take them in turn, evenly at every power of two (van der
    /// Corput 1935, turned by a number of the pixel's own; theory (79)), so that few samples already show all colours.
    pub fn hero(&self, n: usize) -> usize {
        let start = (mix(self.pixel_key ^ Purpose::Hero as u64) >> 11) as f64 * UNIT;
        let turn = (self.sample.reverse_bits() >> 11) as f64 * UNIT;
        let u = start + turn;
        (((u - u.floor()) * n as f64) as usize).min(n - 1)
    }

    /// A number in [0, 1) for the given purpose and its index.
    #[inline]
    pub fn uniform(&self, purpose: Purpose, index: u32) -> f64 {
        self.hash(purpose as u64, u64::from(index))
    }

    /// A number in [0, 1) for one body on the way to one collision.
    #[inline]
    pub fn body(&self, collision: u32, body_id: u32) -> f64 {
        self.hash(Purpose::Body as u64 + u64::from(collision), u64::from(body_id))
    }

    #[inline]
    fn hash(&self, stream: u64, index: u64) -> f64 {
        let bits = mix(self.key ^ mix(stream << 32 ^ index).wrapping_add(GOLDEN));
        (bits >> 11) as f64 * UNIT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_over_each_counter() {
        let by_index = |i: u32| PathRandom::new(1, 2, 3).uniform(Purpose::March, i);
        let by_body = |i: u32| PathRandom::new(1, 2, 3).body(4, i);
        let by_collision = |i: u32| PathRandom::new(1, 2, 3).body(i, 7);
        let by_sample = |i: u32| PathRandom::new(1, 2, u64::from(i)).uniform(Purpose::PixelX, 0);
        let by_pixel = |i: u32| PathRandom::new(1, u64::from(i), 3).uniform(Purpose::PixelX, 0);
        let by_seed = |i: u32| PathRandom::new(u64::from(i), 5, 3).uniform(Purpose::PixelX, 0);
        for draw in [&by_index as &dyn Fn(u32) -> f64, &by_body, &by_collision, &by_sample, &by_pixel, &by_seed] {
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

    #[test]
    fn samples_of_a_pixel_take_all_wavelengths_in_turn() {
        for (pixel, n) in [(0, 8usize), (1, 8), (2, 16), (7, 4)] {
            let mut heroes: Vec<usize> = (0..n as u64).map(|s| PathRandom::new(3, pixel, s).hero(n)).collect();
            heroes.sort_unstable();
            assert_eq!(heroes, (0..n).collect::<Vec<_>>());
        }
        let mut count = [0; 3];
        (0..3000).for_each(|s| count[PathRandom::new(3, 5, s).hero(3)] += 1);
        assert!(count.iter().all(|c| (990..=1010).contains(c)), "{count:?}");
        // Pixels begin anywhere.
        let first: std::collections::BTreeSet<usize> = (0..100).map(|p| PathRandom::new(3, p, 0).hero(8)).collect();
        assert_eq!(first.len(), 8);
    }

    #[test]
    fn numbers_are_frozen() {
        let random = PathRandom::new(1, 2, 3);
        assert_eq!(random.uniform(Purpose::PixelX, 0), FROZEN[0]);
        assert_eq!(random.uniform(Purpose::March, 6), FROZEN[1]);
    }

    /// From an independent implementation in Python: pictures of a seed must not change by accident.
    const FROZEN: [f64; 2] = [0.19922647179906072, 0.43596923166341384];
}
