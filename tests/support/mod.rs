//! Builds small glTF files for tests.

#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mie_cloud::scene::model::Scene;
use mie_cloud::scene::{LoadOptions, SceneError, load};
use serde_json::{Value, json};

/// A file of the test data.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// A glTF document and its one buffer.
pub struct Gltf {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Gltf {
    /// One scene with node 0 as its root, which is still to be given.
    pub fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
            "accessors": [], "bufferViews": [], "extensionsUsed": [],
        });
        Self { json, bytes: Vec::new() }
    }

    /// Adds a buffer view.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        push(&mut self.json["bufferViews"], view)
    }

    /// Adds an accessor.
    pub fn accessor(&mut self, accessor: Value) -> usize {
        push(&mut self.json["accessors"], accessor)
    }

    /// Adds an accessor of 32-bit floats with its view.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            _ => 4,
        };
        let view = self.view(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
        let count = values.len() / width;
        self.accessor(json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }))
    }

    /// The document with its buffer inside.
    pub fn to_text(&self) -> String {
        let mut json = self.json.clone();
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        json.to_string()
    }

    /// Writes the document to a temporary folder and loads it.
    pub fn load(&self, options: &LoadOptions) -> Result<Scene, SceneError> {
        load_bytes(self.to_text().as_bytes(), options)
    }
}

/// A file with every form of droplets, fog, a camera, two lights and settings in it.
pub fn everything() -> Gltf {
    let mut gltf = Gltf::new();
    let position = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let [radius, own, count, material] = [[0.1, 0.2, 0.3], [5.0, 6.0, 7.0], [1.0, 50.0, 1e9], [0.0, 1.0, 0.0]]
        .map(|values: [f32; 3]| gltf.floats("SCALAR", &values));
    let translation = gltf.floats("VEC3", &[0.0, 1.0, 0.0, 0.0, 2.0, 0.0]);
    let rotation = gltf.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let (indices, values) = (gltf.view(&[0, 2]), gltf.view(&[51, 255]));
    let sparse = gltf.accessor(json!({ "componentType": 5121, "normalized": true, "count": 3, "type": "SCALAR",
        "sparse": { "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values } } }));
    let full = json!({ "POSITION": position, "_RADIUS": radius, "_DROPLET_RADIUS_UM": own, "_DROPLET_COUNT": count, "_MATERIAL": material });
    let plain = json!({ "POSITION": position, "_RADIUS": sparse });
    gltf.json["meshes"] = json!([
        { "primitives": [{ "mode": 0, "attributes": full, "material": 0 }, { "mode": 0, "attributes": plain }] },
        { "primitives": [{ "attributes": { "POSITION": translation }, "material": 0 }], "extras": { "mie_cloud": { "kind": "droplet", "phase": "hg:0.8" } } },
        { "primitives": [{ "mode": 0, "attributes": plain }], "extras": { "mie_cloud": { "kind": "fog", "extinction_per_m": 0.5 } } },
    ]);
    gltf.json["materials"] = json!([{ "name": "drop", "extensions": { "KHR_materials_ior": { "ior": 1.4 }, "KHR_materials_dispersion": { "dispersion": 0.3 } } }]);
    gltf.json["nodes"] = json!([
        { "name": "root", "children": [1, 2, 3, 4, 5, 6], "scale": [2.0, 2.0, 2.0] },
        { "name": "points", "mesh": 0, "translation": [1.0, 2.0, 3.0] },
        { "name": "spheres", "mesh": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translation, "ROTATION": rotation } } } },
        { "name": "balls", "mesh": 2, "rotation": [0.0, 0.6, 0.0, 0.8] },
        { "name": "camera", "camera": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,9,1] },
        { "name": "sun", "extensions": { "KHR_lights_punctual": { "light": 0 } }, "extras": { "mie_cloud.spectrum": "d65" } },
        { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 1 } } },
    ]);
    gltf.json["cameras"] =
        json!([{ "type": "orthographic", "orthographic": { "xmag": 2.0, "ymag": 1.0, "znear": 0.1, "zfar": 10.0 } }]);
    gltf.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "intensity": 90000.0, "color": [1.0, 0.9, 0.8] }, { "type": "spot" } ] } });
    gltf.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    gltf.json["scenes"][0]["extras"] = json!({ "mie_cloud": { "droplets": { "materials": ["water", "ice"] },
        "atmosphere": { "step_m": 0.25, "phase": "rayleigh" }, "image": { "resolution": [64, 36] } } });
    gltf
}

/// Loads a file of these bytes.
pub fn load_bytes(bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let file = tempfile::NamedTempFile::new().unwrap_or_else(|e| panic!("temporary file: {e}"));
    std::fs::write(file.path(), bytes).unwrap_or_else(|e| panic!("temporary file: {e}"));
    load(file.path(), options)
}

/// The document as a GLB file.
pub fn glb_of(gltf: &Gltf) -> Vec<u8> {
    let mut json = gltf.json.clone();
    json["buffers"] = json!([{ "byteLength": gltf.bytes.len() }]);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + text.len() + gltf.bytes.len()) as u32).to_le_bytes());
    for (kind, data) in [(b"JSON", &text), (b"BIN\0", &gltf.bytes)] {
        out.extend((data.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(data);
    }
    out
}

fn push(array: &mut Value, item: Value) -> usize {
    let Some(items) = array.as_array_mut() else { panic!("not an array") };
    items.push(item);
    items.len() - 1
}
