//! The pixels that two pictures of one frame share.

use super::CompareError;
use crate::image::picture::Picture;

/// The rectangle that two pictures share, in coordinates of the full frame; the ends are outside.
pub struct Overlap {
    x: [i64; 2],
    y: [i64; 2],
    a: Layout,
    b: Layout,
}

/// Where a picture's rows lie in its channels.
struct Layout {
    x: i64,
    y: i64,
    width: i64,
}

impl Layout {
    fn new(picture: &Picture) -> Self {
        Self { x: picture.frame.x.into(), y: picture.frame.y.into(), width: picture.width.into() }
    }

    fn index(&self, x: i64, y: i64) -> usize {
        ((y - self.y) * self.width + x - self.x) as usize
    }
}

impl Overlap {
    /// Lays two pictures over each other.
    pub fn find(a: &Picture, b: &Picture) -> Result<Self, CompareError> {
        let full = |picture: &Picture| [picture.frame.full_width, picture.frame.full_height];
        if full(a) != full(b) {
            return Err(CompareError::Frame { a: full(a), b: full(b) });
        }
        for picture in [a, b] {
            if let Some(channel) = picture.channels.iter().find(|c| c.values.len() as u64 != picture.n_pixels()) {
                return Err(CompareError::Length(channel.name.clone()));
            }
        }
        let (left, right) = (Layout::new(a), Layout::new(b));
        let x = [left.x.max(right.x), (left.x + left.width).min(right.x + right.width)];
        let y = [left.y.max(right.y), (left.y + i64::from(a.height)).min(right.y + i64::from(b.height))];
        if x[0] >= x[1] || y[0] >= y[1] {
            return Err(CompareError::Disjoint);
        }
        Ok(Self { x, y, a: left, b: right })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.x, self.y].map(|[start, end]| (end - start) as u32)
    }

    /// Indices into a's and b's channels of every shared pixel.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (self.y[0]..self.y[1])
            .flat_map(move |y| (self.x[0]..self.x[1]).map(move |x| (self.a.index(x, y), self.b.index(x, y))))
    }
}

/// The colours of one shared pixel.
pub struct Pixel {
    /// Its index in the channels of a and of b.
    pub at: (usize, usize),
    /// R, G, B of a.
    pub a: [f32; 3],
    /// R, G, B of b.
    pub b: [f32; 3],
}

impl Pixel {
    /// Picks the colours at a pair of indices.
    pub fn gather(at: (usize, usize), a: &[&[f32]; 3], b: &[&[f32]; 3]) -> Self {
        Self { at, a: a.map(|values| values[at.0]), b: b.map(|values| values[at.1]) }
    }

    /// Whether all six values are finite.
    pub fn is_finite(&self) -> bool {
        self.a.iter().chain(&self.b).all(|value| value.is_finite())
    }

    /// Whether any bit differs.
    pub fn differs(&self) -> bool {
        self.a.map(f32::to_bits) != self.b.map(f32::to_bits)
    }

    /// a - b for each colour.
    pub fn differences(&self) -> [f64; 3] {
        std::array::from_fn(|colour| f64::from(self.a[colour]) - f64::from(self.b[colour]))
    }

    /// Standard error of each colour's difference.
    pub fn errors(&self, (a, b): &([&[f32]; 3], [&[f32]; 3])) -> [f64; 3] {
        std::array::from_fn(|colour| f64::from(a[colour][self.at.0]).hypot(f64::from(b[colour][self.at.1])))
    }
}
