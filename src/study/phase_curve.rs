//! A phase function at the angles a plot needs: the forward and backward peaks, the bows, and every fringe if it can.

use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};

use super::scatterer::Scatterer;
use crate::mie::MieError;

/// A phase function over the scattering angle.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseCurve {
    /// Scattering angles, degrees, increasing; from 0 to 180 unless less was asked for.
    pub theta_deg: Vec<f64>,
    /// Phase function, sr^-1.
    pub phase: Vec<f64>,
    /// The phase function times the degree of linear polarisation -S12/S11, sr^-1.
    pub polarized: Vec<f64>,
    /// Distance of the fringes, degrees: pi / x of one sphere. A distribution has none.
    pub fringe_deg: Option<f64>,
    /// Half width of the forward peak, degrees: about 1 / x.
    pub peak_deg: f64,
}

/// Step over most angles, degrees: half a line's width in a plot of 900 points.
const LONGEST_STEP_DEG: f64 = 0.1;

/// Points per fringe: enough to find its height within a few per cent.
const POINTS_PER_FRINGE: f64 = 8.0;

/// Most points.
const MAX_POINTS: usize = 80_000;

/// Points that every curve has, however long they take: one for each line's width.
const ALWAYS_POINTS: usize = 900;

/// Partial waves times angles that a curve may cost: a few seconds on one core.
const BUDGET: f64 = 8e9;

/// Partial waves above which a distribution is averaged anew with fewer radii.
const MANY_TERMS: f64 = 2e6;

/// Points in each of the two peaks, spaced evenly in the logarithm of the distance from the axis.
const PEAK_POINTS: usize = 160;

/// Rings around the axis are followed to this multiple of 1/x, which the inset of a plot shows, with so many points.
const RINGS_END: f64 = 50.0;
const RING_POINTS: usize = 200;

/// The peaks' points reach from this share of 1/x to [`PEAK_END_DEG`].
const PEAK_START: f64 = 0.02;

/// Where the peaks' points end, degrees from the axis.
const PEAK_END_DEG: f64 = 15.0;

impl Scatterer {
    /// The phase function from 0 to 180 degrees, at angles of its own choosing; `None` where nothing is scattered.
    ///
    /// # Errors
    /// None in practice: the scatterer has been solved already.
    pub fn curve(&self) -> Result<Option<PhaseCurve>, MieError> {
        self.curve_between([0.0, 180.0])
    }

    /// The same from one angle to another, degrees in 0 ..= 180, with as many points or fewer.
    ///
    /// # Errors
    /// When the angles are out of range.
    pub fn curve_between(&self, range_deg: [f64; 2]) -> Result<Option<PhaseCurve>, MieError> {
        let coarse = if self.terms() > MANY_TERMS { Some(self.for_picture()?) } else { None };
        let source = coarse.as_ref().unwrap_or(self);
        let Some(scale) = source.phase_scale() else { return Ok(None) };
        let x = source.size_parameter();
        let peak_deg = (1.0 / x).to_degrees();
        let fringe_deg = matches!(self, Self::Sphere(_)).then_some(PI * peak_deg);
        let theta_deg = angles(range_deg, peak_deg, fringe_deg, source.terms());
        let theta_rad: Vec<f64> = theta_deg.iter().map(|deg| deg.to_radians()).collect();
        let matrices = source.matrices(&theta_rad)?;
        Ok(Some(PhaseCurve {
            phase: matrices.iter().map(|m| scale * m.s11).collect(),
            polarized: matrices.iter().map(|m| -scale * m.s12).collect(),
            theta_deg,
            fringe_deg,
            peak_deg,
        }))
    }
}

