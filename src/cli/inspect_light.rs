//! Suns and camera in words.

use glam::DVec3;

use crate::excerpt::excerpt;
use crate::scene::model::{Camera, Lens, Scene, Sun};
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::units::short::number;

/// A sun: how bright, whence, how wide, and what its light is made of in the picture's spectral mode.
pub fn sun(scene: &Scene, sampling: &SpectralSampling, sun: &Sun) -> String {
    let diameter_deg = scene.sun_diameter_deg(sun);
    let width = if diameter_deg > 0.0 { format!("{diameter_deg} degrees wide") } else { "a point".into() };
    let light = match irradiance(scene, sampling, sun) {
        Some(irradiance) => format!("irradiance {} W m^-2 nm^-1", number(irradiance)),
        None => format!("spectrum {}", sun.spectrum.unwrap_or(scene.settings.sun.spectrum)),
    };
    let has_colour = sun.color != [1.0; 3] && !matches!(sampling.mode(), SpectralMode::Mono { .. });
    let colour = if has_colour { format!(", colour ({})", sun.color.map(number).join(", ")) } else { String::new() };
    format!("{}: {} lx, shining along {}, {width}, {light}{colour}", sun.name, number(sun.lux), vector(sun.direction))
}

/// Irradiance before colour, W m^-2 nm^-1, where it sets the picture's brightness: `bands` are relative to the suns' light.
pub fn irradiance(scene: &Scene, sampling: &SpectralSampling, sun: &Sun) -> Option<f64> {
    let brightest = scene.suns.iter().map(|sun| sun.lux).fold(0.0, f64::max);
    let share = if brightest > 0.0 { sun.lux / brightest } else { 0.0 };
    let is_relative = matches!(sampling.mode(), SpectralMode::Bands { .. });
    (!is_relative).then_some(scene.settings.sun.irradiance * share)
}

/// A camera: where, looking where, how wide; what is up where that does not follow.
pub fn camera(camera: &Camera) -> String {
    let frame = camera.world_from_camera;
    let up = if is_upright(camera) { String::new() } else { format!(", up {}", vector(frame.y_axis)) };
    let (name, position) = (excerpt(&camera.name), vector(camera.position_m));
    format!("{name} at {position} m, looking along {}{up}, {}", vector(-frame.z_axis), lens(camera.lens))
}

/// Whether up in the picture is up in the world, +Y, as far as the direction allows.
fn is_upright(camera: &Camera) -> bool {
    let frame = camera.world_from_camera;
    // A ten-thousandth of a degree; rotations in files are rounded to some seven digits.
    frame.x_axis.y.abs() < 2e-6 && frame.y_axis.y > 2e-6
}

/// The camera's lens in words.
pub fn lens(lens: Lens) -> String {
    match lens {
        Lens::Perspective { yfov_rad, .. } => format!("{:.2} degrees high", yfov_rad.to_degrees()),
        Lens::Orthographic { xmag_m, ymag_m } => format!("{} m x {} m", 2.0 * xmag_m, 2.0 * ymag_m),
    }
}

fn vector(v: DVec3) -> String {
    // What rounding has left of nothing is nothing.
    let near = |x: f64| if x.abs() > 1e-6 * v.length() { number(x) } else { "0".into() };
    format!("({}, {}, {})", near(v.x), near(v.y), near(v.z))
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    #[test]
    fn up_is_said_where_the_camera_is_rolled() {
        let said = |world_from_camera: DMat3| {
            let lens = Lens::Orthographic { xmag_m: 1.0, ymag_m: 0.5 };
            camera(&Camera { name: "c".into(), position_m: DVec3::new(0.0, 1.0, 2.0), world_from_camera, lens })
        };
        assert_eq!(said(DMat3::IDENTITY), "c at (0, 1, 2) m, looking along (0, 0, -1), 2 m x 1 m");
        let yaw = DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(-0.2);
        assert!(!said(yaw).contains("up"), "{}", said(yaw));
        assert!(said(yaw * DMat3::from_rotation_z(0.01)).contains("up (-0.0"));
        assert!(said(DMat3::from_rotation_z(std::f64::consts::PI)).contains("up (0, -1, 0)"));
        // Straight down: up is anywhere.
        assert!(said(DMat3::from_rotation_x(-0.5 * std::f64::consts::PI)).contains("(0, -1, 0), up (0, 0, -1)"));
    }
}
