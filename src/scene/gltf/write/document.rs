//! The JSON of a generated scene: a scaled node with the particles, a camera, a sun, settings and recipe.

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Map, Value, json};

use super::buffer::{Buffer, Data, Target};
use crate::scene::generate::{Cloud, Form};
use crate::scene::model::{Camera, Lens, Sun};

/// The document, whose buffer is described but not yet packed, and that buffer.
pub(super) fn build(cloud: &Cloud) -> (Value, Buffer<'_>) {
    let mut buffer = Buffer::default();
    let (mesh, node_extensions) = match cloud.form {
        Form::Points => (points(cloud, &mut buffer), None),
        Form::Instances => {
            let mesh = sphere(&mut buffer);
            (mesh, Some(instances(cloud, &mut buffer)))
        }
    };
    let (buffer_views, accessors) = buffer.describe();
    let mut document = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("mie-cloud ", env!("CARGO_PKG_VERSION")),
            "extras": { "mie_cloud_generator": cloud.recipe },
        },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [light(&cloud.sun)] } },
        "scene": 0,
        "scenes": [{ "name": "cloud", "nodes": [0, 1, 2], "extras": { "mie_cloud": cloud.settings } }],
        "nodes": [cloud_node(cloud), camera_node(&cloud.camera), sun_node(&cloud.sun, &cloud.camera)],
        "cameras": [camera(&cloud.camera)],
        "meshes": [mesh],
        "accessors": accessors,
        "bufferViews": buffer_views,
        "buffers": [{ "byteLength": buffer.len_bytes() }],
    });
    if let Some(extensions) = node_extensions {
        document["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_lights_punctual"]);
        document["nodes"][0]["extensions"] = extensions;
    }
    (document, buffer)
}

/// One POINTS primitive.
fn points<'a>(cloud: &'a Cloud, buffer: &mut Buffer<'a>) -> Value {
    let mut attributes = Map::new();
    let mut add = |name: &str, data| attributes.insert(name.into(), buffer.push(data, Some(Target::Vertices)).into());
    add("POSITION", Data::Vectors(&cloud.positions));
    add("_RADIUS", Data::Scalars(&cloud.radii));
    for (name, values) in droplet_attributes(cloud) {
        add(name, Data::Scalars(values));
    }
    json!({ "name": "particles", "primitives": [{ "mode": 0, "attributes": attributes }] })
}

/// What particles hold, in either form.
fn droplet_attributes(cloud: &Cloud) -> impl Iterator<Item = (&'static str, &[f32])> {
    let radii = cloud.droplet_radii_um.as_deref().map(|radii| ("_DROPLET_RADIUS_UM", radii));
    let counts = cloud.droplet_counts.as_deref().map(|counts| ("_DROPLET_COUNT", counts));
    radii.into_iter().chain(counts)
}

/// The node's EXT_mesh_gpu_instancing: SCALE is the drawn radius, because the mesh has radius 1. The extension is not
/// required: a program that lacks it shows one sphere and everything else.
fn instances<'a>(cloud: &'a Cloud, buffer: &mut Buffer<'a>) -> Value {
    let mut attributes = Map::new();
    let mut add = |name: &str, data| attributes.insert(name.into(), buffer.push(data, None).into());
    add("TRANSLATION", Data::Vectors(&cloud.positions));
    add("SCALE", Data::Repeated(&cloud.radii));
    for (name, values) in droplet_attributes(cloud) {
        add(name, Data::Scalars(values));
    }
    json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } })
}

/// An icosahedron of radius 1, few triangles because it is drawn a million times.
fn sphere<'a>(buffer: &mut Buffer<'a>) -> Value {
    let vertices = buffer.push(Data::Vectors(&ICOSAHEDRON), Some(Target::Vertices));
    let indices = buffer.push(Data::Indices(&ICOSAHEDRON_FACES), Some(Target::Indices));
    json!({
        "name": "particle",
        // On a sphere of radius 1 around the origin, positions are normals.
        "primitives": [{ "attributes": { "POSITION": vertices, "NORMAL": vertices }, "indices": indices }],
    })
}

