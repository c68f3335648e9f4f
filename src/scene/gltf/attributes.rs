//! Which attributes of a primitive or of instances are read: accessor indices by name, everything else is skipped.

use std::borrow::Cow;

use gltf::json::accessor::Type;
use serde::Deserialize;
use serde::de::{IgnoredAny, MapAccess, Visitor};

use super::accessors::{Accessor, Accessors, Allowed, Use};
use crate::excerpt::excerpt;
use crate::scene::error::SceneResult;
use crate::suggest::closest;

/// Accessor indices of the attributes that are known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Attributes {
    pub position: Option<u32>,
    pub radius: Option<u32>,
    pub droplet_radius_um: Option<u32>,
    pub droplet_count: Option<u32>,
    pub material: Option<u32>,
    pub translation: Option<u32>,
    pub rotation: Option<u32>,
    pub scale: Option<u32>,
    /// Those of the file's own (with an underscore) that are not known.
    pub unknown: UnknownNames,
}

/// Names of attributes that are not read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnknownNames {
    pub count: u32,
    /// The first of them, each with the one that was meant.
    first: Vec<String>,
}

/// What attributes of the file's own are read, in small letters.
const KNOWN_SMALL: [&str; 4] = ["_radius", "_droplet_radius_um", "_droplet_count", "_material"];

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Names;
        impl<'de> Visitor<'de> for Names {
            type Value = Attributes;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("an object of attributes")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
                let mut attributes = Attributes::default();
                while let Some(name) = map.next_key::<Cow<'de, str>>()? {
                    let Some(slot) = attributes.slot(&name) else {
                        if name.starts_with('_') {
                            attributes.unknown.push(&name);
                        }
                        map.next_value::<IgnoredAny>()?;
                        continue;
                    };
                    *slot = Some(map.next_value()?);
                }
                Ok(attributes)
            }
        }
        deserializer.deserialize_map(Names)
    }
}

impl UnknownNames {
    /// So many are named: a file may have any number of them.
    const MOST: usize = 3;

    fn push(&mut self, name: &str) {
        self.count = self.count.saturating_add(1);
        if self.first.len() < Self::MOST {
            let name = excerpt(name);
            let meant = closest(&name, KNOWN_SMALL).map(str::to_uppercase);
            let hint = meant.map_or_else(String::new, |meant| format!(" (did you mean {meant}?)"));
            self.first.push(format!("{name}{hint}"));
        }
    }

    /// Adds those of another primitive.
    pub fn add(&mut self, other: &Self) {
        self.count = self.count.saturating_add(other.count);
        self.first.extend(other.first.iter().filter(|name| !self.first.contains(name)).cloned().collect::<Vec<_>>());
        self.first.truncate(Self::MOST);
    }

    /// The first names.
    pub fn words(&self) -> String {
        let more = if self.count as usize > self.first.len() { ", .." } else { "" };
        self.first.join(", ") + more
    }
}

impl Attributes {
    fn slot(&mut self, name: &str) -> Option<&mut Option<u32>> {
        Some(match name {
            "POSITION" => &mut self.position,
            "_RADIUS" => &mut self.radius,
            "_DROPLET_RADIUS_UM" => &mut self.droplet_radius_um,
            "_DROPLET_COUNT" => &mut self.droplet_count,
            "_MATERIAL" => &mut self.material,
            "TRANSLATION" => &mut self.translation,
            "ROTATION" => &mut self.rotation,
            "SCALE" => &mut self.scale,
            _ => return None,
        })
    }
}

/// What particles may carry besides their place.
pub struct ParticleAttributes<'a> {
    pub radius: Option<Accessor<'a>>,
    pub droplet_radius_um: Option<Accessor<'a>>,
    pub droplet_count: Option<Accessor<'a>>,
    pub material: Option<Accessor<'a>>,
}

impl<'a> ParticleAttributes<'a> {
    /// Whether there is none of them.
    pub fn is_empty(&self) -> bool {
        [&self.radius, &self.droplet_radius_um, &self.droplet_count, &self.material].into_iter().all(Option::is_none)
    }

    /// Checks the accessors; all must have `count` elements.
    ///
    /// # Errors
    /// When an accessor is broken, no scalar, or of another count.
    pub fn read(
        accessors: Accessors<'a, '_>,
        attributes: &Attributes,
        count: u64,
        of: &str,
        by: &str,
    ) -> SceneResult<Self> {
        let scalar = |index: Option<u32>, attribute: &'static str| -> SceneResult<Option<Accessor<'a>>> {
            let Some(index) = index else { return Ok(None) };
            let used = Use { attribute, kind: Type::Scalar, components: Allowed::Any };
            let accessor = accessors.get(index, used, by)?;
            accessor.expect_count(count, of)?;
            Ok(Some(accessor))
        };
        Ok(Self {
            radius: scalar(attributes.radius, "_RADIUS")?,
            droplet_radius_um: scalar(attributes.droplet_radius_um, "_DROPLET_RADIUS_UM")?,
            droplet_count: scalar(attributes.droplet_count, "_DROPLET_COUNT")?,
            material: scalar(attributes.material, "_MATERIAL")?,
        })
    }
}
