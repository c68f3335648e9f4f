//! Scenes of every form that the format allows, small enough to be checked by hand.

mod support;

use mie_cloud::optics::material::Material;
use mie_cloud::scene::model::{FogDensity, Lens, ParticleKind, Scene};
use mie_cloud::scene::settings::{Effect, Switch};
use mie_cloud::scene::{LoadOptions, SceneError, SceneFault, load};
use mie_cloud::spectrum::sun::SunSpectrum;
use serde_json::{Value, json};

use support::{Gltf, data, glb_of};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn options() -> LoadOptions {
    LoadOptions::default()
}

fn set(entries: &[(&str, &str)]) -> LoadOptions {
    let settings = entries.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    LoadOptions { settings, ..LoadOptions::default() }
}

fn warned(scene: &Scene, part: &str) -> bool {
    scene.warnings.iter().any(|w| w.to_string().contains(part))
}

/// The error text, or a panic that says what was read instead.
fn failure(result: Result<Scene, SceneError>) -> String {
    match result {
        Ok(scene) => panic!("reads: {} particles, warnings {:?}", scene.particles.len(), scene.warnings),
        Err(error) => error.to_string(),
    }
}

/// Three points at 0, 1, 2 on the x axis with radii 0.1, 0.2, 0.3.
fn three_points() -> Gltf {
    let mut gltf = Gltf::new();
    let position = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let radius = gltf.floats("SCALAR", &[0.1, 0.2, 0.3]);
    gltf.json["meshes"] =
        json!([{ "primitives": [{ "mode": 0, "attributes": { "POSITION": position, "_RADIUS": radius } }] }]);
    gltf.json["nodes"] = json!([{ "name": "Points", "mesh": 0 }]);
    gltf
}

/// A node with an octahedron-based sphere (18 vertices) of the given radius around the given x.
fn sphere_mesh(gltf: &mut Gltf, radius: f32, x: f32) -> Value {
    let mut vertices = Vec::new();
    for (a, b, c) in (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)) {
        let length = ((a * a + b * b + c * c) as f32).sqrt();
        if length > 0.0 && length < 1.6 {
            let [a, b, c] = [a, b, c].map(|t| t as f32 * radius / length);
            vertices.extend([a + x, b, c]);
        }
    }
    let position = gltf.floats("VEC3", &vertices);
    json!({ "primitives": [{ "attributes": { "POSITION": position } }] })
}

fn cube_mesh(gltf: &mut Gltf) -> Value {
    let corners: Vec<f32> = (0..8).flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|t| 2.0 * t as f32 - 1.0)).collect();
    let position = gltf.floats("VEC3", &corners);
    json!({ "primitives": [{ "attributes": { "POSITION": position } }] })
}

// --- the shipped examples ---

#[test]
fn one_cloud_in_four_files_reads_alike() -> Outcome {
    let points = load(&data("fog_points.gltf"), &options())?;
    assert_eq!(points.particles.len(), 64);
    assert_eq!(load(&data("fog_points.glb"), &options())?.hash, points.hash);
    let instanced = load(&data("fog_instanced.gltf"), &options())?;
    assert_eq!(load(&data("fog_instanced_required.gltf"), &options())?.hash, instanced.hash);
    assert_eq!(instanced.particles, points.particles);
    assert_eq!(points.camera.position_m.to_array(), [0.0, 0.0, 3.0]);
    assert!(matches!(points.camera.lens, Lens::Perspective { yfov_rad: 0.6, aspect: Some(_) }));
    let sun = &points.suns[0];
    assert_eq!((sun.lux, sun.spectrum, sun.angular_diameter_deg), (1e5, Some(SunSpectrum::E490), Some(0.533)));
    // The node is turned by -35 degrees about x: -Z becomes (0, -sin 35, -cos 35).
    let (sin, cos) = 35_f64.to_radians().sin_cos();
    assert!((sun.direction - glam::DVec3::new(0.0, -sin, -cos)).length() < 1e-6, "{}", sun.direction);
    // A file of droplets of centimetres asks what was meant.
    assert!(warned(&points, "5 mm"));
    Ok(())
}

// --- the five forms ---

#[test]
fn points_with_radii_are_droplets_scaled_by_their_node() -> Outcome {
    let mut gltf = three_points();
    gltf.json["nodes"][0]["scale"] = json!([2.0, 2.0, -2.0]);
    gltf.json["nodes"][0]["translation"] = json!([10.0, 0.0, 0.0]);
    let scene = gltf.load(&options())?;
    let last = scene.particles[2];
    assert_eq!(last.center_m.to_array(), [14.0, 0.0, 0.0]);
    assert!((last.radius_m - 0.6).abs() < 1e-6);
    assert_eq!((last.kind, last.count, last.droplet_radius_m), (ParticleKind::Droplet, 1.0, last.radius_m));
    Ok(())
}

#[test]
fn further_attributes_give_own_radius_count_and_material() -> Outcome {
    let mut gltf = three_points();
    let own = gltf.floats("SCALAR", &[5.0, 6.0, 7.0]);
    let count = gltf.floats("SCALAR", &[1.0, 1e9, 1.0]);
    let material = gltf.floats("SCALAR", &[1.0, 0.0, 0.0]);
    let attributes = &mut gltf.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["_DROPLET_RADIUS_UM"] = json!(own);
    attributes["_DROPLET_COUNT"] = json!(count);
    attributes["_MATERIAL"] = json!(material);
    gltf.json["scenes"][0]["extras"] = json!({ "mie_cloud": { "droplets": { "materials": ["water", "ice"] } } });
    gltf.json["nodes"][0]["scale"] = json!([3.0, 3.0, 3.0]);
    let scene = gltf.load(&options())?;
    let [a, b, _] = scene.particles.as_slice() else { panic!("three particles") };
    // Own radii are not scaled by nodes.
    assert!((a.droplet_radius_m - 5e-6).abs() < 1e-11 && (a.radius_m - 0.3).abs() < 1e-6);
    assert_eq!((a.kind, b.kind, b.count), (ParticleKind::Droplet, ParticleKind::Parcel, 1e9));
    assert_eq!(scene.classes[usize::from(a.class)].material, Material::Ice);
    assert_eq!(scene.classes[usize::from(b.class)].material, Material::Water);
    // One material too few.
    gltf.json["scenes"][0]["extras"] = json!({ "mie_cloud": { "droplets": { "materials": ["water"] } } });
    assert!(failure(gltf.load(&options())).contains("_MATERIAL"));
    Ok(())
}

