//! How far the picture is: a bar on a terminal, plain lines otherwise, nothing when quiet.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::checkpoint::Checkpoints;
use super::foretell::SoFar;
use super::interrupt::Interrupts;
use super::previews::Previews;
use super::say::say;
use crate::film::Film;
use crate::image::file::FileError;
use crate::transport::{Progress, RenderRequest, RenderState, Until};
use crate::units::short;

/// How much the program says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum Verbosity {
    Quiet,
    Normal,
    Verbose,
}

/// Plain lines come at most this often,
pub const LINE_EVERY: Duration = Duration::from_secs(5);

/// the first one so soon.
pub const FIRST_LINE_AFTER: Duration = Duration::from_secs(1);

/// Samples of each pixel after which noise is known first.
const FIRST_SPP: u64 = 2;

/// Steps of the bar.
const BAR_LENGTH: u64 = 1000;

/// What is kept of a picture while it is in work.
#[derive(Default)]
pub struct Kept {
    pub checkpoints: Option<Checkpoints>,
    pub previews: Option<Previews>,
}

/// What was known at the end of the last round.
#[derive(Clone, Copy)]
struct Known {
    /// Samples of all pixels together.
    taken: u64,
    noise: f64,
}

/// When a render has taken as long as it may.
#[derive(Clone, Copy)]
pub struct TimeLimit {
    /// When the program began: tables count too.
    pub from: Instant,
    pub length: Duration,
}

impl TimeLimit {
    /// Whether no time is left.
    pub fn is_over(&self) -> bool {
        self.from.elapsed() >= self.length
    }
}

/// Shows progress, and ends the render when its time is up or the user has had enough.
pub struct Shown {
    bar: Option<ProgressBar>,
    started: Instant,
    /// When the next plain line is due.
    next_line: Option<Mutex<Instant>>,
    /// When the render is done.
    until: Until,
    pixels: u64,
    /// Samples that were there before.
    begun: u64,
    known: Mutex<Known>,
    /// Whether the user has been told how long it takes.
    foretold: AtomicBool,
    time_limit: Option<TimeLimit>,
    /// Whether there is more than there was before: a time limit leaves no run without work done.
    worked: AtomicBool,
    interrupts: Interrupts,
    /// Whether the user has been told that an interrupt was heard.
    told: AtomicBool,
    kept: Kept,
}

