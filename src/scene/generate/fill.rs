//! How many droplets a cloud holds, and how large its particles are drawn.

use std::f64::consts::PI;

use super::cloud::Summary;
use super::error::GenerateError;
use super::place::{ParcelRadii, Parcels, Placed};
use super::recipe::{Content, Recipe};
use super::shape::CloudShape;
use super::sizes::Sizes;
use crate::optics::distribution::Shape;
use crate::scene::model::{MOST_DROPLETS, SMALLEST_RADIUS_M};
use crate::warning::Warning;

/// Liquid water of radiation fog and small cumulus, g/m^3 (Hess, Koepke & Schult 1998: 0.06 to 0.3).
const DEFAULT_LIQUID_WATER_G_PER_M3: f64 = 0.3;

/// Fewer parcels than this at every point show as balls.
const MIN_OVERLAPPING: f64 = 4.0;

/// Above this share of the volume, droplets do not scatter independently (Tien & Drolen 1987).
const INDEPENDENT_FRACTION: f64 = 0.006;

/// Spheres in random order fill no larger share (Scott & Kilgour 1969).
const PACKED_FRACTION: f64 = 0.64;

/// What the particles hold.
pub(super) struct Filling {
    pub radii: DrawnRadii,
    pub droplet_radii_um: Option<Vec<f32>>,
    pub droplet_counts: Option<Vec<f32>>,
    pub summary: Summary,
    pub warnings: Vec<Warning>,
}

/// How large particles are drawn.
pub(super) enum DrawnRadii {
    /// As parcels.
    Parcels(ParcelRadii),
    /// The droplets' own radii times this.
    Magnified(f64),
}

impl Filling {
    /// How far particles reach beyond the points at their centres, m.
    pub fn reach_m(&self) -> f64 {
        match &self.radii {
            DrawnRadii::Parcels(radii) => radii.largest_m(),
            DrawnRadii::Magnified(times) => times * self.droplet_radii_um.as_deref().map_or(0.0, largest_m),
        }
    }
}

/// Fills the particles that were placed with what the recipe asks for.
pub(super) fn fill(recipe: &Recipe, sizes: &Sizes, placed: &mut Placed) -> Result<Filling, GenerateError> {
    match (placed.parcels.take(), recipe.shape) {
        (None, CloudShape::Droplet { diameter_m }) => fill_one(recipe, sizes, placed, diameter_m),
        (None, _) => fill_droplets(recipe, sizes, placed),
        (Some(parcels), _) => fill_parcels(recipe, sizes, placed, parcels),
    }
}

/// One droplet of the distribution's median radius, drawn as large as the shape.
fn fill_one(recipe: &Recipe, sizes: &Sizes, placed: &Placed, diameter_m: f64) -> Result<Filling, GenerateError> {
    let radii_um = vec![(sizes.median_m() * 1e6) as f32];
    let magnification = 0.5 * diameter_m / largest_m(&radii_um);
    let mut warnings = Vec::new();
    if recipe.content != Content::Default {
        warnings.push(Warning::new(
            "`--liquid-water` and `--optical-depth` do not change a single droplet",
            "use `--shape ball`, or leave them out",
        ));
    }
    if recipe.count > 1 {
        warnings.push(Warning::new(
            format!("`--shape droplet` makes one droplet, not {}", recipe.count),
            "use `--shape ball` for many, or `--count 1`",
        ));
    }
    let water = volume_m3(&radii_um) / placed.volume_m3 * recipe.material.density_kg_per_m3() * 1e3;
    let mut filling = magnified(recipe, sizes, placed, radii_um, magnification, warnings)?;
    // However large it is drawn, it stands for itself.
    (filling.summary.droplets, filling.summary.liquid_water_g_per_m3) = (1.0, water);
    Ok(filling)
}

