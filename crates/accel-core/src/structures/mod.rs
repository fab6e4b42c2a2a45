//! Acceleration structures. One file and one line per structure in [`REGISTRY`].
//!
//! A structure holds ids and knows nothing of primitives but their bounds. Help, `rtbench list`,
//! the settings parser and the test matrix are all made from the registry.

pub mod adaptive_grid;
pub mod bounding_volumes;
pub mod bricked_grid;
pub mod brute_force;
pub mod compact_grid;
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
use crate::params::config::{Config, Settings};
use crate::params::{ParamSpec, Params};
use crate::primitives::{MixedSet, PrimsRef};
use crate::query::tracer::tested::{TestChoice, tested_as};
use crate::query::tracer::{Bound, BoundInMotion, PreviousFrame, Tracer};
use crate::registry::{self, Buildable, RegistryItem};
use crate::structure::{BuildError, Structure};
use crate::structures::time_segments::TimeSegments;
use crate::variants::chosen_tests::{self, ChosenTests};

/// Every structure of the workspace: one line each.
#[cfg(any(not(test), feature = "compiled-tests"))]
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
];

/// Structures that unit tests find by name, or through the light buffer. Each line compiles a
/// structure for all sets and queries: all of them, for unit tests alone, would double the compile
/// time of this crate. So tests that find others by name are in `tests/`.
#[cfg(not(any(not(test), feature = "compiled-tests")))]
pub static REGISTRY: &[Entry] = &[
    entry!(brute_force::BruteForce, brute_force::INFO),
    entry!(wide_bvh::WideBvh, wide_bvh::INFO),
];

/// Parameters that every structure has.
pub const COMMON: &[ParamSpec] =
    &[chosen_tests::TRIANGLE_TEST, chosen_tests::SPHERE_TEST, time_segments::PARAM];

/// A structure that answers rays.
pub struct Traceable;

impl RegistryItem for Traceable {
    type Builder<S: Scalar> = fn(&Params) -> PreparedStructure<S>;
    const COMMON: &'static [ParamSpec] = COMMON;
}

/// One line of [`REGISTRY`].
pub type Entry = registry::Entry<Traceable>;

/// A structure whose settings have been read. What is left is the build, which alone is timed: over
/// the set, ready to trace, or taken there from the frame before, as its setting `update` says, or
/// built anew. The settings are those that it was built with then; it is of no use after an error.
pub type PreparedStructure<S> = Box<
    dyn for<'a> Fn(
            PrimsRef<'a, S>,
            Option<PreviousFrame<'_>>,
        ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError>
        + Send
        + Sync,
>;

impl Entry {
    pub fn prepare<S: Buildable>(&self, params: &Params) -> PreparedStructure<S> {
        S::builder(self)(params)
    }

    /// Builds the structure over the set, ready to trace.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build<'a, S: Buildable>(
        &self,
        prims: PrimsRef<'a, S>,
        params: &Params,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
        self.prepare(params)(prims, None)
    }

    /// Takes a structure of this entry to the next frame: see [`PreparedStructure`].
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn update<'a, S: Buildable>(
        &self,
        prims: PrimsRef<'a, S>,
        params: &Params,
        before: PreviousFrame<'_>,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
        self.prepare(params)(prims, Some(before))
    }
}

/// The entry of that name.
#[warn(missing_docs)]
pub fn find(name: &str) -> Option<&'static Entry> {
    registry::find(REGISTRY, name)
}

/// Reads the settings of `T`, which is then built over whichever set it is, or taken there from the
/// frame before, and boxed as a tracer.
pub fn prepare<S: Scalar, T: Structure<S>>(params: &Params) -> PreparedStructure<S> {
    let (settings, testing) = (Settings::of(params), TestChoice::of(params));
    let segments = time_segments::of(params);
    Box::new(move |prims, before| {
        build_tracer::<S, T>(prims, (&settings, &testing), segments, before)
    })
}

