//! How far the picture is: a bar on a terminal, plain lines otherwise, nothing when quiet.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::film::Film;
use crate::transport::Progress;

/// How much the program says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum Verbosity {
    Quiet,
    Normal,
    Verbose,
}

/// Plain lines come at most this often.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// Shows progress, and ends the render when its time is up.
pub struct Shown {
    bar: Option<ProgressBar>,
    started: Instant,
    last_line: Option<Mutex<Instant>>,
    time_limit: Option<Duration>,
}

impl Shown {
    /// Progress on stderr, and the seconds after which to stop.
    pub fn new(verbosity: Verbosity, time_limit_s: Option<f64>) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let quiet = verbosity == Verbosity::Quiet;
        let bar = (!quiet && terminal).then(|| {
            let style = ProgressStyle::with_template("{prefix} [{wide_bar}] {percent:>3} % {msg}, {eta} left");
            ProgressBar::new(1).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_prefix("render")
        });
        Self {
            bar,
            started: Instant::now(),
            last_line: (!quiet && !terminal).then(|| Mutex::new(Instant::now())),
            time_limit: time_limit_s.map(Duration::from_secs_f64),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn line(&self, samples: u32, of: u32, film: &Film) {
        let Some(last) = self.last_line.as_ref().and_then(|last| last.lock().ok()) else { return };
        let mut last = last;
        if last.elapsed() < LINE_EVERY || samples >= of {
            return;
        }
        *last = Instant::now();
        let elapsed = self.started.elapsed().as_secs_f64();
        let left = elapsed * f64::from(of.saturating_sub(samples)) / f64::from(samples);
        eprintln!("render: {samples}/{of} spp, noise {:.4}, about {left:.0} s left", film.noise());
    }
}

impl Progress for Shown {
    fn round(&self, samples: u32, of: u32, film: &Film) {
        if let Some(bar) = &self.bar {
            bar.set_length(u64::from(of));
            bar.set_position(u64::from(samples));
            bar.set_message(format!("{samples}/{of} spp, noise {:.4}", film.noise()));
        }
        self.line(samples, of, film);
    }

    fn should_stop(&self) -> bool {
        self.time_limit.is_some_and(|limit| self.started.elapsed() >= limit)
    }
}
