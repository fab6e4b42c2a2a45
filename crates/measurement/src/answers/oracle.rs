//! The judge of answers: every primitive tested in f64, nothing else.
//!
//! An answer in f32 may differ from the oracle's only on a *borderline* ray. A ray is borderline
//! when rounding alone decides its answer, that is when the oracle itself
//! * gives another id, hit or miss, for the same ray moved by a few ulps of f32 (origin: ulps of
//!   the scene's largest coordinate; direction: ulps of its length; each axis, both ways), or
//! * finds the primitive of the answer as near as its own, within those ulps (two surfaces in
//!   one place).
//!
//! Otherwise the id must be the same, and t no farther from the oracle's than a few times what
//! moving the ray changes it by: at grazing angles and on slivers the rounding of a primitive test
//! counts for more than that of the ray. Borderline rays are counted, never dropped silently.

use std::sync::Arc;

use accel_core::params::Params;
use accel_core::primitives::{PrimSet, PrimsRef};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::{Entry, find};
use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;
use rayon::prelude::*;
use renderer::{Geometry, RayKind};

use crate::rays::batches::Answers;

/// The structure that tests every primitive.
pub const BRUTE_FORCE: &str = "brute-force";
/// [`Oracle::ulps`] of the oracle of all runs.
const ULPS: f64 = 8.0;

/// Factor by which the rounding of a primitive test may change `t` more than moving the ray does.
pub(super) const TEST_ROUNDING: f64 = 8.0;

/// How the answers to a sample of rays compare with the oracle's.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OracleCounts {
    pub checked: usize,
    /// Number of rays whose answer differs but is decided by rounding.
    pub borderline: usize,
    /// Indices in the batch of rays with a wrong answer.
    pub wrong: Vec<usize>,
    /// The first wrong answer, in words.
    pub example: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Opinion {
    Right,
    /// It differs where rounding decides.
    Borderline,
    /// It is wrong; in words what would be right.
    Wrong(String),
}

pub struct Oracle<'a> {
    pub(super) prims: PrimsRef<'a, f64>,
    tracer: Arc<dyn Tracer<f64> + 'a>,
    /// Largest coordinate of the scene.
    magnitude: f64,
    /// How far rays are moved, and how much more t may be off, in ulps of the tested precision.
    ulps: f64,
}

impl<'a> Oracle<'a> {
    /// Over a scene's geometry.
    pub fn new(geometry: &'a Geometry<f64>) -> Result<Self, BuildError> {
        let entry = find(BRUTE_FORCE).ok_or(BuildError::NoPrimitives { structure: BRUTE_FORCE })?;
        Self::over(geometry.prims(), entry, &entry.params([])?, ULPS)
    }

    /// The same oracle, which moves rays by so many ulps of the tested precision.
    pub fn with_ulps(&self, ulps: f64) -> Self {
        Self { tracer: Arc::clone(&self.tracer), ulps, ..*self }
    }

    /// The same by a structure, for many rays, which are moved by so many ulps of the tested
    /// precision.
    pub fn over(
        prims: PrimsRef<'a, f64>,
        entry: &Entry,
        params: &Params,
        ulps: f64,
    ) -> Result<Self, BuildError> {
        let tracer: Arc<dyn Tracer<f64> + 'a> = Arc::from(entry.build(prims, params)?);
        let bounds = prims.primitives().scene_bounds();
        let magnitude = bounds.min.abs().max(bounds.max.abs()).max_element();
        Ok(Self { prims, tracer, magnitude, ulps })
    }

    /// Compares the answers to the rays of those indices. Runs in the current rayon pool.
    pub fn check<S: Buildable>(
        &self,
        kind: RayKind,
        rays: &[Ray<S>],
        answers: &Answers<S>,
        indices: &[usize],
    ) -> OracleCounts {
        let opinions: Vec<(usize, Opinion)> = indices
            .par_iter()
            .filter_map(|&i| Some((i, self.opinion(rays.get(i)?, answers, i)?)))
            .collect();
        let mut tally = OracleCounts { checked: opinions.len(), ..OracleCounts::default() };
        for (i, opinion) in opinions {
            match opinion {
                Opinion::Right => {}
                Opinion::Borderline => tally.borderline += 1,
                Opinion::Wrong(said) => {
                    tally.wrong.push(i);
                    tally.example.get_or_insert_with(|| {
                        let kind = kind.name();
                        format!("{kind} ray {i}: {}, the oracle says {said}", answers.describe(i))
                    });
                }
            }
        }
        tally
    }

