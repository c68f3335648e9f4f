//! `glow`: light that droplets scatter into the air around them, gathered at points of the air by a cut through a tree.
//!
//! At a point x of the air seen along v, per unit of the air's scattering coefficient,
//!
//! J = sum over suns and sources of p_air(e, -v) E T_sun C_sca p(L, e) T(d) / d^2                             theory (60)
//!
//! with the sources' light e going from each to x. `Glow` is made once per picture; `cut` finds the nodes that stand for
//! all sources, `light` turns them into radiance by wavelength, `near` looks after droplets that are close to the
//! camera's ray, `gather` puts both into the march, `shaded` with what is in the way.

mod bin_phases;
mod blur;
mod cut;
mod exact;
mod extended;
mod eye;
mod gather;
mod light;
mod mixture;
mod near;
mod probe;
mod rows;
mod runs;
mod shaded;
mod shape;
mod sources;
mod totals;
mod tree;
mod weigh;

use glam::DVec3;
use rayon::prelude::*;

use self::bin_phases::{BinPhases, MOST_TABLED};
use self::blur::{BlurTable, step_for};
use self::mixture::{MOST_DEVIATIONS, Mixture};
use self::runs::Run;
use self::shape::own_grains;
use self::sources::{OpticalRows, Slot, SunShare, amount_of, drawn_radius_m, own_variance_m2};
use self::totals::{extent, full_light, media_step, scattering_by_bin, total_scattering};
use self::tree::{Remainders, Summary, Tree};
use super::lighting::Lighting;
use super::media::Media;
use crate::accel::Accel;

pub(super) use self::gather::{GlowScratch, add_step, begin_ray};
pub(super) use self::near::add_near;
pub use self::probe::GlowProbe;

/// Relative error for which exact sums describe phase functions; they use them only to choose.
const EXACT: f64 = 0.01;

/// Where fog is in full shade at the points that were tried, it still counts this much when parts of the sum are
/// chosen: other points of it may be lit.
const LEAST_LIT: f64 = 1e-3;

/// So few droplets are all looked at one by one, wherever they are.
const FEW_DROPLETS: usize = 64;

/// Droplets that a ray through the cloud comes close to, on average.
const NEAR_DROPLETS: f64 = 4.0;

/// A sun as the cut sees it.
#[derive(Clone, Copy, Debug)]
struct GlowSun {
    direction: [f32; 3],
    /// Share of all suns' light.
    share: f32,
}

/// Everything that glows.
pub struct Glow {
    tree: Tree,
    /// The tree's sources in its order, then single droplets that are in none.
    slots: Vec<Slot>,
    n_in_tree: usize,
    rows: OpticalRows,
    sun_share: SunShare,
    mixture: Mixture,
    phases: BlurTable,
    air: BlurTable,
    bin_phases: BinPhases,
    suns: Vec<GlowSun>,
    n_wavelengths: usize,
    extinction_per_unit: f32,
    /// Middle of the sources in the cloud's frame, m, and the tree's unit of length.
    middle: DVec3,
    unit_m: f64,
    /// What the tree's weights and the squares of its distances are divided by.
    scale: f64,
    /// Droplets within this distance of a ray are looked at one by one, m.
    near_m: f64,
    /// Relative error of the sum; 0 sums one by one.
    tolerance: f64,
    /// Whether particles shade each other's light.
    shadows: bool,
    /// Whether decisions and light are the same thing: one wavelength, one sun, one bin.
    is_plain: bool,
    arch: pulp::Arch,
}

