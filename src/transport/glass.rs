//! Refraction: droplets that can be seen are glass balls for all light but the sun's own.
//!
//! A ball turns a path without ending it. One wavelength, the hero, chooses between reflection and refraction; where the
//! index depends on the wavelength, the hero alone goes on once it has been refracted (theory (72), (73)). Legend:
//! weight_l, a path's integrand over the mean density of all heroes; density_h, the heroes' densities over their mean.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::ball::{Ball, Branch, Strike, SurfaceEvent};
use super::media::Absorption;
use super::random::{PathRandom, Purpose};
use crate::accel::{Accel, Crossing, LocalRay, Placed};
use crate::optics::DropletClass;
use crate::optics::bins::{BinPlan, SizeBin};
use crate::optics::material::MaterialError;
use crate::optics::tables::{BinTables, OpticalTables};

/// Most meetings with a surface from inside before a path is given up: total reflection goes on for ever in a ball, and
/// of an index of 20 at normal incidence, the largest there is, 0.82^256 = 1e-22 is left.
const MOST_BOUNCES: u32 = 256;

/// The glass balls of a scene.
pub struct Glass {
    /// Their load is the ratio of own to drawn radius: a magnified droplet absorbs as it does, not as it is drawn.
    balls: Accel,
    /// One per size bin.
    materials: Vec<BallMaterial>,
}

/// What balls are made of, by wavelength.
struct BallMaterial {
    index: Vec<Complex64>,
    /// 4 pi k / lambda, 1/m.
    absorption_per_m: Vec<f64>,
    /// Share of what meets the ball that is not absorbed; 1 but for droplets of a given albedo.
    kept: Vec<f64>,
    /// Whether wavelengths part.
    is_dispersive: bool,
}

/// The next surface of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ahead {
    /// Distance to it, m.
    pub t_m: f64,
    /// Whether the ray starts inside the ball.
    pub is_inside: bool,
    /// The ball.
    pub ball: Ball,
    /// Its size bin.
    pub bin: usize,
    /// Its number among the balls.
    pub id: u32,
    /// Own over drawn radius.
    scale: f64,
}

/// Which of the ways past a ball are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ways {
    /// All of them.
    All,
    /// In and out at once, without a choice: nearly all of the light.
    Straight,
    /// All but that one.
    Others,
}

/// What a path carries through surfaces.
pub(super) struct Carried<'a> {
    pub weight: &'a mut [f64],
    pub density: &'a mut [f64],
    /// Wavelength that chooses.
    pub hero: usize,
    pub random: &'a PathRandom,
    /// Surfaces met so far; numbers the choices.
    pub surfaces: &'a mut u32,
}

impl Glass {
    /// The same, walked as on a processor without vector instructions; for tests.
    pub(super) fn without_simd(self) -> Self {
        Self { balls: self.balls.without_simd(), ..self }
    }

    /// The glass balls of a scene, in a tree beside that of all its bodies; `None` where there are none. Tables of a single
    /// wavelength serve all `n_wavelengths` (no dispersion).
    ///
    /// # Errors
    /// When a material has no index at a wavelength.
    pub fn new(
        beside: &Accel,
        balls: Vec<Placed>,
        bins: &BinPlan,
        classes: &[DropletClass],
        tables: &OpticalTables,
        absorption: Absorption,
    ) -> Result<Option<Self>, MaterialError> {
        if balls.is_empty() {
            return Ok(None);
        }
        let material = |(bin, of_bin): (&SizeBin, &BinTables)| {
            BallMaterial::new(&classes[usize::from(bin.class)], &tables.wavelengths_m, of_bin, absorption)
        };
        let materials = bins.bins.iter().zip(&tables.bins).map(material).collect::<Result<_, _>>()?;
        Ok(Some(Self { balls: beside.build_beside(balls), materials }))
    }

    /// Number of balls, coincident ones counted once.
    pub fn len(&self) -> usize {
        self.balls.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.balls.is_empty()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.balls.geometry_bytes() + self.balls.tree_bytes()
    }

    /// The next surface of a ray; `left` is a ball that it has just left. A ball that holds the ray's origin comes first,
    /// whatever else is in it.
    pub(super) fn ahead(&self, ray: &LocalRay, left: Option<u32>) -> Option<Ahead> {
        let mut around: Option<Ahead> = None;
        let hit = self.balls.closest(ray, 0.0, None, |body, crossing| {
            let Crossing::Chord(enter_m, leave_m) = crossing else { return None };
            if Some(body.id) == left || leave_m <= 0.0 {
                return None;
            }
            if enter_m > 0.0 {
                return Some(enter_m);
            }
            if around.is_none_or(|a| (leave_m, body.id) < (a.t_m, a.id)) {
                let ball = Ball { center: body.center, radius_m: f64::from(body.radius_m) };
                let (bin, scale) = (body.bin(), f64::from(body.load));
                around = Some(Ahead { t_m: leave_m, is_inside: true, ball, bin, id: body.id, scale });
            }
            None
        });
        around.or_else(|| {
            let hit = hit?;
            let body = self.balls.body(hit.index);
            let ball = Ball { center: body.center, radius_m: f64::from(body.radius_m) };
            let (bin, scale) = (body.bin(), f64::from(body.load));
            Some(Ahead { t_m: hit.t_m, is_inside: false, ball, bin, id: hit.id, scale })
        })
    }

