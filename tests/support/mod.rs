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
