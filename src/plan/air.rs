//! How much light changes the picture that air and droplets scatter one after the other.

use super::Estimate;
use super::facts::SceneFacts;
use crate::scene::model::Scene;

/// Glow against the rest of the picture; theory (103).
pub(super) fn glow(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let air = &scene.settings.atmosphere;
    if air.scattering_per_m <= 0.0 {
        return (Some(0.0), "there is no air that scatters".into());
    }
    if facts.is_empty() {
        return (Some(0.0), "there are no droplets to light the air".into());
    }
    let albedo = scene.classes.iter().map(|class| class.albedo.unwrap_or(1.0)).fold(0.0, f64::max);
    let estimate = albedo * facts.glow;
    let reason =
        format!("what droplets send into {} m of air comes to {:.3} % of what is seen", air.depth_m, 100.0 * estimate);
    (Some(estimate), reason)
}

/// Light that the air scatters between other scatterings, against the rest of the picture.
///
/// The air scatters the share g = 1 - exp(-depth) of what crosses it, and of that again: exp(depth) - 1 of what it scatters once.
/// Where the sun does not light it, glow takes the place of that, and what comes back to droplets from the air about them
/// theory (104).
pub(super) fn air_multiple(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let air = &scene.settings.atmosphere;
    if air.scattering_per_m <= 0.0 {
        return (Some(0.0), "there is no air that scatters".into());
    }
    let depth = air.scattering_per_m * air.depth_m;
    let by_air = -(-depth).exp_m1();
    let background = &scene.settings.background;
    let is_bright = background.image.is_some() || background.radiance != [0.0; 3];
    let share = match () {
        () if facts.sun_shines && air.sunlight || is_bright => depth.exp_m1(),
        () if facts.sun_shines => facts.glow * (1.0 + depth.exp_m1() + facts.met_again),
        () => 0.0,
    };
    (Some(share), format!("the air scatters {:.2} % of what crosses its {} m again", 100.0 * by_air, air.depth_m))
}
