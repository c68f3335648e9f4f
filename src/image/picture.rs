//! A picture as plain data: channels of 32-bit floats, where they lie in the full frame, and what is recorded with them.

use std::collections::BTreeSet;

use thiserror::Error;

/// Longest name of a channel or attribute, in bytes (OpenEXR file layout, "long names").
pub const LONGEST_NAME_BYTES: usize = 255;

/// A picture.
///
/// Rows go from top to bottom, pixels from left to right; pixel (x, y) of a channel is `values[y * width + x]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// The channels in any order: `R`, `G`, `B`, `A`, and layers as `direct.R`.
    pub channels: Vec<Channel>,
    /// What is recorded with the picture, by name; names are unique.
    pub attributes: Vec<(String, Attribute)>,
    /// Primaries and white point of R, G, B; `None` where unknown.
    pub chromaticities: Option<Chromaticities>,
    /// Luminance of R = G = B = 1, cd/m^2; `None` where unknown.
    pub white_luminance_cd_m2: Option<f32>,
    /// Where the pixels lie in the full frame.
    pub frame: Frame,
}

/// One channel of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name, `R` or `layer.R`; unique in its picture.
    pub name: String,
    /// One value per pixel, row by row.
    pub values: Vec<f32>,
}

/// A value recorded with a picture.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Attribute {
    /// Text, UTF-8.
    Text(String),
    /// A list of texts.
    Texts(Vec<String>),
    /// A whole number.
    Int(i32),
    /// A single-precision number.
    Float(f32),
    /// A double-precision number.
    Double(f64),
    /// Two whole numbers.
    IntPair([i32; 2]),
    /// Two single-precision numbers.
    FloatPair([f32; 2]),
    /// Three single-precision numbers.
    FloatTriple([f32; 3]),
    /// A rectangle: least x and y, greatest x and y, both inside.
    IntBox([i32; 4]),
}

/// CIE 1931 xy of the primaries and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticities {
    /// Red primary.
    pub red: [f32; 2],
    /// Green primary.
    pub green: [f32; 2],
    /// Blue primary.
    pub blue: [f32; 2],
    /// White point.
    pub white: [f32; 2],
}

impl Chromaticities {
    /// BT.709 primaries with D65 white (ITU-R BT.709-6, item 1.3 and 1.4).
    pub const BT709: Self =
        Self { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: [0.3127, 0.3290] };
}

/// Where a picture lies in the full frame that it is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Column of the full frame that the picture's first column is.
    pub x: i32,
    /// Row of the full frame that the picture's first row is.
    pub y: i32,
    /// Width of the full frame in pixels, at least 1.
    pub full_width: u32,
    /// Height of the full frame in pixels, at least 1.
    pub full_height: u32,
}

impl Frame {
    /// The frame of a picture that is not cropped.
    pub fn whole(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, full_width: width, full_height: height }
    }
}

/// A picture contradicts itself.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PictureError {
    /// No pixels, or more than a file can hold.
    #[error("a picture of {width} x {height} pixels cannot be stored; each side must be 1 to {most}")]
    Size { width: u32, height: u32, most: u32 },
    /// The pixels lie too far from the origin.
    #[error("a picture at ({x}, {y}) of its frame lies outside of what a file can hold")]
    Position { x: i32, y: i32 },
    /// There is no channel.
    #[error("a picture needs at least one channel")]
    NoChannel,
    /// A channel's length is not the number of pixels.
    #[error("channel `{channel}` has {found} values, but the picture has {expected} pixels")]
    Length { channel: String, found: usize, expected: u64 },
    /// A name is empty, too long, or has a control character.
    #[error("`{0}` is not a name: 1 to {LONGEST_NAME_BYTES} bytes without control characters are")]
    Name(String),
    /// A name occurs twice.
    #[error("the name `{0}` occurs twice")]
    Twice(String),
    /// A value is infinite or not a number.
    #[error("channel `{channel}` is {value} at pixel ({x}, {y})")]
    NonFinite { channel: String, x: u32, y: u32, value: f32 },
}

/// Windows stay below half of the range of an `i32` (OpenEXR, `ImfHeader.cpp`, `sanityCheck`).
const FARTHEST: i64 = i32::MAX as i64 / 2;

