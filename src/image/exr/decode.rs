//! Reads OpenEXR files that others wrote: every allocation is bounded before it is made, damage is an error.

use std::collections::HashSet;
use std::fs::File;
use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::block::lines::LineRef;
use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::compression::Compression;
use ::exr::error::Error as CrateError;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::f16;

use super::header::{MAGIC, STRUCTURAL};
use super::{DecodeError, ReadError};
use crate::excerpt::printable;
use crate::image::picture::{Attribute, Channel, Chromaticities, Frame, Picture};

/// What a file may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest file, bytes.
    pub file_bytes: u64,
    /// Most memory for all channels together, bytes.
    pub pixel_bytes: u64,
}

impl Default for Limits {
    /// 2 GiB each: a lat-long picture of 16384 x 8192 in R, G, B takes 1.5 GiB.
    fn default() -> Self {
        Self { file_bytes: 2 << 30, pixel_bytes: 2 << 30 }
    }
}

/// Reads the first part of an OpenEXR file: scan lines or tiles, half, float or whole numbers, as 32-bit floats.
/// Only the largest level of a pyramid is read. Attributes of types that [`Attribute`] lacks are left out.
///
/// # Errors
/// When the file cannot be read, is damaged or truncated, exceeds `limits`, or holds deep or subsampled pixels.
pub fn read(path: &Path, limits: Limits) -> Result<Picture, ReadError> {
    let io = |source| ReadError::Io { path: path.into(), source };
    let content = |source| ReadError::Content { path: path.into(), source };
    let mut file = File::open(path).map_err(io)?.take(limits.file_bytes.saturating_add(1));
    let mut bytes = Vec::new();
    // A long file of another kind is not read to its end.
    file.by_ref().take(MAGIC.len() as u64).read_to_end(&mut bytes).map_err(io)?;
    if bytes != MAGIC {
        return Err(content(DecodeError::Damaged("it does not begin like one".into())));
    }
    file.read_to_end(&mut bytes).map_err(io)?;
    decode(&bytes, limits).map_err(content)
}

/// Decodes the bytes of an OpenEXR file; see [`read`].
///
/// # Errors
/// When the bytes are damaged or truncated, exceed `limits`, or hold deep or subsampled pixels.
pub fn decode(bytes: &[u8], limits: Limits) -> Result<Picture, DecodeError> {
    if bytes.len() as u64 > limits.file_bytes {
        return Err(DecodeError::FileSize { limit: limits.file_bytes });
    }
    // The crate returns errors for damage, but where overflow is checked its B44 decompressor panics on it.
    catch_unwind(AssertUnwindSafe(|| decode_guarded(bytes, limits)))
        .unwrap_or_else(|_| Err(DecodeError::Damaged("its blocks contradict its header".into())))
}

fn decode_guarded(bytes: &[u8], limits: Limits) -> Result<Picture, DecodeError> {
    let reader = Reader::read_from_buffered(Cursor::new(bytes), true).map_err(from_crate)?;
    let header = reader.headers().first().ok_or_else(|| DecodeError::Damaged("it has no header".into()))?.clone();
    for other in reader.headers() {
        check_number_of_blocks(other, bytes.len() as u64)?;
    }
    check_pixels(&header, bytes.len() as u64, limits)?;
    for other in reader.headers() {
        check_size_of_blocks(other, bytes.len() as u64, limits)?;
    }
    let channels = read_channels(reader, &header)?;
    describe(&header, channels)
}

/// Every block has an 8-byte offset and at least 9 bytes of its own, so a file's length bounds their number.
fn check_number_of_blocks(header: &Header, file_bytes: u64) -> Result<(), DecodeError> {
    const LEAST_BYTES_PER_BLOCK: u64 = 17;
    let most = (file_bytes / LEAST_BYTES_PER_BLOCK) as usize;
    if header.chunk_count > most {
        return Err(DecodeError::Incomplete { found: most, expected: header.chunk_count });
    }
    Ok(())
}

/// The crate takes as much memory for a block as that claims to have, up to what the header says a whole one has. Tiles may be larger than
/// a small picture, but not without bound.
fn check_size_of_blocks(header: &Header, file_bytes: u64, limits: Limits) -> Result<(), DecodeError> {
    const LARGEST_TILE_BYTES: u64 = 16 << 20;
    let Vec2(width, height) = header.max_block_pixel_size();
    let needed = width as u128 * height as u128 * header.channels.bytes_per_pixel as u128;
    let limit = most_pixel_bytes(header.compression, file_bytes).min(limits.pixel_bytes).max(LARGEST_TILE_BYTES);
    if needed > u128::from(limit) {
        return Err(DecodeError::Memory { needed: u64::try_from(needed).unwrap_or(u64::MAX), limit });
    }
    Ok(())
}

