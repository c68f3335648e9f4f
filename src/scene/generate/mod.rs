//! Makes clouds: a recipe becomes particles, a camera and a sun, the same for the same seed on every machine.
//!
//! - Particles are spread evenly over the shape (or in banks, with patchiness): droplets wholly at random, so that their
//!   mean transmittance is exp(-tau); parcels with their centres in the shape, so that its faces are soft.
//! - Droplets are as large as they are, unless liquid water or an optical depth is asked for: then their drawn radii are
//!   R = s r, with one s for all, so that the given number of them has the extinction that was asked for. Each keeps the
//!   efficiencies of its own radius r and stands for s^2 droplets.
//! - Parcels share out the droplets that the liquid water or the optical depth takes.
//! - A cumulus and a puff grow from the seed: billows upon billows, roughened by noise, with water that rises from the
//!   base (cumulus) or thins out toward the edge (puff). Their parcels are small at the surface and large inside, and
//!   spread more evenly than by chance. Liquid water is the mean over their volume.
//! - The optical depth is that at 550 nm through the centre along the shortest side: the diameter of a ball, the thickness
//!   of a slab, the height of a cumulus that is wider than high. Through a ball, the mean over its shadow is two thirds of it.

mod billows;
mod cloud;
mod error;
mod fill;
mod grown;
mod noise;
mod place;
mod random;
mod recipe;
mod shape;
mod sizes;
mod view;
mod voxels;

use serde_json::{Map, Value, json};

pub use cloud::{Cloud, Summary};
pub use error::GenerateError;
pub use recipe::{Content, Form, Recipe, kind_name};
pub use shape::CloudShape;
pub use view::{CameraPlacement, View};

use fill::{DrawnRadii, Filling};
use place::ParcelRadii;
use sizes::Sizes;

use crate::optics::material::Material;

/// Makes the cloud of a recipe. `q_ext_550` gives the extinction efficiency at 550 nm of a droplet of a radius in metres.
///
/// # Errors
/// When a value of the recipe is out of range, or its values contradict each other; nothing large is allocated before that
/// is known.
pub fn generate(recipe: &Recipe, q_ext_550: &dyn Fn(f64) -> f64) -> Result<Cloud, GenerateError> {
    recipe.check()?;
    let sizes = Sizes::new(&recipe.distribution, q_ext_550)?;
    let mut placed = place::place(recipe)?;
    let filling = fill::fill(recipe, &sizes, &mut placed)?;
    let mut positions = placed.points;
    let metres_per_unit = metres_per_unit(&recipe.shape);
    let half_sizes = recipe.shape.size_m().map(|size| (0.5 * size / metres_per_unit) as f32);
    for point in &mut positions {
        *point = [0, 1, 2].map(|axis| point[axis] * half_sizes[axis]);
    }
    Ok(Cloud {
        radii: drawn_radii(&filling, positions.len(), metres_per_unit),
        positions,
        metres_per_unit,
        kind: recipe.kind,
        form: recipe.form,
        camera: recipe.view.camera(&recipe.shape, filling.reach_m())?,
        sun: recipe.view.sun(),
        settings: settings(recipe),
        recipe: record(recipe, &filling.summary),
        summary: filling.summary,
        droplet_radii_um: filling.droplet_radii_um,
        droplet_counts: filling.droplet_counts,
        warnings: filling.warnings,
    })
}

/// Metres per cloud unit: the power of two that brings the longest half side to 50 .. 100.
fn metres_per_unit(shape: &CloudShape) -> f64 {
    (0.5 * shape.longest_m() / 100.0).log2().ceil().exp2()
}

fn drawn_radii(filling: &Filling, count: usize, metres_per_unit: f64) -> Vec<f32> {
    let unit = |radius_m: f64| (radius_m / metres_per_unit) as f32;
    match (&filling.radii, &filling.droplet_radii_um) {
        (DrawnRadii::Magnified(times), Some(radii_um)) => {
            radii_um.iter().map(|&r| unit(f64::from(r) * 1e-6 * times)).collect()
        }
        (DrawnRadii::Parcels(ParcelRadii::Each(radii_m)), _) => radii_m.iter().map(|&r| unit(f64::from(r))).collect(),
        (DrawnRadii::Parcels(ParcelRadii::Alike(radius_m)) | DrawnRadii::Magnified(radius_m), _) => {
            vec![unit(*radius_m); count]
        }
    }
}

/// The scene's `extras.mie_cloud`: the droplets' material and distribution, and what the recipe sets itself. Tables stay
/// out of it: scenes read no files from outside their folder.
fn settings(recipe: &Recipe) -> Map<String, Value> {
    let mut droplets = Map::new();
    if !matches!(recipe.material, Material::Table(_)) {
        droplets.insert("material".into(), recipe.material.name().into());
    }
    if let Some(text) = recipe::distribution_text(&recipe.distribution) {
        droplets.insert("distribution".into(), text.into());
    }
    let mut settings = Map::new();
    settings.insert("droplets".into(), droplets.into());
    merge(&mut settings, &recipe.settings);
    settings
}

/// Sets what `above` sets, object by object.
fn merge(settings: &mut Map<String, Value>, above: &Map<String, Value>) {
    for (key, value) in above {
        match (settings.get_mut(key), value) {
            (Some(Value::Object(inner)), Value::Object(value)) => merge(inner, value),
            _ => {
                settings.insert(key.clone(), value.clone());
            }
        }
    }
}

fn record(recipe: &Recipe, summary: &Summary) -> Value {
    let mut record = recipe.to_json();
    record["made"] = json!({
        "droplets": summary.droplets,
        "magnification": summary.magnification,
        "optical_depth": summary.optical_depth,
        "mean_optical_depth": summary.mean_optical_depth,
        "liquid_water_g_per_m3": summary.liquid_water_g_per_m3,
    });
    record
}
