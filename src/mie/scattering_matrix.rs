//! The scattering matrix of a sphere, or of a sum of spheres, from amplitudes.

use num_complex::Complex64;

/// The four elements that a sphere's scattering matrix has (Bohren & Huffman 1983, eq. 4.77; 1 for one sphere).
///
/// The scattered Stokes parameters are those of the incident light times [[s11, s12, 0, 0], [s12, s11, 0, 0],
/// [0, 0, s33, s34], [0, 0, -s34, s33]] over (k d)^2 at the distance d.
///
/// ```
/// use mie_cloud::mie::ScatteringMatrix;
/// use num_complex::Complex64;
///
/// let matrix = ScatteringMatrix::from_amplitudes(Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0));
/// assert_eq!(matrix, ScatteringMatrix { s11: 1.0, s12: 0.0, s33: 0.0, s34: 1.0 });
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScatteringMatrix {
    /// (|S2|^2 + |S1|^2) / 2, the intensity of unpolarised light.
    pub s11: f64,
    /// (|S2|^2 - |S1|^2) / 2.
    pub s12: f64,
    /// Re(S1 S2*).
    pub s33: f64,
    /// Im(S2 S1*).
    pub s34: f64,
}

impl ScatteringMatrix {
    /// The matrix of one sphere.
    pub fn from_amplitudes(s1: Complex64, s2: Complex64) -> Self {
        let (perpendicular, parallel) = (s1.norm_sqr(), s2.norm_sqr());
        let mixed = s2 * s1.conj();
        Self {
            s11: 0.5 * (parallel + perpendicular),
            s12: 0.5 * (parallel - perpendicular),
            s33: mixed.re,
            s34: mixed.im,
        }
    }

    /// This matrix plus `weight` times another: spheres that scatter independently add up.
    pub fn plus(self, weight: f64, other: Self) -> Self {
        Self {
            s11: self.s11 + weight * other.s11,
            s12: self.s12 + weight * other.s12,
            s33: self.s33 + weight * other.s33,
            s34: self.s34 + weight * other.s34,
        }
    }

    /// Degree of linear polarisation -S12/S11 that unpolarised light takes on, -1 ..= 1; above zero it lies across the
    /// scattering plane. Zero where nothing is scattered.
    pub fn linear_polarization(&self) -> f64 {
        if self.s11 > 0.0 { -self.s12 / self.s11 } else { 0.0 }
    }
}
