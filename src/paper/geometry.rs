//! The paper's geometry: where a ray meets a sphere, and how it bends there.

use glam::DVec3;

/// Where a ray meets the sphere: the roots of |o + t d - c|^2 = R^2, theory (87); `None` where it misses.
///
/// `direction` has unit length, so the quadratic t^2 + 2 b t + c has leading coefficient 1.
pub fn ray_sphere(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> Option<(f64, f64)> {
    let from_center = origin - center;
    let b = from_center.dot(direction);
    let c = from_center.length_squared() - radius * radius;
    let discriminant = b * b - c;
    (discriminant > 0.0).then(|| (-b - discriminant.sqrt(), -b + discriminant.sqrt()))
}

/// What becomes of a ray at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AtSurface {
    /// It goes through, in this direction.
    Refracted(DVec3),
    /// It cannot: total internal reflection.
    TotalReflection,
}

/// Snell's law in vectors, theory (88): T = eta I + (eta cos_i - sqrt(1 - eta^2 (1 - cos_i^2))) N.
///
/// I, unit vector along the ray; N, unit normal against it; eta, index on this side over index on the other.
pub fn snell(incoming: DVec3, normal: DVec3, eta: f64) -> AtSurface {
    let cos_i = -normal.dot(incoming);
    let cos_t_squared = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
    if cos_t_squared < 0.0 {
        return AtSurface::TotalReflection; // the published root would be NaN
    }
    AtSurface::Refracted(eta * incoming + (eta * cos_i - cos_t_squared.sqrt()) * normal)
}

/// What becomes of a ray that meets a sphere from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// It leaves the sphere at `point` in `direction`.
    Left { point: DVec3, direction: DVec3 },
    /// It is reflected inside, and the paper follows it no further.
    TotalReflection,
}

/// Follows a ray that meets the sphere at `point` through it: refraction, the chord, refraction.
pub fn pass_sphere(point: DVec3, direction: DVec3, center: DVec3, radius: f64, index: f64) -> Passage {
    let outward = (point - center) / radius;
    let AtSurface::Refracted(inside) = snell(direction, outward, 1.0 / index) else { return Passage::TotalReflection };
    // From a point on the sphere the chord is the second root: t = -2 (o - c) . d.
    let chord = -2.0 * (point - center).dot(inside);
    let exit = point + chord * inside;
    let inward = (center - exit) / radius;
    match snell(inside, inward, index) {
        AtSurface::Refracted(direction) => Passage::Left { point: exit, direction },
        AtSurface::TotalReflection => Passage::TotalReflection,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_the_sphere_twice_or_never() {
        let (near, far) = ray_sphere(DVec3::new(0.3, 0.0, 5.0), DVec3::NEG_Z, DVec3::ZERO, 0.5).expect("it does");
        assert!((near - 4.6).abs() < 1e-12 && (far - 5.4).abs() < 1e-12);
        assert_eq!(ray_sphere(DVec3::new(0.6, 0.0, 5.0), DVec3::NEG_Z, DVec3::ZERO, 0.5), None);
    }

    /// sin_t = eta sin_i, in one plane, unit length.
    #[test]
    fn snells_law_holds_and_knows_its_limit() {
        for degrees in [0.0_f64, 20.0, 60.0, 89.0] {
            let (sin_i, cos_i) = degrees.to_radians().sin_cos();
            let AtSurface::Refracted(t) = snell(DVec3::new(sin_i, 0.0, -cos_i), DVec3::Z, 1.0 / 1.33) else {
                panic!("nothing is reflected totally on the way in")
            };
            assert!((t.x - sin_i / 1.33).abs() < 1e-12 && (t.length() - 1.0).abs() < 1e-12 && t.z < 0.0);
        }
        let critical = (1.0 / 1.33_f64).asin();
        let at = |angle: f64| snell(DVec3::new(angle.sin(), 0.0, -angle.cos()), DVec3::Z, 1.33);
        assert_ne!(at(critical - 1e-6), AtSurface::TotalReflection);
        assert_eq!(at(critical + 1e-6), AtSurface::TotalReflection);
    }

    /// A ray turns by 2 (i - t) on its way through, and one through the middle not at all.
    #[test]
    fn a_ray_through_the_sphere_turns_twice_by_the_same_angle() {
        for offset in [0.0_f64, 0.2, 0.49] {
            let point = DVec3::new(offset, 0.0, (0.25 - offset * offset).sqrt());
            let Passage::Left { point: exit, direction } = pass_sphere(point, DVec3::NEG_Z, DVec3::ZERO, 0.5, 1.33)
            else {
                panic!("a ray from outside always leaves")
            };
            let turn = 2.0 * ((offset / 0.5).asin() - (offset / 0.5 / 1.33).asin());
            assert!((direction.angle_between(DVec3::NEG_Z) - turn).abs() < 1e-7 && direction.x <= 0.0);
            assert!((exit.length() - 0.5).abs() < 1e-12);
        }
    }
}
