//! Files of generated clouds: byte for byte what was generated, in both containers and both forms.

use mie_cloud::scene::generate::{Cloud, CloudShape, Content, Form, Recipe, generate};
use mie_cloud::scene::gltf::write::{Container, WriteError, write, write_glb, write_gltf};
use mie_cloud::scene::model::{ParticleKind, Scene};
use mie_cloud::scene::{LoadOptions, load};
use serde_json::Value;

fn shape(name: &str, lengths_m: &[f64]) -> CloudShape {
    CloudShape::new(name, lengths_m).expect("a valid shape")
}

fn make(recipe: &Recipe) -> Cloud {
    generate(recipe, &|_| 2.0).expect("a valid recipe")
}

fn glb(cloud: &Cloud) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_glb(cloud, &mut bytes).expect("memory takes all bytes");
    bytes
}

/// The JSON and the buffer of a GLB file, by the letter of the specification.
fn split_glb(bytes: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json_end = 20 + word(12);
    assert_eq!((&bytes[16..20], json_end % 4), (&b"JSON"[..], 0));
    assert_eq!((&bytes[json_end + 4..json_end + 8], word(json_end) % 4), (&b"BIN\0"[..], 0));
    let buffer = bytes[json_end + 8..].to_vec();
    assert_eq!(word(json_end), buffer.len());
    (serde_json::from_slice(&bytes[20..json_end]).expect("JSON"), buffer)
}

/// The numbers of an accessor, after its description has been checked against them.
fn read_accessor(document: &Value, buffer: &[u8], index: &Value) -> Vec<f32> {
    let at = |value: &Value| value.as_u64().expect("a whole number") as usize;
    let accessor = &document["accessors"][at(index)];
    let view = &document["bufferViews"][at(&accessor["bufferView"])];
    let (start, length) = (at(&view["byteOffset"]), at(&view["byteLength"]));
    let values: Vec<f32> = buffer[start..start + length]
        .chunks(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four bytes")))
        .collect();
    let width = if accessor["type"] == "VEC3" { 3 } else { 1 };
    assert_eq!(values.len(), width * at(&accessor["count"]));
    for axis in 0..width {
        let column = || values.iter().copied().skip(axis).step_by(width);
        let bound = |name: &str| accessor[name][axis].as_f64().map(|bound| bound as f32);
        assert_eq!(bound("min"), Some(column().fold(f32::INFINITY, f32::min)));
        assert_eq!(bound("max"), Some(column().fold(f32::NEG_INFINITY, f32::max)));
    }
    values
}

#[test]
fn a_seed_is_a_file() {
    for (name, kind, form) in [
        ("ball", ParticleKind::Droplet, Form::Points),
        ("ball", ParticleKind::Parcel, Form::Instances),
        ("cumulus", ParticleKind::Parcel, Form::Points),
        ("puff", ParticleKind::Droplet, Form::Points),
    ] {
        let recipe = Recipe { count: 500, kind, form, patchiness: 0.5, ..Recipe::new(shape(name, &[10.0])) };
        assert_eq!(glb(&make(&recipe)), glb(&make(&recipe)));
        let other = make(&Recipe { seed: 1, ..recipe.clone() });
        assert_ne!(make(&recipe).positions, other.positions);
    }
    // Frozen: when this changes, every recipe makes another cloud.
    let recipe = Recipe { count: 2, seed: 42, ..Recipe::new(shape("box", &[100.0])) };
    assert_eq!(make(&recipe).positions, [[38.9437, -60.448044, 61.50482], [-24.618763, 14.556867, -6.418427]]);
}

#[test]
fn a_cloud_is_the_same_for_any_number_of_threads() {
    let recipe = Recipe { count: 150_000, patchiness: 0.3, ..Recipe::new(shape("ball", &[1.0])) };
    let with_threads = |n, recipe: &Recipe| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
        pool.install(|| make(recipe))
    };
    let cloud = with_threads(1, &recipe);
    assert_eq!(cloud, with_threads(3, &recipe));
    let cumulus = Recipe { kind: ParticleKind::Parcel, ..Recipe::new(shape("cumulus", &[1000.0])) };
    assert_eq!(with_threads(1, &cumulus), with_threads(3, &cumulus));
    // The blocks that threads take are not copies of each other.
    let mut positions: Vec<_> = cloud.positions.iter().map(|p| p.map(f32::to_bits)).collect();
    positions.sort_unstable();
    positions.dedup();
    assert!(positions.len() > 149_900);
}

