//! Which droplets can be seen as what they are, glass balls, and which only scatter: by size in the picture and in waves.

use std::f64::consts::TAU;

use glam::DVec3;

use super::model::{Camera, Lens, Particle, ParticleKind, Scene};
use super::settings::Settings;
use crate::spectrum::SpectralMode;

/// Smallest projected diameter of a ball that can be seen, pixels.
const LEAST_PIXELS: f64 = 1.0;

/// Smallest size parameter of a droplet through which light goes in rays: diffraction spreads what passes it by about
/// 1/x, 0.6 degrees here, far below the tens of degrees by which it is refracted.
const LEAST_SIZE_PARAMETER: f64 = 100.0;

/// A droplet is magnified where it is drawn larger than it is by more than rounding.
const MAGNIFIED: f64 = 1.01;

/// The wavelength for size parameters where a picture has many, m: the middle of the visible range, where eyes see best.
const MIDDLE_WAVELENGTH_M: f64 = 550e-9;

/// Decides for a scene which droplets are resolved.
#[derive(Clone, Debug)]
pub struct Resolution {
    camera: Camera,
    wavelength_m: f64,
    /// Perspective: pixels per radian in the middle of the picture; orthographic: pixels per metre (oblong ones: by area).
    pixels_per_unit: f64,
}

impl Resolution {
    /// Of a scene with its camera, resolution and wavelengths.
    pub fn of(scene: &Scene) -> Self {
        let [width, height] = scene.settings.image.resolution.map(f64::from);
        let pixels_per_unit = match scene.camera.lens {
            Lens::Perspective { yfov_rad, .. } => 0.5 * height / (0.5 * yfov_rad).tan(),
            Lens::Orthographic { xmag_m, ymag_m } => 0.5 * (width / xmag_m * height / ymag_m).sqrt(),
        };
        let wavelength_m = middle_wavelength_m(&scene.settings);
        Self { camera: scene.camera.clone(), wavelength_m, pixels_per_unit }
    }

    /// Whether a particle is a glass ball: a droplet that covers more than a pixel and is either large against the
    /// wavelength or drawn larger than it is.
    pub fn is_resolved(&self, particle: &Particle) -> bool {
        if particle.kind != ParticleKind::Droplet {
            return false;
        }
        let (drawn_m, own_m) = radii_m(particle);
        let is_large = TAU * own_m > LEAST_SIZE_PARAMETER * self.wavelength_m;
        (is_large || drawn_m > MAGNIFIED * own_m) && self.diameter_pixels(particle.center_m, drawn_m) > LEAST_PIXELS
    }

    /// Projected diameter of a ball, pixels in the middle of the picture; infinite where the camera is in it.
    pub fn diameter_pixels(&self, center_m: DVec3, radius_m: f64) -> f64 {
        let distance_m = match self.camera.lens {
            Lens::Orthographic { .. } => 1.0,
            Lens::Perspective { .. } => (center_m - self.camera.position_m).length(),
        };
        if distance_m <= radius_m && matches!(self.camera.lens, Lens::Perspective { .. }) {
            return f64::INFINITY;
        }
        2.0 * radius_m / distance_m * self.pixels_per_unit
    }
}

/// The wavelength that stands for all of a picture's, m.
pub fn middle_wavelength_m(settings: &Settings) -> f64 {
    match settings.spectral_mode {
        Some(SpectralMode::Mono { wavelength_m }) => wavelength_m,
        Some(SpectralMode::Rgb { wavelengths_m: [_, green_m, _] }) => green_m,
        Some(SpectralMode::Bands { .. }) | None => MIDDLE_WAVELENGTH_M,
    }
}

/// Drawn and own radius of a droplet, m.
fn radii_m(particle: &Particle) -> (f64, f64) {
    let drawn_m = f64::from(particle.radius_m);
    let own_m = f64::from(particle.droplet_radius_m);
    (drawn_m, if own_m > 0.0 { own_m } else { drawn_m })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    fn camera(lens: Lens) -> Resolution {
        let camera = Camera { name: "c".into(), position_m: DVec3::ZERO, world_from_camera: DMat3::IDENTITY, lens };
        let pixels_per_unit = if matches!(camera.lens, Lens::Orthographic { .. }) { 50.0 } else { 1000.0 };
        Resolution { camera, wavelength_m: 500e-9, pixels_per_unit }
    }

    fn drop(z_m: f64, drawn_m: f64, own_m: f64) -> Particle {
        Particle {
            center_m: DVec3::new(0.0, 0.0, z_m),
            radius_m: drawn_m as f32,
            droplet_radius_m: own_m as f32,
            count: 1.0,
            class: 0,
            kind: ParticleKind::Droplet,
        }
    }

    #[test]
    fn what_covers_more_than_a_pixel_and_is_large_or_magnified_is_glass() {
        let lens = Lens::Perspective { yfov_rad: 1.0, aspect: None };
        let is_glass = |particle: &Particle| camera(lens).is_resolved(particle);
        // A millimetre at 2 m is half a milliradian in radius: one pixel across.
        assert!(is_glass(&drop(-1.9, 1e-3, 1e-3)) && !is_glass(&drop(-2.1, 1e-3, 1e-3)));
        // Twenty micrometres are 251 waves about, seven are 88.
        assert!(is_glass(&drop(-0.01, 20e-6, 20e-6)) && !is_glass(&drop(-0.01, 7e-6, 7e-6)));
        assert!(is_glass(&drop(-0.01, 20e-6, 0.0)) && !is_glass(&drop(-0.01, 7e-6, 0.0)));
        assert!(is_glass(&drop(-1.0, 0.1, 1e-7)) && !is_glass(&drop(-1000.0, 0.1, 1e-7)));
        assert!(is_glass(&drop(0.0, 0.1, 0.1)), "the camera is in it");
        let parcel = Particle { kind: ParticleKind::Parcel, ..drop(-1.0, 1.0, 1e-3) };
        assert!(!is_glass(&parcel));
        // Fifty pixels per metre, at any distance.
        let lens = Lens::Orthographic { xmag_m: 1.0, ymag_m: 1.0 };
        assert!(
            camera(lens).is_resolved(&drop(-1e6, 0.011, 1e-3)) && !camera(lens).is_resolved(&drop(0.0, 0.009, 1e-3))
        );
    }
}
