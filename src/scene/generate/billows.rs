//! Spheres upon spheres: the skeleton of cumulus and of steam.
//!
//! Clouds that convection drives are heaps of rising bubbles, which carry smaller ones on their upper sides, and those
//! smaller ones again (Bouthors & Neyret 2004, "Modeling clouds shape"; Neyret 1997). Level 0 is laid out by hand: towers
//! on a flat base, or one puff and its tail. Each further level buds from the surface of the one before, where it is free.

use glam::DVec3;
use rand::Rng;

use super::random::unit_f64;

/// A bubble of rising air; lengths in units of the cloud's longest half side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Billow {
    pub center: DVec3,
    pub radius: f64,
}

impl Billow {
    /// How far a point lies below the surface; negative outside.
    pub fn depth(&self, point: DVec3) -> f64 {
        self.radius - (point - self.center).length()
    }
}

/// How buds grow on their parents.
struct Budding {
    /// Directions tried on each parent.
    trials: usize,
    /// Radius over the parent's, smallest and largest.
    sizes: [f64; 2],
    /// Distance of the centre from the parent's, over the parent's radius.
    lift: f64,
    /// The steepest downward direction that still buds, as the direction's y.
    lowest: f64,
}

/// A cumulus in a box of the given half sizes: towers that are highest in the middle, on a base at y = -half.y.
pub(super) fn cumulus(half: DVec3, rng: &mut impl Rng) -> Vec<Billow> {
    let mut levels = vec![towers(half, rng)];
    for budding in [
        Budding { trials: 14, sizes: [0.36, 0.62], lift: 0.82, lowest: -0.35 },
        Budding { trials: 16, sizes: [0.30, 0.52], lift: 0.88, lowest: -0.35 },
        Budding { trials: 14, sizes: [0.28, 0.48], lift: 0.92, lowest: -0.25 },
    ] {
        bud(&mut levels, &budding, -half.y, rng);
    }
    levels.into_iter().flatten().collect()
}

/// A puff of steam: one large bubble among others, a tail of smaller ones below it.
pub(super) fn puff(half: DVec3, rng: &mut impl Rng) -> Vec<Billow> {
    let mut levels = vec![bubbles(half, rng)];
    for budding in [
        Budding { trials: 16, sizes: [0.35, 0.65], lift: 0.75, lowest: -1.0 },
        Budding { trials: 14, sizes: [0.30, 0.55], lift: 0.85, lowest: -1.0 },
    ] {
        bud(&mut levels, &budding, f64::NEG_INFINITY, rng);
    }
    levels.into_iter().flatten().collect()
}

/// Towers of the first cumulus level.
const N_TOWERS: usize = 9;

/// Bubbles of the bank that joins the towers at the base.
const N_BANK: usize = 14;

fn towers(half: DVec3, rng: &mut impl Rng) -> Vec<Billow> {
    let narrow = half.x.min(half.z).min(1.6 * half.y);
    let mut billows = Vec::new();
    for tower in 0..N_TOWERS {
        // The first stands in the middle, so that the middle of the cloud is never empty.
        let place = if tower == 0 { 0.2 * in_disc(rng) } else { in_disc(rng) };
        let off = place.length();
        let height = 2.0 * half.y * (1.0 - 0.6 * off) * if tower == 0 { 1.0 } else { between(rng, 0.55, 0.95) };
        let width = narrow * between(rng, 0.30, 0.42) * (1.0 - 0.35 * off);
        let foot = DVec3::new(0.72 * half.x * place.x, -half.y, 0.72 * half.z * place.z);
        let lean = 0.25 * in_disc(rng);
        let mut y = 0.35 * width;
        while y < height - 0.5 * width {
            let share = y / height;
            // Towers are slimmer in the middle than at the head.
            let radius = width * (0.85 + 0.3 * (share - 0.4).abs()) * between(rng, 0.85, 1.1);
            let sway = 0.3 * width * in_disc(rng);
            billows.push(Billow { center: foot + lean * y + sway + DVec3::Y * y, radius });
            y += between(rng, 0.55, 0.8) * width;
        }
        let top = (height - width).max(0.3 * width);
        billows.push(Billow { center: foot + lean * top + DVec3::Y * top, radius: width });
    }
    for _ in 0..N_BANK {
        let place = in_disc(rng);
        let radius = narrow * between(rng, 0.16, 0.30) * (1.15 - 0.5 * place.length());
        let foot = DVec3::new(0.85 * half.x * place.x, -half.y, 0.85 * half.z * place.z);
        billows.push(Billow { center: foot + DVec3::Y * radius * between(rng, 0.2, 0.7), radius });
    }
    // The middle of the box is inside the cloud, whatever grew where.
    let [low, high] = bounds(&billows);
    let middle = DVec3::new(0.5 * (low.x + high.x), 0.25 * narrow - half.y, 0.5 * (low.z + high.z));
    billows.push(Billow { center: middle, radius: 0.35 * narrow });
    billows
}

