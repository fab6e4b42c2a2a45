//! Batches of rays: closest hits, or whether rays are blocked. Rays that begin far away are brought
//! near before a structure sees them. How the rays go through a structure is the business of
//! `side_by_side.rs` and of `bvh/prepared.rs`.
//!
//! The loop over rays in f32 is compiled twice on x86-64: for the target, and for AVX-512, whose 32
//! registers hold what is known of a ray; which of both runs is decided where it runs. The
//! operations are the same, none is contracted, and so are the answers. Of structures that have
//! batches, so is the loop over single rays.

use std::hint::black_box;
use std::mem::MaybeUninit;
use std::ops::Range;

use wide::f64x8;

use crate::geometry::far_ray::{self, Parameters, PlacedRay};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::Counters;
use crate::query::mailbox::NoMailbox;
use crate::query::ray_order;
use crate::query::sink::{Answer, BatchAnswers, Query, RayBatch, Sink};
use crate::structure::Structure;

/// The ray, or the one that it was brought near as, kept in `moved`, and what its parameters
/// became; none where it cannot hit anything.
#[inline(always)]
pub(crate) fn rebase_origin<'r, S: Scalar>(
    ray: &'r Ray<S>,
    reach: S,
    moved: &'r mut Option<Ray<S>>,
) -> Option<(&'r Ray<S>, Parameters<S>)> {
    match far_ray::place(ray, reach) {
        PlacedRay::Near => Some((ray, Parameters::SAME)),
        PlacedRay::Moved(near, parameters) => Some((moved.insert(near), parameters)),
        PlacedRay::Nowhere => None,
    }
}

/// Puts the frame of the caller at a multiple of a cache line. What a loop over rays knows of a ray
/// as vectors lies in the frame while it calls. Without this a frame begins at any multiple of 16
/// bytes, and a vector lies across two lines, or across two pages, by chance: one store across two
/// pages made `wide-bvh` 9% slower on *kitchen*.
#[inline(always)]
fn align_frame() {
    // a local that is as long as a line and aligned so, which the compiler must keep
    black_box(&mut MaybeUninit::<f64x8>::uninit());
}

/// Answers each ray by what `one` says of the ray, brought near.
#[inline(always)]
pub(crate) fn each_near<S: Scalar, A: Answer<S>>(
    reach: S,
    rays: &[Ray<S>],
    answers: &mut [A],
    mut one: impl FnMut(&Ray<S>) -> A,
) {
    align_frame();
    for (ray, answer) in rays.iter().zip(answers) {
        let found = match rebase_origin(ray, reach, &mut None) {
            Some((near, parameters)) => one(near).restored(parameters),
            None => None,
        };
        *answer = found.unwrap_or_else(|| A::miss(ray));
    }
}

/// The traversal of single rays.
pub(crate) trait Traverse<S: Scalar> {
    fn traverse_one<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K);
}

/// A structure whose lists are as it has them.
pub(crate) struct PlainStructure<'a, T>(pub(crate) &'a T);

impl<S: Scalar, T: Structure<S>> Traverse<S> for PlainStructure<'_, T> {
    #[inline(always)]
    fn traverse_one<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.0.traverse(ray, sink);
    }
}

/// The queries of a batch. Compiled into the loop over rays: a query that is made elsewhere and
/// moved in is waited for.
pub(crate) struct Batch<'r, 'a, S: Scalar, P, C, A> {
    pub(crate) prims: &'r P,
    /// Rays whose answers are wanted.
    pub(crate) rays: &'r [Ray<S>],
    answers: &'a mut [A],
    work: C,
}

impl<'r, S: Scalar, P: PrimSet<S>, C: Counters, A: Answer<S>> Batch<'r, '_, S, P, C, A> {
    /// The query of a ray near the scene, which is prepared for the set.
    #[inline(always)]
    pub(crate) fn query<'q>(&self, ray: &'q Ray<S>, setup: P::RaySetup) -> Query<'q, S, P, C, A>
    where
        'r: 'q,
    {
        Query::prepared(self.prims, ray, setup, NoMailbox)
    }

    /// Keeps the answer of the ray at that place, which was brought near.
    #[inline(always)]
    pub(crate) fn keep(
        &mut self,
        place: usize,
        query: &Query<'_, S, P, C, A>,
        parameters: Parameters<S>,
    ) {
        self.work += query.counters;
        self.answers[place] = match query.answer.restored(parameters) {
            Some(answer) => answer,
            None => A::miss(&self.rays[place]),
        };
    }
}

/// How the rays of a batch go through a structure.
pub(crate) trait BatchDriver<S: Scalar, T> {
    /// True where rays go side by side, which is not compiled for tests that are compared.
    const IS_TOGETHER: bool = true;

    /// Answers the rays at these places; to be inlined.
    fn all<P: PrimSet<S>, C: Counters, A: Answer<S>>(
        structure: &T,
        reach: S,
        batch: &mut Batch<'_, '_, S, P, C, A>,
        places: Range<usize>,
    );
}

/// Traverses one ray after the other.
pub(crate) struct RayByRay;

impl<S: Scalar, T: Traverse<S>> BatchDriver<S, T> for RayByRay {
    const IS_TOGETHER: bool = false;