#[test]
fn parcels_without_an_own_radius_hold_the_distribution() -> Outcome {
    let mut gltf = three_points();
    let count = gltf.floats("SCALAR", &[100.0, 100.0, 100.0]);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["_DROPLET_COUNT"] = json!(count);
    gltf.json["nodes"][0]["extras"] = json!({ "mie_cloud": { "distribution": "mono:r=5um" } });
    let scene = gltf.load(&options())?;
    assert!(scene.particles.iter().all(|p| p.kind == ParticleKind::Parcel && p.droplet_radius_m == 0.0));
    assert_eq!(scene.classes[usize::from(scene.particles[0].class)].distribution.r_max_m, 5e-6);
    Ok(())
}

#[test]
fn instances_take_radius_from_attribute_or_mesh_and_center_from_both() -> Outcome {
    let mut gltf = Gltf::new();
    let mesh = sphere_mesh(&mut gltf, 0.5, 1.0);
    let translation = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 5.0, 0.0]);
    let scale = gltf.floats("VEC3", &[2.0, 2.0, 2.0, 4.0, 4.0, 4.0]);
    // A half turn about z.
    let rotation = gltf.floats("VEC4", &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    gltf.json["meshes"] = json!([mesh]);
    let attributes = json!({ "TRANSLATION": translation, "SCALE": scale, "ROTATION": rotation });
    gltf.json["nodes"] =
        json!([{ "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } }]);
    gltf.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = gltf.load(&options())?;
    let [a, b] = scene.particles.as_slice() else { panic!("two particles") };
    assert!((a.center_m - glam::DVec3::new(-2.0, 0.0, 0.0)).length() < 1e-6, "{}", a.center_m);
    assert!((b.center_m - glam::DVec3::new(4.0, 5.0, 0.0)).length() < 1e-6, "{}", b.center_m);
    assert!((a.radius_m - 1.0).abs() < 1e-6 && (b.radius_m - 2.0).abs() < 1e-6);
    let radius = gltf.floats("SCALAR", &[0.25, 0.75]);
    gltf.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["_RADIUS"] = json!(radius);
    gltf.json["nodes"][0]["scale"] = json!([2.0, 2.0, 2.0]);
    let radii: Vec<f32> = gltf.load(&options())?.particles.iter().map(|p| p.radius_m).collect();
    // The attribute grows with the node, not with the instance.
    assert_eq!(radii, [0.5, 1.5]);
    Ok(())
}

#[test]
fn instances_of_a_bare_point_bring_their_own_radii() -> Outcome {
    let mut gltf = Gltf::new();
    let position = gltf.floats("VEC3", &[0.0, 0.0, 1.0]);
    let translation = gltf.floats("VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let radius = gltf.floats("SCALAR", &[0.5, 0.25]);
    let count = gltf.floats("SCALAR", &[1.0, 7.0]);
    gltf.json["meshes"] = json!([{ "primitives": [{ "mode": 0, "attributes": { "POSITION": position } }] }]);
    let attributes = json!({ "TRANSLATION": translation, "_RADIUS": radius, "_DROPLET_COUNT": count });
    gltf.json["nodes"] = json!([{ "mesh": 0, "scale": [2.0, 2.0, 2.0],
        "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } }]);
    let particles = gltf.load(&options())?.particles;
    assert_eq!(particles.iter().map(|p| (p.radius_m, p.count)).collect::<Vec<_>>(), [(1.0, 1.0), (0.5, 7.0)]);
    assert_eq!(particles[1].center_m.to_array(), [4.0, 0.0, 2.0]);
    Ok(())
}

#[test]
fn marked_spheres_are_droplets_wherever_the_mark_stands_and_duplicates_count() -> Outcome {
    for place in ["node", "mesh", "material", "glob"] {
        let mut gltf = Gltf::new();
        let mut mesh = sphere_mesh(&mut gltf, 2.0, 0.0);
        mesh["primitives"][0]["material"] = json!(0);
        gltf.json["meshes"] = json!([mesh]);
        gltf.json["materials"] = json!([{}]);
        gltf.json["nodes"] = json!([
            { "name": "Drop.001", "mesh": 0, "scale": [0.5, 0.5, 0.5] },
            { "name": "Drop.002", "mesh": 0, "translation": [5.0, 0.0, 0.0] },
        ]);
        gltf.json["scenes"][0]["nodes"] = json!([0, 1]);
        let mark = json!({ "mie_cloud": { "kind": "droplet" } });
        let mut options = options();
        match place {
            "node" => {
                gltf.json["nodes"][0]["extras"] = mark.clone();
                gltf.json["nodes"][1]["extras"] = mark;
            }
            "mesh" => gltf.json["meshes"][0]["extras"] = mark,
            "material" => gltf.json["materials"][0]["extras"] = mark,
            _ => options.droplets_glob = Some("Drop*".into()),
        }
        let scene = gltf.load(&options)?;
        let radii: Vec<f32> = scene.particles.iter().map(|p| p.radius_m).collect();
        assert_eq!(radii.len(), 2, "{place}");
        assert!((radii[0] - 1.0).abs() < 1e-6 && (radii[1] - 2.0).abs() < 1e-6, "{place}: {radii:?}");
    }
    Ok(())
}

#[test]
fn bare_points_need_a_radius_and_say_so() -> Outcome {
    let mut gltf = three_points();
    let attributes = gltf.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut();
    attributes.ok_or("attributes")?.remove("_RADIUS");
    assert!(failure(gltf.load(&options())).contains("--radius"));
    gltf.json["nodes"][0]["scale"] = json!([7.0, 7.0, 7.0]);
    let scene = gltf.load(&LoadOptions { radius_m: Some(0.5), ..options() })?;
    // The flag is a length in the world.
    assert!(scene.particles.iter().all(|p| p.radius_m == 0.5));
    Ok(())
}

#[test]
fn fog_boxes_are_the_bounds_of_their_mesh_in_the_nodes_frame() -> Outcome {
    let mut gltf = Gltf::new();
    gltf.json["meshes"] = json!([cube_mesh(&mut gltf)]);
    let mark = json!({ "kind": "fog", "number_per_m3": 1e8, "distribution": "mono:r=4um" });
    let turn = 0.5_f64.sqrt();
    gltf.json["nodes"] = json!([{ "name": "Bank", "mesh": 0, "extras": { "mie_cloud": mark },
        "scale": [3.0, 2.0, 1.0], "rotation": [0.0, 0.0, turn, turn], "translation": [1e6, 0.0, 0.0] }]);
    let scene = gltf.load(&options())?;
    let [fog] = scene.fog_boxes.as_slice() else { panic!("one box") };
    assert_eq!((fog.name.as_str(), fog.density), ("Bank", FogDensity::NumberPerM3(1e8)));
    assert_eq!(fog.center_m.to_array(), [1e6, 0.0, 0.0]);
    // A quarter turn about z: the long x edge points along y.
    assert!((fog.half_edges_m.x_axis - glam::DVec3::new(0.0, 3.0, 0.0)).length() < 1e-12);
    assert!((fog.half_edges_m.determinant() - 6.0).abs() < 1e-9);
    gltf.json["nodes"][0]["scale"] = json!([3.0, 0.0, 1.0]);
    assert!(failure(gltf.load(&options())).contains("thickness"));
    gltf.json["nodes"][0]["extras"] = json!({ "mie_cloud": { "kind": "fog" } });
    assert!(failure(gltf.load(&options())).contains("number_per_m3"));
    gltf.json["nodes"][0]["extras"] = json!({ "mie_cloud": { "number_per_m3": 1e8 } });
    assert!(failure(gltf.load(&options())).contains("kind"));
    Ok(())
}

#[test]
fn points_marked_as_fog_are_balls_of_fog() -> Outcome {
    let mut gltf = three_points();
    let fog = |density: &str| json!({ "mie_cloud": { "kind": "fog", density: 2.5e6 } });
    gltf.json["meshes"][0]["extras"] = fog("number_per_m3");
    let scene = gltf.load(&options())?;
    let ball = scene.particles[1];
    let expected = 2.5e6 * 4.0 / 3.0 * std::f64::consts::PI * 0.2_f64.powi(3);
    assert_eq!(ball.kind, ParticleKind::Parcel);
    assert!((f64::from(ball.count) / expected - 1.0).abs() < 1e-6);
    assert!(scene.fog_balls.is_empty());

    gltf.json["meshes"][0]["extras"] = fog("extinction_per_m");
    let mut scene = gltf.load(&options())?;
    assert_eq!(scene.fog_balls.len(), 1);
    let mut asked = 0;
    scene
        .fill_fog(|_, own_m, measure| {
            asked += 1;
            assert_eq!((own_m, measure), (None, mie_cloud::scene::fog::Measure::ExtinctionM2));
            Ok::<_, ()>(1e-10)
        })
        .map_err(|()| "fill")?;
    assert_eq!(asked, 1);
    assert!(scene.fog_balls.is_empty());
    assert!((f64::from(scene.particles[1].count) / (expected * 1e10) - 1.0).abs() < 1e-6);
    Ok(())
}

#[test]
fn all_forms_may_stand_in_one_file_below_one_another() -> Outcome {
    let mut gltf = three_points();
    let sphere = sphere_mesh(&mut gltf, 1.0, 0.0);
    let cube = cube_mesh(&mut gltf);
    let points = gltf.json["meshes"][0].clone();
    let mut bare = points.clone();
    bare["primitives"][0]["attributes"].as_object_mut().ok_or("attributes")?.remove("_RADIUS");
    let translation = gltf.floats("VEC3", &[0.0; 15]);
    gltf.json["meshes"] = json!([points, sphere, cube, bare]);
    let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translation } } });
    gltf.json["nodes"] = json!([
        { "mesh": 0, "children": [1], "translation": [1.0, 0.0, 0.0] },
        { "mesh": 1, "children": [2], "extensions": instancing, "translation": [1.0, 0.0, 0.0] },
        { "mesh": 2, "children": [3], "translation": [1.0, 0.0, 0.0],
          "extras": { "mie_cloud.kind": "fog", "mie_cloud.liquid_water_g_per_m3": 0.3 } },
        { "mesh": 3, "children": [4] },
        { "mesh": 1, "extras": { "mie_cloud": "{\"kind\": \"droplet\"}" } },
    ]);
    let scene = gltf.load(&LoadOptions { radius_m: Some(0.1), ..options() })?;
    assert_eq!(scene.particles.len(), 3 + 5 + 3 + 1);
    assert_eq!(scene.fog_boxes[0].center_m.x, 3.0);
    assert_eq!(scene.fog_boxes[0].density, FogDensity::LiquidWaterGPerM3(0.3));
    Ok(())
}

// --- accessors ---

#[test]
fn sparse_strided_and_normalised_accessors_are_read() -> Outcome {
    let mut gltf = Gltf::new();
    // Positions with a stride of 16: the fourth number of each is foreign.
    let view = gltf.view(&[0.0_f32, 1.0, 2.0, 99.0, 3.0, 4.0, 5.0, 99.0].map(f32::to_le_bytes).concat());
    gltf.json["bufferViews"][view]["byteStride"] = json!(16);
    let position = gltf.accessor(json!({ "bufferView": view, "componentType": 5126, "count": 2, "type": "VEC3" }));
    // Radii are zero but for the sparse values 0.5 and 1.0, normalised bytes.
    let (indices, values) = (gltf.view(&[0, 1]), gltf.view(&[51, 255]));
    let sparse = json!({ "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values } });
    let radius = gltf
        .accessor(json!({ "componentType": 5121, "normalized": true, "count": 2, "type": "SCALAR", "sparse": sparse }));
    gltf.json["meshes"] =
        json!([{ "primitives": [{ "mode": 0, "attributes": { "POSITION": position, "_RADIUS": radius } }] }]);
    gltf.json["nodes"] = json!([{ "mesh": 0 }]);
    let scene = gltf.load(&options())?;
    assert_eq!(scene.particles[1].center_m.to_array(), [3.0, 4.0, 5.0]);
    assert_eq!(scene.particles.iter().map(|p| p.radius_m).collect::<Vec<_>>(), [0.2, 1.0]);
    Ok(())
}

#[test]
fn quantised_positions_need_their_extension() -> Outcome {
    let mut gltf = three_points();
    let view = gltf.view(&[0_i16, 0, 0, 1, -1, 2, 32767, -32767, -32768].map(i16::to_le_bytes).concat());
    let position = gltf
        .accessor(json!({ "bufferView": view, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3" }));
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
    assert!(failure(gltf.load(&options())).contains("componentType"));
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(gltf.load(&options())?.particles[2].center_m.to_array(), [1.0, -1.0, -1.0]);
    Ok(())
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    for (value, name) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
        let mut gltf = three_points();
        let position = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, value, 0.0, 2.0, 0.0, 0.0]);
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
        let text = failure(gltf.load(&options()));
        assert!(text.contains("element 1") && text.contains(name), "{text}");
    }
}

/// Its square is no number, and it would turn nothing.
#[test]
fn rotations_whose_length_is_no_number_are_named() {
    let mut gltf = three_points();
    gltf.json["nodes"][0]["rotation"] = json!([1e155, 0.0, 0.0, 1e155]);
    let text = failure(gltf.load(&options()));
    assert!(text.contains("the length of its rotation") && text.contains("unit quaternion"), "{text}");
}

#[test]
fn radii_that_a_quantiser_zeroed_are_an_error_and_a_few_zeros_a_warning() -> Outcome {
    let radii = |values: &[f32]| {
        let mut gltf = three_points();
        let radius = gltf.floats("SCALAR", values);
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["_RADIUS"] = json!(radius);
        gltf.load(&options())
    };
    for zeros in [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        let text = failure(radii(&zeros));
        assert!(text.contains("quantiser"), "{text}");
    }
    let scene = radii(&[0.0, 1.0, 2.0])?;
    assert_eq!(scene.particles.len(), 2);
    assert!(warned(&scene, "radius 0"));
    assert!(failure(radii(&[-1.0, 1.0, 2.0])).contains("radius 0 is -1"));
    Ok(())
}

// --- the node graph ---

#[test]
fn micrometres_survive_a_million_metres_from_the_origin() -> Outcome {
    let mut gltf = three_points();
    // Points around 1..100 under a node scaled to micrometres, below a node at 1e6 m.
    gltf.json["nodes"] = json!([
        { "children": [1], "translation": [1e6, -1e6, 1e6] },
        { "mesh": 0, "scale": [1e-6, 1e-6, 1e-6] },
    ]);
    let scene = gltf.load(&options())?;
    let step_m = scene.particles[1].center_m.x - scene.particles[0].center_m.x;
    // A double resolves 1.2e-10 m at 1e6 m.
    assert!((step_m - 1e-6).abs() < 2e-10, "{step_m}");
    assert!((scene.particles[2].radius_m - 0.3e-6).abs() < 1e-13);
    Ok(())
}

#[test]
fn matrices_and_trs_place_alike() -> Outcome {
    let mut gltf = three_points();
    let half = 0.5_f64.sqrt();
    gltf.json["nodes"][0] = json!({ "mesh": 0, "translation": [1.0, 2.0, 3.0], "rotation": [0.0, half, 0.0, half], "scale": [2.0, 2.0, 2.0] });
    let trs = gltf.load(&options())?;
    // A quarter turn about y sends x to -z; columns first.
    let matrix = [0.0, 0.0, -2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 1.0];
    gltf.json["nodes"][0] = json!({ "mesh": 0, "matrix": matrix });
    let by_matrix = gltf.load(&options())?;
    for (a, b) in trs.particles.iter().zip(&by_matrix.particles) {
        assert!((a.center_m - b.center_m).length() < 1e-12);
        assert!((a.radius_m - b.radius_m).abs() < 1e-7);
    }
    Ok(())
}

#[test]
fn non_uniform_scale_is_the_cube_root_with_a_warning_and_zero_scale_an_error() -> Outcome {
    let mut gltf = three_points();
    gltf.json["nodes"][0]["scale"] = json!([1.0, 2.0, 4.0]);
    let scene = gltf.load(&options())?;
    assert!((scene.particles[0].radius_m - 0.2).abs() < 1e-7);
    assert!(warned(&scene, "non-uniform"));
    gltf.json["nodes"][0]["scale"] = json!([0.0, 0.0, 0.0]);
    assert!(failure(gltf.load(&options())).contains("scale"));
    Ok(())
}

#[test]
fn a_chain_of_fifty_thousand_nodes_is_walked() -> Outcome {
    let mut gltf = three_points();
    let depth = 50_000;
    let mut nodes: Vec<Value> =
        (1..depth).map(|child| json!({ "children": [child], "translation": [0.001, 0.0, 0.0] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    gltf.json["nodes"] = json!(nodes);
    let x = gltf.load(&options())?.particles[0].center_m.x;
    assert!((x - 0.001 * f64::from(depth - 1)).abs() < 1e-9, "{x}");
    Ok(())
}

#[test]
fn two_parents_and_roots_with_parents_are_refused() {
    let mut gltf = three_points();
    gltf.json["nodes"] = json!([{ "children": [2] }, { "children": [2] }, { "mesh": 0 }]);
    gltf.json["scenes"][0]["nodes"] = json!([0, 1]);
    assert!(failure(gltf.load(&options())).contains("both nodes[0] and nodes[1]"));
    gltf.json["nodes"] = json!([{ "children": [1] }, { "mesh": 0 }]);
    assert!(failure(gltf.load(&options())).contains("root"));
}

// --- cameras and lights ---

#[test]
fn cameras_come_first_or_by_name() -> Outcome {
    let mut gltf = three_points();
    gltf.json["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } },
        { "type": "orthographic", "orthographic": { "xmag": 2.0, "ymag": 1.0, "znear": 0.1, "zfar": 10.0 } },
    ]);
    gltf.json["nodes"] =
        json!([{ "mesh": 0, "children": [1] }, { "name": "A", "camera": 0 }, { "name": "B", "camera": 1 }]);
    gltf.json["scenes"][0]["nodes"] = json!([0, 2]);
    let scene = gltf.load(&options())?;
    assert_eq!(scene.camera.name, "A");
    assert_eq!(scene.camera.lens, Lens::Perspective { yfov_rad: 0.5, aspect: None });
    assert!(warned(&scene, "--camera"));
    let scene = gltf.load(&LoadOptions { camera: Some("B".into()), ..options() })?;
    assert_eq!(scene.camera.lens, Lens::Orthographic { xmag_m: 2.0, ymag_m: 1.0 });
    // The picture is 640x360, 16 to 9, and the view 2 to 1.
    assert!(
        warned(&scene, "camera B: xmag and ymag") && warned(&scene, "stretched 0.889 times"),
        "{:?}",
        scene.warnings
    );
    assert!(warned(&scene, "image.resolution to 640x320"), "{:?}", scene.warnings);
    for resolution in [[640, 320], [200, 101]] {
        let options = LoadOptions { camera: Some("B".into()), resolution: Some(resolution), ..options() };
        assert!(!warned(&gltf.load(&options)?, "stretched"), "{resolution:?}");
    }
    let text = failure(gltf.load(&LoadOptions { camera: Some("C".into()), ..options() }));
    assert!(text.contains("A, B"), "{text}");
    // Two of one name are told apart by nothing but their order.
    gltf.json["nodes"][2]["name"] = json!("A");
    let scene = gltf.load(&LoadOptions { camera: Some("A".into()), ..options() })?;
    assert_eq!(scene.camera.lens, Lens::Perspective { yfov_rad: 0.5, aspect: None });
    assert!(warned(&scene, "2 cameras are called A"), "{:?}", scene.warnings);
    Ok(())
}

#[test]
fn scenes_without_camera_and_sun_get_both_and_are_told() -> Outcome {
    let scene = three_points().load(&options())?;
    assert!(warned(&scene, "no camera") && warned(&scene, "no directional light"));
    assert!(scene.camera.position_m.z > 1.0);
    assert!(scene.suns[0].direction.y < 0.0);
    Ok(())
}

#[test]
fn what_is_not_rendered_is_named_once() -> Outcome {
    let mut gltf = three_points();
    let cube = cube_mesh(&mut gltf);
    let points = gltf.json["meshes"][0].clone();
    gltf.json["meshes"] = json!([points, cube]);
    gltf.json["nodes"] =
        json!((0..12).map(|i| json!({ "mesh": usize::from(i > 0), "name": format!("N{i}") })).collect::<Vec<_>>());
    gltf.json["nodes"][5] = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    gltf.json["scenes"][0]["nodes"] = json!((0..12).collect::<Vec<_>>());
    gltf.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    gltf.json["animations"] = json!([{}]);
    gltf.json["images"] = json!([{ "uri": "http://elsewhere/never-read.png" }]);
    gltf.json["extensionsUsed"] = json!(["VENDOR_thing", "KHR_materials_unlit"]);
    let scene = gltf.load(&options())?;
    for part in ["10 mesh nodes (first nodes[1] \"N1\")", "point or spot", "animations", "textures", "VENDOR_thing"] {
        assert_eq!(
            scene.warnings.iter().filter(|w| w.to_string().contains(part)).count(),
            1,
            "{part}: {:?}",
            scene.warnings
        );
    }
    assert!(!warned(&scene, "unlit"));
    Ok(())
}

/// Only a box is drawn as it was modelled, however many vertices it has.
#[test]
fn fog_meshes_that_are_no_boxes_are_told_of() -> Outcome {
    let fog = json!({ "mie_cloud": { "kind": "fog", "extinction_per_m": 1.0 } });
    let grid = |keep: &dyn Fn([f32; 3]) -> bool| -> Vec<f32> {
        let points = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1].map(|t| 0.3 * t as f32 + 7.1));
        points.filter(|point| keep(*point)).flatten().collect()
    };
    let inner = |point: [f32; 3]| point.iter().all(|t| (t - 7.1).abs() < 0.1);
    let subdivided = grid(&|point| !inner(point));
    // A cylinder of eight sides: all vertices lie on its box, none at the corners.
    let edges = grid(&|point| (point[0] - 7.1).abs() < 0.1 || (point[1] - 7.1).abs() < 0.1);
    for (vertices, is_box) in [(subdivided, true), (edges, false)] {
        let mut gltf = three_points();
        let position = gltf.floats("VEC3", &vertices);
        gltf.json["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": position } }] }]);
        gltf.json["nodes"] = json!([{ "name": "Fog", "mesh": 0, "extras": fog }]);
        let scene = gltf.load(&options())?;
        assert_eq!(warned(&scene, "bounding box; POINTS with _RADIUS"), !is_box, "{:?}", scene.warnings);
    }
    let mut gltf = Gltf::new();
    let meshes = [sphere_mesh(&mut gltf, 1.0, 0.0), cube_mesh(&mut gltf)];
    gltf.json["meshes"] = json!(meshes);
    gltf.json["nodes"] = json!([0, 1].map(|mesh| json!({ "name": format!("F{mesh}"), "mesh": mesh, "extras": fog })));
    gltf.json["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = gltf.load(&options())?;
    assert!(warned(&scene, "1 fog mesh that is no box (nodes[0] \"F0\")"), "{:?}", scene.warnings);
    Ok(())
}

#[test]
fn attributes_that_are_not_read_are_named_with_the_ones_that_were_meant() -> Outcome {
    let mut gltf = three_points();
    let values = gltf.floats("SCALAR", &[1e9, 1e9, 1e9]);
    let attributes = &mut gltf.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["_DROPLETS_COUNT"] = json!(values);
    let scene = gltf.load(&options())?;
    let named = "1 vertex attribute of the file's own (_DROPLETS_COUNT (did you mean _DROPLET_COUNT?) of meshes[0]";
    assert!(warned(&scene, named), "{:?}", scene.warnings);
    // They were meant to be many; what they are instead is too large, and the remedy names the attribute.
    assert!(warned(&scene, "no such drops exist in air; for a cloud give each a number of droplets (_DROPLET_COUNT"));
    for i in 0..9 {
        gltf.json["meshes"][0]["primitives"][0]["attributes"][format!("_OWN{i}")] = json!(values);
    }
    let scene = gltf.load(&options())?;
    assert!(
        warned(&scene, "10 vertex attributes of the file's own") && warned(&scene, "_OWN1, .. of"),
        "{:?}",
        scene.warnings
    );
    Ok(())
}

/// Marks and attributes that nothing reads are slips: each kind is named once, with the first node.
#[test]
fn what_is_said_in_vain_is_named_once() -> Outcome {
    let mut gltf = three_points();
    let cube = cube_mesh(&mut gltf);
    let points = gltf.json["meshes"][0].clone();
    gltf.json["meshes"] = json!([points, cube]);
    let translation = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 5.0, 0.0]);
    let count = gltf.floats("SCALAR", &[5.0, 7.0]);
    let attributes = json!({ "TRANSLATION": translation, "_DROPLET_COUNT": count });
    let say = |marks: Value| json!({ "mie_cloud": marks });
    gltf.json["nodes"] = json!([
        { "name": "Twice", "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } },
        { "name": "Box", "mesh": 1, "extras": say(json!({ "kind": "fog", "number_per_m3": 1e6, "droplet_count": 3 })) },
        { "name": "Lamp", "extras": say(json!({ "spectrum": "d65", "angular_diameter_deg": 1 })) },
        { "name": "Parent", "extras": say(json!({ "material": "ice" })) },
        { "name": "Parents", "extras": say(json!({ "droplet_count": 2 })) },
        { "name": "Fine", "mesh": 0, "extras": say(json!({ "droplet_count": 2 })) },
    ]);
    gltf.json["scenes"][0]["nodes"] = json!((0..6).collect::<Vec<_>>());
    let scene = gltf.load(&options())?;
    let parts = [
        "\"Twice\"): those of the points are used",
        "1 fog box with a density and a droplet_count (nodes[1] \"Box\")",
        "1 node says something of a sun and has no light (nodes[2] \"Lamp\")",
        "2 nodes say something of droplets and have no mesh (first nodes[3] \"Parent\")",
    ];
    for part in parts {
        let n = scene.warnings.iter().filter(|w| w.to_string().contains(part)).count();
        assert_eq!(n, 1, "{part}: {:?}", scene.warnings);
    }
    assert!(!warned(&scene, "Fine"));
    // Three points at each of two instances, each alone, and three parcels.
    assert_eq!(scene.particles.iter().filter(|p| p.count == 1.0).count(), 6);
    Ok(())
}

