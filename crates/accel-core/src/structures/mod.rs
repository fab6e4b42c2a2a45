//! Acceleration structures. One file and one line per structure in [`REGISTRY`].
//!
//! A structure holds ids and knows nothing of primitives but their bounds. Help, `rtbench list`,
//! the settings parser and the test matrix are all made from the registry.

pub mod adaptive_grid;
pub mod bounding_volumes;
pub mod bricked_grid;
pub mod brute_force;
pub mod compact_grid;
#[cfg(feature = "embree")]
pub mod embree;
pub mod frustum_queries;
pub mod hashed_grid;
pub mod hug;
pub mod instanced;
pub mod instanced_bvh;
pub mod instanced_grid;
pub mod irregular_grid;
pub mod kay_kajiya;
pub mod kd_tree;
pub mod obvhs;
pub mod octree;
pub mod proximity_clouds;
pub mod recursive_grid;
#[cfg(test)]
pub(crate) mod test_scenes;
pub mod time_segments;
pub mod two_level_grid;
pub mod uniform_grid;
pub mod wide_bvh;

use crate::geometry::scalar::Scalar;
use crate::params::{ParamSpec, Params};
use crate::primitives::{MixedSet, PrimsRef};
use crate::query::tracer::tested::{mailbox_of, tested_as};
use crate::query::tracer::{Before, Bound, BoundInMotion, Tracer};
use crate::registry::{self, Buildable, Listed};
use crate::structure::{BuildError, Structure};
use crate::structures::time_segments::TimeSegments;
use crate::variants::chosen_tests::{self, Choice, ChosenTests};

/// Every structure of the workspace: one line each.
pub static REGISTRY: &[Entry] = &[
    entry!(brute_force::BruteForce, brute_force::INFO),
    compiled_entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
    entry!(hashed_grid::HashedGrid, hashed_grid::INFO),
    entry!(compact_grid::CompactGrid, compact_grid::INFO),
    entry!(bricked_grid::BrickedGrid, bricked_grid::INFO),
    entry!(proximity_clouds::ProximityClouds, proximity_clouds::INFO),
    entry!(recursive_grid::RecursiveGrid, recursive_grid::INFO),
    entry!(hug::Hug, hug::INFO),
    entry!(two_level_grid::TwoLevelGrid, two_level_grid::INFO),
    entry!(adaptive_grid::AdaptiveGrid, adaptive_grid::INFO),
    compiled_entry!(irregular_grid::IrregularGrid, irregular_grid::INFO),
    entry!(octree::Octree, octree::INFO),
    compiled_entry!(kd_tree::KdTree, kd_tree::INFO),
    entry!(bounding_volumes::BoundingVolumes, bounding_volumes::INFO),
    entry!(kay_kajiya::KayKajiya, kay_kajiya::INFO),
    compiled_entry!(wide_bvh::WideBvh, wide_bvh::INFO),
    entry!(instanced_grid::InstancedGrid, instanced_grid::INFO),
    entry!(instanced_bvh::InstancedBvh, instanced_bvh::INFO),
    compiled_entry!(obvhs::bvh2::ObvhsBvh2, obvhs::bvh2::INFO),
    compiled_entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO),
    #[cfg(feature = "embree")]
    entry!(embree::Embree, embree::INFO),
];

/// Parameters that every structure has.
pub const COMMON: &[ParamSpec] =
    &[chosen_tests::TRIANGLE_TEST, chosen_tests::SPHERE_TEST, time_segments::PARAM];

/// A structure that answers rays.
pub struct Traceable;

impl Listed for Traceable {
    type Builder<S: Scalar> = for<'a> fn(
        PrimsRef<'a, S>,
        &Params,
        Option<Before<'_>>,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError>;
    const COMMON: &'static [ParamSpec] = COMMON;
}

/// One line of [`REGISTRY`].
pub type Entry = registry::Entry<Traceable>;

impl Entry {
    /// Builds the structure over the set, ready to trace.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build<'a, S: Buildable>(
        &self,
        prims: PrimsRef<'a, S>,
        params: &Params,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
        S::builder(self)(prims, params, None)
    }

    /// Takes a structure of this entry to the next frame, ready to trace: as its setting `update` says, or built
    /// anew. `params` are those that it was built with; it is of no use after an error.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn update<'a, S: Buildable>(
        &self,
        prims: PrimsRef<'a, S>,
        params: &Params,
        before: Before<'_>,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
        S::builder(self)(prims, params, Some(before))
    }
}

