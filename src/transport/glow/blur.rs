//! Phase functions blurred over the angle that a cluster fills: what its droplets scatter on average, and how much they
//! differ.
//!
//! Legend: h = 1 - cos theta; s = sin(theta/2) from the nearer end, so that both the forward peak and the glory are resolved;
//! alpha^2, variance per axis of the directions in which a cluster's droplets lie; V, variance of p over these directions
//! over the square of its mean; D, mean square over them of what twice the variance changes, over the same. Theory (62),
//! (140).

use super::rows::{Rows, weighted};

/// Blurred tables grow by sqrt(2) in alpha from one to the next, so that each is the one before blurred by as much again.
const LEVEL_RATIO: f64 = 2.0;

/// The narrowest blur, in steps of the sharp table.
const FIRST_BLUR: f64 = 3.0;

/// Steps of a blurred table per alpha: a parabola through three points is missed by alpha^2 p'' / 72.
const STEPS_PER_BLUR: f64 = 3.0;

/// Largest alpha^2; a wider cluster is around the point that looks at it.
const WIDEST: f64 = 1.0;

/// Most entries of the sharp table on either side of 90 degrees.
const MOST_STEPS: f64 = 131_072.0;

/// Tables of several functions of the angle at once, sharp and blurred.
pub(super) struct BlurTable {
    n_channels: usize,
    levels: Vec<Level>,
    /// One row per entry: the functions.
    values: Vec<f32>,
    /// One per entry, of the leading function.
    lead: Vec<Lead>,
    /// One over the first blurred level's alpha^2, times the root of a half step between levels.
    per_variance: f32,
}

/// What decisions need of a function at an angle.
#[derive(Clone, Copy, Debug, Default)]
struct Lead {
    value: f32,
    /// V.
    spread: f32,
    /// D.
    unsure: f32,
    /// Change with h over the value.
    slope: f32,
}

/// One table: entries for the forward half, then for the backward half.
#[derive(Clone, Copy, Debug)]
struct Level {
    first: u32,
    per_side: u32,
    /// Entries per s.
    steps_per_s: f32,
}

/// A place in the tables: between an entry and the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spot {
    pub entry: u32,
    pub part: f32,
}

/// Finest angle that functions with the given largest value need resolved, rad: a 24th of the forward peak's radius,
/// whose solid angle is about 1 / (2 p_max). Fringes are about three times as wide; between entries tables are linear, and
/// with half as many entries single droplets are off by 2 % in their dark fringes.
pub(super) fn step_for(largest_value: f64) -> f64 {
    (1.0 / (2.0 * std::f64::consts::PI * largest_value).sqrt() / 24.0).clamp(1.0 / MOST_STEPS, 0.02)
}

/// Bytes that tables of so many functions take while they are made, about and rather too many; `x` is the largest size parameter. The forward peak
/// of such a sphere is x^2 / 8 pi high, since half of its light lies in it. All levels together have 4.4 times the sharp one's rows, and room to grow;
/// three levels at a time are there in double precision.
pub(super) fn predicted_bytes(x: f64, n_channels: usize) -> u64 {
    let (rows, n) = (8f64.sqrt() / step_for(x * x / (8.0 * std::f64::consts::PI)), n_channels as f64);
    let kept = 5.4 * rows * (4.0 * n + size_of::<Lead>() as f64);
    let working = 3.0 * rows * 8.0 * (n + 1.0);
    (kept + working) as u64
}

impl BlurTable {
    /// Tables of what `eval` fills in at h, on a grid of `step_rad`; `shares` weigh the first of them in
    /// the leading one, on which decisions rest.
    pub fn new(step_rad: f64, n_channels: usize, shares: &[f64], eval: impl Fn(f64, &mut [f64])) -> Self {
        let first_variance = (FIRST_BLUR * step_rad).powi(2);
        let per_variance = (1.0 / first_variance * LEVEL_RATIO.sqrt()) as f32;
        let mut tables = Self { n_channels, levels: Vec::new(), values: Vec::new(), lead: Vec::new(), per_variance };
        let sharp = Rows::sharp(step_rad, n_channels, shares, eval);
        let (mut rows, mut alpha) = (Rows::blurred(&sharp, first_variance.sqrt(), step_rad), first_variance.sqrt());
        let mut change = Rows::change(&sharp, &rows, shares, alpha);
        tables.push(&sharp, shares, [&rows, &change]);
        loop {
            tables.push(&rows, shares, [&rows, &change]);
            if alpha * alpha >= WIDEST {
                return tables;
            }
            // Seven points at once would be too far apart: 14 % too much in the middle of what is narrower than the blur.
            let (half, step_rad) = (alpha * 0.5f64.sqrt(), alpha / STEPS_PER_BLUR);
            let wider = Rows::blurred(&Rows::blurred(&rows, half, step_rad), half, step_rad);
            alpha *= LEVEL_RATIO.sqrt();
            change = Rows::change(&rows, &wider, shares, alpha);
            rows = wider;
        }
    }

