//! The glow tree: sources in nodes of eight, each with what a distant point needs to know of it.
//!
//! Coordinates are f32 in units of the cloud's extent about its middle; f64 returns wherever single sources count.
//! Legend: W, light that is scattered in all, as decisions weigh wavelengths; centroid, variance per axis and reach of
//! the sources, weighted by it; n, sources of equal weight that would vary as much; G, one over the number of grains that it
//! acts as (`shape`).

use glam::DVec3;

use super::mixture::SKETCH;
use super::runs::Run;
use super::shape::{Lump, unlike_normal};
use super::sources::LEAF;

/// Eight nodes side by side: children of one node, or single sources.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Octet {
    pub x: [f32; LEAF],
    pub y: [f32; LEAF],
    pub z: [f32; LEAF],
    pub variance: [f32; LEAF],
    /// No source is farther from the centroid; for a single droplet its drawn radius.
    pub reach: [f32; LEAF],
    pub weight: [f32; LEAF],
    /// G.
    pub graininess: [f32; LEAF],
    /// Variance of the phase function's remainder over its square: at least that of single droplets over n, who sample their
    /// fringes.
    pub rest: [f32; LEAF],
    /// Octets, or slots of sources.
    pub child: [u32; LEAF],
    /// Where the rows of its nodes stand.
    pub rows: u32,
    pub count: u8,
    pub is_leaf: bool,
}

/// What a source or all sources below a node amount to.
#[derive(Clone, Debug)]
pub(super) struct Summary {
    pub weight: f64,
    pub center: DVec3,
    /// Sum over the axes of the second moment about the centre, times weight.
    pub moment: f64,
    /// Sum of squares of weights, of single droplets.
    pub squares: f64,
    /// G.
    pub grains: f64,
    pub reach: f64,
    /// Scattered light by sun and wavelength.
    pub colour: Vec<f64>,
    /// Deviations of the phase function, times weight.
    pub mix: Vec<f64>,
    /// Sketch of the phase function's remainder, times weight; empty where all remainders are little.
    pub sketch: Vec<f64>,
    /// The size bins and what each scatters by sun and wavelength; none where they are too many.
    pub bins: Vec<(u32, Vec<f64>)>,
}

/// Size bins of a node that are kept one by one, at most.
const MOST_BINS: usize = 4;

/// Variances of what the mixture leaves of phase functions, over their squares.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Remainders {
    /// Of single droplets.
    pub single: f64,
    /// Up to which a node of few bins need not be known by these.
    pub negligible: f64,
    /// Mean square deviation of a phase function per square of a coefficient of the mixture's.
    pub per_column: f64,
}

/// The tree; rows of colours and deviations stand apart, one per node, by octet and place in it.
#[derive(Default)]
pub(super) struct Tree {
    pub octets: Vec<Octet>,
    pub colours: Vec<f32>,
    pub mixes: Vec<f32>,
    /// Sketches of remainders; empty where all are little.
    pub sketches: Vec<f32>,
    /// Where the bins begin of every node that is known by its bins, and where they end: mostly nothing.
    bins_of: Vec<[u32; 2]>,
    bins: Vec<u32>,
    bin_colours: Vec<f32>,
    /// Nodes above single sources.
    n_inner: usize,
    remainders: Remainders,
}

impl Tree {
    /// Builds the tree over sorted sources; `summarise` describes one of them.
    pub fn build(run: &Run, remainders: Remainders, summarise: &impl Fn(usize) -> Summary) -> (Self, Option<Summary>) {
        let mut tree = Self { remainders, ..Self::default() };
        if run.len() == 0 {
            return (tree, None);
        }
        let (_, root) = tree.add(run, 0, summarise);
        (tree, Some(root))
    }

    /// Adds the octet of a run that begins at a slot, and all below it; returns its place.
    fn add(&mut self, run: &Run, first: usize, summarise: &impl Fn(usize) -> Summary) -> (u32, Summary) {
        let place = self.octets.len();
        self.octets.push(Octet::default());
        let is_leaf = matches!(run, Run::Leaf(_));
        let children: Vec<(u32, Summary)> = if is_leaf {
            (first..first + run.len()).map(|slot| (slot as u32, summarise(slot))).collect()
        } else {
            let starts = run.children().into_iter().scan(first, |next, part| {
                let start = *next;
                *next += part.len();
                Some((part, start))
            });
            starts.map(|(part, start)| self.add(part, start, summarise)).collect()
        };
        let mut octet = Octet { count: children.len() as u8, is_leaf, ..Octet::default() };
        for (k, (child, summary)) in children.iter().enumerate() {
            octet.set(k, *child, summary);
        }
        if !is_leaf {
            octet.rows = self.store_rows(&children);
            self.store_bins(&mut octet, &children);
        }
        self.octets[place] = octet;
        (place as u32, merge(&children, is_leaf, self.remainders.per_column))
    }

