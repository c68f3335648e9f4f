//! Numbers that fill the unit cube evenly: an Owen-scrambled Sobol sequence for the first dimensions of a path.
//!
//! The samples of a block (`film::block_of`) are the first points of the sequence (direction numbers of Joe & Kuo 2008),
//! scrambled by hashes (Burley 2020) of seed, pixel and block: stratified against each other, independent of any others.

use std::cell::Cell;

use sobol_burley::parts::{owen_scramble_rev, sobol_int4_rev};

use super::random::{GOLDEN, mix};

/// Dimensions that are computed at once.
const SET: u32 = 4;

/// Four dimensions of one point; they are asked for one after the other, so the last ones are kept.
#[derive(Clone, Debug)]
pub(super) struct SobolPoint {
    scramble: u64,
    index_rev: u32,
    latest: Cell<(u32, [u32; 4])>,
}

impl SobolPoint {
    /// A point of the sequence that `scramble` picks out of all that there are.
    pub fn new(scramble: u64, index: u32) -> Self {
        Self { scramble, index_rev: index.reverse_bits(), latest: Cell::new((u32::MAX, [0; 4])) }
    }

    /// The same point of another sequence.
    pub fn rescrambled(&self, scramble: u64) -> Self {
        Self { scramble, index_rev: self.index_rev, latest: Cell::new((u32::MAX, [0; 4])) }
    }

    /// One coordinate, as 32 bits after the point.
    #[inline]
    pub fn coordinate(&self, dimension: u32) -> u32 {
        let (set, lane) = (dimension / SET, (dimension % SET) as usize);
        let (latest, values) = self.latest.get();
        if latest == set {
            return values[lane];
        }
        let values = self.set(set);
        self.latest.set((set, values));
        values[lane]
    }

    #[inline]
    fn set(&self, set: u32) -> [u32; 4] {
        let points: [u32; 4] = sobol_int4_rev(self.index_rev, set).into();
        let low = mix(self.scramble.wrapping_add(u64::from(set).wrapping_mul(GOLDEN)));
        let high = mix(low);
        // Plain multiplications are faster than those of four lanes where SSE2 is all there is.
        let scrambled = |lane: usize, by: u64| owen_scramble_rev(points[lane], by as u32).reverse_bits();
        [scrambled(0, low), scrambled(1, low >> 32), scrambled(2, high), scrambled(3, high >> 32)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every aligned run of 2^k points has one in each of 2^k intervals of every coordinate, and in each box of equal
    /// sides of the first two.
    #[test]
    fn points_are_stratified() {
        for scramble in [1, 0xdead_beef] {
            let points: Vec<SobolPoint> = (0..64).map(|i| SobolPoint::new(scramble, i)).collect();
            for dimension in 0..20 {
                let mut cells: Vec<u32> = points.iter().map(|p| p.coordinate(dimension) >> 26).collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..64).collect::<Vec<u32>>());
            }
            let mut boxes: Vec<(u32, u32)> =
                points.iter().map(|p| (p.coordinate(0) >> 29, p.coordinate(1) >> 29)).collect();
            boxes.sort_unstable();
            boxes.dedup();
            assert_eq!(boxes.len(), 64);
        }
    }

    /// Over many scrambles each coordinate of one point is uniform, and two coordinates are not correlated.
    #[test]
    fn scrambles_are_uniform_and_independent() {
        let n = 20_000u32;
        let unit = |bits: u32| (f64::from(bits) + 0.5) / 4_294_967_296.0 - 0.5;
        for index in [0, 5] {
            let points: Vec<SobolPoint> = (0..n).map(|i| SobolPoint::new(u64::from(i), index)).collect();
            for (a, b) in [(0, 1), (3, 4), (2, 18), (0, 4)] {
                let mean: f64 = points.iter().map(|p| unit(p.coordinate(a))).sum::<f64>() / f64::from(n);
                let product: f64 =
                    points.iter().map(|p| unit(p.coordinate(a)) * unit(p.coordinate(b))).sum::<f64>() / f64::from(n);
                // Standard deviations sqrt(1/12) and 1/12 over sqrt(n); five of them.
                assert!(mean.abs() < 5.0 * (1.0 / 12.0 / f64::from(n)).sqrt(), "{a}: {mean}");
                assert!(product.abs() < 5.0 / 12.0 / f64::from(n).sqrt(), "{a} {b}: {product}");
            }
        }
    }
}
