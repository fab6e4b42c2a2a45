//! The oracle's rule for answers by another primitive test than ours: it may err as if the ray were
//! moved by [`EDGE_ULPS`](crate::answers::arbiter::EDGE_ULPS) ulps, and no further.
//!
//! * A hit must be there: the point that it claims lies within those ulps of the primitive, and its
//!   parameter in the interval of the ray.
//! * A hit may be lost only if the ray, moved so, misses the primitive or leaves its interval; for
//!   a shadow ray this must be so of every primitive in its way.

use accel_core::primitives::PrimsRef;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;

use crate::answers::oracle::{Opinion, Oracle, TEST_ROUNDING};
use crate::rays::batches::Answers;

/// Primitives in the way of a shadow ray that are looked at, one after another.
const MOST_IN_THE_WAY: usize = 64;
/// Parts of the bound that rays are moved by, too.
const SMALLER_PARTS: [f64; 5] = [1.0, 0.125, 0.015_625, 1.0 / 512.0, 1.0 / 4096.0];

impl Oracle<'_> {
    /// Opinion on answer `i`, to `ray`, given by a primitive test other than ours.
    pub fn strict_opinion<S: Buildable>(
        &self,
        ray: &Ray<S>,
        answers: &Answers<S>,
        i: usize,
    ) -> Option<Opinion> {
        let opinion = self.opinion(ray, answers, i)?;
        let is_wrong = matches!(opinion, Opinion::Wrong(_));
        Some(match answers {
            Answers::Hits(hits) => {
                let hit = hits.get(i)?;
                if hit.is_hit() && !self.is_there(ray, hit) {
                    return Some(Opinion::Wrong("that there is no such hit".into()));
                }
                if is_wrong && self.may_be_returned(ray, hit) {
                    Opinion::Borderline
                } else {
                    opinion
                }
            }
            Answers::Blocked(blocked) => {
                let explained = is_wrong && self.may_be_said(ray, *blocked.get(i)?);
                if explained { Opinion::Borderline } else { opinion }
            }
        })
    }

    fn is_there<S: Scalar>(&self, ray: &Ray<S>, hit: &Hit<S>) -> bool {
        if !(ray.t_min <= hit.t && hit.t <= ray.t_max) {
            return false;
        }
        let (exact, t) = (ray.widened(), hit.t.to_f64());
        if self.is_near::<S>(&exact, hit.id, t) {
            return true;
        }
        let open = |ray| Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..ray };
        let moved = self.moved::<S>(&exact).into_iter().chain([exact]).map(open);
        let found: Vec<f64> = moved.filter_map(|ray| self.distance_to(hit.id, &ray)).collect();
        let [least, most] = [1.0, -1.0]
            .map(|sign| sign * found.iter().fold(f64::INFINITY, |least, t| least.min(sign * t)));
        let slack = self.slack::<S>(&exact) + self.epsilon::<S>() * t.abs();
        let slack = slack + TEST_ROUNDING * (most - least).max(0.0);
        t >= least - slack && t <= most + slack
    }

    /// Returns whether the point at `t` is as near to the triangle as the ray is moved: then some
    /// ray that is moved no further hits it there. However narrow it is, and however flat the ray
    /// runs along it.
    fn is_near<S: Scalar>(&self, ray: &Ray<f64>, id: u32, t: f64) -> bool {
        let PrimsRef::Watertight(set) = self.prims else { return false };
        let Some(corners) = set.triangles().get(id as usize) else { return false };
        let turned = self.epsilon::<S>() * ray.direction.length() * t.abs();
        let distance = distance_to_triangle(ray.at(t), &corners.map(DVec3::from_array));
        distance <= self.reach::<S>(ray) + turned
    }

    /// Returns whether rounding may return this hit, which is there, or none, in place of the right
    /// one.
    fn may_be_returned<S: Scalar>(&self, ray: &Ray<S>, hit: &Hit<S>) -> bool {
        let exact = ray.widened();
        let truth = self.closest(&exact);
        let is_first = hit.is_hit() && hit.t.to_f64() <= truth.t;
        !truth.is_hit() || is_first || self.may_be_lost::<S>(&exact, &truth)
    }

    /// Returns whether rounding may say this of an occlusion, though it is wrong.
    fn may_be_said<S: Scalar>(&self, ray: &Ray<S>, blocked: bool) -> bool {
        let mut exact = ray.widened();
        if blocked {
            let slack = self.slack::<S>(&exact);
            let room = |t: f64| slack.max(self.epsilon::<S>() * t.abs());
            let (t_min, t_max) = (exact.t_min - room(exact.t_min), exact.t_max + room(exact.t_max));
            let widened = Ray { t_min, t_max, ..exact };
            // moved by all of it, the ray may pass on the other side of what is small
            let mut moved =
                SMALLER_PARTS.iter().flat_map(|part| self.moved_by::<S>(*part, &widened));
            return self.is_blocked(&widened) || moved.any(|ray| self.is_blocked(&ray));
        }
        for _ in 0..MOST_IN_THE_WAY {
            let hit = self.closest(&exact);
            if !hit.is_hit() {
                return true;
            }
            if !self.may_be_lost::<S>(&Ray { t_min: ray.t_min.to_f64(), ..exact }, &hit) {
                return false;
            }
            exact.t_min = hit.t.next_up();
        }
        false
    }

    /// Returns whether the ray misses the primitive of a hit when it is moved, or leaves its
    /// interval.
    fn may_be_lost<S: Scalar>(&self, ray: &Ray<f64>, hit: &Hit<f64>) -> bool {
        let slack = self.slack::<S>(ray) + self.epsilon::<S>() * hit.t.abs();
        let ends = hit.t - ray.t_min < slack || ray.t_max - hit.t < slack;
        ends || self.moved::<S>(ray).iter().any(|moved| self.distance_to(hit.id, moved).is_none())
    }
}