#[test]
fn files_hold_every_particle_of_the_cloud() {
    for kind in [ParticleKind::Droplet, ParticleKind::Parcel] {
        let recipe = Recipe {
            count: 9000, // more than the writer's chunk
            kind,
            content: Content::OpticalDepth(1.0),
            ..Recipe::new(shape("ball", &[3.0]))
        };
        let cloud = make(&recipe);
        let (document, buffer) = split_glb(&glb(&cloud));
        assert_eq!(document["buffers"][0]["byteLength"], buffer.len());
        let attributes = &document["meshes"][0]["primitives"][0]["attributes"];
        let read = |name: &str| read_accessor(&document, &buffer, &attributes[name]);
        assert_eq!(read("POSITION"), cloud.positions.concat());
        assert_eq!(read("_RADIUS"), cloud.radii);
        match kind {
            ParticleKind::Droplet => assert_eq!(Some(read("_DROPLET_RADIUS_UM")), cloud.droplet_radii_um),
            ParticleKind::Parcel => assert_eq!(Some(read("_DROPLET_COUNT")), cloud.droplet_counts),
        }
        assert_eq!(attributes.as_object().map(|names| names.len()), Some(3));
        assert_eq!(document["nodes"][0]["scale"][1].as_f64(), Some(cloud.metres_per_unit));
    }
}

#[test]
fn instances_hold_what_points_hold() {
    let recipe = Recipe { count: 300, content: Content::OpticalDepth(1.0), ..Recipe::new(shape("ball", &[3.0])) };
    let cloud = make(&Recipe { form: Form::Instances, ..recipe.clone() });
    let (document, buffer) = split_glb(&glb(&cloud));
    let attributes = &document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    let read = |name: &str| read_accessor(&document, &buffer, &attributes[name]);
    let points = make(&recipe);
    assert_eq!(read("TRANSLATION"), points.positions.concat());
    assert_eq!(read("SCALE"), points.radii.iter().flat_map(|&r| [r; 3]).collect::<Vec<_>>());
    assert_eq!(Some(read("_DROPLET_RADIUS_UM")), points.droplet_radii_um);
    assert_eq!(document["extensionsUsed"][0], "EXT_mesh_gpu_instancing");
    assert_eq!(document.get("extensionsRequired"), None);
}

#[test]
fn both_containers_hold_the_same_scene() {
    for form in [Form::Points, Form::Instances] {
        let cloud = make(&Recipe { count: 101, form, ..Recipe::new(shape("ball", &[3.0])) });
        let (document, buffer) = split_glb(&glb(&cloud));
        let mut text = Vec::new();
        write_gltf(&cloud, &mut text).expect("memory takes all bytes");
        let gltf = gltf::Gltf::from_slice(&text).expect("the gltf crate accepts it");
        let mut json: Value = serde_json::from_slice(&text).expect("JSON");
        let uri = json["buffers"][0].as_object_mut().and_then(|buffer| buffer.remove("uri")).expect("a buffer inside");
        assert_eq!(json, document);
        let length = uri.as_str().map(|uri| uri.len() - "data:application/octet-stream;base64,".len());
        assert_eq!(length, Some(buffer.len().div_ceil(3) * 4));
        assert_eq!(gltf.cameras().count(), 1);
        assert_eq!(gltf.lights().map(|lights| lights.count()), Some(1));
    }
}

