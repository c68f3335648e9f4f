//! Clouds of many parcels, and one single droplet.

use std::error::Error;

use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::scene::generate::{CameraPlacement, CloudShape, Content, Recipe, View};
use mie_cloud::scene::model::ParticleKind;
use serde_json::{Value, json};

use super::document::{FogBox, add_fog, no_files, of_cloud, settings};

/// Radiation fog after sunrise: banks twelve metres deep, the low sun shining through them.
pub fn fog() -> Result<Value, Box<dyn Error>> {
    let camera = CameraPlacement { position_m: [0.0, 2.0, 62.0], target_m: [0.0, 5.0, 0.0] };
    of_cloud(&Recipe {
        count: 200_000,
        kind: ParticleKind::Parcel,
        distribution: distribution("gamma:reff=6um,veff=0.1")?,
        content: Content::LiquidWaterGPerM3(0.04),
        seed: 1,
        overlap: 0.65,
        patchiness: 1.0,
        view: View { camera: Some(camera), sun_elevation_deg: 13.0, sun_azimuth_deg: 20.0, ..View::default() },
        settings: settings(json!({
            "accuracy": { "target": 0.06 },
            "effects": { "multiple": "off", "sun-disc": "off" },
            "background": { "radiance": [0.05, 0.07, 0.11] },
        })),
        ..Recipe::new(CloudShape::new("slab", &[160.0, 12.0, 160.0])?)
    })
}

/// One droplet of 10 um, drawn a metre wide, in air that only the droplet lights.
pub fn droplet() -> Result<Value, Box<dyn Error>> {
    of_cloud(&Recipe {
        count: 1,
        distribution: distribution("mono:r=5um")?,
        view: View { sun_elevation_deg: 35.0, sun_azimuth_deg: 100.0, ..View::default() },
        settings: settings(json!({
            "atmosphere": {
                "scattering_per_m": 0.025, "absorption_per_m": 0.1, "depth_m": 8.0, "step_m": 0.05, "sunlight": false,
            },
            "effects": { "air-multiple": "off" },
            "accuracy": { "target": 0.12 },
        })),
        ..Recipe::new(CloudShape::new("droplet", &[1.0])?)
    })
}

/// A fair-weather cumulus, more than a kilometre wide, under a blue sky, the sun to the left. Light that droplets turn
/// by less than 20 degrees goes on as if it had met none: of a thick cloud that keeps the looks and saves most of the time.
pub fn cumulus() -> Result<Value, Box<dyn Error>> {
    let shape = CloudShape::new("cumulus", &[1200.0, 700.0, 1000.0])?;
    of_cloud(&Recipe {
        count: 12_000,
        kind: ParticleKind::Parcel,
        content: Content::OpticalDepth(40.0),
        seed: 8,
        overlap: 0.75,
        view: View { yfov_deg: 34.0, sun_elevation_deg: 38.0, sun_azimuth_deg: 85.0, ..View::of(&shape) },
        settings: settings(json!({
            "accuracy": { "target": 0.1, "peak_truncation_deg": 20.0 },
            "image": { "resolution": [320, 180] },
            "background": { "radiance": [0.06, 0.12, 0.25] },
        })),
        ..Recipe::new(shape)
    })
}

/// A puff of steam in a dusty room, the sun falling in through four windows. The walls are black fog so thick that no light
/// comes through. What the steam sends into the air and the air to the steam is left out: dust is thin.
pub fn steam() -> Result<Value, Box<dyn Error>> {
    let camera = CameraPlacement { position_m: [0.6, 0.0, 4.2], target_m: [0.2, 0.2, 0.0] };
    let mut scene = of_cloud(&Recipe {
        count: 8_000,
        kind: ParticleKind::Parcel,
        content: Content::OpticalDepth(3.0),
        seed: 3,
        overlap: 1.1,
        view: View { camera: Some(camera), sun_elevation_deg: 28.0, sun_azimuth_deg: 27.0, ..View::default() },
        settings: settings(json!({
            "atmosphere": { "scattering_per_m": 0.05, "depth_m": 9.0, "step_m": 0.5, "phase": "hg:0.6" },
            "accuracy": { "target": 0.2, "peak_truncation_deg": 8.0 },
            "effects": { "glow": "off", "air-multiple": "off" },
            "image": { "resolution": [480, 270] },
            "background": { "radiance": [0.008, 0.011, 0.018] },
        })),
        ..Recipe::new(CloudShape::new("puff", &[1.5, 1.9, 1.5])?)
    })?;
    add_fog(&mut scene, &wall_with_windows(-3.0, [0.9, 2.3], &[[-3.3, -2.6], [-1.9, -1.1], [-0.4, 0.3], [1.0, 1.7]]));
    Ok(scene)
}

/// A wall across the room: boxes above, below and between windows, which are given from left to right.
fn wall_with_windows(z: f64, [sill, lintel]: [f64; 2], windows: &[[f64; 2]]) -> Vec<FogBox> {
    const EDGE: f64 = 20.0;
    let board = |[left, right]: [f64; 2], [low, high]: [f64; 2]| FogBox {
        center_m: [0.5 * (left + right), 0.5 * (low + high), z],
        size_m: [right - left, high - low, 0.1],
        extinction_per_m: 3000.0,
        albedo: Some(0.0),
    };
    let lefts = std::iter::once(-EDGE).chain(windows.iter().map(|window| window[1]));
    let rights = windows.iter().map(|window| window[0]).chain([EDGE]);
    let between = lefts.zip(rights).map(|(left, right)| board([left, right], [sill, lintel]));
    between.chain([board([-EDGE, EDGE], [-EDGE, sill]), board([-EDGE, EDGE], [lintel, EDGE])]).collect()
}

fn distribution(text: &str) -> Result<SizeDistribution, Box<dyn Error>> {
    Ok(SizeDistribution::parse(text, &no_files)?)
}