    /// Only nodes above single sources have rows; these know their bins.
    fn store_rows(&mut self, children: &[(u32, Summary)]) -> u32 {
        let first = self.n_inner * LEAF;
        self.n_inner += 1;
        let (n_colours, n_mixes) = (children[0].1.colour.len(), children[0].1.mix.len());
        self.colours.resize((first + LEAF) * n_colours, 0.0);
        self.mixes.resize((first + LEAF) * n_mixes, 0.0);
        for (k, (_, summary)) in children.iter().enumerate() {
            let node = first + k;
            let colours = &mut self.colours[node * n_colours..(node + 1) * n_colours];
            colours.iter_mut().zip(&summary.colour).for_each(|(to, from)| *to = *from as f32);
            let scale = if summary.weight > 0.0 { 1.0 / summary.weight } else { 0.0 };
            let mixes = &mut self.mixes[node * n_mixes..(node + 1) * n_mixes];
            mixes.iter_mut().zip(&summary.mix).for_each(|(to, from)| *to = (from * scale) as f32);
        }
        first as u32
    }

    /// What the mixture leaves of the phase functions: sketches, and bins in their place where they are few.
    fn store_bins(&mut self, octet: &mut Octet, children: &[(u32, Summary)]) {
        let first = octet.rows as usize;
        if children.iter().all(|(_, summary)| summary.sketch.is_empty()) {
            return;
        }
        self.sketches.resize((first + LEAF) * SKETCH, 0.0);
        self.bins_of.resize(first + LEAF, [0; 2]);
        for (k, (_, summary)) in children.iter().enumerate() {
            let scale = if summary.weight > 0.0 { 1.0 / summary.weight } else { 0.0 };
            let rest = summary.sketch.iter().map(|s| (s * scale).powi(2)).sum::<f64>();
            octet.rest[k] = (summary.evenness() * self.remainders.single) as f32;
            if rest <= self.remainders.negligible {
                continue;
            }
            if !summary.bins.is_empty() {
                let start = self.bins.len() as u32;
                for (bin, colour) in &summary.bins {
                    self.bins.push(*bin);
                    self.bin_colours.extend(colour.iter().map(|c| *c as f32));
                }
                self.bins_of[first + k] = [start, self.bins.len() as u32];
                continue;
            }
            octet.rest[k] = octet.rest[k].max(rest as f32);
            let sketch = &mut self.sketches[(first + k) * SKETCH..(first + k + 1) * SKETCH];
            sketch.iter_mut().zip(&summary.sketch).for_each(|(to, from)| *to = (from * scale) as f32);
        }
    }

    /// The bins by which a node is known, with their light by sun and wavelength; none where the mixture does.
    #[inline]
    pub fn bins(&self, row: usize, n_colours: usize) -> impl Iterator<Item = (usize, &[f32])> {
        let [start, end] = self.bins_of.get(row).map_or([0; 2], |range| range.map(|i| i as usize));
        let colours = self.bin_colours[start * n_colours..end * n_colours].chunks_exact(n_colours);
        self.bins[start..end].iter().map(|bin| *bin as usize).zip(colours)
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let rows = [&self.colours, &self.mixes, &self.sketches, &self.bin_colours];
        size_of_val(&self.octets[..])
            + rows.map(|rows| size_of_val(&rows[..])).iter().sum::<usize>()
            + size_of_val(&self.bins_of[..])
            + size_of_val(&self.bins[..])
    }
}

impl Octet {
    fn set(&mut self, k: usize, child: u32, summary: &Summary) {
        let weight = summary.weight.max(f64::MIN_POSITIVE);
        (self.x[k], self.y[k], self.z[k]) = (summary.center.x as f32, summary.center.y as f32, summary.center.z as f32);
        self.variance[k] = (summary.moment / (3.0 * weight)) as f32;
        self.reach[k] = summary.reach as f32;
        self.weight[k] = summary.weight as f32;
        self.graininess[k] = summary.grains as f32;
        self.child[k] = child;
    }
}

impl Summary {
    /// 1 / n.
    fn evenness(&self) -> f64 {
        (self.squares / self.weight.max(f64::MIN_POSITIVE).powi(2)).min(1.0)
    }
}

