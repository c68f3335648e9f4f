//! One glass ball and one ray: where it meets the surface, what is reflected there, what is refracted.
//!
//! Legend: m = n + ik, index inside over that outside; theta_o, theta_i, angles to the normal outside and inside;
//! R, reflectance of unpolarised light. Equation numbers are those of docs/theory.md.

use glam::DVec3;
use num_complex::Complex64;

use crate::accel::LocalRay;

/// What becomes of a ray at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SurfaceEvent {
    /// From outside into the ball.
    Entered,
    /// Back to the outside from where it came.
    Reflected,
    /// From inside to the outside.
    Left,
    /// Back into the ball, in part.
    ReflectedInside,
    /// Back into the ball, all of it.
    TotallyReflected,
}

/// Which of the two ways a ray takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// Back.
    Reflection,
    /// Through the surface.
    Refraction,
}

/// A ball in the frame of its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre, m.
    pub center: DVec3,
    /// Radius, m.
    pub radius_m: f64,
}

/// A ray at the surface of a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strike {
    /// Where, on the surface.
    pub point: DVec3,
    /// Distance from the ray's origin, m.
    pub way_m: f64,
    /// Share of the light that is reflected: 0 to 1.
    pub reflectance: f64,
    /// Direction of what is reflected.
    pub reflected: DVec3,
    /// Direction of what is refracted; `None` where nothing is, which is total reflection of a transparent ball.
    pub refracted: Option<DVec3>,
    is_inside: bool,
}

impl Ball {
    /// A ray from outside at the point where it enters, `t_m` along it.
    pub fn strike_outside(&self, ray: &LocalRay, t_m: f64, m: Complex64) -> Strike {
        let (point, normal) = self.on_surface(ray, t_m);
        let d = ray.direction;
        let cos_o = (-d.dot(normal)).clamp(0.0, 1.0);
        let eta = 1.0 / m.re;
        let sin2_i = eta * eta * (1.0 - cos_o * cos_o);
        // Snell's law as a vector, theory (70).
        let refracted = (sin2_i < 1.0).then(|| (eta * d + (eta * cos_o - (1.0 - sin2_i).sqrt()) * normal).normalize());
        let reflected = (d + 2.0 * cos_o * normal).normalize();
        Strike { point, way_m: t_m, reflectance: reflectance(m, cos_o), reflected, refracted, is_inside: false }
    }

    /// A ray from inside at the point where it meets the surface.
    pub fn strike_inside(&self, ray: &LocalRay, m: Complex64) -> Strike {
        let to_center = self.center - ray.origin;
        let middle = to_center.dot(ray.direction);
        let rest = self.radius_m * self.radius_m - (to_center - middle * ray.direction).length_squared();
        let way_m = (middle + rest.max(0.0).sqrt()).max(0.0);
        let (point, normal) = self.on_surface(ray, way_m);
        let d = ray.direction;
        let cos_i = d.dot(normal).clamp(0.0, 1.0);
        let sin2_o = m.re * m.re * (1.0 - cos_i * cos_i);
        let reflected = (d - 2.0 * cos_i * normal).normalize();
        let cos_o = (1.0 - sin2_o).max(0.0).sqrt();
        let is_total = sin2_o >= 1.0;
        let refracted = (!is_total).then(|| (m.re * d + (cos_o - m.re * cos_i) * normal).normalize());
        // Light meets the same resistance both ways (reciprocity).
        let reflectance = if is_total { 1.0 } else { reflectance(m, cos_o) };
        Strike { point, way_m, reflectance, reflected, refracted, is_inside: true }
    }

    /// The point at a distance along a ray, moved to the surface, and the normal there, which points outward.
    fn on_surface(&self, ray: &LocalRay, t_m: f64) -> (DVec3, DVec3) {
        let offset = ray.origin + t_m * ray.direction - self.center;
        let normal = offset.try_normalize().unwrap_or(-ray.direction);
        (self.center + self.radius_m * normal, normal)
    }
}

impl Strike {
    /// The ray that goes on, and what happened to it. Where nothing is refracted all is reflected.
    pub fn turn(&self, branch: Branch) -> (SurfaceEvent, LocalRay) {
        let (event, direction) = match (branch, self.refracted, self.is_inside) {
            (Branch::Refraction, Some(direction), false) => (SurfaceEvent::Entered, direction),
            (Branch::Refraction, Some(direction), true) => (SurfaceEvent::Left, direction),
            (_, Some(_), true) => (SurfaceEvent::ReflectedInside, self.reflected),
            (_, None, true) => (SurfaceEvent::TotallyReflected, self.reflected),
            (_, _, false) => (SurfaceEvent::Reflected, self.reflected),
        };
        (event, LocalRay { origin: self.point, direction })
    }
}

