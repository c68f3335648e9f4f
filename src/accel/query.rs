//! The two questions that transport asks: what is met first, and what is met at all.

use std::ops::ControlFlow;

use glam::DVec3;

use super::Accel;
use super::body::{Body, BodyKind, Crossing, LocalRay, cross_box, cross_sphere};

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

    /// The first event beyond (`from`, `after_id`), in the order of distance and then of body number.
    ///
    /// `event` gives the distance at which a body acts on the ray, if it does: a certain hit, or one drawn at random.
    pub fn closest<F>(&self, ray: &LocalRay, from: f64, after_id: Option<u32>, mut event: F) -> Option<Hit>
    where
        F: FnMut(&Body, Crossing) -> Option<f64>,
    {
        let mut best: Option<Hit> = None;
        let is_after = |t: f64, id: u32| t > from || (t == from && after_id.is_some_and(|after| id > after));
        let mut test = |index: usize| -> Option<f64> {
            let body = &self.bodies[index];
            let crossing = self.cross(ray, body)?;
            if crossing.end() < from || best.is_some_and(|b| crossing.start() > b.t_m) {
                return None;
            }
            let t_m = event(body, crossing)?;
            let nearer = best.is_none_or(|b| (t_m, body.id) < (b.t_m, b.id));
            if !(nearer && is_after(t_m, body.id)) {
                return None;
            }
            best = Some(Hit { t_m, index: index as u32, id: body.id });
            Some(t_m)
        };
        let Some(tree) = &self.tree else {
            for index in 0..self.bodies.len() {
                test(index);
            }
            return best;
        };
        let (entry, exit) = self.frame.clip(ray, from, f64::INFINITY)?;
        let tree_ray = self.frame.tree_ray(ray, entry, exit);
        self.walker.walk(tree, tree_ray, |primitive, tmax| {
            for index in self.members(primitive) {
                if let Some(t_m) = test(index) {
                    *tmax = tmax.min(self.frame.tree_distance(t_m - entry));
                }
            }
        });
        best
    }

    /// Calls `visit` for every body whose crossing reaches into `from..to`, in no particular order.
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
    pub fn all_until<F>(&self, ray: &LocalRay, from: f64, to: f64, mut visit: F)
    where
        F: FnMut(&Body, Crossing) -> ControlFlow<()>,
    {
        let Some(tree) = &self.tree else {
            let _ = self.bodies.iter().try_for_each(|body| self.visit_within(ray, from, to, body, &mut visit));
            return;
        };
        let Some((entry, exit)) = self.frame.clip(ray, from, to) else { return };
        let tree_ray = self.frame.tree_ray(ray, entry, exit);
        self.walker.walk(tree, tree_ray, |primitive, tmax| {
            // A ray that has been cut off still meets the other bodies of its node.
            if *tmax < 0.0 {
                return;
            }
            for body in &self.bodies[self.members(primitive)] {
                if self.visit_within(ray, from, to, body, &mut visit).is_break() {
                    *tmax = f32::NEG_INFINITY;
                    return;
                }
            }
        });
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
    #[inline]
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
