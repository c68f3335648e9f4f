//! Where particles go, and how large parcels are: evenly in a plain shape, or in the cells of a grown cloud.

use std::f64::consts::PI;

use super::error::GenerateError;
use super::noise::Patches;
use super::random::{self, Purpose, unit_f64};
use super::recipe::Recipe;
use super::shape::CloudShape;
use super::voxels::{Cell, Voxels};
use crate::scene::model::ParticleKind;

/// Particles' centres, and the room that they take.
pub(super) struct Placed {
    /// Centres, in units of the half sizes.
    pub points: Vec<[f32; 3]>,
    /// What parcels are like; `None` for droplets.
    pub parcels: Option<Parcels>,
    /// Volume of the cloud, m^3.
    pub volume_m3: f64,
    /// Area of its shadow along the shortest side, m^2.
    pub shadow_m2: f64,
    /// Integral of the particles' density along the line through the centre, parallel to the shortest side, when its
    /// integral over space is 1: 1/m^2, averaged over all seeds that make this body.
    pub column_per_m2: f64,
}

/// What parcels are like.
pub(super) struct Parcels {
    pub radii: ParcelRadii,
    /// Droplets in each, relative.
    pub shares: Vec<f64>,
    /// Parcels over each point, on average.
    pub overlapping: f64,
    /// Whether they would be larger if the shape were.
    pub cramped: bool,
}

/// Radii of parcels, m.
pub(super) enum ParcelRadii {
    Alike(f64),
    Each(Vec<f32>),
}

impl ParcelRadii {
    /// The smallest, m.
    pub fn smallest_m(&self) -> f64 {
        match self {
            Self::Alike(radius_m) => *radius_m,
            Self::Each(radii_m) => f64::from(radii_m.iter().copied().fold(f32::INFINITY, f32::min)),
        }
    }

    /// The largest, m.
    pub fn largest_m(&self) -> f64 {
        match self {
            Self::Alike(radius_m) => *radius_m,
            Self::Each(radii_m) => f64::from(radii_m.iter().copied().fold(0.0, f32::max)),
        }
    }
}

/// Parcels deep inside a grown cloud are this many times larger than at its surface, which is where one sees them.
const INNER_RADIUS: f64 = 3.0;

/// They are that large this many surface radii below the surface, so that none sticks out.
const INNER_DEPTH: f64 = 3.0;

/// Parcels are no larger than this share of the shape's shortest side, so that they soften its faces no more.
const LARGEST: f64 = 0.25;

/// Places the recipe's particles.
///
/// # Errors
/// When nothing of a grown cloud lies on the line along which its optical depth is counted.
pub(super) fn place(recipe: &Recipe) -> Result<Placed, GenerateError> {
    let count = recipe.particle_count();
    let voxels = recipe.shape.is_grown().then(|| Voxels::new(&recipe.shape, recipe.seed, count));
    let no_middle = || GenerateError::NoMiddle { seed: recipe.seed };
    if voxels.as_ref().is_some_and(|voxels| voxels.cells().is_empty()) {
        return Err(no_middle());
    }
    let placed = match (recipe.kind, voxels) {
        (ParticleKind::Droplet, None) => {
            even(&recipe.shape, droplet_points(recipe, |rng| recipe.shape.sample_unit_point(rng)))
        }
        (ParticleKind::Droplet, Some(voxels)) => droplets_in(recipe, &voxels),
        (ParticleKind::Parcel, voxels) if count == 1 => one_parcel(recipe, voxels.as_ref()),
        (ParticleKind::Parcel, None) => even_parcels(recipe),
        (ParticleKind::Parcel, Some(voxels)) => parcels_in(recipe, &voxels),
    };
    if placed.column_per_m2 > 0.0 { Ok(placed) } else { Err(no_middle()) }
}

