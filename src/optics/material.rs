//! Materials: refractive index against wavelength.

use std::sync::Arc;

/// What a droplet is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Liquid water at 20 C: n of Daimon & Masumura (2007), k of Segelstein (1981).
    Water,
    /// Ice Ih at 266 K: Warren & Brandt (2008).
    Ice,
    /// The same index at every wavelength.
    Constant { n: f64, k: f64 },
    /// A table read from a file.
    Table(Arc<IndexTable>),
}

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
