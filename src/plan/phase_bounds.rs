//! How bright droplets and air can be in a direction, and are at least, before any phase function has been computed.
//!
//! Legend: P = 4 pi p, 1 for light that goes everywhere alike; theta the scattering angle; x the size parameter; h = 1 - cos theta.

use std::f64::consts::PI;

use crate::optics::distribution::SizeDistribution;
use crate::optics::material::Material;
use crate::optics::phase_function::PhaseFunction;
use crate::optics::phase_model::PhaseModel;
use crate::scene::settings::AirPhase;

/// Least size parameter of spheres that are dark from the side.
pub(super) const LARGE: f64 = 3.0;

/// Asymmetry that stands for that of a bin: cloud droplets have 0.84 to 0.87.
const DROPLET_G: f64 = 0.87;

/// Bounds of one phase function, times 4 pi.
#[derive(Clone, Debug)]
pub(super) enum PhaseBounds {
    /// It is known.
    Known(PhaseFunction),
    /// Spheres of any index, theory (130) and (131).
    Spheres(Spheres),
    /// Anything.
    Unknown,
}

/// Spheres of many sizes: means over their areas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spheres {
    /// Mean of x^2.
    x_squared: f64,
    /// Mean of 1/x.
    inverse_x: f64,
    is_large: bool,
    /// Whether they absorb so much that no lower bound is known.
    absorbs: bool,
    /// Whether they are clear and of an index like water's, so that more is known of them.
    is_water: bool,
}

/// Spheres lose about 4 x k of what goes through them to absorption; more than this counts in clouds where light meets hundreds.
const ABSORBED: f64 = 1e-3;

/// Indices of water and ice, and of what is not far from them.
const WATERY: std::ops::RangeInclusive<f64> = 1.25..=1.4;

/// From here on backward water has bows and a glory, degrees.
const BACK_DEG: f64 = 122.0;

/// From here on backward indices near 1.8 focus light to the back, degrees.
const GLORY_DEG: f64 = 165.0;

impl Spheres {
    /// Of one radius, m.
    pub fn of_radius(r_m: f64, wavelength_m: f64) -> Self {
        let x = 2.0 * PI * r_m / wavelength_m;
        Self { x_squared: x * x, inverse_x: 1.0 / x, is_large: x > LARGE, absorbs: false, is_water: false }
    }

    /// Of a distribution.
    pub fn of_distribution(distribution: &SizeDistribution, wavelength_m: f64) -> Self {
        let (law, k) = (distribution.law(), 2.0 * PI / wavelength_m);
        let (area, effective_m) = (law.moment(2), law.moment(3) / law.moment(2));
        Self {
            x_squared: k * k * law.moment(4) / area,
            inverse_x: law.moment(1) / (k * area),
            is_large: k * effective_m > LARGE,
            absorbs: false,
            is_water: false,
        }
    }

    /// The same of a material, whose index may not be known at this wavelength.
    pub fn made_of(self, material: &Material, wavelength_m: f64) -> Self {
        let Ok(index) = material.index(wavelength_m) else { return Self { absorbs: true, ..self } };
        let absorbs = 4.0 * index.im * self.x_squared.sqrt() > ABSORBED;
        let is_water = self.is_large && !absorbs && WATERY.contains(&index.re);
        Self { absorbs, is_water, ..self }
    }

    /// Whether they may scatter much less than they take.
    pub fn absorb(&self) -> bool {
        self.absorbs
    }

    /// Theory (130): the least of diffraction's peak and its envelope, and what goes through and is reflected.
    fn most(&self, theta: f64) -> f64 {
        let envelope = 16.0 / PI * self.inverse_x / theta.powi(3);
        let theta_deg = theta.to_degrees();
        let through = match self.is_water {
            true if theta_deg < BACK_DEG => 0.15 + 14.0 * (-theta_deg / 18.0).exp(),
            true => 1.2,
            false if theta_deg < GLORY_DEG => 2.0 + 12.0 * (-theta_deg / 25.0).exp(),
            false => 30.0,
        };
        self.x_squared.min(envelope) + through
    }

    /// Theory (131).
    fn least(&self, theta: f64) -> f64 {
        let side = if self.is_large { 0.015 } else { 0.08 };
        if self.absorbs {
            return 0.0;
        }
        side + 3.0 * (-theta.to_degrees() / 15.0).exp()
    }
}

impl PhaseBounds {
    /// Of droplets of one class and size.
    pub fn of_droplets(model: &PhaseModel, spheres: Spheres) -> Self {
        match model {
            PhaseModel::Mie => Self::Spheres(spheres),
            PhaseModel::HenyeyGreenstein { g } => Self::Known(PhaseFunction::henyey_greenstein(g.unwrap_or(DROPLET_G))),
            PhaseModel::Rayleigh => Self::Known(PhaseFunction::Rayleigh),
            PhaseModel::Isotropic => Self::Known(PhaseFunction::Isotropic),
            PhaseModel::HgDraine | PhaseModel::Table(_) => Self::Unknown,
        }
    }

