//! Size distributions n(r): number of droplets per radius interval, normalised to 1 between `r_min_m` and `r_max_m`.

use std::sync::Arc;

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
    /// Tabulated: radii in m, dn/dr in arbitrary units.
    Table { name: String, r_m: Arc<[f64]>, dn_dr: Arc<[f64]> },
}
