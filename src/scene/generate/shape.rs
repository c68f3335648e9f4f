//! The bodies that a cloud can fill: their volume, their middle column, and random points in them.

use std::f64::consts::PI;

use rand::Rng;

use super::error::GenerateError;
use super::random::unit_f64;

/// What the cloud fills, centred on the origin; +Y is up, as in glTF.
///
/// A new shape needs a variant, a name in [`CloudShape::NAMES`] and an arm in each method of this file.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CloudShape {
    /// A ball.
    Ball { diameter_m: f64 },
    /// An upright box; sizes along x, y (up) and z.
    Box { size_m: [f64; 3] },
    /// A layer, wide and flat; sizes along x, y (its thickness) and z.
    Slab { size_m: [f64; 3] },
    /// A cumulus: towers of billows on a flat base, in a box of these sizes along x, y (up) and z; its water grows with height.
    Cumulus { size_m: [f64; 3] },
    /// A puff of steam with a tail below it, in a box of these sizes along x, y (up) and z; thick in the middle.
    Puff { size_m: [f64; 3] },
    /// One single particle at the origin, drawn with this diameter.
    Droplet { diameter_m: f64 },
}

/// Height of a cumulus over its width where only one length is given: between a humilis and a mediocris (WMO 2017,
/// International Cloud Atlas).
const CUMULUS_HEIGHT: f64 = 0.7;

/// Thickness of a slab for which only one length is given, relative to that length.
const SLAB_THICKNESS: f64 = 0.125;

/// Lengths outside cannot be told from typing errors, and their cubes leave the range of f32.
const LENGTHS_M: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// Billows are as wide as the shortest side lets them be: in a box more slender than this they are too many to grow in
/// seconds (their number rises with the ratio, the time with its square), and in a flatter one they leave most of it empty.
const MOST_GROWN_RATIO: f64 = 10.0;

