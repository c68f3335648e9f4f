//! Regenerates the scenes that come with the program: `cargo run --release --example shipped_scenes [FOLDER]`.

use std::error::Error;
use std::fs::{File, create_dir_all};
use std::io::BufWriter;
use std::path::Path;

use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::material::Material;
use mie_cloud::paper::{FIGURES, Figure, INDEX};
use mie_cloud::scene::generate::{CameraPlacement, CloudShape, Content, Recipe, View};
use mie_cloud::scene::gltf::write::write_gltf;
use mie_cloud::scene::model::ParticleKind;
use mie_cloud::study::make_cloud;
use serde_json::{Map, Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "scenes".into());
    let mut scenes = vec![("fog.gltf".into(), fog()?), ("droplet.gltf".into(), droplet()?)];
    for figure in FIGURES {
        scenes.push((format!("paper/fig{:02}.gltf", figure.number), paper_figure(&figure)?));
    }
    create_dir_all(Path::new(&folder).join("paper"))?;
    for (name, recipe) in scenes {
        let path = Path::new(&folder).join(name);
        let cloud = make_cloud(&recipe)?;
        write_gltf(&cloud, &mut BufWriter::new(File::create(&path)?))?;
        println!("{}: {:?}", path.display(), cloud.summary);
        cloud.warnings.iter().for_each(|warning| println!("  {warning}"));
    }
    Ok(())
}

/// Radiation fog after sunrise: banks twelve metres deep, the low sun shining through them.
fn fog() -> Result<Recipe, Box<dyn Error>> {
    let camera = CameraPlacement { position_m: [0.0, 2.0, 62.0], target_m: [0.0, 5.0, 0.0] };
    Ok(Recipe {
        count: 200_000,
        kind: ParticleKind::Parcel,
        distribution: SizeDistribution::parse("gamma:reff=6um,veff=0.1", &no_files)?,
        content: Content::LiquidWaterGPerM3(0.04),
        seed: 1,
        overlap: 0.65,
        patchiness: 1.0,
        view: View { camera: Some(camera), sun_elevation_deg: 13.0, sun_azimuth_deg: 20.0, ..View::default() },
        settings: settings(json!({
            "accuracy": { "target": 0.06 },
            "effects": { "multiple": "off" },
            "background": { "radiance": [0.05, 0.07, 0.11] },
        })),
        ..Recipe::new(CloudShape::new("slab", &[160.0, 12.0, 160.0])?)
    })
}

/// One droplet of 10 um, drawn a metre wide, in air that only the droplet lights.
fn droplet() -> Result<Recipe, Box<dyn Error>> {
    Ok(Recipe {
        count: 1,
        distribution: SizeDistribution::parse("mono:r=5um", &no_files)?,
        view: View { sun_elevation_deg: 35.0, sun_azimuth_deg: 100.0, ..View::default() },
        settings: settings(json!({
            "atmosphere": {
                "scattering_per_m": 0.025, "absorption_per_m": 0.1, "depth_m": 8.0, "step_m": 0.05, "sunlight": false,
            },
        })),
        ..Recipe::new(CloudShape::new("droplet", &[1.0])?)
    })
}

/// A droplet of one of the paper's figures, drawn a metre wide in white light from the upper left, which passes it at right
/// angles to the view: what goes forward lights the air to the lower right, what goes backward that to the upper left.
fn paper_figure(figure: &Figure) -> Result<Recipe, Box<dyn Error>> {
    let distribution = format!("mono:r={}nm", 0.5 * figure.diameter_nm);
    let camera = CameraPlacement { position_m: [0.0, 0.0, 6.0], target_m: [0.0; 3] };
    Ok(Recipe {
        count: 1,
        distribution: SizeDistribution::parse(&distribution, &no_files)?,
        material: Material::parse(&format!("n={},k={}", INDEX.re, INDEX.im), &no_files)?,
        view: View { camera: Some(camera), sun_elevation_deg: 45.0, sun_azimuth_deg: 90.0, ..View::default() },
        settings: settings(json!({
            "atmosphere": {
                "scattering_per_m": 0.025, "absorption_per_m": 0.1, "phase": "isotropic", "depth_m": 10.0, "step_m": 0.2,
                "sunlight": false,
            },
            "spectral": { "mode": "rgb" },
            "image": { "resolution": [320, 180] },
        })),
        ..Recipe::new(CloudShape::new("droplet", &[1.0])?)
    })
}

fn settings(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(settings) => settings,
        _ => Map::new(),
    }
}

fn no_files(name: &str) -> Result<String, String> {
    Err(format!("{name} may not be read"))
}
