//! The paper's scattering formulas as they were published, with their limits.
//!
//! Legend: x, size parameter; m, relative index; z = Re(m) x, the argument inside the droplet; H, the step of the
//! derivatives; mu, cosine of the scattering angle; j_n, y_n, spherical Bessel functions; h_n = j_n + i y_n.

use num_complex::Complex64;

use super::bessel::Bessel;

/// Orders that are summed, always.
pub const TERMS: usize = 100;

/// Step of the central differences ("a small H"); this one reproduces the values published with the listing's tests.
pub const H: f64 = 1e-5;

/// Above this size parameter every efficiency is 0.
pub const LARGEST_X: f64 = 1000.0;

/// Asymmetry of the phase function, for every droplet and colour.
pub const G: f64 = 0.9;

/// The two forms in which the paper gives its coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// Its code, which has j_n, h_n and their derivatives where its equations have psi_n, xi_n and theirs.
    Listing,
    /// Its equations: psi_n(z) = z j_n(z), xi_n(z) = z h_n(z).
    Equations,
}

/// What to do where the arithmetic ends in NaN: y_n overflows and j_n underflows at high orders of small droplets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caution {
    /// Nothing: the sum is NaN, as published.
    None,
    /// The sum ends before the first order that is not a number; such orders are far below rounding.
    BeforeNan,
}

/// What a droplet does to one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Efficiencies {
    /// Scattering efficiency.
    pub q_sca: f64,
    /// Absorption efficiency; of absorbing droplets it may be negative, as published.
    pub q_abs: f64,
}

impl Efficiencies {
    /// Q_ext = Q_sca + Q_abs.
    pub fn q_ext(&self) -> f64 {
        self.q_sca + self.q_abs
    }

    /// Q_sca (1 - Q_abs): what the droplet makes of white light, apart from its direction.
    pub fn strength(&self) -> f64 {
        self.q_sca * (1.0 - self.q_abs)
    }

    /// I = P(mu) Q_sca (1 - Q_abs), theory (86).
    pub fn intensity(&self, mu: f64) -> f64 {
        phase(mu) * self.strength()
    }
}

/// x = 2 pi r / lambda, theory (80), of a diameter and a wavelength in one unit.
pub fn size_parameter(diameter: f64, wavelength: f64) -> f64 {
    2.0 * std::f64::consts::PI * (diameter / 2.0) / wavelength
}

/// P(mu) = (1 - g^2) / (1 + g^2 - 2 g mu)^1.5, theory (85): without the 1/(4 pi) that would make it a phase function.
pub fn phase(mu: f64) -> f64 {
    let square = 1.0 + G * G - 2.0 * G * mu;
    (1.0 - G * G) / (square * square.sqrt())
}

/// Q_sca and Q_abs, theory (83) and (84); 0 for x > 1000.
pub fn efficiencies(variant: Variant, caution: Caution, x: f64, m: Complex64) -> Efficiencies {
    if x > LARGEST_X {
        return Efficiencies { q_sca: 0.0, q_abs: 0.0 };
    }
    let (mut sca, mut abs) = (0.0, 0.0);
    for (i, (a, b)) in coefficients(variant, x, m, H).into_iter().enumerate() {
        if caution == Caution::BeforeNan && !(a + b).is_finite() {
            break;
        }
        let weight = (2 * i + 3) as f64; // 2n+1 with n = i + 1
        let squares = a.norm_sqr() + b.norm_sqr();
        sca += weight * squares;
        abs += weight * ((a + b).re - squares);
    }
    Efficiencies { q_sca: 2.0 / (x * x) * sca, q_abs: 2.0 / (x * x) * abs }
}

/// a_n and b_n for n = 1 ..= 100, theory (82), with derivatives by central differences of step `h`.
///
/// Only the real part of m enters the arguments of the functions; where it multiplies it is complex.
pub fn coefficients(variant: Variant, x: f64, m: Complex64, h: f64) -> Vec<(Complex64, Complex64)> {
    let z = m.re * x;
    let outside = Waves::at(x, h);
    let inside = Waves::at(z, h);
    let one = |n: usize| {
        let (p_x, dp_x) = outside.regular(variant, n); // psi_n(x), psi_n'(x)
        let (p_z, dp_z) = inside.regular(variant, n); // psi_n(z), psi_n'(z)
        let (xi, dxi) = outside.outgoing(variant, n); // xi_n(x), xi_n'(x)
        let a = (m * p_z * dp_x - p_x * dp_z) / (m * p_z * dxi - xi * dp_z);
        let b = (p_z * dp_x - m * p_x * dp_z) / (p_z * dxi - m * xi * dp_z);
        (a, b)
    };
    (1..=TERMS).map(one).collect()
}

/// The Bessel functions at an argument and one step of the differences to either side.
struct Waves {
    z: f64,
    h: f64,
    here: Bessel,
    below: Bessel,
    above: Bessel,
}

impl Waves {
    fn at(z: f64, h: f64) -> Self {
        let bessel = |z| Bessel::new(TERMS, z);
        Self { z, h, here: bessel(z), below: bessel(z - h), above: bessel(z + h) }
    }

    /// j_n and j_n' (listing), or psi_n = z j_n and psi_n' = j_n + z j_n' (equations).
    fn regular(&self, variant: Variant, n: usize) -> (f64, f64) {
        let j = self.here.j[n];
        let dj = (self.above.j[n] - self.below.j[n]) / (2.0 * self.h); // theory (81)
        match variant {
            Variant::Listing => (j, dj),
            Variant::Equations => (self.z * j, j + self.z * dj),
        }
    }

    /// h_n and h_n' (listing), or xi_n = z h_n and xi_n' = h_n + z h_n' (equations).
    fn outgoing(&self, variant: Variant, n: usize) -> (Complex64, Complex64) {
        let hankel = |f: &Bessel| Complex64::new(f.j[n], f.y[n]);
        let h = hankel(&self.here);
        let dh = (hankel(&self.above) - hankel(&self.below)) / (2.0 * self.h); // theory (81)
        match variant {
            Variant::Listing => (h, dh),
            Variant::Equations => (self.z * h, h + self.z * dh),
        }
    }
}
