//! A tabulated phase function: cubics in ln p between nodes, and the exact inverse of what they integrate to.
//!
//! Legend: s = sin(theta/2) = sqrt(h/2) in [0, 1], in which both the forward peak and the backward angles are smooth;
//! a cell lies between two nodes of s, z in [0, 1] within it; the probability of ds is 8 pi s p(s) ds.

use std::f64::consts::PI;

use super::phase_cell::{Cell, RULE, hermite, push_split};
use super::phase_shape::{Interpolation, ln_slopes};

/// Values below this fraction of the largest are raised to it: a logarithm needs one above zero.
const FLOOR: f64 = 1e-30;

/// Nodes closer than this are one: the cap of that size holds less than 1e-58 sr.
const CLOSEST_S: f64 = 1e-30;

/// A phase function tabulated over the scattering angle, normalised to 1 over the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTable {
    /// The cells and one more that holds the end: s = 1, cdf = 1.
    cells: Vec<Cell>,
    /// p is this times the exponential of the cell's cubic, sr^-1.
    scale: f64,
    /// The cell that holds the lower end of each of equal parts of s.
    guide_s: Vec<u32>,
    /// The same for equal parts of the probability.
    guide_cdf: Vec<u32>,
    mean_cosine: f64,
    max_value: f64,
}

impl PhaseTable {
    /// A table through values at scattering angles in rad that increase from 0 to pi; values in any unit, >= 0.
    ///
    /// Between the angles ln p is a cubic that keeps to the values' rise and fall. `None` where there are fewer than two
    /// angles, they do not increase from 0 to pi, or no value is above zero and finite.
    pub fn from_samples(theta_rad: &[f64], values: &[f64]) -> Option<Self> {
        let is_increasing = theta_rad.windows(2).all(|pair| pair[0] < pair[1]);
        let (first, last) = (*theta_rad.first()?, *theta_rad.last()?);
        let spans = first == 0.0 && (last - PI).abs() < 1e-9;
        if theta_rad.len() != values.len() || !is_increasing || !spans {
            return None;
        }
        let s: Vec<f64> = theta_rad.iter().map(|theta| (0.5 * theta).sin()).collect();
        Self::from_nodes(s, values, Interpolation::Monotone)
    }

    /// How far the integral of a table as `from_samples` takes it may be off because its angles are far apart, relative: a third of what it changes by
    /// without every other angle, since the error falls with the square of their distance at least. `None` as there.
    pub fn step_error(theta_rad: &[f64], values: &[f64]) -> Option<f64> {
        let last = theta_rad.len().checked_sub(1)?;
        let every_other =
            |all: &[f64]| -> Vec<f64> { all.iter().step_by(2).chain(&all[last - last % 2 + 1..]).copied().collect() };
        let integral = |theta_rad: &[f64], values: &[f64]| {
            Some(values.iter().copied().fold(0.0, f64::max) / Self::from_samples(theta_rad, values)?.scale)
        };
        let whole = integral(theta_rad, values)?;
        // Half of the values may all be zero.
        let half = integral(&every_other(theta_rad), &every_other(values)).unwrap_or(0.0);
        Some((half / whole - 1.0).abs() / 3.0)
    }

