//! Batches of rays: closest hits, or whether rays are blocked. How the rays go through a structure is the
//! business of `prepared.rs` and `side_by_side.rs`.
//!
//! The loop over rays is compiled twice on x86-64: for the target, and for AVX-512, whose 32 registers hold what
//! is known of a ray; which of both runs is decided where it runs. The operations are the same, none is
//! contracted, and so are the answers.

use std::ops::Range;

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::NoCounters;
use crate::query::mailbox::NoMailbox;
use crate::query::sink::{AnyHit, ClosestHit, Sink};
use crate::query::tracer::nearby;
use crate::structure::{BatchAnswers, Structure};

/// How the rays of a batch go through a structure.
pub(crate) trait Drive<S: Scalar, T> {
    /// Answers all rays; to be inlined.
    fn all<'r, P: PrimSet<S>, B: Batch<'r, S, P>>(
        structure: &T,
        prims: &'r P,
        reach: S,
        batch: &mut B,
    );
}

/// The queries of a batch. Compiled into the loop over rays: a sink that is made elsewhere and moved in is
/// waited for.
pub(crate) trait Batch<'r, S: Scalar, P: PrimSet<S>> {
    type Sink: Sink<S>;
    /// Rays whose answers are wanted.
    fn rays(&self) -> &'r [Ray<S>];
    /// The query of a ray near the scene, which is prepared for the set.
    fn sink(&self, ray: &'r Ray<S>, setup: P::RaySetup) -> Self::Sink;
    /// Keeps the answer of the ray at that place.
    fn keep(&mut self, place: usize, sink: &Self::Sink);
    /// Answers the rays at these places, from wherever they come, one after the other.
    fn answer<T: Structure<S>>(&mut self, structure: &T, reach: S, places: Range<usize>);
}

struct Closest<'r, 'a, S: Scalar, P> {
    prims: &'r P,
    rays: &'r [Ray<S>],
    /// As many.
    hits: &'a mut [Hit<S>],
}

impl<'r, S: Scalar, P: PrimSet<S>> Batch<'r, S, P> for Closest<'r, '_, S, P> {
    type Sink = ClosestHit<'r, S, P, NoCounters>;

    #[inline(always)]
    fn rays(&self) -> &'r [Ray<S>] {
        self.rays
    }

    #[inline(always)]
    fn sink(&self, ray: &'r Ray<S>, setup: P::RaySetup) -> Self::Sink {
        ClosestHit::prepared(self.prims, ray, setup)
    }

    #[inline(always)]
    fn keep(&mut self, place: usize, sink: &Self::Sink) {
        let (found, miss) = (sink.hit(), Hit { t: self.rays[place].t_max, ..Hit::NONE });
        self.hits[place] = if found.is_hit() { found } else { miss };
    }

    fn answer<T: Structure<S>>(&mut self, structure: &T, reach: S, places: Range<usize>) {
        let (rays, hits) = (&self.rays[places.clone()], &mut self.hits[places]);
        nearby::closest(reach, rays, hits, NoMailbox, |ray, _| {
            let mut sink = ClosestHit::<S, P, NoCounters>::new(self.prims, ray);
            structure.traverse(ray, &mut sink);
            sink.finish().0
        });
    }
}

/// Occlusion by opaque primitives.
struct Occlusions<'r, 'a, S: Scalar, P> {
    prims: &'r P,
    rays: &'r [Ray<S>],
    /// As many.
    blocked: &'a mut [bool],
}

impl<'r, S: Scalar, P: PrimSet<S>> Batch<'r, S, P> for Occlusions<'r, '_, S, P> {
    type Sink = AnyHit<'r, S, P, NoCounters>;

    #[inline(always)]
    fn rays(&self) -> &'r [Ray<S>] {
        self.rays
    }

    #[inline(always)]
    fn sink(&self, ray: &'r Ray<S>, setup: P::RaySetup) -> Self::Sink {
        AnyHit::prepared(self.prims, ray, setup)
    }

    #[inline(always)]
    fn keep(&mut self, place: usize, sink: &Self::Sink) {
        self.blocked[place] = sink.is_blocked();
    }

    fn answer<T: Structure<S>>(&mut self, structure: &T, reach: S, places: Range<usize>) {
        for place in places {
            self.blocked[place] = nearby::near(reach, &self.rays[place], false, |ray, _| {
                let mut sink = AnyHit::<S, P, NoCounters>::new(self.prims, ray);
                structure.traverse(ray, &mut sink);
                sink.finish().0
            });
        }
    }
}

/// Answers a batch. Compiled for triangles alone: for other sets [`Structure::batches`] says
/// [`RayByRay`](crate::structure::Batches::RayByRay).
#[inline(always)]
pub(crate) fn answer<D: Drive<S, T>, S: Scalar, P: PrimSet<S>, T>(
    structure: &T,
    prims: &P,
    rays: &[Ray<S>],
    reach: S,
    answers: BatchAnswers<'_, S>,
) {
    if P::HAS_BLOCKS {
        match answers {
            BatchAnswers::Closest(hits) => {
                drive::<D, _, _, _, _>(structure, prims, reach, &mut Closest { prims, rays, hits });
            }
            BatchAnswers::Occlusion(blocked) => {
                let batch = &mut Occlusions { prims, rays, blocked };
                drive::<D, _, _, _, _>(structure, prims, reach, batch);
            }
        }
    }
}

/// Whether batches are driven with AVX-512 on this machine.
pub fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

#[inline(never)]
fn drive<'r, D: Drive<S, T>, S: Scalar, P: PrimSet<S>, T, B: Batch<'r, S, P>>(
    structure: &T,
    prims: &'r P,
    reach: S,
    batch: &mut B,
) {
    #[cfg(target_arch = "x86_64")]
    if has_avx512() {
        // SAFETY: the processor has it
        unsafe { drive_by_avx512::<D, _, _, _, _>(structure, prims, reach, batch) };
        return;
    }
    D::all(structure, prims, reach, batch);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn drive_by_avx512<'r, D: Drive<S, T>, S: Scalar, P: PrimSet<S>, T, B: Batch<'r, S, P>>(
    structure: &T,
    prims: &'r P,
    reach: S,
    batch: &mut B,
) {
    D::all(structure, prims, reach, batch);
}