impl CloudShape {
    /// Names, as in `--shape`.
    pub const NAMES: [&'static str; 6] = ["ball", "box", "slab", "cumulus", "puff", "droplet"];

    /// The shape of a name and its lengths in metres: one (a diameter, the edge of a cube, the width of a slab, which is
    /// then an eighth as thick, of a cumulus, then 0.7 as high, or of a puff), or three along x, y (up) and z for all but
    /// ball and droplet.
    ///
    /// # Errors
    /// When the name is unknown, or the lengths are too few, too many or out of range; when a cumulus or a puff is more than ten
    /// times as long as its shortest side.
    ///
    /// ```
    /// use mie_cloud::scene::generate::CloudShape;
    /// assert_eq!(CloudShape::new("slab", &[8.0])?, CloudShape::Slab { size_m: [8.0, 1.0, 8.0] });
    /// # Ok::<(), mie_cloud::scene::generate::GenerateError>(())
    /// ```
    pub fn new(name: &str, lengths_m: &[f64]) -> Result<Self, GenerateError> {
        let found = lengths_m.len();
        let shape = match (name, lengths_m) {
            ("ball", &[diameter_m]) => Self::Ball { diameter_m },
            ("ball", _) => return Err(GenerateError::SizeCount { shape: "ball", expected: "one length", found }),
            ("box", &[a]) => Self::Box { size_m: [a; 3] },
            ("box", &[x, y, z]) => Self::Box { size_m: [x, y, z] },
            ("box", _) => {
                return Err(GenerateError::SizeCount { shape: "box", expected: "one or three lengths", found });
            }
            ("slab", &[a]) => Self::Slab { size_m: [a, a * SLAB_THICKNESS, a] },
            ("slab", &[x, y, z]) => Self::Slab { size_m: [x, y, z] },
            ("slab", _) => {
                return Err(GenerateError::SizeCount { shape: "slab", expected: "one or three lengths", found });
            }
            ("cumulus", &[a]) => Self::Cumulus { size_m: [a, a * CUMULUS_HEIGHT, a] },
            ("cumulus", &[x, y, z]) => Self::Cumulus { size_m: [x, y, z] },
            ("puff", &[a]) => Self::Puff { size_m: [a; 3] },
            ("puff", &[x, y, z]) => Self::Puff { size_m: [x, y, z] },
            ("cumulus" | "puff", _) => {
                let shape = if name == "puff" { "puff" } else { "cumulus" };
                return Err(GenerateError::SizeCount { shape, expected: "one or three lengths", found });
            }
            ("droplet", &[diameter_m]) => Self::Droplet { diameter_m },
            ("droplet", _) => return Err(GenerateError::SizeCount { shape: "droplet", expected: "one length", found }),
            _ => return Err(GenerateError::Shape { name: name.into(), known: Self::NAMES.join(", ") }),
        };
        shape.check()?;
        Ok(shape)
    }

    /// The name, as in `--shape`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ball { .. } => "ball",
            Self::Box { .. } => "box",
            Self::Slab { .. } => "slab",
            Self::Cumulus { .. } => "cumulus",
            Self::Puff { .. } => "puff",
            Self::Droplet { .. } => "droplet",
        }
    }

    /// Whether the seed decides on the shape inside its box.
    pub fn is_grown(&self) -> bool {
        matches!(self, Self::Cumulus { .. } | Self::Puff { .. })
    }

    /// Full sizes along x, y and z, m.
    pub fn size_m(&self) -> [f64; 3] {
        match *self {
            Self::Ball { diameter_m } | Self::Droplet { diameter_m } => [diameter_m; 3],
            Self::Box { size_m } | Self::Slab { size_m } | Self::Cumulus { size_m } | Self::Puff { size_m } => size_m,
        }
    }

    /// The lengths that `--size` takes, m.
    pub fn lengths_m(&self) -> Vec<f64> {
        match *self {
            Self::Ball { diameter_m } | Self::Droplet { diameter_m } => vec![diameter_m],
            Self::Box { size_m } | Self::Slab { size_m } | Self::Cumulus { size_m } | Self::Puff { size_m } => {
                size_m.to_vec()
            }
        }
    }

    /// The longest of the three sizes, m.
    pub fn longest_m(&self) -> f64 {
        self.size_m().into_iter().fold(0.0, f64::max)
    }

    /// The shortest of the three sizes, m: the way along which the optical depth of the cloud is counted.
    pub fn shortest_m(&self) -> f64 {
        self.size_m().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Which side is the shortest: 0, 1, 2 for x, y, z; y where others are equal to it.
    pub(super) fn shortest_axis(&self) -> usize {
        [1, 2, 0].into_iter().min_by(|&a, &b| self.size_m()[a].total_cmp(&self.size_m()[b])).unwrap_or(1)
    }

    /// Volume, m^3; of the box around the cloud where the seed decides on it.
    pub(super) fn volume_m3(&self) -> f64 {
        let [x, y, z] = self.size_m();
        match self {
            Self::Ball { .. } | Self::Droplet { .. } => PI / 6.0 * x * y * z,
            _ => x * y * z,
        }
    }

    /// Area of the shadow along the shortest side, m^2; of the box around the cloud where the seed decides on it.
    pub(super) fn shadow_m2(&self) -> f64 {
        match *self {
            Self::Ball { diameter_m } | Self::Droplet { diameter_m } => PI / 4.0 * diameter_m * diameter_m,
            _ => self.volume_m3() / self.shortest_m(),
        }
    }

    /// Integral along the line through the centre, parallel to the shortest side, of the density (1/m^3, its integral over
    /// space 1) of balls of radius `ball_m` whose centres are spread evenly over the shape, 1/m^2. `ball_m` is 0 for
    /// droplets, and at most a quarter of the shortest side for parcels. Not for shapes that the seed decides on.
    pub(super) fn middle_column_per_m2(&self, ball_m: f64) -> f64 {
        match *self {
            Self::Ball { diameter_m } => middle_of_soft_ball(0.5 * diameter_m, ball_m),
            _ => 1.0 / self.shadow_m2(),
        }
    }

    /// A random point, evenly distributed over the shape (the box around it where the seed decides on it), in units of its half sizes: each coordinate in -1 ..= 1.
    pub(super) fn sample_unit_point(&self, rng: &mut impl Rng) -> [f64; 3] {
        match self {
            // Rejection is exact, needs no functions that differ between machines, and accepts 52 %.
            Self::Ball { .. } => loop {
                let p = cube_point(rng);
                if p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= 1.0 {
                    return p;
                }
            },
            Self::Droplet { .. } => [0.0; 3],
            _ => cube_point(rng),
        }
    }

    pub(super) fn check(&self) -> Result<(), GenerateError> {
        if let Some(size_m) = self.size_m().into_iter().find(|size| !LENGTHS_M.contains(size)) {
            return Err(GenerateError::Size { size_m });
        }
        let ratio = self.longest_m() / self.shortest_m();
        // One picometre in a metre is rounding.
        if self.is_grown() && ratio > MOST_GROWN_RATIO * (1.0 + 1e-12) {
            return Err(GenerateError::Aspect { shape: self.name(), ratio, most: MOST_GROWN_RATIO });
        }
        Ok(())
    }
}