fn build_tracer<'a, S: Scalar, T: Structure<S>>(
    prims: PrimsRef<'a, S>,
    how: (&Settings<T::Config>, &TestChoice),
    segments: usize,
    before: Option<PreviousFrame<'_>>,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let (settings, testing) = how;
    let limits = settings.limits();
    match (prims, testing.choice) {
        (PrimsRef::Mixed(p), None) if p.has_motion() => in_motion::<S, T, false>(p, how, segments),
        (PrimsRef::Mixed(p), Some(choice)) if p.has_motion() => {
            let mailbox = testing.mailbox::<S, _>(p, limits)?;
            let segments = TimeSegments::<S, T>::build(p, settings, testing, segments)?;
            let view = Box::new(ChosenTests::of_mixed(p, choice));
            Ok(Box::new(BoundInMotion::<S, _, T, false>::new(view, segments, mailbox)))
        }
        (PrimsRef::Watertight(p), None) => tested_as::<S, _, _, T>(p, p, how, before),
        (PrimsRef::Mixed(p), None) => tested_as::<S, _, _, T>(p, p, how, before),
        (prims, Some(choice)) => {
            // built from the same bounds, so the structure is that of the set itself
            let (view, mailbox, structure) = match prims {
                PrimsRef::Watertight(p) => {
                    let mailbox = testing.mailbox::<S, _>(p, limits)?;
                    (ChosenTests::of_triangles(p, choice), mailbox, T::build(p, settings)?)
                }
                PrimsRef::Mixed(p) => {
                    let mailbox = testing.mailbox::<S, _>(p, limits)?;
                    (ChosenTests::of_mixed(p, choice), mailbox, T::build(p, settings)?)
                }
            };
            Ok(Box::new(Bound::new(Box::new(view), structure).with_mailbox(mailbox)))
        }
    }
}

/// Builds `T` over a set that moves, under its own tests.
fn in_motion<'a, S: Scalar, T: Structure<S>, const COMPILED: bool>(
    set: &'a MixedSet<S>,
    (settings, testing): (&Settings<T::Config>, &TestChoice),
    segments: usize,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let mailbox = testing.mailbox::<S, _>(set, settings.limits())?;
    let segments = TimeSegments::<S, T>::build(set, settings, testing, segments)?;
    Ok(Box::new(BoundInMotion::<S, _, T, COMPILED>::new(set.in_motion(), segments, mailbox)))
}

/// [`prepare`] for a structure of which more is compiled into its traversals, in f32 alone: the
/// queries of sets that move, and chosen tests where the feature `compiled-tests` is on.
pub fn prepare_compiled<T: Structure<f32>>(params: &Params) -> PreparedStructure<f32> {
    let (settings, testing) = (Settings::of(params), TestChoice::of(params));
    let segments = time_segments::of(params);
    Box::new(move |prims, before| {
        let how = (&settings, &testing);
        #[cfg(feature = "compiled-tests")]
        if let Some(built) = crate::variants::compiled_tests::build::<T>(prims, how) {
            return built;
        }
        match prims {
            PrimsRef::Mixed(set) if testing.choice.is_none() && set.has_motion() => {
                in_motion::<f32, T, true>(set, how, segments)
            }
            _ => build_tracer::<f32, T>(prims, how, segments, before),
        }
    })
}

/// A registry entry for a generic structure and its description: `entry!(my_tree::MyTree,
/// my_tree::INFO)`. The type's only parameter is its scalar; it is a
/// [`Structure`](crate::structure::Structure) in f32 and in f64.
#[macro_export]
macro_rules! entry {
    ($structure:path, $info:path) => {
        $crate::structures::Entry::new(
            &$info,
            |params| {
                use $structure as It;
                $crate::structures::prepare::<f32, It<f32>>(params)
            },
            |params| {
                use $structure as It;
                $crate::structures::prepare::<f64, It<f64>>(params)
            },
        )
    };
}

/// [`entry!`] for a structure of which more can be compiled in: see [`prepare_compiled`].
#[cfg_attr(test, allow(unused_macros, reason = "unit tests see two structures"))]
macro_rules! compiled_entry {
    ($structure:path, $info:path) => {
        $crate::structures::Entry::new(
            &$info,
            |params| {
                use $structure as It;
                $crate::structures::prepare_compiled::<It<f32>>(params)
            },
            |params| {
                use $structure as It;
                $crate::structures::prepare::<f64, It<f64>>(params)
            },
        )
    };
}
#[cfg_attr(test, allow(unused_imports, reason = "as above"))]
use compiled_entry;
use entry;