/// The corners of the box around all billows.
pub(super) fn bounds(billows: &[Billow]) -> [DVec3; 2] {
    let far = DVec3::INFINITY;
    billows.iter().fold([far, -far], |[low, high], billow| {
        [low.min(billow.center - billow.radius), high.max(billow.center + billow.radius)]
    })
}

/// Bubbles around the puff's middle, and in its tail.
const N_BUBBLES: usize = 9;
const N_TAIL: usize = 5;

fn bubbles(half: DVec3, rng: &mut impl Rng) -> Vec<Billow> {
    let narrow = half.min_element();
    let head = DVec3::new(0.0, 0.25 * half.y, 0.0);
    let mut billows = vec![Billow { center: 0.6 * head, radius: 0.5 * narrow }];
    for _ in 0..N_BUBBLES {
        let place = in_ball(rng) * half * DVec3::new(0.62, 0.5, 0.62);
        billows.push(Billow { center: head + place, radius: narrow * between(rng, 0.25, 0.42) });
    }
    for step in 0..N_TAIL {
        let share = (step as f64 + 1.0) / N_TAIL as f64;
        let sway = in_disc(rng) * half * 0.22;
        let radius = narrow * between(rng, 0.9, 1.1) * (0.36 - 0.22 * share);
        billows.push(Billow { center: sway - DVec3::Y * half.y * (0.15 + 0.7 * share), radius });
    }
    billows
}

/// Adds a level: buds on the last one, where no other billow covers them and above the base.
fn bud(levels: &mut Vec<Vec<Billow>>, budding: &Budding, base_y: f64, rng: &mut impl Rng) {
    let mut buds: Vec<Billow> = Vec::new();
    let Some(parents) = levels.last() else { return };
    for parent in parents {
        let first = buds.len();
        for _ in 0..budding.trials {
            let direction = on_sphere(rng);
            let radius = parent.radius * between(rng, budding.sizes[0], budding.sizes[1]);
            let center = parent.center + direction * parent.radius * budding.lift;
            let covered = levels.iter().flatten().any(|other| other.depth(center) > 0.6 * radius);
            let crowded =
                buds[first..].iter().any(|other| (other.center - center).length() < 0.7 * other.radius.max(radius));
            if direction.y >= budding.lowest && center.y > base_y + 0.1 * radius && !covered && !crowded {
                buds.push(Billow { center, radius });
            }
        }
    }
    levels.push(buds);
}

fn between(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * unit_f64(rng)
}

/// By rejection: exact, and without functions that differ between machines.
fn in_ball(rng: &mut impl Rng) -> DVec3 {
    loop {
        let p = DVec3::new(between(rng, -1.0, 1.0), between(rng, -1.0, 1.0), between(rng, -1.0, 1.0));
        if p.length_squared() <= 1.0 && p.length_squared() > 1e-6 {
            return p;
        }
    }
}

fn on_sphere(rng: &mut impl Rng) -> DVec3 {
    in_ball(rng).normalize()
}

/// In the horizontal disc of radius 1.
fn in_disc(rng: &mut impl Rng) -> DVec3 {
    loop {
        let p = DVec3::new(between(rng, -1.0, 1.0), 0.0, between(rng, -1.0, 1.0));
        if p.length_squared() <= 1.0 {
            return p;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::{Purpose, stream};
    use super::*;

    #[test]
    fn every_level_is_smaller_and_there_are_thousands_of_billows() {
        for seed in 0..5 {
            let billows = cumulus(DVec3::new(1.0, 0.7, 1.0), &mut stream(seed, Purpose::Billows));
            let small = billows.iter().filter(|billow| billow.radius < 0.06).count();
            assert!((500..20_000).contains(&billows.len()) && small > billows.len() / 2, "{}: {small}", billows.len());
        }
    }
}
