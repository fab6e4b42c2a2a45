//! One ray through Embree: what its callbacks ask the sink.

use std::ops::ControlFlow;

use super::Embree;
use super::ffi::{self, Context, FilterArguments, PrimitiveArguments};
use super::library::TRIANGLES;
use crate::ray::Ray;
use crate::scalar::Scalar;
use crate::sink::Sink;
use crate::structures::obvhs_adapter::BoxRay;

/// A context with the query behind it; callbacks get its address as that of the context.
#[repr(C)]
struct QueryContext {
    context: Context,
    query: *mut (),
    test: unsafe fn(*mut (), Candidate) -> f32,
}

/// What the library found.
#[derive(Clone, Copy)]
enum Candidate {
    /// By its own test, a triangle of that number.
    Triangle(u32),
    /// By its box, a primitive of that number among those with callbacks.
    Boxed(u32),
}

struct Query<'q, S: Scalar, K> {
    structure: &'q Embree<S>,
    start: &'q BoxRay<S>,
    sink: &'q mut K,
}

impl<S: Scalar, K: Sink<S>> Query<'_, S, K> {
    /// Where the query now ends, in the library's parameter: minus infinity when it is over.
    fn test(&mut self, candidate: Candidate) -> f32 {
        let id = match candidate {
            Candidate::Triangle(number) => self.structure.triangle_ids[number as usize],
            Candidate::Boxed(number) => self.structure.boxed_ids[number as usize],
        };
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
pub(super) fn walk<S: Scalar, K: Sink<S>>(structure: &Embree<S>, ray: &Ray<S>, sink: &mut K) {
    let start = structure.setup.ray(ray, false);
    let t_near = if structure.is_native { start.start(ray.t_min) } else { 0.0 };
    let mut asked = ffi::RayHit {
        ray: ffi::Ray {
            origin: start.ray.origin.to_array(),
            t_near,
            direction: start.ray.direction.to_array(),
            time: 0.0,
            t_far: start.bound(sink.t_max()),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        },
        hit: ffi::Hit {
            normal: [0.0; 3],
            uv: [0.0; 2],
            primitive: ffi::INVALID,
            geometry: ffi::INVALID,
            instance: ffi::INVALID,
        },
    };
    let is_any_hit = sink.is_any_hit();
    let mut query = Query { structure, start: &start, sink };
    let mut context = QueryContext {
        context: Context { flags: 0, filter: std::ptr::null(), instance: ffi::INVALID },
        query: std::ptr::from_mut(&mut query).cast(),
        test: test::<S, K>,
    };
    let (scene, context) = (structure.library.scene(), std::ptr::from_mut(&mut context));
    // SAFETY: the scene is committed; context and ray live until the call returns, and the
    // callbacks find behind the context what they expect
    unsafe {
        if is_any_hit {
            ffi::rtcOccluded1(scene, context.cast(), &raw mut asked.ray);
        } else {
            ffi::rtcIntersect1(scene, context.cast(), &raw mut asked);
        }
    }
    if !is_any_hit && asked.hit.geometry == TRIANGLES {
        query.test(Candidate::Triangle(asked.hit.primitive));
    }
}

/// # Safety
/// `context` is that of [`walk`].
unsafe fn ask(context: *mut Context, candidate: Candidate) -> f32 {
    // SAFETY: `walk` passes a `QueryContext`, whose first field is the context
    unsafe {
        let context = &*context.cast::<QueryContext>();
        (context.test)(context.query, candidate)
    }
}

/// Callback: a primitive whose box is met by a ray that looks for the closest hit.
///
/// # Safety
/// Called by the library during [`walk`].
pub(super) unsafe extern "C" fn test_primitive(arguments: *const PrimitiveArguments) {
    // SAFETY: the library passes valid pointers; the ray is the first part of what `ray` points to
    unsafe {
        let arguments = &*arguments;
        let ends = ask(arguments.context, Candidate::Boxed(arguments.primitive));
        let ray = &mut *arguments.ray;
        ray.t_far = ray.t_far.min(ends);
    }
}

/// Callback: the same for an occlusion query; minus infinity as the end says "occluded".
///
/// # Safety
/// Called by the library during [`walk`].
pub(super) unsafe extern "C" fn occluded_primitive(arguments: *const PrimitiveArguments) {
    // SAFETY: as above
    unsafe {
        let arguments = &*arguments;
        let ends = ask(arguments.context, Candidate::Boxed(arguments.primitive));
        if ends == f32::NEG_INFINITY {
            (*arguments.ray).t_far = ends;
        }
    }
}

/// Callback: a triangle that the library's own test finds in an occlusion query. It counts if our
/// test finds it too, and if no light passes it.
///
/// # Safety
/// Called by the library during [`walk`].
pub(super) unsafe extern "C" fn test_triangle(arguments: *const FilterArguments) {
    // SAFETY: the library passes valid pointers to one ray and its hit
    unsafe {
        let arguments = &*arguments;
        let candidate = Candidate::Triangle((*arguments.hit).primitive);
        if ask(arguments.context, candidate) != f32::NEG_INFINITY {
            *arguments.valid = 0;
        }
    }
}