/// The entry of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    registry::find(REGISTRY, name)
}

/// Builds `T` over whichever set it is, or takes it there from the frame `before`, and boxes it as a tracer.
pub fn build_tracer<'a, S: Scalar, T: Structure<S>>(
    prims: PrimsRef<'a, S>,
    params: &Params,
    before: Option<Before<'_>>,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let choice = Choice::of(params);
    match (prims, choice) {
        (PrimsRef::Mixed(p), None) if p.has_motion() => in_motion::<S, T, false>(p, params),
        (PrimsRef::Mixed(p), Some(choice)) if p.has_motion() => {
            let mailbox = mailbox_of::<S, _>(p, params)?;
            let segments = TimeSegments::<S, T>::build(p, params)?;
            let view = Box::new(ChosenTests::of_mixed(p, choice));
            Ok(Box::new(BoundInMotion::<S, _, T, false>::new(view, segments, mailbox)))
        }
        (PrimsRef::Watertight(p), None) => tested_as::<S, _, _, T>(p, p, params, before),
        (PrimsRef::Mixed(p), None) => tested_as::<S, _, _, T>(p, p, params, before),
        (prims, Some(choice)) => {
            // built from the same bounds, so the structure is that of the set itself
            let (view, mailbox, structure) = match prims {
                PrimsRef::Watertight(p) => {
                    let mailbox = mailbox_of::<S, _>(p, params)?;
                    (ChosenTests::of_triangles(p, choice), mailbox, T::build(p, params)?)
                }
                PrimsRef::Mixed(p) => {
                    let mailbox = mailbox_of::<S, _>(p, params)?;
                    (ChosenTests::of_mixed(p, choice), mailbox, T::build(p, params)?)
                }
            };
            Ok(Box::new(Bound::new(Box::new(view), structure).with_mailbox(mailbox)))
        }
    }
}

/// Builds `T` over a set that moves, under its own tests.
fn in_motion<'a, S: Scalar, T: Structure<S>, const COMPILED: bool>(
    set: &'a MixedSet<S>,
    params: &Params,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let mailbox = mailbox_of::<S, _>(set, params)?;
    let segments = TimeSegments::<S, T>::build(set, params)?;
    Ok(Box::new(BoundInMotion::<S, _, T, COMPILED>::new(set.in_motion(), segments, mailbox)))
}

/// [`build_tracer`] for a structure of which more is compiled into its traversals, in f32 alone: the queries of
/// sets that move, and chosen tests where the feature `compiled-tests` is on.
pub fn build_compiled<'a, T: Structure<f32>>(
    prims: PrimsRef<'a, f32>,
    params: &Params,
    before: Option<Before<'_>>,
) -> Result<Box<dyn Tracer<f32> + 'a>, BuildError> {
    #[cfg(feature = "compiled-tests")]
    if let Some(built) = crate::variants::compiled_tests::build::<T>(prims, params) {
        return built;
    }
    if let (PrimsRef::Mixed(set), None) = (prims, Choice::of(params))
        && set.has_motion()
    {
        return in_motion::<f32, T, true>(set, params);
    }
    build_tracer::<f32, T>(prims, params, before)
}

/// A registry entry for a generic structure and its description: `entry!(my_tree::MyTree, my_tree::INFO)`.
/// The type's only parameter is its scalar; it is a [`Structure`](crate::structure::Structure) in f32 and
/// in f64.
#[macro_export]
macro_rules! entry {
    ($structure:path, $info:path) => {
        $crate::structures::Entry::new(
            &$info,
            |p, s, before| {
                use $structure as It;
                $crate::structures::build_tracer::<f32, It<f32>>(p, s, before)
            },
            |p, s, before| {
                use $structure as It;
                $crate::structures::build_tracer::<f64, It<f64>>(p, s, before)
            },
        )
    };
}

/// [`entry!`] for a structure of which more can be compiled in: see [`build_compiled`].
macro_rules! compiled_entry {
    ($structure:path, $info:path) => {
        $crate::structures::Entry::new(
            &$info,
            |p, s, before| {
                use $structure as It;
                $crate::structures::build_compiled::<It<f32>>(p, s, before)
            },
            |p, s, before| {
                use $structure as It;
                $crate::structures::build_tracer::<f64, It<f64>>(p, s, before)
            },
        )
    };
}
use compiled_entry;
use entry;
