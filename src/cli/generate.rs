//! `mie-cloud generate`: a recipe in, a glTF file out.

use std::path::PathBuf;

use anyhow::{Context, anyhow};
use serde_json::{Map, Value};

use super::claims::Outputs;
use super::failure::Failure;
use super::generate_args::{FormName, GenerateArgs, KindName};
use super::memory::MemoryLimit;
use super::progress::Verbosity;
use super::say::say;
use super::scene::print_warnings;
use crate::image::file::{Existing, write_atomically};
use crate::optics::distribution::SizeDistribution;
use crate::optics::material::Material;
use crate::scene::folder::Folder;
use crate::scene::generate::{CameraPlacement, CloudShape, Content, Form, GenerateError, Recipe, View};
use crate::scene::gltf::write::{Container, write};
use crate::scene::keys::SETTINGS;
use crate::scene::model::ParticleKind;
use crate::scene::settings::Settings;
use crate::scene::settings_parse::{apply, entries_of_flag};
use crate::study::make_cloud;
use crate::units::short::number;

/// Runs the command.
pub fn run(args: &GenerateArgs) -> Result<u8, Failure> {
    let verbosity = if args.quiet { Verbosity::Quiet } else { Verbosity::Normal };
    let existing = if args.no_clobber { Existing::Keep } else { Existing::Replace };
    let name = args.output.to_string_lossy();
    let container = Container::from_name(&name).map_err(Failure::usage)?;
    let outputs = Outputs::new([("--output", Some(&args.output))]);
    outputs.check(existing)?;
    let (recipe, files) = recipe(args)?;
    outputs.spare("is read for the cloud", files)?;
    let cloud = make_cloud(&recipe).map_err(|error| match error {
        GenerateError::Memory { .. } => Failure::other(error),
        _ => Failure::usage(error),
    })?;
    print_warnings(&cloud.warnings, verbosity);
    write_atomically(&args.output, existing, |out| write(&cloud, container, out).map_err(std::io::Error::other))
        .map_err(Failure::other)?;
    if verbosity > Verbosity::Quiet {
        let s = &cloud.summary;
        let magnified = if s.magnification > 1.0 {
            format!(", drawn {} times as large", number(s.magnification))
        } else {
            String::new()
        };
        say!(
            "{}: {} particles for {} droplets{magnified}; optical depth {}, {} g/m3 of liquid water",
            args.output.display(),
            cloud.len(),
            number(s.droplets),
            number(s.optical_depth),
            number(s.liquid_water_g_per_m3)
        );
    }
    Ok(0)
}

/// The recipe, and the files that it was read from.
fn recipe(args: &GenerateArgs) -> Result<(Recipe, Vec<PathBuf>), Failure> {
    let (typed, beside) = (Folder::of_user(), Folder::of_scene(&args.output));
    let (settings, material) = settings(args, &beside)?;
    let shape = CloudShape::new(&args.shape, &args.size).map_err(Failure::usage)?;
    let distribution = SizeDistribution::parse(&args.distribution, &|name| typed.read_typed_text(name))
        .context("--distribution")
        .map_err(Failure::usage)?;
    let content = match (args.liquid_water, args.optical_depth) {
        (Some(water), _) => Content::LiquidWaterGPerM3(water),
        (_, Some(depth)) => Content::OpticalDepth(depth),
        _ => Content::Default,
    };
    let camera = args.camera_position.zip(args.look_at);
    let defaults = Recipe::new(shape);
    let recipe = Recipe {
        // A single droplet needs no count.
        count: args.count.unwrap_or(if matches!(shape, CloudShape::Droplet { .. }) { 1 } else { defaults.count }),
        overlap: args.overlap.unwrap_or(defaults.overlap),
        kind: match args.kind {
            KindName::Droplets => ParticleKind::Droplet,
            KindName::Parcels => ParticleKind::Parcel,
        },
        form: match args.form {
            FormName::Points => Form::Points,
            FormName::Instances => Form::Instances,
        },
        distribution,
        content,
        seed: args.seed,
        patchiness: args.patchiness,
        view: View {
            camera: camera.map(|(position_m, target_m)| CameraPlacement { position_m, target_m }),
            yfov_deg: args.yfov,
            sun_elevation_deg: args.sun_elevation.unwrap_or(defaults.view.sun_elevation_deg),
            sun_azimuth_deg: args.sun_azimuth.unwrap_or(defaults.view.sun_azimuth_deg),
            ..defaults.view
        },
        material,
        settings,
        memory_limit_bytes: MemoryLimit::new(args.memory_limit).bytes(),
        ..defaults
    };
    Ok((recipe, [typed.files(), beside.files()].concat()))
}

/// The settings of `--set`, nested as they are written, and the material that they leave droplets with. A renderer will read
/// them from the file's folder.
fn settings(args: &GenerateArgs, folder: &Folder) -> Result<(Map<String, Value>, Material), Failure> {
    let (mut root, mut read) = (Map::new(), Settings::default());
    for (key, value) in &args.set {
        let entries = entries_of_flag(key, value)
            .and_then(|entries| apply(&mut read, &[SETTINGS], &entries, folder, "--set").map(|()| entries))
            .map_err(|error| Failure::usage(error.in_file(&args.output)))?;
        // What was checked is what is written.
        for (key, value) in entries {
            if key == "droplets.distribution" {
                let error = anyhow!("--set {key}: droplets are drawn from `--distribution`, which the file then names");
                return Err(Failure::usage(error));
            }
            insert(&mut root, &key, as_json(value))
                .ok_or_else(|| Failure::usage(anyhow!("--set {key}: a part of this key is already a value")))?;
        }
    }
    Ok((root, read.droplets.class.material))
}

/// Numbers and truths as such, other text as it is.
fn as_json(value: Value) -> Value {
    let read = value.as_str().and_then(|text| serde_json::from_str(text).ok());
    read.filter(|read: &Value| read.is_number() || read.is_boolean()).unwrap_or(value)
}

fn insert(map: &mut Map<String, Value>, key: &str, value: Value) -> Option<()> {
    match key.split_once('.') {
        None => {
            map.insert(key.into(), value);
            Some(())
        }
        Some((first, rest)) => {
            let inner = map.entry(first).or_insert_with(|| Value::Object(Map::new()));
            insert(inner.as_object_mut()?, rest, value)
        }
    }
}
