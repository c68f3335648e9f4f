//! How deep the droplets lie along a coarse picture's rays, and along the sun's: optical depths on a grid, no render.
//!
//! Legend: tau, optical depth of a cell; own, the sum of squares of what single droplets add to it. What a droplet scatters does
//! not meet it again, so that light that leaves one of a cell's droplets has tau - own / tau before it.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::areas::BodyAreas;
use crate::scene::model::{Camera, Lens, ParticleKind, Scene};

/// Cells along the picture's longer side, and along the sun's view of the cloud.
const CELLS: usize = 32;

/// At most so many particles, evenly chosen, stand for all.
const MOST_PARTICLES: usize = 1 << 15;

/// At most so many fog boxes, evenly chosen, stand for all.
const MOST_BOXES: usize = 256;

/// A grid of parallel or diverging rays.
pub(super) struct Grid {
    size: [usize; 2],
    origin_m: DVec3,
    /// Rows: right, up, toward the viewer.
    frame: DMat3,
    /// Half width and half height, m at distance 1 m (diverging) or everywhere.
    half: [f64; 2],
    diverges: bool,
}

/// What lies along every ray of a grid.
pub(super) struct Depths {
    /// Optical depth.
    pub tau: Vec<f64>,
    own: Vec<f64>,
    /// Optical depth of what scatters.
    pub scattering: Vec<f64>,
    /// Where it lies: each times its mean distance from the start of the ray, m, and times that of the square, m^2.
    moments: Vec<[f64; 2]>,
    scattering_moments: Vec<[f64; 2]>,
    /// Whether a fog box lies between the rays, or beside them all.
    pub misses_a_box: bool,
}

impl Grid {
    /// The camera's rays.
    pub fn of_camera(camera: &Camera, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution.map(f64::from);
        let longer = width.max(height);
        let size = [width, height].map(|side| (CELLS as f64 * side / longer).round().max(1.0) as usize);
        let (half, diverges) = match camera.lens {
            Lens::Orthographic { xmag_m, ymag_m } => ([xmag_m, ymag_m], false),
            Lens::Perspective { yfov_rad, .. } => {
                let up = (0.5 * yfov_rad).tan();
                ([up * width / height, up], true)
            }
        };
        Self { size, origin_m: camera.position_m, frame: camera.world_from_camera.transpose(), half, diverges }
    }

    /// Parallel rays over a ball.
    pub fn along(direction: DVec3, center_m: DVec3, radius_m: f64) -> Self {
        let (right, up) = direction.any_orthonormal_pair();
        let frame = DMat3::from_cols(right, up, -direction).transpose();
        let origin_m = center_m - 2.0 * radius_m * direction;
        Self { size: [CELLS; 2], origin_m, frame, half: [radius_m.max(f64::MIN_POSITIVE); 2], diverges: false }
    }

    /// Origin and direction of the ray through the middle of a cell, in the grid's frame.
    fn ray(&self, column: usize, row: usize) -> (DVec3, DVec3) {
        let [x, y] = [(column, 0), (row, 1)]
            .map(|(i, axis)| self.half[axis] * (2.0 * (i as f64 + 0.5) / self.size[axis] as f64 - 1.0));
        match self.diverges {
            true => (DVec3::ZERO, DVec3::new(x, y, -1.0).normalize()),
            false => (DVec3::new(x, y, 0.0), -DVec3::Z),
        }
    }