    /// Adds a table; `doubts` are the blurred table whose mean squares tell V and that by whose blur functions changed.
    fn push(&mut self, rows: &Rows, shares: &[f64], [blurred, change]: [&Rows; 2]) {
        self.levels.push(Level {
            first: self.lead.len() as u32,
            per_side: rows.per_side as u32,
            steps_per_s: (1.0 / rows.step_s) as f32,
        });
        let mean = |i: usize| weighted(&rows.row(i)[..self.n_channels], shares, |p| p);
        for i in 0..2 * rows.per_side {
            let values = &rows.row(i)[..self.n_channels];
            let [mut mean_row, mut changed] = [vec![0.0; blurred.stride], vec![0.0]];
            blurred.add(rows.h(i), 1.0, &mut mean_row);
            change.add(rows.h(i), 1.0, &mut changed);
            let even = weighted(&mean_row[..self.n_channels], shares, |p| p * p);
            let over_even = |square: f64| if even > 0.0 { square / even } else { 0.0 };
            let (value, [below, above]) = (mean(i), rows.neighbours(i));
            let slope = (mean(above) - mean(below)) / (rows.h(above) - rows.h(below));
            self.lead.push(Lead {
                value: value as f32,
                spread: (over_even(mean_row[self.n_channels]) - 1.0).max(0.0) as f32,
                unsure: over_even(changed[0]) as f32,
                slope: if value > 0.0 { (slope / value) as f32 } else { 0.0 },
            });
            self.values.extend(values.iter().map(|value| *value as f32));
        }
    }

    /// Where to look for h, blurred by alpha^2.
    #[inline(always)]
    pub fn spot(&self, h: f32, variance: f32) -> Spot {
        // The exponent of the ratio is its logarithm: 0 below the first level's reach, then one per level.
        let ratio = variance * self.per_variance;
        let exponent = (ratio.to_bits() >> 23) as i32 - 126;
        let index = exponent.clamp(0, self.levels.len() as i32 - 1) as usize;
        self.levels[index].spot(h)
    }

    /// Number of entries of all tables.
    pub fn len(&self) -> usize {
        self.lead.len()
    }

    /// The functions of all entries, one row per entry.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// Number of entries of the sharp table.
    pub fn sharp_len(&self) -> usize {
        2 * self.levels[0].per_side as usize
    }

    /// h of every entry of the sharp table.
    pub fn sharp_h(&self) -> impl Iterator<Item = f64> {
        let Level { per_side, steps_per_s, .. } = self.levels[0];
        let h = move |i: u32| 2.0 * (f64::from(i) / f64::from(steps_per_s)).powi(2);
        (0..per_side).map(h).chain((0..per_side).map(move |i| 2.0 - h(i)))
    }

    /// The leading function.
    #[inline(always)]
    pub fn lead(&self, spot: Spot) -> f32 {
        let i = spot.entry as usize;
        let (a, b) = (self.lead[i].value, self.lead[i + 1].value);
        a + spot.part * (b - a)
    }

    /// V and D of the functions blurred by alpha^2, by their own variances: between wavelengths they do not cancel.
    #[inline(always)]
    pub fn doubt(&self, spot: Spot, variance: f32) -> [f32; 2] {
        let (a, b) = (self.lead[spot.entry as usize], self.lead[spot.entry as usize + 1]);
        // The sharp table has those of the first blurred one, which grow with alpha^2 and its square.
        let part = (variance * self.per_variance).min(1.0);
        [part * a.spread.max(b.spread), part * part * a.unsure.max(b.unsure)]
    }

    /// Change with h of the leading function, over it.
    #[inline(always)]
    pub fn slope(&self, spot: Spot) -> f32 {
        let i = spot.entry as usize;
        let (a, b) = (self.lead[i].slope, self.lead[i + 1].slope);
        a + spot.part * (b - a)
    }

    /// The rows between which a spot lies.
    #[inline(always)]
    pub fn rows(&self, spot: Spot) -> (&[f32], &[f32]) {
        let start = spot.entry as usize * self.n_channels;
        self.values[start..start + 2 * self.n_channels].split_at(self.n_channels)
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + size_of_val(&self.lead[..])
    }
}