/// Checks that the pixels are flat, of full resolution, and no more than the file can hold and the caller allows.
fn check_pixels(header: &Header, file_bytes: u64, limits: Limits) -> Result<(), DecodeError> {
    if header.deep {
        return Err(DecodeError::Unsupported("deep pixels".into()));
    }
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(DecodeError::Unsupported("subsampled channels".into()));
    }
    let Vec2(width, height) = header.layer_size;
    if width == 0 || height == 0 {
        return Err(DecodeError::Damaged("its data window is empty".into()));
    }
    let samples = width as u128 * height as u128 * header.channels.list.len() as u128;
    let needed = u64::try_from(samples * size_of::<f32>() as u128).unwrap_or(u64::MAX);
    let limit = limits.pixel_bytes.min(most_pixel_bytes(header.compression, file_bytes));
    if needed > limit {
        return Err(DecodeError::Memory { needed, limit });
    }
    Ok(())
}

/// The most bytes of 32-bit samples that a file of this length can decompress to. Deflate reaches 1032 to 1 (zlib,
/// "Maximum Compression Factor"), every other method but DWA less; half samples double when widened. DWA chains two
/// methods and has no useful bound.
fn most_pixel_bytes(compression: Compression, file_bytes: u64) -> u64 {
    match compression {
        Compression::Uncompressed => file_bytes.saturating_mul(2),
        Compression::DWAA(_) | Compression::DWAB(_) => u64::MAX,
        _ => file_bytes.saturating_mul(2 * 1032),
    }
}

fn read_channels(reader: Reader<Cursor<&[u8]>>, header: &Header) -> Result<Vec<Channel>, DecodeError> {
    let Vec2(width, height) = header.layer_size;
    let mut channels: Vec<Channel> = header
        .channels
        .list
        .iter()
        .map(|channel| Channel { name: text(channel.name.as_slice()), values: vec![0.0; width * height] })
        .collect();
    let chunks =
        reader.filter_chunks(true, |_, _, block| block.layer == 0 && block.level == Vec2(0, 0)).map_err(from_crate)?;
    let (meta_data, expected) = (chunks.meta_data().clone(), chunks.expected_chunk_count());
    let mut seen = HashSet::new();
    for chunk in chunks {
        let chunk = chunk.map_err(from_crate)?;
        check_chunk(&chunk, header)?;
        let block = UncompressedBlock::decompress_chunk(chunk, &meta_data, true).map_err(from_crate)?;
        if block.index.layer == 0 && block.index.level == Vec2(0, 0) {
            store_block(&block, header, &mut channels).map_err(from_crate)?;
            seen.insert((block.index.pixel_position.0, block.index.pixel_position.1));
        }
    }
    if seen.len() != expected {
        return Err(DecodeError::Incomplete { found: seen.len(), expected });
    }
    Ok(channels)
}

/// DWA blocks begin with eleven counters: version, nine sizes and a method (`internal_dwa_compressor.h`). The crate
/// allocates what they say, so that sizes beyond what the block can need are refused first.
fn check_chunk(chunk: &Chunk, header: &Header) -> Result<(), DecodeError> {
    const SIZES: std::ops::Range<usize> = 1..10;
    /// Every section holds a sample at most once; run lengths add 1 in 128, tables and rounding to 8 x 8 the rest.
    const MOST_BYTES_PER_BYTE: usize = 8;
    const SMALL_BLOCK_BYTES: usize = 1 << 16;
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Err(DecodeError::Unsupported("deep pixels".into())),
    };
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let place = header.get_block_data_indices(&chunk.compressed_block).map_err(from_crate)?;
    let section = header.get_absolute_block_pixel_coordinates(place).map_err(from_crate)?;
    let raw_bytes = section.size.area().saturating_mul(header.channels.bytes_per_pixel);
    if bytes.len() == raw_bytes {
        return Ok(()); // stored as it is
    }
    let limit = raw_bytes.saturating_mul(MOST_BYTES_PER_BYTE).saturating_add(SMALL_BLOCK_BYTES) as u64;
    let counters = bytes.chunks_exact(size_of::<u64>()).take(SIZES.end).skip(SIZES.start);
    for counter in counters.map(|bytes| bytes.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))) {
        if counter > limit {
            return Err(DecodeError::Memory { needed: counter, limit });
        }
    }
    Ok(())
}

