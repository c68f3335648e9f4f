//! One sample of one pixel: a camera ray, and every layer of light that comes along it.

use super::camera::camera_ray;
use super::chain::Aside;
use super::collision::Finder;
use super::event::{Event, Turn};
use super::flight::meet;
use super::forward::ForwardLobes;
use super::lighting::Lighting;
use super::march::add_airlight;
use super::media::Media;
use super::path::add_path;
use super::random::{PathRandom, Purpose};
use super::render::RayCounts;
use super::transmittance::OpticalDepth;
use crate::accel::{Accel, Body, Crossing, LocalRay};
use crate::film::{Layer, Sample};
use crate::plan::Switches;
use crate::scene::model::Camera;
use glam::DVec3;

/// What every sample reads.
#[derive(Clone, Copy)]
pub struct RenderContext<'a> {
    /// Everything that a ray can meet.
    pub accel: &'a Accel,
    /// What it does to light.
    pub media: &'a Media,
    /// The forward lobe that the droplets have in common, where they have one.
    pub(super) lobes: Option<&'a ForwardLobes>,
    /// The light.
    pub lighting: &'a Lighting,
    /// The camera.
    pub camera: &'a Camera,
    /// Which effects are simulated.
    pub switches: Switches,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Most times that light is scattered by droplets; at least 1.
    pub max_order: u32,
}

impl RenderContext<'_> {
    /// Where a ray runs through the ball of air about the camera, m; the same twice where it does not.
    pub(super) fn way_in_air(&self, ray: &LocalRay) -> (f64, f64) {
        let camera = self.accel.local_ray(self.camera.position_m, ray.direction).origin;
        way_in_ball(ray, camera, self.lighting.air.depth_m)
    }

    /// Transmittance of the air over the first `t_m` metres of a ray.
    pub(super) fn air_transmittance(&self, ray: &LocalRay, t_m: f64) -> f64 {
        if !self.switches.air {
            return 1.0;
        }
        let (enter_m, leave_m) = self.way_in_air(ray);
        self.lighting.air.transmittance((leave_m.min(t_m) - enter_m).max(0.0))
    }
}

/// Where a ray enters and leaves a ball, m from its origin; the same twice where it misses it.
fn way_in_ball(ray: &LocalRay, center: DVec3, radius_m: f64) -> (f64, f64) {
    let to_center = center - ray.origin;
    let middle = to_center.dot(ray.direction);
    let rest = radius_m * radius_m - (to_center - middle * ray.direction).length_squared();
    let half = rest.max(0.0).sqrt();
    let enter_m = (middle - half).max(0.0);
    (enter_m, (middle + half).max(enter_m))
}

/// Buffers of one thread, reused from path to path.
pub(super) struct Scratch {
    /// Weight of the path, by wavelength.
    pub weight: Vec<f64>,
    /// Density with which each wavelength would have drawn the path, over their mean.
    pub density: Vec<f64>,
    /// What the last turn that was asked about is worth.
    pub turned: Turn,
    /// What a look at the sun is worth, without its light.
    pub looked: Vec<f64>,
    /// Share of the path whose turns all belong to the common forward lobe.
    pub small_turns: Vec<f64>,
    /// Sum of the rarities of its turns.
    pub rarity: f64,
    /// The chain toward the sun.
    pub aside: Aside,
    /// The collision that the path is at.
    pub event: Event,
    pub finder: Finder,
    /// Optical depth of the whole ray that was followed last.
    pub total_depth: Vec<f64>,
    /// Transmittance toward the sun that was asked last.
    pub sunlit: Vec<f64>,
    /// Radiance by layer and wavelength.
    pub layers: [Vec<f64>; Layer::ALL.len()],
    /// The layers' sum by wavelength.
    pub spectrum: Vec<f64>,
    pub crossings: Vec<(Body, Crossing)>,
    pub sun_depth: OpticalDepth,
    pub path_depth: OpticalDepth,
    pub depth_sum: f64,
    pub depth_weight: f64,
    pub rays: RayCounts,
}