impl Level {
    #[inline(always)]
    fn spot(&self, h: f32) -> Spot {
        let nearer = h.min(2.0 - h).max(0.0);
        let place = (0.5 * nearer).sqrt() * self.steps_per_s;
        let step = (place as u32).min(self.per_side - 2);
        let side = if h > 1.0 { self.per_side } else { 0 };
        Spot { entry: self.first + side + step, part: place - step as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::phase_function::PhaseFunction;

    fn table(g: f64) -> (BlurTable, PhaseFunction) {
        let phase = PhaseFunction::henyey_greenstein(g);
        let step = step_for(phase.max_value());
        (BlurTable::new(step, 1, &[1.0], |h, row| row[0] = phase.eval(h)), phase)
    }

    #[test]
    fn the_sharp_table_is_the_function() {
        for g in [0.0, 0.7, -0.5, 0.95] {
            let (table, phase) = table(g);
            for i in 0..=1000 {
                let h = 2.0 * f64::from(i) / 1000.0;
                let found = f64::from(table.lead(table.spot(h as f32, 0.0)));
                assert!((found / phase.eval(h) - 1.0).abs() < 3e-3, "g {g}, h {h}: {found} {}", phase.eval(h));
            }
        }
    }

    /// The nearest alpha of a table, which stand at powers of two of alpha^2.
    fn at_a_level(table: &BlurTable, alpha: f64) -> f64 {
        let level = (alpha * alpha * f64::from(table.per_variance) / 2f64.sqrt()).log2().round();
        (level.exp2() / f64::from(table.per_variance) * 2f64.sqrt()).sqrt()
    }

    /// The mean of HG over a normal distribution of directions about its axis, by quadrature in the plane.
    #[test]
    fn a_blurred_table_is_the_mean_over_directions() {
        let (table, phase) = table(0.9);
        for alpha in [0.03f64, 0.1, 0.3] {
            let alpha = at_a_level(&table, alpha);
            let n = 4000;
            let mean: f64 = (0..n)
                .map(|i| {
                    let theta = alpha * (-2.0 * ((f64::from(i) + 0.5) / f64::from(n)).ln()).sqrt();
                    phase.eval(1.0 - theta.cos())
                })
                .sum::<f64>()
                / f64::from(n);
            let found = f64::from(table.lead(table.spot(0.0, (alpha * alpha) as f32)));
            // Seven points instead of a normal distribution, level after level: 3 % where the peak is as wide as the blur.
            assert!((found / mean - 1.0).abs() < 0.05, "alpha {alpha}: {found} {mean}");
        }
    }

    /// Rationale: over a cluster the mean of a product of two functions is not that of their means; what is left at
    /// second order is in their slopes (142). Expected: the mean by quadrature over a normal distribution, within what is of
    /// fourth order.
    #[test]
    fn slopes_tell_what_two_functions_have_in_common() {
        use glam::DVec3;
        let (table, phase) = table(0.7);
        let e = DVec3::Z;
        let (l, m) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.3, 0.4, 0.75).normalize());
        let alpha = at_a_level(&table, 0.05);
        let (n, mut mean) = (200, 0.0);
        let quantiles = || (0..n).map(|i| alpha * (-2.0 * ((f64::from(i) + 0.5) / f64::from(n)).ln()).sqrt());
        for rho in quantiles() {
            for k in 0..n {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
                let to = DVec3::new(rho.sin() * cos, rho.sin() * sin, rho.cos());
                let h = |axis: DVec3| 0.5 * (to - axis).length_squared();
                mean += phase.eval(h(l)) * phase.eval(h(m)) / f64::from(n * n);
            }
        }
        let variance = (alpha * alpha) as f32;
        let h = |axis: DVec3| (0.5 * (e - axis).length_squared()) as f32;
        let (p, q) = (table.spot(h(l), variance), table.spot(h(m), variance));
        let apart = f64::from(table.lead(p) * table.lead(q));
        let across = l.dot(m) - f64::from((1.0 - h(l)) * (1.0 - h(m)));
        let together = f64::from(variance * table.slope(p) * table.slope(q)) * across;
        assert!(together > 0.01, "{together}");
        assert!((apart * (1.0 + together) / mean - 1.0).abs() < 0.2 * together, "{apart} {together} {mean}");
    }

    #[test]
    fn an_even_function_has_no_spread_and_any_blur_keeps_it() {
        let (table, _) = table(0.0);
        for (h, variance) in [(0.0, 1e-9), (1.0, 1e-3), (2.0, 0.5), (0.7, 7.0)] {
            let spot = table.spot(h, variance);
            assert!((table.lead(spot) * 4.0 * std::f32::consts::PI - 1.0).abs() < 1e-5);
            assert!(table.doubt(spot, variance).iter().all(|doubt| *doubt < 1e-5) && table.slope(spot).abs() < 1e-4);
        }
    }
}
