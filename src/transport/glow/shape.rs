//! How far the shape of a cluster is from the normal distribution that it is taken for.
//!
//! A fringe of a phase function of wave vector k, seen over a cluster with the characteristic function phi, is weakened to
//! |phi(k)|; of a normal one it would be phi_0(k). Legend: S, mean of |phi - phi_0|^2 over normal k of standard deviation q
//! per axis. Theory (141).

use glam::DVec3;

use crate::accel::{Accel, Body, BodyKind};

/// q times the cluster's standard deviation: fringes a few of which lie across it, beyond what second moments tell.
const FRINGES: f64 = 1.5;

/// A part of a cluster, itself taken to be normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lump {
    /// Of the whole's weight.
    pub part: f64,
    pub from_middle: DVec3,
    /// Per axis.
    pub variance: f64,
}

/// S of lumps with the given variance per axis in all.
pub(super) fn unlike_normal(lumps: &[Lump], variance: f64) -> f64 {
    if variance <= 0.0 {
        return 0.0;
    }
    let q2 = FRINGES * FRINGES / variance;
    // Mean of exp(i k d - k^2 v / 2) over k.
    let mean = |way: DVec3, v: f64| {
        let wide = 1.0 + q2 * v;
        (-0.5 * q2 * way.length_squared() / wide).exp() / (wide * wide.sqrt())
    };
    let normal = Lump { part: -1.0, from_middle: DVec3::ZERO, variance };
    let all = || lumps.iter().copied().chain([normal]);
    let pair = |a: Lump, b: Lump| a.part * b.part * mean(a.from_middle - b.from_middle, a.variance + b.variance);
    all().map(|a| all().map(|b| pair(a, b)).sum::<f64>()).sum::<f64>().max(0.0)
}

/// S of a body of fog, evenly filled: of a box, cut in eight across its longest edges. A ball's is below 0.01, and a droplet is a
/// grain of its own.
pub(super) fn own_grains(accel: &Accel, body: &Body) -> f64 {
    match body.kind() {
        BodyKind::Droplet | BodyKind::Glass => 1.0,
        BodyKind::Ball => 0.0,
        BodyKind::Box => {
            let edges = accel.half_edges(body);
            of_box([edges.x_axis, edges.y_axis, edges.z_axis])
        }
    }
}

fn of_box(mut half_edges: [DVec3; 3]) -> f64 {
    let variance = |edges: &[DVec3; 3]| edges.iter().map(|edge| edge.length_squared()).sum::<f64>() / 9.0;
    let whole = variance(&half_edges);
    let mut middles = vec![DVec3::ZERO];
    for _ in 0..3 {
        let lengths = half_edges.map(|edge| edge.length_squared());
        let longest = (0..3).max_by(|a, b| lengths[*a].total_cmp(&lengths[*b])).unwrap_or(0);
        half_edges[longest] *= 0.5;
        let half = half_edges[longest];
        middles = middles.into_iter().flat_map(|middle| [middle - half, middle + half]).collect();
    }
    let part = 1.0 / middles.len() as f64;
    let lump = |from_middle| Lump { part, from_middle, variance: variance(&half_edges) };
    unlike_normal(&middles.into_iter().map(lump).collect::<Vec<_>>(), whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: DVec3 = DVec3::X;

    /// Two points at +-1 per axis variance 1/3: phi = cos k_x.
    #[test]
    fn two_points_are_as_by_their_characteristic_function() {
        let lumps = [X, -X].map(|from_middle| Lump { part: 0.5, from_middle, variance: 0.0 });
        let found = unlike_normal(&lumps, 1.0 / 3.0);
        // Midpoints over normal k, in x and in the square of what is across it.
        let q = FRINGES * 3f64.sqrt();
        let (n, mut sum) = (400, 0.0);
        for i in 0..n {
            let x = 12.0 * (f64::from(i) + 0.5) / f64::from(n) - 6.0;
            let weight = (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt() * 12.0 / f64::from(n);
            for j in 0..n {
                let across2 = -2.0 * ((f64::from(j) + 0.5) / f64::from(n)).ln();
                let normal = (-(x * x + across2) * q * q / 6.0).exp();
                sum += weight / f64::from(n) * ((q * x).cos() - normal).powi(2);
            }
        }
        assert!((found / sum - 1.0).abs() < 2e-3, "{found} {sum}");
    }

    #[test]
    fn what_is_normal_has_no_grains_and_what_is_long_has() {
        let one = Lump { part: 1.0, from_middle: DVec3::ZERO, variance: 2.0 };
        assert!(unlike_normal(&[one], 2.0) < 1e-12);
        let cube = of_box([X, DVec3::Y, DVec3::Z]);
        let slab = of_box([X, DVec3::Y, 0.01 * DVec3::Z]);
        let rod = of_box([X, 0.01 * DVec3::Y, 0.01 * DVec3::Z]);
        assert!(cube < 0.01 && cube < slab && slab < rod && rod < 0.5, "{cube} {slab} {rod}");
    }
}
