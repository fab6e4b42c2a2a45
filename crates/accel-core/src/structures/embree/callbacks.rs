//! What Embree calls back during a query; the query stands behind the context.

use crate::structures::embree::ffi::{Context, FilterArguments, PrimitiveArguments};

/// A context with the query behind it; callbacks get its address as that of the context.
#[repr(C)]
pub(super) struct QueryContext {
    pub(super) context: Context,
    pub(super) query: *mut (),
    pub(super) test: unsafe fn(*mut (), Candidate) -> f32,
}

/// What the library found.
#[derive(Clone, Copy)]
pub(super) enum Candidate {
    /// By its own test, a triangle of that number.
    Triangle(u32),
    /// By its box, a primitive of that number among those with callbacks.
    Boxed(u32),
}

/// # Safety
/// `context` is that of `query::traverse`.
unsafe fn ask(context: *mut Context, candidate: Candidate) -> f32 {
    // SAFETY: `query::traverse` passes a `QueryContext`, whose first field is the context
    unsafe {
        let context = &*context.cast::<QueryContext>();
        (context.test)(context.query, candidate)
    }
}

/// Callback: a primitive whose box is met by a ray that looks for the closest hit.
///
/// # Safety
/// Called by the library during `query::traverse`.
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
/// Called by the library during `query::traverse`.
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
/// Called by the library during `query::traverse`.
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

/// Callback: a triangle that lets light pass, found by the library's own test in an occlusion query.
///
/// # Safety
/// Called by the library.
pub(super) unsafe extern "C" fn let_pass(arguments: *const FilterArguments) {
    // SAFETY: the library passes valid pointers to one ray
    unsafe { *(*arguments).valid = 0 };
}
