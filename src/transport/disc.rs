//! The suns' discs in a perspective camera's picture: how much of a pixel a disc fills is found by many points, of which one is followed.
//!
//! The disc is thousands of times brighter than all else, so that a point of a pixel drawn by chance tells little. Legend: E, irradiance;
//! A cos^3 theta, a pixel's solid angle; theory (146).

use glam::{DVec2, DVec3};

use super::camera::{CameraRay, camera_ray};
use super::flight::meet;
use super::lighting::SunLight;
use super::path::turn_h;
use super::random::PathRandom;
use super::sample::RenderContext;
use super::scratch::Scratch;
use crate::film::Layer;
use crate::scene::model::{Camera, Lens};

/// Points per sample are STRATA^2: a filled share is known to some percent then.
const STRATA: u32 = 8;

/// What a perspective camera makes of directions.
struct Lookup<'a> {
    camera: &'a Camera,
    resolution: [u32; 2],
    size: DVec2,
    /// Half the picture's width and height at distance 1.
    half: DVec2,
}

impl<'a> Lookup<'a> {
    /// `None` for cameras whose rays are parallel: they see a disc everywhere or nowhere.
    fn new(ctx: &RenderContext<'a>) -> Option<Self> {
        let size = DVec2::new(f64::from(ctx.resolution[0]), f64::from(ctx.resolution[1]));
        match ctx.camera.lens {
            Lens::Perspective { yfov_rad, .. } => {
                let up = (0.5 * yfov_rad).tan();
                let half = DVec2::new(up * size.x / size.y, up);
                Some(Self { camera: ctx.camera, resolution: ctx.resolution, size, half })
            }
            Lens::Orthographic { .. } => None,
        }
    }

    /// Where in the picture a direction lies, pixels from the top left corner, and the cosine from the camera's axis; `None` behind it.
    fn pixel(&self, direction: DVec3) -> Option<(DVec2, f64)> {
        let local = self.camera.world_from_camera.transpose() * direction;
        let cos = -local.z;
        let at = DVec2::new(local.x, -local.y) / (cos * self.half);
        (cos > 0.0).then(|| (0.5 * self.size * (at + 1.0), cos))
    }

    /// Solid angle of a pixel in a direction of the given cosine, sr.
    fn pixel_sr(&self, cos: f64) -> f64 {
        4.0 * self.half.x * self.half.y / (self.size.x * self.size.y) * cos.powi(3)
    }

    /// Whether some of a disc may lie in a pixel that a ray goes through: chords between unit vectors are no longer than those of the picture's
    /// plane, and the longest of a pixel is its diagonal.
    fn may_touch(&self, sun: &SunLight, direction: DVec3) -> bool {
        let diagonal = (2.0 * self.half / self.size).length();
        (direction + sun.direction).length() <= (2.0 * sun.disc_h).sqrt() + diagonal
    }
}

/// Whether `add_discs` looks after the discs.
pub(super) fn draws_discs(ctx: &RenderContext) -> bool {
    Lookup::new(ctx).is_some()
}

/// Adds the light of the discs that reaches a pixel past droplets and air, where no glass is in the way; `direction` is that of a ray through the
/// pixel.
pub(super) fn add_discs(
    ctx: &RenderContext,
    pixel: [u32; 2],
    direction: DVec3,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    if ctx.lighting.suns.iter().all(SunLight::is_point) {
        return;
    }
    let Some(lookup) = Lookup::new(ctx) else { return };
    let corner = DVec2::new(f64::from(pixel[0]), f64::from(pixel[1]));
    let is_near = |sun: &&SunLight| !sun.is_point() && lookup.may_touch(sun, direction);
    for sun in ctx.lighting.suns.iter().filter(is_near) {
        if let Some((ray, radiance)) = look(&lookup, sun, corner, random, scratch) {
            add(ctx, sun, &ray, radiance, scratch);
        }
    }
}

/// A ray to the part of a disc that lies in a pixel, and the pixel's mean radiance for a unit of irradiance, were nothing in the way.
fn look(
    lookup: &Lookup,
    sun: &SunLight,
    corner: DVec2,
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Option<(CameraRay, f64)> {
    // Points are drawn on whichever is smaller, and count where they lie in the other.
    let is_small = lookup.pixel(-sun.direction).is_some_and(|(_, cos)| sun.disc_per_sr() * lookup.pixel_sr(cos) > 1.0);
    let (mut n, mut chosen) = (0.0, None);
    for i in 0..STRATA * STRATA {
        let u = scratch.draw_on_disc(random);
        let place = DVec2::new(f64::from(i / STRATA) + u[0], f64::from(i % STRATA) + u[1]) / f64::from(STRATA);
        let found = match is_small {
            true => lookup.on_disc(sun, corner, place),
            false => lookup.in_pixel(sun, corner, place),
        };
        let Some((ray, radiance)) = found else { continue };
        n += 1.0;
        // Each is the one that is kept in the end with the same chance.
        let [keep, _] = scratch.draw_on_disc(random);
        if keep * n < 1.0 {
            chosen = Some((ray, radiance));
        }
    }
    // One stands for n of all points.
    chosen.map(|(ray, radiance)| (ray, radiance * n / f64::from(STRATA * STRATA)))
}

impl Lookup<'_> {
    /// A point of the disc, if it lies in the pixel.
    fn on_disc(&self, sun: &SunLight, corner: DVec2, place: DVec2) -> Option<(CameraRay, f64)> {
        let (at, cos) = self.pixel(sun.toward(place.to_array()))?;
        let inside = at - corner;
        let is_inside = inside.min_element() >= 0.0 && inside.max_element() < 1.0;
        is_inside.then(|| (camera_ray(self.camera, self.resolution, at.x, at.y), 1.0 / self.pixel_sr(cos)))
    }

    /// A point of the pixel, if it lies on the disc.
    fn in_pixel(&self, sun: &SunLight, corner: DVec2, place: DVec2) -> Option<(CameraRay, f64)> {
        let at = corner + place;
        let ray = camera_ray(self.camera, self.resolution, at.x, at.y);
        (turn_h(ray.direction, -sun.direction) <= sun.disc_h).then(|| (ray, sun.disc_per_sr()))
    }
}

/// Adds what comes along a ray from a disc.
fn add(ctx: &RenderContext, sun: &SunLight, ray: &CameraRay, radiance: f64, scratch: &mut Scratch) {
    let ray = ctx.accel.local_ray(ray.origin_m, ray.direction);
    if ctx.glass.is_some_and(|glass| glass.ahead(&ray, None).is_some()) {
        return;
    }
    scratch.rays.shadow += 1;
    let radiance = radiance * ctx.air_transmittance(&ray, f64::INFINITY);
    // Not as shadows are: droplets that are glass hide as much as their outline, and no more.
    scratch.reach_m = f64::INFINITY;
    meet(ctx, &ray, scratch);
    let Scratch { total_depth, layers, .. } = scratch;
    let seen =
        total_depth.iter().zip(&sun.irradiance).map(|(depth, irradiance)| radiance * (-depth).exp() * irradiance);
    layers[Layer::Background as usize].iter_mut().zip(seen).for_each(|(sum, seen)| *sum += seen);
}
