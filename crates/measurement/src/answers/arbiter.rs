//! Decides the rays on which rows differ, by brute force.
//!
//! No row is the judge of others. One is asked first, and where another row answers differently,
//! every primitive is tested. The tests that our rows share say what the answer is to the last bit;
//! f64 brute force decides where it refutes that. If the row that was asked first is contradicted,
//! the answer expected of that ray is replaced and all rows are checked again.
//!
//! A row with primitive tests of its own may differ where rounding decides: by as much as moving
//! the ray by [`EDGE_ULPS`] ulps changes the right answer, and no more (`own_test.rs`).

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use accel_core::Ray;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::find;
use renderer::{Geometry, RayKind};

use crate::answers::oracle::{BRUTE_FORCE, Opinion, Oracle};
use crate::rays::batches::{Answers, Batch, BatchSet, trace};
use crate::rays::exactness::Exactness;

/// How far a ray is moved to find out whether it passes an edge: ulps, of the precision that is
/// tested, of the scene's largest coordinate and of the direction's length. 64 are 4e-6 of the
/// scene in f32, 7e-15 in f64: a few times what the usual tests (Moeller and Trumbore) are off by
/// at triangles that are no slivers.
pub const EDGE_ULPS: f64 = 64.0;

/// Name of a batch, and index of a ray in all of its rays.
type RayId = (String, usize);
/// A ray, the bits of an answer to it, and how far that must agree.
type GivenAnswer = (RayId, Vec<u8>, Exactness);

pub struct Arbiter<'a, S: Buildable> {
    pub oracle: Oracle<'a>,
    at_edges: Oracle<'a>,
    /// Tests every primitive in the precision of the run.
    every: Box<dyn Tracer<S> + 'a>,
    /// Decided answers: rounds ask the same again.
    opinions: Mutex<HashMap<GivenAnswer, Opinion>>,
    /// Right answers, where the row that was asked first gave others.
    overturned: Mutex<HashMap<RayId, Answers<S>>>,
}

impl<'a, S: Buildable> Arbiter<'a, S> {
    pub fn new(geometry: &'a Geometry<S>, exact: &'a Geometry<f64>) -> Result<Self, BuildError> {
        let oracle = Oracle::new(exact)?;
        let entry = find(BRUTE_FORCE).ok_or(BuildError::NoPrimitives { structure: BRUTE_FORCE })?;
        Ok(Self {
            at_edges: oracle.with_ulps(EDGE_ULPS),
            oracle,
            every: entry.build(geometry.prims(), &entry.params([])?)?,
            opinions: Mutex::default(),
            overturned: Mutex::default(),
        })
    }

    /// Answer of the shared primitive tests.
    pub fn answer(&self, kind: RayKind, ray: &Ray<S>) -> Answers<S> {
        let mut answer = Answers::new(kind, 1);
        trace(&*self.every, std::slice::from_ref(ray), &mut answer);
        answer
    }

    /// Opinion on answer `i` to a batch of rays of which every `stride`-th is asked.
    pub fn opinion(
        &self,
        (batch, stride): (&Batch<'_, S>, usize),
        i: usize,
        answers: &Answers<S>,
        exactness: Exactness,
    ) -> Option<Opinion> {
        let id = (batch.name(), i * stride);
        let own = answers.picked(std::iter::once(i));
        let key = (id.clone(), own.bytes(), exactness);
        let lock = || self.opinions.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return Some(known.clone());
        }
        let mut one = batch.window(i..i + 1);
        let ray = *one.rays.first()?;
        let right = self.answer(batch.kind, &ray);
        let first = std::mem::replace(&mut one.expected, right.clone());
        if right.differing(&first).next().is_some() {
            let mut overturned = self.overturned.lock().unwrap_or_else(PoisonError::into_inner);
            overturned.insert(id, right.clone());
        }
        let opinion = if exactness == Exactness::OwnTest {
            self.at_edges.strict_opinion(&ray, &own, 0)?
        } else if matches!(self.oracle.opinion(&ray, &right, 0)?, Opinion::Wrong(_)) {
            self.oracle.opinion(&ray, &own, 0)?
        } else if one.wrong(&own, exactness).next().is_none()
            || exactness == Exactness::Library
                && self.oracle.opinion(&ray, &own, 0)? == Opinion::Right
        {
            // a library's parameter may be closer to the truth than ours
            Opinion::Right
        } else {
            Opinion::Wrong(right.describe(0))
        };
        lock().insert(key, opinion.clone());
        Some(opinion)
    }

