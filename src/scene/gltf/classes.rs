//! Droplet classes: what droplets have in common, made once for each combination that occurs.

use std::collections::HashMap;

use xxhash_rust::xxh3::xxh3_128;

use super::materials::Surface;
use crate::excerpt::excerpt;
use crate::optics::DropletClass;
use crate::optics::distribution::SizeDistribution;
use crate::optics::material::Material;
use crate::optics::phase_model::PhaseModel;
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::folder::Folder;
use crate::scene::marks::Marks;
use crate::scene::settings::DropletSettings;

/// Whether the scene's settings name a material; if they do not, glTF materials may give an index of refraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneMaterial {
    Named,
    Open,
}

/// The classes of a scene; the first is that of droplets which say nothing.
pub struct Classes<'d> {
    list: Vec<DropletClass>,
    /// By the hash of what describes them: a text that many nodes share is not kept for each.
    by_key: HashMap<u128, u16>,
    materials: &'d [Material],
    scene_material: SceneMaterial,
    folder: &'d Folder,
}

impl<'d> Classes<'d> {
    /// The scene's own class only.
    pub fn new(settings: &'d DropletSettings, scene_material: SceneMaterial, folder: &'d Folder) -> Self {
        Self {
            list: vec![settings.class.clone()],
            by_key: HashMap::new(),
            materials: &settings.materials,
            scene_material,
            folder,
        }
    }

    /// The finished list.
    pub fn into_list(self) -> Vec<DropletClass> {
        self.list
    }

    /// The class of droplets with these marks and surface.
    ///
    /// # Errors
    /// When a description cannot be read, or there are too many classes.
    pub fn of(&mut self, marks: &Marks, surface: Option<&Surface>, element: &str) -> SceneResult<u16> {
        let open = marks.material.is_none() && self.scene_material == SceneMaterial::Open;
        let refracting = surface.filter(|surface| open && surface.refraction.is_some());
        let Marks { material, phase, distribution, albedo, .. } = marks;
        if refracting.is_none() && material.is_none() && phase.is_none() && distribution.is_none() && albedo.is_none() {
            return Ok(0);
        }
        let key = format!("{material:?} {phase:?} {distribution:?} {albedo:?} {:?}", refracting.map(|s| s.index));
        let key = xxh3_128(key.as_bytes());
        if let Some(&class) = self.by_key.get(&key) {
            return Ok(class);
        }
        let class = self.make(marks, refracting, element)?;
        self.add(key, class, element)
    }

    /// The class `base` with the material that `_MATERIAL` names.
    ///
    /// # Errors
    /// When `droplets.materials` has no such index, or there are too many classes.
    pub fn with_material(&mut self, base: u16, index: f64, number: u64, element: &str) -> SceneResult<u16> {
        let whole = index.fract() == 0.0 && index >= 0.0;
        let Some(material) = self.materials.get(index as usize).filter(|_| whole) else {
            let remedy = "list that many materials in droplets.materials";
            let problem = format!("_MATERIAL {number} is {index}, and there are {} materials", self.materials.len());
            return Err(SceneError::at(element, SceneFault::Mark { problem, remedy }));
        };
        let key = xxh3_128(format!("{base} #{index}").as_bytes());
        if let Some(&class) = self.by_key.get(&key) {
            return Ok(class);
        }
        let class = DropletClass { material: material.clone(), ..self.list[usize::from(base)].clone() };
        self.add(key, class, element)
    }

    fn make(&self, marks: &Marks, refracting: Option<&Surface>, element: &str) -> SceneResult<DropletClass> {
        let mut class = self.list[0].clone();
        if let Some(material) = refracting.and_then(|surface| surface.refraction.clone()) {
            class.material = material;
        }
        if let Some(text) = &marks.material {
            class.material = self.parse("material", text, Material::parse, element)?;
        }
        if let Some(text) = &marks.phase {
            class.phase = self.parse("phase", text, PhaseModel::parse, element)?;
        }
        if let Some(text) = &marks.distribution {
            class.distribution = self.parse("distribution", text, SizeDistribution::parse, element)?;
        }
        class.albedo = marks.albedo.or(class.albedo);
        Ok(class)
    }

    fn parse<T, E: std::fmt::Display>(
        &self,
        key: &str,
        text: &str,
        parse: impl Fn(&str, crate::optics::ReadText) -> Result<T, E>,
        element: &str,
    ) -> SceneResult<T> {
        parse(text, &|name: &str| self.folder.read_text(name)).map_err(|e| {
            let (key, value, problem) = (key.into(), format!("\"{}\"", excerpt(text)), e.to_string());
            SceneError::at(element, SceneFault::Setting { key, value, problem })
        })
    }

    fn add(&mut self, key: u128, class: DropletClass, element: &str) -> SceneResult<u16> {
        // Two descriptions may mean the same; scenes have few classes, so a search costs little.
        const SEARCHED: usize = 256;
        let same = self.list.iter().take(SEARCHED).position(|known| *known == class);
        let index = same.unwrap_or(self.list.len());
        let Ok(index) = u16::try_from(index) else {
            let remedy = "give droplets of one kind the same material, phase, distribution and albedo";
            let problem = "more than 65536 kinds of droplets".into();
            return Err(SceneError::at(element, SceneFault::Mark { problem, remedy }));
        };
        if same.is_none() {
            self.list.push(class);
        }
        self.by_key.insert(key, index);
        Ok(index)
    }
}
