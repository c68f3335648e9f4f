//! EXT_mesh_gpu_instancing: the transforms of a node's instances, and what each carries besides.

use glam::{DAffine3, DQuat, DVec3};
use gltf::json::accessor::Type;

use super::accessors::{Accessor, Accessors, Allowed, Use};
use super::attributes::{Attributes, ParticleAttributes};
use super::document::{self, Node};
use crate::scene::error::{SceneError, SceneFault, SceneResult};

/// The instances of a node.
pub struct Instances<'a> {
    /// How many; at least one.
    pub count: u64,
    /// What they carry.
    pub carried: ParticleAttributes<'a>,
    translation: Option<Accessor<'a>>,
    rotation: Option<Accessor<'a>>,
    scale: Option<Accessor<'a>>,
}

/// Whether the instances of a node bring their own radii.
///
/// # Errors
/// When their attributes are no attributes.
pub fn carry_radii(node: &Node, element: &str) -> SceneResult<bool> {
    let Some(extension) = &node.extensions.instancing else { return Ok(false) };
    let attributes: Attributes = document::parse(extension.attributes, || element.to_owned())?;
    Ok(attributes.radius.is_some())
}

impl<'a> Instances<'a> {
    /// The instances of a node, `None` where it has none of its own.
    ///
    /// # Errors
    /// When an attribute is broken, or counts differ.
    pub fn read(accessors: Accessors<'a, '_>, node: &Node, element: &str) -> SceneResult<Option<Self>> {
        let Some(extension) = &node.extensions.instancing else { return Ok(None) };
        let by = format!("{element}.EXT_mesh_gpu_instancing");
        let attributes: Attributes = document::parse(extension.attributes, || by.clone())?;
        let get = |index: Option<u32>, attribute, kind, components| -> SceneResult<Option<Accessor<'a>>> {
            index.map(|index| accessors.get(index, Use { attribute, kind, components }, &by)).transpose()
        };
        let translation = get(attributes.translation, "TRANSLATION", Type::Vec3, Allowed::Float)?;
        let rotation = get(attributes.rotation, "ROTATION", Type::Vec4, Allowed::FloatOrNormalized)?;
        let scale = get(attributes.scale, "SCALE", Type::Vec3, Allowed::FloatOrNormalized)?;
        let placed = [&translation, &rotation, &scale];
        let Some(count) = placed.iter().find_map(|a| a.as_ref().map(Accessor::count)) else {
            let remedy = "instances need at least one of them";
            return Err(SceneError::at(by, SceneFault::Missing { what: "TRANSLATION, ROTATION or SCALE", remedy }));
        };
        for accessor in placed.into_iter().flatten() {
            accessor.expect_count(count, "the instances")?;
        }
        let carried = ParticleAttributes::read(accessors, &attributes, count, "the instances", &by)?;
        Ok(Some(Self { count, carried, translation, rotation, scale }))
    }

    /// From an instance's frame to the node's.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn transform(&self, i: u64) -> SceneResult<DAffine3> {
        let translation = self.translation.as_ref().map_or(Ok(DVec3::ZERO), |a| a.vec3(i))?;
        let rotation = self.rotation.as_ref().map_or(Ok(DQuat::IDENTITY), |a| a.rotation(i))?;
        let scale = self.scale.as_ref().map_or(Ok(DVec3::ONE), |a| a.vec3(i))?;
        Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
    }
}
