//! From nodes with meshes to droplets, parcels, balls and boxes of fog: the five forms in which scenes hold them.

use glam::{DAffine3, DVec3};

use super::accessors::{Accessor, Accessors};
use super::attributes::ParticleAttributes;
use super::classes::Classes;
use super::instancing::{Instances, carry_radii};
use super::materials::{Surface, Surfaces};
use super::meshes::{Mesh, Meshes, Morphs, Points};
use super::nodes::{Uniformity, Visit, length_scale};
use super::particles::{Group, Particles, Source};
use super::unrendered::{Kind, Unrendered};
use crate::excerpt::excerpt;
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::folder::Folder;
use crate::scene::glob;
use crate::scene::marks::{MARKS, MarkKind, Marks, NODE_LIGHT};
use crate::scene::model::{FogBox, WORLD_LIMIT_M};
use crate::scene::settings_parse::{apply, entries_of_extras};

/// What the user's flags say about droplets.
#[derive(Clone, Copy)]
pub struct Flags<'a> {
    /// Names of nodes whose meshes are droplets.
    pub glob: Option<&'a str>,
    /// Drawn radius of points without one, m in the world.
    pub radius_m: Option<f64>,
}

/// Collects particles and boxes while the scene is walked.
pub struct Collector<'a, 'd> {
    pub accessors: Accessors<'a, 'd>,
    pub folder: &'d Folder,
    pub flags: Flags<'d>,
    pub meshes: Meshes<'d>,
    pub surfaces: Surfaces<'d>,
    pub classes: Classes<'d>,
    pub particles: Particles,
    pub fog_boxes: Vec<FogBox>,
    pub notes: Unrendered,
    /// How many nodes the glob matched.
    pub glob_matches: u64,
}

/// A mesh at a node: everything that its parts share.
struct Placed<'v> {
    visit: &'v Visit<'v>,
    marks: Marks,
}

