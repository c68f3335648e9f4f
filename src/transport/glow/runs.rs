//! Sorting sources for the tree: in halves, or at gaps between clusters, down to runs of eight.
//!
//! A node that spans two clusters is no one cluster: seen from afar its droplets scatter by two angles, not by those about
//! their middle. Runs are split where most of the spread of their positions goes, if that is much more than by halving.

use super::sources::{LEAF, Slot};

/// Positions by which a run's gap is found, at most.
const SAMPLES: usize = 256;

/// A gap leaves at most this part of the spread that halves would leave; even clouds are halved, so that leaves are full.
const GAP: f64 = 0.7;

/// A source's position and what it is.
pub(super) type Placed = ([f32; 3], Slot);

/// Sources next to each other in the tree's order.
#[derive(Debug)]
pub(super) enum Run {
    /// Sources of one leaf.
    Leaf(usize),
    /// Two runs and how many sources they have.
    Pair(Box<[Run; 2]>, usize),
}

impl Run {
    /// Sorts positions so that what is close lies together; how they are split.
    pub fn sort(items: &mut [Placed]) -> Self {
        if items.len() <= LEAF {
            return Self::Leaf(items.len());
        }
        let (axis, middle) = split(items);
        let by_place = |a: &Placed, b: &Placed| a.0[axis].total_cmp(&b.0[axis]).then_with(|| a.1.body.cmp(&b.1.body));
        items.select_nth_unstable_by(middle, by_place);
        let n = items.len();
        let (left, right) = items.split_at_mut(middle);
        let (left, right) = if n > 8192 {
            rayon::join(|| Self::sort(left), || Self::sort(right))
        } else {
            (Self::sort(left), Self::sort(right))
        };
        Self::Pair(Box::new([left, right]), n)
    }

    /// Number of sources.
    pub fn len(&self) -> usize {
        match self {
            Self::Leaf(n) | Self::Pair(_, n) => *n,
        }
    }

    /// The runs that become the children of one node: the longest is split until there are eight.
    pub fn children(&self) -> Vec<&Self> {
        let mut parts = vec![self];
        while parts.len() < LEAF {
            let pairs = parts.iter().enumerate().filter(|(_, part)| matches!(part, Self::Pair(..)));
            // The first of equally long ones.
            let longest = pairs.rev().max_by_key(|(_, part)| part.len()).map(|(i, _)| i);
            let Some((i, Self::Pair(halves, _))) = longest.map(|i| (i, parts[i])) else { break };
            parts.splice(i..=i, halves.iter());
        }
        parts
    }
}

/// Along which axis a run is split, and how many sources are on the lower side.
fn split(items: &[Placed]) -> (usize, usize) {
    let stride = items.len().div_ceil(SAMPLES);
    let axes = [0, 1, 2].map(|axis| Axis::new(items.iter().step_by(stride).map(|(p, _)| f64::from(p[axis])).collect()));
    let longest = (0..3).max_by(|a, b| axes[*a].extent().total_cmp(&axes[*b].extent())).unwrap_or(0);
    let spread: f64 = axes.iter().map(Axis::spread).sum();
    let halved = spread - axes[longest].gain_of_halves();
    let gaps = axes.iter().enumerate().map(|(axis, values)| (axis, values.largest_gain()));
    let best = gaps.max_by(|a, b| a.1.0.total_cmp(&b.1.0));
    if let Some((axis, (_, border))) = best.filter(|(_, (gain, _))| spread - gain < GAP * halved) {
        let lower = items.iter().filter(|(p, _)| f64::from(p[axis]) < border).count();
        if 0 < lower && lower < items.len() {
            return (axis, lower);
        }
    }
    (longest, middle_of(items.len()))
}

/// Where a run is halved: so that leaves come out full.
fn middle_of(len: usize) -> usize {
    (len / 2).next_multiple_of(LEAF).min(len.next_multiple_of(LEAF) - LEAF)
}

/// Positions along an axis, in order, from their mean.
struct Axis {
    values: Vec<f64>,
    mean: f64,
}

impl Axis {
    fn new(mut values: Vec<f64>) -> Self {
        values.sort_unstable_by(f64::total_cmp);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter_mut().for_each(|value| *value -= mean);
        Self { values, mean }
    }

    fn extent(&self) -> f64 {
        self.values.last().unwrap_or(&0.0) - self.values.first().unwrap_or(&0.0)
    }

    /// Sum of squares about the mean.
    fn spread(&self) -> f64 {
        self.values.iter().map(|value| value * value).sum()
    }

    /// What a split takes from the spread, for every number of values on the lower side from 1; with c their sum,
    /// c^2 n / (i (n - i)).
    fn gains(&self) -> impl Iterator<Item = f64> {
        let n = self.values.len() as f64;
        let mut sum = 0.0;
        (1..self.values.len()).map(move |i| {
            sum += self.values[i - 1];
            sum * sum * n / (i as f64 * (n - i as f64))
        })
    }

    fn gain_of_halves(&self) -> f64 {
        self.gains().nth((self.values.len() / 2).saturating_sub(1)).unwrap_or(0.0)
    }

    /// The most that a split takes, and where.
    fn largest_gain(&self) -> (f64, f64) {
        let best = self.gains().zip(1..).max_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or((0.0, 0.0), |(gain, i)| (gain, self.mean + 0.5 * (self.values[i - 1] + self.values[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(at: [f32; 3], body: u32) -> Placed {
        (at, Slot { body, amount: 1.0 })
    }

    /// Two clusters of 100 and 37 droplets, far apart along the shorter axis of neither.
    #[test]
    fn a_gap_splits_what_is_two_clusters() {
        let spot = |i: u32, offset: f32| {
            let u = |axis: u64| crate::transport::random::hash_uniform(u64::from(i), axis) as f32;
            placed([u(0) + offset, u(1), 2.0 * u(2) - offset], i)
        };
        let mut items: Vec<Placed> = (0..100).map(|i| spot(i, 0.0)).chain((100..137).map(|i| spot(i, 6.0))).collect();
        let Run::Pair(halves, 137) = Run::sort(&mut items) else { panic!("a pair") };
        let lengths = [halves[0].len(), halves[1].len()];
        assert!(lengths == [100, 37] || lengths == [37, 100], "{lengths:?}");
        let first = items[..lengths[0]].iter().map(|(_, slot)| slot.body < 100);
        assert!(first.clone().all(|one| one) || first.clone().all(|one| !one));
    }

    /// Coincident positions and such as only floats can tell apart have an end, too.
    #[test]
    fn any_positions_can_be_sorted() {
        let powers = (0..140).map(|i| placed([(-i as f32).exp2(), 0.0, 0.0], i as u32));
        let same = (140..400).map(|i| placed([0.5; 3], i));
        let mut items: Vec<Placed> = powers.chain(same).collect();
        let run = Run::sort(&mut items);
        assert_eq!(run.len(), 400);
        assert_eq!(run.children().iter().map(|part| part.len()).sum::<usize>(), 400);
    }
}
