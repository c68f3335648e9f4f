//! Small scenes made in code, and pictures of them, for the tests of transport.

#![allow(dead_code)] // each test file uses a part

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use mie_cloud::film::{Wanted, develop};
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::plan;
use mie_cloud::scene::model::{Camera, FogBox, FogDensity, Lens, Particle, ParticleKind, Scene, Sun};
use mie_cloud::scene::settings::{AirPhase, Effect, ImageSettings, Settings, Switch};
use mie_cloud::spectrum::{SpectralMode, SpectralSampling};
use mie_cloud::transport::{
    Prepared, Progress, Rates, RenderOutcome, RenderRequest, SilentProgress, Spectral, Until, render,
};

/// A scene of one class of 5 um water droplets at 550 nm, with a sun along -z and nothing in it.
pub fn empty_scene() -> Scene {
    let mut settings = Settings {
        spectral_mode: Some(SpectralMode::Mono { wavelength_m: 550e-9 }),
        image: ImageSettings { resolution: [8, 8] },
        ..Settings::default()
    };
    // References are for suns that are points.
    settings.sun.angular_diameter_deg = 0.0;
    Scene {
        name: "test".into(),
        particles: Vec::new(),
        fog_balls: Vec::new(),
        fog_boxes: Vec::new(),
        classes: vec![settings.droplets.class.clone()],
        camera: orthographic(DVec3::new(0.0, 0.0, 10.0), 1e-3),
        suns: vec![sun(DVec3::NEG_Z)],
        settings,
        warnings: Vec::new(),
        files: Vec::new(),
        hash: String::new(),
    }
}

/// A camera that looks along -z at a square of the given half width.
pub fn orthographic(position_m: DVec3, half_width_m: f64) -> Camera {
    Camera {
        name: "test".into(),
        position_m,
        world_from_camera: DMat3::IDENTITY,
        lens: Lens::Orthographic { xmag_m: half_width_m, ymag_m: half_width_m },
    }
}

pub fn sun(direction: DVec3) -> Sun {
    Sun {
        name: "sun".into(),
        direction: direction.normalize(),
        lux: 1e5,
        color: [1.0; 3],
        spectrum: None,
        angular_diameter_deg: None,
    }
}

/// A droplet of its own radius, drawn at `radius_m`.
pub fn droplet(center_m: DVec3, radius_m: f64, own_radius_m: f64) -> Particle {
    Particle {
        center_m,
        radius_m: radius_m as f32,
        droplet_radius_m: own_radius_m as f32,
        count: 1.0,
        class: 0,
        kind: ParticleKind::Droplet,
    }
}

/// A ball of `count` droplets of radius 5 um.
pub fn parcel(center_m: DVec3, radius_m: f64, count: f64) -> Particle {
    Particle { count: count as f32, kind: ParticleKind::Parcel, ..droplet(center_m, radius_m, 5e-6) }
}

/// Leaves refraction out: droplets act as discs, as those do that are too small to be seen, however large they are drawn.
pub fn without_refraction(scene: &mut Scene) {
    scene.settings.effects.insert(Effect::Refraction, Switch::Off);
}

/// A box of fog with the given extinction coefficient at 550 nm.
pub fn fog_box(center_m: DVec3, half_size_m: DVec3, extinction_per_m: f64) -> FogBox {
    FogBox {
        name: "fog".into(),
        center_m,
        half_edges_m: DMat3::from_diagonal(half_size_m),
        density: FogDensity::ExtinctionPerM(extinction_per_m),
        class: 0,
        droplet_radius_m: Some(5e-6),
    }
}

pub fn with_phase(scene: &mut Scene, phase: PhaseModel) {
    scene.classes[0].phase = phase;
}

pub fn with_air(scene: &mut Scene, scattering_per_m: f64, absorption_per_m: f64, depth_m: f64, step_m: f64) {
    let air = &mut scene.settings.atmosphere;
    (air.scattering_per_m, air.absorption_per_m, air.depth_m, air.step_m) =
        (scattering_per_m, absorption_per_m, depth_m, step_m);
    air.phase = AirPhase::Isotropic;
}

