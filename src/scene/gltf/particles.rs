//! The list of particles as it grows: radii checked against quantisers, counts turned into droplets, parcels and balls.

use glam::DVec3;

use super::accessors::Accessor;
use super::attributes::ParticleAttributes;
use super::classes::Classes;
use super::unrendered::{Kind, Unrendered};
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::fog::ball_volume_m3;
use crate::scene::marks::{MarkKind, Marks};
use crate::scene::model::{
    FogBalls, FogDensity, MOST_DROPLETS, Particle, ParticleKind, SMALLEST_RADIUS_M, WORLD_LIMIT_M,
};

/// Raindrops above this radius break up in air (Pruppacher & Klett 1997, section 10.3.5), m.
const LARGEST_DROP_M: f64 = 5e-3;

/// Particles and balls of fog, in the order in which they were found.
#[derive(Default)]
pub struct Particles {
    pub list: Vec<Particle>,
    pub fog_balls: Vec<FogBalls>,
}

/// What the particles of one primitive or node share.
pub struct Group {
    element: String,
    class: u16,
    fog: Option<FogDensity>,
    kind: GroupKind,
    droplet_radius_m: Option<f64>,
    droplet_count: Option<f64>,
    start: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum GroupKind {
    Droplets,
    Fog,
}

impl Group {
    /// A group that begins at particle `start`.
    pub fn new(element: &str, class: u16, marks: &Marks, start: usize) -> Self {
        let kind = if marks.kind == Some(MarkKind::Fog) { GroupKind::Fog } else { GroupKind::Droplets };
        Self {
            element: element.into(),
            class,
            fog: marks.density,
            kind,
            droplet_radius_m: marks.droplet_radius_um.map(|um| um * 1e-6),
            droplet_count: marks.droplet_count,
            start,
        }
    }
}

/// Where the numbers of a particle come from.
#[derive(Clone, Copy)]
pub struct Source<'s> {
    pub carried: &'s ParticleAttributes<'s>,
    /// Metres per unit of the drawn radius.
    pub scale: f64,
    /// Drawn radius where none is carried, m.
    pub default_radius_m: Option<f64>,
    pub group: &'s Group,
}

impl ParticleAttributes<'_> {
    /// Checks all carried radii before any is used.
    ///
    /// # Errors
    /// When most are zero, or one is negative or not finite.
    pub fn check_radii(&self) -> SceneResult<()> {
        [&self.radius, &self.droplet_radius_um].into_iter().flatten().try_for_each(check_radii)
    }
}

impl Source<'_> {
    fn drawn_radius_m(&self, i: u64) -> SceneResult<f64> {
        match &self.carried.radius {
            Some(radii) => Ok(radii.scalar(i)? * self.scale),
            None => Ok(self.default_radius_m.unwrap_or(0.0)),
        }
    }

    fn count(&self, i: u64) -> SceneResult<Option<f64>> {
        match &self.carried.droplet_count {
            Some(counts) => counts.scalar(i).map(Some),
            None => Ok(self.group.droplet_count),
        }
    }
}

/// All-zero or mostly-zero radii are the work of a quantiser; negative ones of something worse.
fn check_radii(radii: &Accessor) -> SceneResult<()> {
    let mut zeros = 0;
    for i in 0..radii.count() {
        let radius = radii.scalar(i)?;
        if radius < 0.0 {
            let what = format!("radius {i}");
            return Err(SceneError::at(
                radii.element(),
                SceneFault::Range { what, value: radius, expected: "above 0" },
            ));
        }
        zeros += u64::from(radius == 0.0);
    }
    if 2 * zeros > radii.count() {
        return Err(SceneError::at(radii.element(), SceneFault::ZeroRadii { zeros, count: radii.count() }));
    }
    Ok(())
}

impl Particles {
    /// What the budget counts for each.
    pub const BYTES_EACH: usize = size_of::<Particle>();

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Makes room for `count` more, which the budget has allowed.
    ///
    /// # Errors
    /// When there is no such memory.
    pub fn reserve(&mut self, count: u64, element: &str) -> SceneResult<()> {
        let room = usize::try_from(count).ok().and_then(|count| self.list.try_reserve(count).ok());
        room.ok_or_else(|| {
            let bytes = count.saturating_mul(Self::BYTES_EACH as u64);
            let (what, remedy) = (format!("{count} particles"), "render on a machine with more memory");
            SceneError::at(element, SceneFault::TooLarge { what, bytes, limit: 0, remedy })
        })
    }

