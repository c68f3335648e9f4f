//! glTF documents of scenes: a generated cloud, or none, and boxes of fog.

use std::error::Error;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DMat3, DQuat, DVec3};
use mie_cloud::scene::generate::Recipe;
use mie_cloud::scene::gltf::write::write_gltf;
use mie_cloud::study::make_cloud;
use serde_json::{Map, Value, json};

/// The document of a generated cloud.
pub fn of_cloud(recipe: &Recipe) -> Result<Value, Box<dyn Error>> {
    let cloud = make_cloud(recipe)?;
    cloud.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    let mut text = Vec::new();
    write_gltf(&cloud, &mut text)?;
    Ok(serde_json::from_slice(&text)?)
}

/// Where a camera stands and looks, and how high its picture is.
pub struct View {
    pub position_m: DVec3,
    pub direction: DVec3,
    pub yfov_deg: f64,
}

/// A document with a camera, a sun of 100 klx whose light travels along `sunlight`, and no fog yet.
pub fn without_fog(view: &View, sunlight: DVec3, settings: Value) -> Value {
    let lens = json!({ "yfov": view.yfov_deg.to_radians(), "aspectRatio": 16.0 / 9.0, "znear": 0.1, "zfar": 1e4 });
    json!({
        "asset": { "version": "2.0", "generator": concat!("mie-cloud ", env!("CARGO_PKG_VERSION")) },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": {
            "lights": [{ "name": "Sun", "type": "directional", "color": [1.0, 1.0, 1.0], "intensity": 1e5 }],
        } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1], "extras": { "mie_cloud": settings } }],
        "nodes": [
            { "name": "Camera", "camera": 0, "translation": view.position_m.to_array(), "rotation": facing(view.direction) },
            { "name": "Sun", "rotation": facing(sunlight), "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "cameras": [{ "name": "Camera", "type": "perspective", "perspective": lens }],
        "meshes": [],
        "accessors": [],
        "bufferViews": [],
        "buffers": [],
    })
}

/// A droplet, in the units of its node.
pub struct Sphere {
    pub center: [f32; 3],
    pub radius: f32,
}

/// Adds droplets as points with radii under a node of the given scale.
pub fn add_points(document: &mut Value, name: &str, scale: f64, spheres: &[Sphere]) {
    let centers = spheres.iter().flat_map(|sphere| sphere.center);
    let bytes: Vec<u8> = centers.chain(spheres.iter().map(|sphere| sphere.radius)).flat_map(f32::to_le_bytes).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let buffer = push(document, "buffers", json!({ "byteLength": bytes.len(), "uri": uri }));
    let split = 12 * spheres.len();
    let view = |offset: usize, length: usize| json!({ "buffer": buffer, "byteOffset": offset, "byteLength": length, "target": 34962 });
    let centers = push(document, "bufferViews", view(0, split));
    let radii = push(document, "bufferViews", view(split, bytes.len() - split));
    let ends = |pick: fn(f32, f32) -> f32| {
        let fold = |axis: usize| spheres.iter().map(|sphere| sphere.center[axis]).reduce(pick);
        [0, 1, 2].map(fold)
    };
    let accessor = |view: usize, kind: &str| json!({ "bufferView": view, "componentType": 5126, "count": spheres.len(), "type": kind });
    let mut positions = accessor(centers, "VEC3");
    (positions["min"], positions["max"]) = (json!(ends(f32::min)), json!(ends(f32::max)));
    let positions = push(document, "accessors", positions);
    let radii = push(document, "accessors", accessor(radii, "SCALAR"));
    let primitive = json!({ "mode": 0, "attributes": { "POSITION": positions, "_RADIUS": radii } });
    let mesh = push(document, "meshes", json!({ "name": name, "primitives": [primitive] }));
    let node = push(document, "nodes", json!({ "name": name, "mesh": mesh, "scale": [scale, scale, scale] }));
    push(&mut document["scenes"][0], "nodes", node.into());
}

