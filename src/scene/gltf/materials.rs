//! glTF materials, each parsed once: marks for droplets, and the index of refraction that KHR_materials_ior gives.

use std::rc::Rc;
use std::sync::Arc;

use super::document::{self, Document, label};
use crate::optics::material::{IndexTable, Material};
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::folder::Folder;
use crate::scene::marks::{MARKS, Marks};
use crate::scene::settings_parse::{apply, entries_of_extras};

/// A glTF material, as far as droplets go.
#[derive(Debug)]
pub struct Surface {
    /// Index into `materials`.
    pub index: u32,
    /// What its extras say.
    pub marks: Marks,
    /// The index of refraction, where KHR_materials_ior gives one.
    pub refraction: Option<Material>,
}

/// All materials of a file, parsed when they are first asked for.
pub struct Surfaces<'d> {
    document: &'d Document<'d>,
    folder: &'d Folder,
    parsed: Vec<Option<Rc<Surface>>>,
}

impl<'d> Surfaces<'d> {
    /// No material is parsed yet.
    pub fn new(document: &'d Document<'d>, folder: &'d Folder) -> Self {
        Self { document, folder, parsed: vec![None; document.materials.len()] }
    }

    /// A material by index.
    ///
    /// # Errors
    /// When it does not exist or is broken.
    pub fn get(&mut self, index: u32, by: &str) -> SceneResult<Rc<Surface>> {
        if let Some(Some(surface)) = self.parsed.get(index as usize) {
            return Ok(Rc::clone(surface));
        }
        let surface = Rc::new(self.parse(index, by)?);
        if let Some(slot) = self.parsed.get_mut(index as usize) {
            *slot = Some(Rc::clone(&surface));
        }
        Ok(surface)
    }

    fn parse(&self, index: u32, by: &str) -> SceneResult<Surface> {
        let raw: document::Material = self.document.materials.get("materials", index, by)?;
        let element = label("materials", index, raw.name.as_deref());
        let mut marks = Marks::default();
        apply(&mut marks, &[MARKS], &entries_of_extras(raw.extras, &element)?, self.folder, &element)?;
        let dispersion = raw.extensions.dispersion.map_or(0.0, |d| d.dispersion);
        let refraction = raw.extensions.ior.map(|ior| refraction(ior.ior.unwrap_or(DEFAULT_IOR), dispersion, &element));
        Ok(Surface { index, marks, refraction: refraction.transpose()? })
    }
}

/// KHR_materials_ior: the index where the extension is present but says nothing.
const DEFAULT_IOR: f64 = 1.5;

fn refraction(ior: f64, dispersion: f64, element: &str) -> SceneResult<Material> {
    let range =
        |what: &str, value, expected| SceneError::at(element, SceneFault::Range { what: what.into(), value, expected });
    // The extension allows 0 as a stand-in for an infinite index, of which no droplet can be made.
    if !(1.0..=20.0).contains(&ior) {
        return Err(range("KHR_materials_ior.ior", ior, "1 to 20"));
    }
    if !(0.0..=1e6).contains(&dispersion) {
        return Err(range("KHR_materials_dispersion.dispersion", dispersion, "0 to 1e6 (20 / Abbe number)"));
    }
    if dispersion == 0.0 {
        return Ok(Material::Constant { n: ior, k: 0.0 });
    }
    Ok(Material::Table(Arc::new(cauchy_table(ior, dispersion))))
}

/// KHR_materials_dispersion: n(l) = max(1, n_d + (n_d - 1) / V_d (523655 / l^2 - 1.5168)), l in nm, V_d = 20 / dispersion;
/// a Cauchy fit through the index at the d line with the Abbe number V_d.
fn cauchy(ior: f64, dispersion: f64, wavelength_nm: f64) -> f64 {
    let abbe = 20.0 / dispersion;
    (ior + (ior - 1.0) / abbe * (523_655.0 / wavelength_nm.powi(2) - 1.5168)).clamp(1.0, 20.0)
}

/// Every nanometre: between them the formula is linear to 1e-6 of n at 300 nm.
fn cauchy_table(ior: f64, dispersion: f64) -> IndexTable {
    let nm: Vec<f64> = (200..=2500).map(f64::from).collect();
    IndexTable {
        name: format!("ior={ior},dispersion={dispersion}"),
        n: nm.iter().map(|&nm| cauchy(ior, dispersion, nm)).collect(),
        k: vec![0.0; nm.len()],
        wavelength_m: nm.iter().map(|nm| nm * 1e-9).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dispersion_has_the_abbe_number_that_the_extension_names() {
        // Fraunhofer lines F, d, C: V_d = (n_d - 1) / (n_F - n_C). The extension's rounded constants leave 1e-3.
        let [f, d, c] = [486.13, 587.56, 656.27].map(|nm| cauchy(1.5168, 20.0 / 64.17, nm));
        assert!((d - 1.5168).abs() < 2e-5, "{d}");
        assert!(((d - 1.0) / (f - c) / 64.17 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn indices_that_no_droplet_has_are_refused() {
        assert!(refraction(0.0, 0.0, "").is_err());
        assert!(refraction(1.33, -1.0, "").is_err());
        assert_eq!(refraction(1.33, 0.0, "").ok(), Some(Material::Constant { n: 1.33, k: 0.0 }));
    }
}
