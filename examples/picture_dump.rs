//! Prints what an OpenEXR file holds as JSON: size, windows, attributes, and the mean and extremes of each channel.
//!
//! `cargo run --example picture_dump -- FILE.exr [VALUES.bin]`. VALUES.bin gets every value of every channel in the
//! order of the JSON, 32-bit floats, least byte first, row by row, so that other programs can compare bit by bit.

use std::error::Error;
use std::path::Path;

use mie_cloud::image::file::{Existing, write_atomically};
use mie_cloud::image::{Attribute, Channel, Picture, exr};
use serde_json::{Map, Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = arguments.next().ok_or("usage: picture_dump FILE.exr [VALUES.bin]")?;
    let picture = exr::read(Path::new(&path), exr::Limits::default())?;
    if let Some(values) = arguments.next() {
        write_atomically(Path::new(&values), Existing::Replace, |writer| {
            let all = picture.channels.iter().flat_map(|channel| &channel.values);
            all.map(|value| value.to_le_bytes()).try_for_each(|bytes| writer.write_all(&bytes))
        })?;
    }
    println!("{}", serde_json::to_string_pretty(&dump(&picture))?);
    Ok(())
}

fn dump(picture: &Picture) -> Value {
    let frame = picture.frame;
    let attributes: Map<String, Value> =
        picture.attributes.iter().map(|(name, value)| (name.clone(), attribute(value))).collect();
    json!({
        "width": picture.width, "height": picture.height,
        "frame": {"x": frame.x, "y": frame.y, "full_width": frame.full_width, "full_height": frame.full_height},
        "chromaticities": picture.chromaticities.map(|c| [c.red, c.green, c.blue, c.white].concat()),
        "white_luminance_cd_m2": picture.white_luminance_cd_m2,
        "attributes": attributes,
        "channels": picture.channels.iter().map(describe).collect::<Vec<_>>(),
    })
}

/// The type by its name in the format, and the value.
fn attribute(value: &Attribute) -> Value {
    match value {
        Attribute::Text(value) => json!(["string", value]),
        Attribute::Texts(values) => json!(["stringvector", values]),
        Attribute::Int(value) => json!(["int", value]),
        Attribute::Float(value) => json!(["float", value]),
        Attribute::Double(value) => json!(["double", value]),
        Attribute::IntPair(values) => json!(["v2i", values]),
        Attribute::FloatPair(values) => json!(["v2f", values]),
        Attribute::FloatTriple(values) => json!(["v3f", values]),
        Attribute::IntBox(values) => json!(["box2i", values]),
        other => json!(["unknown", format!("{other:?}")]),
    }
}

fn describe(channel: &Channel) -> Value {
    let mean = channel.values.iter().map(|value| f64::from(*value)).sum::<f64>() / channel.values.len() as f64;
    let least = channel.values.iter().copied().fold(f32::INFINITY, f32::min);
    let greatest = channel.values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    json!({"name": channel.name, "mean": mean, "min": least, "max": greatest})
}
