//! Loads a scene with the overrides of the command line, and prints its warnings.

use crate::cli::args::SceneArgs;
use crate::cli::failure::Failure;
use crate::cli::memory::MemoryLimit;
use crate::cli::progress::Verbosity;
use crate::cli::say::say;
use crate::scene::error::SceneFault;
use crate::scene::model::Scene;
use crate::scene::{LoadOptions, SceneError, load};
use crate::transport::need::Need;
use crate::warning::Warning;

/// Reads the scene that the arguments name; `resolution` overrides its own.
pub fn load_scene(args: &SceneArgs, resolution: Option<[u32; 2]>) -> Result<Scene, Failure> {
    let limit = MemoryLimit::new(args.memory_limit);
    limit.check(&Need::of_program())?;
    let options = LoadOptions {
        settings: args.set.clone(),
        camera: args.camera.clone(),
        droplets_glob: args.droplets.clone(),
        radius_m: args.radius,
        resolution,
        memory_limit_bytes: limit.allowed,
        available_bytes: limit.of_machine(),
    };
    load(&args.scene, &options).map_err(|error| match &*error.fault {
        _ if is_flags_fault(&error) => Failure::usage(error),
        // The scene may be sound; it is too large for this machine.
        SceneFault::Memory { .. } => Failure::other(error),
        _ => Failure::scene(error),
    })
}

/// Errors of a scene name the element at fault, which may be a flag.
fn is_flags_fault(error: &SceneError) -> bool {
    error.element.starts_with("--")
}

/// Prints warnings to stderr, each once.
pub fn print_warnings(warnings: &[Warning], verbosity: Verbosity) {
    if verbosity == Verbosity::Quiet {
        return;
    }
    let mut seen = std::collections::HashSet::new();
    for warning in warnings.iter().filter(|warning| seen.insert(*warning)) {
        say!("warning: {warning}");
    }
}
