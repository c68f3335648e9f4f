//! `mie-cloud inspect`: what was understood of a scene, and what would be simulated.

use std::io::Write;

use serde_json::{Value, json};

use super::args::InspectArgs;
use super::failure::Failure;
use super::inspect_report::{Seen, count, drawn_radii_m, lens};
use super::job::target_and_sampling;
use super::progress::Verbosity;
use super::scene::{load_scene, print_warnings};
use crate::plan::{self, EffectPlan, SceneFacts, SeenDepths};
use crate::scene::model::{ParticleKind, Scene};
use crate::spectrum::SpectralSampling;
use crate::transport::need::{Held, Need};
use crate::transport::{RenderRequest, Spectral, Until};

/// Runs the command.
pub fn run(args: &InspectArgs) -> Result<u8, Failure> {
    let effects = super::effects::chosen(args.scene.effects.as_deref())?;
    let mut scene = load_scene(&args.scene, None)?;
    let (target, sampling) = target_and_sampling(&scene);
    let plan = plan::plan(&scene, &effects, target, sampling.wavelengths_m.len());
    scene.warnings.extend(plan.warnings());
    let (facts, depths) = (SceneFacts::of(&scene), SeenDepths::of(&scene));
    let need = need(&scene, &plan, &sampling);
    if args.json {
        let mut json = to_json(&scene, &plan, (&facts, &depths), &sampling);
        json["memory_bytes"] = memory_json(&need);
        writeln!(std::io::stdout().lock(), "{json:#}").map_err(Failure::other)?;
    } else {
        print_warnings(&scene.warnings, Verbosity::Normal);
        let seen = Seen { scene: &scene, plan: &plan, depths, sampling: &sampling, need: &need, target };
        write!(std::io::stdout().lock(), "{}", seen.report()).map_err(Failure::other)?;
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

fn memory_json(need: &Need) -> Value {
    let parts: Vec<Value> = need.items.iter().map(|item| json!({ "what": item.what, "bytes": item.bytes })).collect();
    json!({ "total": need.total(), "parts": parts })
}

fn to_json(
    scene: &Scene,
    plan: &EffectPlan,
    (facts, depths): (&SceneFacts, &SeenDepths),
    sampling: &SpectralSampling,
) -> Value {
    let decision = |d: &plan::Decision| {
        (
            d.effect.name().to_owned(),
            json!({ "on": d.on, "reason": d.reason, "estimate": d.estimate, "time_share": d.time_share }),
        )
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
        "optical_depth": { "seen": depths.mean, "deepest_seen": depths.deepest, "across": facts.optical_depth,
            "deepest": facts.deepest_optical_depth, "meaning": {
                "seen": "about, mean over the camera's rays that meet droplets",
                "deepest_seen": "about, the largest along the camera's rays on a coarse grid",
                "across": "rough: extinction over the mean shadow of the box around all particles, and every fog box along its diagonal",
                "deepest": "rough: across, along the longest way through that box; no ray is deeper",
            } },
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
