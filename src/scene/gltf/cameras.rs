//! glTF cameras: the first in scene order, or the one that was asked for.

use glam::{DAffine3, DMat3};

use super::document::{self, Document, label};
use super::nodes::Visit;
use crate::excerpt::excerpt;
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::model::{Camera, Lens};
use crate::suggest::closest;
use crate::warning::Warning;

/// Watches for cameras while the scene is walked.
pub struct Cameras<'a> {
    wanted: Option<&'a str>,
    found: Option<Camera>,
    count: u64,
    /// How many are the one that was asked for, or any.
    n_found: u64,
    /// The first few names, for messages.
    names: Vec<String>,
}

/// Names that a message lists at most.
const LISTED: usize = 8;

impl<'a> Cameras<'a> {
    /// Looks for the camera called `wanted`, or any.
    pub fn new(wanted: Option<&'a str>) -> Self {
        Self { wanted, found: None, count: 0, n_found: 0, names: Vec::new() }
    }

    /// Takes the node's camera, if it has one and it is the one.
    ///
    /// # Errors
    /// When the camera does not exist or is out of range.
    pub fn take(&mut self, document: &Document, visit: &Visit) -> SceneResult<()> {
        let Some(index) = visit.node.camera else { return Ok(()) };
        let camera: document::Camera = document.cameras.get("cameras", index, &visit.element)?;
        let node_name = visit.node.name.as_deref();
        let name = node_name.or(camera.name.as_deref()).unwrap_or("camera");
        self.count += 1;
        if self.names.len() < LISTED {
            self.names.push(excerpt(name));
        }
        let lens = lens(&camera, &label("cameras", index, camera.name.as_deref()))?;
        let is_it = match self.wanted {
            Some(wanted) => node_name == Some(wanted) || camera.name.as_deref() == Some(wanted),
            None => true,
        };
        self.n_found += u64::from(is_it);
        if is_it && self.found.is_none() {
            let world_from_camera = frame(&visit.world_from_node, &visit.element)?;
            let position_m = visit.world_from_node.translation;
            self.found = Some(Camera { name: name.into(), position_m, world_from_camera, lens });
        }
        Ok(())
    }

    /// The camera, if there is one, and a word about the others.
    ///
    /// # Errors
    /// When one was asked for and is not there.
    pub fn finish(self, warnings: &mut Vec<Warning>) -> SceneResult<Option<Camera>> {
        if let (None, Some(wanted)) = (&self.found, self.wanted) {
            let available = match self.names.as_slice() {
                [] => "the scene has none".into(),
                [only] => format!("the scene's only one is `{only}`"),
                names => {
                    let hint = closest(wanted, names.iter().map(String::as_str));
                    let hint = hint.map_or_else(String::new, |name| format!("did you mean `{name}`? "));
                    format!("{hint}there are {}", names.join(", "))
                }
            };
            return Err(SceneError::at("--camera", SceneFault::NoSuchCamera { name: excerpt(wanted), available }));
        }
        match (&self.found, self.wanted, self.n_found) {
            (Some(camera), None, n @ 2..) => {
                let what = format!("{n} cameras; the first, {}, is used", excerpt(&camera.name));
                warnings.push(Warning::new(what, format!("choose with --camera: {}", self.names.join(", "))));
            }
            (Some(_), Some(wanted), n @ 2..) => {
                let what =
                    format!("--camera: {n} cameras are called {}; the first in scene order is used", excerpt(wanted));
                warnings.push(Warning::new(what, "give their nodes names that differ"));
            }
            _ => {}
        }
        Ok(self.found)
    }
}

fn lens(camera: &document::Camera, element: &str) -> SceneResult<Lens> {
    let check = |what: &str, value: f64, high: f64, expected| {
        if value > 0.0 && value < high {
            return Ok(value);
        }
        Err(SceneError::at(element, SceneFault::Range { what: what.into(), value, expected }))
    };
    match (camera.kind.as_str(), camera.perspective, camera.orthographic) {
        ("perspective", Some(lens), _) => {
            let aspect = lens.aspect_ratio.map(|a| check("aspectRatio", a, 1e6, "above 0, below 1e6")).transpose()?;
            let yfov_rad = check("yfov", lens.yfov, std::f64::consts::PI, "above 0, below pi")?;
            Ok(Lens::Perspective { yfov_rad, aspect })
        }
        ("orthographic", _, Some(lens)) => Ok(Lens::Orthographic {
            xmag_m: check("xmag", lens.xmag, 1e12, "above 0, below 1e12")?,
            ymag_m: check("ymag", lens.ymag, 1e12, "above 0, below 1e12")?,
        }),
        ("perspective", ..) => missing(element, "`perspective`"),
        ("orthographic", ..) => missing(element, "`orthographic`"),
        _ => missing(element, "known type: perspective or orthographic are expected, and no"),
    }
}

fn missing<T>(element: &str, what: &'static str) -> SceneResult<T> {
    Err(SceneError::at(element, SceneFault::Missing { what, remedy: "export the camera again" }))
}

/// The camera's axes without scale and skew; mirrored nodes keep where they look and what is up.
fn frame(world_from_node: &DAffine3, element: &str) -> SceneResult<DMat3> {
    let backward = world_from_node.matrix3.z_axis.try_normalize();
    let axes = backward.and_then(|backward| {
        let up = world_from_node.matrix3.y_axis.reject_from_normalized(backward).try_normalize()?;
        Some(DMat3::from_cols(up.cross(backward), up, backward))
    });
    axes.ok_or_else(|| {
        let what = "the scale of the camera".into();
        SceneError::at(element, SceneFault::Range { what, value: 0.0, expected: "a scale that is not 0" })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn scaled_and_mirrored_cameras_have_orthonormal_frames() -> SceneResult<()> {
        let node = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(-3.0, 2.0, 1e-3)), translation: DVec3::ZERO };
        assert_eq!(frame(&node, "")?, DMat3::IDENTITY);
        let flat = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)), translation: DVec3::ZERO };
        assert!(frame(&flat, "").is_err());
        Ok(())
    }
}
