//! Sums of samples per pixel: means, standard errors, layers.

mod block;
mod develop;
mod join;
mod noise;
mod tally;
mod tile;

pub use block::block_of;
pub use develop::{Channel, Wanted, develop};
pub use join::{Joiner, is_whole, most_held, nodes_of};
pub use noise::{Noise, Spread};
pub use tally::Tally;
pub use tile::{Tile, TilePixels};

use rayon::prelude::*;

/// A class of light paths; the picture is the sum of all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// Camera, droplet, sun.
    Direct,
    /// Camera, several droplets, sun.
    Multiple,
    /// Camera, air, sun.
    Airlight,
    /// Camera, air, droplet, sun.
    Glow,
    /// All other paths from the sun with air in them.
    AirMultiple,
    /// Through resolved droplets.
    Refraction,
    /// The background, seen straight or by way of droplets and air, and the suns' discs.
    Background,
}

impl Layer {
    /// All layers with the names of their channels, in the order of the sum.
    pub const ALL: [(Layer, &'static str); 7] = [
        (Layer::Direct, "direct"),
        (Layer::Multiple, "multiple"),
        (Layer::Airlight, "airlight"),
        (Layer::Glow, "glow"),
        (Layer::AirMultiple, "air_multiple"),
        (Layer::Refraction, "refraction"),
        (Layer::Background, "background"),
    ];
}

/// What one path brings to its pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// R, G, B of each layer, indexed by `Layer`.
    pub layers: [[f64; 3]; Layer::ALL.len()],
    /// Transmittance of the camera ray in R, G, B.
    pub transmittance: [f64; 3],
    /// One minus the luminance-weighted transmittance.
    pub opacity: f64,
    /// Sum of distances to the first event, weighted, m.
    pub depth_sum_m: f64,
    /// Sum of those weights.
    pub depth_weight: f64,
}

/// Positions of the sums of a pixel; the layers follow, then the spectrum.
mod slot {
    /// Number of samples.
    pub const COUNT: usize = 0;
    /// Squares of the blocks' numbers of samples.
    pub const COUNT_SQUARES: usize = 1;
    pub const BEAUTY: usize = 2;
    /// Squares of the blocks' beauty.
    pub const SQUARES: usize = 5;
    /// Products of the blocks' beauty and numbers of samples.
    pub const PRODUCTS: usize = 8;
    pub const TRANSMITTANCE: usize = 11;
    pub const OPACITY: usize = 14;
    pub const DEPTH: usize = 15;
    pub const DEPTH_WEIGHT: usize = 16;
    pub const LAYERS: usize = 17;
}

/// Sums over samples of every pixel of a rectangle.
///
/// Every value is a sum, so that films of different samples of one scene are combined by addition; films of aligned runs of
/// samples (`Tally`) to the very bits that one film would have. Each pixel knows its number of samples. The pixels of a tile
/// lie together, so that threads can fill tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: usize,
    height: usize,
    layers: Vec<Layer>,
    n_spectral: usize,
    sums: Vec<f64>,
}

impl Film {
    /// An empty film that keeps the given layers apart, and radiance at `n_spectral` wavelengths.
    pub fn new(width: u32, height: u32, layers: &[Layer], n_spectral: usize) -> Self {
        let (width, height) = (width as usize, height as usize);
        let mut film = Self { width, height, layers: layers.to_vec(), n_spectral, sums: Vec::new() };
        film.sums = vec![0.0; film.n_tiles() * tile::PIXELS * film.stride()];
        film
    }

    /// A film of known sums, as `sums` gives them; `None` where their number is wrong, one is not finite, or a number of
    /// samples is none.
    pub fn from_sums(width: u32, height: u32, layers: &[Layer], n_spectral: usize, sums: Vec<f64>) -> Option<Self> {
        let right = Self::n_sums(width, height, layers.len(), n_spectral)? == sums.len() as u64;
        let (width, height) = (width as usize, height as usize);
        let film = Self { width, height, layers: layers.to_vec(), n_spectral, sums };
        let is_count = |n: f64| (0.0..=f64::from(u32::MAX)).contains(&n) && n.fract() == 0.0;
        let is_sound = |pixel: &[f64]| is_count(pixel[slot::COUNT]) && pixel.iter().all(|sum| sum.is_finite());
        (right && film.sums.chunks_exact(film.stride()).all(is_sound)).then_some(film)
    }

