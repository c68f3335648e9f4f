//! Drops of rain seen close, over a meadow: glass balls that show it upside down.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use mie_cloud::image::Picture;
use serde_json::{Value, json};

use super::document::{Sphere, View, add_points, without_fog};

/// Drops of half a millimetre to two millimetres, the largest in the middle, hanging in front of a meadow with poppies. The sun
/// is a bright spot in the background picture, behind the viewer to the left, a little more than the rainbow's angle from the point
/// opposite: so drops show it as a glint of the rainbow's colours where they would be a part of the bow. Sunlight as the
/// mean over a drop's disc would only hide that.
pub fn drop() -> Value {
    let view = View { position_m: DVec3::new(0.0, 0.0, 7e-3), direction: DVec3::NEG_Z, yfov_deg: 20.0 };
    let [sun_longitude, sun_latitude] = SUN_DEG.map(f64::to_radians);
    let mut scene = without_fog(
        &view,
        -toward(sun_longitude, sun_latitude),
        json!({
            "background": { "image": MEADOW },
            "spectral": { "mode": "bands:12" },
            "effects": { "direct": "off", "multiple": "off" },
            "accuracy": { "target": 0.06 },
            "image": { "resolution": [480, 270] },
        }),
    );
    // Millimetres.
    let drops = [
        ([0.0, 0.0, 0.0], 1.0),
        ([-2.1, 1.0, -2.2], 0.55),
        ([2.0, 0.75, -1.2], 0.4),
        ([1.75, -0.95, -2.6], 0.6),
        ([-1.65, -0.85, 0.1], 0.28),
        ([-0.9, 1.45, -3.0], 0.35),
        ([3.3, -0.1, -4.0], 0.5),
        ([-3.6, -1.3, -4.5], 0.7),
        ([1.0, 1.5, -6.0], 0.5),
    ];
    add_points(&mut scene, "Drops", 1e-3, &drops.map(|(center, radius)| Sphere { center, radius }));
    scene
}

/// The background's file, beside the scene.
pub const MEADOW: &str = "meadow.exr";

const WIDTH: u32 = 384;

/// Where the sun is, degrees to the right of the view and above the horizon.
const SUN_DEG: [f64; 2] = [-140.5, 15.0];

/// A meadow with flowers, trees and hills under the evening's sky, as a lat-long picture.
pub fn meadow() -> Picture {
    let height = WIDTH / 2;
    let flowers = flowers();
    let texel = |i: u32| {
        let longitude = (f64::from(i % WIDTH) + 0.5) / f64::from(WIDTH) * TAU - PI;
        let latitude = PI / 2.0 - (f64::from(i / WIDTH) + 0.5) / f64::from(height) * PI;
        color(longitude, latitude, &flowers)
    };
    let texels: Vec<DVec3> = (0..WIDTH * height).map(texel).collect();
    let mut picture = Picture::new(WIDTH, height);
    for (name, of) in [("R", 0), ("G", 1), ("B", 2)] {
        picture.push(name, texels.iter().map(|texel| coarse(texel[of] as f32)).collect());
    }
    picture
}

/// To nine binary digits, so that the file is small.
fn coarse(value: f32) -> f32 {
    f32::from_bits(value.to_bits() & 0xffff_8000)
}

/// 0 below the first number, 1 above the second, and smooth between.
fn step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn toward(longitude: f64, latitude: f64) -> DVec3 {
    DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), -longitude.cos() * latitude.cos())
}

fn color(longitude: f64, latitude: f64, flowers: &[Flower]) -> DVec3 {
    let (direction, up_deg) = (toward(longitude, latitude), latitude.to_degrees());
    let wave = |n: f64, phase: f64| (n * longitude + phase).sin();
    let hills_deg = 4.5 + 2.2 * wave(2.0, 2.6) + 1.3 * wave(5.0, 2.0) + 0.6 * wave(11.0, 1.0);
    let crowns = wave(9.0, 0.4).abs().sqrt() * wave(23.0, 1.3).abs();
    let trees_deg = 1.5 + 2.2 * crowns + 1.5 * wave(4.0, 0.0).abs();
    let mut color = sky(direction, up_deg);
    for (top_deg, soft_deg, paint) in [
        (hills_deg, 0.8, DVec3::new(0.10, 0.16, 0.13)),
        (trees_deg, 0.7, DVec3::new(0.02, 0.045, 0.018)),
        (0.0, 0.4, meadow_color(direction, [longitude, latitude], flowers)),
    ] {
        color = color.lerp(paint, step(top_deg + soft_deg, top_deg - soft_deg, up_deg));
    }
    color
}

fn sky(direction: DVec3, up_deg: f64) -> DVec3 {
    let [sun_longitude, sun_latitude] = SUN_DEG.map(f64::to_radians);
    let from_sun_deg = direction.angle_between(toward(sun_longitude, sun_latitude)).to_degrees();
    let height = (up_deg / 90.0).clamp(0.0, 1.0).sqrt();
    let blue = DVec3::new(0.45, 0.40, 0.36).lerp(DVec3::new(0.03, 0.10, 0.34), height);
    let disc = 250.0 * (-(from_sun_deg / 1.0).powi(2)).exp();
    let glow = 4.0 * (-from_sun_deg / 5.0).exp() + 0.5 * (-from_sun_deg / 22.0).exp();
    blue + (disc + glow) * DVec3::new(1.0, 0.85, 0.6)
}

struct Flower {
    toward: DVec3,
    width_deg: f64,
    color: DVec3,
}

/// Poppies and others, larger where they are nearer.
fn flowers() -> Vec<Flower> {
    let colors = [[0.9, 0.06, 0.03], [0.95, 0.85, 0.15], [0.9, 0.9, 0.85], [0.45, 0.2, 0.7]].map(DVec3::from);
    // Additive recurrences of the plastic number spread them evenly (Roberts 2018).
    let one = |i: usize| {
        let [u, v] = [0.754_877_666_2, 0.569_840_290_9].map(|a| (0.5 + a * i as f64).fract());
        let down = 0.03 + 0.92 * v;
        Flower {
            toward: toward(TAU * u, -down.asin()),
            width_deg: 1.3 + 1.2 * down,
            color: 0.8 * colors[i * 7 % 11 % colors.len()],
        }
    };
    (0..260).map(one).collect()
}

fn meadow_color(direction: DVec3, [longitude, latitude]: [f64; 2], flowers: &[Flower]) -> DVec3 {
    let near = (-latitude / 1.05).clamp(0.0, 1.0);
    let grass = DVec3::new(0.16, 0.24, 0.05).lerp(DVec3::new(0.05, 0.11, 0.02), near);
    let tufts = (37.0 * longitude + 3.0 * (35.0 * latitude).sin()).sin()
        * (61.0 * latitude + 2.0 * (9.0 * longitude).sin()).sin();
    flowers.iter().fold(grass * (1.0 + 0.35 * tufts), |color, flower| {
        let away = direction.angle_between(flower.toward).to_degrees() / flower.width_deg;
        color.lerp(flower.color, (-away.powi(4)).exp())
    })
}
