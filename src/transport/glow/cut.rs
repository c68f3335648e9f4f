//! The cut: which nodes of the glow tree stand for all sources as seen from one point, near ones single, far ones in
//! clusters.
//!
//! Which nodes may stay together is decided by what they bring and by how much that may be off (`weigh`). Theory (60), (61), (64), (112).

use super::Glow;
use super::eye::Eye;
use super::mixture::SKETCH;
use super::sources::LEAF;
use super::tree::Octet;
use super::weigh::{Item, Looked, look, weigh};

/// Estimated error that is allowed per error that is asked for: errors of nodes side by side have one sign where a fringe is
/// wider than they are, and one in a hundred sums may be off by twice the tolerance. Calibrated against exact sums
/// (`tests/glow.rs`).
const CAUTION: f64 = 0.3;

/// The same for what many nodes have in common, the part of their phase functions that the mixture leaves (112): known at
/// its RMS over all angles.
const COMMON_CAUTION: f64 = 0.4;

/// What may be off by more than this is opened however little it brings: estimates of such are no good.
const MOST_RELATIVE: f32 = 0.3;

/// Most passes of falling threshold, each half the last.
const MOST_PASSES: usize = 24;

/// Buffers of a cut, reused from point to point.
#[derive(Default)]
pub(super) struct Cut {
    pub items: Vec<Item>,
    stack: Vec<u32>,
    /// Nodes and sources that were looked at.
    pub evaluations: u64,
}

impl Cut {
    /// Fills `items` so that the sum's error is about `tolerance` of it; returns the largest error of a node.
    #[inline(always)]
    pub fn refine(&mut self, glow: &Glow, eye: &Eye, tolerance: f32) -> f32 {
        self.items.clear();
        self.stack.clear();
        self.stack.push(0);
        self.walk(glow, eye, f32::INFINITY);
        let mut limit = 0.0;
        for _ in 0..MOST_PASSES {
            let (mut sum, mut square, mut largest) = (0.0f64, 0.0f64, 0.0f32);
            for item in &self.items {
                sum += f64::from(item.light);
                if !item.is_leaf {
                    square += f64::from(item.error * item.error);
                    largest = largest.max(item.error);
                }
            }
            let wanted = f64::from(tolerance) * sum;
            let mut error = square.sqrt() / CAUTION;
            if error <= wanted {
                error = self.common_rest(glow) / COMMON_CAUTION;
            }
            limit = largest;
            if error <= wanted || largest == 0.0 {
                break;
            }
            // Errors above this make up the excess; halving at least, so that passes are few.
            limit = (0.5 * largest).min(largest * (wanted / error) as f32);
            self.open(glow, limit);
            self.walk(glow, eye, limit);
        }
        limit
    }

    /// What the remainders of all nodes come to if all are seen at one angle (112).
    fn common_rest(&self, glow: &Glow) -> f64 {
        if glow.tree.sketches.is_empty() {
            return 0.0;
        }
        let mut sum = [0.0f32; SKETCH];
        for item in self.items.iter().filter(|item| !item.is_leaf) {
            let row = glow.tree.octets[item.node as usize / LEAF].rows as usize + item.node as usize % LEAF;
            let sketch = &glow.tree.sketches[row * SKETCH..(row + 1) * SKETCH];
            sum.iter_mut().zip(sketch).for_each(|(sum, s)| *sum += item.light * s);
        }
        sum.iter().map(|s| f64::from(*s).powi(2)).sum::<f64>().sqrt()
    }

    /// Fills `items` with the cut of a given error per node.
    #[inline(always)]
    pub fn take(&mut self, glow: &Glow, eye: &Eye, limit: f32) {
        self.items.clear();
        self.stack.clear();
        self.stack.push(0);
        self.walk(glow, eye, limit);
    }

    /// Hands all sources over, leaf by leaf.
    #[inline(always)]
    pub fn take_leaves(&mut self, glow: &Glow, eye: &Eye, mut sum: impl FnMut(&Self)) {
        let leaves = glow.tree.octets.iter().enumerate().filter(|(_, octet)| octet.is_leaf);
        for (place, octet) in leaves {
            let looked = look(glow, eye, octet);
            self.items.clear();
            for k in 0..usize::from(octet.count).min(LEAF) {
                self.add_source(glow, eye, octet, &looked, place as u32, k);
            }
            sum(self);
        }
    }

    /// Takes nodes of larger error out and puts their children up.
    fn open(&mut self, glow: &Glow, limit: f32) {
        let Self { items, stack, .. } = self;
        items.retain(|item| {
            let stays = item.is_leaf || item.error <= limit;
            if !stays {
                let octet = &glow.tree.octets[item.node as usize / LEAF];
                stack.push(octet.child[item.node as usize % LEAF]);
            }
            stays
        });
    }

    /// Looks at everything on the stack, and below what must be opened.
    #[inline(always)]
    fn walk(&mut self, glow: &Glow, eye: &Eye, limit: f32) {
        while let Some(place) = self.stack.pop() {
            let octet = &glow.tree.octets[place as usize];
            let looked = look(glow, eye, octet);
            self.evaluations += u64::from(octet.count);
            for k in 0..usize::from(octet.count).min(LEAF) {
                if octet.is_leaf {
                    self.add_source(glow, eye, octet, &looked, place, k);
                } else {
                    self.add_node(glow, eye, octet, &looked, place, k, limit);
                }
            }
        }
    }

    #[inline(always)]
    #[allow(clippy::too_many_arguments)] // the innermost loop, cut in two
    fn add_node(&mut self, glow: &Glow, eye: &Eye, octet: &Octet, looked: &Looked, place: u32, k: usize, limit: f32) {
        let (d, reach) = (looked.d[k], octet.reach[k]);
        if eye.bands.of(d - reach) > eye.bands.last {
            return;
        }
        if d < reach + eye.near {
            self.stack.push(octet.child[k]);
            return;
        }
        let (item, doubt) = weigh(glow, eye, octet, looked, place, k);
        let relative2 = doubt.variance(octet.graininess[k]) + octet.rest[k];
        let error = relative2.sqrt() * item.light;
        if error > limit || relative2 > MOST_RELATIVE * MOST_RELATIVE {
            self.stack.push(octet.child[k]);
            return;
        }
        let weight = eye.bands.weight(d);
        if weight > 0.0 {
            let (factor, light) = (item.factor * weight, item.light * weight);
            self.items.push(Item { error, factor, light, ..item });
        }
    }

    #[inline(always)]
    fn add_source(&mut self, glow: &Glow, eye: &Eye, octet: &Octet, looked: &Looked, place: u32, k: usize) {
        let d = looked.d[k];
        let weight = eye.bands.weight(d);
        let is_droplet = octet.variance[k] == 0.0;
        if weight == 0.0 || (is_droplet && d < octet.reach[k].max(eye.near)) {
            return;
        }
        let (item, doubt) = weigh(glow, eye, octet, looked, place, k);
        let error = if is_droplet { 0.0 } else { doubt.variance(octet.graininess[k]).sqrt() * item.light };
        let (factor, light) = (item.factor * weight, item.light * weight);
        self.items.push(Item { error, factor, light, is_leaf: true, ..item });
    }
}
