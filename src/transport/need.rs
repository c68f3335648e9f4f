//! How much memory a render will take, and for what: foretold from counts before anything large is allocated.
//!
//! The numbers per droplet and pixel are those of the data's layout, or measured peaks where a stage holds several things for
//! a moment (docs/robustness.md). They are meant to be somewhat too large: what is allowed must fit.

use std::f64::consts::TAU;
use std::path::Path;

use super::glow;
use super::place::bin_plan;
use super::render::{RenderRequest, Spectral};
use super::wanted_tables::table_wavelengths;
use crate::film::Film;
use crate::image::exr::{Foretold, foretold};
use crate::optics::bins::BinPlan;
use crate::optics::tables::predicted_bytes;
use crate::plan::EffectPlan;
use crate::scene::model::Scene;
use crate::scene::resolved::Resolution;
use crate::scene::settings::Effect;
use crate::spectrum::SpectralSampling;

/// What one thing takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// What it is, as in "4 GB for ..".
    pub what: String,
    /// At its peak, bytes.
    pub bytes: u64,
    /// How to need less of it.
    pub remedy: &'static str,
}

/// The memory that something takes, by what it is for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Need {
    /// The largest first.
    pub items: Vec<Item>,
}

/// What is held beside one film: everything that multiplies it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    /// Channels of the picture that is written.
    pub n_channels: usize,
    /// Copies of all sums: 1, and one more for each of `--resume` and `--samples`.
    pub n_copies: u64,
    /// Threads that take samples.
    pub n_threads: usize,
}

/// The program itself, and what hardly grows.
const PROGRAM_BYTES: u64 = 24 << 20;

/// A particle as it is read (40 bytes), sorted (16 for its key, 4 for its group), and its share of the tree (measured: 75).
const PARTICLE_BYTES: u64 = 76;

/// Leaves of a part of the tree, which a thread builds at a time, and what each takes while it does (measured: 50 MB).
const PART: u64 = 1 << 17;
const LEAF_BYTES: u64 = 400;

/// A fog box with its name, its shape and its inverse, beyond what a particle takes.
const BOX_BYTES: u64 = 400;

/// A source of glow while it is sorted (28) and in its octet, without its rows of colours.
const SOURCE_BYTES: u64 = 72;

/// Numbers by which a node of glow knows its phase functions where there are many: deviations from the mean, and a sketch of
/// what these leave.
const MIXTURE_NUMBERS: u64 = 12 + 16 + 2;

/// Bins that a node of glow keeps apart at most.
const NODE_BINS: u64 = 4;

/// A thread's buffers: fixed, and by wavelength.
const THREAD_BYTES: u64 = 1 << 20;
const THREAD_BYTES_PER_WAVELENGTH: u64 = 4096;

impl Need {
    /// The sum.
    pub fn total(&self) -> u64 {
        self.items.iter().fold(0, |sum, item| sum.saturating_add(item.bytes))
    }

    /// Adds something, unless it is next to nothing.
    pub fn add(&mut self, what: impl Into<String>, bytes: u64, remedy: &'static str) {
        if bytes > 0 {
            self.items.push(Item { what: what.into(), bytes, remedy });
            self.items.sort_by_key(|item| std::cmp::Reverse(item.bytes));
        }
    }

    /// Of the program before it has read anything.
    pub fn of_program() -> Self {
        let mut need = Self::default();
        need.add("the program", PROGRAM_BYTES, "");
        need
    }

    /// Of a render of this scene, from its tables on.
    pub fn of_render(
        scene: &Scene,
        plan: &EffectPlan,
        sampling: &SpectralSampling,
        request: &RenderRequest,
        held: Held,
    ) -> Self {
        let mut need = Self::of_program();
        let n_wavelengths = sampling.wavelengths_m.len() as u64;
        let n_threads = held.n_threads as u64;
        let threads = n_threads.saturating_mul(THREAD_BYTES + n_wavelengths * THREAD_BYTES_PER_WAVELENGTH);
        need.add(format!("{n_threads} threads"), threads, "use fewer --threads");
        let bins = bin_plan(scene);
        need.add_bodies(scene, plan, n_wavelengths, n_threads, bins.bins.len());
        need.add_glow_tables(scene, plan, &bins, sampling);
        let tables = table_wavelengths(plan, sampling).middles_m;
        let bytes = predicted_bytes(&bins, &scene.classes, tables);
        need.add("optical tables", bytes, "ask for fewer spectral bands, or for fewer droplets.size_bins");
        need.add_film(request, n_wavelengths, held);
        need.add_background(scene, plan);
        need
    }

    /// Of a picture that is read: `what` it is for.
    pub fn add_picture(&mut self, what: impl Into<String>, path: &Path, bytes_per_pixel: u64) {
        if let Some(Foretold { pixels, bytes }) = foretold(path) {
            let bytes = bytes.saturating_add(pixels.saturating_mul(bytes_per_pixel));
            self.add(what, bytes, "use a smaller picture");
        }
    }

