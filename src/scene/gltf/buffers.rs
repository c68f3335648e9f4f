//! The bytes of buffers and buffer views: data URIs, the GLB chunk and files under the scene's folder, each read once.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use super::document::{self, Buffer, BufferView, Document};
use super::uri::{self, Target};
use crate::excerpt::excerpt;
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::folder::{Folder, read_start};

/// All buffers of a file, loaded when they are first asked for.
pub struct Buffers<'a> {
    document: &'a Document<'a>,
    chunk: Option<&'a [u8]>,
    folder: &'a Folder,
    loaded: Vec<OnceCell<Box<Bytes<'a>>>>,
    /// Two buffers of one file share its bytes: memory stays bounded by the files' sizes.
    files: RefCell<HashMap<PathBuf, Rc<Vec<u8>>>>,
    read_bytes: Cell<u64>,
    most_bytes: u64,
    longest: OnceCell<u64>,
}

enum Bytes<'a> {
    Chunk(&'a [u8]),
    Own(Vec<u8>),
    Shared(Rc<Vec<u8>>),
}

impl Bytes<'_> {
    fn as_slice(&self) -> &[u8] {
        match self {
            Bytes::Chunk(bytes) => bytes,
            Bytes::Own(bytes) => bytes,
            Bytes::Shared(bytes) => bytes,
        }
    }
}

/// The bytes of a buffer view and its stride.
pub struct View<'b> {
    /// Exactly the view's bytes.
    pub bytes: &'b [u8],
    /// Distance between elements, where the file sets one.
    pub stride: Option<u64>,
    /// As named in messages.
    pub element: String,
}

impl<'a> Buffers<'a> {
    /// No buffer is read yet, but `file_bytes`; all files together may have `most_bytes`.
    pub fn new(
        document: &'a Document<'a>,
        chunk: Option<&'a [u8]>,
        folder: &'a Folder,
        file_bytes: u64,
        most_bytes: u64,
    ) -> Self {
        let mut loaded = Vec::new();
        loaded.resize_with(document.buffers.len(), OnceCell::new);
        Self {
            document,
            chunk,
            folder,
            loaded,
            files: RefCell::default(),
            read_bytes: Cell::new(file_bytes),
            most_bytes,
            longest: OnceCell::new(),
        }
    }

    /// How many bytes of files have been read, the scene's own included.
    pub fn read_bytes(&self) -> u64 {
        self.read_bytes.get()
    }

    /// A buffer view, checked against its buffer.
    ///
    /// # Errors
    /// When view or buffer do not exist, cannot be read or are shorter than the file says.
    pub fn view(&self, index: u32, by: &str) -> SceneResult<View<'_>> {
        let view: BufferView = self.document.buffer_views.get("bufferViews", index, by)?;
        let element = format!("bufferViews[{index}]");
        let buffer = self.buffer(view.buffer, &element)?;
        let bytes = slice(buffer, view.byte_offset, view.byte_length).ok_or_else(|| {
            let needs = format!("{} + {}", view.byte_offset, view.byte_length);
            let (of, has) = (format!("buffers[{}]", view.buffer), buffer.len() as u64);
            SceneError::at(&element, SceneFault::TooShort { needs, of, has })
        })?;
        Ok(View { bytes, stride: view.byte_stride, element })
    }

    fn buffer(&self, index: u32, by: &str) -> SceneResult<&[u8]> {
        let element = format!("buffers[{index}]");
        let buffer: Buffer = self.document.buffers.get("buffers", index, by)?;
        // The index is within bounds, or `get` would have failed.
        let cell = &self.loaded[index as usize];
        if cell.get().is_none() {
            let bytes = self.load(index, &buffer, &element)?;
            let _ = cell.set(Box::new(bytes));
        }
        let bytes = cell.get().map_or(&[][..], |bytes| bytes.as_slice());
        slice(bytes, 0, buffer.byte_length).ok_or_else(|| {
            let (needs, of) = (buffer.byte_length.to_string(), "its data".into());
            SceneError::at(&element, SceneFault::TooShort { needs, of, has: bytes.len() as u64 })
        })
    }

    fn load(&self, index: u32, buffer: &Buffer<'a>, element: &str) -> SceneResult<Bytes<'a>> {
        let Some(raw) = buffer.uri else { return self.glb_chunk(index, element) };
        // A long data URI has nothing to unescape and need not be copied.
        let text = raw.get();
        let inner = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')).filter(|t| !t.contains('\\'));
        let unescaped: String;
        let uri = match inner {
            Some(inner) => inner,
            None => {
                unescaped = document::parse(raw, || format!("{element}.uri"))?;
                &unescaped
            }
        };
        match uri::parse(uri).map_err(|fault| SceneError::at(element, fault))? {
            Target::Embedded(bytes) => Ok(Bytes::Own(bytes)),
            Target::Relative(name) => self.file(&name, element).map(Bytes::Shared),
        }
    }

    fn glb_chunk(&self, index: u32, element: &str) -> SceneResult<Bytes<'a>> {
        match self.chunk {
            Some(chunk) if index == 0 => Ok(Bytes::Chunk(chunk)),
            _ => {
                let remedy = "only the first buffer of a .glb may do without one";
                Err(SceneError::at(element, SceneFault::Missing { what: "uri", remedy }))
            }
        }
    }

    /// The longest buffer that the file declares: of a longer file beside the scene no more is read.
    fn longest_buffer(&self) -> u64 {
        let length =
            |index| self.document.buffers.get("buffers", index, "").map_or(0, |buffer: Buffer| buffer.byte_length);
        *self.longest.get_or_init(|| (0..self.loaded.len() as u32).map(length).max().unwrap_or(0))
    }

    fn file(&self, name: &str, element: &str) -> SceneResult<Rc<Vec<u8>>> {
        let refused = |refusal: crate::scene::folder::Refusal| {
            let (problem, remedy) = (refusal.problem, refusal.remedy);
            SceneError::at(element, SceneFault::Uri { uri: excerpt(name), problem, remedy })
        };
        let path = self.folder.resolve(name).map_err(refused)?;
        if let Some(bytes) = self.files.borrow().get(&path) {
            return Ok(Rc::clone(bytes));
        }
        let length = std::fs::metadata(&path).map_or(0, |info| info.len()).min(self.longest_buffer());
        let left = self.most_bytes.saturating_sub(self.read_bytes.get());
        if length > left {
            let what = format!("the bytes of `{}`", excerpt(name));
            return Err(SceneError::at(element, SceneFault::Memory { what, bytes: length, limit: left }));
        }
        let bytes = Rc::new(read_start(&path, length).map_err(refused)?);
        self.read_bytes.set(self.read_bytes.get() + bytes.len() as u64);
        self.files.borrow_mut().insert(path, Rc::clone(&bytes));
        Ok(bytes)
    }
}

/// `length` bytes from `offset`, in checked arithmetic.
pub fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let end = offset.checked_add(length)?;
    bytes.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?)
}
