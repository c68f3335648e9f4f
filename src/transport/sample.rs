//! One sample of one pixel: a camera ray, and every layer of light that comes along it.

use super::camera::camera_ray;
use super::collision::Stretch;
use super::direct::add_direct;
use super::lighting::Lighting;
use super::march::add_airlight;
use super::media::Media;
use super::random::{PathRandom, Purpose};
use super::render::RayCounts;
use super::transmittance::OpticalDepth;
use crate::accel::{Accel, Body, Crossing, LocalRay};
use crate::film::{Layer, Sample};
use crate::plan::Switches;
use crate::scene::model::Camera;

/// What every sample reads.
#[derive(Clone, Copy)]
pub struct RenderContext<'a> {
    /// Everything that a ray can meet.
    pub accel: &'a Accel,
    /// What it does to light.
    pub media: &'a Media,
    /// The light.
    pub lighting: &'a Lighting,
    /// The camera.
    pub camera: &'a Camera,
    /// Which effects are simulated.
    pub switches: Switches,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
}

/// Buffers of one thread, reused from path to path.
pub(super) struct Scratch {
    pub weight: Vec<f64>,
    pub sigma: Vec<f64>,
    /// Size bins that act at a place, with droplets per cubic metre.
    pub acting: Vec<(u32, f64)>,
    pub stretches: Vec<Stretch>,
    /// Optical depth of the whole camera ray.
    pub total_depth: Vec<f64>,
    /// Transmittance toward the sun that was asked last.
    pub sunlit: Vec<f64>,
    pub direct: Vec<f64>,
    pub airlight: Vec<f64>,
    pub background: Vec<f64>,
    /// The layers' sum by wavelength.
    pub spectrum: Vec<f64>,
    pub crossings: Vec<(Body, Crossing)>,
    pub sun_depth: OpticalDepth,
    pub camera_depth: OpticalDepth,
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
            sigma: zeros(),
            acting: Vec::new(),
            stretches: Vec::new(),
            total_depth: zeros(),
            sunlit: zeros(),
            direct: zeros(),
            airlight: zeros(),
            background: zeros(),
            spectrum: zeros(),
            crossings: Vec::new(),
            sun_depth: OpticalDepth::new(media),
            camera_depth: OpticalDepth::new(media),
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
            *sum = self.direct[w] + self.airlight[w] + self.background[w];
        }
    }

    fn clear(&mut self) {
        for layer in [&mut self.direct, &mut self.airlight, &mut self.background] {
            layer.fill(0.0);
        }
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
    let Scratch { crossings, camera_depth, total_depth, .. } = scratch;
    ctx.accel.all(&ray, 0.0, f64::INFINITY, |body, crossing| crossings.push((*body, crossing)));
    total_depth.copy_from_slice(camera_depth.past(ctx.media, crossings, f64::INFINITY));
    if ctx.switches.direct && !scratch.crossings.is_empty() {
        add_direct(ctx, &ray, random, scratch);
    }
    if ctx.switches.airlight {
        add_airlight(ctx, &ray, random, scratch);
    }
    finish(ctx, scratch)
}

/// Adds the background and turns wavelengths into channels.
fn finish(ctx: &RenderContext, scratch: &mut Scratch) -> Sample {
    let lighting = ctx.lighting;
    let Scratch { total_depth, background, .. } = scratch;
    // From here on, depth has become transmittance.
    total_depth.iter_mut().for_each(|depth| *depth = (-*depth).exp());
    let droplets = &total_depth[..];
    let air = if ctx.switches.air { lighting.air.transmittance(f64::INFINITY) } else { 1.0 };
    let mut passed_luminance = 0.0;
    let mut transmittance = [0.0; 3];
    for w in 0..background.len() {
        let passed = droplets[w] * air;
        passed_luminance += lighting.luminance_weights[w] * passed;
        if ctx.switches.background {
            background[w] = passed * lighting.background[w];
        }
    }
    for (c, transmittance) in transmittance.iter_mut().enumerate() {
        *transmittance = lighting.channel_mean(c, droplets) * air;
    }
    scratch.sum_spectrum();
    let mut sample = Sample {
        transmittance,
        opacity: 1.0 - passed_luminance,
        depth_sum_m: scratch.depth_sum,
        depth_weight: scratch.depth_weight,
        ..Sample::default()
    };
    sample.layers[Layer::Direct as usize] = lighting.rgb(&scratch.direct);
    sample.layers[Layer::Airlight as usize] = lighting.rgb(&scratch.airlight);
    sample.layers[Layer::Background as usize] = lighting.rgb(&scratch.background);
    sample
}
