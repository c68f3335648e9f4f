//! Lorenz-Mie theory of one homogeneous sphere: coefficients, efficiencies, amplitudes.
//!
//! ```
//! use mie_cloud::mie::Series;
//! use num_complex::Complex64;
//!
//! let drop = Series::new(10.0, Complex64::new(1.33, 1e-8))?;
//! let q = drop.efficiencies();
//! println!("Q_ext = {}, Q_sca = {}, g = {}", q.q_ext, q.q_sca, q.g);
//!
//! let theta_rad = [0.0, 1.0, 2.0];
//! let mut intensity = [0.0; 3];
//! drop.intensities(&theta_rad, &mut intensity)?;
//! // A phase function that integrates to 1 over the sphere, sr^-1.
//! let phase = intensity.map(|i| i / (std::f64::consts::PI * drop.x * drop.x * q.q_sca));
//! assert!(phase[0] > phase[1]);
//! # Ok::<(), mie_cloud::mie::MieError>(())
//! ```
//!
//! # Conventions
//!
//! Those of Bohren & Huffman (1983): m = n + ik relative to the medium, k >= 0 absorbs, time factor exp(-i omega t);
//! x = 2 pi r n_medium / lambda; S1 perpendicular and S2 parallel to the scattering plane (eq. 4.74); theta = 0 is
//! forward. Angles are given as theta, not as its cosine, which cannot resolve the forward peak of a large sphere.
//!
//! # Method
//!
//! `docs/theory.md`, equations (1)-(19). The Riccati-Bessel functions outside and the wave inside are recurred
//! without normalisation and combined as products: no division in any recurrence, no overflow, no expansion for
//! small x, and at m -> 1 no difference of close numbers. A real index stays in real arithmetic.
//! Angles share their recurrence with their mirror images and go through vector registers, chosen at run time.
//!
//! # Accuracy and domain
//!
//! [`domain`] has both as data. The time of a sphere grows like max(1, |m|) x: about 4 ns per order, 0.1 s at
//! worst (x = 1e6, n = 20).

use num_complex::Complex64;
use thiserror::Error;

mod amplitudes;
mod angles;
mod angular;
mod coefficients;
pub mod domain;
mod efficiencies;
mod exterior;
mod intensity;
mod interior;
mod solver;
mod terms;
mod waves;

pub use amplitudes::ScatteringMatrix;
pub use angles::Angles;
pub use intensity::IntensitySum;
pub use solver::{Solver, efficiencies};

/// The sphere is outside the domain of the theory as it is computed here.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MieError {
    /// The size parameter is not a positive finite number in range.
    #[error("size parameter x = {0} must lie in 1e-6 to 1e6")]
    SizeParameter(f64),
    /// The refractive index is out of range or absorbs with the wrong sign.
    #[error("refractive index {n} + {k}i must have 0.05 <= n <= 20 and 0 <= k <= 100 (k > 0 absorbs)")]
    Index { n: f64, k: f64 },
    /// A scattering angle is out of range or not a number.
    #[error("scattering angle {0} rad must lie in 0 to pi")]
    Angle(f64),
    /// A slice for results does not match the angles.
    #[error("{values} slots for results at {angles} angles: the numbers must be equal")]
    Lengths { angles: usize, values: usize },
}

/// Efficiencies of one sphere; all but `g` and `n_terms` are relative to its geometric cross section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Efficiencies {
    /// Extinction efficiency.
    pub q_ext: f64,
    /// Scattering efficiency.
    pub q_sca: f64,
    /// Absorption efficiency, summed directly, never a difference.
    pub q_abs: f64,
    /// Radar backscattering efficiency, 4 |S1(180 deg)|^2 / x^2.
    pub q_back: f64,
    /// Radiation pressure efficiency, q_ext - g q_sca; good to the rounding of q_ext, so not where g is close to 1.
    pub q_pr: f64,
    /// Asymmetry parameter, the mean cosine of the scattering angle; 0 where nothing is scattered (m = 1).
    pub g: f64,
    /// Number of partial waves that were summed.
    pub n_terms: usize,
}

/// The scattering coefficients a_n, b_n of one sphere.
#[derive(Clone, Debug)]
pub struct Series {
    /// Size parameter.
    pub x: f64,
    /// Relative refractive index, k >= 0.
    pub m: Complex64,
    /// a_n, n = 1 ..= n_terms.
    pub a: Vec<Complex64>,
    /// b_n, n = 1 ..= n_terms.
    pub b: Vec<Complex64>,
    efficiencies: Efficiencies,
}

impl Series {
    /// Solves the sphere of size parameter `x` and relative index `m`.
    ///
    /// # Errors
    /// [`MieError`] if `x` or `m` lies outside the domain.
    pub fn new(x: f64, m: Complex64) -> Result<Self, MieError> {
        Solver::new().series(x, m)
    }

    /// Efficiencies, summed with the coefficients.
    pub fn efficiencies(&self) -> Efficiencies {
        self.efficiencies
    }
}
