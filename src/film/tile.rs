//! Tiles: small squares of pixels, the work items of the picture loop.
//!
//! They are small, so that also a small picture keeps many threads busy, and lie together in memory.

use super::{Tally, slot};

/// Edge of a tile, pixels.
const EDGE: usize = 4;

/// Pixels of a tile; those beyond the picture's edge are there, and stay empty.
pub(super) const PIXELS: usize = EDGE * EDGE;

/// Where a pixel's sums are, counted in pixels.
pub(super) fn place(width: usize, x: usize, y: usize) -> usize {
    let tile = y / EDGE * width.div_ceil(EDGE) + x / EDGE;
    tile * PIXELS + within(x, y)
}

fn within(x: usize, y: usize) -> usize {
    y % EDGE * EDGE + x % EDGE
}

/// A tile of a picture: its number, counted row by row, and the pixels that it covers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Its number, row by row.
    pub index: usize,
    /// Its place among the columns of tiles.
    pub column: usize,
    /// Its place among the rows of tiles.
    pub row: usize,
    width: usize,
    height: usize,
}

impl Tile {
    /// Number of tiles in a row.
    pub fn columns(width: usize) -> usize {
        width.div_ceil(EDGE)
    }

    pub(super) fn count(width: usize, height: usize) -> usize {
        Self::columns(width) * height.div_ceil(EDGE)
    }

    pub(super) fn new(index: usize, width: usize, height: usize) -> Self {
        let columns = Self::columns(width).max(1);
        Self { index, column: index % columns, row: index / columns, width, height }
    }

    /// Column and row in the picture of every pixel of the tile.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (left, top) = (self.column * EDGE, self.row * EDGE);
        let (right, bottom) = (self.width.min(left + EDGE), self.height.min(top + EDGE));
        (top..bottom).flat_map(move |y| (left..right).map(move |x| (x, y)))
    }
}

/// The sums of the pixels of one tile, for one thread to fill.
pub struct TilePixels<'a> {
    stride: usize,
    sums: &'a mut [f64],
}

impl<'a> TilePixels<'a> {
    pub(super) fn new(stride: usize, sums: &'a mut [f64]) -> Self {
        Self { stride, sums }
    }

    /// Samples that a pixel has, by its column and row in the picture.
    pub fn samples(&self, x: usize, y: usize) -> u32 {
        self.sums[within(x, y) * self.stride + slot::COUNT] as u32
    }

    /// Adds a tally to a pixel, and leaves it empty.
    pub fn pour(&mut self, x: usize, y: usize, tally: &mut Tally) {
        let place = within(x, y) * self.stride;
        tally.pour(&mut self.sums[place..place + self.stride]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height) in [(1, 1), (8, 8), (9, 5), (3, 17)] {
            let mut seen = vec![0; Tile::count(width, height) * PIXELS];
            for index in 0..Tile::count(width, height) {
                for (x, y) in Tile::new(index, width, height).pixels() {
                    assert!(x < width && y < height);
                    assert_eq!(place(width, x, y) / PIXELS, index);
                    seen[place(width, x, y)] += 1;
                }
            }
            assert_eq!(seen.iter().sum::<i32>() as usize, width * height);
            assert_eq!(seen.iter().max(), Some(&1));
        }
    }
}