impl Glow {
    /// Prepares the sum; `None` where nothing scatters.
    pub fn new(accel: &Accel, media: &Media, lighting: &Lighting, tolerance: f64, shadows: bool) -> Option<Self> {
        let rows = OpticalRows::new(media);
        let (middle, unit_m) = extent(accel)?;
        let mut items: Vec<([f32; 3], Slot)> = accel
            .bodies()
            .par_iter()
            .enumerate()
            .map(|(i, body)| {
                let at = ((body.center - middle) / unit_m).as_vec3().to_array();
                (at, Slot { body: i as u32, amount: amount_of(accel, media, body) as f32 })
            })
            .filter(|(_, slot)| rows.of(accel.body(slot.body)).iter().any(|c| c * f64::from(slot.amount) > 0.0))
            .collect();
        let is_droplet = |slot: &Slot| accel.body(slot.body).is_disc();
        let n_droplets = items.iter().filter(|(_, slot)| is_droplet(slot)).count();
        let is_single = |slot: &Slot| n_droplets <= FEW_DROPLETS && is_droplet(slot);
        let singles: Vec<Slot> = items.iter().map(|(_, slot)| *slot).filter(is_single).collect();
        items.retain(|(_, slot)| !is_single(slot));
        let run = Run::sort(&mut items);
        let n_in_tree = items.len();
        let slots: Vec<Slot> = items.into_iter().map(|(_, slot)| slot).chain(singles).collect();
        let error = if tolerance > 0.0 { tolerance } else { EXACT };
        let mixture = Mixture::new(media, &scattering_by_bin(accel, media, &rows, &slots), error);
        let step_rad = media_step(media);
        let n = media.n_wavelengths();
        let shares = &lighting.luminance_weights;
        let phases = BlurTable::new(step_rad, n * mixture.rank(), shares, |h, out| mixture.eval(media, h, out));
        let scattering_m2 = total_scattering(accel, &rows, lighting, &slots);
        if !(scattering_m2 > 0.0 && scattering_m2.is_finite()) {
            return None;
        }
        let mut glow = Self {
            sun_share: SunShare::new(accel, media, lighting, &slots, shadows),
            tree: Tree::default(),
            bin_phases: BinPhases::new(media, &phases, step_rad),
            air: air_table(lighting),
            suns: suns(lighting),
            n_wavelengths: n,
            extinction_per_unit: (lighting.air.extinction_per_m * unit_m) as f32,
            is_plain: n == 1 && lighting.suns.len() == 1 && media.n_bins() == 1,
            scale: scattering_m2 / (unit_m * unit_m),
            near_m: 0.0,
            arch: pulp::Arch::new(),
            slots,
            n_in_tree,
            rows,
            mixture,
            phases,
            middle,
            unit_m,
            tolerance,
            shadows,
        };
        let summarise = |slot: usize| glow.summarise(accel, media, lighting, scattering_m2, slot);
        let Mixture { remainder, negligible, .. } = glow.mixture;
        let remainders = Remainders { single: remainder, negligible, per_column: glow.mixture.per_column() };
        let (tree, root) = Tree::build(&run, remainders, &summarise);
        glow.tree = tree;
        glow.near_m = root.map_or(0.0, |root| glow.choose_near(n_droplets, &root));
        Some(glow)
    }

    /// The same, gathered as on a processor without vector instructions; for tests and measurements.
    pub fn without_simd(self) -> Self {
        Self { arch: pulp::Arch::Scalar, ..self }
    }

    /// Number of sources.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether nothing glows.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Whether the steps of a march have anything to sum: not where every droplet is looked at by itself.
    pub(super) fn needs_steps(&self) -> bool {
        self.n_in_tree > 0
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.tree.bytes()
            + size_of_val(&self.slots[..])
            + size_of_val(&self.bin_phases.values[..])
            + self.sun_share.bytes()
            + self.phases.bytes()
            + self.air.bytes()
    }

    /// What one source amounts to.
    fn summarise(&self, accel: &Accel, media: &Media, lighting: &Lighting, scattering_m2: f64, slot: usize) -> Summary {
        let body = accel.body(self.slots[slot].body);
        let mut colour = vec![0.0; lighting.suns.len() * self.n_wavelengths];
        self.add_source_colour(accel, lighting, scattering_m2, slot, &mut colour);
        let shares = lighting.luminance_weights.iter().cycle();
        let lit: f64 = colour.iter().zip(shares.clone()).map(|(light, share)| light * share).sum();
        let is_fog = !body.is_disc();
        let full: f64 = if is_fog { self.full_light(accel, lighting, slot) / scattering_m2 } else { 0.0 };
        let weight = lit.max(LEAST_LIT * full);
        let variance = own_variance_m2(accel, body) / (self.unit_m * self.unit_m);
        // Where the mixture is good, bins need not be known; nor where they have no tables.
        let has_bins = self.bin_phases.is_blurred && !self.mixture.sketch(body.bin()).is_empty();
        let bins = if has_bins { vec![(body.bin() as u32, colour.clone())] } else { Vec::new() };
        Summary {
            weight,
            center: (body.center - self.middle) / self.unit_m,
            moment: 3.0 * variance * weight,
            squares: if is_fog { 0.0 } else { weight * weight },
            grains: own_grains(accel, body),
            reach: drawn_radius_m(media, body) / self.unit_m,
            sketch: self.mixture.sketch(body.bin()).iter().map(|s| f64::from(*s) * weight).collect(),
            bins,
            colour,
            mix: self.mixture.coefficients(body.bin()).iter().map(|c| f64::from(*c) * weight).collect(),
        }
    }

