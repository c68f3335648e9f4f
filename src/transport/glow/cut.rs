//! The cut: which nodes of the glow tree stand for all sources as seen from one point, near ones single, far ones in
//! clusters.
//!
//! Legend: x, the point that looks; y, a node's centroid; d = |x - y|; e, unit vector from y to x; L, a sun's
//! direction; v, the camera ray's; alpha = sigma / d; V, spread of the summand over a node, relative; D, what twice the
//! blur would change of it; G, one over the number of grains that a node acts as; c, what it brings; epsilon, its
//! relative error. Theory (60), (61), (64), (140)-(142).

use super::Glow;
use super::blur::Spot;
use super::exact::DRAWN_SUNS;
use super::mixture::SKETCH;
use super::sources::LEAF;
use super::tree::Octet;

/// How much of the variance that (64) foretells was found in nodes of even and puffy clouds, one size and many: half, as
/// fringes that are as wide as a node are weakened less than by what their contrast and the node's shape tell apart.
const FOUND: f32 = 0.5;

/// Estimated error that is allowed per error that is asked for: errors of nodes side by side have one sign where a fringe is
/// wider than they are, and one in a hundred sums may be off by twice the tolerance. Calibrated against exact sums
/// (`tests/glow.rs`).
const CAUTION: f64 = 0.3;

/// The same for what many nodes have in common, the part of their phase functions that the mixture leaves (112): known at
/// its RMS over all angles.
const COMMON_CAUTION: f64 = 0.4;

/// What may be off by more than this is opened however little it brings: estimates of such are no good.
const MOST_RELATIVE: f32 = 0.3;

/// Square of how much of two factors' variances together their product may be off: second moments give half of it per axis,
/// and differ between axes by as much.
const PRODUCTS: f32 = 0.25;

/// Most that two phase functions' slopes together change a node's light: beyond, second order tells nothing.
const MOST_TOGETHER: f32 = 0.5;

/// Most passes of falling threshold, each half the last.
const MOST_PASSES: usize = 24;

/// A point that looks, in the tree's units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    pub x: [f32; 3],
    /// Direction of the camera ray.
    pub view: [f32; 3],
    /// From the middle of the ball of air to the point.
    pub in_air: [f32; 3],
    /// |in_air|^2 minus the ball's radius squared.
    pub depth_in_air: f32,
    /// Droplets nearer than this are left out.
    pub near: f32,
    pub bands: Bands,
    /// Directions of the first suns' light.
    pub suns: [[f32; 3]; DRAWN_SUNS],
}

impl Eye {
    /// Direction of a sun's light.
    #[inline(always)]
    pub fn sun(&self, glow: &Glow, index: usize) -> [f32; 3] {
        if index < DRAWN_SUNS { self.suns[index] } else { glow.suns[index].direction }
    }
}

/// How far a step of the march looks: light from afar varies slowly, so that few steps look for it and count it several
/// times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bands {
    /// One over the distance at which the second band begins.
    pub per_unit: f32,
    /// The last band that this step looks at.
    pub last: i32,
    /// The last band that there is.
    pub most: i32,
}

impl Bands {
    /// Everything, once.
    pub const ALL: Self = Self { per_unit: 0.0, last: 0, most: 0 };

    /// The band of a distance: its power of two.
    #[inline(always)]
    fn of(self, d: f32) -> i32 {
        (((d * self.per_unit).max(1.0).to_bits() >> 23) as i32 - 127).min(self.most)
    }

    /// How often light from a distance counts: not at all, or for all steps that do not look.
    #[inline(always)]
    pub fn weight(self, d: f32) -> f32 {
        let band = self.of(d);
        if band > self.last { 0.0 } else { f32::from_bits(((127 + band) as u32) << 23) }
    }
}

/// A node or source that takes part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Octet, eight times, and the place in it.
    pub node: u32,
    pub is_leaf: bool,
    /// Everything but weight and phase functions.
    pub factor: f32,
    /// Where the air's phase function is.
    pub air: Spot,
    /// Where the phase function of the first sun is.
    pub spot: Spot,
    /// c.
    pub light: f32,
    /// epsilon c.
    pub error: f32,
}

/// Buffers of a cut, reused from point to point.
#[derive(Default)]
pub(super) struct Cut {
    pub items: Vec<Item>,
    stack: Vec<u32>,
    /// Nodes and sources that were looked at.
    pub evaluations: u64,
}

/// What is known of eight nodes from a point.
struct Looked {
    d: [f32; LEAF],
    alpha2: [f32; LEAF],
    /// Everything but weight and phase functions.
    factor: [f32; LEAF],
    /// 1 - cos of the scattering angle in the air.
    h_air: [f32; LEAF],
    e: [[f32; LEAF]; 3],
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
        let relative2 = variance_of(doubt, octet.graininess[k]) + octet.rest[k];
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
        let error = if is_droplet { 0.0 } else { variance_of(doubt, octet.graininess[k]).sqrt() * item.light };
        let (factor, light) = (item.factor * weight, item.light * weight);
        self.items.push(Item { error, factor, light, is_leaf: true, ..item });
    }
}

