//! The droplets of the paper's figures.

use std::error::Error;

use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::material::Material;
use mie_cloud::paper::{Figure, INDEX};
use mie_cloud::scene::generate::{CameraPlacement, CloudShape, Recipe, View};
use serde_json::{Value, json};

use super::document::{no_files, of_cloud, settings};

/// A droplet of one of the paper's figures, drawn a metre wide in white light from the upper left, which passes it at right
/// angles to the view: what goes forward lights the air to the lower right, what goes backward that to the upper left.
pub fn figure(figure: &Figure) -> Result<Value, Box<dyn Error>> {
    // To the picometre, as the figures give diameters; halves of a decimal number are not always the nearest to their text.
    let radius_um = (figure.diameter_nm * 5e5).round() / 1e9;
    let distribution = format!("mono:r={radius_um}um");
    let camera = CameraPlacement { position_m: [0.0, 0.0, 6.0], target_m: [0.0; 3] };
    of_cloud(&Recipe {
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
            // The paper's air scatters once, and its light is parallel.
            "effects": { "air-multiple": "off", "sun-disc": "off" },
            "image": { "resolution": [320, 180] },
        })),
        ..Recipe::new(CloudShape::new("droplet", &[1.0])?)
    })
}
