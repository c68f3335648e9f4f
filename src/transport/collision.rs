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
    /// The body's number: of discs met at one distance the one with the lower number is first.
    pub id: u32,
}

/// Where a collision is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// In fog, at this distance, m.
    Fog(f64),
    /// On the disc of a droplet, by its place among the crossings.
    Disc(u32),
}

impl Place {
    /// How far along the ray it is, m, given what the ray meets.
    pub fn t_m(self, crossings: &[(Body, Crossing)]) -> f64 {
        match self {
            Self::Fog(t_m) => t_m,
            Self::Disc(index) => crossings[index as usize].1.start(),
        }
    }
}

impl Stretch {
    /// What a body puts on the ray at one wavelength; `None` where the ray starts behind it.
    pub fn of(media: &Media, wavelength: usize, index: usize, (body, crossing): &(Body, Crossing)) -> Option<Self> {
        let load = f64::from(body.load);
        let (start, end) = (crossing.start().max(0.0), crossing.end());
        let depth = match body.kind() {
            BodyKind::Droplet | BodyKind::Glass => load * media.disc_depth(body.bin())[wavelength],
            BodyKind::Ball | BodyKind::Box => load * media.c_ext_m2(body.bin())[wavelength] * (end - start),
        };
        (depth > 0.0).then_some(Self { start, end, depth, index: index as u32, id: body.id })
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

    /// Optical depth per metre of fog.
    fn slope(&self) -> f64 {
        self.depth / (self.end - self.start)
    }
}

/// Few enough to sort.
const FEW: usize = 12;

/// Finds places of collisions; its buffers are reused from one to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Finder {
    /// What lies on the ray; to be filled before `find`, which cuts it down.
    pub stretches: Vec<Stretch>,
    edges: Vec<Edge>,
}

/// Where the slope of the optical depth changes.
#[derive(Clone, Copy, Debug)]
struct Edge {
    t: f64,
    /// Place of the body among the crossings.
    index: u32,
    id: u32,
    change: Change,
}

#[derive(Clone, Copy, Debug)]
enum Change {
    /// Fog begins (positive) or ends (negative): change of the depth per metre.
    Slope(f64),
    /// A disc of this depth.
    Disc(f64),
}

impl Finder {
    /// The place where the optical depth of all stretches together reaches `target`; `None` where nothing lies on the
    /// ray.
    ///
    /// Halves the ray again and again, keeping the half in which the target lies, until few stretches are left there;
    /// these are sorted and walked. On average every stretch is looked at twice or so, instead of being sorted.
    pub fn find(&mut self, mut target: f64) -> Option<Place> {
        while self.stretches.len() > FEW {
            let before = self.stretches.len();
            let middle = self.stretches.iter().map(|s| 0.5 * (s.start + s.end)).sum::<f64>() / before as f64;
            let left: f64 = self.stretches.iter().map(|s| s.before(middle)).sum();
            if target < left {
                self.stretches.retain(|s| s.start < middle);
                self.stretches.iter_mut().for_each(|s| s.cut_after(middle));
            } else {
                target -= left;
                // A disc exactly in the middle is still to come.
                self.stretches.retain(|s| s.end > middle || s.start >= middle);
                self.stretches.iter_mut().for_each(|s| s.cut_before(middle));
            }
            // Where nearly all overlap, halving does not thin them out.
            if self.stretches.len() * 5 > before * 4 {
                break;
            }
        }
        match self.stretches[..] {
            [only] => Some(only.place(target)),
            _ => self.walk(target),
        }
    }

    /// Walks from edge to edge.
    fn walk(&mut self, mut target: f64) -> Option<Place> {
        self.collect_edges();
        let (mut t, mut slope) = (self.edges.first()?.t, 0.0f64);
        for edge in &self.edges {
            let depth = slope.max(0.0) * (edge.t - t);
            if target < depth {
                return Some(Place::Fog(t + target / slope));
            }
            target -= depth;
            t = edge.t;
            match edge.change {
                Change::Slope(change) => slope += change,
                Change::Disc(depth) if target < depth => return Some(Place::Disc(edge.index)),
                Change::Disc(depth) => target -= depth,
            }
        }
        // Rounding can leave the target just beyond the end.
        self.stretches.iter().max_by(|a, b| a.end.total_cmp(&b.end)).map(|last| last.place(f64::INFINITY))
    }

    fn collect_edges(&mut self) {
        self.edges.clear();
        for s in &self.stretches {
            if s.is_disc() {
                self.edges.push(Edge { t: s.start, index: s.index, id: s.id, change: Change::Disc(s.depth) });
            } else {
                self.edges.push(Edge { t: s.start, index: s.index, id: s.id, change: Change::Slope(s.slope()) });
                self.edges.push(Edge { t: s.end, index: s.index, id: s.id, change: Change::Slope(-s.slope()) });
            }
        }
        self.edges.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.id.cmp(&b.id)));
    }
}

impl Stretch {
    fn is_disc(&self) -> bool {
        self.start >= self.end
    }

    /// Where its own depth reaches `target`, at its end at the latest.
    fn place(&self, target: f64) -> Place {
        if self.is_disc() {
            return Place::Disc(self.index);
        }
        Place::Fog(self.start + (self.end - self.start) * (target / self.depth).min(1.0))
    }

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
                        Stretch { start, end: start + length, depth: rng.random(), index, id: index }
                    })
                    .collect();
                let total: f64 = stretches.iter().map(|s| s.depth).sum();
                let target = rng.random::<f64>() * total;
                let before = |t: f64| stretches.iter().map(|s| s.before(t)).sum::<f64>();
                let mut finder = Finder { stretches: stretches.clone(), ..Finder::default() };
                match finder.find(target) {
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
        let opaque = Stretch { start: 1.0, end: 1.0, depth: f64::INFINITY, index: 3, id: 3 };
        let behind = Stretch { start: 2.0, end: 3.0, depth: 1.0, index: 4, id: 4 };
        let mut finder = Finder { stretches: vec![behind, opaque], ..Finder::default() };
        assert_eq!(finder.find(1e300), Some(Place::Disc(3)));
    }
}
