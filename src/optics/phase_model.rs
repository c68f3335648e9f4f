//! Which phase function stands for a size bin: exact Mie, or one of the approximations it is compared with.

use std::sync::Arc;

/// The phase model of a droplet class.
#[derive(Clone, Debug, PartialEq)]
pub enum PhaseModel {
    /// Exact Lorenz-Mie, averaged over the bin.
    Mie,
    /// Henyey-Greenstein; `None` takes the exact asymmetry of the bin.
    HenyeyGreenstein { g: Option<f64> },
    /// Jendersie & d'Eon (2023), a blend fitted to fog droplets of 5..50 um diameter.
    HgDraine,
    /// Rayleigh.
    Rayleigh,
    /// Isotropic.
    Isotropic,
    /// Read from a file, normalised on load.
    Table(Arc<AngleTable>),
}

/// A phase function tabulated over the scattering angle.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleTable {
    /// Where it came from.
    pub name: String,
    /// Scattering angles from 0 to pi, strictly increasing, rad.
    pub theta_rad: Vec<f64>,
    /// Values, >= 0, in any unit.
    pub value: Vec<f64>,
}
