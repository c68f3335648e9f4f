//! A cloud that grew from billows, in cells: how deep each lies below the surface and how much water it holds.
//!
//! Everything that must be known of such a cloud (its volume, its middle column, how to draw points from it) is a sum over
//! cells, so that it holds what was asked for exactly, whatever its shape.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::grown::Grown;
use super::shape::CloudShape;

/// The cloud in cells along x, y, z; odd numbers, so that the middle lines run through middles of cells.
pub(super) struct Voxels {
    n: [usize; 3],
    cell_m: [f64; 3],
    /// Cells inside the cloud, along a Z-order curve: neighbours on it are neighbours in space.
    cells: Vec<Cell>,
    /// The axis along which the optical depth is counted.
    axis: usize,
}

/// A cell inside the cloud.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    index: [u16; 3],
    /// Depth of its middle below the cloud's surface, m.
    pub depth_m: f32,
    /// Water, relative.
    pub water: f32,
}

/// Cells along the longest side: enough for the smallest billows, more where parcels are smaller still.
const CELLS: std::ops::RangeInclusive<f64> = 64.0..=224.0;

/// Of a thousand parcels in a cloud as wide as high, ten lie along its side; cells are a quarter of their distances.
const CELLS_PER_SPACING: f64 = 4.0;

/// Points across each side of a cell's footprint at which the parcels' chords are averaged.
const SUBCELLS: usize = 8;

/// Cells along x, y and z of the box around the cloud.
fn cell_counts(shape: &CloudShape, count: u64) -> [usize; 3] {
    let longest = (CELLS_PER_SPACING * (count as f64).cbrt()).clamp(*CELLS.start(), *CELLS.end());
    // Long and thin clouds have three cells across at least.
    shape.size_m().map(|size| 2 * (0.5 * longest * size / shape.longest_m()).max(1.0) as usize + 1)
}

/// The share of its box that a grown cloud fills, at most (measured over seeds and shapes: up to 0.32).
const FILLED: f64 = 0.4;

impl Voxels {
    /// Bytes that the cells of a cloud take.
    pub fn bytes(shape: &CloudShape, count: u64) -> u64 {
        let all: f64 = cell_counts(shape, count).into_iter().map(|n| n as f64).product();
        (FILLED * all) as u64 * size_of::<Cell>() as u64
    }

    /// The cells of a seed's cloud; as many as `count` particles need.
    pub fn new(shape: &CloudShape, seed: u64, count: u64) -> Self {
        let grown = Grown::new(shape, seed);
        let size_m = shape.size_m();
        let n = cell_counts(shape, count);
        let cell_m = [0, 1, 2].map(|axis| size_m[axis] / n[axis] as f64);
        let mut cells: Vec<Cell> = (0..n[2]).into_par_iter().flat_map_iter(|k| layer(&grown, n, k)).collect();
        cells.par_sort_unstable_by_key(|cell| z_order(cell.index));
        Self { n, cell_m, cells, axis: shape.shortest_axis() }
    }

    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Volume of the cloud, m^3.
    pub fn volume_m3(&self) -> f64 {
        self.cells.len() as f64 * self.cell_volume_m3()
    }

    pub fn cell_volume_m3(&self) -> f64 {
        self.cell_m.iter().product()
    }

    /// Area of the shadow along the shortest side, m^2.
    pub fn shadow_m2(&self) -> f64 {
        let [a, b] = self.across();
        let mut shaded = vec![false; self.n[a] * self.n[b]];
        for cell in &self.cells {
            shaded[usize::from(cell.index[a]) * self.n[b] + usize::from(cell.index[b])] = true;
        }
        shaded.into_iter().filter(|&shade| shade).count() as f64 * self.cell_m[a] * self.cell_m[b]
    }

    /// As [`CloudShape::middle_column_per_m2`], where balls around the points of a cell have the radius `ball_m` of it.
    pub fn middle_column_per_m2(&self, ball_m: impl Fn(&Cell) -> f64 + Sync) -> f64 {
        let water: f64 = self.cells.iter().map(|cell| f64::from(cell.water)).sum();
        let column: f64 =
            self.cells.iter().map(|cell| f64::from(cell.water) * self.mean_chord_per_m2(cell, ball_m(cell))).sum();
        column / water
    }

    /// What balls of radius `b` with centres anywhere in the cell put on the middle line: their chord over their volume.
    fn mean_chord_per_m2(&self, cell: &Cell, b: f64) -> f64 {
        let [u, v] = self.across();
        let off = |axis: usize| (f64::from(cell.index[axis]) + 0.5) * self.cell_m[axis] - self.half_m(axis);
        let (x, y, dx, dy) = (off(u), off(v), self.cell_m[u], self.cell_m[v]);
        if b == 0.0 {
            return if x.abs() < 0.5 * dx && y.abs() < 0.5 * dy { 1.0 / (dx * dy) } else { 0.0 };
        }
        if (x.abs() - 0.5 * dx).max(y.abs() - 0.5 * dy) > b {
            return 0.0;
        }
        let part = |i: usize| (i as f64 + 0.5) / SUBCELLS as f64 - 0.5;
        let chord = |i: usize| {
            let (x, y) = (x + dx * part(i / SUBCELLS), y + dy * part(i % SUBCELLS));
            2.0 * (b * b - x * x - y * y).max(0.0).sqrt()
        };
        let mean = (0..SUBCELLS * SUBCELLS).map(chord).sum::<f64>() / (SUBCELLS * SUBCELLS) as f64;
        mean / (4.0 / 3.0 * PI * b * b * b)
    }

