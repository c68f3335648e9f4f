//! `airlight`: sunlight that the air scatters once, marched along the camera ray.
//!
//! Steps are equal and at most `step_m` long; the sample lies at random in each, so a coarse step is noise and never a
//! bias.

use super::random::{PathRandom, Purpose};
use super::sample::{RenderContext, Scratch};
use crate::accel::LocalRay;
use crate::film::Layer;

/// Adds the airlight along a camera ray; `scratch.crossings` holds what the ray meets.
pub(super) fn add_airlight(ctx: &RenderContext, ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    let air = &ctx.lighting.air;
    let n_steps = (air.depth_m / air.step_m).ceil().max(1.0) as u32;
    let step_m = air.depth_m / f64::from(n_steps);
    for step in 0..n_steps {
        let t_m = (f64::from(step) + random.uniform(Purpose::March, step)) * step_m;
        let scattered = air.scattering_per_m * step_m * air.transmittance(t_m);
        add_sample(ctx, ray, t_m, scattered, scratch);
    }
}

/// One sample of the march: what the suns send there, scattered to the camera, weakened on the way.
fn add_sample(ctx: &RenderContext, ray: &LocalRay, t_m: f64, scattered: f64, scratch: &mut Scratch) {
    let air = &ctx.lighting.air;
    let point = ray.origin + t_m * ray.direction;
    let Scratch { path_depth, crossings, weight, .. } = scratch;
    for (seen, depth) in weight.iter_mut().zip(path_depth.past(ctx.media, crossings, t_m)) {
        *seen = scattered * (-depth).exp();
    }
    if weight.iter().all(|seen| *seen <= 0.0) {
        return;
    }
    for sun in &ctx.lighting.suns {
        let h = 0.5 * (sun.direction + ray.direction).length_squared();
        let sun_ray = LocalRay { origin: point, direction: -sun.direction };
        scratch.light_sun(ctx, &sun_ray);
        let Scratch { layers, weight, sunlit, .. } = scratch;
        for (w, radiance) in layers[Layer::Airlight as usize].iter_mut().enumerate() {
            *radiance += weight[w] * sunlit[w] * air.phase[w].eval(h) * sun.irradiance[w];
        }
    }
}
