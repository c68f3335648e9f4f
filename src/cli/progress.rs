//! How far the picture is: a bar on a terminal, plain lines otherwise, nothing when quiet.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::checkpoint::Checkpoints;
use super::interrupt::Interrupts;
use super::say::say;
use crate::film::Film;
use crate::image::file::FileError;
use crate::transport::{Progress, RenderState};

/// How much the program says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum Verbosity {
    Quiet,
    Normal,
    Verbose,
}

/// Plain lines come at most this often.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// Steps of the bar.
const BAR_LENGTH: u64 = 1000;

/// Shows progress, and ends the render when its time is up or the user has had enough.
pub struct Shown {
    bar: Option<ProgressBar>,
    started: Instant,
    last_line: Option<Mutex<Instant>>,
    /// What was known at the end of the last round.
    state: Mutex<String>,
    time_limit: Option<Duration>,
    interrupts: Interrupts,
    checkpoints: Option<Checkpoints>,
}

impl Shown {
    /// Progress on stderr, the seconds after which to stop, the interrupts that stop it sooner, and what is kept meanwhile.
    pub fn new(
        verbosity: Verbosity,
        time_limit_s: Option<f64>,
        interrupts: Interrupts,
        checkpoints: Option<Checkpoints>,
    ) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let quiet = verbosity == Verbosity::Quiet;
        let bar = (!quiet && terminal).then(|| {
            let style = ProgressStyle::with_template("{prefix} [{wide_bar}] {percent:>3} % {msg}, {eta} left");
            ProgressBar::new(BAR_LENGTH)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
                .with_prefix("render")
        });
        Self {
            bar,
            started: Instant::now(),
            state: Mutex::default(),
            last_line: (!quiet && !terminal).then(|| Mutex::new(Instant::now())),
            time_limit: time_limit_s.map(Duration::from_secs_f64),
            interrupts,
            checkpoints,
        }
    }

    /// Whether the user wanted an early end.
    pub fn interrupted(&self) -> bool {
        self.interrupts.heard()
    }

    /// Keeps the state at the end.
    ///
    /// # Errors
    /// When the checkpoint cannot be written.
    pub fn keep(&self, state: &RenderState) -> Result<(), FileError> {
        self.checkpoints.iter().try_for_each(|checkpoints| checkpoints.write(state))
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// Share of the picture that is done: of its samples, or of its time.
    fn share(&self, taken: u64, expected: u64) -> f64 {
        let of_time = self.time_limit.map_or(0.0, |limit| self.started.elapsed().as_secs_f64() / limit.as_secs_f64());
        (taken as f64 / expected.max(1) as f64).max(of_time).min(1.0)
    }

    fn show(&self, taken: u64, expected: u64, state: &str) {
        let share = self.share(taken, expected);
        if let Some(bar) = &self.bar {
            bar.set_position((share * BAR_LENGTH as f64) as u64);
        }
        // Whoever finds the line taken has nothing newer to say.
        let Some(mut last) = self.last_line.as_ref().and_then(|last| last.try_lock().ok()) else { return };
        if last.elapsed() < LINE_EVERY || share >= 1.0 || share == 0.0 {
            return;
        }
        *last = Instant::now();
        let left = self.started.elapsed().as_secs_f64() * (1.0 / share - 1.0);
        say!("render: {:.0} %, {state}about {left:.0} s left", 100.0 * share);
    }
}

impl Progress for Shown {
    fn samples(&self, taken: u64, expected: u64) {
        if self.bar.is_some() || self.last_line.is_some() {
            let state = self.state.lock().map(|state| state.clone()).unwrap_or_default();
            self.show(taken, expected, &state);
        }
    }

    fn round(&self, taken: u64, expected: u64, film: &Film) {
        let pixels = (film.width() * film.height()).max(1) as f64;
        let each = |samples: u64| (samples as f64 / pixels).round();
        let state = format!("{}/{} spp, noise {:.4}", each(taken), each(expected.max(taken)), film.noise());
        if let Some(bar) = &self.bar {
            bar.set_message(state.clone());
        }
        if let Ok(mut shown) = self.state.lock() {
            *shown = format!("{state}, ");
        }
        self.samples(taken, expected);
    }

    fn should_stop(&self) -> bool {
        self.interrupts.heard() || self.time_limit.is_some_and(|limit| self.started.elapsed() >= limit)
    }

    fn should_pause(&self) -> bool {
        self.checkpoints.as_ref().is_some_and(Checkpoints::due)
    }

    fn pause(&self, state: &RenderState) {
        if let Some(checkpoints) = &self.checkpoints {
            checkpoints.write_or_warn(state);
        }
    }
}