    /// Takes a path past the ball ahead, to where it goes on outside. `None` where nothing does.
    pub(super) fn pass(&self, ahead: &Ahead, ray: &LocalRay, ways: Ways, carried: &mut Carried) -> Option<LocalRay> {
        let material = &self.materials[ahead.bin];
        let mut ray = *ray;
        let mut is_inside = ahead.is_inside;
        if !is_inside {
            carried
                .weight
                .iter_mut()
                .enumerate()
                .for_each(|(w, weight)| *weight *= BallMaterial::at(&material.kept, w));
        }
        for bounce in 0..MOST_BOUNCES {
            let strike_for = |m: Complex64| match is_inside {
                true => ahead.ball.strike_inside(&ray, m),
                false => ahead.ball.strike_outside(&ray, ahead.t_m, m),
            };
            let strike = strike_for(BallMaterial::at(&material.index, carried.hero));
            if is_inside {
                material.absorb(strike.way_m * ahead.scale, carried.weight);
            }
            let chances = match (ways, bounce) {
                (Ways::Straight, _) => Chances::Through,
                (Ways::Others, 0) => Chances::NotStraight,
                (Ways::Others, 1) => Chances::Back,
                _ => Chances::Fresnel,
            };
            let branch = material.choose(&strike, strike_for, chances, carried)?;
            let event;
            (event, ray) = strike.turn(branch);
            if !balance(carried.weight, carried.density) {
                return None;
            }
            match event {
                SurfaceEvent::Reflected | SurfaceEvent::Left => return Some(ray),
                SurfaceEvent::Entered | SurfaceEvent::ReflectedInside | SurfaceEvent::TotallyReflected => {}
            }
            is_inside = true;
        }
        None
    }
}

impl BallMaterial {
    /// A given albedo takes the place of the material's absorption: C_abs = (1 - albedo) C_ext, at most all.
    fn new(
        class: &DropletClass,
        wavelengths_m: &[f64],
        of_bin: &BinTables,
        absorption: Absorption,
    ) -> Result<Self, MaterialError> {
        let mut index = wavelengths_m.iter().map(|l| class.material.index(*l)).collect::<Result<Vec<_>, _>>()?;
        let given = class.albedo.filter(|_| absorption == Absorption::Simulated);
        if absorption == Absorption::LeftOut || given.is_some() {
            index.iter_mut().for_each(|m| m.im = 0.0);
        }
        // The table's own albedo: where peaks are cut it goes with the lower extinction, so that as much is absorbed (theory (96)).
        let kept = of_bin.optics.iter().map(|optics| match given {
            Some(_) => (1.0 - (1.0 - optics.albedo) * optics.q_ext).max(0.0),
            None => 1.0,
        });
        let kept = kept.collect();
        let absorption_per_m = index.iter().zip(wavelengths_m).map(|(m, l_m)| 4.0 * PI * m.im / l_m).collect();
        let is_dispersive = index.iter().any(|m| m.re != index[0].re);
        Ok(Self { index, absorption_per_m, kept, is_dispersive })
    }

    /// Values of the wavelength with this number; a single one serves all.
    #[inline]
    fn at<T: Copy>(values: &[T], w: usize) -> T {
        values[w.min(values.len() - 1)]
    }

    /// What the material takes on a way through it.
    fn absorb(&self, way_m: f64, weight: &mut [f64]) {
        for (w, weight) in weight.iter_mut().enumerate() {
            *weight *= (-Self::at(&self.absorption_per_m, w) * way_m).exp();
        }
    }

    /// Chooses the way by the hero's reflectance, and weighs all wavelengths by theirs. `None` where that way is closed.
    fn choose(
        &self,
        strike: &Strike,
        strike_for: impl Fn(Complex64) -> Strike,
        chances: Chances,
        carried: &mut Carried,
    ) -> Option<Branch> {
        let u = carried.random.uniform(Purpose::Surface, *carried.surfaces);
        *carried.surfaces += 1;
        let branch = match strike.refracted {
            Some(_) if u >= chances.of_reflection(strike.reflectance) => Branch::Refraction,
            None if chances == Chances::Through => return None,
            _ => Branch::Reflection,
        };
        let alone = self.is_dispersive && branch == Branch::Refraction;
        for w in 0..carried.weight.len() {
            if alone && w != carried.hero {
                (carried.weight[w], carried.density[w]) = (0.0, 0.0);
            }
            if carried.weight[w] == 0.0 && carried.density[w] == 0.0 {
                continue;
            }
            let other = strike_for(Self::at(&self.index, w));
            let (share, chance) = match (branch, other.refracted) {
                (Branch::Reflection, Some(_)) => (other.reflectance, chances.of_reflection(other.reflectance)),
                (Branch::Refraction, Some(_)) => {
                    (1.0 - other.reflectance, 1.0 - chances.of_reflection(other.reflectance))
                }
                // What is not absorbed is reflected, without a choice.
                (_, None) => (other.reflectance, 1.0),
            };
            carried.weight[w] *= share;
            carried.density[w] *= chance;
        }
        Some(branch)
    }
}

/// How reflection and refraction are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chances {
    /// As the light divides.
    Fresnel,
    /// Refraction.
    Through,
    /// Reflection.
    Back,
    /// As the light divides that does not pass both surfaces of a ball straight through: R outside and T R inside.
    NotStraight,
}

impl Chances {
    #[inline]
    fn of_reflection(self, reflectance: f64) -> f64 {
        match self {
            Self::Fresnel => reflectance,
            Self::Through => 0.0,
            Self::Back => 1.0,
            Self::NotStraight => 1.0 / (2.0 - reflectance),
        }
    }
}

/// Divides weights and densities by the mean density; `false` where no hero could have drawn the path.
#[inline]
pub(super) fn balance(weight: &mut [f64], density: &mut [f64]) -> bool {
    let mean = density.iter().sum::<f64>() / density.len() as f64;
    if mean.is_nan() || mean <= 0.0 {
        return false;
    }
    let inverse = mean.recip();
    weight.iter_mut().for_each(|weight| *weight *= inverse);
    density.iter_mut().for_each(|density| *density *= inverse);
    true
}
