//! The march through the air along the camera ray: `airlight`, sunlight that the air scatters once, and `glow`, light
//! that droplets scatter into the air.
//!
//! Steps are equal and at most `step_m` long; the sample lies at random in each, by what the air lets pass, so a coarse
//! step is noise and never a bias, and air that is lit evenly, with no droplet before it, has no noise at all.

use super::glow;
use super::path::turn_h;
use super::random::{PathRandom, Purpose};
use super::sample::RenderContext;
use super::scratch::Scratch;
use crate::accel::LocalRay;
use crate::film::Layer;
use crate::plan::{LAST_OPTICAL_DEPTH, MOST_STEPS, march_steps};

/// What a march looks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Marched {
    airlight: bool,
    glow: bool,
}

impl Marched {
    pub const BOTH: Self = Self { airlight: true, glow: true };
    pub const AIRLIGHT: Self = Self { airlight: true, glow: false };
    pub const GLOW: Self = Self { airlight: false, glow: true };
}

/// Adds what the air scatters along a camera ray; `scratch.crossings` holds what the ray meets.
pub(super) fn march(ctx: &RenderContext, ray: &LocalRay, wanted: Marched, random: &PathRandom, scratch: &mut Scratch) {
    let air = &ctx.lighting.air;
    if air.scattering_per_m <= 0.0 {
        return;
    }
    let (enter_m, leave_m) = ctx.way_in_air(ray);
    let leave_m = leave_m.min(scratch.reach_m);
    if leave_m <= enter_m {
        return;
    }
    // Air that is lit evenly, with nothing before it, is one step: its integral is known (theory (107)).
    let (airlight, glow) = (ctx.switches.airlight && wanted.airlight, ctx.glow.filter(|_| wanted.glow));
    let is_even = !ctx.switches.shadows && glow.is_none() && scratch.crossings.is_empty();
    let (n_steps, step_m) = match is_even {
        true => (1, (leave_m - enter_m).min(LAST_OPTICAL_DEPTH / air.extinction_per_m)),
        false => march_steps(air.extinction_per_m, air.step_m, leave_m - enter_m),
    };
    let way_m = [enter_m, enter_m + f64::from(n_steps) * step_m];
    if let Some(glow) = glow {
        glow::add_near(ctx, glow, ray, way_m, n_steps, random, scratch);
        if !airlight && !glow.needs_steps() {
            return;
        }
        glow::begin_ray(ctx, glow, ray, way_m, n_steps, random, scratch);
    }
    // The share of the light of a step's end that the step itself takes.
    let taken = -(-air.extinction_per_m * step_m).exp_m1();
    for step in 0..n_steps {
        let number = scratch.leg.wrapping_mul(MOST_STEPS).wrapping_add(step);
        let u = random.uniform(Purpose::March, number);
        let start_m = f64::from(step) * step_m;
        let t_m = enter_m + start_m + (-(-u * taken).ln_1p() / air.extinction_per_m).min(step_m);
        let scattered = air.scattering_per_m / air.extinction_per_m * taken * air.transmittance(start_m);
        if !see_step(ctx, t_m, scattered, scratch) {
            continue;
        }
        if airlight {
            add_airlight(ctx, ray, t_m, random, scratch);
        }
        if let Some(glow) = glow {
            glow::add_step(ctx, glow, ray, t_m, number, random, scratch);
        }
    }
}

/// Fills `scratch.weight` with how what is scattered at `t_m` is seen; `false` where nothing of it is.
fn see_step(ctx: &RenderContext, t_m: f64, scattered: f64, scratch: &mut Scratch) -> bool {
    let Scratch { path_depth, crossings, weight, seen, .. } = scratch;
    for ((weight, depth), seen) in weight.iter_mut().zip(path_depth.past(ctx.media, crossings, t_m)).zip(seen) {
        *weight = *seen * scattered * (-depth).exp();
    }
    weight.iter().any(|weight| *weight > 0.0)
}

/// Adds what the suns send to one step.
fn add_airlight(ctx: &RenderContext, ray: &LocalRay, t_m: f64, random: &PathRandom, scratch: &mut Scratch) {
    let air = &ctx.lighting.air;
    let point = ray.origin + t_m * ray.direction;
    for sun in &ctx.lighting.suns {
        let to_sun = scratch.toward(sun, random);
        let h = turn_h(ray.direction, to_sun);
        scratch.light_sun(ctx, &LocalRay { origin: point, direction: to_sun });
        let layer = scratch.layer(Layer::Airlight);
        let Scratch { layers, weight, sunlit, .. } = scratch;
        for (w, radiance) in layers[layer].iter_mut().enumerate() {
            *radiance += weight[w] * sunlit[w] * air.phase[w].eval(h) * sun.irradiance[w];
        }
    }
}
