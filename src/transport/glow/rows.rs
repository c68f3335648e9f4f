//! Tables of phase functions in the making, in f64: evaluated, and blurred one from the other.
//!
//! Legend as in `blur`: h = 1 - cos theta; s = sin(theta/2) from the nearer end. Theory (62), (140).

/// A normal distribution in the plane as seven points: radius over sigma, sin^2 of half the azimuth, weight. Exact to
/// the fifth degree (Abramowitz & Stegun 1964, 25.4.63 in shape).
const HEXAGON: [(f64, f64, f64); 5] =
    [(0.0, 0.0, 0.5), (2.0, 0.0, 1.0 / 12.0), (2.0, 0.25, 2.0 / 12.0), (2.0, 0.75, 2.0 / 12.0), (2.0, 1.0, 1.0 / 12.0)];

/// Mean of a function of the first values, by their shares.
pub(super) fn weighted(values: &[f64], shares: &[f64], of: impl Fn(f64) -> f64) -> f64 {
    values.iter().zip(shares).map(|(value, share)| share * of(*value)).sum()
}

/// One table in the making, in f64: rows of the functions and of the weighted mean of their squares.
pub(super) struct Rows {
    pub step_s: f64,
    /// Entries on either side of 90 degrees.
    pub per_side: usize,
    pub stride: usize,
    rows: Vec<f64>,
}

impl Rows {
    fn empty(step_rad: f64, stride: usize) -> Self {
        // s is half of theta at either end.
        let step_s = 0.5 * step_rad;
        let per_side = (0.5f64.sqrt() / step_s).ceil() as usize + 2;
        Self { step_s, per_side, stride, rows: vec![0.0; 2 * per_side * stride] }
    }

    pub fn sharp(step_rad: f64, n_channels: usize, shares: &[f64], eval: impl Fn(f64, &mut [f64])) -> Self {
        let mut table = Self::empty(step_rad, n_channels + 1);
        for index in 0..2 * table.per_side {
            let h = table.h(index);
            let row = &mut table.rows[index * table.stride..(index + 1) * table.stride];
            eval(h, &mut row[..n_channels]);
            row[n_channels] = weighted(&row[..n_channels], shares, |p| p * p);
        }
        table
    }

    /// A table blurred by the standard deviation `sigma`, rad.
    pub fn blurred(sharper: &Self, sigma: f64, step_rad: f64) -> Self {
        let mut table = Self::empty(step_rad, sharper.stride);
        for index in 0..2 * table.per_side {
            let h = table.h(index);
            let theta = 2.0 * (0.5 * h).sqrt().min(1.0).asin();
            let (start, end) = (index * table.stride, (index + 1) * table.stride);
            for (radius, half_azimuth, weight) in HEXAGON {
                let rho = radius * sigma;
                // Haversines do not cancel: hav c = hav(a - b) + sin a sin b hav C.
                let hav = (0.5 * (theta - rho)).sin().powi(2) + theta.sin() * rho.sin() * half_azimuth;
                sharper.add(2.0 * hav, weight, &mut table.rows[start..end]);
            }
        }
        table
    }

    /// Mean square over a cluster's directions of what its functions change from a blur to the next, `alpha`: one number
    /// per entry of the next.
    pub fn change(sharper: &Self, wider: &Self, shares: &[f64], alpha: f64) -> Self {
        let mut squares = Self { rows: vec![0.0; 2 * sharper.per_side], stride: 1, ..*sharper };
        let mut at = vec![0.0; wider.stride];
        for index in 0..2 * sharper.per_side {
            at.fill(0.0);
            wider.add(sharper.h(index), 1.0, &mut at);
            at.iter_mut().zip(sharper.row(index)).for_each(|(wide, sharp)| *wide -= sharp);
            squares.rows[index] = weighted(&at, shares, |change| change * change);
        }
        let (half, step_rad) = (alpha * 0.5f64.sqrt(), 2.0 * wider.step_s);
        Self::blurred(&Self::blurred(&squares, half, step_rad), half, step_rad)
    }

    pub fn row(&self, index: usize) -> &[f64] {
        &self.rows[index * self.stride..(index + 1) * self.stride]
    }

    /// The entries on either side of one, or itself at an end of its half.
    pub fn neighbours(&self, index: usize) -> [usize; 2] {
        let first = index / self.per_side * self.per_side;
        [index.saturating_sub(1).max(first), (index + 1).min(first + self.per_side - 1)]
    }

    pub fn h(&self, index: usize) -> f64 {
        let forward = index < self.per_side;
        let s = (index % self.per_side) as f64 * self.step_s;
        if forward { 2.0 * s * s } else { 2.0 - 2.0 * s * s }
    }

    /// Adds `weight` times the interpolated row at h.
    pub fn add(&self, h: f64, weight: f64, out: &mut [f64]) {
        let place = (0.5 * h.min(2.0 - h).max(0.0)).sqrt() / self.step_s;
        let step = (place as usize).min(self.per_side - 2);
        let part = place - step as f64;
        let side = if h > 1.0 { self.per_side } else { 0 };
        let start = (side + step) * self.stride;
        let (low, high) = self.rows[start..start + 2 * self.stride].split_at(self.stride);
        for ((out, low), high) in out.iter_mut().zip(low).zip(high) {
            *out += weight * (low + part * (high - low));
        }
    }
}
