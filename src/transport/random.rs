//! Random numbers from counters: stateless, so that neither threads nor the order of a traversal can change a picture.
//!
//! Every number is a hash of (seed, pixel, sample) and of what it is drawn for. The hash is the finaliser of SplitMix64
//! (Steele, Lea & Flood 2014, with the constants of Stafford's variant 13).

/// The random numbers of one path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathRandom {
    key: u64,
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
    /// Free flight: plus the number of the collision, for every body.
    Body,
}

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
        let key = mix(key ^ pixel.wrapping_mul(GOLDEN));
        Self { key: mix(key ^ sample.wrapping_add(1).wrapping_mul(GOLDEN)) }
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
        (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
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
    fn numbers_are_frozen() {
        let random = PathRandom::new(1, 2, 3);
        assert_eq!(random.uniform(Purpose::PixelX, 0), FROZEN[0]);
        assert_eq!(random.uniform(Purpose::March, 6), FROZEN[1]);
    }

    /// From an independent implementation in Python: pictures of a seed must not change by accident.
    const FROZEN: [f64; 2] = [0.19922647179906072, 0.03412754645239102];
}