impl Shown {
    /// Progress on stderr of a render that begins with so many samples, the time after which to stop, the interrupts that stop
    /// it sooner, and what is kept meanwhile.
    pub fn new(
        verbosity: Verbosity,
        (request, begun): (&RenderRequest, u64),
        time_limit: Option<TimeLimit>,
        interrupts: Interrupts,
        kept: Kept,
    ) -> Self {
        let [_, _, width, height] = request.crop;
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
            next_line: (!quiet && !terminal).then(|| Mutex::new(Instant::now() + FIRST_LINE_AFTER)),
            until: request.until,
            pixels: u64::from(width) * u64::from(height),
            begun,
            known: Mutex::new(Known { taken: 0, noise: f64::INFINITY }),
            // Whoever sets a limit knows how long it takes.
            foretold: AtomicBool::new(quiet || time_limit.is_some()),
            time_limit,
            worked: AtomicBool::new(false),
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

    fn so_far(&self, taken: u64, expected: u64) -> SoFar {
        let known = self.known.lock().map_or(Known { taken: 0, noise: f64::INFINITY }, |known| *known);
        let noise = known.noise * (known.taken as f64 / taken.max(1) as f64).sqrt();
        let elapsed_s = self.started.elapsed().as_secs_f64();
        SoFar { elapsed_s, begun: self.begun, taken, expected: expected.max(taken), noise }
    }

    /// Whether it is unknown as yet how many samples there will be.
    fn seeks_noise(&self, so_far: &SoFar) -> bool {
        matches!(self.until, Until::Noise { .. }) && self.time_limit.is_none() && !so_far.noise.is_finite()
    }

    /// Share of the picture that is done: of its samples, or of its time; and how long the rest takes.
    fn share_and_left(&self, so_far: &SoFar) -> (f64, String) {
        let of_samples = (so_far.taken as f64 / so_far.expected.max(1) as f64).min(1.0);
        let spent = |limit: TimeLimit| limit.from.elapsed().as_secs_f64() / limit.length.as_secs_f64();
        let of_time = self.time_limit.map_or(0.0, spent).min(1.0);
        let left_s = match self.time_limit {
            Some(limit) if of_time > of_samples => (1.0 - of_time) * limit.length.as_secs_f64(),
            _ => so_far.left_s(),
        };
        (
            of_samples.max(of_time),
            if left_s.is_finite() { format!("about {} left", short::time(left_s)) } else { String::new() },
        )
    }

    /// How far it is, as a share and in words.
    fn words(&self, so_far: &SoFar) -> (f64, String) {
        if self.seeks_noise(so_far) {
            let of_first = so_far.taken as f64 / (FIRST_SPP * self.pixels.max(1)) as f64;
            return (of_first.min(1.0), format!("of the first {FIRST_SPP} spp, to see how noisy it is"));
        }
        let (share, left) = self.share_and_left(so_far);
        let each = |samples: u64| samples as f64 / self.pixels.max(1) as f64;
        let noise =
            if so_far.noise.is_finite() { format!("noise {}, ", short::percent(so_far.noise)) } else { String::new() };
        let taken = each(so_far.taken).floor();
        // With a limit of time alone nobody expects the most samples that there may be.
        let is_open = self.time_limit.is_some() && matches!(self.until, Until::Noise { target: 0.0, .. });
        let expected = if is_open { String::new() } else { format!("/{:.0}", each(so_far.expected)) };
        (share, format!("{taken:.0}{expected} spp, {noise}{left}"))
    }

    fn show(&self, so_far: &SoFar) {
        let (share, words) = self.words(so_far);
        let words = words.trim_end_matches([' ', ',']);
        if let Some(bar) = &self.bar {
            bar.set_position((share * BAR_LENGTH as f64) as u64);
            bar.set_message(words.to_owned());
        }
        // Whoever finds the line taken has nothing newer to say.
        let Some(mut next) = self.next_line.as_ref().and_then(|next| next.try_lock().ok()) else { return };
        if Instant::now() < *next || share >= 1.0 || share == 0.0 {
            return;
        }
        *next = Instant::now() + LINE_EVERY;
        say!("render: {:.0} % {words}", 100.0 * share);
    }

    /// Tells once how long it takes, as soon as that can be told.
    fn foretell(&self, so_far: &SoFar) {
        if self.foretold.load(Ordering::Relaxed) {
            return;
        }
        if let Some(text) = so_far.foretold(self.until) {
            self.foretold.store(true, Ordering::Relaxed);
            self.say_above_bar(&text);
        }
    }

    fn say_above_bar(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.println(text),
            None => say!("{text}"),
        }
    }

    /// An interrupt waits for the tiles in work, and for the first sample of every pixel: the user should know.
    fn tell_of_interrupt(&self) {
        if !self.interrupts.heard() || self.told.swap(true, Ordering::Relaxed) {
            return;
        }
        self.say_above_bar("interrupted: finishing what is in work, to save it; a second interrupt ends at once");
    }
}

impl Progress for Shown {
    fn samples(&self, taken: u64, expected: u64) {
        self.tell_of_interrupt();
        if taken > self.begun {
            self.worked.store(true, Ordering::Relaxed);
        }
        if self.bar.is_some() || self.next_line.is_some() {
            let so_far = self.so_far(taken, expected);
            self.show(&so_far);
            self.foretell(&so_far);
        }
    }

    fn round(&self, taken: u64, _expected: u64, film: &Film) {
        // Before the next round it is not known how many samples are expected of it: what there is to say is said then.
        if let Ok(mut known) = self.known.lock() {
            *known = Known { taken, noise: film.noise() };
        }
        if let Some(previews) = self.kept.previews.as_ref().filter(|previews| previews.due()) {
            previews.write_or_warn(film);
        }
    }

    fn should_stop(&self) -> bool {
        let is_late = || self.time_limit.is_some_and(|limit| limit.is_over());
        self.interrupts.heard() || self.worked.load(Ordering::Relaxed) && is_late()
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
