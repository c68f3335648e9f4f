//! OpenEXR pictures: backgrounds, references, pictures to compare.

use std::path::Path;

use glam::DVec3;
use mie_cloud::image::Picture;
use mie_cloud::image::compare::{compare, difference_map};
use mie_cloud::image::exr::{Limits, decode, read};
use mie_cloud::transport::LatLong;

use super::check_message;

/// Small, so that a fuzzer meets the limit as well.
const LIMITS: Limits = Limits { file_bytes: 1 << 20, pixel_bytes: 8 << 20 };

/// An `.exr` file, as a background and as one of two pictures.
pub fn exr(bytes: &[u8], _folder: &Path) {
    let picture = match decode(bytes, LIMITS) {
        Ok(picture) => picture,
        Err(error) => return check_message(&error.to_string(), ""),
    };
    check_picture(&picture);
    if let Err(error) = compare(&picture, &picture) {
        check_message(&error.to_string(), "");
    }
    if let Err(error) = difference_map(&picture, &picture) {
        check_message(&error.to_string(), "");
    }
    let name = Path::new("sky.exr");
    match LatLong::of(&picture, name) {
        Ok((sky, _)) => {
            for direction in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.48, -0.64)] {
                assert!(sky.look(direction).iter().all(|value| value.is_finite() && *value >= 0.0));
            }
        }
        Err(error) => check_message(&error.to_string(), "sky.exr"),
    }
}

fn check_picture(picture: &Picture) {
    let n_pixels = picture.width as usize * picture.height as usize;
    assert!(n_pixels > 0);
    let bytes: usize = picture.channels.iter().map(|channel| size_of_val(&channel.values[..])).sum();
    assert!(bytes as u64 <= LIMITS.pixel_bytes, "{bytes} bytes of pixels");
    assert!(picture.channels.iter().all(|channel| channel.values.len() == n_pixels));
}

/// Two `.exr` files, the second beginning after the word SPLIT, as `mie-cloud diff` reads them.
pub fn diff(bytes: &[u8], folder: &Path) {
    let at = bytes.windows(5).position(|word| word == b"SPLIT");
    let (a, b) = at.map_or((bytes, bytes), |at| (&bytes[..at], &bytes[at + 5..]));
    let (Ok(a), Ok(b)) = (decode(a, LIMITS), decode(b, LIMITS)) else {
        let file = folder.join("a.exr");
        std::fs::write(&file, a).expect("written");
        if let Err(error) = read(&file, LIMITS) {
            check_message(&error.to_string(), "a.exr");
        }
        return;
    };
    match compare(&a, &b) {
        Ok(comparison) => assert!(comparison.rmse >= 0.0 || comparison.n_non_finite > 0, "{comparison:?}"),
        Err(error) => check_message(&error.to_string(), ""),
    }
}
