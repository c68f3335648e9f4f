//! How many droplets a cloud holds, and how large its particles are drawn.

use std::f64::consts::PI;

use super::cloud::Summary;
use super::error::GenerateError;
use super::noise::Patches;
use super::recipe::{Content, Recipe};
use super::shape::CloudShape;
use super::sizes::Sizes;
use crate::optics::distribution::Shape;
use crate::scene::model::ParticleKind;
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
    /// Drawn radii, m.
    pub radii: DrawnRadii,
    pub droplet_radii_um: Option<Vec<f32>>,
    pub droplet_counts: Option<Vec<f32>>,
    pub summary: Summary,
    pub warnings: Vec<Warning>,
}

/// How large particles are drawn.
#[derive(Clone, Copy)]
pub(super) enum DrawnRadii {
    /// All alike, m.
    Alike(f64),
    /// The droplets' own radii times this.
    Magnified(f64),
}

impl Filling {
    /// How far particles reach beyond the points at their centres, m.
    pub fn reach_m(&self) -> f64 {
        match self.radii {
            DrawnRadii::Alike(radius_m) => radius_m,
            DrawnRadii::Magnified(times) => times * self.droplet_radii_um.as_deref().map_or(0.0, largest_m),
        }
    }
}

/// Fills the recipe's shape; `points` are the centres, in units of the half sizes.
pub(super) fn fill(recipe: &Recipe, sizes: &Sizes, points: &[[f32; 3]]) -> Result<Filling, GenerateError> {
    match (recipe.kind, recipe.shape) {
        (ParticleKind::Droplet, CloudShape::Droplet { diameter_m }) => fill_one(recipe, sizes, diameter_m),
        (ParticleKind::Droplet, _) => fill_droplets(recipe, sizes),
        (ParticleKind::Parcel, _) => fill_parcels(recipe, sizes, points),
    }
}

/// One droplet of the distribution's median radius, drawn as large as the shape.
fn fill_one(recipe: &Recipe, sizes: &Sizes, diameter_m: f64) -> Result<Filling, GenerateError> {
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
    let water = volume_m3(&radii_um) / recipe.shape.volume_m3() * recipe.material.density_kg_per_m3() * 1e3;
    let mut filling = magnified(recipe, sizes, radii_um, magnification, warnings)?;
    // However large it is drawn, it stands for itself.
    (filling.summary.droplets, filling.summary.liquid_water_g_per_m3) = (1.0, water);
    Ok(filling)
}

