//! How much droplets change by meeting each other's light, by shading each other and the air, and by being glass.

use super::Estimate;
use super::facts::SceneFacts;
use crate::scene::model::Scene;
use crate::units::short::{number, percent};

/// 1 - g of droplets that are large against the wavelength: each order turns light by so much of a turn in all directions.
pub(super) const TURNED: f64 = 0.15;

/// Sunlight that droplets scatter once.
pub(super) fn direct(facts: &SceneFacts) -> Estimate {
    if facts.is_empty() {
        return (Some(0.0), "there are no droplets".into());
    }
    let parts = &facts.parts;
    let most = parts.droplets_rms / parts.surroundings_least;
    let reason = match facts.seen_depth > 0.0 {
        true => format!("optical depth about {} along the camera's rays", number(facts.seen_depth)),
        false => "the camera's rays meet no droplet".into(),
    };
    (most.is_finite().then_some(most), reason)
}

/// Light that droplets scatter meets droplets again, theory (101), as does what they scatter of the background, on its way to the camera
/// or into the air before it.
pub(super) fn multiple(scene: &Scene, facts: &SceneFacts) -> Estimate {
    if facts.is_empty() {
        return (Some(0.0), "there are no droplets".into());
    }
    let albedo = scene.classes.iter().map(|class| class.albedo.unwrap_or(1.0)).fold(0.0, f64::max);
    let met_unseen = 1.0 - (-facts.sunward_depth).exp();
    let reason = match facts.cover > 0.0 {
        true => format!(
            "of what droplets scatter {} meets droplets again, over {} of the picture",
            percent(facts.met_again / facts.concentration),
            percent(facts.concentration.powi(-2))
        ),
        false => {
            format!("of what droplets that are not seen send into the air {} meets droplets again", percent(met_unseen))
        }
    };
    if scene.settings.background.image.is_some() {
        return (None, reason + ", and what is beside the picture may be brighter than what is in it");
    }
    let (parts, orders) = (&facts.parts, 1.0 + TURNED * facts.sunward_depth);
    let of_sun = match facts.sun_shines {
        true => facts.met_again * parts.droplets_share() + facts.glow * met_unseen,
        false => 0.0,
    };
    let again = (scene.settings.atmosphere.scattering_per_m * scene.settings.atmosphere.depth_m).exp_m1();
    let into_air = again * (1.0 - (-facts.deepest_optical_depth).exp());
    let of_background = parts.relative((parts.scattered_rms + into_air) * parts.background_rms);
    (of_background.map(|share| share + albedo * of_sun * orders), reason)
}

/// Shade on droplets, theory (102), of which the air that they light has its part, and on the air where the sun lights it.
pub(super) fn shadows(facts: &SceneFacts) -> Estimate {
    if facts.is_empty() {
        return (Some(0.0), "there are no droplets".into());
    }
    let parts = &facts.parts;
    // Without shade all orders are lit in full.
    let orders = 1.0 + facts.sunward_depth;
    let on_droplets = orders * (1.0 / facts.sunlit.max(f64::MIN_POSITIVE) - 1.0);
    let air = match parts.air_rms > 0.0 {
        true => format!(", and {} of what lights the air", percent(parts.shade_rms / parts.air_rms)),
        false => String::new(),
    };
    let reason = format!("droplets take {} of each other's sunlight{air}", percent(1.0 - facts.sunlit));
    let shaded = on_droplets * (facts.concentration * parts.droplets_share() + facts.glow);
    let estimate = parts.relative(parts.shade_rms).map(|share| share + shaded);
    (estimate, reason)
}

/// Glass changes the picture where it covers it: what lies behind is seen through it, and what the droplet scatters comes from its
/// own outline, not from its extinction disc of twice the area. The error of a picture is a root mean square, relative to its
/// mean; where nothing else is bright, that mean is the droplets' own light.
pub(super) fn refraction(facts: &SceneFacts) -> Estimate {
    if facts.n_resolved == 0 {
        return (Some(0.0), "no droplet is large enough to be seen".into());
    }
    let (n, covered) = (facts.n_resolved, facts.glass_cover);
    let droplets = if n == 1 { "droplet" } else { "droplets" };
    let own = covered.sqrt() / facts.cover.max(covered) * facts.parts.droplets_share();
    let behind = facts.parts.relative(covered.sqrt() * facts.parts.background_rms);
    (
        behind.map(|share| share + own),
        format!("{n} {droplets} of glass, in their own outlines, cover about {} of the picture", percent(covered)),
    )
}
