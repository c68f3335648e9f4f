//! How much the background and the size of the sun could change the picture.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::DVec3;

use super::Estimate;
use super::facts::SceneFacts;
use crate::scene::model::{Lens, Scene, Sun};
use crate::units::short::{number, percent};

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
    (None, format!("radiance {} lies behind, and costs nothing", number(brightest)))
}

/// Radius of the rings about the sun and about the point opposite to it, in 1/x.
const RINGS: f64 = 3.0;

/// How much brighter a glory's rings are than what is about them, at most: 5 at the middle of those of mono-sized droplets.
const RING_CONTRAST: f64 = 5.0;

/// The forward peak is bright up to about this angle, in 1/x.
const PEAK: f64 = 10.0;

/// And never farther than this: what lies beside is no peak any more.
const WIDEST_PEAK_RAD: f64 = FRAC_PI_4;

/// A disc matters where it is seen, and where it blurs what droplets scatter: theory (106).
pub(super) fn sun_disc(scene: &Scene, facts: &SceneFacts) -> Estimate {
    let diameter_deg = |sun: &Sun| if sun.lux > 0.0 { scene.sun_diameter_deg(sun) } else { 0.0 };
    let largest_deg = scene.suns.iter().map(diameter_deg).fold(0.0, f64::max);
    if largest_deg == 0.0 {
        return (Some(0.0), "the sun is a point".into());
    }
    let wide = || scene.suns.iter().filter(|sun| diameter_deg(sun) > 0.0);
    let radius_rad = |sun: &Sun| 0.5 * scene.sun_diameter_deg(sun).to_radians();
    if wide().any(|sun| beside_picture_rad(scene, -sun.direction) <= radius_rad(sun)) {
        return (None, format!("the sun's disc of {largest_deg} degrees is in the picture"));
    }
    let a_rad = 0.5 * largest_deg.to_radians();
    let softened = (2.0 * a_rad * facts.shade_reach_m / facts.least_shade_m).sqrt().min(1.0);
    let parts = &facts.parts;
    let air_rms = if facts.haze_size_parameter > 0.0 { parts.air_rms } else { 0.0 };
    let Some((shafts, haze)) = parts.relative(parts.shade_rms * softened).zip(parts.relative(air_rms)) else {
        return (None, format!("a disc of {largest_deg} degrees softens the edges of shafts of light"));
    };
    let droplets = parts.droplets_share();
    let spheres = [
        Spheres {
            what: "droplets",
            x: facts.largest_size_parameter,
            has_fringes: facts.has_fringes,
            share: droplets,
            bright: droplets * facts.concentration,
        },
        Spheres {
            what: "haze",
            x: facts.haze_size_parameter,
            has_fringes: facts.haze_has_fringes,
            // Its bounds are far apart where it has a peak; a change of all that is seen is worth 1.
            share: haze.min(1.0),
            bright: haze.min(1.0),
        },
    ];
    let suns: Vec<&Sun> = wide().collect();
    let (mut square, mut said) = (shafts * shafts, Vec::new());
    for spheres in spheres.iter().filter(|spheres| spheres.x > 0.0 && spheres.bright > 0.0) {
        let (change, reason) = spheres.blurred(scene, &suns, a_rad);
        square += change * change;
        said.push(reason);
    }
    if shafts > 0.0 {
        said.push(format!("softens shafts of light by {}", percent(shafts)));
    }
    let said = if said.is_empty() { "blurs nothing that is seen".into() } else { said.join(", ") };
    (Some(square.sqrt()), format!("a disc of {largest_deg} degrees {said}"))
}

/// Spheres whose phase function a disc blurs.
struct Spheres {
    what: &'static str,
    /// Size parameter.
    x: f64,
    has_fringes: bool,
    /// What a change of all of their light is worth, and one of its brightest parts.
    share: f64,
    bright: f64,
}

impl Spheres {
    /// How much a disc of the angular radius a changes, and of what that is made.
    fn blurred(&self, scene: &Scene, suns: &[&Sun], a_rad: f64) -> (f64, String) {
        // Smaller ones scatter as smoothly as those of x = 1.
        let (x, what) = (self.x.max(1.0), self.what);
        let blurred = |width: f64| ((a_rad / width).powi(2) / 8.0).min(1.0);
        let peak_rad = (PEAK / x).min(WIDEST_PEAK_RAD);
        if suns.iter().any(|sun| beside_picture_rad(scene, -sun.direction) <= peak_rad) {
            let peak = blurred(1.0 / x) * self.bright;
            let said =
                format!("near the picture lowers the peaks of {what} of size parameter {x:.0} by {}", percent(peak));
            return (peak, said);
        }
        let (width, structure) = if self.has_fringes { (1.0 / x, "fringes") } else { (x.powf(-2.0 / 3.0), "bows") };
        let bows = blurred(width) * self.bright;
        let sees_glory = suns.iter().any(|sun| beside_picture_rad(scene, sun.direction) <= RINGS / x);
        let rings = (PI * (RINGS / x).powi(2) / picture_sr(scene)).min(1.0);
        let glory = if sees_glory { RING_CONTRAST * blurred(1.0 / x) * rings.sqrt() * self.share } else { 0.0 };
        let said = format!(
            "blurs {structure} of {what} of size parameter {x:.0} by {}, glories by {}",
            percent(bows),
            percent(glory)
        );
        (bows.hypot(glory), said)
    }
}

/// Tangents of half the angles that the picture sees across and up; 0 where all rays are parallel.
fn half_tangents(scene: &Scene) -> [f64; 2] {
    match scene.camera.lens {
        Lens::Orthographic { .. } => [0.0; 2],
        Lens::Perspective { yfov_rad, .. } => {
            let [width, height] = scene.settings.image.resolution.map(f64::from);
            let up = (0.5 * yfov_rad).tan();
            [up * width / height, up]
        }
    }
}

/// Solid angle of the picture, sr, as if it were small; at least that of a ray as wide as the sun's disc.
fn picture_sr(scene: &Scene) -> f64 {
    let [across, up] = half_tangents(scene);
    (4.0 * across * up).max(1e-4)
}

/// How far a direction lies from what the picture may see, rad; 0 or less inside: the angle from the axis to its corner bounds it.
fn beside_picture_rad(scene: &Scene, direction: DVec3) -> f64 {
    let d = scene.camera.world_from_camera.transpose() * direction;
    let [across, up] = half_tangents(scene);
    (-d.z).clamp(-1.0, 1.0).acos() - across.hypot(up).atan()
}