impl Scratch {
    pub fn new(media: &Media) -> Self {
        let n_wavelengths = media.n_wavelengths();
        let zeros = || vec![0.0; n_wavelengths];
        Self {
            weight: zeros(),
            density: zeros(),
            turned: Turn::new(n_wavelengths),
            looked: zeros(),
            small_turns: zeros(),
            rarity: 0.0,
            aside: Aside::new(n_wavelengths),
            event: Event::new(n_wavelengths),
            finder: Finder::default(),
            total_depth: zeros(),
            sunlit: zeros(),
            layers: Layer::ALL.map(|_| zeros()),
            spectrum: zeros(),
            crossings: Vec::new(),
            sun_depth: OpticalDepth::new(media),
            path_depth: OpticalDepth::new(media),
            depth_sum: 0.0,
            depth_weight: 0.0,
            rays: RayCounts::default(),
        }
    }

    /// Fills `sunlit` with the transmittance toward a sun: 1 where droplets cast no shadows.
    pub fn light_sun(&mut self, ctx: &RenderContext, sun_ray: &LocalRay) {
        if !ctx.switches.shadows {
            self.sunlit.fill(1.0);
            return;
        }
        self.rays.shadow += 1;
        let depth = self.sun_depth.along(ctx.accel, ctx.media, sun_ray, f64::INFINITY);
        for (lit, depth) in self.sunlit.iter_mut().zip(depth) {
            *lit = (-depth).exp();
        }
    }

    fn sum_spectrum(&mut self) {
        for (w, sum) in self.spectrum.iter_mut().enumerate() {
            *sum = self.layers.iter().map(|layer| layer[w]).sum();
        }
    }

    fn clear(&mut self) {
        self.layers.iter_mut().for_each(|layer| layer.fill(0.0));
        self.crossings.clear();
        (self.depth_sum, self.depth_weight) = (0.0, 0.0);
    }
}

/// Takes one sample of a pixel; `pixel` counts from the top left corner of the whole picture.
pub(super) fn take_sample(
    ctx: &RenderContext,
    [column, row]: [u32; 2],
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Sample {
    scratch.clear();
    let x = f64::from(column) + random.uniform(Purpose::PixelX, 0);
    let y = f64::from(row) + random.uniform(Purpose::PixelY, 0);
    let camera_ray = camera_ray(ctx.camera, ctx.resolution, x, y);
    let ray = ctx.accel.local_ray(camera_ray.origin_m, camera_ray.direction);
    scratch.rays.camera += 1;
    // What the ray meets, all of it: its transmittance is exact, and empty rays end here.
    meet(ctx, &ray, scratch);
    let mut sample = Sample::default();
    see_through(ctx, &ray, scratch, &mut sample);
    if ctx.switches.airlight {
        add_airlight(ctx, &ray, random, scratch);
    }
    if ctx.switches.direct && !scratch.crossings.is_empty() {
        add_path(ctx, &ray, random, scratch);
    }
    scratch.sum_spectrum();
    for (channels, radiance) in sample.layers.iter_mut().zip(&scratch.layers) {
        *channels = ctx.lighting.rgb(radiance);
    }
    (sample.depth_sum_m, sample.depth_weight) = (scratch.depth_sum, scratch.depth_weight);
    sample
}

/// The background and the opacity, exact along the camera ray.
fn see_through(ctx: &RenderContext, ray: &LocalRay, scratch: &mut Scratch, sample: &mut Sample) {
    let lighting = ctx.lighting;
    let Scratch { total_depth, sunlit: passed, layers, .. } = scratch;
    let air = ctx.air_transmittance(ray, f64::INFINITY);
    for (passed, depth) in passed.iter_mut().zip(total_depth) {
        *passed = (-*depth).exp() * air;
    }
    if ctx.switches.background {
        for (w, radiance) in layers[Layer::Background as usize].iter_mut().enumerate() {
            *radiance = passed[w] * lighting.background[w];
        }
    }
    sample.transmittance = [0, 1, 2].map(|channel| lighting.channel_mean(channel, passed));
    let luminance: f64 = lighting.luminance_weights.iter().zip(passed).map(|(weight, passed)| weight * *passed).sum();
    sample.opacity = 1.0 - luminance;
}