fn cube_point(rng: &mut impl Rng) -> [f64; 3] {
    [0; 3].map(|_| 2.0 * unit_f64(rng) - 1.0)
}

/// The middle column of an even ball of radius `a` smeared by an even ball of radius `b` < `a`: the product of both chords,
/// integrated over the plane across the line, with rho = b sin phi so that the integrand is smooth.
fn middle_of_soft_ball(a: f64, b: f64) -> f64 {
    const N_STEPS: usize = 256; // Simpson; 1e-11 relative at b = a / 2.
    let step = 0.5 * PI / N_STEPS as f64;
    let share = b / a;
    let sum: f64 = (0..=N_STEPS)
        .map(|i| {
            let weight = if i == 0 || i == N_STEPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            let (sin, cos) = (i as f64 * step).sin_cos();
            weight * sin * cos * cos * (1.0 - (share * sin).powi(2)).max(0.0).sqrt()
        })
        .sum();
    // The chords' mean over the smearing ball, times 2 a / V_a; the integral is 1/3 for b = 0.
    3.0 * (sum * step / 3.0) * 1.5 / (PI * a * a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_column_of_a_ball_is_its_diameter_over_its_volume() {
        let ball = CloudShape::Ball { diameter_m: 3.0 };
        assert!((ball.middle_column_per_m2(0.0) - 3.0 / ball.volume_m3()).abs() < 1e-9);
    }

    #[test]
    fn the_middle_column_of_a_soft_ball_is_what_random_points_find() {
        // A line crosses the ball of radius b around a centre at distance rho from it over 2 sqrt(b^2 - rho^2).
        let (a, b) = (1.0, 0.5);
        let shape = CloudShape::Ball { diameter_m: 2.0 * a };
        let mut rng = super::super::random::stream(3, super::super::random::Purpose::Positions);
        let n = 400_000;
        let chords = (0..n).map(|_| {
            let [x, _, z] = shape.sample_unit_point(&mut rng);
            2.0 * (b * b - x * x - z * z).max(0.0).sqrt()
        });
        let mean = chords.sum::<f64>() / f64::from(n) / (4.0 / 3.0 * PI * b * b * b);
        let expected = shape.middle_column_per_m2(b);
        // Three standard errors; one chord has a relative deviation of 1.3.
        assert!((mean / expected - 1.0).abs() < 3.0 * 1.3 / f64::from(n).sqrt(), "{mean} against {expected}");
    }

    #[test]
    fn lengths_are_counted_and_checked() {
        assert_eq!(CloudShape::new("box", &[1.0, 2.0, 3.0]), Ok(CloudShape::Box { size_m: [1.0, 2.0, 3.0] }));
        assert!(matches!(CloudShape::new("ball", &[1.0, 2.0, 3.0]), Err(GenerateError::SizeCount { found: 3, .. })));
        assert!(matches!(CloudShape::new("slab", &[1.0, 2.0]), Err(GenerateError::SizeCount { found: 2, .. })));
        assert!(matches!(CloudShape::new("box", &[0.0]), Err(GenerateError::Size { .. })));
        assert!(matches!(CloudShape::new("ball", &[f64::NAN]), Err(GenerateError::Size { .. })));
        assert!(matches!(CloudShape::new("cube", &[1.0]), Err(GenerateError::Shape { .. })));
        for (name, size) in
            [("cumulus", [1e3, 1e-3, 1e3]), ("cumulus", [10.0, 110.0, 10.0]), ("puff", [1.0, 11.0, 1.0])]
        {
            assert!(matches!(CloudShape::new(name, &size), Err(GenerateError::Aspect { .. })), "{name} {size:?}");
            assert!(CloudShape::new("slab", &size).is_ok(), "{size:?}");
        }
        assert!(CloudShape::new("puff", &[0.3, 3.0, 3.0]).is_ok());
        for name in CloudShape::NAMES {
            assert_eq!(CloudShape::new(name, &[2.0]).map(|shape| shape.name()), Ok(name));
        }
    }
}