    /// Adds particle `i` of a source; those without size or content are left out and noted.
    ///
    /// # Errors
    /// When a number is out of range.
    pub fn push(
        &mut self,
        center_m: DVec3,
        i: u64,
        source: &Source,
        classes: &mut Classes,
        notes: &mut Unrendered,
    ) -> SceneResult<()> {
        let group = source.group;
        let radius_m = source.drawn_radius_m(i)?;
        let own_um = source.carried.droplet_radius_um.as_ref().map(|radii| radii.scalar(i)).transpose()?;
        let own_m = own_um.map(|um| um * 1e-6).or(group.droplet_radius_m);
        if radius_m == 0.0 || own_m == Some(0.0) {
            notes.note(Kind::ZeroRadius, 1, || group.element.clone());
            return Ok(());
        }
        check_radius(radius_m, "its drawn radius in the world (m)", i, group)?;
        own_m.map_or(Ok(()), |own| check_radius(own, "its own radius (m)", i, group))?;
        let count = source.count(i)?;
        if count == Some(0.0) {
            notes.note(Kind::ZeroCount, 1, || group.element.clone());
            return Ok(());
        }
        let class = match &source.carried.material {
            Some(materials) => classes.with_material(group.class, materials.scalar(i)?, i, materials.element())?,
            None => group.class,
        };
        let (kind, count) = content(group, count, radius_m, i)?;
        let own_m = match kind {
            ParticleKind::Droplet => own_m.unwrap_or(radius_m),
            ParticleKind::Parcel => own_m.unwrap_or(0.0),
        };
        note_sizes(kind, radius_m, own_m, group, notes);
        let (radius_m, droplet_radius_m) = (radius_m as f32, own_m as f32);
        self.list.push(Particle { center_m, radius_m, droplet_radius_m, count: count as f32, class, kind });
        Ok(())
    }

    /// Ends a group: its balls of fog are noted for filling.
    pub fn finish(&mut self, group: Group) {
        let particles = group.start..self.list.len();
        if let (Some(density), GroupKind::Fog, false) = (group.fog, group.kind, particles.is_empty())
            && !matches!(density, FogDensity::NumberPerM3(_))
        {
            self.fog_balls.push(FogBalls { particles, density });
        }
    }
}

fn check_radius(radius_m: f64, what: &str, i: u64, group: &Group) -> SceneResult<()> {
    if (SMALLEST_RADIUS_M..=WORLD_LIMIT_M).contains(&radius_m) {
        return Ok(());
    }
    let what = format!("particle {i}: {what}");
    let expected = "1e-10 m (an atom) to 1e12 m; check units and scales";
    Err(SceneError::at(&group.element, SceneFault::Range { what, value: radius_m, expected }))
}

/// Droplet or parcel, and how many droplets.
fn content(group: &Group, count: Option<f64>, radius_m: f64, i: u64) -> SceneResult<(ParticleKind, f64)> {
    let range = |what: &str, value: f64, expected| {
        let what = format!("particle {i}: {what}");
        Err(SceneError::at(&group.element, SceneFault::Range { what, value, expected }))
    };
    match (group.kind, group.fog, count) {
        (GroupKind::Fog, Some(_), Some(_)) => {
            let problem = "balls of fog have both a density and a droplet count".into();
            Err(SceneError::at(&group.element, SceneFault::Mark { problem, remedy: "give one of them" }))
        }
        (GroupKind::Fog, Some(FogDensity::NumberPerM3(number)), None) => {
            let count = number * ball_volume_m3(radius_m);
            if count > f64::from(f32::MAX) {
                return range("its number of droplets", count, "at most 3e38");
            }
            Ok((ParticleKind::Parcel, count))
        }
        // Filled later, by `Scene::fill_fog`.
        (GroupKind::Fog, Some(_), None) => Ok((ParticleKind::Parcel, 0.0)),
        (_, _, None) => Ok((ParticleKind::Droplet, 1.0)),
        (_, _, Some(count)) if !(1.0..=MOST_DROPLETS).contains(&count) => {
            range("_DROPLET_COUNT", count, "0, or 1 to 1e36")
        }
        (GroupKind::Fog, ..) => Ok((ParticleKind::Parcel, count.unwrap_or(1.0))),
        (_, _, Some(1.0)) => Ok((ParticleKind::Droplet, 1.0)),
        (_, _, Some(count)) => Ok((ParticleKind::Parcel, count)),
    }
}

fn note_sizes(kind: ParticleKind, radius_m: f64, own_m: f64, group: &Group, notes: &mut Unrendered) {
    if own_m > LARGEST_DROP_M {
        notes.note(Kind::LargeDrop, 1, || group.element.clone());
    }
    // 1e-6: single precision on both sides.
    if kind == ParticleKind::Droplet && radius_m < own_m * (1.0 - 1e-6) {
        notes.note(Kind::ShrunkDroplet, 1, || group.element.clone());
    }
}
