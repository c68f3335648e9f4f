//! Radii in logarithmic bins, as numbers and as a small chart of characters.

use crate::optics::distribution::SizeDistribution;
use crate::optics::size_law::SizeLaw;
use crate::units::short::length;

/// Bins of a histogram, but for a single radius.
const BINS: usize = 16;

/// Lines of a chart, and the steps that each divides into.
const ROWS: usize = 3;
const STEPS: [char; 4] = [' ', '.', ':', '#'];

/// Radii in bins that are equal in ln r; a single bin without width for a single radius.
#[derive(Debug)]
pub struct Histogram {
    /// The least radius, m.
    pub least_m: f64,
    /// Sum of r^3 over sum of r^2, m.
    pub effective_m: f64,
    /// The largest radius, m.
    pub greatest_m: f64,
    /// Edges of the bins, m, from the least radius to the largest.
    pub edges_m: Vec<f64>,
    /// How many are in each bin: particles and fog boxes, or shares of the number of droplets.
    pub amounts: Vec<f64>,
}

impl Histogram {
    /// Of a distribution between its limits: shares of the number of droplets.
    pub fn of_law(distribution: &SizeDistribution) -> Self {
        let law = distribution.law();
        let (least_m, greatest_m) = ends_m(distribution, &law);
        let edges_m = edges_m(least_m, greatest_m);
        let inner = edges_m[1..edges_m.len() - 1].iter().map(|r_m| share_below(&law, *r_m));
        let below: Vec<f64> = std::iter::once(0.0).chain(inner).chain([1.0]).collect();
        let amounts = below.windows(2).map(|share| share[1] - share[0]).collect();
        let effective_m = law.mono_radius().unwrap_or_else(|| law.effective_radius_m());
        Self { least_m, effective_m, greatest_m, edges_m, amounts }
    }

    /// Whether all radii are one.
    pub fn is_single(&self) -> bool {
        self.amounts.len() < 2
    }

    /// A chart of a few lines beside a label, with the radii at its ends; none of a single radius. What holds any droplet has a dot
    /// at least.
    pub fn chart(&self, label: &str, remark: &str) -> Option<String> {
        if self.is_single() {
            return None;
        }
        let [least, effective, greatest] = [self.least_m, self.effective_m, self.greatest_m].map(length);
        let rows = rows(&self.amounts);
        let blank = " ".repeat(label.chars().count());
        let mut out = String::new();
        for (i, row) in rows.iter().enumerate() {
            let label = if i == 0 { label } else { &blank };
            let is_last = i + 1 == rows.len();
            let (left, right) = match is_last {
                true => (least.as_str(), format!(" {greatest}, effective {effective}{remark}")),
                false => ("", String::new()),
            };
            let line = format!("{label}{left:<width$} {row}{right}", width = least.chars().count());
            out.push_str(line.trim_end());
            out.push('\n');
        }
        Some(out)
    }
}

/// The columns of a chart, line by line from the top.
fn rows(amounts: &[f64]) -> Vec<String> {
    let most = amounts.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let per_row = STEPS.len() - 1;
    let height = |amount: &f64| (amount / most * (ROWS * per_row) as f64).ceil() as usize;
    let cell = |row: usize, amount: &f64| STEPS[height(amount).saturating_sub(row * per_row).min(per_row)];
    (0..ROWS).rev().map(|row| amounts.iter().map(|amount| cell(row, amount)).collect()).collect()
}

/// The limits of a distribution as far as it is worth counting, m.
fn ends_m(distribution: &SizeDistribution, law: &SizeLaw) -> (f64, f64) {
    let (r_min_m, r_max_m) = (distribution.r_min_m, distribution.r_max_m);
    let cells = law.cells().reduce(|all, cell| (all.0, cell.1));
    cells.map_or((r_min_m, r_max_m), |(least_m, greatest_m)| (least_m.max(r_min_m), greatest_m.min(r_max_m)))
}

/// Edges of bins, m; the first and the last are the ends as they are.
fn edges_m(least_m: f64, greatest_m: f64) -> Vec<f64> {
    if least_m >= greatest_m {
        return vec![least_m, greatest_m];
    }
    let width = (greatest_m / least_m).ln() / BINS as f64;
    let inner = (1..BINS).map(|i| (least_m * (width * i as f64).exp()).clamp(least_m, greatest_m));
    std::iter::once(least_m).chain(inner).chain([greatest_m]).collect()
}

/// Share of droplets with radii below one, by bisection of the quantiles.
fn share_below(law: &SizeLaw, r_m: f64) -> f64 {
    let (mut below, mut above) = (0.0, 1.0);
    // To the last bit of a share.
    for _ in 0..53 {
        let middle = 0.5 * (below + above);
        if law.quantile(middle) < r_m { below = middle } else { above = middle }
    }
    0.5 * (below + above)
}

/// Gathers a histogram of radii in two passes: first all are given to `extend`, then all to `count`.
#[derive(Debug, Default)]
pub struct Tally {
    /// Whether there was any without a radius of its own.
    pub follows_law: bool,
    ends_m: Option<(f64, f64)>,
    edges_m: Vec<f64>,
    counts: Vec<u64>,
    squares_m2: f64,
    cubes_m3: f64,
}