    /// Opinion on answer `i`, to `ray`; `None` if there is no such answer.
    pub fn opinion<S: Buildable>(
        &self,
        ray: &Ray<S>,
        answers: &Answers<S>,
        i: usize,
    ) -> Option<Opinion> {
        Some(match answers {
            Answers::Hits(hits) => self.of_hit(ray, hits.get(i)?),
            Answers::Blocked(blocked) => self.of_occlusion(ray, *blocked.get(i)?),
        })
    }

    fn of_hit<S: Scalar>(&self, ray: &Ray<S>, hit: &Hit<S>) -> Opinion {
        let exact = ray.widened();
        let truth = self.closest(&exact);
        let slack = self.slack::<S>(&exact);
        let t = hit.t.to_f64();
        let near = |a: f64, b: f64| (a - b).abs() <= slack + self.epsilon::<S>() * b.abs();
        if hit.id == truth.id && (!truth.is_hit() || near(t, truth.t)) {
            return Opinion::Right;
        }
        let moved: Vec<Hit<f64>> =
            self.moved::<S>(&exact).iter().map(|ray| self.closest(ray)).collect();
        if moved.iter().any(|m| m.id != truth.id) {
            return Opinion::Borderline;
        }
        if hit.is_hit() && hit.id != truth.id {
            let twin = self.distance_to(hit.id, &exact);
            if truth.is_hit() && twin.is_some_and(|twin| near(twin, truth.t)) {
                return Opinion::Borderline;
            }
        }
        if hit.id == truth.id {
            let farthest = moved.iter().fold(slack, |far, m| far.max((m.t - truth.t).abs()));
            if (t - truth.t).abs() <= TEST_ROUNDING * farthest {
                return Opinion::Right;
            }
        }
        Opinion::Wrong(Answers::Hits(vec![truth]).describe(0))
    }

    fn of_occlusion<S: Scalar>(&self, ray: &Ray<S>, blocked: bool) -> Opinion {
        let exact = ray.widened();
        let truth = self.is_blocked(&exact);
        if truth == blocked {
            return Opinion::Right;
        }
        if self.moved::<S>(&exact).iter().any(|ray| self.is_blocked(ray) != truth) {
            return Opinion::Borderline;
        }
        Opinion::Wrong(Answers::<f64>::Blocked(vec![truth]).describe(0))
    }

    /// The rounding of the scene's coordinates, as a distance along the ray.
    pub(super) fn slack<S: Scalar>(&self, ray: &Ray<f64>) -> f64 {
        self.reach::<S>(ray) / ray.direction.length()
    }

    /// Distance by which origins are moved.
    pub(super) fn reach<S: Scalar>(&self, ray: &Ray<f64>) -> f64 {
        self.epsilon::<S>() * self.magnitude.max(ray.origin.abs().max_element())
    }

    /// Its ulps, as a part of a number.
    pub(super) fn epsilon<S: Scalar>(&self) -> f64 {
        self.ulps * S::EPSILON.to_f64()
    }

    /// The ray, moved along and turned about each axis, both ways.
    pub(super) fn moved<S: Scalar>(&self, ray: &Ray<f64>) -> Vec<Ray<f64>> {
        self.moved_by::<S>(1.0, ray)
    }

