//! Clouds with the exact extinction of their droplets: joins the generator, which knows no optics, with Mie theory.

use std::f64::consts::TAU;

use crate::mie;
use crate::optics::material::Material;
use crate::scene::generate::{Cloud, GenerateError, Recipe, generate};

/// Wavelength at which optical depths are given, m.
const REFERENCE_WAVELENGTH_M: f64 = 550e-9;

/// Makes a recipe's cloud with the exact extinction of its material.
///
/// # Errors
/// As [`generate`].
pub fn make_cloud(recipe: &Recipe) -> Result<Cloud, GenerateError> {
    generate(recipe, &|radius_m| extinction_efficiency(&recipe.material, radius_m))
}

/// Extinction efficiency at 550 nm; NaN where it cannot be computed, which the generator refuses.
fn extinction_efficiency(material: &Material, radius_m: f64) -> f64 {
    let Ok(index) = material.index(REFERENCE_WAVELENGTH_M) else { return f64::NAN };
    mie::efficiencies(TAU * radius_m / REFERENCE_WAVELENGTH_M, index).map_or(f64::NAN, |q| q.q_ext)
}