#[test]
fn required_extensions_are_refused_by_name_unless_they_only_change_surfaces() -> Outcome {
    let mut gltf = three_points();
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "VENDOR_thing"] {
        gltf.json["extensionsRequired"] = json!([name]);
        assert!(failure(gltf.load(&options())).contains(name));
    }
    gltf.json["extensionsRequired"] = json!(["KHR_materials_volume", "KHR_texture_transform", "KHR_lights_punctual"]);
    gltf.load(&options())?;
    Ok(())
}

// --- settings ---

#[test]
fn settings_come_nested_flat_as_text_and_by_flag() -> Outcome {
    let mut gltf = three_points();
    let forms = [
        json!({ "mie_cloud": { "atmosphere": { "step_m": 0.25, "sunlight": false }, "effects": { "air_multiple": "off" } } }),
        json!({ "mie_cloud.atmosphere.step_m": 0.25, "mie_cloud.atmosphere.sunlight": 0, "mie_cloud.effects.air-multiple": "off" }),
        json!({ "mie_cloud": "{\"atmosphere\": {\"step_m\": 0.25, \"sunlight\": false}, \"effects\": {\"air-multiple\": false}}" }),
        json!({ "mie_cloud": { "atmosphere.step_m": "0.25", "atmosphere.sunlight": "off", "effects.air_multiple": "off" }, "other": [1] }),
    ];
    let mut hashes = Vec::new();
    for form in forms {
        gltf.json["scenes"][0]["extras"] = form;
        let scene = gltf.load(&options())?;
        assert_eq!(scene.settings.atmosphere.step_m, 0.25);
        assert!(!scene.settings.atmosphere.sunlight);
        assert_eq!(scene.settings.effects[&Effect::AirMultiple], Switch::Off);
        hashes.push(scene.hash);
    }
    hashes.dedup();
    assert_eq!(hashes.len(), 1);
    let flags = set(&[
        ("atmosphere.step_m", "0.5"),
        ("image.resolution", "320x200"),
        ("background.radiance", "0.1,0.2,0.3"),
        ("spectral.mode", "rgb"),
        ("accuracy.target", "fine"),
        ("droplets", "{\"material\": \"ice\", \"albedo\": 1}"),
    ]);
    let settings = gltf.load(&flags)?.settings;
    assert_eq!(settings.atmosphere.step_m, 0.5);
    assert_eq!(settings.image.resolution, [320, 200]);
    assert_eq!(settings.background.radiance, [0.1, 0.2, 0.3]);
    assert_eq!((settings.accuracy.target, settings.droplets.class.albedo), (Some(0.02), Some(1.0)));
    assert_eq!(settings.droplets.class.material, Material::Ice);
    Ok(())
}

