//! The diffusion equation in the averaged cloud, solved by conjugate gradients (theory (123)).
//!
//! Legend: phi, fluence of scattered light; D = 1 / (3 sigma'), diffusion coefficient; sigma_a, absorption; E, irradiance of a
//! sun; tau', reduced optical depth toward it; B, mean radiance of the surroundings.

use std::f64::consts::PI;

use glam::DVec3;

use super::cells::{Cells, N};

/// The iteration ends where the residual has fallen by this: light deep in an absorbing cloud is that faint.
const RESIDUAL: f64 = 1e-10;

/// And after so many steps in any case.
const MOST_STEPS: usize = 300;

/// The system of equations: seven points, symmetric and positive.
struct Stencil {
    /// Conductance between a cell and its neighbour in +x, +y, +z; 0 at the end.
    between: [Vec<f64>; 3],
    diagonal: Vec<f64>,
}

/// What falls on the cloud, in the mean over the wavelengths.
pub(super) struct Light {
    /// Direction in which each sun's light travels, and E.
    pub suns: Vec<(DVec3, f64)>,
    /// B.
    pub surroundings: f64,
}

/// Fluence of scattered and unscattered light in each cell, in the units of the irradiance.
pub(super) fn fluence(cells: &Cells, light: &Light) -> Vec<f64> {
    let volume_m3 = cells.size_m.element_product();
    let reach_m = cells.size_m.length() * N as f64;
    let diffusion: Vec<f64> =
        cells.reduced.iter().map(|[extinction, _]| 1.0 / (3.0 * extinction.max(1.0 / reach_m))).collect();
    let direct = sunlight(cells, &light.suns);
    let mut source: Vec<f64> =
        cells.reduced.iter().zip(&direct).map(|([_, scattering], light)| volume_m3 * scattering * light).collect();
    let stencil = Stencil::new(cells, &diffusion, 4.0 * PI * light.surroundings, &mut source);
    let mut phi = stencil.solve(&source);
    phi.iter_mut().zip(&direct).for_each(|(phi, direct)| *phi += direct);
    phi
}

/// Irradiance of unscattered sunlight in each cell, in the mean over it.
fn sunlight(cells: &Cells, suns: &[(DVec3, f64)]) -> Vec<f64> {
    let mut light = vec![0.0; N * N * N];
    for (direction, irradiance) in suns {
        // Cells as units: half a cell along the axis on which the way is longest.
        let per_cell = -*direction / cells.size_m;
        let step_m = 0.5 / per_cell.abs().max_element();
        let step = per_cell * step_m;
        for (index, light) in light.iter_mut().enumerate() {
            let own = 2.0 * step_m * cells.reduced[index][0];
            let mut at = center_of(index) + 1.5 * step;
            let mut depth = 0.0;
            while at.min_element() >= 0.0 && at.max_element() < N as f64 {
                let [x, y, z] = at.as_uvec3().to_array().map(|i| i as usize);
                depth += step_m * cells.reduced[x + N * (y + N * z)][0];
                at += step;
            }
            let within = if own > 1e-9 { -(-own).exp_m1() / own } else { 1.0 };
            *light += irradiance * (-depth).exp() * within;
        }
    }
    light
}

/// A cell's centre with cells as units.
fn center_of(index: usize) -> DVec3 {
    DVec3::new((index % N) as f64, (index / N % N) as f64, (index / (N * N)) as f64) + 0.5
}

impl Stencil {
    /// Sets up the conductances; light that enters through the outer faces is added to `source`.
    fn new(cells: &Cells, diffusion: &[f64], surroundings: f64, source: &mut [f64]) -> Self {
        let size = cells.size_m.to_array();
        let volume_m3 = cells.size_m.element_product();
        let mut diagonal: Vec<f64> = cells.reduced.iter().map(|[t, s]| volume_m3 * (t - s).max(0.0)).collect();
        let mut between = [const { Vec::new() }; 3];
        for (axis, between) in between.iter_mut().enumerate() {
            let (stride, h) = (N.pow(axis as u32), size[axis]);
            let face_m2 = volume_m3 / h;
            between.resize(N * N * N, 0.0);
            for index in 0..N * N * N {
                let place = index / stride % N;
                if place + 1 < N {
                    let conductance = 2.0 * face_m2 / (h * (1.0 / diffusion[index] + 1.0 / diffusion[index + stride]));
                    between[index] = conductance;
                    diagonal[index] += conductance;
                    diagonal[index + stride] += conductance;
                }
                // Marshak's condition: no more comes in than the surroundings send.
                let outer = face_m2 / (0.5 * h / diffusion[index] + 2.0);
                let n_outer = f64::from(u8::from(place == 0) + u8::from(place + 1 == N));
                diagonal[index] += n_outer * outer;
                source[index] += n_outer * outer * surroundings;
            }
        }
        Self { between, diagonal }
    }