fn fill_droplets(recipe: &Recipe, sizes: &Sizes, placed: &Placed) -> Result<Filling, GenerateError> {
    let radii_um = sizes.sample_um(recipe.count as usize, recipe.seed);
    let mut warnings = Vec::new();
    let magnification = match wanted_extinction_m2(recipe, sizes, placed)? {
        Some(extinction_m2) => (extinction_m2 / sizes.sum_c_ext_m2(&radii_um)?).sqrt(),
        None => {
            warnings.extend(check_crowding(recipe, placed, &radii_um)?);
            1.0
        }
    };
    warnings.extend(check_magnified(recipe, magnification, &radii_um)?);
    if magnification < 1.0 {
        warnings.push(Warning::new(
            format!(
                "so little takes fewer than {} droplets: they are drawn {magnification:.3} times their own size",
                recipe.count
            ),
            "lower `--count`, or ask for more with `--liquid-water` or `--optical-depth`",
        ));
    }
    magnified(recipe, sizes, placed, radii_um, magnification, warnings)
}

/// Droplets drawn at `magnification` times their own radii: each stands for that squared of its kind.
fn magnified(
    recipe: &Recipe,
    sizes: &Sizes,
    placed: &Placed,
    radii_um: Vec<f32>,
    magnification: f64,
    warnings: Vec<Warning>,
) -> Result<Filling, GenerateError> {
    check_drawn(magnification * 1e-6 * radii_um.iter().copied().map(f64::from).fold(f64::INFINITY, f64::min))?;
    let stands_for = magnification * magnification;
    let extinction_m2 = stands_for * sizes.sum_c_ext_m2(&radii_um)?;
    let summary = Summary {
        droplets: stands_for * radii_um.len() as f64,
        magnification,
        liquid_water_g_per_m3: stands_for * volume_m3(&radii_um) / placed.volume_m3
            * recipe.material.density_kg_per_m3()
            * 1e3,
        ..optical_depths(placed, extinction_m2)
    };
    Ok(Filling {
        radii: DrawnRadii::Magnified(magnification),
        droplet_radii_um: Some(radii_um),
        droplet_counts: None,
        summary,
        warnings,
    })
}

fn fill_parcels(recipe: &Recipe, sizes: &Sizes, placed: &Placed, parcels: Parcels) -> Result<Filling, GenerateError> {
    check_drawn(parcels.radii.smallest_m())?;
    let (c_ext_m2, volume_m3) = (sizes.mean_c_ext_m2()?, sizes.mean_volume_m3());
    let water = Content::LiquidWaterGPerM3(DEFAULT_LIQUID_WATER_G_PER_M3);
    let extinction_m2 = match wanted_extinction_m2(recipe, sizes, placed)? {
        Some(extinction_m2) => extinction_m2,
        None => extinction_of(water, recipe, sizes, placed)?,
    };
    let droplets = extinction_m2 / c_ext_m2;
    let droplet_counts = share_out(droplets, &parcels.shares)?;
    // A table of sizes lives in a file of its own: there each parcel holds one size of it.
    let by_size = matches!(recipe.distribution.shape, Shape::Table { .. });
    let summary = Summary {
        droplets,
        magnification: 1.0,
        liquid_water_g_per_m3: droplets * volume_m3 / placed.volume_m3 * recipe.material.density_kg_per_m3() * 1e3,
        ..optical_depths(placed, extinction_m2)
    };
    Ok(Filling {
        warnings: check_smoothness(&parcels).into_iter().collect(),
        radii: DrawnRadii::Parcels(parcels.radii),
        droplet_radii_um: by_size.then(|| sizes.sample_um(placed.points.len(), recipe.seed)),
        droplet_counts: Some(droplet_counts),
        summary,
    })
}

/// Droplets per parcel, in proportion to their shares.
fn share_out(droplets: f64, shares: &[f64]) -> Result<Vec<f32>, GenerateError> {
    let each = droplets / shares.iter().sum::<f64>();
    let thinnest = each * shares.iter().copied().fold(f64::INFINITY, f64::min);
    let fullest = each * shares.iter().copied().fold(0.0, f64::max);
    // A parcel of one droplet or less would be read as a droplet.
    if thinnest <= 1.001 {
        return Err(GenerateError::EmptyParcels { parcels: shares.len() as u64, droplets });
    }
    if fullest > MOST_DROPLETS {
        return Err(GenerateError::FullParcels { droplets: fullest });
    }
    Ok(shares.iter().map(|share| (each * share) as f32).collect())
}

fn check_smoothness(parcels: &Parcels) -> Option<Warning> {
    let (count, overlapping) = (parcels.shares.len() as f64, parcels.overlapping);
    (parcels.cramped && overlapping < MIN_OVERLAPPING).then(|| {
        Warning::new(
            format!("{count} parcels are too few to fill the shape smoothly"),
            format!("set `--count` to {:.0} or more", (count * MIN_OVERLAPPING / overlapping).ceil()),
        )
    })
}

