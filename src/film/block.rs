//! Blocks: the runs of samples of a pixel that are drawn together, and compared with each other to learn the error.
//!
//! The samples of one block are stratified against each other; those of different blocks are independent. So a block's
//! sum has the variance that stratification left, and the scatter between blocks is an honest estimate of it. Blocks grow
//! like the root of the number of samples: there are ever more of them, and they gain ever more.

use std::ops::Range;

/// The block that a sample belongs to: 0, 1, 2..4, then blocks of 4 up to 16, of 8 up to 64, of 16 up to 256, ..
///
/// A block's length is a power of two of which its start is a multiple: 2^(floor(log2(s) / 2) + 1) for s >= 2.
#[inline]
pub fn block_of(sample: u32) -> Range<u32> {
    if sample < 2 {
        return sample..sample + 1;
    }
    let length = 2u32 << (sample.ilog2() / 2);
    let start = sample & !(length - 1);
    start..start.saturating_add(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected: blocks follow each other without gap, and never reach across a power of two.
    #[test]
    fn blocks_tile_the_samples() {
        let mut sample = 0;
        let mut lengths = Vec::new();
        while sample < 1 << 20 {
            let block = block_of(sample);
            assert_eq!(block.start, sample);
            assert!(block.clone().step_by(7).all(|s| block_of(s) == block));
            let length = block.end - block.start;
            assert!(length.is_power_of_two() && block.start % length == 0);
            assert!(!(block.start + 1..block.end).any(u32::is_power_of_two), "{block:?}");
            lengths.push(length);
            sample = block.end;
        }
        assert_eq!(lengths[..12], [1, 1, 2, 4, 4, 4, 8, 8, 8, 8, 8, 8]);
        assert_eq!(block_of(u32::MAX).end, u32::MAX);
    }
}
