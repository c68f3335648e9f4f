//! The two questions that transport asks: what is met first, and what is met at all.

use std::ops::ControlFlow;

use glam::DVec3;

use super::Accel;
use super::body::{Body, BodyKind, Crossing, LocalRay, cross_box, cross_sphere};
use super::walk::Visitor;

/// The nearest event of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin, m.
    pub t_m: f64,
    /// Place of the body in the tree's order.
    pub index: u32,
    /// Number of the body in the scene.
    pub id: u32,
}

impl Accel {
    /// A world-space ray in the cloud's frame. `direction` must have unit length.
    pub fn local_ray(&self, origin_m: DVec3, direction: DVec3) -> LocalRay {
        LocalRay { origin: self.frame.local_from_world(origin_m), direction }
    }

    /// The only body that there is, if it is fog: where a ray runs through it needs no list.
    #[inline]
    pub fn only_fog(&self) -> Option<&Body> {
        match &self.bodies[..] {
            [body] if !body.is_disc() => Some(body),
            _ => None,
        }
    }

    /// The first event beyond (`from`, `after_id`), in the order of distance and then of body number.
    ///
    /// `event` gives the distance at which a body acts on the ray, if it does: a certain hit, or one drawn at random.
    pub fn closest<F>(&self, ray: &LocalRay, from: f64, after_id: Option<u32>, event: F) -> Option<Hit>
    where
        F: FnMut(&Body, Crossing) -> Option<f64>,
    {
        let mut search = Closest { accel: self, ray, from, after_id, event, entry: 0.0, best: None };
        if self.nodes.is_empty() {
            (0..self.bodies.len()).for_each(|index| _ = search.test(index));
        } else {
            let (entry, exit) = self.frame.clip(ray, from, f64::INFINITY)?;
            search.entry = entry;
            self.walker.walk(&self.nodes, &self.frame.tree_ray(ray, entry, exit), &mut search);
        }
        search.best
    }

    /// Calls `visit` for every body whose crossing reaches into `from..to`, in no particular order.
    #[inline]
    pub fn all<F>(&self, ray: &LocalRay, from: f64, to: f64, mut visit: F)
    where
        F: FnMut(&Body, Crossing),
    {
        self.all_until(ray, from, to, |body, crossing| {
            visit(body, crossing);
            ControlFlow::Continue(())
        });
    }

    /// As `all`, until `visit` breaks off.
    #[inline]
    pub fn all_until<F>(&self, ray: &LocalRay, from: f64, to: f64, mut visit: F)
    where
        F: FnMut(&Body, Crossing) -> ControlFlow<()>,
    {
        if self.nodes.is_empty() {
            let _ = self.bodies.iter().try_for_each(|body| self.visit_within(ray, from, to, body, &mut visit));
        } else if let Some((entry, exit)) = self.frame.clip(ray, from, to) {
            let tree_ray = self.frame.tree_ray(ray, entry, exit);
            self.walker.walk(&self.nodes, &tree_ray, All { accel: self, ray, from, to, visit });
        }
    }

    /// Calls `visit` if the body's crossing reaches into `from..to`.
    #[inline(always)]
    fn visit_within<F>(&self, ray: &LocalRay, from: f64, to: f64, body: &Body, visit: &mut F) -> ControlFlow<()>
    where
        F: FnMut(&Body, Crossing) -> ControlFlow<()>,
    {
        match self.cross(ray, body) {
            Some(crossing) if crossing.end() > from && crossing.start() < to => visit(body, crossing),
            _ => ControlFlow::Continue(()),
        }
    }

    /// The bodies of one primitive of the tree.
    #[inline(always)]
    fn members(&self, primitive: usize) -> std::ops::Range<usize> {
        if self.group_start.is_empty() {
            return primitive..primitive + 1;
        }
        self.group_start[primitive] as usize..self.group_start[primitive + 1] as usize
    }

    /// Where the ray crosses the body, if it does.
    #[inline(always)]
    pub(super) fn cross(&self, ray: &LocalRay, body: &Body) -> Option<Crossing> {
        let radius_m = f64::from(body.radius_m);
        match body.kind() {
            BodyKind::Droplet | BodyKind::Glass => {
                cross_sphere(ray, body.center, radius_m).map(|(t, _)| Crossing::Point(t))
            }
            BodyKind::Ball => cross_sphere(ray, body.center, radius_m).map(|(t, rest)| {
                let half = rest.sqrt();
                Crossing::Chord(t - half, t + half)
            }),
            BodyKind::Box => {
                cross_box(ray, body.center, &self.boxes[body.box_index()]).map(|(t0, t1)| Crossing::Chord(t0, t1))
            }
        }
    }
}

/// Looks for the first event.
struct Closest<'a, F> {
    accel: &'a Accel,
    ray: &'a LocalRay,
    from: f64,
    after_id: Option<u32>,
    event: F,
    /// Where the tree's ray begins.
    entry: f64,
    best: Option<Hit>,
}

impl<F: FnMut(&Body, Crossing) -> Option<f64>> Closest<'_, F> {
    /// The distance of a body's event, if it is the first so far.
    #[inline(always)]
    fn test(&mut self, index: usize) -> Option<f64> {
        let body = &self.accel.bodies[index];
        let crossing = self.accel.cross(self.ray, body)?;
        if crossing.end() < self.from || self.best.is_some_and(|best| crossing.start() > best.t_m) {
            return None;
        }
        let t_m = (self.event)(body, crossing)?;
        let is_after = t_m > self.from || (t_m == self.from && self.after_id.is_some_and(|after| body.id > after));
        let is_nearer = self.best.is_none_or(|best| (t_m, body.id) < (best.t_m, best.id));
        if !(is_nearer && is_after) {
            return None;
        }
        self.best = Some(Hit { t_m, index: index as u32, id: body.id });
        Some(t_m)
    }
}

impl<F: FnMut(&Body, Crossing) -> Option<f64>> Visitor for &mut Closest<'_, F> {
    #[inline(always)]
    fn visit(&mut self, primitive: usize, tmax: &mut f32) {
        for index in self.accel.members(primitive) {
            if let Some(t_m) = self.test(index) {
                *tmax = tmax.min(self.accel.frame.tree_distance(t_m - self.entry));
            }
        }
    }
}

/// Looks at everything between two distances.
struct All<'a, F> {
    accel: &'a Accel,
    ray: &'a LocalRay,
    from: f64,
    to: f64,
    visit: F,
}

impl<F: FnMut(&Body, Crossing) -> ControlFlow<()>> Visitor for All<'_, F> {
    #[inline(always)]
    fn visit(&mut self, primitive: usize, tmax: &mut f32) {
        // A ray that has been cut off still meets the other bodies of its batch.
        if *tmax < 0.0 {
            return;
        }
        for body in &self.accel.bodies[self.accel.members(primitive)] {
            if self.accel.visit_within(self.ray, self.from, self.to, body, &mut self.visit).is_break() {
                *tmax = f32::NEG_INFINITY;
                return;
            }
        }
    }
}