/// Fresnel's reflectance of unpolarised light, theory (71), by the cosine of the angle outside.
///
/// ```
/// use mie_cloud::transport::reflectance;
/// use num_complex::Complex64;
/// let r = reflectance(Complex64::new(1.5, 0.0), 1.0);
/// assert!((r - 0.04).abs() < 1e-15);
/// ```
pub fn reflectance(m: Complex64, cos_o: f64) -> f64 {
    let sin2_o = (1.0 - cos_o * cos_o).max(0.0);
    let cos_i = (1.0 - sin2_o / (m * m)).sqrt();
    let ratio = |a: Complex64, b: Complex64| {
        let sum = (a + b).norm_sqr();
        // Exactly grazing: nothing passes, but for an index of one.
        if sum > 0.0 { (a - b).norm_sqr() / sum } else { f64::from(m != Complex64::new(1.0, 0.0)) }
    };
    let (s, p) = (ratio(Complex64::from(cos_o), m * cos_i), ratio(m * cos_o, cos_i));
    (0.5 * (s + p)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: Ball = Ball { center: DVec3::ZERO, radius_m: 1.0 };

    #[test]
    fn every_way_is_recorded() {
        let m = Complex64::new(1.5, 0.0);
        let ray = LocalRay { origin: DVec3::new(0.5, 0.0, 2.0), direction: DVec3::NEG_Z };
        let strike = BALL.strike_outside(&ray, 2.0 - 0.75f64.sqrt(), m);
        assert_eq!(strike.turn(Branch::Reflection).0, SurfaceEvent::Reflected);
        let (event, inside) = strike.turn(Branch::Refraction);
        assert_eq!(event, SurfaceEvent::Entered);
        let strike = BALL.strike_inside(&inside, m);
        assert_eq!(strike.turn(Branch::Reflection).0, SurfaceEvent::ReflectedInside);
        assert_eq!(strike.turn(Branch::Refraction).0, SurfaceEvent::Left);
        // From a point near the surface, along it: beyond the critical angle for ever.
        let mut ray = LocalRay { origin: DVec3::new(0.9, 0.0, 0.0), direction: DVec3::Y };
        for _ in 0..1000 {
            let event;
            (event, ray) = BALL.strike_inside(&ray, m).turn(Branch::Refraction);
            assert_eq!(event, SurfaceEvent::TotallyReflected);
        }
    }

    #[test]
    fn rays_are_reversible_and_stay_in_their_plane() {
        let m = Complex64::new(1.33, 0.0);
        for b in [0.0, 0.1, 0.5, 0.9, 0.999, 0.999_999] {
            let ray = LocalRay { origin: DVec3::new(b, 0.0, 3.0), direction: DVec3::NEG_Z };
            let strike = BALL.strike_outside(&ray, 3.0 - f64::sqrt(1.0 - b * b), m);
            let (_, inside) = strike.turn(Branch::Refraction);
            let (_, out) = BALL.strike_inside(&inside, m).turn(Branch::Refraction);
            let back = LocalRay { origin: out.origin, direction: -out.direction };
            let (_, inside) = BALL.strike_outside(&back, 0.0, m).turn(Branch::Refraction);
            let (_, last) = BALL.strike_inside(&inside, m).turn(Branch::Refraction);
            // Near the edge an angle is the root of the rounding.
            assert!((last.direction - DVec3::Z).length() < 1e-7, "{b}: {last:?}");
            assert!(out.direction.y == 0.0 && (last.origin - strike.point).length() < 1e-7);
        }
    }

    #[test]
    fn an_index_of_one_changes_nothing() {
        let m = Complex64::new(1.0, 0.0);
        for b in [0.0, 0.3, 0.999] {
            let ray = LocalRay { origin: DVec3::new(b, 0.0, 3.0), direction: DVec3::NEG_Z };
            let strike = BALL.strike_outside(&ray, 3.0 - f64::sqrt(1.0 - b * b), m);
            // The root of a difference: rounding squared.
            assert!(strike.reflectance < 1e-24);
            let (_, inside) = strike.turn(Branch::Refraction);
            let (event, out) = BALL.strike_inside(&inside, m).turn(Branch::Refraction);
            assert_eq!(event, SurfaceEvent::Left);
            assert!((out.direction - DVec3::NEG_Z).length() < 1e-12);
        }
        assert_eq!(reflectance(m, 0.0), 0.0);
        assert_eq!(reflectance(Complex64::new(1.33, 0.0), 0.0), 1.0);
    }
}