    fn half_m(&self, axis: usize) -> f64 {
        0.5 * self.cell_m[axis] * self.n[axis] as f64
    }

    /// The two axes across the one of the optical depth.
    fn across(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// A point of a cell in units of the half sizes, from three numbers in 0 .. 1.
    pub fn point(&self, cell: &Cell, u: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| 2.0 * (f64::from(cell.index[axis]) + u[axis]) / self.n[axis] as f64 - 1.0)
    }
}

/// The cells inside the cloud with index `k` along z.
fn layer(grown: &Grown, n: [usize; 3], k: usize) -> Vec<Cell> {
    let place =
        |index: [usize; 3]| grown.place([0, 1, 2].map(|axis| (2 * index[axis] + 1) as f64 / n[axis] as f64 - 1.0));
    let in_layer = grown.near(grown.billows(), 2, place([0, 0, k]).z);
    let mut cells = Vec::new();
    for j in 0..n[1] {
        let in_row = grown.near(&in_layer, 1, place([0, j, k]).y);
        cells.extend((0..n[0]).filter_map(|i| {
            let (depth, water) = grown.look(&in_row, place([i, j, k]))?;
            let depth_m = (depth * grown.metres_per_unit()) as f32;
            Some(Cell { index: [i, j, k].map(|index| index as u16), depth_m, water: water as f32 })
        }));
    }
    cells
}

/// The place on a Z-order curve (Morton 1966): the bits of the three indices take turns.
fn z_order(index: [u16; 3]) -> u64 {
    (0..16)
        .flat_map(|bit| (0..3).map(move |axis| (bit, axis)))
        .fold(0, |code, (bit, axis)| code | u64::from(index[axis] >> bit & 1) << (3 * bit + axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_take_no_more_memory_than_is_foretold_and_not_a_fraction_of_it() {
        for (name, size) in
            [("puff", [1.0; 3]), ("puff", [3.0, 1.0, 2.0]), ("cumulus", [1.0; 3]), ("cumulus", [1.0, 0.7, 1.0])]
        {
            let shape = CloudShape::new(name, &size).expect("a shape");
            let told = Voxels::bytes(&shape, 1000) as f64;
            let took = (0..6).map(|seed| size_of_val(&Voxels::new(&shape, seed, 1000).cells[..]) as f64);
            let (least, most) = took.fold((f64::INFINITY, 0.0_f64), |(a, b), bytes| (a.min(bytes), b.max(bytes)));
            assert!(most <= told && most > 0.3 * told, "{name} {size:?}: {least} to {most} of {told}");
        }
    }

    #[test]
    fn neighbours_on_the_curve_are_close_in_space() {
        assert_eq!(z_order([0, 0, 0]), 0);
        assert_eq!(z_order([3, 0, 0]), 0b001_001);
        assert_eq!(z_order([0, 1, 2]), 0b100_010);
    }

    #[test]
    fn the_middle_of_a_grown_cloud_is_never_empty() {
        for seed in 0..8 {
            for name in ["cumulus", "puff"] {
                let shape = CloudShape::new(name, &[1.0]).expect("a shape");
                let voxels = Voxels::new(&shape, seed, 1000);
                let (points, balls) = (voxels.middle_column_per_m2(|_| 0.0), voxels.middle_column_per_m2(|_| 0.03));
                // Between a third of the mean over the shadow and six times it.
                let share = points * voxels.shadow_m2();
                assert!((0.3..6.0).contains(&share), "{name} {seed}: {share}");
                assert!((0.5..2.0).contains(&(points / balls)), "{name} {seed}: {points} {balls}");
            }
        }
    }

    #[test]
    fn no_cell_of_the_middle_line_is_counted_twice_or_missed() {
        let shape = CloudShape::new("cumulus", &[1.0, 0.5, 2.0]).expect("a shape");
        let voxels = Voxels::new(&shape, 3, 1000);
        // Balls far larger than the cloud see it as a point: chord 2 b over volume.
        let b = 100.0;
        let column = voxels.middle_column_per_m2(|_| b);
        assert!((column * 4.0 / 3.0 * PI * b * b / 2.0 - 1.0).abs() < 1e-3);
        assert!(voxels.volume_m3() < 0.7 && voxels.volume_m3() > 0.1 && voxels.shadow_m2() < 2.0);
    }
}