    /// Number of rays on which the row that was asked first was contradicted.
    pub fn contradicted(&self) -> usize {
        self.overturned.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// The rays of `all` with the answers that are right; `None` if the row that was asked first
    /// was contradicted on none.
    pub fn amended<'b>(&self, all: &'b BatchSet<'_, S>) -> Option<BatchSet<'b, S>> {
        let overturned = self.overturned.lock().unwrap_or_else(PoisonError::into_inner);
        let mut amended = (!overturned.is_empty()).then(|| all.thinned(1))?;
        for batch in &mut amended.batches {
            let name = batch.name();
            for ((_, i), right) in overturned.iter().filter(|((of, _), _)| *of == name) {
                batch.expected.set(*i, right);
            }
        }
        Some(amended)
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use accel_core::Hit;
    use glam::{Vec3, dvec3};
    use scene_loading::Scene;

    use super::*;
    use crate::rays::order::RayOrder;

    /// A floor of 100 x 100 in two triangles.
    fn floor() -> Scene {
        let (mut scene, m) = Scene::of_one_material("floor");
        let [a, b] = [dvec3(-50.0, -50.0, 0.0), dvec3(50.0, 50.0, 0.0)];
        scene.push_triangle(m, [b, dvec3(-50.0, 50.0, 0.0), a]);
        scene.push_triangle(m, [a, dvec3(50.0, -50.0, 0.0), b]);
        scene
    }

    #[test]
    fn an_answer_is_judged_by_the_rule_of_its_row_and_may_be_closer_than_ours() {
        let scene = floor();
        let (single, exact) = (Geometry::of(&scene).unwrap(), Geometry::of(&scene).unwrap());
        let arbiter = Arbiter::<f32>::new(&single, &exact).unwrap();
        let origin = Vec3::new(0.035_311_002, -0.137_351_84, 0.113_654_47);
        let ray = Ray::new(origin, Vec3::new(0.735_762_66, -0.406_419_52, -0.541_734_7));
        let hits = |t: f32| Answers::Hits(vec![Hit { t, id: 1 }]);
        let ours = arbiter.answer(RayKind::Diffuse, &ray);
        let batch = Batch {
            kind: RayKind::Diffuse,
            order: RayOrder::Scanline,
            rays: Cow::Owned(vec![ray]),
            lights: Vec::new(),
            expected: ours.clone(),
        };
        // in exact arithmetic t is 0.209797292; the floor's corners are 50 away
        let (close, far) = (hits(0.209_797_28), hits(0.3));
        assert!(batch.wrong(&close, Exactness::Library).next().is_some(), "{}", ours.describe(0));
        let opinion =
            |answers, exactness| arbiter.opinion((&batch, 1), 0, answers, exactness).unwrap();
        for exactness in [Exactness::Bits, Exactness::OurTest] {
            assert!(matches!(opinion(&close, exactness), Opinion::Wrong(_)), "{exactness:?}");
            assert_eq!(opinion(&ours, exactness), Opinion::Right, "{exactness:?}");
        }
        for exactness in [Exactness::Library, Exactness::OwnTest] {
            assert_eq!(opinion(&close, exactness), Opinion::Right, "{exactness:?}");
            assert!(matches!(opinion(&far, exactness), Opinion::Wrong(_)), "{exactness:?}");
        }
    }
}
