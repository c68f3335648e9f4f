//! Meshes, each parsed once: which primitives are points, which make a solid, and what the artist marked.

use std::cell::OnceCell;
use std::rc::Rc;

use glam::DVec3;
use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;

use super::accessors::Accessors;
use super::attributes::{Attributes, UnknownNames};
use super::document::{self, Document, label};
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::folder::Folder;
use crate::scene::marks::{MARKS, Marks};
use crate::scene::settings_parse::{apply, entries_of_extras};

/// Share of a box's edge by which a vertex on its surface may be off: positions are single precision, of any offset.
const FLUSH: f64 = 1e-4;

/// A mesh, as far as droplets and fog go.
pub struct Mesh {
    /// As named in messages.
    pub element: String,
    /// What its extras say.
    pub marks: Marks,
    /// POINTS primitives.
    pub points: Vec<Points>,
    /// All other primitives together.
    pub solid: Option<Solid>,
    /// Attributes of the file's own that are not known.
    pub unknown_attributes: UnknownNames,
    /// Whether shape keys are left out.
    pub morphs: Morphs,
    bounds: OnceCell<Bounds>,
}

/// Whether a mesh has morph targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Morphs {
    None,
    Some,
}

/// A POINTS primitive.
pub struct Points {
    pub primitive: usize,
    pub attributes: Attributes,
    pub material: Option<u32>,
}

/// Triangles, lines and strips of a mesh.
pub struct Solid {
    /// Accessors of their positions.
    pub positions: Vec<u32>,
    /// Material of the first primitive.
    pub material: Option<u32>,
}

/// Extent of a solid in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
    /// Distances of the nearest and farthest vertex from the middle of the bounds.
    pub nearest: f64,
    pub farthest: f64,
    pub vertices: u64,
    /// Whether the vertices make the bounding box: all lie on it, and some at each of its corners.
    pub is_box: bool,
}

impl Bounds {
    /// Middle of the bounding box.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Whether all vertices lie about as far from the middle, as those of UV spheres and icospheres do. Ten percent
    /// leave room for rounded and subdivided ones; twelve vertices (an icosahedron's) exclude cubes.
    pub fn is_sphere_like(&self) -> bool {
        self.farthest > 0.0 && self.nearest >= 0.9 * self.farthest && self.vertices >= 12
    }
}

/// All meshes of a file, parsed when they are first asked for.
pub struct Meshes<'d> {
    document: &'d Document<'d>,
    folder: &'d Folder,
    parsed: Vec<Option<Rc<Mesh>>>,
}

impl<'d> Meshes<'d> {
    /// No mesh is parsed yet.
    pub fn new(document: &'d Document<'d>, folder: &'d Folder) -> Self {
        Self { document, folder, parsed: vec![None; document.meshes.len()] }
    }

    /// A mesh by index.
    ///
    /// # Errors
    /// When it does not exist or is broken.
    pub fn get(&mut self, index: u32, by: &str) -> SceneResult<Rc<Mesh>> {
        if let Some(Some(mesh)) = self.parsed.get(index as usize) {
            return Ok(Rc::clone(mesh));
        }
        let mesh = Rc::new(self.parse(index, by)?);
        if let Some(slot) = self.parsed.get_mut(index as usize) {
            *slot = Some(Rc::clone(&mesh));
        }
        Ok(mesh)
    }

    fn parse(&self, index: u32, by: &str) -> SceneResult<Mesh> {
        let raw: document::Mesh = self.document.meshes.get("meshes", index, by)?;
        let element = label("meshes", index, raw.name.as_deref());
        let mut marks = Marks::default();
        apply(&mut marks, &[MARKS], &entries_of_extras(raw.extras, &element)?, self.folder, &element)?;
        let mut mesh = Mesh {
            element,
            marks,
            points: Vec::new(),
            solid: None,
            unknown_attributes: UnknownNames::default(),
            morphs: Morphs::None,
            bounds: OnceCell::new(),
        };
        for k in 0..raw.primitives.len() {
            mesh.add_primitive(&raw, k)?;
        }
        Ok(mesh)
    }
}

impl Mesh {
    fn add_primitive(&mut self, raw: &document::Mesh, k: usize) -> SceneResult<()> {
        let name = || format!("{}.primitives[{k}]", self.element);
        let primitive: document::Primitive = raw.primitives.get("primitives", k as u32, &self.element)?;
        let attributes: Attributes = document::parse(primitive.attributes, || format!("{}.attributes", name()))?;
        let Checked::Valid(mode) = primitive.mode else {
            let problem = "its mode is unknown".into();
            return Err(SceneError::at(name(), SceneFault::Accessor { problem, expected: "0 (points) to 6".into() }));
        };
        self.unknown_attributes.add(&attributes.unknown);
        if primitive.targets.is_some() {
            self.morphs = Morphs::Some;
        }
        if mode == Mode::Points {
            self.points.push(Points { primitive: k, attributes, material: primitive.material });
        } else {
            let solid = self.solid.get_or_insert_with(|| Solid { positions: Vec::new(), material: primitive.material });
            solid.positions.extend(attributes.position);
        }
        Ok(())
    }

    /// Extent of the solid, measured once.
    ///
    /// # Errors
    /// When it has no vertices or they cannot be read.
    pub fn bounds(&self, accessors: Accessors) -> SceneResult<Bounds> {
        if let Some(bounds) = self.bounds.get() {
            return Ok(*bounds);
        }
        let bounds = self.measure(accessors)?;
        Ok(*self.bounds.get_or_init(|| bounds))
    }

    fn measure(&self, accessors: Accessors) -> SceneResult<Bounds> {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut vertices = 0;
        self.each_vertex(accessors, |p| {
            (min, max) = (min.min(p), max.max(p));
            vertices += 1;
        })?;
        if vertices == 0 {
            let remedy = "a mesh marked as droplet or fog needs a POSITION attribute";
            return Err(SceneError::at(&self.element, SceneFault::Missing { what: "vertices", remedy }));
        }
        let center = 0.5 * (min + max);
        let (mut nearest, mut farthest) = (f64::INFINITY, 0.0_f64);
        let (mut on_box, mut corners) = (true, 0_u8);
        self.each_vertex(accessors, |p| {
            nearest = nearest.min(p.distance(center));
            farthest = farthest.max(p.distance(center));
            let sides = [p - min, max - p].map(|d| d.cmple(FLUSH * (max - min)));
            on_box &= (sides[0] | sides[1]).any();
            if (sides[0] | sides[1]).all() {
                corners |= 1 << sides[1].bitmask();
            }
        })?;
        Ok(Bounds { min, max, nearest, farthest, vertices, is_box: on_box && corners == u8::MAX })
    }

    fn each_vertex(&self, accessors: Accessors, mut each: impl FnMut(DVec3)) -> SceneResult<()> {
        let Some(solid) = &self.solid else { return Ok(()) };
        for &index in &solid.positions {
            let positions = accessors.get(index, accessors.position_use(), &self.element)?;
            accessors.budget.visit(positions.count(), accessors.buffers.read_bytes(), &self.element)?;
            for i in 0..positions.count() {
                each(positions.vec3(i)?);
            }
        }
        Ok(())
    }
}