fn fill_droplets(recipe: &Recipe, sizes: &Sizes) -> Result<Filling, GenerateError> {
    let radii_um = sizes.sample_um(recipe.count as usize, recipe.seed);
    let mut warnings = Vec::new();
    let magnification = match wanted_extinction_m2(recipe, sizes, 0.0)? {
        Some(extinction_m2) => (extinction_m2 / sizes.sum_c_ext_m2(&radii_um)?).sqrt(),
        None => {
            warnings.extend(check_crowding(recipe, &radii_um)?);
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
    magnified(recipe, sizes, radii_um, magnification, warnings)
}

/// Droplets drawn at `magnification` times their own radii: each stands for that squared of its kind.
fn magnified(
    recipe: &Recipe,
    sizes: &Sizes,
    radii_um: Vec<f32>,
    magnification: f64,
    warnings: Vec<Warning>,
) -> Result<Filling, GenerateError> {
    let stands_for = magnification * magnification;
    let extinction_m2 = stands_for * sizes.sum_c_ext_m2(&radii_um)?;
    let summary = Summary {
        droplets: stands_for * radii_um.len() as f64,
        magnification,
        liquid_water_g_per_m3: stands_for * volume_m3(&radii_um) / recipe.shape.volume_m3()
            * recipe.material.density_kg_per_m3()
            * 1e3,
        ..optical_depths(&recipe.shape, 0.0, extinction_m2)
    };
    Ok(Filling {
        radii: DrawnRadii::Magnified(magnification),
        droplet_radii_um: Some(radii_um),
        droplet_counts: None,
        summary,
        warnings,
    })
}

fn fill_parcels(recipe: &Recipe, sizes: &Sizes, points: &[[f32; 3]]) -> Result<Filling, GenerateError> {
    let (radius_m, warning) = parcel_radius_m(recipe);
    let (c_ext_m2, volume_m3) = (sizes.mean_c_ext_m2()?, sizes.mean_volume_m3());
    let water = Content::LiquidWaterGPerM3(DEFAULT_LIQUID_WATER_G_PER_M3);
    let extinction_m2 = match wanted_extinction_m2(recipe, sizes, radius_m)? {
        Some(extinction_m2) => extinction_m2,
        None => extinction_of(water, recipe, sizes, radius_m)?,
    };
    let droplets = extinction_m2 / c_ext_m2;
    let droplet_counts = share_out(droplets, recipe, points)?;
    // A table of sizes lives in a file of its own: there each parcel holds one size of it.
    let by_size = matches!(recipe.distribution.shape, Shape::Table { .. });
    let summary = Summary {
        droplets,
        magnification: 1.0,
        liquid_water_g_per_m3: droplets * volume_m3 / recipe.shape.volume_m3()
            * recipe.material.density_kg_per_m3()
            * 1e3,
        ..optical_depths(&recipe.shape, radius_m, extinction_m2)
    };
    Ok(Filling {
        radii: DrawnRadii::Alike(radius_m),
        droplet_radii_um: by_size.then(|| sizes.sample_um(points.len(), recipe.seed)),
        droplet_counts: Some(droplet_counts),
        summary,
        warnings: warning.into_iter().collect(),
    })
}

/// Droplets per parcel: even, or in proportion to the density of the patches at the parcel's centre.
fn share_out(droplets: f64, recipe: &Recipe, points: &[[f32; 3]]) -> Result<Vec<f32>, GenerateError> {
    let patches = Patches::new(recipe.seed, recipe.patchiness, recipe.shape.size_m());
    let densities: Vec<f64> = points.iter().map(|point| patches.density(point.map(f64::from))).collect();
    let each = droplets / densities.iter().sum::<f64>();
    let thinnest = each * densities.iter().copied().fold(f64::INFINITY, f64::min);
    let fullest = each * densities.iter().copied().fold(0.0, f64::max);
    // A parcel of one droplet or less would be read as a droplet.
    if thinnest <= 1.001 {
        return Err(GenerateError::EmptyParcels { parcels: points.len() as u64, droplets });
    }
    if fullest > f64::from(f32::MAX) {
        return Err(GenerateError::FullParcels { droplets: fullest });
    }
    Ok(densities.into_iter().map(|density| (each * density) as f32).collect())
}

/// The radius at which parcels overlap smoothly, but soften the shape's faces by no more than a quarter of its shortest side;
/// one single parcel fills that side.
fn parcel_radius_m(recipe: &Recipe) -> (f64, Option<Warning>) {
    let (shape, count) = (&recipe.shape, recipe.particle_count() as f64);
    if count == 1.0 {
        return (0.5 * shape.shortest_m(), None);
    }
    let smooth_m = recipe.overlap * (shape.volume_m3() / count).cbrt();
    let radius_m = smooth_m.min(0.25 * shape.shortest_m());
    let overlapping = count * 4.0 / 3.0 * PI * radius_m.powi(3) / shape.volume_m3();
    let warning = (radius_m < smooth_m && overlapping < MIN_OVERLAPPING).then(|| {
        Warning::new(
            format!("{count} parcels are too few to fill the shape smoothly"),
            format!("set `--count` to {:.0} or more", (count * MIN_OVERLAPPING / overlapping).ceil()),
        )
    });
    (radius_m, warning)
}

/// The sum of all extinction cross sections that the recipe asks for; `None` where it leaves it open.
fn wanted_extinction_m2(recipe: &Recipe, sizes: &Sizes, ball_m: f64) -> Result<Option<f64>, GenerateError> {
    match recipe.content {
        Content::Default => Ok(None),
        content => extinction_of(content, recipe, sizes, ball_m).map(Some),
    }
}

fn extinction_of(content: Content, recipe: &Recipe, sizes: &Sizes, ball_m: f64) -> Result<f64, GenerateError> {
    Ok(match content {
        Content::OpticalDepth(tau) => tau / middle_column_per_m2(&recipe.shape, ball_m),
        Content::LiquidWaterGPerM3(water) => {
            let kg = water * 1e-3 * recipe.shape.volume_m3();
            kg / recipe.material.density_kg_per_m3() / sizes.mean_volume_m3() * sizes.mean_c_ext_m2()?
        }
        Content::Default => 0.0,
    })
}

fn optical_depths(shape: &CloudShape, ball_m: f64, extinction_m2: f64) -> Summary {
    Summary {
        droplets: 0.0,
        magnification: 1.0,
        extinction_m2,
        optical_depth: extinction_m2 * middle_column_per_m2(shape, ball_m),
        mean_optical_depth: extinction_m2 / shape.shadow_m2(),
        liquid_water_g_per_m3: 0.0,
    }
}

/// As [`CloudShape::middle_column_per_m2`], and for the one parcel that sits in the middle.
fn middle_column_per_m2(shape: &CloudShape, ball_m: f64) -> f64 {
    if ball_m > 0.25 * shape.shortest_m() { 1.5 / (PI * ball_m * ball_m) } else { shape.middle_column_per_m2(ball_m) }
}

fn check_crowding(recipe: &Recipe, radii_um: &[f32]) -> Result<Option<Warning>, GenerateError> {
    let fraction = volume_m3(radii_um) / recipe.shape.volume_m3();
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

fn volume_m3(radii_um: &[f32]) -> f64 {
    radii_um.iter().map(|&r| 4.0 / 3.0 * PI * (f64::from(r) * 1e-6).powi(3)).sum()
}

fn largest_m(radii_um: &[f32]) -> f64 {
    f64::from(radii_um.iter().copied().fold(0.0, f32::max)) * 1e-6
}