    // without closures, which would not be compiled for AVX-512
    #[inline(always)]
    fn all<P: PrimSet<S>, C: Counters, A: Answer<S>>(
        structure: &T,
        reach: S,
        batch: &mut Batch<'_, '_, S, P, C, A>,
        places: Range<usize>,
    ) {
        let (prims, rays) = (batch.prims, batch.rays);
        for place in places {
            let mut moved = None;
            match rebase_origin(&rays[place], reach, &mut moved) {
                Some((ray, parameters)) => {
                    let mut query = batch.query(ray, prims.setup(ray));
                    structure.traverse_one(ray, &mut query);
                    batch.keep(place, &query, parameters);
                }
                None => batch.answers[place] = A::miss(&rays[place]),
            }
        }
    }
}

/// So many rays are put into another order at a time, which bounds the memory for that.
const ORDERED_AT_A_TIME: usize = 1 << 20;

/// So many of these are copied at a time, which the second cache holds.
const COPIED_AT_A_TIME: usize = 1 << 12;

/// Answers a batch; what it took. With a `unit`, that of [`ray_order::of`], in an order in which
/// neighbours run alike where those of the batch do not, as its first rays tell. Compiled for
/// triangles alone.
#[inline(always)]
pub(crate) fn answer<D: BatchDriver<S, T>, C: Counters, S: Scalar, P: PrimSet<S>, T>(
    structure: &T,
    prims: &P,
    RayBatch { rays, reach, answers }: RayBatch<'_, S>,
    unit: Option<f64>,
) -> C {
    let work = C::default();
    if !P::HAS_BLOCKS || D::IS_TOGETHER && P::HAS_OTHER_TESTS {
        return work;
    }
    match answers {
        BatchAnswers::Closest(answers) => {
            let batch = Batch { prims, rays, answers, work };
            answered::<D, _, _, _, _, _>(structure, reach, batch, unit)
        }
        BatchAnswers::Occlusion(answers) => {
            let batch = Batch { prims, rays, answers, work };
            answered::<D, _, _, _, _, _>(structure, reach, batch, unit)
        }
    }
}

/// The same for answers of one kind.
#[inline(always)]
fn answered<D: BatchDriver<S, T>, C: Counters, S: Scalar, P: PrimSet<S>, T, A: Answer<S>>(
    structure: &T,
    reach: S,
    mut batch: Batch<'_, '_, S, P, C, A>,
    unit: Option<f64>,
) -> C {
    let (prims, rays) = (batch.prims, batch.rays);
    let (mut first, mut ordered, mut found) = (0, Vec::new(), Vec::new());
    while let Some(unit) = unit
        && first < rays.len()
    {
        let places = first..rays.len().min(first + ORDERED_AT_A_TIME);
        let Some(order) = ray_order::of(&rays[places.clone()], unit) else { break };
        for order in order.chunks(COPIED_AT_A_TIME) {
            ordered.clear();
            ordered.extend(order.iter().map(|&at| rays[first + at as usize]));
            // each is overwritten
            found.resize(order.len(), A::miss(&ordered[0]));
            let work = batch.work;
            let mut part = Batch { prims, rays: &ordered, answers: &mut found, work };
            drive::<D, _, _, _, _, _>(structure, reach, &mut part, 0..order.len());
            batch.work = part.work;
            let answers = order.iter().zip(&found);
            answers.for_each(|(&at, &answer)| batch.answers[first + at as usize] = answer);
        }
        first = places.end;
    }
    drive::<D, _, _, _, _, _>(structure, reach, &mut batch, first..rays.len());
    batch.work
}

/// Environment variable: `off` where AVX-512 is not to be used though the processor has it.
pub const AVX512_VARIABLE: &str = "RTBENCH_AVX512";

/// Returns whether rays are traced with AVX-512 on this machine, where code for it was compiled.
pub fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        static IS_ON: std::sync::LazyLock<bool> = std::sync::LazyLock::new(|| {
            std::env::var_os(AVX512_VARIABLE).is_none_or(|value| value != "off")
        });
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && *IS_ON
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Answers the rays at these places of a batch; what counts is compiled for the target alone.
#[inline(never)]
pub(crate) fn drive<
    D: BatchDriver<S, T>,
    S: Scalar,
    P: PrimSet<S>,
    T,
    C: Counters,
    A: Answer<S>,
>(
    structure: &T,
    reach: S,
    batch: &mut Batch<'_, '_, S, P, C, A>,
    places: Range<usize>,
) {
    #[cfg(target_arch = "x86_64")]
    if size_of::<S>() == size_of::<f32>() && !C::ENABLED && has_avx512() {
        // SAFETY: the processor has it
        unsafe { drive_by_avx512::<D, _, _, _, _, _>(structure, reach, batch, places) };
        return;
    }
    align_frame();
    D::all(structure, reach, batch, places);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn drive_by_avx512<D: BatchDriver<S, T>, S: Scalar, P: PrimSet<S>, T, C: Counters, A: Answer<S>>(
    structure: &T,
    reach: S,
    batch: &mut Batch<'_, '_, S, P, C, A>,
    places: Range<usize>,
) {
    align_frame();
    D::all(structure, reach, batch, places);
}
