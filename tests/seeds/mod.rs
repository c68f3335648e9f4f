//! Sound files of every kind that is read, and files that were found to break a reader: what damage begins with.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    Vec2, WritableImage, f16,
};
use mie_cloud::image::{Attribute, Picture, exr};

use crate::program::Bench;
use crate::readers::files::CLOUD;

/// A file and where it comes from.
pub struct Seed {
    pub name: String,
    pub bytes: Vec<u8>,
}

impl Seed {
    fn new(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self { name: name.into(), bytes }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// The seeds of a reader, kept files among them; larger ones than `most_bytes` are left out.
pub fn of(reader: &str, most_bytes: usize) -> Vec<Seed> {
    let mut seeds = match reader {
        "scene" => scenes(),
        "exr" => pictures(),
        "diff" => pairs(),
        "part" => parts(),
        "resume" => [parts(), files("tests/data/seeds", reader)].into_iter().flatten().collect(),
        "table" => tables(),
        _ => files("tests/data/seeds", reader),
    };
    seeds.extend(kept(reader));
    seeds.retain(|seed| seed.bytes.len() <= most_bytes);
    assert!(!seeds.is_empty(), "{reader} has no seeds");
    seeds
}

/// Files that once broke a reader.
pub fn kept(reader: &str) -> Vec<Seed> {
    files("tests/data/kept", reader)
}

/// The files of a folder by name, without the folders in it; none where there is no such folder.
fn files(parent: &str, folder: &str) -> Vec<Seed> {
    let entries = std::fs::read_dir(root().join(parent).join(folder)).into_iter().flatten().filter_map(Result::ok);
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    paths.sort();
    let name = |path: &Path| format!("{folder}-{}", path.file_name().unwrap_or_default().display());
    paths.iter().map(|path| Seed::new(name(path), std::fs::read(path).expect("a seed"))).collect()
}

fn scenes() -> Vec<Seed> {
    let mut seeds: Vec<Seed> = ["tests/data", "scenes"].into_iter().flat_map(|folder| files(folder, "")).collect();
    seeds.extend(["hostile", "seeds/scene"].into_iter().flat_map(|folder| files("tests/data", folder)));
    seeds.push(Seed::new("everything.gltf", crate::support::everything().to_text().into_bytes()));
    seeds.iter_mut().for_each(|seed| seed.name = seed.name.replace('/', "-"));
    seeds
}

/// Pictures of this program, and of others: every compression, blocks, numbers of every width.
fn pictures() -> Vec<Seed> {
    let (width, height) = (6, 4);
    let ramp = |scale: f32| (0..24).map(|i| scale * i as f32).collect::<Vec<f32>>();
    let mut own = Picture::new(width, height);
    ["R", "G", "B", "A", "stderr.R", "stderr.G", "stderr.B", "depth.Z"].iter().zip(1u8..).for_each(|(name, scale)| {
        own.push(*name, ramp(0.125 * f32::from(scale)));
    });
    own.attributes = vec![
        ("mie_cloud.seed".into(), Attribute::Int(7)),
        ("mie_cloud.settings".into(), Attribute::Text("{}".into())),
        ("mie_cloud.window".into(), Attribute::IntBox([0, 0, 5, 3])),
    ];
    let mut seeds = vec![Seed::new("own.exr", exr::encode(&own).expect("encoded"))];
    let mut gray = Picture::new(8, 4);
    gray.push("Y", vec![0.5; 32]);
    seeds.push(Seed::new("gray.exr", exr::encode(&gray).expect("encoded")));
    let compressions = [
        ("raw", Compression::Uncompressed),
        ("rle", Compression::RLE),
        ("zip", Compression::ZIP1),
        ("piz", Compression::PIZ),
        ("pxr24", Compression::PXR24),
        ("b44", Compression::B44),
        ("b44a", Compression::B44A),
        ("dwaa", Compression::DWAA(None)),
        ("dwab", Compression::DWAB(None)),
    ];
    for (name, compression) in compressions {
        for (form, blocks) in [("lines", Blocks::ScanLines), ("tiles", Blocks::Tiles(Vec2(8, 8)))] {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            seeds.push(Seed::new(format!("{name}-{form}.exr"), foreign(encoding)));
        }
    }
    seeds
}

fn foreign(encoding: Encoding) -> Vec<u8> {
    let size = (18, 11);
    let values: Vec<f32> = (0..size.0 * size.1).map(|i| (i % 13) as f32 * 0.5).collect();
    let halves: Vec<f16> = values.iter().map(|value| f16::from_f32(*value)).collect();
    let channels = [
        AnyChannel::new("B", FlatSamples::F16(halves.clone())),
        AnyChannel::new("G", FlatSamples::F16(halves)),
        AnyChannel::new("R", FlatSamples::F32(values)),
        AnyChannel::new("id", FlatSamples::U32((0..(size.0 * size.1) as u32).collect())),
    ];
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = Layer::new(size, LayerAttributes::named("main"), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("written");
    bytes.into_inner()
}

/// Two pictures in one, as the reader of pairs divides them.
fn pairs() -> Vec<Seed> {
    let pictures = pictures();
    let (Some(own), Some(raw)) = (pictures.first(), pictures.iter().find(|seed| seed.name.starts_with("raw"))) else {
        return Vec::new();
    };
    let pair = |a: &Seed, b: &Seed| [&a.bytes[..], b"SPLIT", &b.bytes].concat();
    vec![
        Seed::new("alike.pair", pair(own, own)),
        Seed::new("unlike.pair", pair(own, raw)),
        Seed::new("raw.pair", pair(raw, raw)),
    ]
}

/// Parts and a checkpoint of a small render.
fn parts() -> Vec<Seed> {
    let bench = Bench::new();
    bench.ok(&format!("generate -o c.glb {}", CLOUD.join(" ")));
    bench.ok("render c.glb -o a.exr --samples 0..4 -q");
    bench.ok("render c.glb -o b.exr --samples 4..12 --spectral --aov all -q");
    bench.ok("render c.glb -o whole.exr --spp 4 --checkpoint c.kept -q");
    ["a.exr", "b.exr", "c.kept", "whole.exr"].iter().map(|name| Seed::new(*name, bench.read(name))).collect()
}

/// Contents of the table cache: five cross sections, then cells of s and a cubic.
fn tables() -> Vec<Seed> {
    let cross_sections = [2.0, 1.5, 0.5, 0.8, 1.0].map(f64::to_le_bytes).concat();
    let cell = |s: f64, cubic: [f32; 4]| [&s.to_le_bytes()[..], &cubic.map(f32::to_le_bytes).concat()].concat();
    let table =
        [cell(0.0, [0.0, -1.0, 0.5, -0.25]), cell(0.25, [-0.75, -2.0, 0.0, 0.0]), cell(0.75, [-2.75, 1.0, 0.0, 0.0])];
    vec![
        Seed::new("cells.table", [cross_sections.clone(), table.concat()].concat()),
        Seed::new("none.table", cross_sections),
    ]
}