/// 1 / sqrt(1 + phi^2) and phi / sqrt(1 + phi^2), phi the golden ratio.
const A: f32 = 0.525_731_1;
const B: f32 = 0.850_650_8;

const ICOSAHEDRON: [[f32; 3]; 12] = [
    [-A, B, 0.0],
    [A, B, 0.0],
    [-A, -B, 0.0],
    [A, -B, 0.0],
    [0.0, -A, B],
    [0.0, A, B],
    [0.0, -A, -B],
    [0.0, A, -B],
    [B, 0.0, -A],
    [B, 0.0, A],
    [-B, 0.0, -A],
    [-B, 0.0, A],
];

/// Counter-clockwise seen from outside.
#[rustfmt::skip]
const ICOSAHEDRON_FACES: [u16; 60] = [
    0, 11, 5,  0, 5, 1,   0, 1, 7,   0, 7, 10,  0, 10, 11,
    1, 5, 9,   5, 11, 4,  11, 10, 2, 10, 7, 6,  7, 1, 8,
    3, 9, 4,   3, 4, 2,   3, 2, 6,   3, 6, 8,   3, 8, 9,
    4, 9, 5,   2, 4, 11,  6, 2, 10,  8, 6, 7,   9, 8, 1,
];

fn cloud_node(cloud: &Cloud) -> Value {
    let scale = [cloud.metres_per_unit; 3];
    json!({ "name": "Cloud", "mesh": 0, "scale": scale })
}

fn camera_node(camera: &Camera) -> Value {
    json!({
        "name": camera.name,
        "camera": 0,
        "translation": camera.position_m.to_array(),
        "rotation": rotation(camera.world_from_camera),
    })
}

/// Near and far planes bracket what the camera can see of a cloud around the origin; only viewers use them.
fn camera(camera: &Camera) -> Value {
    let far = 10.0 * camera.position_m.length().max(f64::from(f32::MIN_POSITIVE));
    let near = 1e-4 * far;
    match camera.lens {
        Lens::Perspective { yfov_rad, aspect } => {
            let mut perspective = json!({ "yfov": yfov_rad, "znear": near, "zfar": far });
            if let Some(aspect) = aspect {
                perspective["aspectRatio"] = aspect.into();
            }
            json!({ "name": camera.name, "type": "perspective", "perspective": perspective })
        }
        Lens::Orthographic { xmag_m, ymag_m } => json!({
            "name": camera.name,
            "type": "orthographic",
            "orthographic": { "xmag": xmag_m, "ymag": ymag_m, "znear": near, "zfar": far },
        }),
    }
}

/// The sun shines along its node's -Z; it stands as far away as the camera, where editors show it.
fn sun_node(sun: &Sun, camera: &Camera) -> Value {
    let backward = -sun.direction;
    let up = if backward.y.abs() > 0.999_999 { DVec3::Z } else { DVec3::Y };
    let right = up.cross(backward).normalize_or(DVec3::X);
    json!({
        "name": sun.name,
        "translation": (backward * camera.position_m.length()).to_array(),
        "rotation": rotation(DMat3::from_cols(right, backward.cross(right), backward)),
        "extensions": { "KHR_lights_punctual": { "light": 0 } },
    })
}

fn light(sun: &Sun) -> Value {
    json!({ "name": sun.name, "type": "directional", "color": sun.color, "intensity": sun.lux })
}

/// A rotation as glTF's quaternion x, y, z, w.
fn rotation(world_from_node: DMat3) -> [f64; 4] {
    DQuat::from_mat3(&world_from_node).normalize().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_icosahedron_is_a_closed_surface_of_radius_one_facing_outwards() {
        for vertex in ICOSAHEDRON {
            assert!((DVec3::from(vertex.map(f64::from)).length() - 1.0).abs() < 1e-6);
        }
        let mut edges = std::collections::HashSet::new();
        for face in ICOSAHEDRON_FACES.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| DVec3::from(ICOSAHEDRON[face[i] as usize].map(f64::from)));
            assert!((b - a).cross(c - a).dot(a) > 0.1);
            for i in 0..3 {
                assert!(edges.insert((face[i], face[(i + 1) % 3])), "an edge is used twice in one direction");
            }
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
    }
}
