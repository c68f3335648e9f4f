//! The binary buffer: one section per accessor, described in JSON and streamed out in the same order.

use std::io::{self, Write};

use serde_json::{Value, json};

/// The buffer's sections, each of which becomes one buffer view and one accessor.
#[derive(Default)]
pub(super) struct Buffer<'a> {
    sections: Vec<Section<'a>>,
}

struct Section<'a> {
    data: Data<'a>,
    target: Option<Target>,
}

/// The numbers of a section.
#[derive(Clone, Copy)]
pub(super) enum Data<'a> {
    /// One number per element.
    Scalars(&'a [f32]),
    /// Three per element.
    Vectors(&'a [[f32; 3]]),
    /// Three equal numbers per element.
    Repeated(&'a [f32]),
    /// Vertex numbers of triangles; an even number of them, so that what follows stays aligned to four bytes.
    Indices(&'a [u16]),
}

/// What the GPU uses a buffer view for.
#[derive(Clone, Copy)]
pub(super) enum Target {
    Vertices = 34962,
    Indices = 34963,
}

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;

impl<'a> Buffer<'a> {
    /// Adds a section and returns the index of its accessor.
    pub fn push(&mut self, data: Data<'a>, target: Option<Target>) -> usize {
        self.sections.push(Section { data, target });
        self.sections.len() - 1
    }

    /// Length of the whole buffer, bytes; a multiple of four.
    pub fn len_bytes(&self) -> usize {
        self.sections.iter().map(|section| section.data.len_bytes()).sum()
    }

    /// The `bufferViews` and `accessors` of the document.
    pub fn describe(&self) -> (Value, Value) {
        let mut offset = 0;
        let mut views = Vec::new();
        let mut accessors = Vec::new();
        for (index, section) in self.sections.iter().enumerate() {
            let length = section.data.len_bytes();
            let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
            if let Some(target) = section.target {
                view["target"] = (target as u32).into();
            }
            views.push(view);
            accessors.push(section.data.accessor(index));
            offset += length;
        }
        (views.into(), accessors.into())
    }

    /// Streams the bytes, little-endian.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for section in &self.sections {
            match section.data {
                Data::Scalars(values) => write_chunks(values, out, |x, bytes| bytes.extend(x.to_le_bytes()))?,
                Data::Vectors(values) => {
                    write_chunks(values, out, |v, bytes| v.iter().for_each(|x| bytes.extend(x.to_le_bytes())))?;
                }
                Data::Repeated(values) => {
                    write_chunks(values, out, |x, bytes| (0..3).for_each(|_| bytes.extend(x.to_le_bytes())))?;
                }
                Data::Indices(values) => write_chunks(values, out, |i, bytes| bytes.extend(i.to_le_bytes()))?,
            }
        }
        Ok(())
    }
}

fn write_chunks<T>(values: &[T], out: &mut dyn Write, put: impl Fn(&T, &mut Vec<u8>)) -> io::Result<()> {
    const CHUNK: usize = 8192;
    let mut bytes = Vec::with_capacity(CHUNK * 12);
    for chunk in values.chunks(CHUNK) {
        bytes.clear();
        chunk.iter().for_each(|value| put(value, &mut bytes));
        out.write_all(&bytes)?;
    }
    Ok(())
}

impl Data<'_> {
    fn len_bytes(&self) -> usize {
        match self {
            Data::Scalars(values) => size_of_val(*values),
            Data::Vectors(values) => size_of_val(*values),
            Data::Repeated(values) => 3 * size_of_val(*values),
            Data::Indices(values) => size_of_val(*values),
        }
    }

    fn accessor(&self, view: usize) -> Value {
        let (kind, component, count) = match self {
            Data::Scalars(values) => ("SCALAR", FLOAT, values.len()),
            Data::Vectors(values) => ("VEC3", FLOAT, values.len()),
            Data::Repeated(values) => ("VEC3", FLOAT, values.len()),
            Data::Indices(values) => ("SCALAR", UNSIGNED_SHORT, values.len()),
        };
        let mut accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if let Some((min, max)) = self.bounds() {
            accessor["min"] = min.into();
            accessor["max"] = max.into();
        }
        accessor
    }

    /// The exact smallest and largest components.
    fn bounds(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let (min, max) = match self {
            Data::Scalars(values) => bounds(values.iter().map(|&x| [x])).map(|(a, b)| (a.to_vec(), b.to_vec()))?,
            Data::Vectors(values) => bounds(values.iter().copied()).map(|(a, b)| (a.to_vec(), b.to_vec()))?,
            Data::Repeated(values) => bounds(values.iter().map(|&x| [x; 3])).map(|(a, b)| (a.to_vec(), b.to_vec()))?,
            Data::Indices(_) => return None,
        };
        Some((min.into_iter().map(f64::from).collect(), max.into_iter().map(f64::from).collect()))
    }
}

fn bounds<const N: usize>(mut values: impl Iterator<Item = [f32; N]>) -> Option<([f32; N], [f32; N])> {
    let first = values.next()?;
    Some(values.fold((first, first), |(mut min, mut max), value| {
        for axis in 0..N {
            min[axis] = min[axis].min(value[axis]);
            max[axis] = max[axis].max(value[axis]);
        }
        (min, max)
    }))
}
