//! obvhs as its authors use it.
//!
//! Its own triangles ([`RtTriangle`], Moeller and Trumbore) in the order of its leaves, its own
//! rays, `ray_traverse` for closest hits, `ray_traverse_miss` for occlusion; nothing of ours but
//! that the answer is written. So its defects are its own as well. It serves triangles in f32; of
//! other sets the primitives are tested by ours in its callback, their boxes as they are. What is
//! counted is that, too: the library's nodes, our sink.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::CwBvh;
use obvhs::ray::{Ray as ObvhsRay, RayHit, safe_inverse};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use glam::Vec3A;
use wide::f64x4;

use crate::bvh::build::agglomerated::agglomerated;
use crate::bvh::items::outward;
use crate::geometry::ray::{Hit, MISS, Ray};
use crate::geometry::scalar::{Scalar, Vector};
use crate::historical::bounds_rule::BoundsRule;
use crate::memory::Limits;
use crate::parallel;
use crate::primitives::Primitives;
use crate::structure::{BatchAnswers, BuildError, RayBatch, bounds_of, refuse_out_of_scale};
use crate::structures::obvhs::builder::agglomerated_triangles;

/// How a tree answers batches: by its `direct` queries, where it has some and they serve the set.
macro_rules! direct_batches {
    () => {
        #[inline(always)]
        fn batches<P: $crate::primitives::PrimSet<S>>(
            &self,
            prims: &P,
            _: Option<&$crate::query::kernel::ListBlocks<S>>,
        ) -> $crate::structure::Batches {
            // a set under another test may be asked, too
            if self.direct().is_some() && direct::is_served(prims) {
                $crate::structure::Batches::Library
            } else {
                $crate::structure::Batches::RayByRay
            }
        }

        #[inline(always)]
        fn answer_batch<P: $crate::primitives::PrimSet<S>, C: $crate::query::counters::Counters>(
            &self,
            _: &P,
            _: Option<&$crate::query::kernel::ListBlocks<S>>,
            batch: $crate::structure::RayBatch<'_, S>,
        ) -> C {
            if let Some(own) = self.direct() {
                own.answer_batch(&self.bvh, batch);
            }
            C::default()
        }
    };
}
pub(crate) use direct_batches;

/// Queries that both trees of obvhs answer.
pub(crate) trait Tree {
    /// The triangle of each place among its leaves.
    fn ids(&self) -> &[u32];
    fn hits(
        &self,
        ray: ObvhsRay,
        hit: &mut RayHit,
        test: impl FnMut(&ObvhsRay, usize) -> f32,
    ) -> bool;
    fn misses(&self, ray: ObvhsRay, test: impl FnMut(&ObvhsRay, usize) -> f32) -> bool;
}

macro_rules! tree {
    ($tree:ty) => {
        impl Tree for $tree {
            #[inline(always)]
            fn ids(&self) -> &[u32] {
                &self.primitive_indices
            }

            #[inline(always)]
            fn hits(
                &self,
                ray: ObvhsRay,
                hit: &mut RayHit,
                test: impl FnMut(&ObvhsRay, usize) -> f32,
            ) -> bool {
                self.ray_traverse(ray, hit, test)
            }

            #[inline(always)]
            fn misses(&self, ray: ObvhsRay, test: impl FnMut(&ObvhsRay, usize) -> f32) -> bool {
                self.ray_traverse_miss(ray, test)
            }
        }
    };
}

tree!(Bvh2);
tree!(CwBvh);

/// The set as obvhs's triangles; none unless all are triangles at rest in f32, under the test of
/// triangles that is the default.
pub(crate) fn triangles<S: Scalar>(prims: &dyn Primitives<S>) -> Option<Vec<Triangle>> {
    if !is_served(prims) {
        return None;
    }
    let triangle = |id| {
        let [v0, v1, v2] = prims.corners(id)?.map(to_obvhs::<S>);
        Some(Triangle { v0, v1, v2 })
    };
    (0..prims.len() as u32).map(triangle).collect()
}

/// Returns whether triangles of the set are in f32, under the test of triangles that is the
/// default.
pub(crate) fn is_served<S: Scalar>(prims: &dyn Primitives<S>) -> bool {
    S::NAME == <f32 as Scalar>::NAME && prims.is_watertight()
}

/// In f32 nothing is converted.
#[inline(always)]
fn to_obvhs<S: Scalar>(v: crate::Vec3<S>) -> Vec3A {
    Vec3A::from_array(v.to_array().map(|x| x.to_f64() as f32))
}

