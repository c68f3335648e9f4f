//! Rings of light around the sun and around the point opposite: thin water clouds of narrow size distributions.

use glam::DVec3;
use serde_json::{Value, json};

use super::document::{FogBox, View, add_fog, without_fog};

/// The direction that rises by `up_deg` from the horizon, away from the viewer.
fn ahead(up_deg: f64) -> DVec3 {
    let (sin, cos) = up_deg.to_radians().sin_cos();
    DVec3::new(0.0, sin, -cos)
}

/// A fogbow over a plain, from a tower of 14 m; the sun stands 20 degrees high behind the viewer. The fog ends at the
/// ground, which is why the bow is fainter below the horizon.
pub fn fogbow() -> Value {
    let view = View { position_m: DVec3::new(0.0, 14.0, 0.0), direction: ahead(0.0), yfov_deg: 70.0 };
    let mut scene = without_fog(
        &view,
        ahead(-20.0),
        json!({
            "droplets": { "distribution": "gamma:reff=20um,veff=0.01" },
            "accuracy": { "target": 0.035 },
            "background": { "radiance": [0.0015, 0.0025, 0.004] },
        }),
    );
    let fog =
        FogBox { center_m: [0.0, 30.0, -125.0], size_m: [900.0, 60.0, 250.0], extinction_per_m: 0.0012, albedo: None };
    add_fog(&mut scene, &[fog]);
    scene
}

/// A glory on a thin layer of cloud far below, the sun 50 degrees high.
pub fn glory() -> Value {
    let view = View { position_m: DVec3::ZERO, direction: ahead(-50.0), yfov_deg: 12.0 };
    let mut scene = without_fog(
        &view,
        ahead(-50.0),
        json!({
            "droplets": { "distribution": "gamma:reff=10um,veff=0.01" },
            "accuracy": { "target": 0.03 },
        }),
    );
    let fog = FogBox {
        center_m: [0.0, -1000.0, -840.0],
        size_m: [2000.0, 100.0, 2000.0],
        extinction_per_m: 0.0007,
        albedo: None,
    };
    add_fog(&mut scene, &[fog]);
    scene
}

/// A corona around the sun behind a thin veil of cloud; the sun itself is as wide as it is (0.53 degrees) where its disc
/// is drawn, and is a point otherwise.
pub fn corona() -> Value {
    let view = View { position_m: DVec3::ZERO, direction: ahead(35.0), yfov_deg: 14.0 };
    let mut scene = without_fog(
        &view,
        -ahead(35.0),
        json!({
            "droplets": { "distribution": "gamma:reff=8um,veff=0.01" },
            "accuracy": { "target": 0.03 },
            "background": { "radiance": [0.004, 0.007, 0.012] },
        }),
    );
    let fog = FogBox {
        center_m: [0.0, 1000.0, -1428.0],
        size_m: [3000.0, 60.0, 3000.0],
        extinction_per_m: 0.0003,
        albedo: None,
    };
    add_fog(&mut scene, &[fog]);
    scene
}

/// Primary and secondary rainbow with Alexander's dark band between them and supernumerary bows inside the first, in
/// a shower of drops half a millimetre wide.
pub fn rainbow() -> Value {
    let view = View { position_m: DVec3::new(0.0, 40.0, 0.0), direction: ahead(8.0), yfov_deg: 70.0 };
    let mut scene = without_fog(
        &view,
        ahead(-22.0),
        json!({
            "droplets": { "distribution": "gamma:reff=250um,veff=0.005" },
            "accuracy": { "target": 0.04 },
            "spectral": { "mode": "bands:16" },
            "background": { "radiance": [0.002, 0.0025, 0.0035] },
        }),
    );
    let rain = FogBox {
        center_m: [0.0, 150.0, -800.0],
        size_m: [4000.0, 300.0, 1200.0],
        extinction_per_m: 0.0002,
        albedo: None,
    };
    add_fog(&mut scene, &[rain]);
    scene
}
