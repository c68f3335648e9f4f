//! Pictures through OpenEXR: every bit comes back, the same picture is the same bytes, and damage is an error.

use std::fs;
use std::io;
use std::path::Path;

use mie_cloud::image::exr::{DecodeError, EncodeError, Limits, ReadError, WriteError, decode, encode, read, write};
use mie_cloud::image::{Attribute, Chromaticities, Existing, Frame, Picture, PictureError};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Random bits that are finite floats: every exponent and sign, denormals too.
fn random_values(n: usize, seed: u64) -> Vec<f32> {
    let mut rng = Pcg64::seed_from_u64(seed);
    std::iter::repeat_with(|| f32::from_bits(rng.random())).filter(|value| value.is_finite()).take(n).collect()
}

fn random_picture(width: u32, height: u32, names: &[&str]) -> Picture {
    let mut picture = Picture::new(width, height);
    for (index, name) in names.iter().enumerate() {
        picture.push(*name, random_values((width * height) as usize, index as u64));
    }
    picture
}

/// One of every attribute, in the order of names, as the reader returns them.
fn all_attributes() -> Vec<(String, Attribute)> {
    [
        ("comments", Attribute::Text("first\nsecond: µ".into())),
        ("double", Attribute::Double(0.1)),
        ("empty", Attribute::Text(String::new())),
        ("float", Attribute::Float(-1.5e-42)),
        ("int", Attribute::Int(i32::MIN)),
        ("mie_cloud.a_name_that_is_longer_than_31_bytes", Attribute::Text("long".into())),
        ("mie_cloud.seed", Attribute::Text("18446744073709551615".into())),
        ("software", Attribute::Text("mie-cloud 0.1.0".into())),
        ("texts", Attribute::Texts(vec!["one".into(), String::new(), "three".into()])),
        ("v2f", Attribute::FloatPair([1.0, -2.0])),
        ("v2i", Attribute::IntPair([3, -4])),
        ("v3f", Attribute::FloatTriple([1.0, 2.0, 3.0])),
        ("window", Attribute::IntBox([-1, -2, 3, 4])),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec()
}

/// Channels in the order of the format: sorted by bytes.
fn sorted(mut picture: Picture) -> Picture {
    picture.channels.sort_by(|a, b| a.name.cmp(&b.name));
    picture
}

fn bits(picture: &Picture) -> Vec<(&str, Vec<u32>)> {
    let bits_of = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
    picture.channels.iter().map(|channel| (channel.name.as_str(), bits_of(&channel.values))).collect()
}

#[test]
fn every_bit_of_every_channel_comes_back_at_any_size() {
    // Blocks have 16 lines: one less, exactly, one more, two and a bit.
    for (width, height) in [(1, 1), (17, 3), (3, 15), (5, 16), (4, 17), (31, 32), (2, 33), (1000, 1), (1, 100)] {
        let names = ["R", "G", "B", "A", "direct.R", "depth.Z", "stderr.R", "S0.550,000000nm"];
        let picture = sorted(random_picture(width, height, &names));
        let back = decode(&encode(&picture).unwrap(), Limits::default()).unwrap();
        assert_eq!(bits(&back), bits(&picture), "{width} x {height}");
        assert_eq!(back, picture);
    }
}

#[test]
fn extreme_values_come_back() {
    let values = vec![0.0, -0.0, 1e38, f32::MAX, f32::MIN, 1e-38, 1e-42, f32::from_bits(1), f32::MIN_POSITIVE];
    let mut picture = Picture::new(9, 1);
    picture.push("Y", values);
    let back = decode(&encode(&picture).unwrap(), Limits::default()).unwrap();
    assert_eq!(bits(&back), bits(&picture));
}

#[test]
fn smooth_pictures_are_compressed() {
    let mut picture = Picture::new(256, 256);
    picture.push("Y", (0..65536).map(|index| (index / 256) as f32).collect());
    let bytes = encode(&picture).unwrap();
    assert!(bytes.len() < 65536 * 4 / 20, "{} bytes", bytes.len());
    assert_eq!(decode(&bytes, Limits::default()).unwrap(), picture);
}

#[test]
fn attributes_colours_and_windows_come_back() {
    let mut picture = random_picture(5, 4, &["Y"]);
    picture.attributes = all_attributes();
    picture.white_luminance_cd_m2 = Some(42436.5);
    for frame in [
        Frame { x: 10, y: 20, full_width: 640, full_height: 360 },
        Frame { x: 635, y: 356, full_width: 640, full_height: 360 },
        Frame { x: -3, y: -2, full_width: 2, full_height: 3 },
    ] {
        picture.frame = frame;
        assert_eq!(decode(&encode(&picture).unwrap(), Limits::default()).unwrap(), picture);
    }
    picture.chromaticities = Some(Chromaticities { white: [0.3, 0.3], ..Chromaticities::BT709 });
    assert_eq!(decode(&encode(&picture).unwrap(), Limits::default()).unwrap(), picture);
    picture.chromaticities = None;
    assert_eq!(decode(&encode(&picture).unwrap(), Limits::default()).unwrap(), picture);
}

fn picture_with_everything() -> Picture {
    let mut picture = random_picture(33, 47, &["R", "G", "B", "A", "multiple.G"]);
    picture.attributes = all_attributes();
    picture.white_luminance_cd_m2 = Some(1.0);
    picture
}

#[test]
fn the_same_picture_is_the_same_bytes_with_any_number_of_threads() {
    let picture = picture_with_everything();
    let first = encode(&picture).unwrap();
    for n_threads in (1..=20).map(|run| 1 + run % 4) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        assert!(pool.install(|| encode(&picture)).unwrap() == first, "{n_threads} threads");
    }
    // Neither the order of the channels nor that of the attributes is part of the picture.
    let mut shuffled = picture;
    shuffled.channels.reverse();
    shuffled.attributes.reverse();
    assert!(encode(&shuffled).unwrap() == first);
}