    /// A table through values at nodes of s that increase from 0 to 1.
    pub(super) fn from_nodes(mut s: Vec<f64>, values: &[f64], interpolation: Interpolation) -> Option<Self> {
        let largest = values.iter().copied().fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite() && values.iter().all(|value| *value >= 0.0)) || s.len() < 2 {
            return None;
        }
        let mut y: Vec<f64> = values.iter().map(|value| (value / largest).max(FLOOR).ln()).collect();
        merge_close(&mut s, &mut y);
        let slopes = ln_slopes(&s, &y, interpolation);
        let mut cells = Vec::with_capacity(s.len());
        for i in 0..s.len() - 1 {
            let width = s[i + 1] - s[i];
            push_split(&mut cells, s[i], width, hermite(y[i], y[i + 1], width * slopes[i], width * slopes[i + 1]));
        }
        cells.push(Cell { s: 1.0, cdf: 1.0, ln_p: [0.0; 4] });
        Some(Self::integrate(cells))
    }

    /// Integrates the cells and normalises.
    fn integrate(mut cells: Vec<Cell>) -> Self {
        let (mut total, mut moment, mut largest) = (0.0, 0.0, f64::NEG_INFINITY);
        for i in 0..cells.len() - 1 {
            let (cell, end) = (cells[i], cells[i + 1].s);
            let weight = |z: f64, f: &dyn Fn(f64) -> f64| {
                let s = cell.s + z * (end - cell.s);
                8.0 * PI * s * cell.relative(z) * (end - cell.s) * f(s)
            };
            cells[i].cdf = total;
            total += RULE.iter().map(|(z, w)| w * weight(*z, &|_| 1.0)).sum::<f64>();
            moment += RULE.iter().map(|(z, w)| w * weight(*z, &|s| 2.0 * s * s)).sum::<f64>();
            largest = largest.max(cell.largest_ln());
        }
        let last = cells.len() - 1;
        cells[..last].iter_mut().for_each(|cell| cell.cdf /= total);
        let scale = 1.0 / total;
        Self {
            guide_s: guide(&cells, |cell| cell.s),
            guide_cdf: guide(&cells, |cell| cell.cdf),
            mean_cosine: 1.0 - moment * scale,
            max_value: scale * largest.exp(),
            cells,
            scale,
        }
    }

    /// Value at h = 1 - cos theta, sr^-1.
    #[inline]
    pub fn eval(&self, h: f64) -> f64 {
        let s = (0.5 * h).sqrt();
        let i = self.find(&self.guide_s, s, |cell| cell.s);
        let (s0, s1) = (self.cells[i].s, self.cells[i + 1].s);
        self.scale * self.cells[i].relative((s - s0) / (s1 - s0))
    }

    /// h = 1 - cos theta from a uniform number in [0, 1): the exact inverse of the integral of `eval`.
    #[inline]
    pub fn sample(&self, u: f64) -> f64 {
        let i = self.find(&self.guide_cdf, u, |cell| cell.cdf);
        let (cell, end) = (self.cells[i], self.cells[i + 1].s);
        let z = cell.invert(end, (u - cell.cdf) / self.scale);
        let s = cell.s + z * (end - cell.s);
        2.0 * s * s
    }

    /// Probability of scattering by less than h.
    pub fn cdf(&self, h: f64) -> f64 {
        let s = (0.5 * h).sqrt();
        let i = self.find(&self.guide_s, s, |cell| cell.s);
        let (cell, end) = (self.cells[i], self.cells[i + 1].s);
        (cell.cdf + self.scale * cell.mass_below(end, (s - cell.s) / (end - cell.s))).clamp(0.0, 1.0)
    }

    /// The function with its values below an angle in rad replaced by the value there, normalised, and the share of the
    /// light that this takes away; `None` where it takes nothing, or all, away.
    pub(super) fn without_peak(&self, angle_rad: f64) -> Option<(Self, f64)> {
        let s = (0.5 * angle_rad).sin();
        let h = 2.0 * s * s;
        let level = self.eval(h);
        let removed = self.cdf(h) - 2.0 * PI * h * level;
        // Less than the table's own rounding is no peak.
        if !(1e-6..1.0).contains(&removed) || s >= 1.0 {
            return None;
        }
        let i = self.find(&self.guide_s, s, |cell| cell.s);
        let flat = Cell { s: 0.0, cdf: 0.0, ln_p: [(level / self.scale).ln() as f32, 0.0, 0.0, 0.0] };
        let rest = self.cells[i].after(s, self.cells[i + 1].s);
        let cells = [flat, rest].into_iter().chain(self.cells[i + 1..].iter().copied()).collect();
        Some((Self::integrate(cells), removed))
    }

    /// The asymmetry parameter of the table, mean cos theta.
    pub fn mean_cosine(&self) -> f64 {
        self.mean_cosine
    }

    /// The largest value over all angles, sr^-1.
    pub fn max_value(&self) -> f64 {
        self.max_value
    }

    /// Appends the cells, little-endian: s and the cubic of each. What follows from them is not written.
    pub(super) fn write_bytes(&self, bytes: &mut Vec<u8>) {
        for cell in &self.cells[..self.cell_count()] {
            bytes.extend(cell.s.to_le_bytes());
            cell.ln_p.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
        }
    }

    /// Reads what `write_bytes` wrote; `None` where it cannot be a table.
    pub(super) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (rows, rest) = bytes.as_chunks::<24>();
        let mut cells = Vec::with_capacity(rows.len() + 1);
        for row in rows {
            let s = f64::from_le_bytes(row[..8].try_into().ok()?);
            let mut ln_p = [0.0f32; 4];
            for (value, bytes) in ln_p.iter_mut().zip(row[8..].as_chunks::<4>().0) {
                *value = f32::from_le_bytes(*bytes);
            }
            let follows = cells.last().map_or(s == 0.0, |last: &Cell| last.s < s && s < 1.0);
            if !follows || ln_p.iter().any(|value| !value.is_finite()) {
                return None;
            }
            cells.push(Cell { s, cdf: 0.0, ln_p });
        }
        if cells.is_empty() || !rest.is_empty() {
            return None;
        }
        cells.push(Cell { s: 1.0, cdf: 1.0, ln_p: [0.0; 4] });
        // A checksum does not vouch for the numbers: exponentials of them may overflow, or vanish altogether.
        Some(Self::integrate(cells)).filter(|table| {
            table.scale.is_finite() && table.scale > 0.0 && table.max_value.is_finite() && table.mean_cosine.is_finite()
        })
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() - 1
    }

    /// Memory outside the struct, bytes.
    pub fn heap_bytes(&self) -> usize {
        self.cells.len() * size_of::<Cell>() + (self.guide_s.len() + self.guide_cdf.len()) * size_of::<u32>()
    }

    /// The cell whose interval of `key` holds `value`: the guide names the first candidate and the last.
    #[inline]
    fn find(&self, guide: &[u32], value: f64, key: impl Fn(&Cell) -> f64) -> usize {
        let parts = guide.len() - 1;
        let part = ((value * parts as f64) as usize).min(parts - 1);
        let (mut low, mut high) = (guide[part] as usize, guide[part + 1] as usize + 1);
        while high - low > 1 {
            let middle = low.midpoint(high);
            if key(&self.cells[middle]) <= value { low = middle } else { high = middle }
        }
        low.min(self.cells.len() - 2)
    }
}

