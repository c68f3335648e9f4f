//! Writes a picture whose every value follows from a formula, so that other programs can check what they read.
//!
//! `cargo run --example write_test_picture -- FOLDER` writes `whole.exr`, `crop.exr`, `spectral.exr` and `pixel.exr`.
//! Channel number c (in the order below) has at pixel (x, y) of the full frame the value
//! ((x + 1) * 0.5 + (y + 1) * 0.25 + c) * 2^(c - 4) * (-1)^x, which a 32-bit float holds exactly.

use std::error::Error;
use std::path::Path;

use mie_cloud::image::{Attribute, Existing, Frame, Picture, exr, spectral};

const CHANNELS: [&str; 8] = ["R", "G", "B", "A", "direct.R", "stderr.G", "samples.N", "depth.Z"];
const WAVELENGTHS_NM: [f64; 3] = [380.0, 550.0, 612.5];

fn value(x: i32, y: i32, channel: usize) -> f32 {
    let sign = if x % 2 == 0 { 1.0 } else { -1.0 };
    ((x + 1) as f32 * 0.5 + (y + 1) as f32 * 0.25 + channel as f32) * 2f32.powi(channel as i32 - 4) * sign
}

fn plane(frame: Frame, width: u32, height: u32, channel: usize) -> Vec<f32> {
    (0..height as i32).flat_map(|y| (0..width as i32).map(move |x| value(frame.x + x, frame.y + y, channel))).collect()
}

fn test_picture(width: u32, height: u32, frame: Frame) -> Picture {
    let mut picture = Picture::new(width, height);
    picture.frame = frame;
    picture.white_luminance_cd_m2 = Some(42_435.5);
    for (index, name) in CHANNELS.iter().enumerate() {
        picture.push(*name, plane(frame, width, height, index));
    }
    for (name, value) in [
        ("software", Attribute::Text("mie-cloud test".into())),
        ("comments", Attribute::Text("two lines\nand µ".into())),
        ("mie_cloud.seed", Attribute::Text("18446744073709551615".into())),
        ("mie_cloud.samples", Attribute::Int(64)),
        ("mie_cloud.noise", Attribute::Float(0.125)),
        ("mie_cloud.time", Attribute::Double(0.1)),
        ("mie_cloud.a_name_of_more_than_31_characters", Attribute::Text("long".into())),
        ("mie_cloud.range", Attribute::IntPair([-3, 7])),
        ("mie_cloud.direction", Attribute::FloatTriple([0.5, -0.25, 1.0])),
        ("mie_cloud.effects", Attribute::Texts(vec!["direct".into(), "glow".into()])),
    ] {
        picture.record(name, value);
    }
    picture
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: write_test_picture FOLDER")?;
    let folder = Path::new(&folder);
    let write = |name: &str, picture: &Picture| exr::write(&folder.join(name), picture, Existing::Replace);
    write("whole.exr", &test_picture(70, 37, Frame::whole(70, 37)))?;
    write("pixel.exr", &test_picture(1, 1, Frame::whole(1, 1)))?;
    write("crop.exr", &test_picture(17, 33, Frame { x: 12, y: 5, full_width: 64, full_height: 48 }))?;
    let mut spectrum = test_picture(5, 18, Frame::whole(5, 18));
    let planes = WAVELENGTHS_NM.iter().enumerate();
    let planes: Vec<_> = planes.map(|(index, nm)| (*nm, plane(spectrum.frame, 5, 18, 8 + index))).collect();
    spectral::add_spectrum(&mut spectrum, planes, spectral::SPECTRAL_RADIANCE);
    write("spectral.exr", &spectrum)?;
    Ok(())
}