/// Geometry of eight nodes at once.
#[inline(always)]
fn look(glow: &Glow, eye: &Eye, octet: &Octet) -> Looked {
    let mut out =
        Looked { d: [0.0; LEAF], alpha2: [0.0; LEAF], factor: [0.0; LEAF], h_air: [0.0; LEAF], e: [[0.0; LEAF]; 3] };
    for k in 0..LEAF {
        let (x, y, z) = (eye.x[0] - octet.x[k], eye.x[1] - octet.y[k], eye.x[2] - octet.z[k]);
        let d2 = (x * x + y * y + z * z).max(f32::MIN_POSITIVE);
        let inverse = 1.0 / d2.sqrt();
        let e = [x * inverse, y * inverse, z * inverse];
        let d = d2 * inverse;
        // Nearer than the cluster is wide, it is all around.
        let alpha2 = octet.variance[k] / d2.max(octet.variance[k]);
        let air = [e[0] + eye.view[0], e[1] + eye.view[1], e[2] + eye.view[2]];
        // From x towards y the ball of air ends at -b + (b^2 - c)^(1/2).
        let b = -(eye.in_air[0] * e[0] + eye.in_air[1] * e[1] + eye.in_air[2] * e[2]);
        let way = d.min((b * b - eye.depth_in_air).max(0.0).sqrt() - b);
        out.e[0][k] = e[0];
        out.e[1][k] = e[1];
        out.e[2][k] = e[2];
        out.d[k] = d;
        out.alpha2[k] = alpha2;
        out.h_air[k] = 0.5 * (air[0] * air[0] + air[1] * air[1] + air[2] * air[2]);
        // The mean of 1/d^2 over the cluster is (1 + alpha^2) / d^2.
        out.factor[k] = (1.0 + alpha2) / d2.max(octet.variance[k]) * fast_exp(-glow.extinction_per_unit * way.max(0.0));
    }
    out
}

/// What is known of a summand over a node.
#[derive(Clone, Copy)]
struct Doubt {
    /// V.
    spread: f32,
    /// D, and what comes with products of its factors.
    unsure: f32,
}

/// What a node brings, and its doubts.
#[inline(always)]
fn weigh(glow: &Glow, eye: &Eye, octet: &Octet, looked: &Looked, place: u32, k: usize) -> (Item, Doubt) {
    let node = place * LEAF as u32 + k as u32;
    let alpha2 = looked.alpha2[k];
    let h_air = looked.h_air[k];
    let air = glow.air.spot(h_air, alpha2);
    let [air_spread, air_unsure] = glow.air.doubt(air, alpha2);
    let e = [looked.e[0][k], looked.e[1][k], looked.e[2][k]];
    let (mut phase, mut together, mut spread, mut unsure, mut first) = (0.0, 0.0, 0.0f32, 0.0f32, Spot::default());
    for (i, sun) in glow.suns.iter().enumerate() {
        let toward = eye.sun(glow, i);
        let h = turn(e, toward);
        let spot = glow.phases.spot(h, alpha2);
        let part = sun.share * glow.phases.lead(spot);
        let [own_spread, own_unsure] = glow.phases.doubt(spot, alpha2);
        phase += part;
        // The gradient of p(h) along e is -dp/dh times what of L is across e; the air's has -v in the place of L (142).
        let across = -dot(toward, eye.view) - (1.0 - h) * (1.0 - h_air);
        together += part * glow.phases.slope(spot) * across;
        spread = spread.max(own_spread);
        unsure = unsure.max(own_unsure);
        if i == 0 {
            first = spot;
        }
    }
    let together = if phase > 0.0 { alpha2 * glow.air.slope(air) * together / phase } else { 0.0 };
    let factor = looked.factor[k] * (1.0 + together.clamp(-MOST_TOGETHER, MOST_TOGETHER));
    let light = octet.weight[k] * factor * glow.air.lead(air) * phase;
    let smooth = 4.0 * alpha2 + glow.extinction_per_unit * glow.extinction_per_unit * octet.variance[k];
    let doubt = Doubt {
        spread: spread + air_spread + smooth,
        unsure: unsure + air_unsure + PRODUCTS * (spread * air_spread + smooth * smooth),
    };
    (Item { node, is_leaf: false, factor, air, spot: first, light, error: 0.0 }, doubt)
}

/// epsilon^2 but for the remainder of the phase function.
#[inline(always)]
fn variance_of(doubt: Doubt, graininess: f32) -> f32 {
    FOUND * (doubt.spread * graininess + doubt.unsure)
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// h = 1 - cos of the angle between unit vectors.
#[inline(always)]
pub(super) fn turn(e: [f32; 3], l: [f32; 3]) -> f32 {
    let (x, y, z) = (e[0] - l[0], e[1] - l[1], e[2] - l[2]);
    0.5 * (x * x + y * y + z * z)
}

/// exp(x) for x <= 0, to 2e-7: a power of two and a polynomial for the rest (Taylor series of 2^f about 0.5).
#[inline(always)]
fn fast_exp(x: f32) -> f32 {
    let power = (x * std::f32::consts::LOG2_E).max(-126.0);
    let whole = power.floor();
    let r = (power - whole - 0.5) * std::f32::consts::LN_2;
    let series = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r / 720.0)))));
    f32::from_bits(((whole as i32 + 127) as u32) << 23) * std::f32::consts::SQRT_2 * series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_one() {
        for i in 0..2000 {
            let x = -0.04 * i as f32;
            // Half a rounding of the argument, and the series.
            let allowed = 2e-7 * (1.0 - f64::from(x));
            assert!((f64::from(fast_exp(x)) / f64::from(x).exp() - 1.0).abs() < allowed, "{x}");
        }
    }

    /// Over all steps of a march, light from any distance counts as often as there are steps.
    #[test]
    fn bands_count_every_distance_once_per_step() {
        for distance in [0.0, 0.5, 1.0, 3.0, 100.0, 1e9] {
            let weight = |step: u32| {
                let last = step.trailing_zeros().min(3) as i32;
                Bands { per_unit: 1.0, last, most: 3 }.weight(distance)
            };
            let total: f32 = (0..64).map(weight).sum();
            assert_eq!(total, 64.0, "{distance}");
        }
    }
}
