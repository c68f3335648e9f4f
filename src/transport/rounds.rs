//! How many samples each pixel gets next: the same for all, or more where the noise is.
//!
//! The work for a given noise is least where a pixel's samples are in proportion to the standard deviation of one of them
//! (theory (91)). That is learned from the samples so far, pooled over tiles, since the few samples of one pixel may have
//! missed what matters. Pixels are coloured like a chessboard, and a pixel's number of samples is learned from pixels of the
//! other colour only: if a rare bright sample of its own earned it more samples, these would dilute it, and the picture
//! would be too dark.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::render::Until;
use crate::film::{Film, Spread, Tile, block_of};

/// Every pixel has as many samples before noise is looked at: fewer cannot tell.
const PILOT: u32 = 16;

/// Share of the picture's mean variance that is added to every pixel's own: what was missed so far gets some samples too.
/// It costs a few percent: a pixel that shows no variance gets a tenth of the samples of an average one.
const BENEFIT_OF_DOUBT: f64 = 0.01;

/// Noise falls at most by this factor in a round, and samples of a pixel at most double: then more is known.
const LARGEST_STEP: f64 = 0.75;

/// Samples that each pixel should have after a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Targets {
    /// As many in every pixel.
    Even(u32),
    /// By tile, for pixels of even and of odd x + y.
    ByTile(Vec<[u32; 2]>),
}

impl Targets {
    /// Whether there is a target for every tile of a film, none above the most samples that a pixel may have.
    pub fn fit(&self, film: &Film, most: u32) -> bool {
        match self {
            Self::Even(n) => *n <= most,
            Self::ByTile(targets) => targets.len() == film.n_tiles() && targets.iter().flatten().all(|n| *n <= most),
        }
    }

    pub fn of(&self, tile: usize, x: usize, y: usize) -> u32 {
        match self {
            Self::Even(n) => *n,
            Self::ByTile(targets) => targets[tile][(x + y) % 2],
        }
    }
}

/// What is to be done next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Round {
    pub targets: Targets,
    /// Samples that the finished picture will have taken, as far as can be told.
    pub expected: u64,
}

/// The next round for the film of a run of samples; `None` where the run is done.
///
/// Even rounds double the samples, so that their sums join exactly (`film::Tally`), and begin with the first block, from 0
/// on with one sample, so that there is something to show at once.
pub(super) fn next_round(film: &Film, until: Until, run: &Range<u32>) -> Option<Round> {
    let pixels = (film.width() * film.height()) as u64;
    let each = u32::try_from(film.samples() / pixels.max(1)).unwrap_or(u32::MAX);
    let first = block_of(run.start).len() as u32;
    let even = |most: u32, expected: u32| {
        let next = each.saturating_mul(2).max(first).min(most);
        Round { targets: Targets::Even(next), expected: pixels * u64::from(expected.max(next)) }
    };
    match until {
        _ if pixels == 0 => None,
        Until::Samples(n) => (each < n).then(|| even(n, n)),
        Until::Range { first, end } => {
            let n = run.len() as u32;
            (each < n).then(|| even(n, end.saturating_sub(first)))
        }
        Until::Noise { target, at_most } if each < PILOT.min(at_most) => {
            Some(even(PILOT.min(at_most), expected_each(film, each, target, at_most)))
        }
        Until::Noise { target, at_most } => Survey::new(film).next_round(target, at_most),
    }
}

/// Noise falls like the root of the number of samples; while it is not known, what tells it is expected.
fn expected_each(film: &Film, each: u32, target: f64, at_most: u32) -> u32 {
    let excess = film.noise() / target;
    if each == 0 || !excess.is_finite() {
        return PILOT.min(at_most);
    }
    (f64::from(each) * excess * excess).ceil().clamp(f64::from(PILOT.min(at_most)), f64::from(at_most)) as u32
}

/// What is known about pixels of one colour in one tile.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    pixels: f64,
    /// Samples of each pixel.
    samples: f64,
    /// Variance of one sample.
    variance: f64,
    /// Its root as learned from pixels of the other colour: what the number of samples goes by.
    deviation: f64,
}

/// What is known about the noise of a picture.
struct Survey {
    cells: Vec<[Cell; 2]>,
    noise: f64,
    uncertainty: f64,
}

impl Survey {
    fn new(film: &Film) -> Self {
        let spreads = film.tile_spreads();
        let mut all = Spread::default();
        spreads.iter().flatten().for_each(|spread| all.add(spread));
        let doubt = BENEFIT_OF_DOUBT * all.mean();
        let columns = Tile::columns(film.width());
        let cells = (0..spreads.len()).map(|tile| cells(&spreads, columns, tile, doubt)).collect();
        let noise = film.noise_and_uncertainty();
        Self { cells, noise: noise.relative, uncertainty: noise.uncertainty }
    }