/// The sum of all extinction cross sections that the recipe asks for; `None` where it leaves it open.
fn wanted_extinction_m2(recipe: &Recipe, sizes: &Sizes, placed: &Placed) -> Result<Option<f64>, GenerateError> {
    match recipe.content {
        Content::Default => Ok(None),
        content => extinction_of(content, recipe, sizes, placed).map(Some),
    }
}

fn extinction_of(content: Content, recipe: &Recipe, sizes: &Sizes, placed: &Placed) -> Result<f64, GenerateError> {
    Ok(match content {
        Content::OpticalDepth(tau) => tau / placed.column_per_m2,
        Content::LiquidWaterGPerM3(water) => {
            let kg = water * 1e-3 * placed.volume_m3;
            kg / recipe.material.density_kg_per_m3() / sizes.mean_volume_m3() * sizes.mean_c_ext_m2()?
        }
        Content::Default => 0.0,
    })
}

fn optical_depths(placed: &Placed, extinction_m2: f64) -> Summary {
    Summary {
        droplets: 0.0,
        magnification: 1.0,
        extinction_m2,
        optical_depth: extinction_m2 * placed.column_per_m2,
        mean_optical_depth: extinction_m2 / placed.shadow_m2,
        liquid_water_g_per_m3: 0.0,
    }
}

fn check_crowding(recipe: &Recipe, placed: &Placed, radii_um: &[f32]) -> Result<Option<Warning>, GenerateError> {
    let fraction = volume_m3(radii_um) / placed.volume_m3;
    if fraction > PACKED_FRACTION {
        let max_count = (recipe.count as f64 * PACKED_FRACTION / fraction) as u64;
        return Err(GenerateError::Crowded { count: recipe.count, fraction, max_count });
    }
    Ok((fraction > INDEPENDENT_FRACTION).then(|| {
        Warning::new(
            format!("droplets fill {fraction:.3} of the shape: so close together they do not scatter independently"),
            "raise `--size` or lower `--count`",
        )
    }))
}

/// Droplets drawn wider than the shape is thick stick out of it; wider than all of it, they are no cloud.
fn check_magnified(recipe: &Recipe, magnification: f64, radii_um: &[f32]) -> Result<Option<Warning>, GenerateError> {
    let mean_square = radii_um.iter().map(|&r| (f64::from(r) * 1e-6).powi(2)).sum::<f64>() / radii_um.len() as f64;
    let radius_m = magnification * mean_square.sqrt();
    // The count at which a typical droplet is drawn with this radius: the product of count and square stays.
    let count_for = |radius_limit_m: f64| (recipe.count as f64 * (radius_m / radius_limit_m).powi(2)).ceil() as u64;
    let (shortest_m, longest_m) = (recipe.shape.shortest_m(), recipe.shape.longest_m());
    if radius_m > 0.5 * longest_m {
        let min_count = count_for(0.5 * longest_m);
        return Err(GenerateError::Magnified { count: recipe.count, radius_m, size_m: longest_m, min_count });
    }
    Ok((radius_m > 0.25 * shortest_m).then(|| {
        Warning::new(
            format!("droplets are drawn {radius_m:e} m in radius and stick out of a shape {shortest_m:e} m across"),
            format!("set `--count` to {} or more, or use `--kind parcels`", count_for(0.25 * shortest_m)),
        )
    }))
}

/// Droplets drawn smaller than an atom would be refused by whoever reads them.
fn check_drawn(radius_m: f64) -> Result<(), GenerateError> {
    match radius_m < SMALLEST_RADIUS_M {
        true => Err(GenerateError::Tiny { radius_m, least_m: SMALLEST_RADIUS_M }),
        false => Ok(()),
    }
}

fn volume_m3(radii_um: &[f32]) -> f64 {
    radii_um.iter().map(|&r| 4.0 / 3.0 * PI * (f64::from(r) * 1e-6).powi(3)).sum()
}

fn largest_m(radii_um: &[f32]) -> f64 {
    f64::from(radii_um.iter().copied().fold(0.0, f32::max)) * 1e-6
}
