//! Numbers out of accessors: strides, sparse values and normalised integers, every bound checked before anything is read.
//!
//! An accessor is a view: nothing is copied or allocated, so a count alone costs no memory.

use glam::{DQuat, DVec3};
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::budget::Budget;
use super::buffers::{Buffers, View, slice};
use super::document::{self, Document};
use crate::scene::error::{SceneError, SceneFault, SceneResult};

/// A checked accessor; every element below `count` can be read.
pub struct Accessor<'b> {
    element: String,
    count: u64,
    components: usize,
    scale: Scale,
    base: Option<Strided<'b>>,
    sparse: Option<Sparse<'b>>,
}

/// How stored integers become numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    AsStored,
    /// glTF 2.0, section 3.6.2.4: c / max, signed ones clamped at -1.
    Normalized,
}

/// What an accessor is used for.
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// The attribute's name, for messages.
    pub attribute: &'static str,
    /// Scalar, vector.
    pub kind: Type,
    /// Which component types are fine.
    pub components: Allowed,
}

/// Which component types an attribute may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// 32-bit floats.
    Float,
    /// Floats, or integers that are normalised.
    FloatOrNormalized,
    /// Everything.
    Any,
}

struct Strided<'b> {
    bytes: &'b [u8],
    stride: usize,
    component: ComponentType,
}

struct Sparse<'b> {
    count: usize,
    indices: Strided<'b>,
    values: Strided<'b>,
}

/// Reads accessors of one file.
#[derive(Clone, Copy)]
pub struct Accessors<'a, 'd> {
    pub document: &'d Document<'d>,
    pub buffers: &'a Buffers<'d>,
    /// Bounds work and memory.
    pub budget: &'a Budget,
}

impl<'a> Accessors<'a, '_> {
    /// Checks an accessor for a use.
    ///
    /// # Errors
    /// When it does not exist, has another type, or reaches outside its buffer.
    pub fn get(&self, index: u32, used: Use, by: &str) -> SceneResult<Accessor<'a>> {
        let raw: document::Accessor = self.document.accessors.get("accessors", index, by)?;
        let element = format!("accessors[{index}]");
        let component = component_type(&raw, &element)?;
        let components = check_use(&raw, component, used).map_err(|fault| SceneError::at(&element, fault))?;
        let size = component.size() * components;
        let base = match raw.buffer_view {
            Some(view) => {
                let view = self.buffers.view(view, &element)?;
                Some(strided(&view, raw.byte_offset, raw.count, size, component, &element)?)
            }
            None => None,
        };
        let scale = if raw.normalized && component != ComponentType::F32 { Scale::Normalized } else { Scale::AsStored };
        let sparse = raw.sparse.as_ref().map(|sparse| self.sparse(sparse, raw.count, size, component, &element));
        Ok(Accessor { count: raw.count, components, scale, base, sparse: sparse.transpose()?, element })
    }

    /// How POSITION is read: floats, or integers where KHR_mesh_quantization says so.
    pub fn position_use(&self) -> Use {
        let quantized = self.document.extensions_used.iter().any(|name| name == "KHR_mesh_quantization");
        let components = if quantized { Allowed::Any } else { Allowed::Float };
        Use { attribute: "POSITION", kind: Type::Vec3, components }
    }

    fn sparse(
        &self,
        sparse: &document::Sparse,
        of: u64,
        size: usize,
        component: ComponentType,
        element: &str,
    ) -> SceneResult<Sparse<'a>> {
        let element = format!("{element}.sparse");
        let Checked::Valid(index) = &sparse.indices.component_type else {
            let problem = "its indices have an unknown componentType".into();
            return Err(wrong(&element, problem, "5121, 5123 or 5125 (unsigned integers)"));
        };
        if sparse.count == 0 || sparse.count > of {
            return Err(wrong(&element, format!("it replaces {} of {of} elements", sparse.count), "1 up to the count"));
        }
        let view = self.buffers.view(sparse.indices.buffer_view, &element)?;
        let indices =
            strided(&tight(view), sparse.indices.byte_offset, sparse.count, index.0.size(), index.0, &element)?;
        let view = self.buffers.view(sparse.values.buffer_view, &element)?;
        let values = strided(&tight(view), sparse.values.byte_offset, sparse.count, size, component, &element)?;
        // Both views hold `count` elements, so it fits a usize.
        let sparse = Sparse { count: sparse.count as usize, indices, values };
        sparse.check_indices(of, &element)?;
        Ok(sparse)
    }
}

