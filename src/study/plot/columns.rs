//! A curve gathered in columns as wide as a line: what is drawn where fringes are finer than that.

use crate::study::phase_curve::PhaseCurve;

/// A column of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Middle, degrees.
    pub theta_deg: f64,
    /// Smallest and largest phase function, sr^-1.
    pub low: f64,
    pub high: f64,
    /// Mean phase function, sr^-1.
    pub mean: f64,
    /// Degree of polarisation of the mean.
    pub degree: f64,
}

/// Gathers a curve in `count` columns; columns without points are left out.
///
/// Means are taken over the angle by the trapezoidal rule, so that points may be spaced unevenly.
pub fn gather(curve: &PhaseCurve, count: usize) -> Vec<Column> {
    let (from, to) =
        (curve.theta_deg.first().copied().unwrap_or(0.0), curve.theta_deg.last().copied().unwrap_or(180.0));
    let width = (to - from) / count as f64;
    let place = |deg: f64| ((deg - from) / width).floor();
    let mut columns = Vec::with_capacity(count);
    let mut start = 0;
    while start < curve.theta_deg.len() {
        let column = place(curve.theta_deg[start]);
        let inside = curve.theta_deg[start..].iter().take_while(|deg| place(**deg) == column).count();
        columns.push(one(curve, start..start + inside));
        start += inside;
    }
    smooth(&mut columns);
    columns
}

/// Smooths the means by weights 1, 2, 1: a column does not hold a whole number of fringes, so neighbours alternate.
/// The phase function is smoothed in its logarithm, or the forward peak would spread.
fn smooth(columns: &mut [Column]) {
    let before = columns.to_vec();
    for (column, near) in columns.iter_mut().skip(1).zip(before.windows(3)) {
        let mean =
            |value: &dyn Fn(&Column) -> f64| 0.25 * value(&near[0]) + 0.5 * value(&near[1]) + 0.25 * value(&near[2]);
        column.degree = mean(&|c| c.degree);
        if near.iter().all(|c| c.mean > 0.0) {
            column.mean = mean(&|c| c.mean.ln()).exp();
        }
    }
}

fn one(curve: &PhaseCurve, points: std::ops::Range<usize>) -> Column {
    let theta = &curve.theta_deg;
    let weight = |i: usize| 0.5 * (theta[(i + 1).min(theta.len() - 1)] - theta[i.saturating_sub(1)]);
    let total: f64 = points.clone().map(weight).sum();
    let mean = |values: &[f64]| points.clone().map(|i| weight(i) * values[i]).sum::<f64>() / total;
    let phase = &curve.phase[points.clone()];
    let average = mean(&curve.phase);
    Column {
        theta_deg: mean(theta),
        low: phase.iter().copied().fold(f64::INFINITY, f64::min),
        high: phase.iter().copied().fold(0.0, f64::max),
        mean: average,
        degree: if average > 0.0 { mean(&curve.polarized) / average } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_enclose_the_curve_and_keep_its_mean() {
        let theta_deg: Vec<f64> = (0..=1800).map(|i| f64::from(i) / 10.0).collect();
        let phase: Vec<f64> = theta_deg.iter().map(|deg| 2.0 + deg.to_radians().cos() + (deg * 20.0).sin()).collect();
        let polarized = phase.iter().map(|p| -0.5 * p).collect();
        let curve = PhaseCurve { theta_deg, phase, polarized, fringe_deg: Some(0.3), peak_deg: 0.1 };
        let columns = gather(&curve, 90);
        assert_eq!(columns.len(), 91, "180 degrees begins a column of its own");
        assert!(columns.iter().all(|c| (c.degree + 0.5).abs() < 1e-12));
        for column in &columns[1..90] {
            assert!(column.low < column.mean && column.mean < column.high, "{column:?}");
            // Fringes of height 1 on 2 + cos: what is left of them is the share of a fringe that ends a column.
            let exact = 2.0 + column.theta_deg.to_radians().cos();
            assert!((column.mean / exact - 1.0).abs() < 0.2, "{column:?}");
        }
        let highest = columns.iter().map(|c| c.high).fold(0.0, f64::max);
        assert_eq!(highest, curve.phase.iter().copied().fold(0.0, f64::max));
    }
}