    /// Of the air.
    pub fn of_air(phase: &AirPhase, wavelength_m: f64) -> Self {
        match phase {
            AirPhase::Isotropic => Self::Known(PhaseFunction::Isotropic),
            AirPhase::Rayleigh => Self::Known(PhaseFunction::Rayleigh),
            AirPhase::HenyeyGreenstein { g } => Self::Known(PhaseFunction::henyey_greenstein(*g)),
            AirPhase::Haze(distribution) => Self::Spheres(Spheres::of_distribution(distribution, wavelength_m)),
        }
    }

    /// An upper bound of P within `blur` of the angle, rad.
    pub fn most(&self, h: f64, blur: f64) -> f64 {
        let theta = (angle(h) - blur).max(0.0);
        match self {
            Self::Known(phase) => [theta, angle(h), (angle(h) + blur).min(PI)]
                .map(|theta| 4.0 * PI * phase.eval(1.0 - theta.cos()))
                .into_iter()
                .fold(0.0, f64::max),
            Self::Spheres(spheres) => spheres.most(theta),
            Self::Unknown => f64::INFINITY,
        }
    }

    /// A lower bound of P.
    pub fn least(&self, h: f64) -> f64 {
        match self {
            Self::Known(phase) => 4.0 * PI * phase.eval(h),
            Self::Spheres(spheres) => spheres.least(angle(h)),
            Self::Unknown => 0.0,
        }
    }
}

/// The angle of h, rad.
fn angle(h: f64) -> f64 {
    2.0 * (0.5 * h).max(0.0).sqrt().min(1.0).asin()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::size_average::{AverageAccuracy, SizeAverage, Sizes};

    const GREEN_M: f64 = 550e-9;

    fn distribution(text: &str) -> SizeDistribution {
        SizeDistribution::parse(text, &|_: &str| Err("no files here".into())).expect("a distribution")
    }

    /// Bounds against exact Mie every 2.5 degrees, the upper one against means over a window of 5: what counts is a mean over a
    /// picture, and glories and ripples are narrower.
    #[test]
    fn mie_lies_between_the_bounds() {
        let clear = |n| Material::Constant { n, k: 0.0 };
        let cases = [
            ("gamma:reff=0.1um,veff=0.1", Material::Water),
            ("gamma:reff=0.3um,veff=0.1", Material::Water),
            ("gamma:reff=1um,veff=0.1", Material::Water),
            ("gamma:reff=6um,veff=0.1", Material::Water),
            ("gamma:reff=20um,veff=0.01", Material::Water),
            ("gamma:reff=100um,veff=0.01", Material::Ice),
            ("lognormal:rg=2um,sigma=0.6", Material::Water),
            ("gamma:reff=4um,veff=0.1", clear(1.5)),
            ("gamma:reff=4um,veff=0.1", clear(1.8)),
            ("lognormal:rg=0.05um,sigma=0.6", Material::Constant { n: 1.75, k: 0.44 }),
            ("gamma:reff=6um,veff=0.1", Material::Constant { n: 1.5, k: 0.05 }),
        ];
        for (text, material) in cases {
            let sizes = distribution(text);
            let index = material.index(GREEN_M).expect("an index");
            let bounds = Spheres::of_distribution(&sizes, GREEN_M).made_of(&material, GREEN_M);
            let sizes = Sizes::Law(Box::new(sizes.law()));
            let mie = SizeAverage::new(index, GREEN_M, &sizes, AverageAccuracy::picture()).expect("Mie");
            let albedo = mie.cross_sections.c_sca_m2 / mie.cross_sections.c_ext_m2;
            let half_degrees: Vec<f64> = (0..=360).map(|i| (0.5 * f64::from(i)).to_radians()).collect();
            let p: Vec<f64> = mie.phase(&half_degrees).expect("p").iter().map(|p| 4.0 * PI * p).collect();
            for i in (0..=360).step_by(5) {
                let theta = half_degrees[i];
                let window = &p[i.saturating_sub(5)..=(i + 5).min(360)];
                let mean = window.iter().sum::<f64>() / window.len() as f64;
                let (most, least) = (bounds.most((theta - 0.0436).max(0.0)), bounds.least(theta));
                assert!(
                    albedo * mean <= most,
                    "{text} {material} at {:.1} degrees: {mean} > {most}",
                    theta.to_degrees()
                );
                // Within a factor of two: a mean over directions is compared with a target's tenth.
                assert!(
                    2.0 * mean >= least,
                    "{text} {material} at {:.1} degrees: {mean} < {least}",
                    theta.to_degrees()
                );
            }
        }
    }
}
