//! Buffers of one thread, reused from path to path, so that no path allocates: where a path is and what it has gathered.

use super::chain::Aside;
use super::collision::Finder;
use super::event::{Event, Turn};
use super::glass::Ahead;
use super::glow::GlowScratch;
use super::lighting::SunLight;
use super::random::{PathRandom, Purpose};
use super::rates::{Ask, Part};
use super::render::RayCounts;
use super::sample::RenderContext;
use super::split::Branches;
use super::transmittance::OpticalDepth;
use crate::accel::{Body, Crossing, LocalRay};
use crate::film::Layer;
use glam::DVec3;

/// Buffers of one thread, reused from path to path.
pub(super) struct Scratch {
    /// What reaches the camera from where its ray has come to, by wavelength; 1 until it meets glass.
    pub seen: Vec<f64>,
    /// The heroes' densities of the camera ray's way, over their mean.
    pub seen_density: Vec<f64>,
    /// The wavelength that draws everything.
    pub hero: usize,
    /// Balls that the camera ray has met.
    pub leg: u32,
    /// Transmittance of the camera ray's leg.
    pub passed: Vec<f64>,
    /// Radiance behind everything.
    pub behind: Vec<f64>,
    /// Whether what is followed has met glass.
    pub is_refracted: bool,
    /// Where the ray that was followed last ends: at glass, or nowhere.
    pub reach_m: f64,
    /// Surfaces of glass met so far.
    pub surfaces: u32,
    /// Points drawn on suns so far.
    pub sun_draws: u32,
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
    /// How many there were, since the camera or the glass behind which the path began anew.
    pub n_turns: u32,
    /// The chain toward the sun.
    pub aside: Aside,
    /// The collision that the path is at.
    pub event: Event,
    pub finder: Finder,
    /// Branches of the path that wait.
    pub branches: Branches,
    /// Optical depth of the whole ray that was followed last.
    pub total_depth: Vec<f64>,
    /// Transmittance toward the sun that was asked last.
    pub sunlit: Vec<f64>,
    /// How this sample asks its estimators, by `Part`.
    pub asks: [Ask; Part::ALL.len()],
    /// Radiance by layer and wavelength.
    pub layers: [Vec<f64>; Layer::ALL.len()],
    /// The same of what was gathered before, while an estimator is asked whose result is weighted.
    before: [Vec<f64>; Layer::ALL.len()],
    /// The layers' sum by wavelength.
    pub spectrum: Vec<f64>,
    pub crossings: Vec<(Body, Crossing)>,
    pub sun_depth: OpticalDepth,
    pub path_depth: OpticalDepth,
    pub glow: GlowScratch,
    pub depth_sum: f64,
    pub depth_weight: f64,
    pub rays: RayCounts,
}

impl Scratch {
    pub fn new(ctx: &RenderContext) -> Self {
        let media = ctx.media;
        let n_wavelengths = media.n_wavelengths();
        let zeros = || vec![0.0; n_wavelengths];
        Self {
            seen: zeros(),
            seen_density: zeros(),
            hero: 0,
            leg: 0,
            passed: zeros(),
            behind: zeros(),
            is_refracted: false,
            reach_m: f64::INFINITY,
            surfaces: 0,
            sun_draws: 0,
            weight: zeros(),
            density: zeros(),
            turned: Turn::new(n_wavelengths),
            looked: zeros(),
            small_turns: zeros(),
            rarity: 0.0,
            n_turns: 0,
            aside: Aside::new(n_wavelengths),
            event: Event::new(n_wavelengths),
            finder: Finder::default(),
            branches: Branches::default(),
            total_depth: zeros(),
            sunlit: zeros(),
            asks: [Ask { times: 1, weight: 1.0 }; Part::ALL.len()],
            layers: Layer::ALL.map(|_| zeros()),
            before: Layer::ALL.map(|_| zeros()),
            spectrum: zeros(),
            crossings: Vec::new(),
            sun_depth: OpticalDepth::new(media),
            path_depth: OpticalDepth::new(media),
            glow: GlowScratch::new(n_wavelengths, ctx.lighting.suns.len()),
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

    /// The ball ahead of a ray that has just left another one, and with it `reach_m`.
    pub fn look_ahead(&mut self, ctx: &RenderContext, ray: &LocalRay, left: Option<u32>) -> Option<Ahead> {
        let ahead = ctx.glass.and_then(|glass| glass.ahead(ray, left));
        self.reach_m = ahead.map_or(f64::INFINITY, |ahead| ahead.t_m);
        ahead
    }

    /// The layer of what is followed: all that has met glass is `refraction`.
    #[inline]
    pub fn layer(&self, layer: Layer) -> usize {
        if self.is_refracted { Layer::Refraction as usize } else { layer as usize }
    }

    /// A direction to a sun, somewhere on its disc.
    #[inline]
    pub fn toward(&mut self, sun: &SunLight, random: &PathRandom) -> DVec3 {
        if sun.is_point() {
            return -sun.direction;
        }
        let u = self.draw_on_disc(random);
        sun.toward(u)
    }

    /// Two even numbers in [0, 1) for a place on a sun's disc.
    #[inline]
    pub fn draw_on_disc(&mut self, random: &PathRandom) -> [f64; 2] {
        self.sun_draws += 1;
        [Purpose::SunHeight, Purpose::SunTurn].map(|purpose| random.uniform(purpose, self.sun_draws))
    }

    /// Adds to the layers what `gather` adds, times a weight.
    pub fn weighted(&mut self, weight: f64, gather: impl FnOnce(&mut Self)) {
        if weight == 1.0 {
            return gather(self);
        }
        std::mem::swap(&mut self.layers, &mut self.before);
        self.layers.iter_mut().for_each(|layer| layer.fill(0.0));
        let depth = std::mem::take(&mut self.depth_sum);
        let depth_weight = std::mem::take(&mut self.depth_weight);
        gather(self);
        for (layer, before) in self.layers.iter_mut().zip(&self.before) {
            layer.iter_mut().zip(before).for_each(|(radiance, before)| *radiance = *before + weight * *radiance);
        }
        self.depth_sum = depth + weight * self.depth_sum;
        self.depth_weight = depth_weight + weight * self.depth_weight;
    }

    pub fn sum_spectrum(&mut self) {
        for (w, sum) in self.spectrum.iter_mut().enumerate() {
            *sum = self.layers.iter().map(|layer| layer[w]).sum();
        }
    }

    pub fn clear(&mut self) {
        self.layers.iter_mut().for_each(|layer| layer.fill(0.0));
        self.crossings.clear();
        (self.depth_sum, self.depth_weight) = (0.0, 0.0);
        (self.leg, self.surfaces, self.sun_draws) = (0, 0, 0);
        self.seen.fill(1.0);
        self.seen_density.fill(1.0);
    }
}