impl Picture {
    /// A picture without channels in the project's colour space, uncropped.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            channels: Vec::new(),
            attributes: Vec::new(),
            chromaticities: Some(Chromaticities::BT709),
            white_luminance_cd_m2: None,
            frame: Frame::whole(width, height),
        }
    }

    /// The number of pixels.
    pub fn n_pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Adds a channel.
    pub fn push(&mut self, name: impl Into<String>, values: Vec<f32>) {
        self.channels.push(Channel { name: name.into(), values });
    }

    /// Adds a record.
    pub fn record(&mut self, name: impl Into<String>, value: Attribute) {
        self.attributes.push((name.into(), value));
    }

    /// The values of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| channel.values.as_slice())
    }

    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|(other, _)| other == name).map(|(_, value)| value)
    }

    /// The first infinite value or NaN, in the order of channels and pixels.
    pub fn first_non_finite(&self) -> Option<PictureError> {
        self.channels.iter().find_map(|channel| {
            let index = channel.values.iter().position(|value| !value.is_finite())?;
            let width = self.width.max(1) as usize;
            Some(PictureError::NonFinite {
                channel: channel.name.clone(),
                x: (index % width) as u32,
                y: (index / width) as u32,
                value: channel.values[index],
            })
        })
    }

    /// Checks that the picture can be stored.
    ///
    /// # Errors
    /// When sizes, names or lengths contradict each other, or a value is not finite.
    pub fn validate(&self) -> Result<(), PictureError> {
        self.validate_window()?;
        if self.channels.is_empty() {
            return Err(PictureError::NoChannel);
        }
        if let Some(channel) = self.channels.iter().find(|channel| channel.values.len() as u64 != self.n_pixels()) {
            return Err(PictureError::Length {
                channel: channel.name.clone(),
                found: channel.values.len(),
                expected: self.n_pixels(),
            });
        }
        validate_names(self.channels.iter().map(|channel| channel.name.as_str()))?;
        validate_names(self.attributes.iter().map(|(name, _)| name.as_str()))?;
        self.first_non_finite().map_or(Ok(()), Err)
    }

    fn validate_window(&self) -> Result<(), PictureError> {
        for (width, height) in [(self.width, self.height), (self.frame.full_width, self.frame.full_height)] {
            if [width, height].iter().any(|side| !(1..FARTHEST).contains(&i64::from(*side))) {
                return Err(PictureError::Size { width, height, most: FARTHEST as u32 - 1 });
            }
        }
        let Frame { x, y, .. } = self.frame;
        let far =
            |start: i32, side: u32| i64::from(start) <= -FARTHEST || i64::from(start) + i64::from(side) >= FARTHEST;
        if far(x, self.width) || far(y, self.height) {
            return Err(PictureError::Position { x, y });
        }
        Ok(())
    }
}

fn validate_names<'a>(names: impl Iterator<Item = &'a str>) -> Result<(), PictureError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if name.is_empty() || name.len() > LONGEST_NAME_BYTES || name.chars().any(char::is_control) {
            return Err(PictureError::Name(name.into()));
        }
        if !seen.insert(name) {
            return Err(PictureError::Twice(name.into()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, height: u32) -> Picture {
        let mut picture = Picture::new(width, height);
        picture.push("Y", vec![0.5; (width * height) as usize]);
        picture
    }

    #[test]
    fn a_contradiction_is_named() {
        assert_eq!(gray(3, 2).validate(), Ok(()));
        assert_eq!(Picture::new(3, 2).validate(), Err(PictureError::NoChannel));
        assert!(matches!(gray(0, 2).validate(), Err(PictureError::Size { .. })));
        let mut short = gray(3, 2);
        short.channels[0].values.pop();
        assert!(matches!(short.validate(), Err(PictureError::Length { found: 5, expected: 6, .. })));
        let mut twice = gray(3, 2);
        twice.push("Y", vec![0.0; 6]);
        assert_eq!(twice.validate(), Err(PictureError::Twice("Y".into())));
        for name in ["", "a\0b", "a\nb", &"n".repeat(256)] {
            let mut named = gray(1, 1);
            named.channels[0].name = name.into();
            assert_eq!(named.validate(), Err(PictureError::Name(name.into())));
        }
        let mut far = gray(3, 2);
        far.frame.x = i32::MAX;
        assert!(matches!(far.validate(), Err(PictureError::Position { .. })));
    }

    #[test]
    fn the_first_value_that_is_not_finite_is_named_with_its_pixel() {
        let mut picture = gray(3, 2);
        picture.push("Z", vec![0.0, 0.0, 0.0, 0.0, f32::INFINITY, f32::NAN]);
        let error = picture.first_non_finite().expect("there is one");
        assert_eq!(error.to_string(), "channel `Z` is inf at pixel (1, 1)");
        assert_eq!(picture.validate(), Err(error));
    }
}
