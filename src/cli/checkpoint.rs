//! Checkpoints: the state of a render on disk, from time to time and at its end, to go on from.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::anyhow;

use super::failure::Failure;
use super::identity::{About, difference, differs_in_samples_only};
use super::say::say;
use crate::image::file::{Existing, FileError, write_atomically};
use crate::transport::keep::{self, Kept};
use crate::transport::{RenderState, Until};

/// Writing takes at most this share of the time: with a large film on a slow disk checkpoints become rarer.
const MOST_OF_THE_TIME: f64 = 0.05;

/// Writes checkpoints when they are due.
pub struct Checkpoints {
    path: PathBuf,
    about: serde_json::Value,
    every: Duration,
    due: Mutex<Instant>,
}

impl Checkpoints {
    /// Checkpoints in one file, which is replaced each time.
    pub fn new(path: &Path, about: &About, every_s: f64) -> Result<Self, Failure> {
        let about = serde_json::to_value(about).map_err(Failure::other)?;
        let every = Duration::try_from_secs_f64(every_s).unwrap_or(Duration::MAX);
        Ok(Self { path: path.into(), about, every, due: Mutex::new(after(Instant::now(), every)) })
    }

    /// Whether it is time.
    pub fn due(&self) -> bool {
        self.due.lock().is_ok_and(|due| Instant::now() >= *due)
    }

    /// Writes one now.
    pub fn write(&self, state: &RenderState) -> Result<(), FileError> {
        let begun = Instant::now();
        let result = write_atomically(&self.path, Existing::Replace, |out| keep::write(out, &self.about, state));
        if let Ok(mut due) = self.due.lock() {
            *due = after(Instant::now(), self.every.max(begun.elapsed().div_f64(MOST_OF_THE_TIME)));
        }
        result
    }

    /// Writes one, or warns: a full disk is no reason to lose the render as well.
    pub fn write_or_warn(&self, state: &RenderState) {
        if let Err(error) = self.write(state) {
            say!("warning: no checkpoint: {error}");
        }
    }
}

/// So far away that it never comes, where the clock cannot tell.
fn after(now: Instant, wait: Duration) -> Instant {
    const A_YEAR: Duration = Duration::from_secs(31_557_600);
    now.checked_add(wait).unwrap_or(now + A_YEAR)
}

/// A checkpoint that is there holds work: it is replaced only by a render that goes on from it.
pub fn check_kept(checkpoint: &Path, resume: Option<&Path>) -> Result<(), Failure> {
    let same = |other: &Path| matches!((checkpoint.canonicalize(), other.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if !checkpoint.is_file() || resume.is_some_and(same) {
        return Ok(());
    }
    let shown = checkpoint.display();
    Err(Failure::usage(anyhow!(
        "--checkpoint {shown}: the file is there and may hold work; add `--resume {shown}` to go on from it, or remove it"
    )))
}

/// Reads the state to go on from.
///
/// # Errors
/// When the file cannot be read, or is of another render.
pub fn resume(path: &Path, about: &About, empty: &RenderState, until: Until) -> Result<RenderState, Failure> {
    let kept = Kept::open(path).map_err(|error| Failure::other(anyhow::Error::new(error).context("--resume")))?;
    let shown = path.display();
    let other: About = serde_json::from_value(kept.about().clone()).map_err(|error| {
        Failure::other(anyhow!("--resume {shown}: it is not a checkpoint of this program: {error}"))
    })?;
    if let Some(what) = difference(&other.identity, &about.identity) {
        let remedy = match differs_in_samples_only(&other.identity, &about.identity) {
            true => {
                "the goal is settled when a render begins: finish it as it was begun, or begin anew; parts made with \
                 --samples can be added to later, by `merge`"
            }
            false => "use the same scene and flags, or begin anew without --resume",
        };
        return Err(Failure::usage(anyhow!("--resume {shown}: it is of another render: {what}; {remedy}")));
    }
    let state = kept.read().map_err(Failure::other)?;
    if !state.fits(empty, until) {
        return Err(Failure::other(anyhow!(
            "--resume {shown}: its sums are not of this picture; begin anew without it"
        )));
    }
    Ok(state)
}
