//! OpenEXR files: one part, scan lines, ZIP in blocks of 16, 32-bit floats; the same picture is always the same bytes.
//!
//! The header is written here, in the order of the names, because the `exr` crate keeps attributes in a hash map
//! whose order changes from run to run; the crate compresses the blocks and reads files.

mod decode;
mod encode;
mod foretold;
mod header;

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::file::{self, Existing, FileError};
use super::picture::{Picture, PictureError};

pub use decode::{Limits, decode, read};
pub use encode::encode;
pub use foretold::{Foretold, foretold};

/// A picture could not be written as OpenEXR.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The picture contradicts itself, or a value is not finite.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The format keeps this name for itself.
    #[error("the attribute `{0}` belongs to the file format; choose another name")]
    Reserved(String),
    /// A text or list is longer than the format can say.
    #[error("the attribute `{0}` is longer than 2 GiB")]
    Long(String),
    /// The compressor refused.
    #[error("the rows from {row} on cannot be compressed: {reason}")]
    Compression { row: u32, reason: String },
}

/// An OpenEXR file could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The picture cannot be encoded.
    #[error("cannot write {path}: {source}")]
    Encode { path: PathBuf, source: EncodeError },
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// An OpenEXR file could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}; check the path and its permissions")]
    Io { path: PathBuf, source: std::io::Error },
    /// The content is not a picture that can be used.
    #[error("cannot use {path}: {source}")]
    Content { path: PathBuf, source: DecodeError },
}

/// Bytes are not an OpenEXR picture that can be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DecodeError {
    /// The bytes contradict the format.
    #[error("not a sound OpenEXR file: {0}")]
    Damaged(String),
    /// The file is sound but uses something that is not read here.
    #[error("the file uses {0}, which is not read; save it as a flat scan-line picture with ZIP compression")]
    Unsupported(String),
    /// The file is longer than allowed.
    #[error("the file has more than {limit} bytes, the limit")]
    FileSize { limit: u64 },
    /// The pixels need more memory than allowed, or than a file of this length can hold.
    #[error("its header asks for {needed} bytes of pixels, but the limit for this file is {limit}")]
    Memory { needed: u64, limit: u64 },
    /// Some pixels are missing.
    #[error("{found} of {expected} blocks of pixels are there; the file is truncated")]
    Incomplete { found: usize, expected: usize },
}

/// Writes a picture to an OpenEXR file, whole or not at all.
///
/// # Errors
/// When the picture cannot be encoded, or the file cannot be written; the previous file is then as it was.
///
/// ```
/// use mie_cloud::image::{Existing, Picture, exr};
/// let folder = std::env::temp_dir().join("mie-cloud-doc");
/// std::fs::create_dir_all(&folder)?;
/// let mut picture = Picture::new(2, 1);
/// picture.push("Y", vec![0.5, 1.0]);
/// exr::write(&folder.join("gray.exr"), &picture, Existing::Replace)?;
/// assert_eq!(exr::read(&folder.join("gray.exr"), exr::Limits::default())?, picture);
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(path: &Path, picture: &Picture, existing: Existing) -> Result<(), WriteError> {
    let bytes = encode(picture).map_err(|source| WriteError::Encode { path: path.into(), source })?;
    Ok(file::write_atomically(path, existing, |writer| writer.write_all(&bytes))?)
}