    fn apply(&self, x: &[f64], out: &mut [f64]) {
        for ((out, x), diagonal) in out.iter_mut().zip(x).zip(&self.diagonal) {
            *out = diagonal * x;
        }
        for (axis, between) in self.between.iter().enumerate() {
            let stride = N.pow(axis as u32);
            for index in 0..x.len() - stride {
                out[index] -= between[index] * x[index + stride];
                out[index + stride] -= between[index] * x[index];
            }
        }
    }

    /// Conjugate gradients, preconditioned by the diagonal (Hestenes & Stiefel 1952).
    fn solve(&self, source: &[f64]) -> Vec<f64> {
        let n = source.len();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(&self.diagonal).map(|(r, d)| r / d).collect() };
        let (mut x, mut residual) = (vec![0.0; n], source.to_vec());
        let mut toward = scaled(&residual);
        let mut product = vec![0.0; n];
        let mut size = dot(&residual, &toward);
        let enough = RESIDUAL * RESIDUAL * size;
        for _ in 0..MOST_STEPS {
            if size <= enough {
                break;
            }
            self.apply(&toward, &mut product);
            let step = size / dot(&toward, &product);
            for i in 0..n {
                x[i] += step * toward[i];
                residual[i] -= step * product[i];
            }
            let next = scaled(&residual);
            let new_size = dot(&residual, &next);
            let keep = new_size / size;
            toward.iter_mut().zip(&next).for_each(|(toward, next)| *toward = next + keep * *toward);
            size = new_size;
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(extinction: f64, scattering: f64, size_m: DVec3) -> Cells {
        Cells::of(DVec3::ZERO, size_m, vec![[extinction, scattering]; N * N * N])
    }

    /// Deep inside, light falls by the diffusion length: of the seven-point equation, (k h)^2 / 2 = cosh(q h) - 1.
    #[test]
    fn light_falls_by_the_diffusion_length() {
        let (extinction, scattering, h) = (1.0, 0.97, 1.0);
        let cells = even(extinction, scattering, DVec3::new(1e3, 1e3, h));
        let light = fluence(&cells, &Light { suns: vec![(DVec3::NEG_Z, 1.0)], surroundings: 0.0 });
        let k = (3.0f64 * extinction * (extinction - scattering)).sqrt();
        let per_cell = (-(1.0 + 0.5 * (k * h).powi(2)).acosh()).exp();
        let at = |z: usize| light[N / 2 + N * (N / 2 + N * z)];
        for z in 10..14 {
            assert!((at(z) / at(z + 1) / per_cell - 1.0).abs() < 2e-3, "{z}: {} {per_cell}", at(z) / at(z + 1));
        }
    }

    /// What is scattered first is absorbed, or leaves through the outer faces as phi / (2 + h / 2D) each.
    #[test]
    fn energy_is_kept() {
        let (extinction, scattering, size) = (2.0, 1.5, DVec3::new(0.1, 0.2, 0.4));
        let cells = even(extinction, scattering, size);
        let suns = vec![(DVec3::new(0.6, 0.0, -0.8), 3.0), (DVec3::Y, 0.5)];
        let direct = sunlight(&cells, &suns);
        let light = fluence(&cells, &Light { suns, surroundings: 0.0 });
        let volume_m3 = size.element_product();
        let (mut gone, mut born) = (0.0, 0.0);
        for (index, (light, direct)) in light.iter().zip(&direct).enumerate() {
            let scattered = light - direct;
            born += volume_m3 * scattering * direct;
            gone += volume_m3 * (extinction - scattering) * scattered;
            for (axis, h) in size.to_array().into_iter().enumerate() {
                let place = index / N.pow(axis as u32) % N;
                if place == 0 || place + 1 == N {
                    gone += volume_m3 / h * scattered / (2.0 + 1.5 * h * extinction);
                }
            }
        }
        assert!((gone / born - 1.0).abs() < 1e-8, "{gone} {born}");
    }

    /// In surroundings of one radiance a cloud that does not absorb is as bright as they are: phi = 4 pi B.
    #[test]
    fn a_furnace_is_even() {
        let cells = even(3.0, 3.0, DVec3::new(0.1, 0.3, 1.0));
        for light in fluence(&cells, &Light { suns: Vec::new(), surroundings: 0.7 }) {
            assert!((light / (4.0 * PI * 0.7) - 1.0).abs() < 1e-8);
        }
    }
}