#[test]
fn unknown_keys_are_errors_with_a_proposal() {
    let mut gltf = three_points();
    for (key, meant) in [
        ("atmosphere.setp_m", "atmosphere.step_m"),
        ("step_m", "atmosphere.step_m"),
        ("drops.material", "droplets.material"),
        ("effects.glwo", "effects.glow"),
    ] {
        let text = failure(gltf.load(&set(&[(key, "1")])));
        assert!(text.contains(&format!("did you mean `{meant}`?")), "{text}");
        assert!(text.contains("--set"), "{text}");
    }
    // An empty group sets nothing, and is looked at all the same.
    assert!(gltf.load(&set(&[("atmosphere", "{}")])).is_ok());
    assert!(failure(gltf.load(&set(&[("atmosfere", "{}")]))).contains("atmosphere"));
    assert!(failure(gltf.load(&set(&[("atmosphere.step_m", "{}")]))).contains("is not a finite number"));
    gltf.json["scenes"][0]["extras"] = json!({ "mie_cloud": { "droplet": {}, "atmosphere": {} } });
    assert!(failure(gltf.load(&options())).contains("droplets"));
    gltf.json["scenes"][0]["extras"] = json!(null);
    gltf.json["nodes"][0]["extras"] = json!({ "mie_cloud": { "kind": "fog", "extinction": 1 } });
    assert!(failure(gltf.load(&options())).contains("did you mean `extinction_per_m`?"));
    gltf.json["nodes"][0]["extras"] = json!({ "mie_cloud": { "materiel": "ice" } });
    let text = failure(gltf.load(&options()));
    assert!(text.contains("did you mean `material`?") && text.contains("nodes[0] \"Points\""), "{text}");
}