    /// Light that a source scatters, as decisions weigh wavelengths, were it in the sun.
    fn full_light(&self, accel: &Accel, lighting: &Lighting, slot: usize) -> f64 {
        let Slot { body, amount } = self.slots[slot];
        full_light(self.rows.of(accel.body(body)), lighting) * f64::from(amount)
    }

    /// Adds the light that a source scatters, by sun and wavelength, over `divisor`.
    fn add_source_colour(&self, accel: &Accel, lighting: &Lighting, divisor: f64, slot: usize, out: &mut [f64]) {
        let Slot { body, amount } = self.slots[slot];
        let row = self.rows.of(accel.body(body));
        let lit = self.sun_share.of(slot);
        let n = self.n_wavelengths;
        for (s, sun) in lighting.suns.iter().enumerate() {
            for w in 0..n {
                out[s * n + w] += f64::from(amount) * row[w] * sun.irradiance[w] * f64::from(lit[s * n + w]) / divisor;
            }
        }
    }

    /// Distance within which droplets are looked at one by one, so that a ray through the cloud has few of them.
    fn choose_near(&self, n_droplets: usize, root: &Summary) -> f64 {
        if n_droplets <= FEW_DROPLETS {
            return 0.0;
        }
        // The edge of a cube that is filled as widely.
        let edge_m = (12.0 * root.moment / (3.0 * root.weight.max(f64::MIN_POSITIVE))).sqrt() * self.unit_m;
        edge_m * (NEAR_DROPLETS / (std::f64::consts::PI * n_droplets as f64)).sqrt()
    }
}

fn suns(lighting: &Lighting) -> Vec<GlowSun> {
    let light = |irradiance: &[f64]| -> f64 {
        irradiance.iter().zip(&lighting.luminance_weights).map(|(e, share)| e * share).sum()
    };
    let total: f64 = lighting.suns.iter().map(|sun| light(&sun.irradiance)).sum();
    let one = |sun: &super::lighting::SunLight| GlowSun {
        direction: sun.direction.as_vec3().to_array(),
        share: (light(&sun.irradiance) / total) as f32,
    };
    lighting.suns.iter().map(one).collect()
}

/// Bytes that the blurred phase functions of droplets up to a size parameter take while they are made, about and rather too many.
pub(super) fn predicted_bytes(x: f64, n_wavelengths: usize, n_bins: usize) -> u64 {
    let mixture = blur::predicted_bytes(x, n_wavelengths * n_bins.clamp(1, 1 + MOST_DEVIATIONS));
    let bin_by_bin = if n_bins > 1 { (size_of::<f32>() * MOST_TABLED) as u64 } else { 0 };
    mixture.saturating_add(bin_by_bin.min(mixture))
}

/// The air's phase functions: one where all wavelengths share it.
fn air_table(lighting: &Lighting) -> BlurTable {
    let phases = &lighting.air.phase;
    let differ = phases.iter().any(|phase| !std::sync::Arc::ptr_eq(phase, &phases[0]));
    let phases = if differ { &phases[..] } else { &phases[..1] };
    let step_rad = phases.iter().map(|phase| step_for(phase.max_value())).fold(f64::INFINITY, f64::min);
    let shares = if differ { &lighting.luminance_weights[..] } else { &[1.0] };
    BlurTable::new(step_rad, phases.len(), shares, |h, out| {
        out.iter_mut().zip(phases).for_each(|(out, phase)| *out = phase.eval(h));
    })
}
