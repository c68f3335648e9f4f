//! Clouds with the exact extinction of their droplets: joins the generator, which knows no optics, with Mie theory.

use std::f64::consts::TAU;

use crate::mie::{self, domain::SIZE_PARAMETER};
use crate::optics::material::Material;
use crate::scene::generate::{Cloud, GenerateError, Recipe, generate};

/// Wavelength at which optical depths are given, m.
const REFERENCE_WAVELENGTH_M: f64 = 550e-9;

/// Makes a recipe's cloud with the exact extinction of its material.
///
/// # Errors
/// As [`generate`].
pub fn make_cloud(recipe: &Recipe) -> Result<Cloud, GenerateError> {
    generate(recipe, &|radius_m| extinction_efficiency(&recipe.material, radius_m)).map_err(name_domain)
}

/// Droplets without an efficiency are those beyond the domain of the Mie series.
fn name_domain(error: GenerateError) -> GenerateError {
    let GenerateError::Extinction { radius_m, q_ext } = error else { return error };
    let [least, most] = SIZE_PARAMETER;
    let size_parameter = TAU * radius_m / REFERENCE_WAVELENGTH_M;
    if !q_ext.is_nan() || (least..=most).contains(&size_parameter) {
        return error;
    }
    let largest_m = most * REFERENCE_WAVELENGTH_M / TAU;
    GenerateError::SizeParameter { radius_m, size_parameter, least, most, largest_m }
}

/// Extinction efficiency at 550 nm; NaN where it cannot be computed, which the generator refuses.
fn extinction_efficiency(material: &Material, radius_m: f64) -> f64 {
    let Ok(index) = material.index(REFERENCE_WAVELENGTH_M) else { return f64::NAN };
    mie::efficiencies(TAU * radius_m / REFERENCE_WAVELENGTH_M, index).map_or(f64::NAN, |q| q.q_ext)
}