#[test]
fn every_setting_is_checked_for_type_and_range() {
    let bad = [
        ("atmosphere.step_m", "0"),
        ("atmosphere.step_m", "-1"),
        ("atmosphere.step_m", "NaN"),
        ("atmosphere.depth_m", "inf"),
        ("atmosphere.scattering_per_m", "-0.1"),
        ("atmosphere.scattering_per_m", "lots"),
        ("atmosphere.sunlight", "maybe"),
        ("atmosphere.phase", "hg:1"),
        ("atmosphere.phase", "hg:NaN"),
        ("atmosphere.phase", "mie:nonsense"),
        ("background.radiance", "1,2"),
        ("background.radiance", "-1"),
        ("background.image", "no-such-file.exr"),
        ("image.resolution", "0x10"),
        ("image.resolution", "65537x1"),
        ("image.resolution", "65536x65536"),
        ("image.resolution", "1.5x2"),
        ("image.resolution", "100"),
        ("sun.irradiance", "0"),
        ("sun.angular_diameter_deg", "91"),
        ("sun.spectrum", "moon"),
        ("spectral.mode", "bands:0"),
        ("droplets.material", "granite"),
        ("droplets.material", "n=1.33,k=-1"),
        ("droplets.phase", "hg:2"),
        ("droplets.distribution", "gamma:reff=-1um"),
        ("droplets.albedo", "1.01"),
        ("droplets.size_bins", "0"),
        ("droplets.materials", "water;granite"),
        ("effects.glow", "perhaps"),
        ("accuracy.target", "0"),
        ("accuracy.target", "superb"),
        ("accuracy.size_parameter_cap", "2e7"),
        ("accuracy.glow_tolerance", "-0.1"),
        ("accuracy.angle_tolerance", "2"),
    ];
    for (key, value) in bad {
        match three_points().load(&set(&[(key, value)])) {
            Err(error) => {
                let text = error.to_string();
                assert!(matches!(*error.fault, SceneFault::Setting { .. }), "{key}={value}: {text}");
                let remedies =
                    ["expected", "accepted are", "must", "check the path", "needs", "non-negative", "above zero"];
                assert!(text.contains(key) && remedies.iter().any(|remedy| text.contains(remedy)), "{text}");
            }
            Ok(_) => panic!("{key}={value} is accepted"),
        }
    }
}