fn wrong(element: &str, problem: String, expected: &str) -> SceneError {
    SceneError::at(element, SceneFault::Accessor { problem, expected: expected.into() })
}

fn component_type(raw: &document::Accessor, element: &str) -> SceneResult<ComponentType> {
    match &raw.component_type {
        Checked::Valid(generic) => Ok(generic.0),
        Checked::Invalid => Err(wrong(element, "unknown componentType".into(), "5120, 5121, 5122, 5123, 5125 or 5126")),
    }
}

/// The number of components, once type and component type have been found to fit the use.
fn check_use(raw: &document::Accessor, component: ComponentType, used: Use) -> Result<usize, SceneFault> {
    let wrong = |problem: String, expected: String| Err(SceneFault::Accessor { problem, expected });
    let expected = format!("{} for {}", type_name(used.kind), used.attribute);
    match &raw.kind {
        Checked::Valid(kind) if *kind == used.kind => {}
        Checked::Valid(kind) => return wrong(format!("its type is {}", type_name(*kind)), expected),
        Checked::Invalid => return wrong("its type is unknown".into(), expected),
    }
    if raw.count == 0 {
        return wrong("its count is 0".into(), "at least one element".into());
    }
    let fits = match used.components {
        Allowed::Any => true,
        Allowed::Float => component == ComponentType::F32,
        Allowed::FloatOrNormalized => component == ComponentType::F32 || raw.normalized,
    };
    if !fits {
        let problem = format!("its componentType is {} (an integer)", component.as_gl_enum());
        return wrong(problem, format!("5126 (float) for {}", used.attribute));
    }
    if component == ComponentType::U32 && raw.normalized {
        return wrong("32-bit integers cannot be normalised".into(), "5126 (float)".into());
    }
    Ok(used.kind.multiplicity())
}

fn type_name(kind: Type) -> &'static str {
    match kind {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    }
}

/// Sparse arrays are tightly packed whatever their view says.
fn tight(view: View<'_>) -> View<'_> {
    View { stride: None, ..view }
}

/// Checks that `count` elements of `size` bytes lie inside a view, and cuts it to them.
fn strided<'b>(
    view: &View<'b>,
    offset: u64,
    count: u64,
    size: usize,
    component: ComponentType,
    element: &str,
) -> SceneResult<Strided<'b>> {
    let stride = view.stride.unwrap_or(size as u64);
    if stride < size as u64 {
        let problem = format!("{}.byteStride is {stride}", view.element);
        return Err(wrong(element, problem, &format!("at least the element's {size} bytes")));
    }
    // (count - 1) stride + size, which must not wrap around.
    let length = (count.saturating_sub(1)).checked_mul(stride).and_then(|l| l.checked_add(size as u64));
    let bytes = length.and_then(|length| slice(view.bytes, offset, length)).ok_or_else(|| {
        let needs = format!("{offset} + {count} x {stride}");
        SceneError::at(element, SceneFault::TooShort { needs, of: view.element.clone(), has: view.bytes.len() as u64 })
    })?;
    // A stride beyond the address space is only possible for a single element, which needs none.
    Ok(Strided { bytes, stride: usize::try_from(stride).unwrap_or(size), component })
}

