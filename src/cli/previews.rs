//! The preview while the picture is in work: a first look at once, and then what there is, now and then.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::output::{Recipe, picture};
use super::say::say;
use crate::film::Film;
use crate::image::file::Existing;
use crate::image::{Picture, png};
use crate::transport::{RenderContext, RenderRequest, SilentProgress, Spectral, Until, render};

/// Previews are written at most this often,
const EVERY: Duration = Duration::from_secs(10);

/// and so seldom that they take at most this share of the time.
const MOST_OF_THE_TIME: f64 = 0.05;

/// Without a first look there is soon something to see.
const FIRST_AFTER: Duration = Duration::from_secs(2);

/// Pixels of a first look: 160x90, a second's work where a sample of every pixel of 1920x1080 takes half a minute,
const LOOK_PIXELS: f64 = 14_400.0;

/// with so many samples each.
const LOOK_SPP: u32 = 4;

/// Pictures whose sides are less than this many times as long need no first look.
const LEAST_SHRINKING: u32 = 4;

/// Writes previews when they are due.
pub struct Previews {
    path: PathBuf,
    recipe: Recipe,
    look: Option<Look>,
    /// When the next one is due; `None` where one could not be written.
    due: Mutex<Option<Instant>>,
}

impl Previews {
    /// Previews in one file, which is replaced each time. Large pictures get a first look now.
    pub fn begin(path: &Path, recipe: &Recipe, ctx: &RenderContext, request: &RenderRequest) -> Self {
        let recipe = recipe.for_preview();
        let due = Mutex::new(Some(Instant::now() + FIRST_AFTER));
        let previews = Self { path: path.into(), look: Look::take(ctx, request, &recipe), recipe, due };
        if previews.look.is_some() {
            let [_, _, width, height] = request.crop;
            previews.write_or_warn(&Film::new(width, height, &[], 0));
        }
        previews
    }

    /// Whether it is time.
    pub fn due(&self) -> bool {
        self.due.lock().is_ok_and(|due| due.is_some_and(|due| Instant::now() >= due))
    }

    /// Writes one now, or warns once: what is wrong with the file is told again when the picture is written.
    pub fn write_or_warn(&self, film: &Film) {
        let begun = Instant::now();
        let mut picture = picture(film, &self.recipe);
        if let Some(look) = &self.look {
            look.fill(&mut picture);
        }
        let written = png::write_preview(&self.path, &picture, Existing::Replace);
        if let Err(error) = &written {
            say!("warning: no preview for now: {error}");
        }
        if let Ok(mut due) = self.due.lock() {
            let wait = EVERY.max(begun.elapsed().div_f64(MOST_OF_THE_TIME));
            *due = written.is_ok().then(|| Instant::now() + wait);
        }
    }
}

/// The whole picture with few pixels, shown where there are no samples yet.
struct Look(Picture);

impl Look {
    /// Renders it; none for small pictures.
    fn take(ctx: &RenderContext, request: &RenderRequest, recipe: &Recipe) -> Option<Self> {
        let [width, height] = ctx.resolution;
        let shrinking = (f64::from(width) * f64::from(height) / LOOK_PIXELS).sqrt().ceil() as u32;
        if shrinking < LEAST_SHRINKING {
            return None;
        }
        let mut ctx = *ctx;
        ctx.resolution = [width.div_ceil(shrinking), height.div_ceil(shrinking)];
        let [width, height] = ctx.resolution;
        let crop = [0, 0, width, height];
        let until = Until::Samples(LOOK_SPP);
        let request = RenderRequest { until, crop, layers: Vec::new(), spectral: Spectral::Discard, ..request.clone() };
        Some(Self(picture(&render(&ctx, &request, &SilentProgress).film, recipe)))
    }

    /// Fills the pixels of a picture that have no sample.
    fn fill(&self, picture: &mut Picture) {
        let Some(samples) = picture.channel("samples.N").map(<[f32]>::to_vec) else { return };
        let (width, frame) = (picture.width as usize, picture.frame);
        let place = |at: usize, first: i32, full: u32, own: u32| {
            (at as u64 + u64::from(first.unsigned_abs())) * u64::from(own) / u64::from(full.max(1))
        };
        for channel in &mut picture.channels {
            let Some(coarse) = self.0.channel(&channel.name) else { continue };
            let empty = channel.values.iter_mut().zip(&samples).enumerate().filter(|(_, (_, n))| **n == 0.0);
            for (i, (value, _)) in empty {
                let x = place(i % width, frame.x, frame.full_width, self.0.width);
                let y = place(i / width, frame.y, frame.full_height, self.0.height);
                *value = coarse.get((y * u64::from(self.0.width) + x) as usize).copied().unwrap_or(0.0);
            }
        }
    }
}