    /// The same by a part of that.
    pub(super) fn moved_by<S: Scalar>(&self, part: f64, ray: &Ray<f64>) -> Vec<Ray<f64>> {
        let shift = part * self.reach::<S>(ray);
        let turn = part * self.ulps * S::EPSILON.to_f64() * ray.direction.length();
        let mut rays = Vec::with_capacity(12);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
            rays.push(Ray { origin: ray.origin + axis * shift, ..*ray });
            rays.push(Ray { direction: ray.direction + axis * turn, ..*ray });
        }
        rays
    }

    pub(super) fn closest(&self, ray: &Ray<f64>) -> Hit<f64> {
        let mut hit = [Hit::NONE];
        self.tracer.closest_hits(std::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    pub(super) fn is_blocked(&self, ray: &Ray<f64>) -> bool {
        let mut blocked = [false];
        self.tracer.occlusions(std::slice::from_ref(ray), &mut blocked);
        blocked[0]
    }

    /// Parameter at which the ray hits one primitive.
    pub(super) fn distance_to(&self, id: u32, ray: &Ray<f64>) -> Option<f64> {
        fn of<P: PrimSet<f64>>(prims: &P, id: u32, ray: &Ray<f64>) -> Option<f64> {
            if id as usize >= prims.len() {
                return None;
            }
            prims.intersect(id, ray, &prims.setup(ray), ray.t_max)
        }
        match self.prims {
            PrimsRef::Watertight(p) => of(p, id, ray),
            PrimsRef::Mixed(p) => of(p.in_motion(), id, ray),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use glam::{Vec3, dvec3};
    use scene_loading::Scene;

    use super::*;

    pub(in crate::answers) fn two_triangles() -> Geometry<f64> {
        let (mut scene, m) = Scene::of_one_material("two");
        // A unit square in z = 0, split along its diagonal, and a copy of the first half behind.
        scene.push_triangle(m, [dvec3(0., 0., 0.), dvec3(1., 0., 0.), dvec3(1., 1., 0.)]);
        scene.push_triangle(m, [dvec3(0., 0., 0.), dvec3(1., 1., 0.), dvec3(0., 1., 0.)]);
        scene.push_triangle(m, [dvec3(0., 0., -1.), dvec3(1., 0., -1.), dvec3(1., 1., -1.)]);
        Geometry::of(&scene).unwrap()
    }

    fn opinion(x: f32, y: f32, id: u32, t: f32) -> (usize, usize) {
        let geometry = two_triangles();
        let oracle = Oracle::new(&geometry).unwrap();
        let ray = Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z);
        let answers = Answers::Hits(vec![Hit { t, id }]);
        let tally = oracle.check(RayKind::Primary, &[ray], &answers, &[0]);
        assert_eq!((tally.checked, tally.example.is_some()), (1, !tally.wrong.is_empty()));
        (tally.borderline, tally.wrong.len())
    }

    #[test]
    fn right_and_wrong_answers() {
        assert_eq!(opinion(0.75, 0.25, 0, 1.0), (0, 0));
        assert_eq!(opinion(0.75, 0.25, 0, 1.0_f32.next_up()), (0, 0));
        assert_eq!(opinion(0.75, 0.25, 0, 1.001), (0, 1), "t is off");
        assert_eq!(opinion(0.75, 0.25, 1, 1.0), (0, 1), "another triangle");
        assert_eq!(opinion(0.75, 0.25, 2, 2.0), (0, 1), "the one behind");
        assert_eq!(opinion(0.75, 0.25, accel_core::MISS, f32::INFINITY), (0, 1), "lost");
        assert_eq!(opinion(0.75, 0.25, 999, 1.0), (0, 1), "no such primitive");
        assert_eq!(opinion(5.0, 0.25, accel_core::MISS, f32::INFINITY), (0, 0));
        assert_eq!(opinion(5.0, 0.25, 0, 1.0), (0, 1), "invented");
    }

    #[test]
    fn only_rays_on_an_edge_are_borderline() {
        assert_eq!(opinion(0.5, 0.5, 1, 1.0), (1, 0), "on the diagonal either half is right");
        assert_eq!(opinion(0.5, 0.4999, 1, 1.0), (0, 1), "beside it only one is");
        assert_eq!(opinion(1.0, 0.5, accel_core::MISS, f32::INFINITY), (1, 0), "on the rim");
        assert_eq!(opinion(0.999, 0.5, accel_core::MISS, f32::INFINITY), (0, 1));
    }
}
