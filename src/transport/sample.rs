//! One sample of one pixel: a camera ray, and every layer of light that comes along it.

use super::air_path::add_air_path;
use super::camera::camera_ray;
use super::disc::{add_discs, draws_discs};
use super::flight::{Crowd, meet};
use super::forward::ForwardLobes;
use super::glass::{Ahead, Carried, Glass, Ways};
use super::glow::Glow;
use super::guide::Guide;
use super::lighting::Lighting;
use super::march::{Marched, march};
use super::media::Media;
use super::path::{add_path, survival_of_length, turn_h};
use super::random::{PathRandom, Purpose};
use super::rates::{Ask, Part, Rates};
use super::scratch::Scratch;
use crate::accel::{Accel, LocalRay};
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
    /// Droplets that can be seen, where they are glass.
    pub glass: Option<&'a Glass>,
    /// The forward lobe that the droplets have in common, where they have one.
    pub(super) lobes: Option<&'a ForwardLobes>,
    /// How bright the cloud is inside, where paths need to know it.
    pub(super) guide: Option<&'a Guide>,
    /// The light.
    pub lighting: &'a Lighting,
    /// What glows, where glow is simulated.
    pub glow: Option<&'a Glow>,
    /// The camera.
    pub camera: &'a Camera,
    /// Which effects are simulated.
    pub switches: Switches,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// How often each estimator is asked per sample.
    pub rates: Rates,
    /// Most times that light is scattered by droplets; at least 1.
    pub max_order: u32,
    /// Most times that light is scattered at all where air takes part; 0 without `air-multiple`.
    pub max_air_order: u32,
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

/// Takes one sample of a pixel; `pixel` counts from the top left corner of the whole picture.
pub(super) fn take_sample(
    ctx: &RenderContext,
    [column, row]: [u32; 2],
    random: &PathRandom,
    scratch: &mut Scratch,
) -> Sample {
    scratch.clear();
    scratch.hero = random.hero(scratch.seen.len());
    scratch.asks = ctx.rates.asks(random);
    let x = f64::from(column) + random.uniform(Purpose::PixelX, 0);
    let y = f64::from(row) + random.uniform(Purpose::PixelY, 0);
    let camera_ray = camera_ray(ctx.camera, ctx.resolution, x, y);
    let ray = ctx.accel.local_ray(camera_ray.origin_m, camera_ray.direction);
    scratch.rays.camera += 1;
    let mut sample = Sample::default();
    follow(ctx, &ray, random, scratch, &mut sample);
    add_discs(ctx, [column, row], camera_ray.direction, random, scratch);
    scratch.sum_spectrum();
    for (channels, radiance) in sample.layers.iter_mut().zip(&scratch.layers) {
        *channels = ctx.lighting.rgb(radiance);
    }
    (sample.depth_sum_m, sample.depth_weight) = (scratch.depth_sum, scratch.depth_weight);
    sample
}

/// Camera rays that have met more balls than this are thinned out: in a cloud of glass without end their mean number would
/// have no bound.
const LONG_WAY: u32 = 64;

/// Of camera rays that keep less than this of their light, a part stands for all.
const LITTLE: f64 = 1e-3;

/// Follows a camera ray from ball to ball, and adds what comes along each leg of its way. At the first ball it divides:
/// nearly all light goes in and out at once, which is followed without a choice; one of the other ways stands for the rest.
fn follow(ctx: &RenderContext, ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch, sample: &mut Sample) {
    let Some(ahead) = add_leg(ctx, ray, None, random, scratch, sample) else { return };
    if ahead.is_inside {
        follow_on(ctx, ray, &ahead, Ways::All, random, scratch, sample);
        return;
    }
    let (seen, density) = (scratch.seen.clone(), scratch.seen_density.clone());
    follow_on(ctx, ray, &ahead, Ways::Straight, random, scratch, sample);
    scratch.leg = 0;
    scratch.seen.copy_from_slice(&seen);
    scratch.seen_density.copy_from_slice(&density);
    follow_on(ctx, ray, &ahead, Ways::Others, random, scratch, sample);
}