#[test]
fn files_carry_settings_and_recipe() {
    let settings = serde_json::json!({ "droplets": { "phase": "hg" }, "accuracy": { "target": 0.1 } });
    let recipe = Recipe {
        seed: 9,
        content: Content::LiquidWaterGPerM3(0.1),
        kind: ParticleKind::Parcel,
        settings: settings.as_object().cloned().unwrap_or_default(),
        ..Recipe::new(shape("slab", &[80.0]))
    };
    let (document, _) = split_glb(&glb(&make(&recipe)));
    let extras = &document["scenes"][0]["extras"]["mie_cloud"];
    assert_eq!(extras["droplets"]["distribution"], "gamma:reff=6um,veff=0.1");
    assert_eq!(extras["droplets"]["phase"], "hg");
    assert_eq!(extras["accuracy"]["target"], 0.1);
    let record = &document["asset"]["extras"]["mie_cloud_generator"];
    assert_eq!(record["size_m"], serde_json::json!([80.0, 10.0, 80.0]));
    assert_eq!((&record["seed"], &record["liquid_water_g_per_m3"]), (&9.into(), &0.1.into()));
    assert_eq!(
        (&record["kind"], &record["shape"], &record["as"]),
        (&"parcels".into(), &"slab".into(), &"points".into())
    );
}

#[test]
fn outputs_that_fail_and_names_that_say_nothing_are_errors() {
    struct Full;
    impl std::io::Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let cloud = make(&Recipe { count: 10, ..Recipe::new(shape("ball", &[1.0])) });
    for container in [Container::Glb, Container::Gltf] {
        assert!(write(&cloud, container, &mut Full).is_err());
    }
    assert!(matches!(Container::from_name("fog.GLB"), Ok(Container::Glb)));
    assert!(matches!(Container::from_name("a/fog.gltf"), Ok(Container::Gltf)));
    assert!(matches!(Container::from_name("fog.obj"), Err(WriteError::Extension { .. })));
}

#[test]
fn the_scene_reader_finds_what_was_generated() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (kind, form, name) in [
        (ParticleKind::Droplet, Form::Points, "ball"),
        (ParticleKind::Droplet, Form::Instances, "slab"),
        (ParticleKind::Parcel, Form::Points, "box"),
        (ParticleKind::Parcel, Form::Instances, "ball"),
        (ParticleKind::Droplet, Form::Points, "droplet"),
        (ParticleKind::Parcel, Form::Instances, "droplet"),
        (ParticleKind::Parcel, Form::Points, "cumulus"),
        (ParticleKind::Droplet, Form::Instances, "puff"),
    ] {
        let recipe = Recipe { count: 700, kind, form, ..Recipe::new(shape(name, &[3.0])) };
        let cloud = make(&recipe);
        for extension in ["glb", "gltf"] {
            let path = folder.path().join("cloud").with_extension(extension);
            let container = Container::from_name(extension_of(&path)).expect("a known extension");
            let mut file = std::fs::File::create(&path).expect("a file");
            write(&cloud, container, &mut file).expect("room on the disk");
            assert_scene_is_cloud(&load(&path, &LoadOptions::default()).expect("a scene"), &cloud, &recipe);
        }
    }
}

fn extension_of(path: &std::path::Path) -> &str {
    path.to_str().expect("a name in UTF-8")
}

fn assert_scene_is_cloud(scene: &Scene, cloud: &Cloud, recipe: &Recipe) {
    assert_eq!(scene.warnings, []);
    assert_eq!(scene.particles.len(), cloud.len());
    // Four roundings to f32, 6e-8 each; positions are as exact as the largest of them.
    let (tolerance, reach_m) = (2.4e-7, 2.4e-7 * recipe.shape.longest_m());
    for (read, made) in scene.particles.iter().zip(cloud.particles()) {
        assert!((read.center_m - made.center_m).abs().max_element() <= reach_m);
        assert!((read.radius_m / made.radius_m - 1.0).abs() <= tolerance as f32);
        assert!((read.droplet_radius_m - made.droplet_radius_m).abs() <= tolerance as f32 * made.droplet_radius_m);
        assert_eq!((read.count, read.kind), (made.count, made.kind));
        assert_eq!(scene.classes[usize::from(read.class)].distribution, recipe.distribution);
    }
    assert!((scene.camera.position_m - cloud.camera.position_m).length() < 1e-6 * cloud.camera.position_m.length());
    let frame = scene.camera.world_from_camera - cloud.camera.world_from_camera;
    assert!(frame.to_cols_array().iter().all(|difference| difference.abs() < 1e-6));
    assert_eq!(scene.suns.len(), 1);
    assert!((scene.suns[0].direction - cloud.sun.direction).length() < 1e-6);
    assert_eq!(scene.suns[0].lux, cloud.sun.lux);
}