impl Tally {
    /// The first pass.
    pub fn extend(&mut self, radius_m: Option<f64>) {
        match (radius_m, self.ends_m) {
            (None, _) => self.follows_law = true,
            (Some(r_m), None) => self.ends_m = Some((r_m, r_m)),
            (Some(r_m), Some((least, most))) => self.ends_m = Some((r_m.min(least), r_m.max(most))),
        }
    }

    /// The second pass.
    pub fn count(&mut self, radius_m: Option<f64>) {
        let (Some(r_m), Some((least_m, greatest_m))) = (radius_m, self.ends_m) else { return };
        if self.edges_m.is_empty() {
            self.edges_m = edges_m(least_m, greatest_m);
            self.counts = vec![0; self.edges_m.len() - 1];
        }
        // The largest radius belongs to the last bin.
        let bin = self.edges_m.partition_point(|edge_m| *edge_m <= r_m).clamp(1, self.counts.len()) - 1;
        self.counts[bin] += 1;
        self.squares_m2 += r_m.powi(2);
        self.cubes_m3 += r_m.powi(3);
    }

    /// The histogram; none where nothing has a radius of its own.
    pub fn finish(self) -> Option<Histogram> {
        let (least_m, greatest_m) = self.ends_m?;
        Some(Histogram {
            least_m,
            // Sums round.
            effective_m: (self.cubes_m3 / self.squares_m2).clamp(least_m, greatest_m),
            greatest_m,
            edges_m: self.edges_m,
            amounts: self.counts.iter().map(|count| *count as f64).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tallied(radii_m: &[f64]) -> Histogram {
        let mut tally = Tally::default();
        radii_m.iter().for_each(|r_m| tally.extend(Some(*r_m)));
        radii_m.iter().for_each(|r_m| tally.count(Some(*r_m)));
        tally.finish().expect("radii")
    }

    fn of_law(text: &str) -> Histogram {
        let read = |_: &str| Ok("radius_um,dn_dr\n1,0\n5,2\n20,1\n".into());
        Histogram::of_law(&SizeDistribution::parse(text, &read).expect(text))
    }

    #[test]
    fn every_radius_is_in_its_bin() {
        // Powers of 10^(1/16) from the first edge on, a little above the edges.
        let radii: Vec<f64> =
            (0..16).map(|i| 1e-6 * 10f64.powf(f64::from(i) / 16.0 + 1e-9)).chain([1e-6, 1e-5]).collect();
        let histogram = tallied(&radii);
        assert_eq!(histogram.edges_m.len(), 17);
        assert_eq!((histogram.edges_m[0], histogram.edges_m[16]), (1e-6, 1e-5));
        let mut expected = [1.0; 16];
        (expected[0], expected[15]) = (2.0, 2.0);
        assert_eq!(histogram.amounts, expected);
        let one = tallied(&[5e-6; 7]);
        assert_eq!((one.amounts.as_slice(), one.effective_m), (&[7.0][..], 5e-6));
        assert!(one.chart("", "").is_none());
        // 1 + 8 over 1 + 4.
        assert!((tallied(&[1.0, 2.0]).effective_m - 1.8).abs() < 1e-12);
    }

    #[test]
    fn shares_are_those_of_the_density() {
        for text in [
            "gamma:reff=6um,veff=0.1",
            "lognormal:rg=3um,sigma=0.4",
            "csv:f",
            "gamma:reff=6um,veff=0.1,rmin=5um,rmax=7um",
        ] {
            let histogram = of_law(text);
            let read = |_: &str| Ok("radius_um,dn_dr\n1,0\n5,2\n20,1\n".into());
            let law = SizeDistribution::parse(text, &read).expect(text).law();
            assert!((histogram.amounts.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{text}");
            for (edges, share) in histogram.edges_m.windows(2).zip(&histogram.amounts) {
                // Midpoints: with 1000 the error is below 1e-6 of the bin but where the density has a kink.
                let step = (edges[1] - edges[0]) / 1000.0;
                let sum: f64 =
                    (0..1000).map(|i| law.number_density(edges[0] + (f64::from(i) + 0.5) * step) * step).sum();
                assert!((sum - share).abs() < 1e-6, "{text}: {edges:?} {sum} {share}");
            }
        }
        assert_eq!(of_law("mono:r=5um").amounts, [1.0]);
        assert_eq!(of_law("mono:r=5um").edges_m, [5e-6, 5e-6]);
    }

    #[test]
    fn charts_are_as_high_as_the_amounts() {
        assert_eq!(rows(&[0.0, 1.0, 2.0, 3.0, 6.0, 9.0, 0.01]), ["     # ", "    ## ", " .:###."]);
        let histogram = Histogram {
            least_m: 1e-6,
            effective_m: 2e-6,
            greatest_m: 4e-6,
            edges_m: vec![1e-6, 2e-6, 4e-6],
            amounts: vec![1.0, 3.0],
        };
        let chart = histogram.chart("sizes ", "").expect("two bins");
        assert_eq!(chart, "sizes       #\n            #\n      1 um ## 4 um, effective 2 um\n");
    }
}