impl<'a> Collector<'a, '_> {
    /// Takes what a node holds; returns what it says about a light.
    ///
    /// # Errors
    /// When the node, its mesh or its marks are at fault.
    pub fn take(&mut self, visit: &Visit) -> SceneResult<Marks> {
        let mut marks = Marks::default();
        let entries = entries_of_extras(visit.node.extras, &visit.element)?;
        apply(&mut marks, &[MARKS, NODE_LIGHT], &entries, self.folder, &visit.element)?;
        let named = visit.node.name.as_deref().unwrap_or_default();
        if self.flags.glob.is_some_and(|pattern| glob::matches(pattern, named)) {
            marks.kind = Some(MarkKind::Droplet);
            self.glob_matches += 1;
        }
        let Some(index) = visit.node.mesh else {
            if marks.kind.is_some() {
                self.notes.note(Kind::EmptyMark, 1, || visit.element.clone());
            } else if marks.is_of_droplets() {
                self.notes.note(Kind::IdleMark, 1, || visit.element.clone());
            }
            return Ok(marks);
        };
        if visit.node.skin.is_some() {
            self.notes.note(Kind::SkinnedNode, 1, || visit.element.clone());
        }
        let mesh = self.meshes.get(index, &visit.element)?;
        let placed = Placed { visit, marks: marks.clone().over(&mesh.marks) };
        self.take_mesh(&placed, &mesh)?;
        Ok(marks)
    }

    fn take_mesh(&mut self, placed: &Placed, mesh: &Mesh) -> SceneResult<()> {
        let element = &placed.visit.element;
        let unknown = &mesh.unknown_attributes;
        self.notes
            .note(Kind::OwnAttribute, unknown.count.into(), || format!("{} of {}", unknown.words(), mesh.element));
        if mesh.morphs == Morphs::Some {
            self.notes.note(Kind::MorphTarget, 1, || mesh.element.clone());
        }
        let mut bare = 0;
        let others_bring_radii =
            self.flags.radius_m.is_some() || (!mesh.points.is_empty() && carry_radii(&placed.visit.node, element)?);
        for points in &mesh.points {
            if points.attributes.radius.is_none() && !others_bring_radii {
                bare += 1;
            } else {
                self.take_points(placed, mesh, points)?;
            }
        }
        self.notes.note(Kind::BarePoints, bare, || element.clone());
        let Some(solid) = &mesh.solid else { return Ok(()) };
        let surface = self.surface(solid.material, element)?;
        let marks = with_surface(&placed.marks, surface.as_deref());
        check_density(&marks, element)?;
        match marks.kind {
            Some(MarkKind::Droplet) => self.take_spheres(placed, mesh, &marks, surface.as_deref()),
            Some(MarkKind::Fog) => self.take_boxes(placed, mesh, &marks, surface.as_deref()),
            None if self.are_spheres(placed, mesh)? => self.take_spheres(placed, mesh, &marks, surface.as_deref()),
            None => {
                self.notes.note(Kind::Mesh, 1, || element.clone());
                Ok(())
            }
        }
    }

    /// Instances of a sphere are droplets without a mark: that is how clouds of them are exported.
    fn are_spheres(&self, placed: &Placed, mesh: &Mesh) -> SceneResult<bool> {
        Ok(placed.visit.node.extensions.instancing.is_some() && mesh.bounds(self.accessors)?.is_sphere_like())
    }

    fn surface(&mut self, material: Option<u32>, by: &str) -> SceneResult<Option<std::rc::Rc<Surface>>> {
        material.map(|index| self.surfaces.get(index, by)).transpose()
    }

    /// Forms 1, 4 and balls of fog: every point is a particle, once for each instance of the node.
    fn take_points(&mut self, placed: &Placed, mesh: &Mesh, points: &Points) -> SceneResult<()> {
        let element = format!("{}.primitives[{}]", mesh.element, points.primitive);
        let surface = self.surface(points.material, &element)?;
        let marks = with_surface(&placed.marks, surface.as_deref());
        check_density(&marks, &placed.visit.element)?;
        let Some(positions) = points.attributes.position else {
            let remedy = "points need positions";
            return Err(SceneError::at(element, SceneFault::Missing { what: "POSITION", remedy }));
        };
        let positions = self.accessors.get(positions, self.accessors.position_use(), &element)?;
        let count = positions.count();
        let carried = ParticleAttributes::read(self.accessors, &points.attributes, count, "POSITION", &element)?;
        let instances = Instances::read(self.accessors, &placed.visit.node, &placed.visit.element)?;
        let n_instances = instances.as_ref().map_or(1, |i| i.count);
        self.reserve(count.saturating_mul(n_instances), &element)?;
        // Radii are checked against quantisation before any droplet is made of them.
        carried.check_radii()?;
        instances.as_ref().map_or(Ok(()), |instances| instances.carried.check_radii())?;
        let both = |i: &Instances| !i.carried.is_empty() && (carried.radius.is_some() || i.carried.radius.is_none());
        if instances.as_ref().is_some_and(both) {
            self.notes.note(Kind::IdleInstances, 1, || placed.visit.element.clone());
        }
        let group = self.group(placed, &marks, surface.as_deref(), &element)?;
        for instance in 0..n_instances {
            let world = world_of(placed, instances.as_ref(), instance)?;
            let scale = self.scale_of(&world, &placed.visit.element)?;
            let cloud = PointCloud { positions: &positions, world };
            // Points without radii of their own take everything from their instance, whose radius grows with the node.
            match instances.as_ref().filter(|i| carried.radius.is_none() && i.carried.radius.is_some()) {
                Some(instances) => {
                    let scale = self.scale_of(&placed.visit.world_from_node, &placed.visit.element)?;
                    let source = Source { carried: &instances.carried, scale, default_radius_m: None, group: &group };
                    self.push_points(&cloud, &source, |_| instance)?;
                }
                None => {
                    let default_radius_m = self.flags.radius_m;
                    let source = Source { carried: &carried, scale, default_radius_m, group: &group };
                    self.push_points(&cloud, &source, |i| i)?;
                }
            }
        }
        self.particles.finish(group);
        Ok(())
    }

    /// Adds every point; `carried_by` tells which element of the source belongs to point `i`.
    fn push_points(&mut self, cloud: &PointCloud, source: &Source, carried_by: impl Fn(u64) -> u64) -> SceneResult<()> {
        for i in 0..cloud.positions.count() {
            let center_m = cloud.world.transform_point3(cloud.positions.vec3(i)?);
            check_place(center_m, cloud.positions.element())?;
            self.particles.push(center_m, carried_by(i), source, &mut self.classes, &mut self.notes)?;
        }
        Ok(())
    }

    /// Forms 2 and 3: spheres that stand for droplets, singly or as instances.
    fn take_spheres(
        &mut self,
        placed: &Placed,
        mesh: &Mesh,
        marks: &Marks,
        surface: Option<&Surface>,
    ) -> SceneResult<()> {
        let element = &placed.visit.element;
        let bounds = mesh.bounds(self.accessors)?;
        if !bounds.is_sphere_like() {
            self.notes.note(Kind::NoSphere, 1, || element.clone());
        }
        let instances = Instances::read(self.accessors, &placed.visit.node, element)?;
        let count = instances.as_ref().map_or(1, |i| i.count);
        self.reserve(count, element)?;
        let none = ParticleAttributes { radius: None, droplet_radius_um: None, droplet_count: None, material: None };
        let carried = instances.as_ref().map_or(&none, |i| &i.carried);
        let group = self.group(placed, marks, surface, element)?;
        // `_RADIUS` is in the node's units; the mesh's own radius grows with the instance too.
        let node_scale = self.scale_of(&placed.visit.world_from_node, element)?;
        let by_attribute = Source { carried, scale: node_scale, default_radius_m: None, group: &group };
        carried.check_radii()?;
        for i in 0..count {
            let world = world_of(placed, instances.as_ref(), i)?;
            let center_m = world.transform_point3(bounds.center());
            check_place(center_m, element)?;
            let source = match carried.radius {
                Some(_) => by_attribute,
                None => {
                    let scale = self.scale_of(&world, element)?;
                    Source { default_radius_m: Some(bounds.farthest * scale), ..by_attribute }
                }
            };
            self.particles.push(center_m, i, &source, &mut self.classes, &mut self.notes)?;
        }
        self.particles.finish(group);
        Ok(())
    }

    /// Form 5: the mesh's bounding box, filled with fog, once for each instance.
    fn take_boxes(
        &mut self,
        placed: &Placed,
        mesh: &Mesh,
        marks: &Marks,
        surface: Option<&Surface>,
    ) -> SceneResult<()> {
        let element = &placed.visit.element;
        let density = marks.density.ok_or_else(|| missing_density(element))?;
        if marks.droplet_count.is_some() {
            self.notes.note(Kind::CountedBox, 1, || element.clone());
        }
        let bounds = mesh.bounds(self.accessors)?;
        if !bounds.is_box {
            self.notes.note(Kind::NoBox, 1, || element.clone());
        }
        let half = 0.5 * (bounds.max - bounds.min);
        let class = self.classes.of(marks, surface, element)?;
        let instances = Instances::read(self.accessors, &placed.visit.node, element)?;
        let count = instances.as_ref().map_or(1, |i| i.count);
        // A box and its name, which is shortened: a long one would be kept for every instance. Messages have no less of it.
        let name = placed.visit.node.name.as_deref().map_or_else(|| element.clone(), excerpt);
        let size = size_of::<FogBox>() + element.len();
        self.accessors.budget.take(count, size, self.accessors.buffers.read_bytes(), element)?;
        for i in 0..count {
            let world = world_of(placed, instances.as_ref(), i)?;
            let center_m = world.transform_point3(bounds.center());
            check_place(center_m, element)?;
            let half_edges_m = world.matrix3 * glam::DMat3::from_diagonal(half);
            let smallest = half_edges_m.determinant().abs();
            if !(smallest.is_finite() && smallest > 0.0) {
                let what = "the volume of its bounding box".into();
                let fault = SceneFault::Range { what, value: 8.0 * smallest, expected: "a box with thickness" };
                return Err(SceneError::at(element, fault));
            }
            self.fog_boxes.push(FogBox {
                name: name.clone(),
                center_m,
                half_edges_m,
                density,
                class,
                droplet_radius_m: marks.droplet_radius_um.map(|um| um * 1e-6),
            });
        }
        Ok(())
    }

    fn reserve(&mut self, count: u64, element: &str) -> SceneResult<()> {
        let file_bytes = self.accessors.buffers.read_bytes();
        self.accessors.budget.take(count, Particles::BYTES_EACH, file_bytes, element)?;
        self.particles.reserve(count, element)
    }

    fn group(
        &mut self,
        placed: &Placed,
        marks: &Marks,
        surface: Option<&Surface>,
        element: &str,
    ) -> SceneResult<Group> {
        let class = self.classes.of(marks, surface, &placed.visit.element)?;
        Ok(Group::new(element, class, marks, self.particles.len()))
    }

    fn scale_of(&mut self, world: &DAffine3, element: &str) -> SceneResult<f64> {
        let (scale, uniformity) = length_scale(world.matrix3, element)?;
        if uniformity == Uniformity::Skewed {
            self.notes.note(Kind::SkewedDroplet, 1, || element.to_owned());
        }
        Ok(scale)
    }
}

