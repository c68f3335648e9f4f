//! Smooth random variation in space: what gives fog its banks.

use rand::Rng;

use super::random::{Purpose, stream};

/// Density of a patchy cloud, relative to its densest places: exp(k n), n a fractal sum of gradient noise
/// (Perlin 2002, "Improving noise", without the fixed permutation: the lattice is hashed from the seed).
#[derive(Clone, Copy, Debug)]
pub(super) struct Patches {
    seed: u64,
    contrast: f64,
    per_length: [f64; 3],
}

/// Octaves of the sum.
const N_OCTAVES: i32 = 4;

/// The sum is cut off here; its standard deviation is 0.31, and its largest values would cost many rejected droplets.
const N_LIMIT: f64 = 0.5;

/// Contrast at patchiness 1: densities over the cut-off range differ by exp(4), a factor of 55.
const CONTRAST: f64 = 4.0;

/// Banks along the longest side.
const N_BANKS: f64 = 4.0;

impl Patches {
    /// Patches for a shape of the given sizes; `patchiness` 0 to 1.
    pub fn new(seed: u64, patchiness: f64, size: [f64; 3]) -> Self {
        let longest = size.into_iter().fold(0.0, f64::max);
        // Half sizes, because points come in units of these.
        let per_length = size.map(|size| 0.5 * N_BANKS * size / longest);
        Self { seed: stream(seed, Purpose::Patches).next_u64(), contrast: CONTRAST * patchiness, per_length }
    }

    /// Relative density at a point in units of the half sizes, above 0, at most 1.
    pub fn density(&self, point: [f64; 3]) -> f64 {
        if self.contrast == 0.0 {
            return 1.0;
        }
        let place = [0, 1, 2].map(|axis| point[axis] * self.per_length[axis]);
        let n = fractal_noise(place, self.seed, N_OCTAVES).clamp(-N_LIMIT, N_LIMIT);
        (self.contrast * (n - N_LIMIT)).exp()
    }
}

/// Gradient noise in octaves, each with half the size and half the height of the one before.
pub(super) fn fractal_noise(place: [f64; 3], seed: u64, n_octaves: i32) -> f64 {
    (0..n_octaves)
        .map(|octave| {
            let scale = f64::from(1 << octave);
            // The shift keeps the lattices' zeros apart.
            gradient_noise(place.map(|x| x * scale + 17.31 * f64::from(octave)), seed) / scale
        })
        .sum()
}

/// Gradient noise, about -1 to 1, zero on the integer lattice.
fn gradient_noise(place: [f64; 3], seed: u64) -> f64 {
    let cell = place.map(f64::floor);
    let [x, y, z] = [place[0] - cell[0], place[1] - cell[1], place[2] - cell[2]];
    let [u, v, w] = [fade(x), fade(y), fade(z)];
    let [i, j, k] = cell.map(|c| c as i64);
    let corner = |di: i64, dj: i64, dk: i64| {
        slope(hash([i + di, j + dj, k + dk], seed), [x - di as f64, y - dj as f64, z - dk as f64])
    };
    let edge = |dj, dk| mix(corner(0, dj, dk), corner(1, dj, dk), u);
    let face = |dk| mix(edge(0, dk), edge(1, dk), v);
    mix(face(0), face(1), w)
}

/// The quintic whose first and second derivatives vanish at 0 and 1.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// The product of one of the twelve directions to the edges of a cube with `d`.
fn slope(hash: u64, d: [f64; 3]) -> f64 {
    let sign = |bit: u64| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let (a, b) = match (hash >> 8) % 3 {
        0 => (d[0], d[1]),
        1 => (d[1], d[2]),
        _ => (d[2], d[0]),
    };
    sign(0) * a + sign(1) * b
}

/// Odd multipliers, then the finalizer of SplitMix64 (Steele, Lea & Flood 2014).
fn hash([x, y, z]: [i64; 3], seed: u64) -> u64 {
    let mixed = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ (z as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
    let mut h = seed.wrapping_add(mixed);
    h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^ (h >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::generate::random::unit_f64;

    #[test]
    fn noise_is_smooth_centred_and_as_wide_as_documented() {
        let mut rng = stream(1, Purpose::Positions);
        let noise = |place| fractal_noise(place, 5, N_OCTAVES);
        let n = 20_000;
        let values: Vec<f64> = (0..n)
            .map(|_| {
                let place = [0; 3].map(|_| 40.0 * unit_f64(&mut rng));
                let (here, near) = (noise(place), noise(place.map(|x| x + 1e-6)));
                assert!((here - near).abs() < 5e-5, "a jump at {place:?}");
                here
            })
            .collect();
        let mean = values.iter().sum::<f64>() / f64::from(n);
        let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
        assert!(mean.abs() < 0.02 && (0.22..0.36).contains(&deviation), "{mean} {deviation}");
    }

    #[test]
    fn even_clouds_have_no_patches() {
        assert_eq!(Patches::new(5, 0.0, [1.0; 3]).density([0.3, 0.1, 0.9]), 1.0);
        let patchy = Patches::new(5, 1.0, [1.0; 3]).density([0.3, 0.1, 0.9]);
        assert!(patchy > 0.0 && patchy <= 1.0);
    }
}
