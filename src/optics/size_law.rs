//! A size distribution made ready for use: normalised densities, moments and quantiles.
//!
//! Legend: t = ln r for the analytic shapes and r itself for tables; the cumulative number is kept at nodes in t and is
//! a cubic between them, so that quantiles cost no exponentials.

use super::distribution::{Shape, SizeDistribution};
use super::quadrature::GaussLegendre;

/// Cells of an analytic distribution's cumulative table: with 1024 over the whole support the cubic's error is below
/// 1e-9 (see the test).
const CELLS: usize = 1024;

/// Points per cell of the integrals: with 8 the error of a cell is below rounding.
const POINTS: usize = 8;

/// Where the logarithm of an analytic density has fallen by this much nothing is left: exp(-40) = 4e-18.
const SUPPORT_DROP: f64 = 40.0;

/// Share left out at each end by the default limits.
const TAIL_SHARE: f64 = 1e-7;

/// The default lower limit is at least this fraction of the radius where most area lies, as far as the area allows:
/// distributions that are dominated in number by molecules have no other end.
const SMALLEST_FRACTION: f64 = 1e-3;

/// A normalised size distribution.
#[derive(Clone, Debug)]
pub struct SizeLaw {
    distribution: SizeDistribution,
    /// Nodes in t.
    nodes: Vec<f64>,
    /// Share of droplets up to each node.
    cumulative: Vec<f64>,
    /// Share of droplets per unit of t at each node.
    slope: Vec<f64>,
    /// Integral of the relative density.
    norm: f64,
}

impl SizeLaw {
    pub(super) fn new(distribution: &SizeDistribution) -> Self {
        let nodes = nodes(distribution);
        let mut law = Self {
            distribution: distribution.clone(),
            cumulative: vec![0.0; nodes.len()],
            slope: Vec::new(),
            nodes,
            norm: 1.0,
        };
        let rule = GaussLegendre::new(POINTS);
        for i in 1..law.nodes.len() {
            let cell = rule.integrate(law.nodes[i - 1], law.nodes[i], |t| law.density_over_t(t));
            law.cumulative[i] = law.cumulative[i - 1] + cell;
        }
        law.norm = law.cumulative.last().copied().unwrap_or(0.0);
        law.cumulative.iter_mut().for_each(|share| *share /= law.norm);
        law.slope = law.nodes.iter().map(|t| law.density_over_t(*t) / law.norm).collect();
        law
    }

    /// Whether there is anything to normalise.
    pub(super) fn holds_droplets(&self) -> bool {
        self.mono_radius().is_some() || (self.norm > 0.0 && self.norm.is_finite())
    }

    /// The radius of a law that has only one, m.
    pub fn mono_radius(&self) -> Option<f64> {
        match self.distribution.shape {
            Shape::Mono { r_m } => Some(r_m),
            _ => None,
        }
    }

    fn radius(&self, t: f64) -> f64 {
        if is_logarithmic(&self.distribution.shape) { t.exp() } else { t }
    }

    /// Relative density per unit of t, limits left to the nodes.
    fn density_over_t(&self, t: f64) -> f64 {
        let shape = &self.distribution.shape;
        if is_logarithmic(shape) { (shape.log_density(t) + t).exp() } else { shape.relative_density(t) }
    }

    /// Share of droplets per metre of radius; integrates to 1 between the limits. Zero everywhere for one radius.
    pub fn number_density(&self, r_m: f64) -> f64 {
        if self.mono_radius().is_some() { 0.0 } else { self.distribution.relative_density(r_m) / self.norm }
    }

    /// Mean of `f` over the droplets: the integral of n(r) f(r) over the radii (m).
    pub fn mean(&self, mut f: impl FnMut(f64) -> f64) -> f64 {
        if let Some(r_m) = self.mono_radius() {
            return f(r_m);
        }
        let rule = GaussLegendre::new(POINTS);
        let cell = |t: &[f64]| rule.integrate(t[0], t[1], |t| self.density_over_t(t) * f(self.radius(t)));
        self.nodes.windows(2).map(cell).sum::<f64>() / self.norm
    }