/// Even steps with finer ones toward both ends.
fn angles([from, to]: [f64; 2], peak_deg: f64, fringe_deg: Option<f64>, terms: f64) -> Vec<f64> {
    let span = to - from;
    let longest = LONGEST_STEP_DEG * span / 180.0;
    let step = fringe_deg.map_or(longest, |fringe| (fringe / POINTS_PER_FRINGE).min(longest));
    let affordable = ((BUDGET / terms) as usize).clamp(ALWAYS_POINTS, MAX_POINTS);
    let count = ((span / step).ceil() as usize).min(affordable);
    // Steps that miss fringes would beat with them, were they even: each point is anywhere in its step.
    let misses_fringes = fringe_deg.is_some_and(|fringe| span / count as f64 > fringe / POINTS_PER_FRINGE * 1.5);
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(0);
    let mut moved = |i: usize| if misses_fringes && i > 0 && i < count { rng.random::<f64>() - 0.5 } else { 0.0 };
    let even = (0..=count).map(|i| from + span * (i as f64 + moved(i)) / count as f64);
    let start = (PEAK_START * peak_deg).min(0.1 * PEAK_END_DEG);
    let ratio = PEAK_END_DEG / start;
    let peak = (0..PEAK_POINTS).map(|i| start * ratio.powf(i as f64 / (PEAK_POINTS - 1) as f64));
    let rings_end = (RINGS_END * peak_deg).min(PEAK_END_DEG);
    let rings = (1..=RING_POINTS).map(|i| rings_end * i as f64 / RING_POINTS as f64);
    let peak = peak.chain(rings);
    let mut all: Vec<f64> = even.chain(peak.clone()).chain(peak.map(|deg| 180.0 - deg)).collect();
    all.retain(|deg| (from..=to).contains(deg));
    all.extend([from, to]);
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    fn sphere(x: f64, n: f64) -> Scatterer {
        Scatterer::relative_sphere(x, Complex64::new(n, 0.0)).unwrap()
    }

    #[test]
    fn a_curve_holds_all_the_light() {
        for x in [0.01, 1.0, 30.0, 1000.0] {
            let curve = sphere(x, 1.33).curve().unwrap().unwrap();
            assert_eq!((curve.theta_deg[0], *curve.theta_deg.last().unwrap()), (0.0, 180.0));
            let nodes: Vec<(f64, f64)> =
                curve.theta_deg.iter().zip(&curve.phase).map(|(deg, p)| (-deg.to_radians().cos(), *p)).collect();
            let total: f64 = nodes.windows(2).map(|w| PI * (w[1].0 - w[0].0) * (w[0].1 + w[1].1)).sum();
            // The trapezoidal rule with eight points per fringe or more.
            assert!((total - 1.0).abs() < 5e-3, "{x}: {total}");
        }
    }

    #[test]
    fn large_spheres_cost_no_more_than_the_budget() {
        let theta = angles([0.0, 180.0], 1e-4, Some(PI * 1e-4), 1e6);
        assert!(theta.len() < 9000, "{}", theta.len());
        assert!(theta.windows(2).all(|w| w[0] < w[1]));
    }

    /// Even steps of 4.2 fringes show 0.1 fringes per step instead: means over such beats are those of a few points.
    #[test]
    fn steps_do_not_beat_with_fringes_that_they_miss() {
        let fringe = 180.0 / 1e5;
        let theta = angles([0.0, 180.0], fringe / PI, Some(fringe), 1e5);
        // Fringes of any order: the mean of their cosine over a drawn column is none, within its scatter.
        for harmonic in 1..=4 {
            let phase = |deg: &f64| (2.0 * PI * f64::from(harmonic) * deg / fringe).cos();
            for column in 20..740 {
                let inside = |deg: &&f64| (**deg * 768.0 / 180.0).floor() == f64::from(column);
                let values: Vec<f64> = theta.iter().filter(inside).map(phase).collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                // Four standard errors of the mean of numbers of variance 1/2, once more for 2880 of them.
                assert!(mean.abs() < 5.0 * (0.5 / values.len() as f64).sqrt(), "{harmonic} {column}: {mean}");
            }
        }
    }

    #[test]
    fn close_ups_have_the_asked_angles_and_finer_steps() {
        let curve = sphere(300.0, 1.33).curve_between([135.0, 145.0]).unwrap().unwrap();
        assert_eq!((curve.theta_deg[0], *curve.theta_deg.last().unwrap()), (135.0, 145.0));
        assert!(curve.theta_deg.windows(2).all(|w| w[0] < w[1] && w[1] - w[0] < 0.0056), "{:?}", curve.theta_deg);
        // The same function, whatever is shown of it.
        let whole = sphere(300.0, 1.33).curve().unwrap().unwrap();
        let highest = |curve: &PhaseCurve| {
            let inside = curve.theta_deg.iter().zip(&curve.phase).filter(|(deg, _)| (135.0..=145.0).contains(*deg));
            inside.map(|(_, phase)| *phase).fold(0.0, f64::max)
        };
        assert!((highest(&curve) / highest(&whole) - 1.0).abs() < 0.01);
    }

    #[test]
    fn nothing_scattered_has_no_curve() {
        assert_eq!(sphere(10.0, 1.0).curve(), Ok(None));
    }
}