    fn next_round(&self, target: f64, at_most: u32) -> Option<Round> {
        // Noise that chance has made look small is not believed: its variance may be higher by two standard errors.
        let believed = target / (1.0 + 2.0 * self.uncertainty).sqrt();
        if self.noise <= believed {
            return None;
        }
        let at_most_each = f64::from(at_most);
        let all_of_it = self.factor_for(believed / self.noise, at_most_each);
        let expected = self.samples(|cell| cell.wanted(all_of_it, at_most_each));
        let step = (believed / self.noise).max(LARGEST_STEP);
        let mut factor = self.factor_for(step, at_most_each);
        // Rounding to whole blocks may leave nothing to do.
        loop {
            let targets = self.targets(factor, at_most);
            let grown = self.cells.iter().flatten().zip(targets.iter().flatten());
            if grown.clone().any(|(cell, target)| f64::from(*target) > cell.samples) {
                return Some(Round { targets: Targets::ByTile(targets), expected: expected.ceil() as u64 });
            }
            if self.cells.iter().flatten().all(|cell| cell.pixels == 0.0 || cell.samples >= at_most_each) {
                return None;
            }
            factor *= 1.1;
        }
    }

    /// The factor by which samples are in proportion to deviations so that the noise falls to `fall` of what it is.
    fn factor_for(&self, fall: f64, at_most: f64) -> f64 {
        let now = self.variance(0.0, at_most);
        let (mut low, mut high) = (0.0, 1.0);
        let deviation = self.cells.iter().flatten().map(|cell| cell.deviation).fold(0.0, f64::max);
        // In units in which the largest deviation asks for one sample.
        let scale = if deviation > 0.0 { 1.0 / deviation } else { 0.0 };
        while self.variance(high * scale, at_most) > fall * fall * now && high < 1e3 * at_most {
            (low, high) = (high, 2.0 * high);
        }
        while high - low > 1e-3 * high {
            let middle = 0.5 * (low + high);
            if self.variance(middle * scale, at_most) > fall * fall * now { low = middle } else { high = middle }
        }
        high * scale
    }

    /// Sum over pixels of the variance of their means, had they the samples that the factor asks for.
    fn variance(&self, factor: f64, at_most: f64) -> f64 {
        self.cells.iter().flatten().map(|cell| cell.pixels * cell.variance / cell.wanted(factor, at_most)).sum()
    }

    /// Samples of all pixels together.
    fn samples(&self, each: impl Fn(&Cell) -> f64) -> f64 {
        self.cells.iter().flatten().map(|cell| cell.pixels * each(cell)).sum()
    }

    /// Whole blocks of samples for each cell: rounded up or down so that the mean over neighbours is what is wanted.
    fn targets(&self, factor: f64, at_most: u32) -> Vec<[u32; 2]> {
        let target = |tile: usize, colour: usize| {
            let cell = &self.cells[tile][colour];
            let wanted = cell.wanted(factor, f64::from(at_most).min(2.0 * cell.samples));
            let block = block_of(wanted as u32);
            let share = (wanted - f64::from(block.start)) / f64::from(block.end - block.start);
            // Multiples of the golden ratio spread evenly.
            let threshold = ((2 * tile + colour) as f64 * 0.618_033_988_749_895).fract();
            let whole = if share > threshold { block.end } else { block.start };
            whole.min(at_most).max(cell.samples as u32)
        };
        (0..self.cells.len()).map(|tile| [target(tile, 0), target(tile, 1)]).collect()
    }
}

impl Cell {
    /// Samples of each pixel: in proportion to the deviation, as many as there are already at least.
    fn wanted(&self, factor: f64, at_most: f64) -> f64 {
        (factor * self.deviation).min(at_most).max(self.samples).max(1.0)
    }
}

/// What is known about one tile, from itself and its neighbours.
fn cells(spreads: &[[Spread; 2]], columns: usize, tile: usize, doubt: f64) -> [Cell; 2] {
    let rows = spreads.len() / columns;
    let (column, row) = (tile % columns, tile / columns);
    let mut pooled = [Spread::default(); 2];
    for y in row.saturating_sub(1)..rows.min(row + 2) {
        for x in column.saturating_sub(1)..columns.min(column + 2) {
            pooled.iter_mut().zip(&spreads[y * columns + x]).for_each(|(sum, spread)| sum.add(spread));
        }
    }
    let mut both = pooled[0];
    both.add(&pooled[1]);
    [0, 1].map(|colour| {
        let own = &spreads[tile][colour];
        // A picture of one pixel has no other colour.
        let other = if pooled[1 - colour].pixels > 0 { pooled[1 - colour].mean() } else { both.mean() };
        Cell {
            pixels: f64::from(own.pixels),
            samples: own.samples as f64 / f64::from(own.pixels.max(1)),
            variance: both.mean(),
            deviation: (other + doubt).sqrt(),
        }
    })
}
