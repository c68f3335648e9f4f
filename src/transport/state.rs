//! How far a render is: everything that is needed to go on as if it had not been interrupted.

use std::ops::Range;

use super::render::{RayCounts, RenderOutcome, RenderRequest, Spectral, Until};
use super::rounds::{Round, next_round};
use super::sample::RenderContext;
use crate::film::{Film, Joiner};

/// The sums so far, and the round that has been begun: its targets follow from the film before it, which is gone.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderState {
    /// A film for each run of samples that has been begun; the last one may be unfinished.
    pub(super) films: Vec<Film>,
    /// The round that the last film is in.
    pub(super) round: Option<Round>,
    /// Rays traced so far.
    pub(super) rays: RayCounts,
}

impl RenderState {
    /// Nothing yet.
    pub fn new(ctx: &RenderContext, request: &RenderRequest) -> Self {
        let n_spectral = if request.spectral == Spectral::Keep { ctx.media.n_wavelengths() } else { 0 };
        let [_, _, width, height] = request.crop;
        let film = Film::new(width, height, &request.layers, n_spectral);
        Self { films: vec![film], round: None, rays: RayCounts::default() }
    }

    /// Whether a state that was read belongs to this request: `empty` is its beginning.
    pub fn fits(&self, empty: &Self, until: Until) -> bool {
        let shaped = self.films.iter().zip(empty.films.iter().cycle()).all(|(film, empty)| film.has_shape_of(empty));
        let most = match until {
            Until::Samples(n) => n,
            Until::Range { first, end } => end.saturating_sub(first),
            Until::Noise { at_most, .. } => at_most,
        };
        let round_fits = self.round.iter().all(|round| self.films.iter().all(|film| round.targets.fit(film, most)));
        shaped && round_fits && (1..=until.runs().len()).contains(&self.films.len())
    }

    /// The latest sums in which every pixel has a sample, or else the latest: what there is to look at.
    pub fn latest(&self) -> Option<&Film> {
        self.films.iter().rfind(|film| film.is_covered()).or(self.films.last())
    }

    /// The sums of every run that has been begun, in order.
    pub fn into_films(self) -> Vec<Film> {
        self.films
    }

    /// Samples of all pixels together.
    pub fn samples(&self) -> u64 {
        self.films.iter().map(Film::samples).sum()
    }

    /// Rays traced for these sums, before and after they were kept.
    pub fn rays(&self) -> RayCounts {
        self.rays
    }

    /// The outcome, if nothing more is done.
    pub fn finish(self, request: &RenderRequest, stopped: bool) -> RenderOutcome {
        let runs = request.until.runs();
        // Made only where it is needed: a film is large.
        let empty = self.films.first().filter(|_| runs.is_empty()).map(Film::emptied);
        let mut joiner = Joiner::default();
        runs.into_iter().zip(self.films).for_each(|(run, film)| joiner.push(run, film));
        let film = joiner.finish().or(empty).unwrap_or_else(|| Film::new(0, 0, &[], 0));
        RenderOutcome { samples: film.mean_samples(), film, rays: self.rays, stopped }
    }

    /// The number of the run in work.
    pub(super) fn current(&self) -> usize {
        self.films.len().saturating_sub(1)
    }

    /// The film of the run in work; there is always one.
    pub(super) fn film(&mut self) -> &mut Film {
        let last = self.current();
        &mut self.films[last]
    }

    pub(super) fn begin_run(&mut self) {
        let empty = self.film().emptied();
        self.films.push(empty);
    }

    /// The round that has been begun, or the next one; `None` where the run is done.
    pub(super) fn begin_round(&mut self, until: Until, run: &Range<u32>) -> Option<Round> {
        if self.round.is_none() {
            self.round = next_round(self.film(), until, run);
        }
        self.round.clone()
    }

    pub(super) fn end_round(&mut self) {
        self.round = None;
    }

    /// Whether every pixel has a sample.
    pub(super) fn is_covered(&self) -> bool {
        self.films.len() > 1 || self.films.iter().all(Film::is_covered)
    }
}