/// What all children together amount to.
fn merge(children: &[(u32, Summary)], is_leaf: bool, per_column: f64) -> Summary {
    let weight: f64 = children.iter().map(|(_, child)| child.weight).sum();
    let even = 1.0 / children.len() as f64;
    // Sources in full shade still need a place.
    let part = |child: &Summary| if weight > 0.0 { child.weight / weight } else { even };
    let center: DVec3 = children.iter().map(|(_, child)| part(child) * child.center).sum();
    let sum = |of: &dyn Fn(&Summary) -> &[f64]| -> Vec<f64> {
        let mut total = vec![0.0; of(&children[0].1).len()];
        for (_, child) in children {
            total.iter_mut().zip(of(child)).for_each(|(total, value)| *total += value);
        }
        total
    };
    let moment = children.iter().map(|(_, c)| c.moment + c.weight * (c.center - center).length_squared()).sum();
    let own = |child: &Summary| child.moment / (3.0 * child.weight.max(f64::MIN_POSITIVE));
    let lumps: Vec<Lump> = (children.iter().map(|(_, child)| child))
        .map(|child| Lump { part: part(child), from_middle: child.center - center, variance: own(child) })
        .collect();
    let below: f64 = children.iter().map(|(_, child)| part(child).powi(2) * child.grains).sum();
    let shape = unlike_normal(&lumps, moment / (3.0 * weight.max(f64::MIN_POSITIVE)));
    // Single droplets are lumps already.
    let lumpy = if is_leaf { below.max(shape) } else { below + shape };
    let (mix, sketch) = (sum(&|child| &child.mix), sum(&|child| &child.sketch));
    let differ = |of: &dyn Fn(&Summary) -> &[f64], mean: &[f64]| -> f64 {
        let square = |child: &Summary| {
            let scale = child.weight.max(f64::MIN_POSITIVE).recip();
            of(child)
                .iter()
                .zip(mean)
                .map(|(own, mean)| (own * scale - mean / weight.max(f64::MIN_POSITIVE)).powi(2))
                .sum::<f64>()
        };
        children.iter().map(|(_, child)| part(child) * square(child)).sum()
    };
    let mixed = if is_leaf {
        0.0
    } else {
        per_column * differ(&|child| &child.mix, &mix) + differ(&|child| &child.sketch, &sketch)
    };
    Summary {
        weight,
        center,
        moment,
        grains: (lumpy + mixed).min(1.0),
        squares: children.iter().map(|(_, child)| child.squares).sum(),
        reach: children.iter().map(|(_, c)| c.reach + (c.center - center).length()).fold(0.0, f64::max),
        colour: sum(&|child| &child.colour),
        mix,
        sketch,
        bins: merge_bins(children),
    }
}

/// The bins of all children, if they are few and known.
fn merge_bins(children: &[(u32, Summary)]) -> Vec<(u32, Vec<f64>)> {
    let mut all: Vec<(u32, Vec<f64>)> = Vec::new();
    if children.iter().any(|(_, child)| child.bins.is_empty()) {
        return all;
    }
    for (bin, colour) in children.iter().flat_map(|(_, child)| &child.bins) {
        match all.iter().position(|(known, _)| known == bin) {
            Some(i) => all[i].1.iter_mut().zip(colour).for_each(|(sum, c)| *sum += c),
            None if all.len() == MOST_BINS => return Vec::new(),
            None => all.push((*bin, colour.clone())),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::sources::Slot;
    use super::*;

    /// Sources at x = 0, 1, 2, .. of weight 1.
    fn one(i: usize) -> Summary {
        Summary {
            weight: 1.0,
            center: DVec3::splat(i as f64),
            moment: 0.0,
            squares: 1.0,
            grains: 1.0,
            reach: 0.0,
            colour: vec![1.0],
            mix: vec![],
            sketch: vec![],
            bins: vec![],
        }
    }

    #[test]
    fn evenly_spread_leaves_are_full_but_one() {
        for len in [1, 7, 8, 9, 64, 65, 1000, 4097] {
            let slot = |i: usize| Slot { body: i as u32, amount: 1.0 };
            let mut items: Vec<_> = (0..len).map(|i| ([i as f32, 0.0, 0.0], slot(i))).collect();
            let (tree, root) = Tree::build(&Run::sort(&mut items), Remainders::default(), &one);
            let leaves: Vec<usize> = tree.octets.iter().filter(|o| o.is_leaf).map(|o| usize::from(o.count)).collect();
            assert_eq!(leaves.iter().sum::<usize>(), len);
            assert_eq!(leaves.len(), len.div_ceil(LEAF), "{len}: {leaves:?}");
            let root = root.unwrap();
            assert_eq!((root.weight, root.colour[0], root.squares), (len as f64, len as f64, len as f64));
            assert!((root.center.x - (len as f64 - 1.0) / 2.0).abs() < 1e-9);
            let variance = (len * len - 1) as f64 / 12.0;
            assert!((root.moment - 3.0 * variance * len as f64).abs() < 1e-6 * root.moment.max(1.0));
        }
    }
}