/// Removes nodes that rounding has put on one s, and those so close that slopes between them could overflow; 0 and 1 stay.
fn merge_close(s: &mut Vec<f64>, y: &mut Vec<f64>) {
    let last = s.len() - 1;
    (s[0], s[last]) = (0.0, 1.0);
    let keep: Vec<bool> = (0..=last).map(|i| i == last || s[i + 1] - s[i] > CLOSEST_S).collect();
    // Of the nodes next to 0 the last one stays, and stands for it.
    if let Some(first) = keep.iter().position(|kept| *kept) {
        s[first] = 0.0;
    }
    let mut kept = keep.iter();
    s.retain(|_| *kept.next().unwrap_or(&true));
    let mut kept = keep.iter();
    y.retain(|_| *kept.next().unwrap_or(&true));
}

/// For each of equal parts of a key that runs from 0 to 1, the last cell that begins at or before it.
fn guide(cells: &[Cell], key: impl Fn(&Cell) -> f64) -> Vec<u32> {
    // As many parts as cells: a look-up then meets one candidate on average.
    let parts = cells.len().max(8);
    let last = cells.len() - 2;
    let mut cell = 0;
    let mut find = |part: usize| {
        let value = part as f64 / parts as f64;
        while cell < last && key(&cells[cell + 1]) <= value {
            cell += 1;
        }
        cell as u32
    };
    (0..=parts).map(&mut find).collect()
}