#[test]
fn droplets_say_their_own_material_node_before_mesh_before_surface() -> Outcome {
    let mut gltf = three_points();
    gltf.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    gltf.json["materials"] = json!([{ "extensions": { "KHR_materials_ior": { "ior": 1.4 } },
        "extras": { "mie_cloud": { "phase": "rayleigh", "albedo": 0.5 } } }]);
    let class = |gltf: &Gltf, options: &LoadOptions| -> Result<_, SceneError> {
        let scene = gltf.load(options)?;
        Ok(scene.classes[usize::from(scene.particles[0].class)].clone())
    };
    let surface = class(&gltf, &options())?;
    assert_eq!((surface.material, surface.albedo), (Material::Constant { n: 1.4, k: 0.0 }, Some(0.5)));
    // A scene that names its material has named it.
    assert_eq!(class(&gltf, &set(&[("droplets.material", "water")]))?.material, Material::Water);
    gltf.json["materials"][0]["extensions"]["KHR_materials_dispersion"] = json!({ "dispersion": 0.36 });
    let Material::Table(table) = class(&gltf, &options())?.material else { panic!("a table") };
    // n(486.1) - n(656.3) = (n - 1) dispersion / 20.
    let n = |nm: usize| table.n[nm - 200];
    assert!(((n(486) - n(656)) / (0.4 * 0.36 / 20.0) - 1.0).abs() < 2e-3);
    gltf.json["meshes"][0]["extras"] = json!({ "mie_cloud": { "material": "ice", "phase": "isotropic" } });
    gltf.json["nodes"][0]["extras"] = json!({ "mie_cloud.phase": "hg:0.5" });
    let class = class(&gltf, &options())?;
    assert_eq!(class.material, Material::Ice);
    assert_eq!(class.phase.to_string(), "hg:0.5");
    assert_eq!(class.albedo, Some(0.5));
    Ok(())
}