/// Positions and where they stand.
struct PointCloud<'p, 'a> {
    positions: &'p Accessor<'a>,
    world: DAffine3,
}

fn world_of(placed: &Placed, instances: Option<&Instances>, i: u64) -> SceneResult<DAffine3> {
    Ok(match instances {
        Some(instances) => placed.visit.world_from_node * instances.transform(i)?,
        None => placed.visit.world_from_node,
    })
}

fn with_surface(marks: &Marks, surface: Option<&Surface>) -> Marks {
    match surface {
        Some(surface) => marks.clone().over(&surface.marks),
        None => marks.clone(),
    }
}

fn missing_density(element: &str) -> SceneError {
    let remedy = "give number_per_m3, liquid_water_g_per_m3 or extinction_per_m beside kind = \"fog\"";
    SceneError::at(element, SceneFault::Mark { problem: "is fog, but says not how dense".into(), remedy })
}

/// A density means fog, and fog needs one; a mesh that has only the one is a slip.
fn check_density(marks: &Marks, element: &str) -> SceneResult<()> {
    match (marks.kind, marks.density) {
        (Some(MarkKind::Fog), None) if marks.droplet_count.is_none() => Err(missing_density(element)),
        (Some(MarkKind::Fog), _) | (_, None) => Ok(()),
        (_, Some(_)) => {
            let problem = "has a density of fog, but is not marked as fog".into();
            let remedy = "add kind = \"fog\", or take the density away";
            Err(SceneError::at(element, SceneFault::Mark { problem, remedy }))
        }
    }
}

fn check_place(center_m: DVec3, element: &str) -> SceneResult<()> {
    let value = center_m.abs().max_element();
    if center_m.is_finite() && value <= WORLD_LIMIT_M {
        return Ok(());
    }
    let what = "a position in the world".into();
    Err(SceneError::at(element, SceneFault::Range { what, value, expected: "at most 1e12 m from the origin" }))
}