fn store_block(block: &UncompressedBlock, header: &Header, channels: &mut [Channel]) -> Result<(), CrateError> {
    let width = header.layer_size.width();
    for line in block.lines(&header.channels) {
        let index = line.location.channel;
        let start = line.location.position.y() * width + line.location.position.x();
        let target = channels[index].values.get_mut(start..start + line.location.sample_count);
        let target = target.ok_or(CrateError::Invalid("block outside of the picture".into()))?;
        store_line(line, header.channels.list[index].sample_type, target)?;
    }
    Ok(())
}

/// Widens one line to 32-bit floats; whole numbers above 2^24 lose their last bits.
fn store_line(line: LineRef<'_>, sample_type: SampleType, target: &mut [f32]) -> Result<(), CrateError> {
    match sample_type {
        SampleType::F32 => line.read_samples_into_slice(target)?,
        SampleType::F16 => {
            for (target, sample) in target.iter_mut().zip(line.read_samples::<f16>()) {
                *target = sample?.to_f32();
            }
        }
        SampleType::U32 => {
            for (target, sample) in target.iter_mut().zip(line.read_samples::<u32>()) {
                *target = sample? as f32;
            }
        }
    }
    Ok(())
}

/// Builds the picture from its header and channels.
fn describe(header: &Header, channels: Vec<Channel>) -> Result<Picture, DecodeError> {
    let display = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    let side =
        |pixels: usize| u32::try_from(pixels).map_err(|_| DecodeError::Damaged("its window is too large".into()));
    let mut attributes: Vec<(String, Attribute)> = header
        .all_named_attributes()
        .map(|(name, value)| (text(name), value))
        .filter(|(name, _)| !STRUCTURAL.contains(&name.as_str()))
        .filter_map(|(name, value)| Some((name, attribute(value)?)))
        .collect();
    attributes.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(Picture {
        width: side(header.layer_size.width())?,
        height: side(header.layer_size.height())?,
        channels,
        attributes,
        chromaticities: header.shared_attributes.chromaticities.map(|colours| Chromaticities {
            red: pair(colours.red),
            green: pair(colours.green),
            blue: pair(colours.blue),
            white: pair(colours.white),
        }),
        white_luminance_cd_m2: header.own_attributes.white_luminance,
        frame: Frame {
            x: position.x().saturating_sub(display.position.x()),
            y: position.y().saturating_sub(display.position.y()),
            full_width: side(display.size.width())?,
            full_height: side(display.size.height())?,
        },
    })
}

fn attribute(value: AttributeValue) -> Option<Attribute> {
    Some(match value {
        AttributeValue::Text(value) => Attribute::Text(text(value.as_slice())),
        AttributeValue::TextVector(values) => {
            Attribute::Texts(values.iter().map(|value| text(value.as_slice())).collect())
        }
        AttributeValue::I32(value) => Attribute::Int(value),
        AttributeValue::F32(value) => Attribute::Float(value),
        AttributeValue::F64(value) => Attribute::Double(value),
        AttributeValue::IntVec2(Vec2(x, y)) => Attribute::IntPair([x, y]),
        AttributeValue::FloatVec2(value) => Attribute::FloatPair(pair(value)),
        AttributeValue::FloatVec3((x, y, z)) => Attribute::FloatTriple([x, y, z]),
        AttributeValue::IntegerBounds(bounds) => {
            let last = |start: i32, side: usize| (i64::from(start) + side as i64 - 1) as i32;
            let Vec2(x, y) = bounds.position;
            Attribute::IntBox([x, y, last(x, bounds.size.width()), last(y, bounds.size.height())])
        }
        _ => return None,
    })
}

fn pair(Vec2(x, y): Vec2<f32>) -> [f32; 2] {
    [x, y]
}

/// Texts of the format are bytes; most are ASCII or UTF-8.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// What the crate says may hold names from the file.
fn from_crate(error: CrateError) -> DecodeError {
    match error {
        CrateError::NotSupported(what) => DecodeError::Unsupported(printable(&what)),
        CrateError::Invalid(what) => DecodeError::Damaged(printable(&what)),
        CrateError::Io(error) => DecodeError::Damaged(printable(&error.to_string())),
        CrateError::Aborted => DecodeError::Damaged("reading was given up".into()),
    }
}
