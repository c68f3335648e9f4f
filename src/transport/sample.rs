//! One sample of one pixel: a camera ray, and every layer of light that comes along it.

use super::camera::camera_ray;
use super::direct::add_direct;
use super::lighting::Lighting;
use super::march::add_airlight;
use super::media::Media;
use super::random::{PathRandom, Purpose};
use super::render::RayCounts;
use super::transmittance::Transmittance;
use crate::accel::{Accel, Body, Crossing};
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
    pub share: Vec<f64>,
    pub direct: Vec<f64>,
    pub airlight: Vec<f64>,
    pub background: Vec<f64>,
    /// The layers' sum by wavelength.
    pub spectrum: Vec<f64>,
    pub crossings: Vec<(Body, Crossing)>,
    pub transmittance: Transmittance,
    pub camera_transmittance: Transmittance,
    pub depth_sum: f64,
    pub depth_weight: f64,
    pub rays: RayCounts,
}

impl Scratch {
    pub fn new(n_wavelengths: usize) -> Self {
        let zeros = || vec![0.0; n_wavelengths];
        Self {
            weight: zeros(),
            share: zeros(),
            direct: zeros(),
            airlight: zeros(),
            background: zeros(),
            spectrum: zeros(),
            crossings: Vec::new(),
            transmittance: Transmittance::new(n_wavelengths),
            camera_transmittance: Transmittance::new(n_wavelengths),
            depth_sum: 0.0,
            depth_weight: 0.0,
            rays: RayCounts::default(),
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
    let Scratch { crossings, .. } = scratch;
    ctx.accel.all(&ray, 0.0, f64::INFINITY, |body, crossing| crossings.push((*body, crossing)));
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
    let Scratch { camera_transmittance, crossings, background, .. } = scratch;
    let droplets = camera_transmittance.past(ctx.media, crossings, f64::INFINITY);
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