/// Follows a ray past the ball ahead, and past all others behind it.
fn follow_on(
    ctx: &RenderContext,
    ray: &LocalRay,
    ahead: &Ahead,
    mut ways: Ways,
    random: &PathRandom,
    scratch: &mut Scratch,
    sample: &mut Sample,
) {
    let (mut ray, mut ahead) = (*ray, *ahead);
    let Some(glass) = ctx.glass else { return };
    loop {
        let Scratch { seen, seen_density, surfaces, hero, .. } = scratch;
        let mut carried = Carried { weight: seen, density: seen_density, hero: *hero, random, surfaces };
        let Some(next) = glass.pass(&ahead, &ray, ways, &mut carried) else { return };
        scratch.leg += 1;
        if !goes_on(random, scratch) {
            return;
        }
        scratch.rays.refracted += 1;
        let Some(further) = add_leg(ctx, &next, Some(ahead.id), random, scratch, sample) else { return };
        (ray, ahead, ways) = (next, further, Ways::All);
    }
}

/// Whether a camera ray is followed further: of what weighs little, or has come a long way, a part stands for all.
fn goes_on(random: &PathRandom, scratch: &mut Scratch) -> bool {
    let largest = scratch.seen.iter().copied().fold(0.0, f64::max);
    let survival = (largest / LITTLE).min(1.0) * survival_of_length(scratch.leg, LONG_WAY);
    if random.uniform(Purpose::Leg, scratch.surfaces) >= survival {
        return false;
    }
    scratch.seen.iter_mut().for_each(|seen| *seen /= survival);
    true
}

/// Adds what comes along one leg, from its start to the ball ahead, which is returned, or to the end of the world; `left` is
/// a ball that the ray has just left.
fn add_leg(
    ctx: &RenderContext,
    ray: &LocalRay,
    left: Option<u32>,
    random: &PathRandom,
    scratch: &mut Scratch,
    sample: &mut Sample,
) -> Option<Ahead> {
    scratch.is_refracted = scratch.leg > 0;
    let ahead = scratch.look_ahead(ctx, ray, left);
    if ahead.is_some_and(|ahead| ahead.is_inside) {
        if scratch.leg == 0 {
            sample.opacity = 1.0;
        }
        return ahead;
    }
    // What the ray meets, all of it: its transmittance is exact, and empty rays end here.
    meet(ctx, ray, scratch);
    let crowd = Crowd::of(scratch);
    let air = ctx.air_transmittance(ray, scratch.reach_m);
    let Scratch { total_depth, passed, .. } = scratch;
    for (passed, depth) in passed.iter_mut().zip(total_depth) {
        *passed = (-*depth).exp() * air;
    }
    if scratch.leg == 0 {
        note_opacity(ctx.lighting, ahead.as_ref(), scratch, sample);
    }
    add_air(ctx, ray, random, scratch);
    if (ctx.switches.direct || ctx.switches.multiple) && !scratch.crossings.is_empty() {
        add_paths(ctx, ray, random, scratch);
    }
    if ctx.max_air_order > 0 {
        repeat(Part::AirPaths, random, scratch, |random, scratch| {
            add_air_path(ctx, ray, left, crowd, random, scratch);
        });
    }
    scratch.is_refracted = scratch.leg > 0;
    let Scratch { seen, passed, .. } = scratch;
    seen.iter_mut().zip(passed).for_each(|(seen, passed)| *seen *= *passed);
    match &ahead {
        Some(ahead) => {
            let seen = std::mem::take(&mut scratch.seen);
            add_ball_sunlight(ctx, ahead, ray, (Layer::Direct, &seen), None, random, scratch);
            scratch.seen = seen;
        }
        None => add_behind(ctx, ray, scratch),
    }
    ahead
}

/// Adds what the air scatters along a leg.
fn add_air(ctx: &RenderContext, ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    let [airlight, glow] = [Part::Airlight, Part::Glow].map(|part| scratch.asks[part as usize]);
    let has_airlight = ctx.switches.airlight && airlight.times > 0;
    let has_glow = ctx.glow.is_some() && glow.times > 0;
    if has_airlight && has_glow && airlight == glow {
        repeat(Part::Glow, random, scratch, |random, scratch| march(ctx, ray, Marched::BOTH, random, scratch));
        return;
    }
    if has_airlight {
        repeat(Part::Airlight, random, scratch, |random, scratch| march(ctx, ray, Marched::AIRLIGHT, random, scratch));
    }
    if has_glow {
        repeat(Part::Glow, random, scratch, |random, scratch| march(ctx, ray, Marched::GLOW, random, scratch));
    }
}