    /// Mean of r^order, m^order.
    pub fn moment(&self, order: i32) -> f64 {
        self.mean(|r_m| r_m.powi(order))
    }

    /// Effective radius: mean r^3 over mean r^2, m (Hansen & Travis 1974, eq. 2.53).
    pub fn effective_radius_m(&self) -> f64 {
        self.moment(3) / self.moment(2)
    }

    /// Effective variance: the area-weighted variance of r over the effective radius squared (Hansen & Travis 1974,
    /// eq. 2.54).
    pub fn effective_variance(&self) -> f64 {
        let reff_m = self.effective_radius_m();
        self.mean(|r_m| (r_m * (r_m - reff_m)).powi(2)) / (reff_m * reff_m * self.moment(2))
    }

    /// Mean geometric cross section pi r^2, m^2.
    pub fn mean_area_m2(&self) -> f64 {
        std::f64::consts::PI * self.moment(2)
    }

    /// Mean volume, m^3.
    pub fn mean_volume_m3(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.moment(3)
    }

    /// The cells of the law, each as its two radii in m, from the smallest to the largest.
    pub fn cells(&self) -> impl Iterator<Item = (f64, f64)> {
        self.nodes.windows(2).map(|t| (self.radius(t[0]), self.radius(t[1])))
    }

    /// The radius in m that a share `u` in [0, 1] of the droplets does not exceed.
    pub fn quantile(&self, u: f64) -> f64 {
        if let Some(r_m) = self.mono_radius() {
            return r_m;
        }
        let last = self.nodes.len() - 1;
        let cell = self.cumulative.partition_point(|share| *share <= u).clamp(1, last) - 1;
        let (t0, t1) = (self.nodes[cell], self.nodes[cell + 1]);
        let width = t1 - t0;
        let (c0, c1) = (self.cumulative[cell], self.cumulative[cell + 1]);
        let cubic = Cubic::hermite(c0, c1, width * self.slope[cell], width * self.slope[cell + 1]);
        let r_m = self.radius(t0 + width * cubic.invert(u));
        r_m.clamp(self.distribution.r_min_m, self.distribution.r_max_m)
    }
}

/// A cubic on [0, 1] that increases.
struct Cubic([f64; 4]);

impl Cubic {
    fn hermite(y0: f64, y1: f64, d0: f64, d1: f64) -> Self {
        let rise = y1 - y0;
        Self([y0, d0, 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise])
    }

    /// Where the cubic has the value `y`, by Newton's method inside a shrinking bracket.
    fn invert(&self, y: f64) -> f64 {
        let [a, b, c, d] = self.0;
        let (mut lower, mut upper) = (0.0, 1.0);
        let mut s = ((y - a) / (b + c + d)).clamp(0.0, 1.0);
        // Newton doubles the digits at each step and bisection adds one: 50 steps end at rounding in any case.
        for _ in 0..50 {
            let excess = a + s * (b + s * (c + s * d)) - y;
            if excess > 0.0 {
                upper = s
            } else {
                lower = s
            }
            let step = s - excess / (b + s * (2.0 * c + 3.0 * s * d));
            let next = if step > lower && step < upper { step } else { 0.5 * (lower + upper) };
            let change = (next - s).abs();
            s = next;
            // The next Newton step would be the square of this one.
            if change <= 1e-7 && step == next {
                break;
            }
        }
        if s.is_nan() { 0.5 } else { s }
    }
}

fn is_logarithmic(shape: &Shape) -> bool {
    !matches!(shape, Shape::Table { .. } | Shape::Mono { .. })
}