// --- files beside the scene ---

#[test]
fn buffers_and_tables_are_read_from_the_scenes_folder_only() -> Outcome {
    let dir = tempfile::tempdir()?;
    let home = dir.path().join("scene");
    std::fs::create_dir_all(home.join("my data"))?;
    let mut gltf = three_points();
    std::fs::write(home.join("my data/a.bin"), &gltf.bytes)?;
    std::fs::write(home.join("stone.csv"), "wavelength_um,n,k\n0.3,1.5,0\n0.9,1.5,0\n")?;
    std::fs::write(dir.path().join("outside.csv"), "wavelength_um,n,k\n0.3,1.5,0\n0.9,1.5,0\n")?;
    gltf.json["buffers"] = json!([{ "byteLength": gltf.bytes.len(), "uri": "my%20data/a.bin" }]);
    gltf.json["scenes"][0]["extras"] = json!({ "mie_cloud": { "droplets": { "material": "stone.csv" } } });
    let path = home.join("scene.gltf");
    std::fs::write(&path, gltf.json.to_string())?;
    let scene = load(&path, &options())?;
    assert!(matches!(scene.settings.droplets.class.material, Material::Table(_)));
    // A longer file serves too; what is behind the buffer is not read.
    let file = std::fs::OpenOptions::new().write(true).open(home.join("my data/a.bin"))?;
    file.set_len(1 << 40)?;
    assert_eq!(load(&path, &options())?.hash, scene.hash);
    // What the user types is unrestricted.
    let outside = dir.path().join("outside.csv");
    load(&path, &set(&[("droplets.material", outside.to_str().ok_or("path")?)]))?;
    gltf.json["scenes"][0]["extras"] = json!({ "mie_cloud": { "droplets": { "material": "../outside.csv" } } });
    std::fs::write(&path, gltf.json.to_string())?;
    assert!(failure(load(&path, &options())).contains("leaves the scene's folder"));
    Ok(())
}

