//! What can be wrong with a scene: each error names the file, the element, what was expected and what to do.

use std::path::PathBuf;

use thiserror::Error;

use crate::excerpt::printable;
use crate::units::format_bytes;

/// A scene could not be read.
#[derive(Debug, Error)]
#[error("{}: {}{}", .file.display(), if .element.is_empty() { String::new() } else { format!("{}: ", printable(element)) }, printable(&.fault.to_string()))]
#[non_exhaustive]
pub struct SceneError {
    /// The file that was read.
    pub file: PathBuf,
    /// The element at fault as it is written in the file (`accessors[3]`, `nodes[2] "Droplets"`); may be empty.
    pub element: String,
    /// What is wrong with it.
    pub fault: Box<SceneFault>,
}

/// What is wrong with an element of a scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneFault {
    /// The file cannot be opened or read.
    #[error("cannot be read ({0}); check the path and its permissions")]
    Unreadable(std::io::Error),
    /// The path leads to a folder, a device or a pipe.
    #[error("is not a regular file; give the path of a .gltf or .glb file")]
    NotAFile,
    /// The file is of another kind.
    #[error("begins neither like glTF JSON nor like GLB; give the path of a .gltf or .glb file")]
    NotAScene,
    /// The JSON is broken, or an element does not have the form that glTF 2.0 demands.
    #[error("is not valid glTF 2.0 JSON ({0}); export the file again or mend it there")]
    Json(String),
    /// Settings that are written as JSON text are broken.
    #[error("is not valid JSON ({0}); write an object such as {{\"atmosphere\": {{\"step_m\": 0.1}}}}")]
    SettingsJson(String),
    /// Objects and arrays are nested without end.
    #[error("JSON is nested more than {limit} levels deep; no glTF needs that, export the file again")]
    Nesting { limit: usize },
    /// The GLB container is broken.
    #[error("broken GLB container: {0}; export the file again")]
    Container(String),
    /// The file is of another version of glTF.
    #[error("is glTF version {0}; version 2.x is expected: convert the file")]
    Version(String),
    /// An extension is required that is not understood.
    #[error("requires the extension {name}, which is not understood; {remedy}")]
    Extension { name: String, remedy: &'static str },
    /// A part that glTF demands is missing.
    #[error("has no {what}; {remedy}")]
    Missing { what: &'static str, remedy: &'static str },
    /// An index points outside its array.
    #[error("refers to {target}[{index}], but the file has {len} of them, counted from 0; export the file again")]
    Index { target: &'static str, index: u64, len: usize },
    /// A URI or path that may not or cannot be read.
    #[error("`{uri}` {problem}; {remedy}")]
    Uri { uri: String, problem: String, remedy: &'static str },
    /// Data are shorter than the file says.
    #[error("needs {needs} bytes of {of}, which has {has}; the file is damaged or was cut short")]
    TooShort { needs: String, of: String, has: u64 },
    /// An accessor's form does not fit its use.
    #[error("{problem}; expected {expected}")]
    Accessor { problem: String, expected: String },
    /// A number is NaN or infinite.
    #[error("element {index} is {value}; expected a finite number")]
    NotFinite { index: u64, value: f64 },
    /// A number is outside its range.
    #[error("{what} is {}; expected {expected}", legible(*.value))]
    Range { what: String, value: f64, expected: &'static str },
    /// The node graph is no forest.
    #[error("{0}; a glTF scene is a tree in which every node has one parent: mend the hierarchy")]
    NodeGraph(String),
    /// Radii that a quantiser has turned into zeros.
    #[error(
        "{zeros} of {count} radii are zero: a quantiser has probably rounded micrometre radii given in metres; store \
         them as 32-bit floats, or around 1 under a scaled node, or give --radius"
    )]
    ZeroRadii { zeros: u64, count: u64 },
    /// A setting has the wrong type or is out of range.
    #[error("{key} = {value}: {problem}")]
    Setting { key: String, value: String, problem: String },
    /// A key that does not exist.
    #[error("unknown key `{key}`; {suggestion}")]
    UnknownKey { key: String, suggestion: String },
    /// Marks that contradict each other or say too little.
    #[error("{problem}; {remedy}")]
    Mark { problem: String, remedy: &'static str },
    /// The scene would need more memory than its files can justify.
    #[error(
        "{what} need {}, but {} are left of what files of this size may take; {remedy}",
        format_bytes(*.bytes), format_bytes(*.limit)
    )]
    TooLarge { what: String, bytes: u64, limit: u64, remedy: &'static str },
    /// The scene would need more memory than there is, or than the user allows.
    #[error(
        "{what} need {}, but {} are left of what may be used; make the scene smaller, or raise --memory-limit if there is more",
        format_bytes(*.bytes), format_bytes(*.limit)
    )]
    Memory { what: String, bytes: u64, limit: u64 },
    /// There is no camera of that name.
    #[error("no camera is called `{name}`; {available}")]
    NoSuchCamera { name: String, available: String },
    /// Nothing in the scene could make a picture.
    #[error(
        "nothing to render: no droplets, no fog, no air that scatters, no background{found}; mark sphere meshes with \
         extras.mie_cloud.kind = \"droplet\" or --droplets 'NAME*', boxes with kind = \"fog\", give bare points a \
         --radius, or set atmosphere.scattering_per_m or background.radiance"
    )]
    Empty {
        /// What is there instead; empty, or after a semicolon.
        found: String,
    },
}

impl SceneError {
    /// An error at an element; the file is filled in by [`SceneError::in_file`].
    pub(crate) fn at(element: impl Into<String>, fault: SceneFault) -> Self {
        Self { file: PathBuf::new(), element: element.into(), fault: Box::new(fault) }
    }

    /// Names the file, unless a more precise one has been named.
    pub(crate) fn in_file(mut self, file: &std::path::Path) -> Self {
        if self.file.as_os_str().is_empty() {
            self.file = file.to_path_buf();
        }
        self
    }
}

/// The result of reading a part of a scene.
pub(crate) type SceneResult<T> = Result<T, SceneError>;

/// A number without rows of zeros.
fn legible(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}
