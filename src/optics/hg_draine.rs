//! The blend of Henyey-Greenstein and Draine functions that Jendersie & d'Eon (2023) fitted to fog droplets.
//!
//! J. Jendersie, E. d'Eon, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", SIGGRAPH Talks 2023,
//! equations 4 to 7. Draine's function: B. T. Draine, Astrophys. J. 598, 1017 (2003), equation 6.
//! Legend: d, droplet diameter in um; w, share of Draine's function; alpha, its weight of cos^2; c = 1 + g^2.

use std::f64::consts::PI;

use super::phase_function::HenyeyGreenstein;

/// Smallest droplet diameter of the fit, um.
pub const MIN_DIAMETER_UM: f64 = 5.0;

/// Largest droplet diameter of the fit, um.
pub const MAX_DIAMETER_UM: f64 = 50.0;

/// The blend for one droplet diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HgDraine {
    peak: HenyeyGreenstein,
    draine: Draine,
    draine_share: f64,
}

impl HgDraine {
    /// The blend for droplets of a diameter in um; `None` outside the fitted range of 5 to 50 um.
    pub fn new(diameter_um: f64) -> Option<Self> {
        let d = diameter_um;
        if !(MIN_DIAMETER_UM..=MAX_DIAMETER_UM).contains(&d) {
            return None;
        }
        Some(Self {
            peak: HenyeyGreenstein { g: (-0.0990567 / (d - 1.67154)).exp() },
            draine: Draine {
                g: (-2.20679 / (d + 3.91029) - 0.428934).exp(),
                alpha: (3.62489 - 8.29288 / (d + 5.52825)).exp(),
            },
            draine_share: (-0.599085 / (d - 0.641583) - 0.665888).exp(),
        })
    }

    /// Value at h = 1 - cos theta, sr^-1.
    pub fn eval(&self, h: f64) -> f64 {
        (1.0 - self.draine_share) * self.peak.eval(h) + self.draine_share * self.draine.eval(h)
    }

    /// Probability of scattering by less than h.
    pub fn cdf(&self, h: f64) -> f64 {
        (1.0 - self.draine_share) * self.peak.cdf(h) + self.draine_share * self.draine.cdf(h)
    }

    /// Chooses one of the two with `u` and samples it with what is left of `u`.
    pub fn sample(&self, u: f64) -> f64 {
        if u < self.draine_share {
            self.draine.sample(u / self.draine_share)
        } else {
            self.peak.sample((u - self.draine_share) / (1.0 - self.draine_share))
        }
    }

    /// Mean cos theta.
    pub fn mean_cosine(&self) -> f64 {
        (1.0 - self.draine_share) * self.peak.g + self.draine_share * self.draine.mean_cosine()
    }
}

/// Henyey-Greenstein times (1 + alpha mu^2), normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Draine {
    g: f64,
    alpha: f64,
}

impl Draine {
    fn norm(self) -> f64 {
        1.0 + self.alpha * (1.0 + 2.0 * self.g * self.g) / 3.0
    }

    fn eval(self, h: f64) -> f64 {
        let mu = 1.0 - h;
        HenyeyGreenstein { g: self.g }.eval(h) * (1.0 + self.alpha * mu * mu) / self.norm()
    }

    fn mean_cosine(self) -> f64 {
        self.g * (1.0 + self.alpha * (3.0 + 2.0 * self.g * self.g) / 5.0) / self.norm()
    }

    /// With q = (1 + g^2 - 2 g mu)^(1/2) the integral over mu is one of (1 + alpha (c - q^2)^2 / (4 g^2)) / (g q^2).
    fn cdf(self, h: f64) -> f64 {
        let g = self.g;
        let (c, a) = (1.0 + g * g, self.alpha / (4.0 * g * g));
        let primitive = |q: f64| -(1.0 + a * c * c) / q - 2.0 * a * c * q + a * q * q * q / 3.0;
        let q = ((1.0 - g) * (1.0 - g) + 2.0 * g * h).sqrt();
        let sum = (primitive(q) - primitive(1.0 - g)) * (1.0 - g * g) / (2.0 * g * self.norm());
        sum.clamp(0.0, 1.0)
    }

    /// Newton's method inside a shrinking bracket, started where Henyey-Greenstein would be.
    fn sample(self, u: f64) -> f64 {
        let (mut lower, mut upper) = (0.0, 2.0);
        let mut h = HenyeyGreenstein { g: self.g }.sample(u);
        // Newton's method takes about six steps; bisection alone would need fifty.
        for _ in 0..60 {
            let excess = self.cdf(h) - u;
            if excess > 0.0 {
                upper = h
            } else {
                lower = h
            }
            let step = h - excess / (2.0 * PI * self.eval(h));
            let next = if step > lower && step < upper { step } else { 0.5 * (lower + upper) };
            if (next - h).abs() <= 1e-14 {
                break;
            }
            h = next;
        }
        h
    }
}
