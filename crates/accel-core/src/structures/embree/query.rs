//! One ray through Embree: what its callbacks ask the sink.

use std::ops::ControlFlow;

use super::callbacks::{Candidate, QueryContext};
use super::ffi::{self, Context};
use super::scene::Scene;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structures::obvhs::box_ray::{BoxParameters, Length};

struct Query<'q, S: Scalar, K> {
    structure: &'q Scene<S>,
    start: &'q BoxParameters<S>,
    sink: &'q mut K,
}

impl<S: Scalar, K: Sink<S>> Query<'_, S, K> {
    /// Where the query now ends, in the library's parameter: minus infinity when it is over.
    fn test(&mut self, candidate: Candidate) -> f32 {
        let id = match candidate {
            Candidate::Triangle(number) => self.structure.triangle_ids[number as usize],
            Candidate::Boxed(number) => self.structure.boxed_ids[number as usize],
        };
        self.test_id(id)
    }

    fn test_id(&mut self, id: u32) -> f32 {
        self.sink.elementary_step(false);
        match self.sink.test(&[id]) {
            ControlFlow::Break(()) => f32::NEG_INFINITY,
            ControlFlow::Continue(()) => self.start.bound(self.sink.t_max()),
        }
    }
}

/// # Safety
/// `query` points to a live `Query<S, K>` that nobody else uses.
unsafe fn test<S: Scalar, K: Sink<S>>(query: *mut (), candidate: Candidate) -> f32 {
    // SAFETY: by the contract
    unsafe { &mut *query.cast::<Query<S, K>>() }.test(candidate)
}

/// Asks the library for the candidates of a ray and the sink for the answers.
#[inline(always)]
pub(super) fn traverse<S: Scalar, K: Sink<S>>(structure: &Scene<S>, ray: &Ray<S>, sink: &mut K) {
    let start = structure.setup.ray(ray, Length::Unit);
    let t_near = if structure.is_native { start.parameters.start(ray.t_min) } else { 0.0 };
    let mut asked = ffi::RayHit {
        ray: ffi::Ray {
            origin: start.origin.to_array(),
            t_near,
            direction: start.direction.to_array(),
            time: 0.0,
            t_far: start.parameters.bound(sink.t_max()),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        },
        hit: ffi::Hit::NONE,
    };
    let is_any_hit = sink.is_any_hit();
    // without its filter, an occlusion query would not say what it found
    let is_occlusion = is_any_hit && !structure.is_direct;
    let mut query = Query { structure, start: &start.parameters, sink };
    let mut context = QueryContext {
        context: Context::NEW,
        query: std::ptr::from_mut(&mut query).cast(),
        test: test::<S, K>,
    };
    let (scene, context) = (structure.library.scene(), std::ptr::from_mut(&mut context));
    loop {
        // SAFETY: the scene is committed; context and ray live until the call returns, and the
        // callbacks find behind the context what they expect
        unsafe {
            if is_occlusion {
                ffi::rtcOccluded1(scene, context.cast(), &raw mut asked.ray);
                return;
            }
            ffi::rtcIntersect1(scene, context.cast(), &raw mut asked);
        }
        let Some(id) = structure.id(&asked.hit) else { return };
        let end = query.test_id(id);
        if !is_any_hit || end == f32::NEG_INFINITY {
            return;
        }
        // what occludes nothing was found: on from behind it
        asked.ray.t_near = asked.ray.t_far.next_up();
        asked.ray.t_far = end;
        asked.hit = ffi::Hit::NONE;
    }
}
