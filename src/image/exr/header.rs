//! The header of an OpenEXR file, byte by byte, with every attribute in the order of its name.
//!
//! Layout: "OpenEXR File Layout" (Academy Software Foundation): magic number, version field, attributes as name, type,
//! size and value, a zero byte. The OpenEXR library itself writes attributes sorted by name.

use std::collections::BTreeMap;

use super::EncodeError;
use crate::image::picture::{Attribute, Picture};

/// Magic number and version 2 (OpenEXR File Layout, "Magic Number" and "Version Field").
pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const VERSION: u32 = 2;
/// Bit 10 of the version field: names longer than 31 bytes occur.
const LONG_NAMES: u32 = 1 << 10;
const LONGEST_SHORT_NAME_BYTES: usize = 31;
/// Code of ZIP in blocks of 16 lines, of increasing y, and of 32-bit float samples (same document).
const COMPRESSION_ZIP16: u8 = 3;
const LINE_ORDER_INCREASING_Y: u8 = 0;
const SAMPLE_FLOAT: i32 = 2;

/// Names that have a meaning of their own for the layout of a file, or that fields of [`Picture`] stand for.
pub const STRUCTURAL: [&str; 18] = [
    "channels",
    "chromaticities",
    "chunkCount",
    "compression",
    "dataWindow",
    "deepImageState",
    "displayWindow",
    "dwaCompressionLevel",
    "lineOrder",
    "maxSamplesPerPixel",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "type",
    "version",
    "whiteLuminance",
];

/// An attribute's type name and value as they stand in the file.
struct Encoded {
    kind: &'static str,
    bytes: Vec<u8>,
}

/// Encodes magic number, version and attributes of `picture`, its channels in the given order.
pub fn encode_header(picture: &Picture, channel_names: &[&str]) -> Result<Vec<u8>, EncodeError> {
    let mut attributes = structure(picture, channel_names);
    for (name, value) in &picture.attributes {
        if STRUCTURAL.contains(&name.as_str()) {
            return Err(EncodeError::Reserved(name.clone()));
        }
        attributes.insert(name, encode_attribute(value));
    }
    let long = attributes.keys().chain(channel_names).any(|name| name.len() > LONGEST_SHORT_NAME_BYTES);
    let mut out = MAGIC.to_vec();
    out.extend((VERSION | if long { LONG_NAMES } else { 0 }).to_le_bytes());
    for (name, Encoded { kind, bytes }) in attributes {
        let size = i32::try_from(bytes.len()).map_err(|_| EncodeError::Long(name.into()))?;
        push_name(&mut out, name);
        push_name(&mut out, kind);
        out.extend(size.to_le_bytes());
        out.extend(bytes);
    }
    out.push(0);
    Ok(out)
}

/// The attributes that every file has, and those that fields of the picture stand for.
fn structure<'a>(picture: &'a Picture, channel_names: &[&str]) -> BTreeMap<&'a str, Encoded> {
    let frame = picture.frame;
    let (right, bottom) = (frame.x + picture.width as i32 - 1, frame.y + picture.height as i32 - 1);
    let full = [0, 0, frame.full_width as i32 - 1, frame.full_height as i32 - 1];
    let mut attributes = BTreeMap::from([
        ("channels", encode_channels(channel_names)),
        ("compression", Encoded { kind: "compression", bytes: vec![COMPRESSION_ZIP16] }),
        ("dataWindow", encode_attribute(&Attribute::IntBox([frame.x, frame.y, right, bottom]))),
        ("displayWindow", encode_attribute(&Attribute::IntBox(full))),
        ("lineOrder", Encoded { kind: "lineOrder", bytes: vec![LINE_ORDER_INCREASING_Y] }),
        ("pixelAspectRatio", encode_attribute(&Attribute::Float(1.0))),
        ("screenWindowCenter", encode_attribute(&Attribute::FloatPair([0.0, 0.0]))),
        ("screenWindowWidth", encode_attribute(&Attribute::Float(1.0))),
    ]);
    if let Some(colours) = picture.chromaticities {
        let bytes = floats(&[colours.red, colours.green, colours.blue, colours.white].concat());
        attributes.insert("chromaticities", Encoded { kind: "chromaticities", bytes });
    }
    if let Some(luminance) = picture.white_luminance_cd_m2 {
        attributes.insert("whiteLuminance", encode_attribute(&Attribute::Float(luminance)));
    }
    attributes
}

