//! Size distributions n(r): number of droplets per radius interval between `r_min_m` and `r_max_m`.

use std::fmt;
use std::sync::Arc;

use super::ReadText;
use super::distribution_error::DistributionError;
use super::distribution_parse::parse_distribution;
use super::size_law::{SizeLaw, default_limits};
use crate::units::format_length;

/// A size distribution with its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeDistribution {
    /// The shape.
    pub shape: Shape,
    /// Smallest radius, m.
    pub r_min_m: f64,
    /// Largest radius, m.
    pub r_max_m: f64,
}

/// The functional form of a size distribution.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// One radius.
    Mono { r_m: f64 },
    /// Hansen & Travis (1974): r^((1-3b)/b) exp(-r/(a b)), a the effective radius, b the effective variance.
    Gamma { reff_m: f64, veff: f64 },
    /// Deirmendjian (1969): r^alpha exp(-(alpha/gamma)(r/rc)^gamma).
    ModifiedGamma { alpha: f64, gamma: f64, rc_m: f64 },
    /// Log-normal: number median radius, standard deviation of ln r.
    LogNormal { rg_m: f64, sigma: f64 },
    /// Tabulated: radii in m, dn/dr in arbitrary units; linear between the rows.
    Table { name: String, r_m: Arc<[f64]>, dn_dr: Arc<[f64]> },
}

impl SizeDistribution {
    /// A distribution with given limits; `None` takes the default.
    ///
    /// The default limits leave out a share below 1e-7 of the number of droplets (at the lower end) and of the sum of
    /// r^4 (at the upper end), so less of area and volume; the lower one is never below a thousandth of the radius
    /// where most area lies, if less than 1e-7 of the area lies below that. A table's limits are its first and last radius.
    ///
    /// # Errors
    /// When a parameter is out of range, or no droplets lie between the limits.
    pub fn new(shape: Shape, r_min_m: Option<f64>, r_max_m: Option<f64>) -> Result<Self, DistributionError> {
        check_shape(&shape)?;
        let (lower, upper) = default_limits(&shape);
        let (r_min_m, r_max_m) = (r_min_m.unwrap_or(lower), r_max_m.unwrap_or(upper));
        let distribution = Self { shape, r_min_m, r_max_m };
        distribution.check_limits()?;
        Ok(distribution)
    }

    /// Reads `mono:r=5um`, `gamma:reff=6um,veff=0.1`, `modgamma:alpha=6,gamma=1,rc=4um`, `lognormal:rg=3um,sigma=0.4`
    /// or `csv:FILE` (radius_um,dn_dr), all with `rmin=` and `rmax=`.
    ///
    /// # Errors
    /// When the form, a key or a value is not accepted, or the file is defective.
    ///
    /// ```
    /// use mie_cloud::optics::distribution::SizeDistribution;
    /// let no_files = |name: &str| Err(format!("{name} may not be read"));
    /// let fog = SizeDistribution::parse("gamma:reff=6um,veff=0.1,rmax=40um", &no_files)?;
    /// assert_eq!(fog.r_max_m, 40e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parse(text: &str, read: ReadText) -> Result<Self, DistributionError> {
        parse_distribution(text, read)
    }

    /// The same distribution of radii that are smaller by a factor.
    pub(super) fn divided_by(&self, factor: f64) -> Self {
        let shape = match &self.shape {
            Shape::Mono { r_m } => Shape::Mono { r_m: r_m / factor },
            Shape::Gamma { reff_m, veff } => Shape::Gamma { reff_m: reff_m / factor, veff: *veff },
            Shape::ModifiedGamma { alpha, gamma, rc_m } => {
                Shape::ModifiedGamma { alpha: *alpha, gamma: *gamma, rc_m: rc_m / factor }
            }
            Shape::LogNormal { rg_m, sigma } => Shape::LogNormal { rg_m: rg_m / factor, sigma: *sigma },
            Shape::Table { name, r_m, dn_dr } => {
                Shape::Table { name: name.clone(), r_m: r_m.iter().map(|r| r / factor).collect(), dn_dr: dn_dr.clone() }
            }
        };
        Self { shape, r_min_m: self.r_min_m / factor, r_max_m: self.r_max_m / factor }
    }

    /// The distribution made ready for densities, moments and quantiles.
    pub fn law(&self) -> SizeLaw {
        SizeLaw::new(self)
    }

    /// The distribution's share of droplets per metre of radius, not normalised; zero outside the limits.
    pub fn relative_density(&self, r_m: f64) -> f64 {
        let is_inside = self.r_min_m <= r_m && r_m <= self.r_max_m;
        if is_inside { self.shape.relative_density(r_m) } else { 0.0 }
    }

    fn check_limits(&self) -> Result<(), DistributionError> {
        let Self { shape, r_min_m, r_max_m } = self;
        let holds = match shape {
            Shape::Mono { .. } => r_min_m <= r_max_m,
            Shape::Table { r_m, .. } => r_min_m < r_max_m && r_m[0] < *r_max_m && *r_min_m < r_m[r_m.len() - 1],
            _ => r_min_m < r_max_m,
        };
        let holds = holds && *r_min_m > 0.0 && r_max_m.is_finite() && self.law().holds_droplets();
        if holds {
            return Ok(());
        }
        Err(DistributionError::Limits { of: shape.name(), rmin_um: r_min_m * 1e6, rmax_um: r_max_m * 1e6 })
    }
}

impl Default for SizeDistribution {
    /// A fog: `gamma:reff=6um,veff=0.1`.
    fn default() -> Self {
        let shape = Shape::Gamma { reff_m: 6e-6, veff: 0.1 };
        let (r_min_m, r_max_m) = default_limits(&shape);
        Self { shape, r_min_m, r_max_m }
    }
}

