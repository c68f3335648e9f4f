//! `mie-cloud merge`: parts of a picture, each with samples of its own, to the picture of all samples.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::anyhow;

use super::args::MergeArgs;
use super::claims::names_same_file;
use super::failure::Failure;
use super::identity::{About, difference_of_parts};
use super::memory::MemoryLimit;
use super::output;
use super::say::say;
use crate::film::{Film, Joiner, is_whole, most_held, nodes_of};
use crate::image::file::{Existing, check_writable};
use crate::transport::keep::Kept;
use crate::transport::need::Need;
use crate::units::short::amount;

/// A part whose sums have not been read.
struct Part {
    path: PathBuf,
    samples: Range<u32>,
    about: About,
    film_bytes: u64,
    size: [u32; 2],
}

/// Runs the command.
pub fn run(args: &MergeArgs) -> Result<u8, Failure> {
    let existing = if args.no_clobber { Existing::Keep } else { Existing::Replace };
    output::check_kind(&args.output).map_err(Failure::usage)?;
    for path in [Some(&args.output), args.preview.as_ref()].into_iter().flatten() {
        check_writable(path, existing).map_err(Failure::other)?;
        if let Some(part) = args.parts.iter().find(|part| names_same_file(part, path)) {
            return Err(Failure::usage(anyhow!(
                "{} is one of the parts; name another file for the output",
                part.display()
            )));
        }
    }
    if args.preview.as_ref().is_some_and(|preview| names_same_file(preview, &args.output)) {
        return Err(Failure::usage(anyhow!("--output and --preview both name {}", args.output.display())));
    }
    let mut parts = args.parts.iter().map(|path| open(path)).collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|part| part.samples.start);
    let recipe = check_together(&parts, args.allow_gaps)?.about.recipe.clone();
    MemoryLimit::new(args.memory_limit).check(&need(&parts))?;
    let film = join(&parts)?;
    let picture = output::picture(&film, &recipe);
    output::write(&args.output, args.preview.as_deref(), &picture, None, existing)?;
    if !args.quiet {
        let (shown, n, spp) = (args.output.display(), amount(parts.len(), "part", "parts"), film.mean_samples());
        let noise = film.noise();
        let noise = if noise.is_finite() { format!("{:.2} %", 100.0 * noise) } else { "unknown".into() };
        say!("{shown}: {n}, {spp} samples per pixel, noise {noise}");
    }
    Ok(0)
}

fn open(path: &Path) -> Result<Part, Failure> {
    let kept = Kept::open(path).map_err(Failure::other)?;
    let shown = path.display();
    let about: About = serde_json::from_value(kept.about().clone())
        .map_err(|error| Failure::other(anyhow!("{shown} is not a part of a picture: {error}")))?;
    match about.part {
        Some([start, end]) if start < end && is_whole(&(start..end)) => {
            Ok(Part { path: path.into(), samples: start..end, about, film_bytes: kept.film_bytes(), size: kept.size() })
        }
        Some(_) => Err(Failure::other(anyhow!("{shown} is damaged: its range of samples is impossible"))),
        None => Err(Failure::usage(anyhow!(
            "{shown} is a checkpoint, not a part; finish it with --resume, or render parts with --samples A..B"
        ))),
    }
}

/// Checks that the parts, sorted by their first sample, make up one picture; returns one of them.
fn check_together(parts: &[Part], allow_gaps: bool) -> Result<&Part, Failure> {
    let Some(first) = parts.first() else { return Err(Failure::usage(anyhow!("there are no parts"))) };
    for part in &parts[1..] {
        if let Some(what) = difference_of_parts(&part.about, &first.about) {
            let (shown, first) = (part.path.display(), first.path.display());
            return Err(Failure::usage(anyhow!("{shown} and {first} are not of one picture: in the former {what}")));
        }
    }
    for pair in parts.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if b.samples.start < a.samples.end {
            let (common, until) = (b.samples.start, b.samples.end.min(a.samples.end));
            return Err(Failure::usage(anyhow!(
                "{} and {} both hold the samples {common}..{until}; each may count once",
                a.path.display(),
                b.path.display()
            )));
        }
    }
    let missing = gaps(parts);
    if !allow_gaps && !missing.is_empty() {
        return Err(Failure::usage(anyhow!(
            "the samples {} are missing; render them with --samples, or merge without them by --allow-gaps",
            missing.join(", ")
        )));
    }
    Ok(first)
}

/// The ranges that are missing from sample 0 on.
fn gaps(parts: &[Part]) -> Vec<String> {
    let starts = parts.iter().map(|part| part.samples.start);
    let ends = std::iter::once(0).chain(parts.iter().map(|part| part.samples.end));
    ends.zip(starts).filter(|(end, start)| end < start).map(|(end, start)| format!("{end}..{start}")).collect()
}

/// The memory of a merge: films of parts that cannot be added up yet, and the picture.
fn need(parts: &[Part]) -> Need {
    let mut need = Need::of_program();
    let Some(first) = parts.first() else { return need };
    let [width, height] = first.size;
    // One more is kept to compare shapes with.
    let n_films = 1 + most_held(parts.iter().map(|part| part.samples.clone()));
    let sums = first.film_bytes.saturating_mul(n_films);
    need.add(
        format!("{n_films} times the sums of {width}x{height} pixels"),
        sums,
        "merge parts of fewer pixels, made with --crop",
    );
    need.add_written([width, height], first.about.recipe.n_channels(), "merge parts of fewer pixels, made with --crop");
    need
}

/// Reads one part after the other and adds it.
fn join(parts: &[Part]) -> Result<Film, Failure> {
    let mut joiner = Joiner::default();
    let mut shape: Option<Film> = None;
    for part in parts {
        let damaged = || Failure::other(anyhow!("{} is damaged: its sums are not of its picture", part.path.display()));
        let films = Kept::open(&part.path).and_then(Kept::read).map_err(Failure::other)?.into_films();
        let nodes = nodes_of(part.samples.clone());
        if films.len() != nodes.len() {
            return Err(damaged());
        }
        for (node, film) in nodes.into_iter().zip(films) {
            let expected = shape.get_or_insert_with(|| film.emptied());
            if !film.has_shape_of(expected) || film.samples() != node.len() as u64 * film.n_pixels() {
                return Err(damaged());
            }
            joiner.push(node, film);
        }
    }
    joiner.finish().ok_or_else(|| Failure::usage(anyhow!("there are no parts")))
}