    /// The cells of parallel rays within a distance of a point across them, and one more on each side.
    pub fn cells_about(&self, point: DVec3, margin_m: f64) -> impl Iterator<Item = usize> {
        let at = self.frame * (point - self.origin_m);
        let range = |x: f64, axis: usize| {
            let cell_m = 2.0 * self.half[axis] / self.size[axis] as f64;
            let of = |x_m: f64| ((x_m + self.half[axis]) / cell_m).floor();
            let (low, high) = (of(x - margin_m) - 1.0, of(x + margin_m) + 2.0);
            low.max(0.0) as usize..high.clamp(0.0, self.size[axis] as f64) as usize
        };
        let (columns, rows, width) = (range(at.x, 0), range(at.y, 1), self.size[0]);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// How far along the parallel rays a point lies, m.
    pub fn along_m(&self, point: DVec3) -> f64 {
        -(self.frame * (point - self.origin_m)).z
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Area of a cell, m^2, or at distance 1 m.
    pub fn cell_m2(&self) -> f64 {
        4.0 * self.half[0] * self.half[1] / (self.size[0] * self.size[1]) as f64
    }

    /// How far a cell reaches from its middle, rad; 0 where all rays are parallel.
    pub fn blur_rad(&self) -> f64 {
        let half_cell = |axis: usize| self.half[axis] / self.size[axis] as f64;
        if self.diverges { half_cell(0).hypot(half_cell(1)) } else { 0.0 }
    }

    /// All rays, row by row, in world space.
    pub fn rays(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        let back = self.frame.transpose();
        let cells = (0..self.size[1]).flat_map(|row| (0..self.size[0]).map(move |column| (column, row)));
        cells.map(move |(column, row)| {
            let (start, direction) = self.ray(column, row);
            (self.origin_m + back * start, back * direction)
        })
    }

    /// What lies along the rays.
    pub fn depths(&self, scene: &Scene, areas: &BodyAreas) -> Depths {
        let n = self.size[0] * self.size[1];
        let mut depths = Depths {
            tau: vec![0.0; n],
            own: vec![0.0; n],
            scattering: vec![0.0; n],
            moments: vec![[0.0; 2]; n],
            scattering_moments: vec![[0.0; 2]; n],
            misses_a_box: false,
        };
        let albedo = |class: u16| scene.classes[usize::from(class)].albedo.unwrap_or(1.0);
        let step = scene.particles.len().div_ceil(MOST_PARTICLES).max(1);
        for (i, particle) in scene.particles.iter().enumerate().step_by(step) {
            let disc = particle.kind == ParticleKind::Droplet;
            let (radius_m, albedo) = (f64::from(particle.radius_m), albedo(particle.class));
            let ball = Ball { radius_m, area_m2: areas.of_particle(scene, i), disc, albedo };
            self.add_ball(self.frame * (particle.center_m - self.origin_m), &ball, step as f64, &mut depths);
        }
        let step = scene.fog_boxes.len().div_ceil(MOST_BOXES).max(1);
        for fog in scene.fog_boxes.iter().step_by(step) {
            let per_m = areas.extinction_per_m(scene, fog.density, fog.class, fog.droplet_radius_m);
            let (into_box, albedo) = (fog.half_edges_m.inverse(), albedo(fog.class));
            let mut is_met = false;
            for (cell, (origin_m, direction)) in self.rays().enumerate() {
                let (enter_m, way_m) = chord_m(into_box * (origin_m - fog.center_m), into_box * direction);
                if way_m > 0.0 {
                    is_met = true;
                    let place = Place { cell, at_m: enter_m + 0.5 * way_m, extent_m: way_m, albedo };
                    depths.add(place, per_m * way_m, step as f64, false);
                }
            }
            depths.misses_a_box |= !is_met;
        }
        depths
    }

    /// Adds a ball, whose centre is given in the grid's frame: to every cell whose ray meets it, or to the cell that it lies in.
    fn add_ball(&self, center: DVec3, ball: &Ball, weight: f64, depths: &mut Depths) {
        let distance_m = if self.diverges { center.length() } else { 1.0 };
        if self.diverges && distance_m <= ball.radius_m {
            let inside = 0.75 * ball.area_m2 / (PI * ball.radius_m * ball.radius_m);
            let all = 0..depths.tau.len();
            all.for_each(|cell| depths.add(ball.place(cell, 0.5 * ball.radius_m), inside, weight, false));
            return;
        }
        let scale = if self.diverges { -center.z } else { 1.0 };
        if scale <= 0.0 {
            return;
        }
        let place = [center.x, center.y].map(|x| x / scale);
        // Cells per metre, or per metre at a distance of one.
        let per = [0, 1].map(|axis| 0.5 * self.size[axis] as f64 / self.half[axis]);
        let at = [0, 1].map(|axis| (place[axis] + self.half[axis]) * per[axis]);
        let radius = [0, 1].map(|axis| ball.radius_m / distance_m.max(scale) * per[axis]);
        if radius[0].max(radius[1]) < 1.0 {
            let inside = (0..2).all(|axis| at[axis] >= 0.0 && at[axis] < self.size[axis] as f64);
            if inside {
                let added = ball.area_m2 / (distance_m * distance_m) * per[0] * per[1];
                let cell = at[1] as usize * self.size[0] + at[0] as usize;
                depths.add(ball.place(cell, -center.z), added, weight, ball.disc);
            }
            return;
        }
        let span = |axis: usize| {
            let low = (at[axis] - radius[axis] - 0.5).ceil().max(0.0) as usize;
            let high = (at[axis] + radius[axis] + 0.5).floor().clamp(0.0, self.size[axis] as f64) as usize;
            low..high.max(low)
        };
        for row in span(1) {
            for column in span(0) {
                let (start, direction) = self.ray(column, row);
                let offset = (center - start).cross(direction).length_squared() / (ball.radius_m * ball.radius_m);
                if offset < 1.0 {
                    // A ball's chord is 3/2 of its mean in the middle.
                    let profile = if ball.disc { 1.0 } else { 1.5 * (1.0 - offset).sqrt() };
                    let added = profile * ball.area_m2 / (PI * ball.radius_m * ball.radius_m);
                    let place = ball.place(row * self.size[0] + column, -center.z);
                    depths.add(place, added, weight, ball.disc);
                }
            }
        }
    }
}

impl Depths {
    fn add(&mut self, place: Place, added: f64, weight: f64, disc: bool) {
        let Place { cell, at_m, extent_m, albedo } = place;
        if cell >= self.tau.len() {
            return;
        }
        self.tau[cell] += weight * added;
        self.own[cell] += if disc { weight * added * added } else { 0.0 };
        self.scattering[cell] += weight * added * albedo;
        // What is spread evenly has the variance of its extent.
        for (power, moment) in [at_m, at_m * at_m + extent_m * extent_m / 12.0].into_iter().enumerate() {
            self.moments[cell][power] += weight * added * moment;
            self.scattering_moments[cell][power] += weight * added * albedo * moment;
        }
    }

    /// Share of the light that each ray loses.
    pub fn covers(&self) -> impl Iterator<Item = f64> + '_ {
        self.tau.iter().map(|tau| -(-tau).exp_m1())
    }

    /// Share of the light of each ray that is scattered and not absorbed, where no albedo but those that a scene sets is known.
    pub fn scattered(&self) -> impl Iterator<Item = f64> + '_ {
        let albedo = |(scattering, tau): (&f64, &f64)| if *tau > 0.0 { scattering / tau } else { 0.0 };
        self.covers().zip(self.scattering.iter().zip(&self.tau).map(albedo)).map(|(cover, albedo)| cover * albedo)
    }