/// Renders a scene with everything on that it calls for.
pub fn render_scene(scene: Scene, spp: u32, seed: u64) -> RenderOutcome {
    render_with(scene, spp, seed, &BTreeMap::new())
}

/// Renders a scene with light scattered once only.
pub fn render_once(scene: Scene, spp: u32, seed: u64) -> RenderOutcome {
    render_with(scene, spp, seed, &BTreeMap::from([(Effect::Multiple, Switch::Off)]))
}

pub fn render_with(scene: Scene, spp: u32, seed: u64, effects: &BTreeMap<Effect, Switch>) -> RenderOutcome {
    render_prepared(&prepare(scene, effects), spp, seed)
}

/// `prepare` with every effect that the scene calls for; the camera and the largest order may still be changed.
pub fn prepare_all(scene: Scene) -> Prepared {
    prepare(scene, &BTreeMap::new())
}

/// A scene that is ready to be rendered, with everything on that it calls for.
pub fn prepare(scene: Scene, effects: &BTreeMap<Effect, Switch>) -> Prepared {
    // Few samples, and layers looked at by themselves: every estimator is asked in each.
    let mut prepared = prepare_as_rendered(scene, effects);
    prepared.rates = Rates::EVEN;
    prepared
}

/// The same with estimators asked as often as is best for the whole picture.
pub fn prepare_as_rendered(scene: Scene, effects: &BTreeMap<Effect, Switch>) -> Prepared {
    let mode = scene.settings.spectral_mode.unwrap_or(SpectralMode::Bands { count: 8 });
    let sampling = SpectralSampling::new(mode, scene.settings.sun.spectrum);
    // A target of 1e-9 leaves nothing out.
    let plan = plan::plan(&scene, effects, 1e-9, sampling.wavelengths_m.len());
    Prepared::new(scene, &plan, &sampling, None, &mut |_| {}).expect("the scene can be prepared")
}

pub fn render_prepared(prepared: &Prepared, spp: u32, seed: u64) -> RenderOutcome {
    render_until(prepared, Until::Samples(spp), seed, &SilentProgress)
}

/// Renders until enough is done or `progress` ends it.
pub fn render_until(prepared: &Prepared, until: Until, seed: u64, progress: &dyn Progress) -> RenderOutcome {
    let [width, height] = prepared.resolution;
    let request = RenderRequest {
        seed,
        until,
        crop: [0, 0, width, height],
        layers: mie_cloud::film::Layer::ALL.iter().map(|(layer, _)| *layer).collect(),
        spectral: Spectral::Discard,
    };
    render(&prepared.context(), &request, progress)
}

/// An orthographic camera outside of everything near the origin, for light that travels to it along `travel`.
pub fn camera_for(travel: DVec3, half_width_m: f64) -> Camera {
    let (x, y) = travel.any_orthonormal_pair();
    Camera { world_from_camera: DMat3::from_cols(x, y, travel), ..orthographic(travel * 100.0, half_width_m) }
}

/// All channels of a picture by name.
pub fn channels(outcome: &RenderOutcome) -> BTreeMap<String, Vec<f32>> {
    let wanted: Vec<Wanted> = Wanted::all().into_iter().map(|(wanted, _)| wanted).collect();
    develop(&outcome.film, &wanted, 1.0).into_iter().map(|channel| (channel.name, channel.values)).collect()
}

pub fn mean(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

/// The mean of a channel over the picture.
pub fn mean_of(outcome: &RenderOutcome, channel: &str) -> f64 {
    mean(&channels(outcome)[channel])
}

/// The mean of green over the picture, and its standard error from the picture's own `stderr` layer.
pub fn mean_and_error(outcome: &RenderOutcome) -> (f64, f64) {
    let channels = channels(outcome);
    let errors = &channels["stderr.G"];
    let variance: f64 = errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>() / (errors.len() as f64).powi(2);
    (mean(&channels["G"]), variance.sqrt())
}
