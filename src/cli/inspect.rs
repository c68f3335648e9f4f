//! `mie-cloud inspect`: what was understood of a scene, and what would be simulated.

use std::io::Write;

use super::args::InspectArgs;
use super::failure::Failure;
use super::inspect_report::Seen;
use super::inspect_sizes::ClassSizes;
use super::job::target_and_sampling;
use super::progress::Verbosity;
use super::scene::{load_scene, print_warnings};
use crate::plan::{self, EffectPlan, SceneFacts, SeenDepths};
use crate::scene::model::Scene;
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
    let seen = Seen {
        scene: &scene,
        plan: &plan,
        facts: SceneFacts::of(&scene),
        depths: SeenDepths::of(&scene),
        across: SeenDepths::across(&scene),
        sizes: ClassSizes::of(&scene),
        sampling: &sampling,
        need: need(&scene, &plan, &sampling),
        target,
    };
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", seen.json()).map_err(Failure::other)?;
    } else {
        print_warnings(&scene.warnings, Verbosity::Normal);
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
