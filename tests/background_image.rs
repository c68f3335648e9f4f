//! Lat-long backgrounds: which way they lie, in every spectral mode, through fog, and which files are refused.

mod common;
mod program;

use common::*;
use glam::{DMat3, DVec3};
use mie_cloud::image::{Chromaticities, Existing, Picture, exr};
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::model::{Lens, Scene};
use mie_cloud::spectrum::SpectralMode;

/// Eight by four texels, each its own colour.
fn color(column: u32, row: u32) -> [f32; 3] {
    [0.1 + column as f32 / 8.0, 0.1 + row as f32 / 4.0, 0.3]
}

fn write(path: &std::path::Path, channels: &[&str], value: impl Fn(u32, u32, usize) -> f32) {
    let mut picture = Picture::new(8, 4);
    for (c, name) in channels.iter().enumerate() {
        let texels = (0..4).flat_map(|row| (0..8).map(move |column| (column, row)));
        picture.push(*name, texels.map(|(column, row)| value(column, row, c)).collect());
    }
    exr::write(path, &picture, Existing::Replace).expect("can be written");
}

/// A scene that looks in a direction through a view so narrow that it is one texel's middle.
fn looking(path: &std::path::Path, direction: DVec3) -> Scene {
    let mut scene = empty_scene();
    scene.settings.background.image = Some(path.into());
    scene.settings.image.resolution = [2, 2];
    let back = -direction.normalize();
    let right = DVec3::Y.cross(back).normalize();
    scene.camera.world_from_camera = DMat3::from_cols(right, back.cross(right), back);
    scene.camera.lens = Lens::Perspective { yfov_rad: 1e-6, aspect: None };
    scene
}

/// The middle of a texel: -Z is the middle of the picture, +X to its right, +Y on top.
fn toward(column: u32, row: u32) -> DVec3 {
    let longitude = ((f64::from(column) + 0.5) / 8.0 - 0.5) * std::f64::consts::TAU;
    let elevation = (0.5 - (f64::from(row) + 0.5) / 4.0) * std::f64::consts::PI;
    DVec3::new(elevation.cos() * longitude.sin(), elevation.sin(), -elevation.cos() * longitude.cos())
}

#[test]
fn every_texel_is_seen_where_it_belongs() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.exr");
    write(&path, &["R", "G", "B"], |column, row, c| color(column, row)[c]);
    for row in 0..4 {
        for column in 0..8 {
            let mut scene = looking(&path, toward(column, row));
            scene.settings.spectral_mode = Some(SpectralMode::Bands { count: 8 });
            let picture = channels(&render_scene(scene, 2, 1));
            for (channel, expected) in ["background.R", "background.G", "background.B"].iter().zip(color(column, row)) {
                let found = mean(&picture[*channel]);
                assert!((found - f64::from(expected)).abs() < 1e-5, "{column} {row} {channel}: {found} {expected}");
            }
        }
    }
    // In words: ahead right of the middle, above the horizon.
    assert!(toward(4, 1).x > 0.0 && toward(4, 1).z < 0.0 && toward(4, 1).y > 0.0);
}

#[test]
fn pictures_come_out_as_they_are_in_every_mode() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grey.exr");
    write(&path, &["Y"], |_, _, _| 0.7);
    for mode in ["mono:550nm", "rgb", "bands:1", "bands:8", "bands:33"] {
        let mut scene = looking(&path, DVec3::new(0.3, 0.2, -1.0));
        scene.settings.spectral_mode = Some(mode.parse().expect("a mode"));
        let picture = channels(&render_scene(scene, 1, 1));
        for channel in ["R", "G", "B"] {
            assert!((mean(&picture[channel]) - 0.7).abs() < 1e-6, "{mode} {channel}");
        }
    }
}

/// Paths that fog scatters look the picture up where they leave: isotropic, deep, white fog shows its mean over the sphere.
#[test]
fn fog_shows_the_mean_of_its_surroundings() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("halves.exr");
    write(&path, &["Y"], |_, row, _| if row < 2 { 1.0 } else { 0.2 });
    // Straight from the side: as much from above as from below.
    let mut scene = looking(&path, DVec3::NEG_Z);
    with_phase(&mut scene, PhaseModel::Isotropic);
    scene.classes[0].albedo = Some(1.0);
    scene.suns[0].lux = 0.0;
    scene.particles = vec![parcel(DVec3::ZERO, 1.0, 1e11)];
    let (mean, error) = mean_and_error(&render_scene(scene, 4000, 1));
    assert!((mean - 0.6).abs() < 4.0 * error && error < 0.01, "{mean} +- {error}");
}

#[test]
fn bad_pictures_end_with_3_and_say_what_to_do() {
    let bench = program::Bench::with_cloud();
    let render = |set: &str| format!("render cloud.glb -o a.exr --resolution 2x2 --spp 1 --set background.image={set}");
    bench.write("text.exr", "no picture");
    let said = bench.fails(3, &render("text.exr"));
    program::assert_says(&said, &["text.exr", "background.image", "OpenEXR"]);
    write(&bench.path("depth.exr"), &["Z"], |_, _, _| 1.0);
    program::assert_says(&bench.fails(3, &render("depth.exr")), &["depth.exr", "Z", "R, G and B"]);
    for bad in [2e12, f32::INFINITY, f32::NAN] {
        let pixel = |x, y| (1.0f32, if x == 2 && y == 1 { bad } else { 0.0 }, 0.5f32);
        ::exr::prelude::write_rgb_file(bench.path("nan.exr"), 4, 2, pixel).expect("can be written");
        let said = bench.fails(3, &render("nan.exr"));
        program::assert_says(&said, &["nan.exr", "(2, 1)", "G", "a number of at most 1e12"]);
    }
    // Left out, it is not read.
    bench.ok(&format!("{} --effects -background -q", render("nan.exr")));
    write(&bench.path("negative.exr"), &["R", "G", "B"], |_, _, c| c as f32 - 0.5);
    let output = bench.run(&render("negative.exr"));
    assert_eq!(output.status.code(), Some(0));
    program::assert_says(&program::text(&output.stderr), &["negative.exr", "32 values are negative"]);
    // AP0 (SMPTE ST 2065-1) has other primaries; those of BT.709 may be written with fewer digits.
    let ap0 =
        Chromaticities { red: [0.7347, 0.2653], green: [0.0, 1.0], blue: [0.0001, -0.0770], white: [0.32168, 0.33767] };
    let rounded = Chromaticities { white: [0.313, 0.329], ..Chromaticities::BT709 };
    for (name, colours, is_told) in [("ap0.exr", ap0, true), ("bt709.exr", rounded, false)] {
        let mut picture = grey_sky();
        picture.chromaticities = Some(colours);
        exr::write(&bench.path(name), &picture, Existing::Replace).expect("can be written");
        let said = program::text(&bench.run(&render(name)).stderr);
        assert_eq!(said.contains("other primaries than BT.709"), is_told, "{name}: {said}");
    }
}

fn grey_sky() -> Picture {
    let mut picture = Picture::new(8, 4);
    for name in ["R", "G", "B"] {
        picture.push(name, vec![0.5; 32]);
    }
    picture
}
