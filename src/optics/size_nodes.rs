//! Which radii stand for a size distribution in an average: Gauss-Legendre panels, narrow where the light is scattered.
//!
//! The integrand has ripples about one unit of x apart and resonances far narrower than any spacing: what limits an
//! average is how many radii stand where light is scattered, and how evenly. So panels are laid by weight, three
//! quarters by area, some by r^4 (which the forward peak follows), the rest evenly; and they have two points each,
//! nearly evenly spaced. Measured over 18 distributions, 4096 radii: p is off by 4e-3 at the worst of 60 angles (rms
//! over the distributions); 16 points per panel, or other shares, give up to 6e-3.

use super::quadrature::GaussLegendre;
use super::size_law::SizeLaw;

/// Points per panel; see the top of the file.
const PANEL_POINTS: usize = 2;

/// Shares of the panels laid by area, by r^4, and evenly over the radii; see the top of the file.
const SHARES: [f64; 3] = [0.75, 0.15, 0.1];

/// Share of the area below, and of r^6 above, the radii that are used: well below the tolerances of averages.
const NEGLIGIBLE: f64 = 1e-8;

/// The strata of a size law, ready to be divided into panels.
#[derive(Clone, Debug)]
pub struct SizeStrata<'a> {
    law: &'a SizeLaw,
    /// Edges of the cells that matter, m.
    edges: Vec<f64>,
    /// Share of the panels up to each edge.
    share: Vec<f64>,
}

impl<'a> SizeStrata<'a> {
    /// The strata of a law that holds more than one radius.
    pub fn new(law: &'a SizeLaw) -> Self {
        let rule = GaussLegendre::new(4);
        let cells: Vec<(f64, f64)> = law.cells().collect();
        let weigh = |order: i32| -> Vec<f64> {
            let cell = |(a, b): &(f64, f64)| rule.integrate(*a, *b, |r_m| law.number_density(r_m) * r_m.powi(order));
            cells.iter().map(cell).collect()
        };
        let (area, peak, rayleigh) = (weigh(2), weigh(4), weigh(6));
        let first = negligible(area.iter());
        let end = cells.len() - negligible(rayleigh.iter().rev());
        let (first, end) = if first < end { (first, end) } else { (0, cells.len()) };
        let width: Vec<f64> = cells.iter().map(|(a, b)| b - a).collect();
        let total = |weights: &[f64]| weights[first..end].iter().sum::<f64>();
        let totals = [total(&area), total(&peak), total(&width)];
        let mut strata = Self { law, edges: vec![cells[first].0], share: vec![0.0] };
        let mut sum = 0.0;
        for i in first..end {
            let parts = [area[i], peak[i], width[i]];
            sum += (0..3).map(|k| SHARES[k] * parts[k] / totals[k]).sum::<f64>();
            strata.edges.push(cells[i].1);
            strata.share.push(sum);
        }
        strata.share.iter_mut().for_each(|share| *share /= sum);
        strata
    }

    /// The middle of the radii by the number that stand for them, m.
    pub fn mean_radius_m(&self) -> f64 {
        self.edge(0.5)
    }

    /// About `count` radii in m with their shares of the droplets.
    pub fn nodes(&self, count: usize) -> Vec<(f64, f64)> {
        let panels = (count / PANEL_POINTS).max(1);
        let rule = GaussLegendre::new(PANEL_POINTS);
        let edges: Vec<f64> = (0..=panels).map(|i| self.edge(i as f64 / panels as f64)).collect();
        let mut nodes = Vec::with_capacity(panels * PANEL_POINTS);
        for edge in edges.windows(2) {
            let (middle, half) = (0.5 * (edge[0] + edge[1]), 0.5 * (edge[1] - edge[0]));
            for (x, weight) in &rule.points {
                let r_m = middle + half * x;
                nodes.push((r_m, half * weight * self.law.number_density(r_m)));
            }
        }
        nodes
    }

    /// The radius up to which there is a share of the panels, linear within cells.
    fn edge(&self, share: f64) -> f64 {
        let i = self.share.partition_point(|value| *value <= share).clamp(1, self.share.len() - 1);
        let t = (share - self.share[i - 1]) / (self.share[i] - self.share[i - 1]);
        self.edges[i - 1] + t.clamp(0.0, 1.0) * (self.edges[i] - self.edges[i - 1])
    }
}

/// How many weights, one after the other, add up to a negligible share of all.
fn negligible<'a>(weights: impl Iterator<Item = &'a f64> + Clone) -> usize {
    let limit = NEGLIGIBLE * weights.clone().sum::<f64>();
    let mut sum = 0.0;
    weights
        .take_while(|weight| {
            sum += **weight;
            sum <= limit
        })
        .count()
}