    /// Collisions of a path that begins along each ray. In a cloud that absorbs nothing the mean way is that of a straight line, however
    /// light is scattered (Blanco & Fournier 2003); with an albedo w a path has 1 / (1 - w) collisions at most.
    pub fn collisions(&self) -> impl Iterator<Item = f64> + '_ {
        let most = |scattering: f64, tau: f64| if scattering < tau { tau / (tau - scattering) } else { f64::INFINITY };
        self.tau.iter().zip(&self.scattering).map(move |(tau, scattering)| tau.min(most(*scattering, *tau)))
    }

    /// Mean and variance of the distance along a ray of all that lies there, m and m^2; 0 where nothing does.
    pub fn place(&self, cell: usize) -> (f64, f64) {
        place(self.tau[cell], self.moments[cell])
    }

    /// The same of what scatters.
    pub fn scattering_place(&self, cell: usize) -> (f64, f64) {
        place(self.scattering[cell], self.scattering_moments[cell])
    }

    /// Optical depth of what a droplet of the cell has before and behind it, itself left out.
    pub fn of_others(&self) -> impl Iterator<Item = f64> + '_ {
        self.tau.iter().zip(&self.own).map(|(tau, own)| if *tau > 0.0 { (tau - own / tau).max(0.0) } else { 0.0 })
    }
}

fn place(weight: f64, [first, second]: [f64; 2]) -> (f64, f64) {
    if weight <= 0.0 {
        return (0.0, 0.0);
    }
    let mean_m = first / weight;
    (mean_m, (second / weight - mean_m * mean_m).max(0.0))
}

struct Ball {
    radius_m: f64,
    area_m2: f64,
    disc: bool,
    albedo: f64,
}

impl Ball {
    fn place(&self, cell: usize, at_m: f64) -> Place {
        Place { cell, at_m, extent_m: if self.disc { 0.0 } else { self.radius_m }, albedo: self.albedo }
    }
}

/// Where along which ray something is met, and how much of what it takes it scatters.
#[derive(Clone, Copy)]
struct Place {
    cell: usize,
    at_m: f64,
    extent_m: f64,
    albedo: f64,
}

/// Where a line from its origin on enters the cube of half edges 1, and how long it stays, in lengths of its direction.
fn chord_m(origin: DVec3, direction: DVec3) -> (f64, f64) {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        let (a, b) = ((-1.0 - o) / d, (1.0 - o) / d);
        if d == 0.0 {
            if o.abs() > 1.0 {
                return (0.0, 0.0);
            }
            continue;
        }
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    (enter, if leave.is_finite() { (leave - enter).max(0.0) } else { 0.0 })
}
