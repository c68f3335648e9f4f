//! KHR_lights_punctual: directional lights are suns; others are noted.

use super::document::{self, Document, label};
use super::nodes::Visit;
use super::unrendered::{Kind, Unrendered};
use crate::excerpt::excerpt;
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::folder::Folder;
use crate::scene::marks::{LIGHT, LightMarks};
use crate::scene::model::Sun;
use crate::scene::settings_parse::{apply, entries_of_extras};

/// Brighter than any star that is lived under; keeps products in single precision finite, lx.
const BRIGHTEST_LUX: f64 = 1e12;

/// Adds the node's light to the suns, if it has one; `marks` are the node's own, which win over the light's.
///
/// # Errors
/// When the light does not exist or is out of range.
pub fn take(
    document: &Document,
    folder: &Folder,
    visit: &Visit,
    marks: LightMarks,
    suns: &mut Vec<Sun>,
    notes: &mut Unrendered,
) -> SceneResult<()> {
    let Some(reference) = &visit.node.extensions.light else {
        let idle = u64::from(marks != LightMarks::default());
        notes.note(Kind::IdleLightMark, idle, || visit.element.clone());
        return Ok(());
    };
    let none = document::Elements::default();
    let lights = document.extensions.lights.as_ref().map_or(&none, |extension| &extension.lights);
    let light: document::Light = lights.get("KHR_lights_punctual.lights", reference.light, &visit.element)?;
    let element = label("KHR_lights_punctual.lights", reference.light, light.name.as_deref());
    match light.kind.as_str() {
        "directional" => {}
        "point" | "spot" => {
            notes.note(Kind::OtherLight, 1, || element);
            return Ok(());
        }
        _ => {
            let remedy = "directional, point and spot lights are known";
            return Err(SceneError::at(element, SceneFault::Missing { what: "known type", remedy }));
        }
    }
    let mut own = LightMarks::default();
    apply(&mut own, &[LIGHT], &entries_of_extras(light.extras, &element)?, folder, &element)?;
    // The light shines along the node's -Z.
    let direction = (-visit.world_from_node.matrix3.z_axis).try_normalize().ok_or_else(|| {
        let what = "the scale of the light".into();
        SceneError::at(&visit.element, SceneFault::Range { what, value: 0.0, expected: "a scale that is not 0" })
    })?;
    // Many nodes may hold one light: a long name of it is not kept for each.
    let name = visit.node.name.as_deref().or(light.name.as_deref()).map_or_else(|| "sun".into(), excerpt);
    suns.push(Sun {
        name,
        direction,
        lux: within(light.intensity.unwrap_or(1.0), BRIGHTEST_LUX, "intensity", &element)?,
        color: color(light.color.unwrap_or([1.0; 3]), &element)?,
        spectrum: marks.spectrum.or(own.spectrum),
        angular_diameter_deg: marks.angular_diameter_deg.or(own.angular_diameter_deg),
    });
    Ok(())
}

fn color([r, g, b]: [f64; 3], element: &str) -> SceneResult<[f64; 3]> {
    let part = |c| within(c, 1e6, "color", element);
    Ok([part(r)?, part(g)?, part(b)?])
}

fn within(value: f64, high: f64, what: &str, element: &str) -> SceneResult<f64> {
    if (0.0..=high).contains(&value) {
        return Ok(value);
    }
    let expected = if high > 1e6 { "0 to 1e12 lx" } else { "0 to 1e6" };
    Err(SceneError::at(element, SceneFault::Range { what: what.into(), value, expected }))
}