/// Droplets are wholly at random: more where it is dense.
fn droplet_points(recipe: &Recipe, sample: impl Fn(&mut rand_pcg::Pcg64) -> [f64; 3] + Sync) -> Vec<[f32; 3]> {
    let patches = Patches::new(recipe.seed, recipe.patchiness, recipe.shape.size_m());
    random::make_blocks(recipe.particle_count() as usize, recipe.seed, Purpose::Positions, |_, rng| {
        loop {
            let point = sample(rng);
            if recipe.patchiness == 0.0 || unit_f64(rng) < patches.density(point) {
                return point.map(|x| x as f32);
            }
        }
    })
}

fn even(shape: &CloudShape, points: Vec<[f32; 3]>) -> Placed {
    Placed {
        points,
        parcels: None,
        volume_m3: shape.volume_m3(),
        shadow_m2: shape.shadow_m2(),
        column_per_m2: shape.middle_column_per_m2(0.0),
    }
}

/// One parcel fills the shortest side.
fn one_parcel(recipe: &Recipe, voxels: Option<&Voxels>) -> Placed {
    let radius_m = 0.5 * recipe.shape.shortest_m();
    let parcels = Parcels { radii: ParcelRadii::Alike(radius_m), shares: vec![1.0], overlapping: 1.0, cramped: false };
    let around = even(&recipe.shape, vec![[0.0; 3]]);
    Placed {
        parcels: Some(parcels),
        column_per_m2: 1.5 / (PI * radius_m * radius_m),
        volume_m3: voxels.map_or(around.volume_m3, Voxels::volume_m3),
        shadow_m2: voxels.map_or(around.shadow_m2, Voxels::shadow_m2),
        ..around
    }
}

fn even_parcels(recipe: &Recipe) -> Placed {
    let (shape, count) = (&recipe.shape, recipe.particle_count() as f64);
    let points = random::make_blocks(count as usize, recipe.seed, Purpose::Positions, |_, rng| {
        shape.sample_unit_point(rng).map(|x| x as f32)
    });
    let smooth_m = recipe.overlap * (shape.volume_m3() / count).cbrt();
    let radius_m = smooth_m.min(LARGEST * shape.shortest_m());
    let parcels = Parcels {
        radii: ParcelRadii::Alike(radius_m),
        shares: densities(recipe, &points),
        overlapping: count * 4.0 / 3.0 * PI * radius_m.powi(3) / shape.volume_m3(),
        cramped: radius_m < smooth_m,
    };
    Placed { parcels: Some(parcels), column_per_m2: shape.middle_column_per_m2(radius_m), ..even(shape, points) }
}

/// Relative densities of the patches at the points.
fn densities(recipe: &Recipe, points: &[[f32; 3]]) -> Vec<f64> {
    let patches = Patches::new(recipe.seed, recipe.patchiness, recipe.shape.size_m());
    points.iter().map(|point| patches.density(point.map(f64::from))).collect()
}

fn droplets_in(recipe: &Recipe, voxels: &Voxels) -> Placed {
    let draw = CellDraw::new(voxels.cells(), |cell| f64::from(cell.water));
    let points = droplet_points(recipe, |rng| {
        let cell = draw.cell(unit_f64(rng));
        voxels.point(&voxels.cells()[cell], [0; 3].map(|_| unit_f64(rng)))
    });
    Placed {
        points,
        parcels: None,
        volume_m3: voxels.volume_m3(),
        shadow_m2: voxels.shadow_m2(),
        column_per_m2: voxels.middle_column_per_m2(|_| 0.0),
    }
}

