//! What a node brings as seen from one point, and by how much that may be off.
//!
//! Legend: x, the point that looks; y, a node's centroid; d = |x - y|; e, unit vector from y to x; L, a sun's
//! direction; v, the camera ray's; alpha = sigma / d; V, spread of the summand over a node, relative; D, what twice the
//! blur would change of it; G, one over the number of grains that a node acts as; c, what it brings; epsilon, its
//! relative error. Theory (60), (64), (140)-(142).

use super::Glow;
use super::blur::Spot;
use super::eye::Eye;
use super::sources::LEAF;
use super::tree::Octet;

/// How much of the variance that (64) foretells was found in nodes of even and puffy clouds, one size and many: half, as
/// fringes that are as wide as a node are weakened less than by what their contrast and the node's shape tell apart.
const FOUND: f32 = 0.5;

/// Square of how much of two factors' variances together their product may be off: second moments give half of it per axis,
/// and differ between axes by as much.
const PRODUCTS: f32 = 0.25;

/// Most that two phase functions' slopes together change a node's light: beyond, second order tells nothing.
const MOST_TOGETHER: f32 = 0.5;

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

/// What is known of eight nodes from a point.
pub(super) struct Looked {
    pub d: [f32; LEAF],
    alpha2: [f32; LEAF],
    /// Everything but weight and phase functions.
    factor: [f32; LEAF],
    /// 1 - cos of the scattering angle in the air.
    h_air: [f32; LEAF],
    e: [[f32; LEAF]; 3],
}

/// Geometry of eight nodes at once.
#[inline(always)]
pub(super) fn look(glow: &Glow, eye: &Eye, octet: &Octet) -> Looked {
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
pub(super) struct Doubt {
    /// V.
    spread: f32,
    /// D, and what comes with products of its factors.
    unsure: f32,
}

impl Doubt {
    /// epsilon^2 but for the remainder of the phase function, of a node of graininess G.
    #[inline(always)]
    pub fn variance(self, graininess: f32) -> f32 {
        FOUND * (self.spread * graininess + self.unsure)
    }
}

/// What a node brings, and its doubts.
#[inline(always)]
pub(super) fn weigh(glow: &Glow, eye: &Eye, octet: &Octet, looked: &Looked, place: u32, k: usize) -> (Item, Doubt) {
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
}
