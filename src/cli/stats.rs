//! What a render cost and what it did: a summary for people, JSON for programs.

use std::path::Path;

use serde_json::{Value, json};

use super::failure::Failure;
use crate::image::file::{Existing, write_atomically};
use crate::plan::EffectPlan;
use crate::scene::settings::Effect;
use crate::transport::{ErrorEstimate, ErrorPart, Prepared, Rates, RenderOutcome, RenderRequest};
use crate::units::short::amount;
use crate::warning::Warning;

/// Seconds spent in each stage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    pub load: f64,
    pub bvh: f64,
    pub tables: f64,
    pub render: f64,
    pub write: f64,
    pub total: f64,
}

/// Everything that is reported about a render.
pub struct Stats<'a> {
    pub scene: String,
    pub camera: String,
    pub prepared: &'a Prepared,
    pub plan: &'a EffectPlan,
    pub request: &'a RenderRequest,
    pub outcome: &'a RenderOutcome,
    /// Rays of this run: without those that a checkpoint brought.
    pub rays_now: u64,
    pub noise: f64,
    pub seconds: Seconds,
    pub peak_rss_bytes: u64,
    pub warnings: Vec<Warning>,
}

impl Stats<'_> {
    fn rays_per_second(&self) -> f64 {
        self.rays_now as f64 / self.seconds.render.max(1e-9)
    }

    /// Writes the JSON.
    pub fn write(&self, path: &Path, existing: Existing) -> Result<(), Failure> {
        let json = self.json();
        write_atomically(path, existing, |writer| writeln!(writer, "{json:#}")).map_err(Failure::other)
    }

    fn json(&self) -> Value {
        let Self { prepared, outcome, seconds, request, .. } = self;
        let counts = &prepared.counts;
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": self.scene,
            "camera": self.camera,
            "particles": counts.particles,
            "droplets": counts.droplets,
            "parcels": counts.parcels,
            "fog_boxes": counts.fog_boxes,
            "size_bins": counts.size_bins,
            "wavelengths": prepared.media.n_wavelengths(),
            "resolution": prepared.resolution,
            "crop": request.crop,
            "spp": outcome.samples,
            "seed": request.seed,
            "threads": rayon::current_num_threads(),
            "effects": self.effects(),
            "asked_per_sample": self.asked_per_sample(),
            "seconds": {
                "load": seconds.load, "bvh": seconds.bvh, "tables": seconds.tables,
                "render": seconds.render, "write": seconds.write, "total": seconds.total,
            },
            "rays": {
                "camera": outcome.rays.camera, "scatter": outcome.rays.scatter,
                "refracted": outcome.rays.refracted,
                "shadow": outcome.rays.shadow, "glow_queries": outcome.rays.glow_queries,
            },
            "rays_per_second": self.rays_per_second(),
            "noise": if self.noise.is_finite() { json!(self.noise) } else { Value::Null },
            "error": self.error(),
            "peak_rss_bytes": self.peak_rss_bytes,
            "geometry_bytes": prepared.accel.geometry_bytes(),
            "bvh_bytes": prepared.accel.tree_bytes(),
            "table_bytes": prepared.counts.table_bytes,
            "warnings": self.warnings.iter().map(|warning| warning.to_string()).collect::<Vec<_>>(),
        })
    }

    fn estimate(&self) -> ErrorEstimate {
        ErrorEstimate::new(self.plan, self.prepared, self.noise)
    }

    /// The estimated error and its parts, the largest first; null before noise is known.
    fn error(&self) -> Value {
        let estimate = self.estimate();
        let part = |part: &ErrorPart| json!({ "knob": part.knob, "what": part.what, "error": part.error });
        match self.noise.is_finite() {
            true => json!({ "total": estimate.total(), "parts": estimate.parts.iter().map(part).collect::<Vec<_>>() }),
            false => Value::Null,
        }
    }

    fn asked_per_sample(&self) -> Value {
        let on = self.prepared.is_asked();
        let times = self.prepared.rates.per_sample().into_iter().zip(on);
        times.map(|((name, times), on)| (name.to_owned(), json!(if on { times } else { 0.0 }))).collect()
    }

    /// One loop simulates all effects together, so their seconds are not known apart: null.
    fn effects(&self) -> Value {
        let one = |(effect, name): &(Effect, &str)| {
            let decision = self.plan.decisions.iter().find(|decision| decision.effect == *effect)?;
            let value = json!({
                "on": decision.on, "reason": decision.reason, "estimate": decision.estimate,
                "time_share": decision.time_share, "seconds": null,
            });
            Some(((*name).to_owned(), value))
        };
        Value::Object(Effect::ALL.iter().filter_map(one).collect())
    }

    /// A closing summary of a few short lines, for terminals of 80 columns.
    pub fn summary(&self, output: &Path) -> String {
        let Self { prepared, outcome, seconds, request, .. } = self;
        let counts = &prepared.counts;
        let [_, _, width, height] = request.crop;
        let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
        let noise = if self.noise.is_finite() { format!("{:.2} %", 100.0 * self.noise) } else { "unknown".into() };
        let error = if self.noise.is_finite() { self.estimate().line() + "\n" } else { String::new() };
        let boxes = match counts.fog_boxes {
            0 => String::new(),
            n => format!(" and {}", amount(n, "fog box", "fog boxes")),
        };
        let asked = asked(self.prepared.rates);
        format!(
            "{}: {width}x{height}, {} spp, noise {noise}\n{error}{asked}\
             {}{boxes} in {}, {}\n\
             peak memory {:.0} MiB; tables {:.1}, geometry {:.1}, tree {:.1}\n\
             time: {:.2} s; load {:.2}, tables {:.2}, tree {:.2}, render {:.2}, write {:.2}\n\
             {:.2} million rays/s\n",
            output.display(),
            outcome.samples,
            amount(counts.particles, "particle", "particles"),
            amount(counts.size_bins, "size bin", "size bins"),
            amount(prepared.media.n_wavelengths(), "wavelength", "wavelengths"),
            self.peak_rss_bytes as f64 / f64::from(1 << 20),
            mib(counts.table_bytes),
            mib(prepared.accel.geometry_bytes()),
            mib(prepared.accel.tree_bytes()),
            seconds.total,
            seconds.load,
            seconds.tables,
            seconds.bvh,
            seconds.render,
            seconds.write,
            self.rays_per_second() * 1e-6,
        )
    }
}

/// A line about what is asked less or more often than once per sample; nothing where all is asked once.
fn asked(rates: Rates) -> String {
    let uneven = rates.per_sample().into_iter().filter(|(_, times)| *times != 1.0);
    let words: Vec<String> = uneven
        .map(|(name, times)| match times < 1.0 {
            true => format!("{name} 1/{}", 1.0 / times),
            false => format!("{name} {times}"),
        })
        .collect();
    if words.is_empty() { String::new() } else { format!("asked per sample: {}\n", words.join("; ")) }
}