/// Writes the picture where a parent test asks for it; without one there is nothing to do.
#[test]
fn write_a_picture_for_the_parent_process() {
    if let Some(path) = std::env::var_os("MIE_CLOUD_TEST_PICTURE") {
        write(Path::new(&path), &picture_with_everything(), Existing::Replace).unwrap();
    }
}

#[test]
fn separate_processes_write_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let written: Vec<Vec<u8>> = (0..5)
        .map(|run| {
            let path = folder.path().join(format!("{run}.exr"));
            let status = std::process::Command::new(std::env::current_exe().unwrap())
                .args(["--exact", "write_a_picture_for_the_parent_process", "--quiet"])
                .env("MIE_CLOUD_TEST_PICTURE", &path)
                .stdout(std::process::Stdio::null())
                .status()
                .unwrap();
            assert!(status.success());
            fs::read(path).unwrap()
        })
        .collect();
    assert!(written[0] == encode(&picture_with_everything()).unwrap());
    assert!(written.iter().all(|bytes| *bytes == written[0]));
}

#[test]
fn a_value_that_is_not_finite_is_refused_with_channel_and_pixel() {
    let mut picture = random_picture(4, 4, &["R", "G"]);
    picture.channels[1].values[6] = f32::NAN;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let error = write(&path, &picture, Existing::Replace).unwrap_err();
    assert!(matches!(
        &error,
        WriteError::Encode { source: EncodeError::Picture(PictureError::NonFinite { channel, x: 2, y: 1, .. }), .. }
            if channel == "G"
    ));
    assert!(error.to_string().contains("channel `G` is NaN at pixel (2, 1)"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

// Damaged files.

#[test]
fn a_truncated_file_is_an_error_at_every_length() {
    let mut picture = random_picture(7, 40, &["R", "G", "B"]);
    picture.attributes = all_attributes();
    let bytes = encode(&picture).unwrap();
    for length in (0..bytes.len()).step_by(7).chain([bytes.len() - 1]) {
        assert!(decode(&bytes[..length], Limits::default()).is_err(), "{length} of {} bytes", bytes.len());
    }
}

#[test]
fn mutated_files_never_panic_and_never_ask_for_much_memory() {
    let mut picture = Picture::new(19, 35);
    picture.push("R", (0..19 * 35).map(|index| index as f32 * 0.25).collect());
    picture.push("G", random_values(19 * 35, 3));
    picture.attributes = all_attributes();
    let sound = encode(&picture).unwrap();
    let header_end = sound.len() - 19 * 35 * 4;
    let mut rng = Pcg64::seed_from_u64(20);
    let (mut refused, mut accepted) = (0, 0);
    for round in 0..6000 {
        let mut bytes = sound.clone();
        for _ in 0..rng.random_range(1..4) {
            // Half of the mutations hit the header, where sizes and types are.
            let end = if round % 2 == 0 { header_end } else { bytes.len() };
            let at = rng.random_range(0..end);
            bytes[at] = match rng.random_range(0..4) {
                0 => rng.random(),
                1 => bytes[at] ^ (1 << rng.random_range(0..8)),
                2 => 0xff,
                _ => 0,
            };
        }
        match decode(&bytes, Limits { file_bytes: 1 << 20, pixel_bytes: 16 << 20 }) {
            Ok(picture) => {
                assert!(picture.channels.iter().all(|channel| channel.values.len() as u64 == picture.n_pixels()));
                accepted += 1;
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 1000 && accepted > 100, "{refused} refused, {accepted} accepted");
}

#[test]
fn a_header_that_asks_for_more_than_the_file_can_hold_is_refused() {
    let sound = encode(&random_picture(8, 8, &["Y"])).unwrap();
    let at = sound.windows(16).position(|bytes| bytes == b"dataWindow\0box2i").unwrap() + 21;
    let mut wide = sound.clone();
    wide[at + 8..at + 12].copy_from_slice(&100_000_000_i32.to_le_bytes());
    assert!(matches!(decode(&wide, Limits::default()), Err(DecodeError::Memory { needed: 3_200_000_032, .. })));
    let mut tall = sound.clone();
    tall[at + 12..at + 16].copy_from_slice(&100_000_000_i32.to_le_bytes());
    assert!(matches!(decode(&tall, Limits::default()), Err(DecodeError::Incomplete { .. })));
    let small = Limits { pixel_bytes: 255, ..Limits::default() };
    assert_eq!(decode(&sound, small), Err(DecodeError::Memory { needed: 256, limit: 255 }));
    let short = Limits { file_bytes: 100, ..Limits::default() };
    assert_eq!(decode(&sound, short), Err(DecodeError::FileSize { limit: 100 }));
}

#[test]
fn a_file_that_is_missing_or_no_picture_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    assert!(matches!(read(&path, Limits::default()), Err(ReadError::Io { .. })));
    fs::write(&path, "not a picture").unwrap();
    let error = read(&path, Limits::default()).unwrap_err();
    assert!(matches!(&error, ReadError::Content { source: DecodeError::Damaged(_), .. }));
    assert!(error.to_string().contains("a.exr"), "{error}");
}

// Files of other programs.

mod foreign {
    use super::*;
    use ::exr::prelude::*;

    fn encoded(channels: Vec<AnyChannel<FlatSamples>>, size: (usize, usize), encoding: Encoding) -> Vec<u8> {
        let layer = Layer::new(size, LayerAttributes::named("main"), encoding, AnyChannels::sort(channels.into()));
        let mut bytes = io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn half_float_and_whole_numbers_in_every_compression_and_in_tiles_are_read() {
        let (width, height) = (70, 37);
        let values: Vec<f32> = (0..width * height).map(|index| (index % 97) as f32 * 0.5).collect();
        let halves = values.iter().map(|value| f16::from_f32(*value)).collect();
        let whole = (0..(width * height) as u32).collect();
        let channels = vec![
            AnyChannel::new("F", FlatSamples::F32(values.clone())),
            AnyChannel::new("H", FlatSamples::F16(halves)),
            AnyChannel::new("U", FlatSamples::U32(whole)),
        ];
        let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))];
        for compression in
            [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
        {
            for blocks in blocks {
                let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
                let bytes = encoded(channels.clone(), (width, height), encoding);
                let picture = decode(&bytes, Limits::default()).unwrap();
                assert_eq!((picture.width, picture.height), (70, 37));
                assert_eq!(picture.channel("F").unwrap(), values, "{compression:?}");
                assert_eq!(picture.channel("H").unwrap(), values, "{compression:?}");
                assert!(picture.channel("U").unwrap().iter().zip(0..).all(|(value, index)| *value == index as f32));
            }
        }
    }

    #[test]
    fn mutations_of_every_compression_never_panic() {
        let (width, height) = (40, 34);
        let halves = (0..width * height).map(|index| f16::from_f32((index % 61) as f32)).collect();
        let floats = (0..width * height).map(|index| (index % 13) as f32).collect();
        let channels =
            vec![AnyChannel::new("F", FlatSamples::F32(floats)), AnyChannel::new("H", FlatSamples::F16(halves))];
        let mut rng = Pcg64::seed_from_u64(21);
        for compression in [
            Compression::Uncompressed,
            Compression::RLE,
            Compression::ZIP1,
            Compression::PIZ,
            Compression::PXR24,
            Compression::B44,
            Compression::B44A,
            Compression::DWAA(None),
        ] {
            for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))] {
                let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
                let sound = encoded(channels.clone(), (width, height), encoding);
                assert_eq!(decode(&sound, Limits::default()).err(), None, "{compression:?} {blocks:?}");
                for _ in 0..250 {
                    let mut bytes = sound.clone();
                    for _ in 0..rng.random_range(1..5) {
                        let at = rng.random_range(0..bytes.len());
                        bytes[at] = rng.random();
                    }
                    let limits = Limits { file_bytes: 1 << 20, pixel_bytes: 16 << 20 };
                    let _ = decode(&bytes, limits);
                }
            }
        }
    }
}