#[test]
fn glb_and_gltf_hold_the_same_scene() -> Outcome {
    let dir = tempfile::tempdir()?;
    let gltf = three_points();
    let path = dir.path().join("scene.bin");
    std::fs::write(&path, glb_of(&gltf))?;
    // Told apart by content, not by name.
    assert_eq!(load(&path, &options())?.hash, gltf.load(&options())?.hash);
    Ok(())
}

#[test]
fn folders_devices_and_missing_files_are_errors() {
    for (path, part) in [("/dev/null", "regular file"), ("/", "regular file"), ("no/such.gltf", "cannot be read")] {
        let text = failure(load(path.as_ref(), &options()));
        assert!(text.starts_with(path) && text.contains(part), "{text}");
    }
}

// --- the whole ---

#[test]
fn a_scene_with_nothing_in_it_is_an_error_unless_air_or_background_show() -> Outcome {
    let mut gltf = Gltf::new();
    gltf.json["nodes"] = json!([{}]);
    let text = failure(gltf.load(&options()));
    assert!(text.contains("--droplets") && text.contains("--radius"), "{text}");
    for (key, value) in [("atmosphere.scattering_per_m", "0.1"), ("background.radiance", "1")] {
        let scene = gltf.load(&set(&[(key, value)]))?;
        assert!(warned(&scene, "no droplets"));
    }
    Ok(())
}

#[test]
fn the_hash_follows_what_is_rendered_and_nothing_else() -> Outcome {
    let mut gltf = three_points();
    let hash = gltf.load(&options())?.hash;
    assert_eq!(hash.len(), 32);
    gltf.json["nodes"][0]["name"] = json!("another name");
    assert_eq!(gltf.load(&options())?.hash, hash);
    assert_ne!(gltf.load(&set(&[("sun.irradiance", "2")]))?.hash, hash);
    gltf.json["nodes"][0]["translation"] = json!([1e-9, 0.0, 0.0]);
    assert_ne!(gltf.load(&options())?.hash, hash);
    Ok(())
}

#[test]
fn a_small_file_cannot_ask_for_much_memory() {
    let mut gltf = three_points();
    let position = gltf.accessor(json!({ "componentType": 5126, "count": 100_000_000_000_u64, "type": "VEC3" }));
    let radius = gltf.accessor(json!({ "componentType": 5126, "count": 100_000_000_000_u64, "type": "SCALAR" }));
    gltf.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": position, "_RADIUS": radius });
    assert!(failure(gltf.load(&options())).contains("--memory-limit"));
}

/// A long name may be kept once, not for every instance of a fog box and every node that holds a light.
#[test]
fn long_names_are_not_multiplied() -> Outcome {
    let mut gltf = Gltf::new();
    gltf.json["meshes"] = json!([cube_mesh(&mut gltf)]);
    let (long, mark) = ("n".repeat(10_000), json!({ "kind": "fog", "number_per_m3": 1e8 }));
    gltf.json["nodes"] = json!([{ "name": long, "mesh": 0, "extras": { "mie_cloud": mark } },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } }]);
    gltf.json["scenes"][0]["nodes"] = json!([0, 1]);
    let lights = json!([{ "type": "directional", "name": "s".repeat(10_000) }]);
    gltf.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    let scene = gltf.load(&options())?;
    let names = [&scene.fog_boxes[0].name, &scene.suns[0].name];
    assert!(names.iter().all(|name| (80..100).contains(&name.len())), "{names:?}");
    Ok(())
}

#[test]
fn the_documentation_has_every_key_with_unit_default_and_range() {
    use mie_cloud::scene::{keys, marks};
    let document = include_str!("../docs/scene-format.md");
    let documented = |name: &str, unit: &str, default: &str, range: &str| {
        let row = format!("| `{name}` | {unit} | {default} | {range} | ");
        assert!(document.lines().any(|line| line.starts_with(&row)), "no row `{row}`");
    };
    keys::SETTINGS.iter().for_each(|k| documented(k.name, k.unit, k.default, k.range));
    marks::MARKS.iter().for_each(|k| documented(k.name, k.unit, k.default, k.range));
    marks::LIGHT.iter().for_each(|k| documented(k.name, k.unit, k.default, k.range));
    let rows = document.lines().filter(|line| line.starts_with("| `")).filter(|l| l.matches('|').count() == 6).count();
    assert_eq!(rows, keys::SETTINGS.len() + marks::MARKS.len() + marks::LIGHT.len());
}

#[test]
fn defaults_are_what_the_key_table_says() -> Outcome {
    use mie_cloud::scene::keys::SETTINGS;
    let scene = three_points().load(&options())?;
    // Keys whose default is a value, not a description of one.
    let described = ["from Mie theory", "none", "from the accuracy", "from the target"];
    let literal: Vec<_> = SETTINGS.iter().filter(|k| !described.contains(&k.default)).collect();
    assert!(literal.len() > 20);
    let flags: Vec<(&str, &str)> = literal.iter().map(|k| (k.name, k.default)).collect();
    let mut written = three_points().load(&set(&flags))?.settings;
    // Auto is the absence of a switch.
    written.effects.retain(|_, switch| *switch != Switch::Auto);
    assert_eq!(written, scene.settings);
    Ok(())
}

#[test]
fn effects_are_keyed_by_their_own_names() {
    for (k, (_, name)) in Effect::ALL.iter().enumerate() {
        let scene = three_points().load(&set(&[(&format!("effects.{name}"), "off")]));
        let effects = scene.map(|s| s.settings.effects).unwrap_or_default();
        assert_eq!(effects.into_iter().collect::<Vec<_>>(), [(Effect::ALL[k].0, Switch::Off)]);
    }
}
