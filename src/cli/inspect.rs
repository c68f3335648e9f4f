//! `mie-cloud inspect`: what was understood of a scene, and what would be simulated.

use std::collections::BTreeMap;
use std::io::Write;

use serde_json::{Value, json};

use super::args::InspectArgs;
use super::failure::Failure;
use super::progress::Verbosity;
use super::render::target_and_sampling;
use super::scene::{load_scene, print_warnings};
use crate::plan::{self, EffectPlan, SceneFacts};
use crate::scene::model::{Lens, ParticleKind, Scene};
use crate::spectrum::SpectralSampling;
use crate::transport::need::{Held, Need};
use crate::transport::{RenderRequest, Spectral, Until};
use crate::units::format_bytes;

/// Larger estimates are shown as this: they say no more.
const MOST_SHOWN: f64 = 1e3;

/// Runs the command.
pub fn run(args: &InspectArgs) -> Result<u8, Failure> {
    let effects =
        args.scene.effects.as_deref().map_or(Ok(BTreeMap::new()), super::effects::parse).map_err(Failure::usage)?;
    let scene = load_scene(&args.scene, None)?;
    let (target, sampling) = target_and_sampling(&scene);
    let plan = plan::plan(&scene, &effects, target, sampling.wavelengths_m.len());
    let facts = SceneFacts::of(&scene);
    let need = need(&scene, &plan, &sampling);
    if args.json {
        let mut json = to_json(&scene, &plan, &facts, &sampling);
        json["memory_bytes"] = memory_json(&need);
        writeln!(std::io::stdout().lock(), "{json:#}").map_err(Failure::other)?;
    } else {
        print_warnings(&scene.warnings, Verbosity::Normal);
        print(&scene, &plan, &facts, &sampling).and_then(|()| print_memory(&need)).map_err(Failure::other)?;
    }
    Ok(0)
}

/// The memory of a plain render of the scene.
fn need(scene: &Scene, plan: &EffectPlan, sampling: &SpectralSampling) -> Need {
    let [width, height] = scene.settings.image.resolution;
    let request = RenderRequest {
        seed: 0,
        until: Until::Samples(1),
        crop: [0, 0, width, height],
        layers: Vec::new(),
        spectral: Spectral::Discard,
    };
    let held = Held { n_channels: 4, n_copies: 1, n_threads: rayon::current_num_threads() };
    Need::of_render(scene, plan, sampling, &request, held)
}

fn print_memory(need: &Need) -> std::io::Result<()> {
    let parts: Vec<String> =
        need.items.iter().take(3).map(|item| format!("{} for {}", format_bytes(item.bytes), item.what)).collect();
    writeln!(
        std::io::stdout().lock(),
        "memory      about {} to render: {}",
        format_bytes(need.total()),
        parts.join(", ")
    )
}

fn memory_json(need: &Need) -> Value {
    let parts: Vec<Value> = need.items.iter().map(|item| json!({ "what": item.what, "bytes": item.bytes })).collect();
    json!({ "total": need.total(), "parts": parts })
}

fn count(scene: &Scene, kind: ParticleKind) -> usize {
    scene.particles.iter().filter(|particle| particle.kind == kind).count()
}

/// Smallest and largest drawn radius, m.
fn drawn_radii_m(scene: &Scene) -> Option<(f32, f32)> {
    scene.particles.iter().map(|p| (p.radius_m, p.radius_m)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

fn print(scene: &Scene, plan: &EffectPlan, facts: &SceneFacts, sampling: &SpectralSampling) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", scene.name)?;
    let (droplets, parcels) = (count(scene, ParticleKind::Droplet), count(scene, ParticleKind::Parcel));
    writeln!(out, "particles   {droplets} droplets, {parcels} parcels, {} fog boxes", scene.fog_boxes.len())?;
    if let Some((least, most)) = drawn_radii_m(scene) {
        writeln!(out, "radii       {least:.3e} m to {most:.3e} m as drawn")?;
    }
    for class in &scene.classes {
        writeln!(out, "droplets    {}, {}, phase {}", class.material, class.distribution, class.phase)?;
    }
    writeln!(
        out,
        "depth       about {:.3} across, up to about {:.3} along the longest way",
        facts.optical_depth, facts.deepest_optical_depth
    )?;
    for sun in &scene.suns {
        let d = sun.direction;
        writeln!(out, "sun         {}: {:.0} lx along ({:.3}, {:.3}, {:.3})", sun.name, sun.lux, d.x, d.y, d.z)?;
    }
    let air = &scene.settings.atmosphere;
    writeln!(
        out,
        "air         scatters {} /m, absorbs {} /m, within {} m of the camera",
        air.scattering_per_m, air.absorption_per_m, air.depth_m
    )?;
    let p = scene.camera.position_m;
    writeln!(
        out,
        "camera      {} at ({:.3}, {:.3}, {:.3}) m, {}",
        scene.camera.name,
        p.x,
        p.y,
        p.z,
        lens(scene.camera.lens)
    )?;
    let [width, height] = scene.settings.image.resolution;
    writeln!(out, "picture     {width}x{height}, {}", sampling.mode())?;
    for decision in &plan.decisions {
        let state = if decision.on { "on " } else { "off" };
        let estimate = decision.estimate.map_or("-".into(), |e| format!("{:.3} %", 100.0 * e.min(MOST_SHOWN)));
        writeln!(out, "effect      {state} {:<12} {estimate:>12}  {}", decision.effect.name(), decision.reason)?;
    }
    Ok(())
}

fn lens(lens: Lens) -> String {
    match lens {
        Lens::Perspective { yfov_rad, .. } => format!("{:.2} degrees high", yfov_rad.to_degrees()),
        Lens::Orthographic { xmag_m, ymag_m } => format!("{} m x {} m", 2.0 * xmag_m, 2.0 * ymag_m),
    }
}

fn to_json(scene: &Scene, plan: &EffectPlan, facts: &SceneFacts, sampling: &SpectralSampling) -> Value {
    let decision = |d: &plan::Decision| {
        (d.effect.name().to_owned(), json!({ "on": d.on, "reason": d.reason, "estimate": d.estimate }))
    };
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene.name,
        "hash": scene.hash,
        "droplets": count(scene, ParticleKind::Droplet),
        "parcels": count(scene, ParticleKind::Parcel),
        "fog_boxes": scene.fog_boxes.len(),
        "drawn_radius_m": drawn_radii_m(scene).map(|(least, most)| [least, most]),
        "classes": scene.classes.iter().map(|class| json!({
            "material": class.material.to_string(),
            "distribution": class.distribution.to_string(),
            "phase": class.phase.to_string(),
            "albedo": class.albedo,
        })).collect::<Vec<_>>(),
        "optical_depth": { "across": facts.optical_depth, "deepest": facts.deepest_optical_depth },
        "suns": scene.suns.iter().map(|sun| json!({
            "name": sun.name, "direction": sun.direction.to_array(), "lux": sun.lux, "color": sun.color,
        })).collect::<Vec<_>>(),
        "camera": { "name": scene.camera.name, "position_m": scene.camera.position_m.to_array(), "lens": lens(scene.camera.lens) },
        "resolution": scene.settings.image.resolution,
        "spectral_mode": sampling.mode().to_string(),
        "effects": plan.decisions.iter().map(decision).collect::<serde_json::Map<_, _>>(),
        "warnings": scene.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