/// C. Ericson, Real-Time Collision Detection, 2005, 5.1.5: the nearest point is a corner, on an
/// edge or within, by where the point projects to.
fn distance_to_triangle(p: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = *corners;
    let to_edge = |a: DVec3, b: DVec3| {
        let along = (b - a).length_squared();
        let at = if along > 0.0 { ((p - a).dot(b - a) / along).clamp(0.0, 1.0) } else { 0.0 };
        p.distance(a + (b - a) * at)
    };
    let normal = (b - a).cross(c - a);
    let inside = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        return (p - a).dot(normal).abs() / normal.length();
    }
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::answers::oracle::tests::two_triangles;

    #[test]
    fn answers_of_another_test_may_differ_at_edges_only() {
        let geometry = two_triangles();
        let oracle = Oracle::new(&geometry).unwrap().with_ulps(64.0);
        let opinion = |x: f32, y: f32, id: u32, t: f32| {
            let mut ray = Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z);
            ray.t_min = 0.5;
            let answers = Answers::Hits(vec![Hit { t, id }]);
            oracle.strict_opinion(&ray, &answers, 0).unwrap()
        };
        let is_wrong = |x, y, id, t| matches!(opinion(x, y, id, t), Opinion::Wrong(_));
        assert_eq!(opinion(0.75, 0.25, 0, 1.0), Opinion::Right);
        // on the diagonal: either half, none, or the one behind through a crack
        assert_eq!(opinion(0.5, 0.5, 0, 1.0), Opinion::Right);
        for (id, t) in [(1, 1.0), (accel_core::MISS, f32::INFINITY), (2, 2.0)] {
            assert_eq!(opinion(0.5, 0.5, id, t), Opinion::Borderline, "{id}");
        }
        // planted faults, on the diagonal as well: a hit that is not there, or not in the interval
        assert!(is_wrong(0.5, 0.5, 1, 1.01) && is_wrong(0.5, 0.5, 2, 1.0));
        assert!(is_wrong(0.5, 0.5, 0, 0.25) && is_wrong(0.5, 0.5, 9, 1.0));
        assert!(is_wrong(0.5, 0.499, 1, 1.0) && is_wrong(0.75, 0.25, accel_core::MISS, 9.0));
    }

    #[test]
    fn shadow_rays_may_pass_where_every_surface_has_an_edge() {
        let geometry = two_triangles();
        let oracle = Oracle::new(&geometry).unwrap().with_ulps(64.0);
        let opinion = |x: f32, y: f32, [t_min, t_max]: [f32; 2], blocked: bool| {
            let mut ray = Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z);
            (ray.t_min, ray.t_max) = (t_min, t_max);
            oracle.strict_opinion(&ray, &Answers::Blocked(vec![blocked]), 0).unwrap()
        };
        let all = [0.0, 9.0];
        assert_eq!(opinion(0.75, 0.25, all, true), Opinion::Right);
        assert!(matches!(opinion(0.75, 0.25, all, false), Opinion::Wrong(_)));
        // both halves and the one behind have the diagonal as an edge
        assert_eq!(opinion(0.5, 0.5, all, false), Opinion::Borderline);
        // at the ends of an interval, however short
        assert_eq!(opinion(0.75, 0.25, [0.0, 1.0], false), Opinion::Borderline);
        let next = 1.0f32.next_up();
        assert_eq!(opinion(0.75, 0.25, [next, next.next_up()], true), Opinion::Borderline);
        assert!(matches!(opinion(0.75, 0.25, [1.1, 1.9], true), Opinion::Wrong(_)));
        // from so far that the bound is wider than the scene
        let far: Ray<f32> = Ray::new(Vec3::new(1.001, 0.5, 1e6), Vec3::new(0.0, 0.0, -1e6));
        let opinion = oracle.strict_opinion(&far, &Answers::Blocked(vec![true]), 0);
        assert_eq!(opinion, Some(Opinion::Borderline));
    }

    #[test]
    fn distances_to_triangles() {
        let corners = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        for (p, distance) in [
            (DVec3::new(0.5, 0.5, 3.0), 3.0),
            (DVec3::new(0.5, -4.0, 3.0), 5.0),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
            (DVec3::new(2.0, 2.0, 0.0), 2f64.sqrt()),
        ] {
            assert!((distance_to_triangle(p, &corners) - distance).abs() < 1e-12, "{p}");
        }
        // a needle has no inside
        assert_eq!(distance_to_triangle(DVec3::Y, &[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]), 1.0);
    }
}
