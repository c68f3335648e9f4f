//! The JSON of a glTF file, parsed element by element: an index of raw text, so that memory stays near the file's size.
//!
//! Arrays hold slices of the text (16 bytes for an element of at least two); an element is parsed when it is asked
//! for, into a structure with only the members that are needed. Leaf types (component and accessor types, primitive
//! modes) are those of the `gltf` crate; its own root structure keeps every extension and extra as a tree, up to ninety
//! times the size of the text, and panics or overflows where files lie.

use gltf::json::accessor::{GenericComponentType, IndexComponentType, Type};
use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;
use serde::Deserialize;
use serde_json::value::RawValue;

use crate::scene::error::{SceneError, SceneFault, SceneResult};

/// Deeper nesting than this is refused: serde_json's own recursion limit, checked here for skipped parts too.
const NESTING_LIMIT: usize = 128;

/// The top level of a glTF file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document<'a> {
    pub asset: Asset,
    #[serde(default)]
    pub extensions_used: Vec<String>,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    pub scene: Option<u64>,
    #[serde(borrow, default)]
    pub scenes: Elements<'a>,
    #[serde(borrow, default)]
    pub nodes: Elements<'a>,
    #[serde(borrow, default)]
    pub meshes: Elements<'a>,
    #[serde(borrow, default)]
    pub materials: Elements<'a>,
    #[serde(borrow, default)]
    pub cameras: Elements<'a>,
    #[serde(borrow, default)]
    pub accessors: Elements<'a>,
    #[serde(borrow, default)]
    pub buffer_views: Elements<'a>,
    #[serde(borrow, default)]
    pub buffers: Elements<'a>,
    #[serde(borrow, default)]
    pub animations: Elements<'a>,
    #[serde(borrow, default)]
    pub skins: Elements<'a>,
    #[serde(borrow, default)]
    pub textures: Elements<'a>,
    #[serde(borrow, default)]
    pub images: Elements<'a>,
    #[serde(borrow, default)]
    pub extensions: RootExtensions<'a>,
}

/// An array of elements that have not been parsed yet.
#[derive(Debug, Default, Deserialize)]
#[serde(transparent)]
pub struct Elements<'a>(#[serde(borrow)] Vec<&'a RawValue>);

#[derive(Debug, Deserialize)]
pub struct Asset {
    pub version: String,
    #[serde(rename = "minVersion")]
    pub min_version: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
pub struct RootExtensions<'a> {
    #[serde(borrow, rename = "KHR_lights_punctual")]
    pub lights: Option<Lights<'a>>,
}

#[derive(Debug, Deserialize)]
pub struct Lights<'a> {
    #[serde(borrow, default)]
    pub lights: Elements<'a>,
}

#[derive(Debug, Deserialize)]
pub struct Scene<'a> {
    pub name: Option<String>,
    #[serde(default)]
    pub nodes: Vec<u32>,
    #[serde(borrow)]
    pub extras: Option<&'a RawValue>,
}

/// The part of a node that the graph needs.
#[derive(Debug, Deserialize)]
pub struct Children {
    #[serde(default)]
    pub children: Vec<u32>,
}

#[derive(Debug, Deserialize)]
pub struct Node<'a> {
    pub name: Option<String>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub mesh: Option<u32>,
    pub camera: Option<u32>,
    pub skin: Option<u32>,
    #[serde(borrow, default)]
    pub extensions: NodeExtensions<'a>,
    #[serde(borrow)]
    pub extras: Option<&'a RawValue>,
}

#[derive(Debug, Default, Deserialize)]
pub struct NodeExtensions<'a> {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<LightIndex>,
    #[serde(borrow, rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing<'a>>,
}

#[derive(Debug, Deserialize)]
pub struct LightIndex {
    pub light: u32,
}

#[derive(Debug, Deserialize)]
pub struct Instancing<'a> {
    /// Parsed by the reader of instances.
    #[serde(borrow)]
    pub attributes: &'a RawValue,
}

#[derive(Debug, Deserialize)]
pub struct Mesh<'a> {
    pub name: Option<String>,
    #[serde(borrow)]
    pub primitives: Elements<'a>,
    #[serde(borrow)]
    pub extras: Option<&'a RawValue>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive<'a> {
    #[serde(borrow)]
    pub attributes: &'a RawValue,
    #[serde(default = "triangles")]
    pub mode: Checked<Mode>,
    pub material: Option<u32>,
    #[serde(borrow)]
    pub targets: Option<&'a RawValue>,
}

