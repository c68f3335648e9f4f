//! The state of a render as bytes: what checkpoints and parts are made of.
//!
//! Layout within a sealed record (`image::sealed`): length of the head (64 bits, little-endian), the head (JSON), then for
//! each run of samples the sums of its film, as 64-bit floats, little-endian, in the film's own order.

use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::render::RayCounts;
use super::rounds::Round;
use super::state::RenderState;
use crate::excerpt::printable;
use crate::film::{Film, Layer};
use crate::image::sealed::{Sealed, SealedError, Sealer};

/// Numbers that are converted at a time.
const CHUNK: usize = 1 << 13;

/// What the sums are of.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    /// Whatever the caller wants to know again.
    about: Value,
    width: u32,
    height: u32,
    layers: Vec<String>,
    n_spectral: usize,
    n_films: usize,
    rays: RayCounts,
    round: Option<Round>,
}

/// Writes a state as a sealed record; nothing may follow it in the file.
///
/// # Errors
/// When the bytes cannot be written.
pub fn write(out: &mut dyn Write, about: &Value, state: &RenderState) -> io::Result<()> {
    let Some(film) = state.films.first() else { return Err(io::Error::other("a state without film")) };
    let head = Head {
        about: about.clone(),
        width: film.width() as u32,
        height: film.height() as u32,
        layers: film.layers().iter().map(|layer| Layer::ALL[*layer as usize].1.to_owned()).collect(),
        n_spectral: film.n_spectral(),
        n_films: state.films.len(),
        rays: state.rays,
        round: state.round.clone(),
    };
    let head = serde_json::to_vec(&head)?;
    let mut sealer = Sealer::new(out);
    sealer.put(&(head.len() as u64).to_le_bytes())?;
    sealer.put(&head)?;
    let mut bytes = Vec::with_capacity(CHUNK * size_of::<f64>());
    for chunk in state.films.iter().flat_map(|film| film.sums().chunks(CHUNK)) {
        bytes.clear();
        bytes.extend(chunk.iter().flat_map(|sum| sum.to_le_bytes()));
        sealer.put(&bytes)?;
    }
    sealer.seal()
}

/// A state that has been kept, its sums not read yet.
#[derive(Debug)]
pub struct Kept {
    record: Sealed,
    head: Head,
    layers: Vec<Layer>,
}

impl Kept {
    /// Opens a file that ends with a state.
    ///
    /// # Errors
    /// When the file cannot be read, holds no state, or a damaged one.
    pub fn open(path: &Path) -> Result<Self, SealedError> {
        let mut record = Sealed::open(path)?;
        let mut length = [0; 8];
        record.fill(&mut length)?;
        let head = record.take(u64::from_le_bytes(length))?;
        let head: Head =
            serde_json::from_slice(&head).map_err(|error| record.damaged(printable(&format!("its head: {error}"))))?;
        let layer = |name: &String| Layer::ALL.iter().find(|(_, known)| known == name).map(|(layer, _)| *layer);
        let layers: Option<Vec<Layer>> = head.layers.iter().map(layer).collect();
        let layers = layers.ok_or_else(|| record.damaged("it has a layer that is not known"))?;
        // Checked before memory is taken: the sums fill the rest of the record exactly.
        let sums = Film::n_sums(head.width, head.height, layers.len(), head.n_spectral);
        let bytes = sums.and_then(|n| n.checked_mul(8)).and_then(|n| n.checked_mul(head.n_films as u64));
        // A picture without pixels could be there any number of times.
        if head.n_films == 0 || sums == Some(0) || bytes != Some(record.left()) {
            return Err(record.damaged("the number of its sums is not that of its picture"));
        }
        Ok(Self { record, head, layers })
    }

    /// What the writer recorded.
    pub fn about(&self) -> &Value {
        &self.head.about
    }

    /// Bytes of each film.
    pub fn film_bytes(&self) -> u64 {
        self.record.left() / self.head.n_films.max(1) as u64
    }

    /// Width and height of the picture, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.head.width, self.head.height]
    }

    /// Reads the sums.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn read(self) -> Result<RenderState, SealedError> {
        let Self { mut record, head, layers } = self;
        let films = (0..head.n_films).map(|_| read_film(&mut record, &head, &layers)).collect::<Result<_, _>>()?;
        Ok(RenderState { films, round: head.round, rays: head.rays })
    }
}

fn read_film(record: &mut Sealed, head: &Head, layers: &[Layer]) -> Result<Film, SealedError> {
    let wrong = "the number of its sums is not that of its picture";
    let n_sums = Film::n_sums(head.width, head.height, layers.len(), head.n_spectral);
    let n_sums = n_sums.and_then(|n| usize::try_from(n).ok()).ok_or_else(|| record.damaged(wrong))?;
    let mut sums = vec![0.0; n_sums];
    let mut bytes = vec![0; CHUNK * size_of::<f64>()];
    for chunk in sums.chunks_mut(CHUNK) {
        let bytes = &mut bytes[..size_of_val(chunk)];
        record.fill(bytes)?;
        chunk.iter_mut().zip(bytes.as_chunks::<8>().0).for_each(|(sum, bytes)| *sum = f64::from_le_bytes(*bytes));
    }
    let film = Film::from_sums(head.width, head.height, layers, head.n_spectral, sums);
    film.ok_or_else(|| record.damaged("one of its sums is no number, or no number of samples"))
}