/// Query data besides the tree itself.
pub(crate) struct DirectQueries {
    /// In the order of its leaves.
    triangles: Vec<RtTriangle>,
    /// Marks triangles that let shadow rays pass; empty if none does.
    transmissive: Vec<bool>,
}

impl DirectQueries {
    /// Lays out the triangles, which are all of the set.
    pub(crate) fn new<S: Scalar>(
        prims: &dyn Primitives<S>,
        tree: &impl Tree,
        triangles: &[Triangle],
    ) -> Self {
        let ids = tree.ids().iter();
        let laid_out = ids.clone().map(|id| RtTriangle::from(&triangles[*id as usize]));
        let is_opaque = (0..prims.len() as u32).all(|id| prims.is_opaque(id));
        let transmissive = ids.filter(|_| !is_opaque).map(|id| !prims.is_opaque(*id));
        Self { triangles: laid_out.collect(), transmissive: transmissive.collect() }
    }

    #[inline(always)]
    pub(crate) fn answer_batch<S: Scalar>(
        &self,
        tree: &impl Tree,
        RayBatch { rays, answers, .. }: RayBatch<'_, S>,
    ) {
        match answers {
            BatchAnswers::Closest(hits) => self.closest_hits(tree, rays, hits),
            BatchAnswers::Occlusion(blocked) => self.occlusions(tree, rays, blocked),
        }
    }

    #[inline(always)]
    fn closest_hits<S: Scalar>(&self, tree: &impl Tree, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let mut found = RayHit::none();
            let is_hit =
                tree.hits(own(ray), &mut found, |ray, at| self.triangles[at].intersect(ray));
            *hit = if is_hit {
                Hit {
                    t: S::from_f64(f64::from(found.t)),
                    id: tree.ids()[found.primitive_id as usize],
                }
            } else {
                Hit { t: ray.t_max, id: MISS }
            };
        }
    }

    #[inline(always)]
    fn occlusions<S: Scalar>(&self, tree: &impl Tree, rays: &[Ray<S>], blocked: &mut [bool]) {
        let test = |ray: &ObvhsRay, at: usize| self.triangles[at].intersect(ray);
        if self.transmissive.is_empty() {
            for (ray, blocked) in rays.iter().zip(blocked) {
                *blocked = !tree.misses(own(ray), test);
            }
            return;
        }
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = !tree.misses(own(ray), |ray, at| match test(ray, at) {
                t if t < ray.tmax && self.transmissive[at] => f32::INFINITY,
                t => t,
            });
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(self.triangles.as_slice()) + self.transmissive.len()) as u64
    }
}

/// A binary tree over the library's triangles, which come with it, or over boxes of primitives that
/// these do not serve.
///
/// # Errors
/// [`BuildError`] for a set without primitives that fit f32, which is all that obvhs knows.
pub(crate) fn tree<S: Scalar>(
    prims: &dyn Primitives<S>,
    limits: Limits,
    preset: &BvhBuildParams,
) -> Result<(Bvh2, Option<Vec<Triangle>>), BuildError> {
    if let Some(triangles) = triangles(prims) {
        return Ok((agglomerated_triangles(&triangles, preset), Some(triangles)));
    }
    // a box and an id of each primitive, twice as many nodes
    limits.fits(96 * prims.len() as u128)?;
    refuse_out_of_scale::<S, f32>(prims.magnitude(), limits.structure)?;
    bounds_of(prims, BoundsRule::Padded, limits.structure)?;
    let boxes = parallel::collect(prims.len(), |id| rounded(&prims.bounds(id as u32)));
    Ok((agglomerated(&boxes, preset, false), None))
}

/// A box in f32, rounded outwards.
pub(crate) fn rounded<S: Scalar>(b: &crate::Aabb<S>) -> Aabb {
    outward(b, f64x4::splat(0.0), 1.0)
}

/// As `obvhs::ray::Ray::new` makes it, which in debug builds panics where a ray is not finite.
#[inline(always)]
pub(crate) fn own<S: Scalar>(ray: &Ray<S>) -> ObvhsRay {
    let direction = to_obvhs::<S>(ray.direction);
    ObvhsRay {
        origin: to_obvhs::<S>(ray.origin),
        direction,
        inv_direction: Vec3A::from_array(direction.to_array().map(safe_inverse)),
        tmin: ray.t_min.to_f64() as f32,
        tmax: ray.t_max.to_f64() as f32,
    }
}
