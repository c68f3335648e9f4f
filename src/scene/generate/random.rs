//! Random numbers of a cloud: pcg64 (O'Neill 2014; `rand_pcg`), one generator per purpose, the same on every machine.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// The generator's name, as it is recorded in files.
pub const GENERATOR: &str = "pcg64";

/// What random numbers are used for; each purpose has its own, so that a change in one leaves the others alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Where particles are.
    Positions = 1,
    /// How large droplets are.
    Sizes = 2,
    /// The lattice of the patchiness noise.
    Patches = 3,
    /// Where billows grow, and the noise that roughens them.
    Billows = 4,
}

/// The generator of a seed and a purpose.
pub(super) fn stream(seed: u64, purpose: Purpose) -> Pcg64 {
    // Weyl steps of SplitMix64 (Steele, Lea & Flood 2014); `seed_from_u64` mixes what they leave alike.
    Pcg64::seed_from_u64(seed.wrapping_add((purpose as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)))
}

/// Particles that one generator makes: blocks are made side by side, and are the same however many threads there are.
const BLOCK: usize = 1 << 16;

/// The generator of a block of particles.
fn block_stream(seed: u64, purpose: Purpose, block: usize) -> Pcg64 {
    let mut first = stream(seed, purpose);
    if block == 0 { first } else { stream(first.next_u64() ^ block as u64, purpose) }
}

/// Makes `count` values from their numbers, block by block, on all threads.
pub(super) fn make_blocks<T: Copy + Default + Send>(
    count: usize,
    seed: u64,
    purpose: Purpose,
    make: impl Fn(usize, &mut Pcg64) -> T + Sync,
) -> Vec<T> {
    let mut values = vec![T::default(); count];
    values.par_chunks_mut(BLOCK).enumerate().for_each(|(block, values)| {
        let mut rng = block_stream(seed, purpose, block);
        values.iter_mut().enumerate().for_each(|(i, value)| *value = make(block * BLOCK + i, &mut rng));
    });
    values
}

/// Evenly distributed in the open interval 0 .. 1: the middles of 2^52 equal steps.
pub(super) fn unit_f64(rng: &mut impl Rng) -> f64 {
    ((rng.next_u64() >> 12) as f64 + 0.5) * (1.0 / (1_u64 << 52) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_a_seed_stay_what_they_are() {
        let first = |seed, purpose| stream(seed, purpose).next_u64();
        assert_ne!(first(0, Purpose::Positions), first(0, Purpose::Sizes));
        assert_ne!(first(0, Purpose::Positions), first(1, Purpose::Positions));
        assert_eq!(block_stream(7, Purpose::Positions, 0).next_u64(), first(7, Purpose::Positions));
        assert_ne!(block_stream(7, Purpose::Positions, 1).next_u64(), first(7, Purpose::Positions));
        // Frozen: a change here changes every generated file.
        assert_eq!(first(7, Purpose::Positions), 8_364_727_173_472_410_164);
    }
}
