//! Where along a ray a given optical depth is reached: the place of a collision, from everything that the ray meets.

use crate::accel::{Body, BodyKind, Crossing};

use super::media::Media;

/// Optical depth that a body puts on a stretch of the ray: spread evenly, or at one point where it is a droplet's disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub start: f64,
    pub end: f64,
    pub depth: f64,
    /// Place of the body among the crossings.
    pub index: u32,
}

/// Where a collision is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// In fog, at this distance, m.
    Fog(f64),
    /// On the disc of a droplet, by its place among the crossings.
    Disc(u32),
}

impl Stretch {
    /// What a body puts on the ray at one wavelength; `None` where the ray starts behind it.
    pub fn of(media: &Media, wavelength: usize, index: usize, (body, crossing): &(Body, Crossing)) -> Option<Self> {
        let load = f64::from(body.load);
        let (start, end) = (crossing.start().max(0.0), crossing.end());
        let depth = match body.kind() {
            BodyKind::Droplet => load * media.disc_depth(body.bin())[wavelength],
            BodyKind::Ball | BodyKind::Box => load * media.c_ext_m2(body.bin())[wavelength] * (end - start),
        };
        (depth > 0.0).then_some(Self { start, end, depth, index: index as u32 })
    }

    /// Optical depth that lies before `t`; what is exactly at `t` does not.
    #[inline]
    fn before(&self, t: f64) -> f64 {
        if t <= self.start {
            0.0
        } else if t >= self.end {
            self.depth
        } else {
            self.depth * (t - self.start) / (self.end - self.start)
        }
    }

    /// Optical depth per metre; infinite for discs.
    fn slope(&self) -> f64 {
        self.depth / (self.end - self.start)
    }
}

/// Few enough to sort.
const FEW: usize = 12;

/// The place where the optical depth of all stretches together reaches `target`; `None` where it does not.
///
/// Halves the ray again and again, keeping the half in which the target lies, until few stretches are left there; these
/// are sorted and walked. On average every stretch is looked at twice or so, instead of being sorted.
pub(super) fn find_depth(stretches: &mut Vec<Stretch>, mut target: f64) -> Option<Place> {
    while stretches.len() > FEW {
        let before = stretches.len();
        let middle = stretches.iter().map(|s| 0.5 * (s.start + s.end)).sum::<f64>() / before as f64;
        let left: f64 = stretches.iter().map(|s| s.before(middle)).sum();
        if target < left {
            stretches.retain(|s| s.start < middle);
            stretches.iter_mut().for_each(|s| s.cut_after(middle));
        } else {
            target -= left;
            // A disc exactly in the middle is still to come.
            stretches.retain(|s| s.end > middle || s.start >= middle);
            stretches.iter_mut().for_each(|s| s.cut_before(middle));
        }
        // Where nearly all overlap, halving does not thin them out.
        if stretches.len() * 5 > before * 4 {
            break;
        }
    }
    walk(stretches, target)
}

impl Stretch {
    fn cut_after(&mut self, t: f64) {
        if self.end > t {
            self.depth = self.before(t);
            self.end = t;
        }
    }

    fn cut_before(&mut self, t: f64) {
        if self.start < t && self.end > t {
            self.depth -= self.before(t);
            self.start = t;
        }
    }
}

/// Walks from boundary to boundary.
fn walk(stretches: &[Stretch], mut target: f64) -> Option<Place> {
    // Distance, change of slope, and the stretch that begins there.
    let mut edges: Vec<(f64, f64, &Stretch)> = Vec::with_capacity(2 * stretches.len());
    for s in stretches {
        if s.start < s.end {
            edges.push((s.start, s.slope(), s));
            edges.push((s.end, -s.slope(), s));
        } else {
            edges.push((s.start, 0.0, s));
        }
    }
    edges.sort_by(|a, b| (a.0, a.2.index).partial_cmp(&(b.0, b.2.index)).unwrap_or(std::cmp::Ordering::Equal));
    let (mut t, mut slope) = (edges.first()?.0, 0.0f64);
    for (next, change, stretch) in edges {
        let depth = slope.max(0.0) * (next - t);
        if target < depth {
            return Some(Place::Fog(t + target / slope));
        }
        target -= depth;
        t = next;
        slope += change;
        if change == 0.0 {
            if target < stretch.depth {
                return Some(Place::Disc(stretch.index));
            }
            target -= stretch.depth;
        }
    }
    // Rounding can leave the target just beyond the end.
    let last = stretches.iter().max_by(|a, b| a.end.total_cmp(&b.end))?;
    Some(if last.start < last.end { Place::Fog(last.end) } else { Place::Disc(last.index) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Against a search on the summed depth, over random sets with discs and overlaps.
    #[test]
    fn the_place_has_the_depth_that_was_asked_for() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
        for n in [1, 2, 5, 13, 100, 400] {
            for _ in 0..200 {
                let stretches: Vec<Stretch> = (0..n)
                    .map(|index| {
                        let start = rng.random::<f64>() * 10.0;
                        let length = if rng.random::<f64>() < 0.3 { 0.0 } else { 5.0 * rng.random::<f64>() };
                        Stretch { start, end: start + length, depth: rng.random(), index }
                    })
                    .collect();
                let total: f64 = stretches.iter().map(|s| s.depth).sum();
                let target = rng.random::<f64>() * total;
                let before = |t: f64| stretches.iter().map(|s| s.before(t)).sum::<f64>();
                match find_depth(&mut stretches.clone(), target) {
                    Some(Place::Fog(t)) => assert!((before(t) - target).abs() < 1e-9 * total, "{n}"),
                    Some(Place::Disc(i)) => {
                        let disc = &stretches[i as usize];
                        assert!(before(disc.start) <= target + 1e-9 * total);
                        assert!(before(disc.start) + disc.depth >= target - 1e-9 * total);
                    }
                    None => panic!("there is always a place"),
                }
            }
        }
    }

    #[test]
    fn an_opaque_disc_stops_everything() {
        let opaque = Stretch { start: 1.0, end: 1.0, depth: f64::INFINITY, index: 3 };
        let behind = Stretch { start: 2.0, end: 3.0, depth: 1.0, index: 4 };
        assert_eq!(find_depth(&mut vec![behind, opaque], 1e300), Some(Place::Disc(3)));
    }
}
