//! Encodes a picture: the header, a table of offsets, and blocks of 16 lines, compressed in parallel.

use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use ::exr::meta::header::Header;
use rayon::prelude::*;

use super::EncodeError;
use super::header::encode_header;
use crate::image::picture::{Channel, Picture};

/// Lines per block of ZIP compression (OpenEXR File Layout, "Scan line blocks").
const LINES_PER_BLOCK: usize = 16;

/// Encodes a picture as the bytes of an OpenEXR file. Equal pictures give equal bytes, with any number of threads.
///
/// # Errors
/// When the picture contradicts itself, holds a value that is not finite, or names an attribute that belongs to the
/// format.
pub fn encode(picture: &Picture) -> Result<Vec<u8>, EncodeError> {
    picture.validate()?;
    let mut channels: Vec<&Channel> = picture.channels.iter().collect();
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let header = encode_header(picture, &names)?;
    let layout = block_layout(picture, &names);
    let blocks = (0..picture.height as usize)
        .step_by(LINES_PER_BLOCK)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|row| compress_block(picture, &channels, &layout, row))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(assemble(header, &blocks, picture.frame.y))
}

/// What the compressor needs to know of the channels; attributes are not written from it.
fn block_layout(picture: &Picture, names: &[&str]) -> Header {
    let describe =
        |name: &&str| ChannelDescription::new(Text::from_slice_unchecked(name.as_bytes()), SampleType::F32, true);
    let size = Vec2(picture.width as usize, picture.height as usize);
    Header::new(Text::default(), size, names.iter().map(describe).collect()).with_encoding(
        Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    )
}

/// Compresses the block that begins at `row`: in each line, the channels one after another.
fn compress_block(
    picture: &Picture,
    channels: &[&Channel],
    layout: &Header,
    row: usize,
) -> Result<Vec<u8>, EncodeError> {
    let width = picture.width as usize;
    let n_lines = LINES_PER_BLOCK.min(picture.height as usize - row);
    let mut bytes = Vec::with_capacity(n_lines * width * channels.len() * size_of::<f32>());
    for line in row..row + n_lines {
        for channel in channels {
            let values = &channel.values[line * width..(line + 1) * width];
            bytes.extend(values.iter().flat_map(|value| value.to_ne_bytes()));
        }
    }
    let section = IntegerBounds::new(Vec2(0, row as i32), Vec2(width, n_lines));
    Compression::ZIP16
        .compress_image_section_to_le(layout, bytes, section)
        .map_err(|error| EncodeError::Compression { row: row as u32, reason: error.to_string() })
}

/// Joins the header, the offset of each block from the file's start, and the blocks with their row and length.
fn assemble(header: Vec<u8>, blocks: &[Vec<u8>], first_row: i32) -> Vec<u8> {
    const BLOCK_HEADER_BYTES: usize = 8;
    let mut offset = header.len() + blocks.len() * size_of::<u64>();
    let total = offset + blocks.iter().map(|block| block.len() + BLOCK_HEADER_BYTES).sum::<usize>();
    let mut out = header;
    out.reserve_exact(total - out.len());
    for block in blocks {
        out.extend((offset as u64).to_le_bytes());
        offset += block.len() + BLOCK_HEADER_BYTES;
    }
    for (index, block) in blocks.iter().enumerate() {
        out.extend((first_row + (index * LINES_PER_BLOCK) as i32).to_le_bytes());
        out.extend((block.len() as i32).to_le_bytes());
        out.extend(block);
    }
    out
}