/// A box of fog.
pub struct FogBox {
    pub center_m: [f64; 3],
    pub size_m: [f64; 3],
    pub extinction_per_m: f64,
    /// What of the light a solid thing gives back, evenly in all directions; none for fog.
    pub albedo: Option<f64>,
}

/// Adds boxes of fog, which share the cube's corners.
pub fn add_fog(document: &mut Value, boxes: &[FogBox]) {
    let cube = add_cube(document);
    for fog in boxes {
        let mut mark = json!({ "kind": "fog", "extinction_per_m": fog.extinction_per_m });
        if let Some(albedo) = fog.albedo {
            (mark["albedo"], mark["phase"]) = (json!(albedo), json!("isotropic"));
        }
        let mesh = json!({ "name": "fog", "primitives": [cube], "extras": { "mie_cloud": mark } });
        let mesh = push(document, "meshes", mesh);
        let node = json!({ "name": "Fog", "mesh": mesh, "translation": fog.center_m, "scale": fog.size_m });
        let node = push(document, "nodes", node);
        push(&mut document["scenes"][0], "nodes", node.into());
    }
}

/// The corners and triangles of a cube with edges of 1, as a primitive.
fn add_cube(document: &mut Value) -> Value {
    const CORNERS: usize = 8;
    #[rustfmt::skip]
    const TRIANGLES: [u16; 36] = [
        0, 1, 3,  0, 3, 2,  4, 6, 7,  4, 7, 5,  0, 4, 5,  0, 5, 1,
        2, 3, 7,  2, 7, 6,  0, 2, 6,  0, 6, 4,  1, 5, 7,  1, 7, 3,
    ];
    let side = |corner: usize, bit: usize| if corner >> bit & 1 == 0 { -0.5_f32 } else { 0.5 };
    let corners = (0..CORNERS).flat_map(|corner| [2, 1, 0].map(|bit| side(corner, bit).to_le_bytes()).concat());
    let bytes: Vec<u8> = corners.chain(TRIANGLES.iter().flat_map(|index| index.to_le_bytes())).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let buffer = push(document, "buffers", json!({ "byteLength": bytes.len(), "uri": uri }));
    let split = 12 * CORNERS;
    let view = |offset: usize, length: usize, target: u32| json!({ "buffer": buffer, "byteOffset": offset, "byteLength": length, "target": target });
    let corners = push(document, "bufferViews", view(0, split, 34962));
    let triangles = push(document, "bufferViews", view(split, bytes.len() - split, 34963));
    let positions = json!({
        "bufferView": corners, "componentType": 5126, "count": CORNERS, "type": "VEC3",
        "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5],
    });
    let indices = json!({ "bufferView": triangles, "componentType": 5123, "count": TRIANGLES.len(), "type": "SCALAR" });
    let (positions, indices) = (push(document, "accessors", positions), push(document, "accessors", indices));
    json!({ "attributes": { "POSITION": positions }, "indices": indices })
}

/// Appends to a list of the document and returns the place.
fn push(object: &mut Value, list: &str, value: Value) -> usize {
    match object[list].as_array_mut() {
        Some(list) => {
            list.push(value);
            list.len() - 1
        }
        None => {
            object[list] = json!([value]);
            0
        }
    }
}

/// The rotation that turns -Z, along which cameras look and suns shine, into a direction, and keeps +X level.
fn facing(direction: DVec3) -> [f64; 4] {
    let backward = -direction.normalize();
    let right = DVec3::Y.cross(backward).normalize();
    DQuat::from_mat3(&DMat3::from_cols(right, backward.cross(right), backward)).normalize().to_array()
}

/// Settings as a recipe takes them.
pub fn settings(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(settings) => settings,
        _ => Map::new(),
    }
}

/// Distributions and materials of scenes that come with the program are no files.
pub fn no_files(name: &str) -> Result<String, String> {
    Err(format!("{name} may not be read"))
}
