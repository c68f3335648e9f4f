//! How much the background, its refraction by droplets and the size of the sun could change the picture.

use super::facts::SceneFacts;
use crate::scene::model::{Lens, Scene, Sun};

/// An estimate of the largest relative change, and what it rests on.
type Estimate = (Option<f64>, String);

/// Whether anything lies behind. How bright that is beside what the sun lights is not known before a render: a fog may send the
/// camera a hundredth of what a white wall would. A background costs no time, so one that is not black is always shown.
pub(super) fn background(scene: &Scene) -> Estimate {
    let background = &scene.settings.background;
    if let Some(image) = &background.image {
        let name = image.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        return (None, format!("the picture {name} lies behind"));
    }
    let brightest = background.radiance.iter().copied().fold(0.0, f64::max);
    if brightest == 0.0 {
        return (Some(0.0), "the background is black".into());
    }
    (None, format!("radiance {brightest:.3e} lies behind, and costs nothing"))
}

/// Glass changes the picture where it covers it, as far as there is anything to be seen in it. The error of a picture is a
/// root mean square, hence the root of the covered share.
pub(super) fn refraction(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let air = &scene.settings.atmosphere;
    let is_bright = scene.settings.background.image.is_some() || scene.settings.background.radiance != [0.0; 3];
    let others = facts.n_particles + facts.n_fog_boxes > 1;
    // Where the sun does not light the air, the droplets do.
    let lit_air = air.scattering_per_m > 0.0;
    match facts.n_resolved {
        0 => (Some(0.0), "no droplet is large enough to be seen".into()),
        n if !(is_bright || others || lit_air) => {
            (Some(0.0), format!("nothing is to be seen through {n} droplets of glass"))
        }
        n => {
            let reason = format!("{n} droplets of glass cover about {:.3} of the picture", facts.glass_cover);
            (Some(facts.glass_cover.sqrt()), reason)
        }
    }
}

/// A disc matters where it is seen, and where it blurs what droplets scatter.
pub(super) fn sun_disc(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let diameter_deg = |sun: &Sun| if sun.lux > 0.0 { scene.sun_diameter_deg(sun) } else { 0.0 };
    let largest_deg = scene.suns.iter().map(diameter_deg).fold(0.0, f64::max);
    if largest_deg == 0.0 {
        return (Some(0.0), "the sun is a point".into());
    }
    if scene.suns.iter().any(|sun| diameter_deg(sun) > 0.0 && is_in_picture(scene, sun)) {
        return (None, format!("the sun's disc of {largest_deg} degrees is in the picture"));
    }
    // The mean of a diffraction peak 1 - (x theta / 2)^2 over a disc of radius a is 1 - (x a)^2 / 8 (theory (78)).
    let blurred = (facts.largest_size_parameter * 0.5 * largest_deg.to_radians()).powi(2) / 8.0;
    let reason = format!(
        "a disc of {largest_deg} degrees lowers the peaks of droplets of size parameter {:.0} by {:.3}",
        facts.largest_size_parameter,
        blurred.min(1.0)
    );
    (Some(blurred.min(1.0)), reason)
}

/// Whether any part of a sun's disc may stand in the picture.
fn is_in_picture(scene: &Scene, sun: &Sun) -> bool {
    let camera = &scene.camera;
    let d = camera.world_from_camera.transpose() * -sun.direction;
    let radius_rad = 0.5 * scene.sun_diameter_deg(sun).to_radians();
    // The angle from the axis to the picture's corner bounds all that it sees.
    let corner_rad = match camera.lens {
        Lens::Orthographic { .. } => 0.0,
        Lens::Perspective { yfov_rad, .. } => {
            let [width, height] = scene.settings.image.resolution.map(f64::from);
            let up = (0.5 * yfov_rad).tan();
            up.hypot(up * width / height).atan()
        }
    };
    (-d.z).clamp(-1.0, 1.0).acos() <= corner_rad + radius_rad
}
