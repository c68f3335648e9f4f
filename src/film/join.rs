//! Joins films of runs of samples to the film of all of them, in the order in which one render would have added them up.
//!
//! A run of 2^k samples whose first is a multiple of 2^k is a node of the binary tree in which `Tally` adds blocks. Any range
//! that cuts no block is a sequence of such runs; nodes are joined in pairs wherever a tally would.

use std::ops::Range;

use super::{Film, block_of};

/// Whether a range of samples cuts no block.
pub fn is_whole(range: &Range<u32>) -> bool {
    range.is_empty() || [range.start, range.end].iter().all(|sample| block_of(*sample).start == *sample)
}

/// The longest nodes of the tree of blocks that a range is made of, in order. The range must cut no block.
pub fn nodes_of(range: Range<u32>) -> Vec<Range<u32>> {
    let mut nodes = Vec::new();
    let mut start = range.start;
    while start < range.end {
        let most = (range.end - start).ilog2();
        let level = if start == 0 { most } else { most.min(start.trailing_zeros()) };
        nodes.push(start..start + (1 << level));
        start += 1 << level;
    }
    nodes
}

/// Whether two runs of samples are the halves of one node.
fn are_siblings(a: &Range<u32>, b: &Range<u32>) -> bool {
    let count = a.end - a.start;
    let neighbours = a.end == b.start && b.end - b.start == count;
    neighbours && count.is_power_of_two() && u64::from(a.start) % (2 * u64::from(count)) == 0
}

/// Adds what belongs to one node, or to whatever comes last; `add` joins the second half of a node to the first.
fn push<T>(pieces: &mut Vec<(Range<u32>, T)>, samples: Range<u32>, value: T, add: impl Fn(&mut T, &T)) {
    pieces.push((samples, value));
    while let [.., (a, first), (b, second)] = &mut pieces[..]
        && are_siblings(a, b)
    {
        add(first, second);
        a.end = b.end;
        pieces.pop();
    }
}

/// Films that are held at a time while those of these ranges are read and joined, one range after the other.
pub fn most_held(ranges: impl IntoIterator<Item = Range<u32>>) -> u64 {
    let (mut pieces, mut most) = (Vec::new(), 0);
    for range in ranges {
        let nodes = nodes_of(range);
        most = most.max(pieces.len() + nodes.len());
        nodes.into_iter().for_each(|node| push(&mut pieces, node, (), |(), ()| ()));
    }
    most as u64
}

/// Adds up films, given in the order of their samples.
#[derive(Default)]
pub struct Joiner {
    pieces: Vec<(Range<u32>, Film)>,
}

impl Joiner {
    /// Adds the film of one node, or of whatever comes last.
    pub fn push(&mut self, samples: Range<u32>, film: Film) {
        push(&mut self.pieces, samples, film, Film::add);
    }

    /// The film of all samples; `None` where there was none.
    pub fn finish(self) -> Option<Film> {
        let mut films = self.pieces.into_iter().map(|(_, film)| film);
        let mut sum = films.next()?;
        films.for_each(|film| sum.add(&film));
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Layer, Sample};

    fn film(samples: Range<u32>) -> Film {
        let mut film = Film::new(1, 1, &[], 0);
        let empty = film.tally();
        film.par_tiles(&|| empty.clone(), |tally, _, mut pixels| {
            tally.start(samples.start);
            for i in samples.clone() {
                let mut sample = Sample { opacity: 1.0 / f64::from(i + 1), ..Sample::default() };
                sample.layers[Layer::Direct as usize] = [f64::from(i).sin(), 1.0 / f64::from(i + 3), 0.1];
                tally.add(&sample, &[]);
            }
            pixels.pour(0, 0, tally);
        });
        film
    }

    /// Expected: nodes follow each other, are aligned, and are as many as the binary digits at most.
    #[test]
    fn as_many_films_are_held_as_was_foretold() {
        let cases: [&[Range<u32>]; 4] =
            [&[0..32, 32..64], &[0..4, 4..8, 8..16], &[4..8, 16..64, 256..384], &[0..1, 1..2, 2..4, 4..64, 64..96]];
        for ranges in cases {
            let (mut joiner, mut most) = (Joiner::default(), 0);
            for range in ranges {
                let nodes = nodes_of(range.clone());
                most = most.max(joiner.pieces.len() + nodes.len());
                nodes.into_iter().for_each(|node| joiner.push(node.clone(), film(node)));
            }
            assert_eq!(most_held(ranges.iter().cloned()), most as u64, "{ranges:?}");
        }
    }

    #[test]
    fn ranges_are_made_of_aligned_nodes() {
        assert_eq!(nodes_of(0..96), [0..64, 64..96]);
        assert_eq!(nodes_of(64..112), [64..96, 96..112]);
        assert_eq!(nodes_of(48..128), [48..64, 64..128]);
        assert_eq!(nodes_of(5..5), []);
        assert!(is_whole(&(64..112)) && is_whole(&(0..1)) && is_whole(&(5..5)));
        assert!(!is_whole(&(64..100)) && !is_whole(&(3..4)) && !is_whole(&(66..128)));
        let huge = nodes_of(1..u32::MAX);
        assert!(huge.len() < 64 && huge.windows(2).all(|pair| pair[0].end == pair[1].start));
    }

    /// Expected: whatever ranges the samples are cut into, the very bits of one tally over all.
    #[test]
    fn films_join_to_the_bits_of_one_tally() {
        let cuts: [&[u32]; 5] =
            [&[0, 32, 64, 96, 128], &[0, 1, 2, 8, 64, 112, 128], &[0, 64, 112], &[0, 16, 24, 176, 256], &[0, 48, 80]];
        for cuts in cuts {
            let mut joiner = Joiner::default();
            for range in cuts.windows(2) {
                assert!(is_whole(&(range[0]..range[1])));
                nodes_of(range[0]..range[1]).into_iter().for_each(|node| joiner.push(node.clone(), film(node)));
            }
            let end = cuts[cuts.len() - 1];
            assert_eq!(joiner.finish(), Some(film(0..end)), "{cuts:?}");
            let mut plain = film(0..cuts[1]);
            cuts[1..].windows(2).for_each(|range| plain.add(&film(range[0]..range[1])));
            assert_eq!(plain.samples(), u64::from(end));
        }
        let mut plain = film(0..32);
        [32..64, 64..96, 96..128].into_iter().for_each(|range| plain.add(&film(range)));
        assert_ne!(plain, film(0..128), "the order of addition shows in the last bits");
        assert_eq!(Joiner::default().finish(), None);
    }
}