/// Adds the light of the paths of a leg, which `scratch.crossings` belongs to.
fn add_paths(ctx: &RenderContext, ray: &LocalRay, random: &PathRandom, scratch: &mut Scratch) {
    let (reach_m, mut is_first) = (scratch.reach_m, true);
    repeat(Part::Paths, random, scratch, |random, scratch| {
        if !std::mem::take(&mut is_first) {
            scratch.reach_m = reach_m;
            meet(ctx, ray, scratch);
        }
        add_path(ctx, ray, random, scratch);
    });
}

/// Asks an estimator as often as it is its turn, and weights what it finds.
fn repeat(part: Part, random: &PathRandom, scratch: &mut Scratch, mut ask: impl FnMut(&PathRandom, &mut Scratch)) {
    let Ask { times, weight } = scratch.asks[part as usize];
    if times == 0 {
        return;
    }
    scratch.weighted(weight, |scratch| {
        ask(random, scratch);
        (1..times).for_each(|time| ask(&random.again(time), scratch));
    });
}

/// What lies behind everything: the background, and the suns' discs where no glass has turned the ray.
fn add_behind(ctx: &RenderContext, ray: &LocalRay, scratch: &mut Scratch) {
    let layer = scratch.layer(Layer::Background);
    let Scratch { seen, behind, layers, is_refracted, .. } = scratch;
    match ctx.switches.background {
        true => ctx.lighting.background_toward(ray.direction, behind),
        false => behind.fill(0.0),
    }
    if !*is_refracted && !draws_discs(ctx) {
        ctx.lighting.add_suns_discs(ray.direction, behind);
    }
    for (w, radiance) in layers[layer].iter_mut().enumerate() {
        *radiance += seen[w] * behind[w];
    }
}

/// Opacity and transmittance, exact along the camera ray; nothing passes glass straight on, which is also an event.
fn note_opacity(lighting: &Lighting, ahead: Option<&Ahead>, scratch: &mut Scratch, sample: &mut Sample) {
    let Scratch { passed, depth_sum, depth_weight, .. } = scratch;
    if let Some(ahead) = ahead {
        let mean = passed.iter().sum::<f64>() / passed.len() as f64;
        *depth_sum += mean * ahead.t_m;
        *depth_weight += mean;
        sample.opacity = 1.0;
        return;
    }
    sample.transmittance = [0, 1, 2].map(|channel| lighting.channel_mean(channel, passed));
    let luminance: f64 = lighting.luminance_weights.iter().zip(passed).map(|(weight, passed)| weight * *passed).sum();
    sample.opacity = 1.0 - luminance;
}

/// The sunlight that a ball scatters back along a ray, theory (74): the mean over its disc. Where chains look for what it sends forward, `lobes`
/// tells what is left to them.
pub(super) fn add_ball_sunlight(
    ctx: &RenderContext,
    ahead: &Ahead,
    ray: &LocalRay,
    (layer, weight): (Layer, &[f64]),
    lobes: Option<&ForwardLobes>,
    random: &PathRandom,
    scratch: &mut Scratch,
) {
    if layer == Layer::Direct && !ctx.switches.direct || weight.iter().all(|weight| *weight <= 0.0) {
        return;
    }
    let layer = scratch.layer(layer);
    let phase = ctx.media.phase(ahead.bin);
    for sun in &ctx.lighting.suns {
        let to_sun = scratch.toward(sun, random);
        scratch.light_sun(ctx, &LocalRay { origin: ahead.ball.center, direction: to_sun });
        let h = turn_h(ray.direction, to_sun);
        for w in (0..weight.len()).filter(|w| weight[*w] > 0.0) {
            let p = phase[w].eval(h);
            let p = lobes.map_or(p, |lobes| scratch.apart_from_chains(lobes, w, h, p));
            let scattered = ctx.media.q_sca(ahead.bin, w) * p;
            scratch.layers[layer][w] += weight[w] * scattered * scratch.sunlit[w] * sun.irradiance[w];
        }
    }
}