fn triangles() -> Checked<Mode> {
    Checked::Valid(Mode::Triangles)
}

#[derive(Debug, Deserialize)]
pub struct Material<'a> {
    pub name: Option<String>,
    #[serde(default)]
    pub extensions: MaterialExtensions,
    #[serde(borrow)]
    pub extras: Option<&'a RawValue>,
}

#[derive(Debug, Default, Deserialize)]
pub struct MaterialExtensions {
    #[serde(rename = "KHR_materials_ior")]
    pub ior: Option<Ior>,
    #[serde(rename = "KHR_materials_dispersion")]
    pub dispersion: Option<Dispersion>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Ior {
    pub ior: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Dispersion {
    #[serde(default)]
    pub dispersion: f64,
}

#[derive(Debug, Deserialize)]
pub struct Camera {
    pub name: Option<String>,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
    #[serde(rename = "type")]
    pub kind: String,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    pub yfov: f64,
    pub aspect_ratio: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Orthographic {
    pub xmag: f64,
    pub ymag: f64,
}

#[derive(Debug, Deserialize)]
pub struct Light<'a> {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: String,
    pub intensity: Option<f64>,
    pub color: Option<[f64; 3]>,
    #[serde(borrow)]
    pub extras: Option<&'a RawValue>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<u32>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: Checked<GenericComponentType>,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: Checked<Type>,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: Checked<IndexComponentType>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer<'a> {
    /// Raw, because a data URI can be as long as the file.
    #[serde(borrow)]
    pub uri: Option<&'a RawValue>,
    pub byte_length: u64,
}

impl<'a> Elements<'a> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Parses element `index` of the array called `name`; `by` is the element that refers to it.
    ///
    /// # Errors
    /// When the index is out of bounds, or the element has not the form that glTF demands.
    pub fn get<T: Deserialize<'a>>(&self, name: &'static str, index: u32, by: &str) -> SceneResult<T> {
        let found = self.0.get(index as usize);
        let raw = found.ok_or_else(|| self.out_of_bounds(name, index, by))?;
        parse(raw, || format!("{name}[{index}]"))
    }

    fn out_of_bounds(&self, name: &'static str, index: u32, by: &str) -> SceneError {
        SceneError::at(by, SceneFault::Index { target: name, index: index.into(), len: self.len() })
    }
}

/// Parses raw JSON into what is needed of it.
///
/// # Errors
/// When it has not the form that glTF demands.
pub fn parse<'a, T: Deserialize<'a>>(raw: &'a RawValue, element: impl FnOnce() -> String) -> SceneResult<T> {
    serde_json::from_str(raw.get()).map_err(|e| SceneError::at(element(), SceneFault::Json(e.to_string())))
}

/// Parses the top level of a glTF file.
///
/// # Errors
/// For broken JSON, nesting without end, and other versions of glTF.
pub fn read(json: &[u8]) -> SceneResult<Document<'_>> {
    check_nesting(json)?;
    let document: Document =
        serde_json::from_slice(json).map_err(|e| SceneError::at("", SceneFault::Json(e.to_string())))?;
    let needed = document.asset.min_version.as_ref().unwrap_or(&document.asset.version);
    if needed.starts_with("2.") || needed == "2" {
        Ok(document)
    } else {
        Err(SceneError::at("asset", SceneFault::Version(crate::excerpt::excerpt(needed))))
    }
}

/// Counts open brackets outside strings; skipped parts of the file would otherwise nest as deep as they like.
fn check_nesting(json: &[u8]) -> SceneResult<()> {
    let (mut depth, mut in_string, mut escaped) = (0_usize, false, false);
    for byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            b'[' | b'{' if !in_string => depth += 1,
            b']' | b'}' if !in_string => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth >= NESTING_LIMIT {
            return Err(SceneError::at("", SceneFault::Nesting { limit: NESTING_LIMIT }));
        }
    }
    Ok(())
}

/// An element as it is named in messages: `nodes[2] "Droplets"`.
pub fn label(array: &str, index: u32, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{array}[{index}] \"{}\"", crate::excerpt::excerpt(name)),
        None => format!("{array}[{index}]"),
    }
}
