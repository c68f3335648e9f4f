//! How much light changes the picture that air and droplets scatter one after the other.

use super::Estimate;
use super::facts::SceneFacts;
use crate::scene::model::Scene;
use crate::units::short::{length, number, percent};

/// Glow against the rest of the picture; theory (103).
pub(super) fn glow(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let air = &scene.settings.atmosphere;
    if air.scattering_per_m <= 0.0 {
        return (Some(0.0), "no air scatters: atmosphere.scattering_per_m is 0".into());
    }
    if facts.is_empty() {
        return (Some(0.0), "there are no droplets to light the air".into());
    }
    let albedo = scene.classes.iter().map(|class| class.albedo.unwrap_or(1.0)).fold(0.0, f64::max);
    let estimate = albedo * facts.glow;
    let reason = format!(
        "what droplets send into {} of air comes to {} of what is seen",
        length(air.depth_m),
        percent(estimate)
    );
    (Some(estimate), reason)
}

/// Sunlight that the air scatters once.
pub(super) fn airlight(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let air = &scene.settings.atmosphere;
    if !air.sunlight {
        return (Some(0.0), "atmosphere.sunlight is off".into());
    }
    let depth = air.scattering_per_m * air.depth_m;
    (facts.parts.relative(facts.parts.air_rms), format!("the air's scattering optical depth is {}", number(depth)))
}

/// Light that the air scatters between other scatterings, against the rest of the picture; theory (104).
///
/// The air scatters the share g = 1 - exp(-depth) of what crosses it, and of that again: exp(depth) - 1 of what it scatters once, of what lies
/// behind and of what falls on droplets. Where the sun does not light it, glow takes the place of that, and what comes back to
/// droplets from the air about them.
pub(super) fn air_multiple(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let air = &scene.settings.atmosphere;
    if air.scattering_per_m <= 0.0 {
        return (Some(0.0), "no air scatters: atmosphere.scattering_per_m is 0".into());
    }
    let depth = air.scattering_per_m * air.depth_m;
    let (by_air, again, parts) = (-(-depth).exp_m1(), depth.exp_m1(), &facts.parts);
    let reason = format!("the air scatters {} of what crosses its {} again", percent(by_air), length(air.depth_m));
    if scene.settings.background.image.is_some() {
        return (None, reason + ", and what is beside the picture may be brighter than what is in it");
    }
    let of_sun = match facts.sun_shines && air.sunlight {
        true => parts.air_rms + parts.scattered_rms * parts.sun_rms,
        false => 0.0,
    };
    let of_glow = if facts.sun_shines { facts.glow * (again + facts.met_again) } else { 0.0 };
    let of_glow = if air.sunlight { of_glow } else { of_glow + facts.glow };
    let estimate = parts.relative(again * (of_sun + parts.background_rms)).map(|share| share + of_glow);
    (estimate, reason)
}