/// Channel list: name, sample type, linearity and three reserved bytes, sampling in x and y; closed by a zero byte.
fn encode_channels(channel_names: &[&str]) -> Encoded {
    let mut bytes = Vec::new();
    for name in channel_names {
        push_name(&mut bytes, name);
        bytes.extend(SAMPLE_FLOAT.to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend([1_i32, 1].map(i32::to_le_bytes).concat());
    }
    bytes.push(0);
    Encoded { kind: "chlist", bytes }
}

fn encode_attribute(value: &Attribute) -> Encoded {
    let (kind, bytes) = match value {
        Attribute::Text(text) => ("string", text.clone().into_bytes()),
        Attribute::Texts(texts) => ("stringvector", encode_texts(texts)),
        Attribute::Int(value) => ("int", value.to_le_bytes().to_vec()),
        Attribute::Float(value) => ("float", floats(&[*value])),
        Attribute::Double(value) => ("double", value.to_le_bytes().to_vec()),
        Attribute::IntPair(values) => ("v2i", ints(values)),
        Attribute::FloatPair(values) => ("v2f", floats(values)),
        Attribute::FloatTriple(values) => ("v3f", floats(values)),
        Attribute::IntBox(values) => ("box2i", ints(values)),
    };
    Encoded { kind, bytes }
}

/// Each text with its length before it. A text above 2 GiB makes the attribute too long, which the caller reports.
fn encode_texts(texts: &[String]) -> Vec<u8> {
    texts.iter().flat_map(|text| [&(text.len() as i32).to_le_bytes()[..], text.as_bytes()].concat()).collect()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn ints(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn push_name(out: &mut Vec<u8>, name: &str) {
    out.extend(name.as_bytes());
    out.push(0);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(header: &[u8]) -> Vec<String> {
        let (mut at, mut names) = (8, Vec::new());
        let word = |at: &mut usize| {
            let end = *at + header[*at..].iter().position(|byte| *byte == 0).expect("names end with zero");
            let text = String::from_utf8_lossy(&header[*at..end]).into_owned();
            *at = end + 1;
            text
        };
        while header[at] != 0 {
            names.push(word(&mut at));
            word(&mut at);
            let size = i32::from_le_bytes(header[at..at + 4].try_into().expect("four bytes"));
            at += 4 + size as usize;
        }
        assert_eq!(at + 1, header.len());
        names
    }

    #[test]
    fn attributes_stand_in_the_order_of_their_names() {
        let mut picture = Picture::new(3, 2);
        picture.white_luminance_cd_m2 = Some(1.0);
        for name in ["zeta", "Alpha", "software", "comments"] {
            picture.record(name, Attribute::Text("x".into()));
        }
        let header = encode_header(&picture, &["B", "G", "R"]).expect("sound");
        let names = names_in(&header);
        assert!(names.is_sorted(), "{names:?}");
        assert_eq!(names.len(), 14);
        assert_eq!(header[5], 0, "no long names");
    }

    #[test]
    fn long_names_are_announced_and_reserved_names_refused() {
        let mut picture = Picture::new(1, 1);
        picture.record("n".repeat(32), Attribute::Int(1));
        assert_eq!(encode_header(&picture, &["Y"]).expect("sound")[5], 4, "bit 10");
        picture.record("tiles", Attribute::Int(1));
        assert!(matches!(encode_header(&picture, &["Y"]), Err(EncodeError::Reserved(name)) if name == "tiles"));
    }
}