/// Nodes over the part of the limits that holds droplets.
fn nodes(distribution: &SizeDistribution) -> Vec<f64> {
    let (r_min_m, r_max_m) = (distribution.r_min_m, distribution.r_max_m);
    match &distribution.shape {
        Shape::Mono { .. } => Vec::new(),
        Shape::Table { r_m, .. } => {
            let lower = r_min_m.max(r_m[0]);
            let upper = r_max_m.min(r_m[r_m.len() - 1]);
            let inner = r_m.iter().copied().filter(|r_m| lower < *r_m && *r_m < upper);
            std::iter::once(lower).chain(inner).chain([upper]).collect()
        }
        shape => {
            let (lower, upper) = support(shape);
            uniform(lower.max(r_min_m.ln()), upper.min(r_max_m.ln()))
        }
    }
}

fn uniform(lower: f64, upper: f64) -> Vec<f64> {
    if lower < upper {
        (0..=CELLS).map(|i| lower + (upper - lower) * i as f64 / CELLS as f64).collect()
    } else {
        Vec::new()
    }
}

/// The range of ln r outside which neither number nor r^6 is worth counting.
fn support(shape: &Shape) -> (f64, f64) {
    (fall(shape, 0.0, -1.0), fall(shape, 6.0, 1.0))
}

/// Where r^(order + 1) n has fallen from its peak by the support's drop, downward or upward in ln r; the logarithm is
/// concave, so there is one such place.
fn fall(shape: &Shape, order: f64, direction: f64) -> f64 {
    let value = |t: f64| shape.log_density(t) + (order + 1.0) * t;
    let peak = shape.log_peak(order);
    let has_fallen = |distance: f64| value(peak) - value(peak + direction * distance) >= SUPPORT_DROP;
    let mut far = 1e-3;
    // Doubling reaches ln r of +-1000, far beyond any length, in twenty steps.
    while !has_fallen(far) && far < 1e3 {
        far *= 2.0;
    }
    let mut near = 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        if has_fallen(middle) { far = middle } else { near = middle }
    }
    peak + direction * far
}

/// The default limits of a shape, m; see [`SizeDistribution::new`].
pub(super) fn default_limits(shape: &Shape) -> (f64, f64) {
    match shape {
        Shape::Mono { r_m } => (*r_m, *r_m),
        Shape::Table { r_m, .. } => (r_m[0], r_m[r_m.len() - 1]),
        shape => {
            let (lower, upper) = support(shape);
            let by_area = share_quantile(shape, (lower, upper), 2.0, TAIL_SHARE);
            let smallest = by_area.min(SMALLEST_FRACTION * shape.log_peak(2.0).exp());
            let r_min_m = share_quantile(shape, (lower, upper), 0.0, TAIL_SHARE).max(smallest);
            (r_min_m, share_quantile(shape, (lower, upper), 4.0, 1.0 - TAIL_SHARE))
        }
    }
}

/// The radius below which a share `u` of the sum of r^order lies, to a cell of the support.
fn share_quantile(shape: &Shape, (lower, upper): (f64, f64), order: f64, u: f64) -> f64 {
    let nodes = uniform(lower, upper);
    let rule = GaussLegendre::new(POINTS);
    let shift = shape.log_density(shape.log_peak(order)) + (order + 1.0) * shape.log_peak(order);
    let weight = |t: f64| (shape.log_density(t) + (order + 1.0) * t - shift).exp();
    let cells: Vec<f64> = nodes.windows(2).map(|t| rule.integrate(t[0], t[1], weight)).collect();
    let total: f64 = cells.iter().sum();
    let count = if u < 0.5 {
        cells_within(cells.iter(), u * total)
    } else {
        cells.len() - cells_within(cells.iter().rev(), (1.0 - u) * total)
    };
    nodes[count].exp()
}

