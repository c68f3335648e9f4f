//! One picture: a ball of fog, described in code, as OpenEXR with a preview.
//! `cargo run --release --example one_picture -- ball.exr ball.png`

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use glam::DVec3;
use mie_cloud::film::develop;
use mie_cloud::image::file::Existing;
use mie_cloud::image::{Picture, exr, png};
use mie_cloud::plan;
use mie_cloud::scene::frame_cloud::{default_sun, framing_camera};
use mie_cloud::scene::model::{Particle, ParticleKind, Scene};
use mie_cloud::scene::settings::Settings;
use mie_cloud::spectrum::{SpectralMode, SpectralSampling};
use mie_cloud::transport::{Prepared, RenderRequest, SilentProgress, Spectral, Until, render};

pub fn main() -> Result<(), Box<dyn Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let [exr_name, png_name] = names.as_slice() else { return Err("usage: one_picture OUT.exr OUT.png".into()) };
    draw(exr_name.as_ref(), png_name.as_ref(), 64)
}

/// Draws the ball with so many samples in every pixel.
pub fn draw(exr_path: &Path, png_path: &Path, spp: u32) -> Result<(), Box<dyn Error>> {
    let (width, height) = (320, 180);
    let mut settings = Settings::default();
    settings.image.resolution = [width, height];
    settings.background.radiance = [0.05, 0.08, 0.12];
    // 5e9 droplets of 5 um in a ball of 1 m: an optical depth of about 0.5 through its middle.
    let (kind, radius_m, count) = (ParticleKind::Parcel, 1.0, 5e9);
    let ball = Particle { center_m: DVec3::ZERO, radius_m, droplet_radius_m: 5e-6, count, class: 0, kind };
    let camera = framing_camera(&[ball], &[], f64::from(width) / f64::from(height));
    let scene = Scene {
        name: "ball".into(),
        suns: vec![default_sun(&camera)],
        classes: vec![settings.droplets.class.clone()],
        particles: vec![ball],
        fog_balls: Vec::new(),
        fog_boxes: Vec::new(),
        hash: String::new(),
        warnings: Vec::new(),
        files: Vec::new(),
        camera,
        settings,
    };

    let sampling = SpectralSampling::new(SpectralMode::Bands { count: 8 }, scene.settings.sun.spectrum);
    let effects = plan::plan(&scene, &BTreeMap::new(), 0.05, sampling.wavelengths_m.len());
    let prepared = Prepared::new(scene, &effects, &sampling, None, &mut |_| {})?;
    let (until, crop) = (Until::Samples(spp), [0, 0, width, height]);
    let request = RenderRequest { seed: 0, until, crop, layers: Vec::new(), spectral: Spectral::Discard };
    let film = render(&prepared.context(), &request, &SilentProgress).film;

    let mut picture = Picture::new(width, height);
    develop(&film, &[], 1.0).into_iter().for_each(|channel| picture.push(channel.name, channel.values));
    exr::write(exr_path, &picture, Existing::Replace)?;
    Ok(png::write_preview(png_path, &picture, Existing::Replace)?)
}