impl Strided<'_> {
    /// Component `c` of element `i`, as stored.
    fn number(&self, i: usize, c: usize) -> f64 {
        let at = i * self.stride + c * self.component.size();
        match self.component {
            ComponentType::I8 => f64::from(i8::from_le_bytes(self.array(at))),
            ComponentType::U8 => f64::from(u8::from_le_bytes(self.array(at))),
            ComponentType::I16 => f64::from(i16::from_le_bytes(self.array(at))),
            ComponentType::U16 => f64::from(u16::from_le_bytes(self.array(at))),
            ComponentType::U32 => f64::from(u32::from_le_bytes(self.array(at))),
            ComponentType::F32 => f64::from(f32::from_le_bytes(self.array(at))),
        }
    }

    /// The constructor has checked that every element lies inside.
    fn array<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|k| self.bytes[at + k])
    }
}

impl Sparse<'_> {
    fn index(&self, k: usize) -> u64 {
        self.indices.number(k, 0) as u64
    }

    fn check_indices(&self, of: u64, element: &str) -> SceneResult<()> {
        let rises = (1..self.count).all(|k| self.index(k - 1) < self.index(k));
        if rises && self.index(self.count - 1) < of {
            return Ok(());
        }
        Err(wrong(
            element,
            "its indices do not rise, or pass the end".into(),
            "strictly rising indices below the count",
        ))
    }

    /// Which replacement stands for element `i`, if any.
    fn find(&self, i: u64) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.index(middle) < i { low = middle + 1 } else { high = middle }
        }
        (low < self.count && self.index(low) == i).then_some(low)
    }
}

impl Accessor<'_> {
    /// Number of elements.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// As named in messages.
    pub fn element(&self) -> &str {
        &self.element
    }

    /// Demands the count of its companions.
    ///
    /// # Errors
    /// When it differs.
    pub fn expect_count(&self, count: u64, of: &str) -> SceneResult<()> {
        if self.count == count {
            return Ok(());
        }
        Err(wrong(&self.element, format!("its count is {}", self.count), &format!("{count}, the count of {of}")))
    }

    /// A scalar.
    ///
    /// # Errors
    /// When it is NaN or infinite.
    pub fn scalar(&self, i: u64) -> SceneResult<f64> {
        self.component(i, 0)
    }

    /// A vector; missing components are 0.
    ///
    /// # Errors
    /// When a component is NaN or infinite.
    pub fn vec3(&self, i: u64) -> SceneResult<DVec3> {
        Ok(DVec3::new(self.component(i, 0)?, self.component(i, 1)?, self.component(i, 2)?))
    }

    /// A rotation, normalised.
    ///
    /// # Errors
    /// When a component is NaN or infinite, or all are zero.
    pub fn rotation(&self, i: u64) -> SceneResult<DQuat> {
        let [x, y, z, w] = [0, 1, 2, 3].map(|c| self.component(i, c));
        let q = DQuat::from_xyzw(x?, y?, z?, w?);
        if q.length_squared() > 0.0 {
            return Ok(q.normalize());
        }
        let what = format!("the length of rotation {i}");
        Err(SceneError::at(&self.element, SceneFault::Range { what, value: 0.0, expected: "a unit quaternion" }))
    }

    fn component(&self, i: u64, c: usize) -> SceneResult<f64> {
        let value = self.scaled(i, c);
        if value.is_finite() {
            return Ok(value);
        }
        Err(SceneError::at(&self.element, SceneFault::NotFinite { index: i, value }))
    }

    fn scaled(&self, i: u64, c: usize) -> f64 {
        if c >= self.components {
            return 0.0;
        }
        let replaced = self.sparse.as_ref().and_then(|sparse| sparse.find(i).map(|k| (&sparse.values, k)));
        // Without a buffer view every element is zero until a sparse one replaces it.
        let Some((from, at)) = replaced.or(self.base.as_ref().map(|base| (base, i as usize))) else { return 0.0 };
        let stored = from.number(at, c);
        match (self.scale, from.component) {
            (Scale::AsStored, _) | (_, ComponentType::F32 | ComponentType::U32) => stored,
            (_, ComponentType::I8) => (stored / 127.0).max(-1.0),
            (_, ComponentType::U8) => stored / 255.0,
            (_, ComponentType::I16) => (stored / 32767.0).max(-1.0),
            (_, ComponentType::U16) => stored / 65535.0,
        }
    }
}
