//! How far the picture is: a bar on a terminal, plain lines otherwise, nothing when quiet.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::checkpoint::Checkpoints;
use super::interrupt::Interrupts;
use super::previews::Previews;
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

/// Before this the first tiles tell too little of how long the rest takes.
const FORETOLD_AFTER_S: f64 = 2.0;

/// Steps of the bar.
const BAR_LENGTH: u64 = 1000;

/// Says on a terminal what is being done before there is a picture to show progress of; gone when it is dropped.
pub struct Busy(Option<ProgressBar>);

impl Busy {
    /// Begins with `what`.
    pub fn with(what: &'static str, verbosity: Verbosity) -> Self {
        let shown = verbosity > Verbosity::Quiet && std::io::stderr().is_terminal();
        let spinner = shown.then(ProgressBar::new_spinner);
        if let Some(spinner) = &spinner {
            spinner.set_message(what);
            spinner.enable_steady_tick(Duration::from_millis(100));
        }
        Self(spinner)
    }

    /// Goes on with `what`.
    pub fn with_next(&self, what: &'static str) {
        if let Some(spinner) = &self.0 {
            spinner.set_message(what);
        }
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        if let Some(spinner) = &self.0 {
            spinner.finish_and_clear();
        }
    }
}

/// What is kept of a picture while it is in work.
#[derive(Default)]
pub struct Kept {
    pub checkpoints: Option<Checkpoints>,
    pub previews: Option<Previews>,
}

/// Shows progress, and ends the render when its time is up or the user has had enough.
pub struct Shown {
    bar: Option<ProgressBar>,
    started: Instant,
    last_line: Option<Mutex<Instant>>,
    /// What was known at the end of the last round.
    state: Mutex<String>,
    /// Share of the samples that was there before.
    begun_at: OnceLock<f64>,
    time_limit: Option<Duration>,
    interrupts: Interrupts,
    /// Whether the user has been told that an interrupt was heard.
    told: AtomicBool,
    kept: Kept,
}

impl Shown {
    /// Progress on stderr, the seconds after which to stop, the interrupts that stop it sooner, and what is kept meanwhile.
    pub fn new(verbosity: Verbosity, time_limit_s: Option<f64>, interrupts: Interrupts, kept: Kept) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let quiet = verbosity == Verbosity::Quiet;
        let bar = (!quiet && terminal).then(|| {
            let style = ProgressStyle::with_template("{prefix} [{wide_bar}] {percent:>3} % {msg}");
            ProgressBar::new(BAR_LENGTH)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
                .with_prefix("render")
        });
        if let Some(bar) = &bar {
            bar.tick();
        }
        Self {
            bar,
            started: Instant::now(),
            last_line: (!quiet && !terminal).then(|| Mutex::new(Instant::now())),
            state: Mutex::default(),
            begun_at: OnceLock::new(),
            time_limit: time_limit_s.map(Duration::from_secs_f64),
            interrupts,
            told: AtomicBool::new(quiet),
            kept,
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
        self.kept.checkpoints.iter().try_for_each(|checkpoints| checkpoints.write(state))
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// Share of the picture that is done: of its samples, or of its time; and how long the rest takes.
    fn share_and_left(&self, taken: u64, expected: u64) -> (f64, String) {
        let elapsed_s = self.started.elapsed().as_secs_f64();
        let of_samples = (taken as f64 / expected.max(1) as f64).min(1.0);
        let begun_at = *self.begun_at.get_or_init(|| of_samples);
        let of_time = self.time_limit.map_or(0.0, |limit| elapsed_s / limit.as_secs_f64()).min(1.0);
        let left_s = match self.time_limit {
            Some(limit) if of_time > of_samples => limit.as_secs_f64() - elapsed_s,
            _ if of_samples > begun_at && elapsed_s > FORETOLD_AFTER_S => {
                elapsed_s * (1.0 - of_samples) / (of_samples - begun_at)
            }
            _ => f64::INFINITY,
        };
        (
            of_samples.max(of_time),
            if left_s.is_finite() { format!("about {} left", rounded(left_s)) } else { String::new() },
        )
    }

    fn show(&self, taken: u64, expected: u64, state: &str) {
        let (share, left) = self.share_and_left(taken, expected);
        if let Some(bar) = &self.bar {
            bar.set_position((share * BAR_LENGTH as f64) as u64);
            bar.set_message(format!("{state}{left}"));
        }
        // Whoever finds the line taken has nothing newer to say.
        let Some(mut last) = self.last_line.as_ref().and_then(|last| last.try_lock().ok()) else { return };
        if last.elapsed() < LINE_EVERY || share >= 1.0 || share == 0.0 {
            return;
        }
        *last = Instant::now();
        say!("render: {:.0} %, {state}{left}", 100.0 * share);
    }

    /// An interrupt waits for the tiles in work, and for the first sample of every pixel: the user should know.
    fn tell_of_interrupt(&self) {
        if !self.interrupts.heard() || self.told.swap(true, Ordering::Relaxed) {
            return;
        }
        let text = "interrupted: finishing what is in work, to save it; a second interrupt ends at once";
        match &self.bar {
            Some(bar) => bar.println(text),
            None => say!("{text}"),
        }
    }
}

/// A time as people say it.
fn rounded(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

impl Progress for Shown {
    fn samples(&self, taken: u64, expected: u64) {
        self.tell_of_interrupt();
        if self.bar.is_some() || self.last_line.is_some() {
            let state = self.state.lock().map(|state| state.clone()).unwrap_or_default();
            self.show(taken, expected, &state);
        }
    }

    fn round(&self, taken: u64, expected: u64, film: &Film) {
        let pixels = (film.width() * film.height()).max(1) as f64;
        let each = |samples: u64| (samples as f64 / pixels).round();
        let noise = Some(film.noise()).filter(|noise| noise.is_finite());
        let noise = noise.map_or_else(String::new, |noise| format!("noise {:.2} %, ", 100.0 * noise));
        if let Ok(mut shown) = self.state.lock() {
            *shown = format!("{}/{} spp, {noise}", each(taken), each(expected.max(taken)));
        }
        self.samples(taken, expected);
        if let Some(previews) = self.kept.previews.as_ref().filter(|previews| previews.due()) {
            previews.write_or_warn(film);
        }
    }

    fn should_stop(&self) -> bool {
        self.interrupts.heard() || self.time_limit.is_some_and(|limit| self.started.elapsed() >= limit)
    }

    fn should_pause(&self) -> bool {
        let Kept { checkpoints, previews } = &self.kept;
        checkpoints.as_ref().is_some_and(Checkpoints::due) || previews.as_ref().is_some_and(Previews::due)
    }

    fn pause(&self, state: &RenderState) {
        if let Some(checkpoints) = self.kept.checkpoints.as_ref().filter(|checkpoints| checkpoints.due()) {
            checkpoints.write_or_warn(state);
        }
        let previews = self.kept.previews.as_ref().filter(|previews| previews.due());
        if let Some((previews, film)) = previews.zip(state.latest()) {
            previews.write_or_warn(film);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn times_are_said_in_the_unit_that_people_use() {
        let said = [0.4, 59.6, 99.0, 100.0, 3600.0, 7200.0].map(rounded);
        assert_eq!(said, ["0 s", "60 s", "99 s", "2 min", "60 min", "2 h"]);
    }
}
