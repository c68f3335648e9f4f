//! What an artist says about droplets in the `extras.mie_cloud` of a node, mesh or material, and about a light in its own.

use super::given::{Fit, Given};
use super::keys::{Key, from_str};
use super::model::{FogDensity, MOST_DROPLETS};
use crate::spectrum::sun::SunSpectrum;

/// What a node, mesh or material says about the droplets in it; `None` leaves it to the next in line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marks {
    pub kind: Option<MarkKind>,
    /// As written; parsed where the class is made.
    pub material: Option<String>,
    pub phase: Option<String>,
    pub distribution: Option<String>,
    /// In 0 ..= 1.
    pub albedo: Option<f64>,
    pub density: Option<FogDensity>,
    /// The droplets' own radius, um.
    pub droplet_radius_um: Option<f64>,
    pub droplet_count: Option<f64>,
    /// Of a light at this node.
    pub light: LightMarks,
}

/// What a mesh stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    Droplet,
    Fog,
}

/// What a light says of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightMarks {
    pub spectrum: Option<SunSpectrum>,
    pub angular_diameter_deg: Option<f64>,
}

/// Densest fog that is taken for one: more droplets than molecules of air (2.7e25 per m^3) cannot be.
const MOST_PER_M3: f64 = 1e25;
/// Solid matter: osmium has 2.3e7 g per m^3.
const MOST_G_PER_M3: f64 = 3e7;
/// As for the atmosphere's coefficients.
const MOST_PER_M: f64 = 1e12;

/// Keys of `extras.mie_cloud` of nodes, meshes and materials.
#[rustfmt::skip]
pub const MARKS: &[Key<Marks>] = &[
    Key { name: "kind", unit: "", default: "none", range: "droplet or fog", set: kind },
    Key { name: "material", unit: "", default: "the scene's", range: "as droplets.material", set: |m, g| { m.material = Some(g.text()?); Ok(()) } },
    Key { name: "phase", unit: "", default: "the scene's", range: "as droplets.phase", set: |m, g| { m.phase = Some(g.text()?); Ok(()) } },
    Key { name: "distribution", unit: "", default: "the scene's", range: "as droplets.distribution", set: |m, g| { m.distribution = Some(g.text()?); Ok(()) } },
    Key { name: "albedo", unit: "", default: "the scene's", range: "0 to 1", set: |m, g| { m.albedo = Some(g.within(0.0, 1.0)?); Ok(()) } },
    Key { name: "number_per_m3", unit: "1/m^3", default: "none", range: "above 0, at most 1e25", set: |m, g| density(m, FogDensity::NumberPerM3(g.positive(MOST_PER_M3)?)) },
    Key { name: "liquid_water_g_per_m3", unit: "g/m^3", default: "none", range: "above 0, at most 3e7", set: |m, g| density(m, FogDensity::LiquidWaterGPerM3(g.positive(MOST_G_PER_M3)?)) },
    Key { name: "extinction_per_m", unit: "1/m at 550 nm", default: "none", range: "above 0, at most 1e12", set: |m, g| density(m, FogDensity::ExtinctionPerM(g.positive(MOST_PER_M)?)) },
    Key { name: "droplet_radius_um", unit: "um", default: "the drawn radius, or the distribution", range: "1e-4 to 1e9", set: |m, g| { m.droplet_radius_um = Some(g.within(1e-4, 1e9)?); Ok(()) } },
    Key { name: "droplet_count", unit: "droplets", default: "1", range: "1 to 1e36", set: |m, g| { m.droplet_count = Some(g.within(1.0, MOST_DROPLETS)?); Ok(()) } },
];

/// Keys that a node takes besides, for the light that it holds.
#[rustfmt::skip]
pub const NODE_LIGHT: &[Key<Marks>] = &[
    Key { name: "spectrum", unit: "", default: "the scene's", range: "as sun.spectrum", set: |m, g| { m.light.spectrum = Some(from_str(g)?); Ok(()) } },
    Key { name: "angular_diameter_deg", unit: "degrees", default: "the scene's", range: "0 to 90", set: |m, g| { m.light.angular_diameter_deg = Some(g.within(0.0, 90.0)?); Ok(()) } },
];

/// Keys of a light's own `extras.mie_cloud`.
#[rustfmt::skip]
pub const LIGHT: &[Key<LightMarks>] = &[
    Key { name: "spectrum", unit: "", default: "the scene's", range: "as sun.spectrum", set: |l, g| { l.spectrum = Some(from_str(g)?); Ok(()) } },
    Key { name: "angular_diameter_deg", unit: "degrees", default: "the scene's", range: "0 to 90", set: |l, g| { l.angular_diameter_deg = Some(g.within(0.0, 90.0)?); Ok(()) } },
];

fn kind(marks: &mut Marks, given: &Given) -> Fit<()> {
    marks.kind = Some(match given.text()?.trim() {
        "droplet" | "droplets" => MarkKind::Droplet,
        "fog" => MarkKind::Fog,
        _ => return Err(given.no_word("is neither droplet nor fog", ["droplet", "fog"])),
    });
    Ok(())
}

fn density(marks: &mut Marks, density: FogDensity) -> Fit<()> {
    if marks.density.is_some() {
        return Err("is one of several densities; give one".into());
    }
    marks.density = Some(density);
    Ok(())
}

impl Marks {
    /// Whether anything is said of droplets, beside a light's own.
    pub fn is_of_droplets(&self) -> bool {
        *self != Self { light: self.light, ..Self::default() }
    }

    /// What is left open here is taken from `below`.
    pub fn over(self, below: &Marks) -> Marks {
        Marks {
            kind: self.kind.or(below.kind),
            material: self.material.or_else(|| below.material.clone()),
            phase: self.phase.or_else(|| below.phase.clone()),
            distribution: self.distribution.or_else(|| below.distribution.clone()),
            albedo: self.albedo.or(below.albedo),
            density: self.density.or(below.density),
            droplet_radius_um: self.droplet_radius_um.or(below.droplet_radius_um),
            droplet_count: self.droplet_count.or(below.droplet_count),
            light: LightMarks {
                spectrum: self.light.spectrum.or(below.light.spectrum),
                angular_diameter_deg: self.light.angular_diameter_deg.or(below.light.angular_diameter_deg),
            },
        }
    }
}