impl Shape {
    /// The form, or the file.
    fn name(&self) -> String {
        match self {
            Self::Mono { .. } => "mono".into(),
            Self::Gamma { .. } => "gamma".into(),
            Self::ModifiedGamma { .. } => "modgamma".into(),
            Self::LogNormal { .. } => "lognormal".into(),
            Self::Table { name, .. } => format!("csv:{name}"),
        }
    }

    /// Droplets per metre of radius, not normalised: 1 at a point near the mode; of a table that was read, from 1 to 2 at
    /// the largest row.
    pub(super) fn relative_density(&self, r_m: f64) -> f64 {
        match self {
            Self::Mono { .. } => 0.0,
            Self::Table { r_m: radii, dn_dr, .. } => interpolate(radii, dn_dr, r_m),
            _ => self.log_density(r_m.ln()).exp(),
        }
    }

    /// Logarithm of the density over t = ln r, for the analytic shapes; concave in t.
    pub(super) fn log_density(&self, t: f64) -> f64 {
        match self {
            Self::Gamma { reff_m, veff } => {
                let ratio = (t - reff_m.ln()).exp();
                (1.0 - 3.0 * veff) / veff * (t - reff_m.ln()) - (ratio - 1.0) / veff
            }
            Self::ModifiedGamma { alpha, gamma, rc_m } => {
                let u = t - rc_m.ln();
                alpha * u - alpha / gamma * (gamma * u).exp_m1()
            }
            Self::LogNormal { rg_m, sigma } => {
                let u = t - rg_m.ln();
                -u - 0.5 * (u / sigma).powi(2)
            }
            Self::Mono { .. } | Self::Table { .. } => 0.0,
        }
    }

    /// ln of the radius at which r^(order + 1) n(r) is largest, for the analytic shapes.
    pub(super) fn log_peak(&self, order: f64) -> f64 {
        match self {
            Self::Gamma { reff_m, veff } => (reff_m * (1.0 - 2.0 * veff + order * veff)).ln(),
            Self::ModifiedGamma { alpha, gamma, rc_m } => rc_m.ln() + ((alpha + order + 1.0) / alpha).ln() / gamma,
            Self::LogNormal { rg_m, sigma } => rg_m.ln() + order * sigma * sigma,
            Self::Mono { r_m } => r_m.ln(),
            Self::Table { r_m, .. } => r_m[0].ln(),
        }
    }
}

fn interpolate(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let above = xs.partition_point(|value| *value <= x);
    if above == 0 {
        return 0.0;
    }
    if above == xs.len() {
        return if xs[above - 1] == x { ys[above - 1] } else { 0.0 };
    }
    let t = (x - xs[above - 1]) / (xs[above] - xs[above - 1]);
    ys[above - 1] + t * (ys[above] - ys[above - 1])
}

/// Radii whose sixth powers and their sums are far from the ends of f64; droplets lie well inside.
pub(super) const RADII_M: std::ops::RangeInclusive<f64> = 1e-15..=1e15;

fn check_shape(shape: &Shape) -> Result<(), DistributionError> {
    let radius = |key, r_m: f64| check_range(key, r_m, RADII_M.contains(&r_m), "from 1e-15 to 1e15 m");
    match shape {
        Shape::Mono { r_m } => radius("r", *r_m),
        Shape::Gamma { reff_m, veff } => {
            radius("reff", *reff_m)?;
            check_range("veff", *veff, (1e-6..0.5).contains(veff), "from 1e-6 to below 0.5")
        }
        Shape::ModifiedGamma { alpha, gamma, rc_m } => {
            radius("rc", *rc_m)?;
            check_range("alpha", *alpha, (1e-3..=1e4).contains(alpha), "from 1e-3 to 1e4")?;
            check_range("gamma", *gamma, (0.05..=100.0).contains(gamma), "from 0.05 to 100")
        }
        Shape::LogNormal { rg_m, sigma } => {
            radius("rg", *rg_m)?;
            check_range("sigma", *sigma, (1e-4..=2.0).contains(sigma), "from 1e-4 to 2")
        }
        Shape::Table { r_m, .. } => r_m.iter().try_for_each(|r_m| radius("radius_um", *r_m)),
    }
}

fn check_range(key: &'static str, value: f64, holds: bool, accepted: &'static str) -> Result<(), DistributionError> {
    if holds { Ok(()) } else { Err(DistributionError::Range { key, value, accepted }) }
}

impl fmt::Display for SizeDistribution {
    /// Writes the distribution as it is read; limits only where they are not the default.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let um = |value_m: f64| format_length(value_m, "um", 1e6);
        match &self.shape {
            Shape::Mono { r_m } => write!(f, "mono:r={}", um(*r_m))?,
            Shape::Gamma { reff_m, veff } => write!(f, "gamma:reff={},veff={veff}", um(*reff_m))?,
            Shape::ModifiedGamma { alpha, gamma, rc_m } => {
                write!(f, "modgamma:alpha={alpha},gamma={gamma},rc={}", um(*rc_m))?;
            }
            Shape::LogNormal { rg_m, sigma } => write!(f, "lognormal:rg={},sigma={sigma}", um(*rg_m))?,
            Shape::Table { name, .. } => write!(f, "csv:{name}")?,
        }
        let (lower, upper) = default_limits(&self.shape);
        if self.r_min_m != lower {
            write!(f, ",rmin={}", um(self.r_min_m))?;
        }
        if self.r_max_m != upper {
            write!(f, ",rmax={}", um(self.r_max_m))?;
        }
        Ok(())
    }
}
