//! Refractive indices tabulated over wavelength, from CSV files.

use num_complex::Complex64;

use super::csv::{NumericCsv, Row, parse_numeric};
use super::material::{K_MAX, MaterialError, N_MAX, N_MIN};

/// How far outside its data a wavelength may lie, relative: the rounding of unit conversions.
pub(super) const EDGE_SLACK: f64 = 1e-9;

/// Wavelengths in tables; outside, their ratios could overflow.
const WAVELENGTHS_M: std::ops::RangeInclusive<f64> = 1e-15..=1e9;
/// Below, nothing is absorbed along any way, and ratios of two k could overflow: they are interpolated like zero.
const LEAST_K: f64 = 1e-100;

/// A refractive index tabulated over wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexTable {
    /// Where it came from.
    pub name: String,
    /// Vacuum wavelengths, strictly increasing, m.
    pub wavelength_m: Vec<f64>,
    /// Real part.
    pub n: Vec<f64>,
    /// Imaginary part, >= 0.
    pub k: Vec<f64>,
}

impl IndexTable {
    /// Reads the columns wavelength_um (or wavelength_nm), n and k, in any order, from the text of a CSV file.
    ///
    /// # Errors
    /// When the header does not name them, a row is not numbers, the wavelengths do not increase or an index is out of
    /// range.
    pub fn parse(name: &str, text: &str) -> Result<Self, MaterialError> {
        let csv = parse_numeric(name, text, 3, 1)?;
        let ([wavelength, n, k], per_meter) = find_columns(name, &csv)?;
        let mut table = Self { name: name.into(), wavelength_m: Vec::new(), n: Vec::new(), k: Vec::new() };
        for Row { line, values } in &csv.rows {
            let wavelength_m = values[wavelength] / per_meter;
            let increases = table.wavelength_m.last().is_none_or(|last| *last < wavelength_m);
            if !WAVELENGTHS_M.contains(&wavelength_m) || !increases {
                return Err(MaterialError::Order { file: name.into(), line: *line });
            }
            check_index(&format!("{name}, line {line}"), values[n], values[k])?;
            table.wavelength_m.push(wavelength_m);
            table.n.push(values[n]);
            table.k.push(values[k]);
        }
        Ok(table)
    }

    /// First and last wavelength, m.
    pub fn range_m(&self) -> (f64, f64) {
        let edge = |wavelength: Option<&f64>| wavelength.copied().unwrap_or(0.0);
        (edge(self.wavelength_m.first()), edge(self.wavelength_m.last()))
    }

    /// The index at a vacuum wavelength: n linear, k linear in the logarithms where it is above zero.
    ///
    /// # Errors
    /// When the wavelength is outside the table.
    pub fn index(&self, wavelength_m: f64) -> Result<Complex64, MaterialError> {
        let (first_m, last_m) = self.range_m();
        let is_inside = first_m * (1.0 - EDGE_SLACK) <= wavelength_m && wavelength_m <= last_m * (1.0 + EDGE_SLACK);
        if !is_inside {
            return Err(out_of_range(&self.name, wavelength_m, first_m, last_m));
        }
        let wavelength_m = wavelength_m.clamp(first_m, last_m);
        let above = self.wavelength_m.partition_point(|w| *w <= wavelength_m);
        if above == self.wavelength_m.len() {
            return Ok(Complex64::new(self.n[above - 1], self.k[above - 1]));
        }
        let (w0, w1) = (self.wavelength_m[above - 1], self.wavelength_m[above]);
        let t = (wavelength_m - w0) / (w1 - w0);
        let n = self.n[above - 1] + t * (self.n[above] - self.n[above - 1]);
        let (k0, k1) = (self.k[above - 1], self.k[above]);
        let k = if k0 > LEAST_K && k1 > LEAST_K {
            k0 * ((wavelength_m / w0).ln() / (w1 / w0).ln() * (k1 / k0).ln()).exp()
        } else {
            k0 + t * (k1 - k0)
        };
        Ok(Complex64::new(n, k))
    }
}

/// Where wavelength, n and k stand, and how many of the wavelength's unit make a metre.
fn find_columns(name: &str, csv: &NumericCsv) -> Result<([usize; 3], f64), MaterialError> {
    let missing = || MaterialError::Header(name.into());
    let header = csv.header.as_ref().ok_or_else(missing)?;
    let find = |column: &str| header.iter().position(|found| found == column);
    let (wavelength, per_meter) = match (find("wavelength_um"), find("wavelength_nm")) {
        (Some(column), None) => (column, 1e6),
        (None, Some(column)) => (column, 1e9),
        _ => return Err(missing()),
    };
    Ok(([wavelength, find("n").ok_or_else(missing)?, find("k").ok_or_else(missing)?], per_meter))
}

/// Whether an index is one that Mie theory takes.
pub(super) fn check_index(of: &str, n: f64, k: f64) -> Result<(), MaterialError> {
    if (N_MIN..=N_MAX).contains(&n) && (0.0..=K_MAX).contains(&k) {
        return Ok(());
    }
    Err(MaterialError::Index { of: of.into(), n, k })
}

pub(super) fn out_of_range(material: &str, wavelength_m: f64, first_m: f64, last_m: f64) -> MaterialError {
    // Shown to people: rounded to 1e-6 nm.
    let in_nm = |length_m: f64| (length_m * 1e15).round() / 1e6;
    MaterialError::Wavelength {
        material: material.into(),
        wavelength_nm: in_nm(wavelength_m),
        min_nm: in_nm(first_m),
        max_nm: in_nm(last_m),
    }
}