    /// The background's picture while its texels are taken from it.
    fn add_background(&mut self, scene: &Scene, plan: &EffectPlan) {
        if let Some(path) = scene.settings.background.image.as_ref().filter(|_| plan.is_on(Effect::Background)) {
            self.add_picture("the background's picture", path, size_of::<[f32; 3]>() as u64);
        }
    }

    /// Of as many droplets and the tree over them.
    pub fn add_particles(&mut self, what: String, count: u64, n_threads: u64) {
        let at_a_time = count.min(PART.saturating_mul(n_threads));
        let bytes = count.saturating_mul(PARTICLE_BYTES).saturating_add(at_a_time * LEAF_BYTES);
        self.add(what, bytes, "use fewer droplets, or parcels that stand for many");
    }

    fn add_bodies(&mut self, scene: &Scene, plan: &EffectPlan, n_wavelengths: u64, n_threads: u64, n_bins: usize) {
        let (particles, boxes) = (scene.particles.len() as u64, scene.fog_boxes.len() as u64);
        self.add_particles(
            format!("{} droplets, parcels and fog boxes", particles + boxes),
            particles + boxes,
            n_threads,
        );
        self.add("the shapes of fog boxes", boxes * BOX_BYTES, "use fewer fog boxes");
        if plan.is_on(Effect::Refraction) {
            let resolution = Resolution::of(scene);
            let balls = scene.particles.iter().filter(|particle| resolution.is_resolved(particle)).count() as u64;
            self.add_particles(format!("{balls} droplets of glass"), balls, n_threads);
        }
        if plan.is_on(Effect::Glow) && scene.settings.atmosphere.scattering_per_m > 0.0 {
            let lights = scene.suns.len() as u64 * n_wavelengths;
            // A row for each node above eight sources, in vectors that may be half empty; sunlight by source, or by leaf.
            let apart = if n_bins > 1 { MIXTURE_NUMBERS + NODE_BINS * (1 + lights) } else { 0 };
            let rows = 2 * 4 * (lights + apart) / 7;
            let sunlight = (4 * lights * (particles + boxes)).min((4 << 24) + lights * (particles + boxes) / 2);
            let bytes = (particles + boxes).saturating_mul(SOURCE_BYTES + rows).saturating_add(sunlight);
            self.add(
                "the tree of what glows",
                bytes,
                "leave it out with --effects -glow, or ask for fewer spectral bands",
            );
        }
    }

    /// Blurred phase functions of what glows: fine where there are large drops, and many where there are many sizes.
    fn add_glow_tables(&mut self, scene: &Scene, plan: &EffectPlan, bins: &BinPlan, sampling: &SpectralSampling) {
        if !plan.is_on(Effect::Glow) || scene.settings.atmosphere.scattering_per_m <= 0.0 {
            return;
        }
        let wavelengths_m = table_wavelengths(plan, sampling).middles_m;
        let shortest_m = wavelengths_m.iter().copied().fold(f64::INFINITY, f64::min);
        let largest_m = bins.bins.iter().map(|bin| bin.distribution.law().effective_radius_m()).fold(0.0, f64::max);
        let x = (TAU * largest_m / shortest_m).min(scene.settings.accuracy.size_parameter_cap);
        self.add(
            "blurred phase functions of what glows",
            glow::predicted_bytes(x, wavelengths_m.len(), bins.bins.len()),
            "leave it out with --effects -glow, or ask for fewer spectral bands, or lower accuracy.size_parameter_cap",
        );
    }

    fn add_film(&mut self, request: &RenderRequest, n_wavelengths: u64, held: Held) {
        let [_, _, width, height] = request.crop;
        let n_spectral = if request.spectral == Spectral::Keep { n_wavelengths as usize } else { 0 };
        let n_sums = Film::n_sums(width, height, request.layers.len(), n_spectral).unwrap_or(u64::MAX / 8);
        let n_films = held.n_copies.saturating_mul(request.until.runs().len() as u64);
        let remedy = "lower --resolution, render a part with --crop, or ask for less with --aov and --spectral";
        self.add(format!("sums of {width}x{height} pixels"), n_sums.saturating_mul(8 * n_films), remedy);
        self.add_written([width, height], held.n_channels + n_spectral, remedy);
    }

    /// A picture that is written: its channels, the compressed blocks and the file made of them.
    pub fn add_written(&mut self, [width, height]: [u32; 2], n_channels: usize, remedy: &'static str) {
        let pixels = u64::from(width) * u64::from(height);
        let bytes = pixels.saturating_mul(4 * 3).saturating_mul(n_channels as u64);
        self.add(format!("a picture of {n_channels} channels"), bytes, remedy);
    }
}