/// How many cells, one after the other, hold no more than `limit`.
fn cells_within<'a>(cells: impl Iterator<Item = &'a f64>, limit: f64) -> usize {
    let mut sum = 0.0;
    cells
        .take_while(|cell| {
            sum += **cell;
            sum <= limit
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(text: &str) -> SizeLaw {
        let read = |_: &str| Ok("radius_um,dn_dr\n1,0\n5,2\n20,1\n".into());
        SizeDistribution::parse(text, &read).expect(text).law()
    }

    const ALL: [&str; 9] = [
        "gamma:reff=6um,veff=0.1",
        "gamma:reff=6um,veff=0.45",
        "gamma:reff=6um,veff=0.00001,rmin=0.001um,rmax=60um",
        "modgamma:alpha=6,gamma=1,rc=4um",
        "modgamma:alpha=2,gamma=0.5,rc=0.07um",
        "lognormal:rg=3um,sigma=0.4",
        "lognormal:rg=0.1um,sigma=1.5",
        "lognormal:rg=3um,sigma=0.4,rmin=1um,rmax=2um",
        "csv:f",
    ];

    #[test]
    fn moments_are_those_of_the_closed_forms() {
        let close = |found: f64, exact: f64| assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
        let gamma = law("gamma:reff=6um,veff=0.1");
        close(gamma.effective_radius_m(), 6e-6);
        close(gamma.effective_variance(), 0.1);
        let haze = law("lognormal:rg=3um,sigma=0.4");
        close(haze.effective_radius_m(), 3e-6 * (2.5f64 * 0.16).exp());
        close(haze.moment(1), 3e-6 * (0.5f64 * 0.16).exp());
        // Deirmendjian's Cloud C1: r_eff = (alpha + 3) / alpha rc for gamma = 1.
        close(law("modgamma:alpha=6,gamma=1,rc=4um").effective_radius_m(), 6e-6);
        close(law("mono:r=5um").mean_area_m2(), 25e-12 * std::f64::consts::PI);
        close(law("gamma:reff=6um,veff=0.00001,rmin=0.001um,rmax=60um").effective_variance(), 1e-5);
    }

    #[test]
    fn default_limits_leave_out_less_than_a_millionth() {
        for text in ALL {
            let law = law(text);
            let shape = law.distribution.shape.clone();
            if matches!(shape, Shape::Table { .. }) {
                continue;
            }
            let (r_min_m, r_max_m) = default_limits(&shape);
            let (lower, upper) = support(&shape);
            let rule = GaussLegendre::new(POINTS);
            for order in [2.0, 3.0] {
                let weight = |t: f64| (shape.log_density(t) + (order + 1.0) * t - (order + 1.0) * upper).exp();
                let sum =
                    |a: f64, b: f64| uniform(a, b).windows(2).map(|t| rule.integrate(t[0], t[1], weight)).sum::<f64>();
                let left_out = 1.0 - sum(r_min_m.ln(), r_max_m.ln()) / sum(lower, upper);
                assert!(left_out.abs() < 1e-6, "{text}: r^{order} {left_out:e}");
            }
        }
    }

    #[test]
    fn the_density_is_normalised() {
        for text in ALL {
            let law = law(text);
            let by_radius: f64 = law
                .nodes
                .windows(2)
                .map(|t| {
                    GaussLegendre::new(POINTS)
                        .integrate(law.radius(t[0]), law.radius(t[1]), |r_m| law.number_density(r_m))
                })
                .sum();
            assert!((by_radius - 1.0).abs() < 1e-9, "{text}: {by_radius}");
        }
    }

    #[test]
    fn quantiles_invert_the_cumulative_number() {
        for text in ALL {
            let law = law(text);
            let rule = GaussLegendre::new(POINTS);
            for i in 0..=100 {
                let u = f64::from(i) / 100.0;
                let r_m = law.quantile(u);
                let t = if is_logarithmic(&law.distribution.shape) { r_m.ln() } else { r_m };
                let below = law.nodes.windows(2).take_while(|cell| cell[0] < t);
                let share: f64 = below
                    .map(|cell| rule.integrate(cell[0], cell[1].min(t), |t| law.density_over_t(t)) / law.norm)
                    .sum();
                assert!((share - u).abs() < 1e-8, "{text} {u}: {share}");
            }
        }
        assert_eq!(law("mono:r=5um").quantile(0.3), 5e-6);
    }
}
