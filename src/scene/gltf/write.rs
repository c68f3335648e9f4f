//! Writes generated clouds as plain glTF 2.0: one GLB file, or one `.gltf` file that holds its buffer itself.

use std::io::{self, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use thiserror::Error;

use crate::scene::generate::Cloud;

mod buffer;
mod document;

/// A cloud could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The name ends in neither `.glb` nor `.gltf`.
    #[error("{name}: the file is glTF; give it a name that ends in `.glb` or `.gltf`")]
    Extension { name: String },
    /// Too much for a buffer inside JSON.
    #[error("{bytes} bytes of particles are too many for a `.gltf` file (limit {limit_bytes}): write a `.glb` file")]
    TooLargeForGltf { bytes: usize, limit_bytes: usize },
    /// GLB files count their bytes in 32 bits.
    #[error("{bytes} bytes are too many for a GLB file (limit {limit_bytes}): lower `--count`")]
    TooLargeForGlb { bytes: u64, limit_bytes: u32 },
    /// The output could not be written.
    #[error("the scene could not be written")]
    Io(#[from] io::Error),
    /// A number could not be expressed in JSON.
    #[error("the scene's description could not be written")]
    Json(#[from] serde_json::Error),
}

/// How glTF is packed into a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// Binary: JSON and buffer in one file.
    Glb,
    /// JSON, with the buffer inside as base64.
    Gltf,
}

/// A larger buffer makes text that editors and viewers choke on.
const GLTF_LIMIT_BYTES: usize = 64 << 20;

impl Container {
    /// The container of a file name, by its extension.
    ///
    /// # Errors
    /// When the name ends in neither `.glb` nor `.gltf`.
    pub fn from_name(name: &str) -> Result<Self, WriteError> {
        let lower = name.to_ascii_lowercase();
        match () {
            () if lower.ends_with(".glb") => Ok(Self::Glb),
            () if lower.ends_with(".gltf") => Ok(Self::Gltf),
            () => Err(WriteError::Extension { name: name.into() }),
        }
    }
}

/// Writes a cloud in the given container. The same cloud gives the same bytes.
///
/// # Errors
/// When the output fails, or the cloud is larger than the container can hold.
pub fn write(cloud: &Cloud, container: Container, out: &mut dyn Write) -> Result<(), WriteError> {
    match container {
        Container::Glb => write_glb(cloud, out),
        Container::Gltf => write_gltf(cloud, out),
    }
}

/// Writes a GLB file; particles are streamed from the cloud, without a second copy in memory.
///
/// # Errors
/// When the output fails, or the file would be larger than 4 GiB.
pub fn write_glb(cloud: &Cloud, out: &mut dyn Write) -> Result<(), WriteError> {
    const HEADER_BYTES: usize = 12;
    const CHUNK_HEADER_BYTES: usize = 8;
    let (document, buffer) = document::build(cloud);
    let mut json = serde_json::to_vec(&document)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let bytes = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json.len() + buffer.len_bytes();
    let to_u32 = |bytes: usize| {
        u32::try_from(bytes).map_err(|_| WriteError::TooLargeForGlb { bytes: bytes as u64, limit_bytes: u32::MAX })
    };
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&to_u32(bytes)?.to_le_bytes())?;
    out.write_all(&to_u32(json.len())?.to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    out.write_all(&to_u32(buffer.len_bytes())?.to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    buffer.write(out)?;
    out.flush()?;
    Ok(())
}

/// What stands before a buffer inside JSON.
const DATA_URI: &str = "data:application/octet-stream;base64,";

/// Writes a `.gltf` file: indented JSON with the buffer as a `data:` URI.
///
/// # Errors
/// When the output fails, or the buffer is larger than 64 MiB.
pub fn write_gltf(cloud: &Cloud, out: &mut dyn Write) -> Result<(), WriteError> {
    let (mut document, buffer) = document::build(cloud);
    let bytes = buffer.len_bytes();
    if bytes > GLTF_LIMIT_BYTES {
        return Err(WriteError::TooLargeForGltf { bytes, limit_bytes: GLTF_LIMIT_BYTES });
    }
    document["buffers"][0]["uri"] = DATA_URI.into();
    let json = serde_json::to_string_pretty(&document)?;
    // The quotes of a text inside a text are escaped: this is the key of the only buffer.
    let start = format!("\"uri\": \"{DATA_URI}");
    let (before, after) = json.split_once(&start).unwrap_or((&json, ""));
    write!(out, "{before}{start}")?;
    // The particles go through once, without a copy or their text in memory.
    let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
    buffer.write(&mut encoder)?;
    encoder.finish()?;
    drop(encoder);
    writeln!(out, "{after}")?;
    out.flush()?;
    Ok(())
}
