//! 8-bit PNG files: previews of pictures, maps of differences, contact sheets.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::file::{self, Existing, FileError};
use super::picture::{Attribute, Picture};
use super::preview::{Preview, PreviewError, develop};

/// A preview could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PngError {
    /// The picture has nothing to show.
    #[error("cannot write {path}: {source}")]
    Picture { path: PathBuf, source: PreviewError },
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Exposes and tone-maps a picture and writes it as 8-bit sRGB. Its attribute `software` becomes a text chunk.
///
/// # Errors
/// When R, G or B is missing, or the file cannot be written; the previous file is then as it was.
pub fn write_preview(path: &Path, picture: &Picture, existing: Existing) -> Result<(), PngError> {
    let preview = develop(picture).map_err(|source| PngError::Picture { path: path.into(), source })?;
    let software = match picture.attribute("software") {
        Some(Attribute::Text(text)) => Some(text.as_str()),
        _ => None,
    };
    Ok(file::write_atomically(path, existing, |writer| encode(writer, &preview, software))?)
}

/// Writes an 8-bit sRGB picture as it is; `software` becomes a text chunk.
///
/// # Errors
/// When the file cannot be written; the previous file is then as it was.
pub fn write(path: &Path, pixels: &Preview, software: &str, existing: Existing) -> Result<(), FileError> {
    file::write_atomically(path, existing, |writer| encode(writer, pixels, Some(software)))
}

/// Encodes a preview; equal previews give equal bytes.
fn encode(writer: &mut dyn Write, preview: &Preview, software: Option<&str>) -> io::Result<()> {
    let mut encoder = ::png::Encoder::new(writer, preview.width, preview.height);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    if let Some(software) = software {
        // "Software" is a keyword of the PNG specification, section 11.3.3.2.
        encoder.add_itxt_chunk("Software".into(), software.into())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&preview.rgb)?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preview_is_read_back_as_it_was_written() {
        let preview = Preview { width: 3, height: 2, rgb: (0..18).map(|step| step * 14).collect() };
        let mut bytes = Vec::new();
        encode(&mut bytes, &preview, Some("mie-cloud 1")).expect("memory takes it");
        let mut reader = ::png::Decoder::new(io::Cursor::new(&bytes)).read_info().expect("a PNG");
        let mut rgb = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut rgb).expect("one frame");
        assert_eq!(rgb, preview.rgb);
        let text = &reader.info().utf8_text[0];
        assert_eq!((text.keyword.as_str(), text.get_text().expect("plain").as_str()), ("Software", "mie-cloud 1"));
        let mut again = Vec::new();
        encode(&mut again, &preview, Some("mie-cloud 1")).expect("memory takes it");
        assert_eq!(again, bytes);
    }
}