    /// How many numbers a film of this shape consists of; `None` where there are too many to count.
    pub fn n_sums(width: u32, height: u32, n_layers: usize, n_spectral: usize) -> Option<u64> {
        let pixels = (Tile::count(width as usize, height as usize) as u64).checked_mul(tile::PIXELS as u64)?;
        let stride = n_layers.checked_mul(3)?.checked_add(n_spectral)?.checked_add(slot::LAYERS)?;
        pixels.checked_mul(stride as u64)
    }

    /// Every sum of every pixel, tile by tile.
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }

    /// The layers that are kept apart.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The number of wavelengths at which radiance is kept.
    pub fn n_spectral(&self) -> usize {
        self.n_spectral
    }

    /// Whether another film has the same pixels and layers.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let shape = |film: &Self| (film.width, film.height, film.n_spectral);
        shape(self) == shape(other) && self.layers == other.layers
    }

    /// A film of this shape without samples.
    pub fn emptied(&self) -> Self {
        Self::new(self.width as u32, self.height as u32, &self.layers, self.n_spectral)
    }

    /// Number of pixels.
    pub fn n_pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// Adds the samples of another film of the same shape.
    pub fn add(&mut self, other: &Self) {
        debug_assert!(self.has_shape_of(other));
        self.sums.par_iter_mut().zip(&other.sums).for_each(|(sum, other)| *sum += other);
    }

    fn stride(&self) -> usize {
        slot::LAYERS + 3 * self.layers.len() + self.n_spectral
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Bytes that the sums take.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.sums[..])
    }

    /// Room to add up the samples of a pixel.
    pub fn tally(&self) -> Tally {
        Tally::new(&self.layers, self.stride())
    }

    /// Number of tiles.
    pub fn n_tiles(&self) -> usize {
        Tile::count(self.width, self.height)
    }

    /// The pixels of a tile.
    pub fn tile(&self, index: usize) -> Tile {
        Tile::new(index, self.width, self.height)
    }

    /// Calls `fill` for every tile, in parallel, and returns what the calls return, in the tiles' order. Each thread
    /// hands the tools that `tools` makes from one call to the next.
    pub fn par_tiles<S, T: Send>(
        &mut self,
        tools: &(impl Fn() -> S + Sync),
        fill: impl Fn(&mut S, Tile, TilePixels<'_>) -> T + Sync,
    ) -> Vec<T> {
        let (stride, width, height) = (self.stride(), self.width, self.height);
        self.sums
            .par_chunks_mut(tile::PIXELS * stride)
            .enumerate()
            .map_init(tools, |tools, (index, sums)| {
                fill(tools, Tile::new(index, width, height), TilePixels::new(stride, sums))
            })
            .collect()
    }

    /// The sums of a pixel.
    fn pixel(&self, x: usize, y: usize) -> &[f64] {
        let place = tile::place(self.width, x, y) * self.stride();
        &self.sums[place..place + self.stride()]
    }

    /// The sums of all pixels, row by row from the top left.
    fn pixels(&self) -> impl Iterator<Item = &[f64]> {
        (0..self.height).flat_map(move |y| (0..self.width).map(move |x| self.pixel(x, y)))
    }

    /// Samples of all pixels together.
    pub fn samples(&self) -> u64 {
        self.pixels().map(|pixel| pixel[slot::COUNT] as u64).sum()
    }

    /// Samples per pixel, on average.
    pub fn mean_samples(&self) -> u32 {
        let pixels = self.n_pixels();
        u32::try_from((self.samples() + pixels / 2) / pixels.max(1)).unwrap_or(u32::MAX)
    }

    /// Whether every pixel has a sample.
    pub fn is_covered(&self) -> bool {
        self.pixels().all(|pixel| pixel[slot::COUNT] > 0.0)
    }

    /// Mean luminance of the picture.
    pub fn mean_luminance(&self) -> f64 {
        let of = |pixel: &[f64]| luminance(|c| pixel[slot::BEAUTY + c] / pixel[slot::COUNT].max(1.0));
        self.pixels().map(of).sum::<f64>() / (self.width * self.height).max(1) as f64
    }
}

/// Luminance of linear BT.709 (ITU-R BT.709-6, item 3.2).
fn luminance(channel: impl Fn(usize) -> f64) -> f64 {
    0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
}
