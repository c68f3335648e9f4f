//! How much memory a picture will take, from its header alone: nothing that grows with its pixels is read.

use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ::exr::math::Vec2;
use ::exr::meta::MetaData;

/// Headers are some kilobytes; what is longer is not looked through.
const LONGEST_HEADER: u64 = 1 << 20;

/// What a file says of its first part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Foretold {
    /// Pixels of the data window.
    pub pixels: u64,
    /// Bytes while it is read: the file, and every channel as 32-bit floats.
    pub bytes: u64,
}

/// Looks at a header; `None` where there is none that can be understood, which [`super::read`] will say better.
///
/// ```
/// use mie_cloud::image::exr::foretold;
/// assert_eq!(foretold(std::path::Path::new("missing.exr")), None);
/// ```
pub fn foretold(path: &Path) -> Option<Foretold> {
    let file = File::open(path).ok()?;
    let metadata = file.metadata().ok().filter(|metadata| metadata.is_file())?;
    let reader = BufReader::new(file.take(LONGEST_HEADER));
    let read = || MetaData::read_from_buffered(reader, false);
    let found = catch_unwind(AssertUnwindSafe(read)).ok()?.ok()?;
    let header = found.headers.first()?;
    let Vec2(width, height) = header.layer_size;
    let pixels = (width as u64).checked_mul(height as u64)?;
    let channels = pixels.checked_mul(4 * header.channels.list.len() as u64)?;
    Some(Foretold { pixels, bytes: channels.checked_add(metadata.len())? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::exr;
    use crate::image::file::Existing;
    use crate::image::picture::Picture;

    #[test]
    fn the_header_tells_what_the_pixels_take() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("a.exr");
        let mut picture = Picture::new(300, 200);
        for name in ["R", "G", "B"] {
            picture.push(name, vec![0.5; 60_000]);
        }
        exr::write(&path, &picture, Existing::Replace)?;
        let length = path.metadata()?.len();
        assert_eq!(foretold(&path), Some(Foretold { pixels: 60_000, bytes: 720_000 + length }));
        std::fs::write(&path, b"no picture")?;
        assert_eq!(foretold(&path), None);
        Ok(())
    }
}
