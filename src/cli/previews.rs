//! The preview while the picture is in work: there early, and rewritten now and then.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::output::{Recipe, picture};
use super::say::say;
use crate::film::Film;
use crate::image::file::Existing;
use crate::image::png;

/// A first look comes as soon as there is something to see,
const FIRST_AFTER: Duration = Duration::from_secs(2);

/// the next ones at most this often,
const EVERY: Duration = Duration::from_secs(10);

/// and so seldom that they take at most this share of the time.
const MOST_OF_THE_TIME: f64 = 0.05;

/// Writes previews when they are due.
pub struct Previews {
    path: PathBuf,
    recipe: Recipe,
    /// When the next one is due; `None` where one could not be written.
    due: Mutex<Option<Instant>>,
}

impl Previews {
    /// Previews in one file, which is replaced each time; R, G, B is all that they need.
    pub fn new(path: &Path, recipe: &Recipe) -> Self {
        Self { path: path.into(), recipe: recipe.colours_alone(), due: Mutex::new(Some(Instant::now() + FIRST_AFTER)) }
    }

    /// Whether it is time.
    pub fn due(&self) -> bool {
        self.due.lock().is_ok_and(|due| due.is_some_and(|due| Instant::now() >= due))
    }

    /// Writes one now, or warns once: what is wrong with the file is told again when the picture is written.
    pub fn write_or_warn(&self, film: &Film) {
        let begun = Instant::now();
        let written = png::write_preview(&self.path, &picture(film, &self.recipe), Existing::Replace);
        if let Err(error) = &written {
            say!("warning: no preview for now: {error}");
        }
        if let Ok(mut due) = self.due.lock() {
            let wait = EVERY.max(begun.elapsed().div_f64(MOST_OF_THE_TIME));
            *due = written.is_ok().then(|| Instant::now() + wait);
        }
    }
}
