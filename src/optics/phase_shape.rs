//! Slopes for cubics through ln p: smooth where the nodes were chosen for it, monotone where they were given.

/// How a table is drawn through its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// A cubic spline: fourth order, for nodes that adaptive refinement has placed.
    Spline,
    /// Rises and falls only where the values do (Fritsch & Butland 1984), for nodes that someone else has chosen.
    Monotone,
}

/// d ln p / ds at the nodes; at s = 0 it vanishes, because p is even in theta.
pub(super) fn ln_slopes(s: &[f64], y: &[f64], interpolation: Interpolation) -> Vec<f64> {
    match interpolation {
        Interpolation::Spline if s.len() > 3 => spline_slopes(s, y),
        _ => monotone_slopes(s, y),
    }
}

/// The clamped cubic spline: continuous second derivative; the slope is 0 at the first node and that of the parabola
/// through the last three at the last.
fn spline_slopes(s: &[f64], y: &[f64]) -> Vec<f64> {
    let n = s.len();
    let (h, secant) = differences(s, y);
    let last = end_slope(h[n - 2], h[n - 3], secant[n - 2], secant[n - 3]);
    // Thomas algorithm for h_i d_{i-1} + 2 (h_{i-1} + h_i) d_i + h_{i-1} d_{i+1} = 3 (h_i e_{i-1} + h_{i-1} e_i).
    let (mut upper, mut slopes) = (vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let pivot = 2.0 * (h[i - 1] + h[i]) - h[i] * upper[i - 1];
        upper[i] = h[i - 1] / pivot;
        let right = 3.0 * (h[i] * secant[i - 1] + h[i - 1] * secant[i]);
        slopes[i] = (right - h[i] * slopes[i - 1]) / pivot;
    }
    slopes[n - 1] = last;
    for i in (1..n - 1).rev() {
        slopes[i] -= upper[i] * slopes[i + 1];
    }
    slopes
}

/// Weighted harmonic means of the neighbouring secants; zero at extrema (Fritsch & Butland 1984).
fn monotone_slopes(s: &[f64], y: &[f64]) -> Vec<f64> {
    let n = s.len();
    let (h, secant) = differences(s, y);
    let mut slopes = vec![0.0; n];
    for i in 1..n - 1 {
        let (before, after) = (secant[i - 1], secant[i]);
        if before * after > 0.0 {
            let (w1, w2) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
            slopes[i] = (w1 + w2) / (w1 / before + w2 / after);
        }
    }
    let last = if n > 2 { end_slope(h[n - 2], h[n - 3], secant[n - 2], secant[n - 3]) } else { secant[0] };
    // Three times the secant is the limit of monotone cubics (Fritsch & Carlson 1980).
    let bound = 3.0 * secant[n - 2];
    slopes[n - 1] = if last * bound <= 0.0 {
        0.0
    } else if last.abs() > bound.abs() {
        bound
    } else {
        last
    };
    slopes
}

fn differences(s: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let h: Vec<f64> = s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let secant = y.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    (h, secant)
}

/// Slope at the end of the parabola through three points.
fn end_slope(h_end: f64, h_next: f64, secant_end: f64, secant_next: f64) -> f64 {
    ((2.0 * h_end + h_next) * secant_end - h_end * secant_next) / (h_end + h_next)
}