/// Parcels are small at the surface and larger inside, everywhere as many over a point: their number falls as the cube of
/// their radius, and what each holds rises with it. Along the Z-order curve each has its own share of the cloud, so that
/// they are spread far more evenly than by chance.
fn parcels_in(recipe: &Recipe, voxels: &Voxels) -> Placed {
    let radii = RadiusByDepth::new(recipe, voxels);
    let draw = CellDraw::new(voxels.cells(), |cell| radii.at(cell).powi(-3));
    let count = recipe.particle_count() as usize;
    let drawn = random::make_blocks(count, recipe.seed, Purpose::Positions, |i, rng| {
        let index = draw.cell((i as f64 + unit_f64(rng)) / count as f64);
        let point = voxels.point(&voxels.cells()[index], [0; 3].map(|_| unit_f64(rng)));
        (index, point.map(|x| x as f32))
    });
    let points: Vec<_> = drawn.iter().map(|&(_, point)| point).collect();
    let cells = || drawn.iter().map(|&(index, _)| &voxels.cells()[index]);
    let water = cells().map(|cell| f64::from(cell.water) * radii.at(cell).powi(3));
    let parcels = Parcels {
        shares: water.zip(densities(recipe, &points)).map(|(water, density)| water * density).collect(),
        radii: ParcelRadii::Each(cells().map(|cell| radii.at(cell) as f32).collect()),
        overlapping: radii.overlapping(voxels, count),
        cramped: radii.cramped(),
    };
    Placed {
        points,
        parcels: Some(parcels),
        volume_m3: voxels.volume_m3(),
        shadow_m2: voxels.shadow_m2(),
        column_per_m2: voxels.middle_column_per_m2(|cell| radii.at(cell)),
    }
}

/// How large parcels are in a cell of a grown cloud.
struct RadiusByDepth {
    surface_m: f64,
    inner_depth_m: f64,
    largest_m: f64,
}

impl RadiusByDepth {
    /// Radii at which as many parcels lie over each point as the recipe's overlap says.
    fn new(recipe: &Recipe, voxels: &Voxels) -> Self {
        let spacing_m = (voxels.volume_m3() / recipe.particle_count() as f64).cbrt();
        let inner_depth_m = INNER_DEPTH * recipe.overlap * spacing_m / INNER_RADIUS.sqrt();
        let largest_m = LARGEST * recipe.shape.shortest_m();
        let unit = Self { surface_m: 1.0, inner_depth_m, largest_m: f64::INFINITY };
        // The count of parcels is the sum over cells of volume / spacing^3.
        let sum: f64 = voxels.cells().iter().map(|cell| unit.at(cell).powi(-3)).sum();
        let spacing_m = (sum * voxels.cell_volume_m3() / recipe.particle_count() as f64).cbrt();
        Self { surface_m: recipe.overlap * spacing_m, inner_depth_m, largest_m }
    }

    fn at(&self, cell: &Cell) -> f64 {
        let share = (f64::from(cell.depth_m) / self.inner_depth_m).clamp(0.0, 1.0);
        (self.surface_m * (1.0 + (INNER_RADIUS - 1.0) * share)).min(self.largest_m)
    }

    fn overlapping(&self, voxels: &Voxels, count: usize) -> f64 {
        let sum: f64 = voxels.cells().iter().map(|cell| self.at(cell).powi(-3)).sum();
        count as f64 * 4.0 / 3.0 * PI / (sum * voxels.cell_volume_m3())
    }

    fn cramped(&self) -> bool {
        self.surface_m * INNER_RADIUS > self.largest_m
    }
}

/// Draws cells with given weights, in their order.
struct CellDraw {
    sums: Vec<f64>,
}

impl CellDraw {
    fn new(cells: &[Cell], weight: impl Fn(&Cell) -> f64) -> Self {
        let mut sum = 0.0;
        let sums = cells.iter().map(|cell| {
            sum += weight(cell);
            sum
        });
        Self { sums: sums.collect() }
    }

    /// The cell at a share of the sum of all weights, 0 to 1.
    fn cell(&self, share: f64) -> usize {
        let target = share * self.sums.last().copied().unwrap_or(0.0);
        self.sums.partition_point(|&sum| sum < target).min(self.sums.len().saturating_sub(1))
    }
}
