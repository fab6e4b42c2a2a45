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

use crate::bvh::{self, WideBvh};
use crate::geometry::scalar::Scalar;
use crate::params::config::{Config, Settings};
use crate::params::{ParamSpec, Params};
use crate::primitives::{MixedSet, PrimSet, PrimsRef};
use crate::query::mailbox;
use crate::query::tracer::tested::{TestChoice, tested_as};
use crate::query::tracer::{BoundInMotion, PreviousFrame, Tracer};
use crate::registry::{self, Buildable, RegistryItem};
use crate::structure::{BuildError, Structure};
use crate::structures::time_segments::TimeSegments;
use crate::variants::chosen_tests::{self, Choice, TestedSetVisitor};

/// Every structure of the workspace: one line each.
#[cfg(not(test))]
pub static REGISTRY: &[Entry] = &[
    entry!(brute_force::BruteForce, brute_force::INFO),
    entry!(uniform_grid::UniformGrid, uniform_grid::INFO, prepare_tested, true),
    entry!(hashed_grid::HashedGrid, hashed_grid::INFO),
    entry!(compact_grid::CompactGrid, compact_grid::INFO),
    entry!(bricked_grid::BrickedGrid, bricked_grid::INFO),
    entry!(proximity_clouds::ProximityClouds, proximity_clouds::INFO),
    entry!(recursive_grid::RecursiveGrid, recursive_grid::INFO),
    entry!(hug::Hug, hug::INFO),
    entry!(two_level_grid::TwoLevelGrid, two_level_grid::INFO),
    entry!(adaptive_grid::AdaptiveGrid, adaptive_grid::INFO),
    entry!(irregular_grid::IrregularGrid, irregular_grid::INFO, prepare_compiled, false),
    entry!(octree::Octree, octree::INFO),
    entry!(kd_tree::KdTree, kd_tree::INFO, prepare_compiled, false),
    entry!(bounding_volumes::BoundingVolumes, bounding_volumes::INFO),
    entry!(kay_kajiya::KayKajiya, kay_kajiya::INFO),
    entry!(WideBvh, bvh::INFO, prepare_tested, true),
    entry!(instanced::InstancedGrid, instanced::GRID_INFO),
    entry!(instanced::InstancedBvh, instanced::BVH_INFO),
    entry!(obvhs::bvh2::ObvhsBvh2, obvhs::bvh2::INFO, prepare_compiled, false),
    entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO, prepare_compiled, true),
];

/// Structures that unit tests find by name, or through the light buffer. Each line compiles a
/// structure for all sets and queries: all of them, for unit tests alone, would double the compile
/// time of this crate. So tests that find others by name are in `tests/`.
#[cfg(test)]
pub static REGISTRY: &[Entry] =
    &[entry!(brute_force::BruteForce, brute_force::INFO), entry!(WideBvh, bvh::INFO)];

/// Parameters that every structure has.
pub const COMMON: &[ParamSpec] = &[time_segments::PARAM];

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
/// frame before, and boxed as a tracer. `COMPILED`: see [`Bound`](crate::query::tracer::Bound).
pub fn prepare<S: Scalar, T: Structure<S>, const COMPILED: bool>(
    params: &Params,
) -> PreparedStructure<S> {
    prepare_for::<S, T, COMPILED, false>(params)
}

/// [`prepare`] in f32, where queries are compiled into the traversal.
pub fn prepare_f32<T: Structure<f32>>(params: &Params) -> PreparedStructure<f32> {
    prepare::<f32, T, true>(params)
}

/// [`prepare_f32`] for a structure of which the queries of sets that move are compiled, too.
pub fn prepare_compiled<T: Structure<f32>>(params: &Params) -> PreparedStructure<f32> {
    prepare_for::<f32, T, true, true>(params)
}

fn prepare_for<S: Scalar, T: Structure<S>, const COMPILED: bool, const COMPILED_IN_MOTION: bool>(
    params: &Params,
) -> PreparedStructure<S> {
    let (settings, testing) = (Settings::of(params), TestChoice::of(params));
    let segments = time_segments::of(params);
    let refusal = testing.chosen.map(|_| Choice::refused(params, "default in this precision"));
    Box::new(move |prims, before| {
        if let Some(refusal) = &refusal {
            return Err(refusal.clone().into());
        }
        let how = (&settings, &testing);
        match prims {
            PrimsRef::Watertight(p) => tested_as::<S, _, T, COMPILED>(p, p, how, before),
            PrimsRef::Mixed(p) if p.has_motion() => {
                in_motion::<S, T, COMPILED_IN_MOTION>(p, how, segments)
            }
            PrimsRef::Mixed(p) => tested_as::<S, _, T, COMPILED>(p, p, how, before),
        }
    })
}

/// Builds `T` over a set that moves.
fn in_motion<'a, S: Scalar, T: Structure<S>, const COMPILED: bool>(
    set: &'a MixedSet<S>,
    (settings, testing): (&Settings<T::Config>, &TestChoice),
    segments: usize,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let mailbox = testing.mailbox(set, settings.limits())?;
    let segments = TimeSegments::<S, T>::build(set, settings, testing, segments)?;
    Ok(Box::new(BoundInMotion::<S, _, T, COMPILED>::new(set.in_motion(), segments, mailbox)))
}

/// [`prepare_compiled`] for a structure of which the tests in [`chosen_tests`] are compiled, too,
/// over primitives at rest. It is built over the set itself: the same one for every test.
pub fn prepare_tested<T: Structure<f32>>(params: &Params) -> PreparedStructure<f32> {
    let (settings, testing) = (Settings::of(params), TestChoice::of(params));
    let Some(choice) = testing.chosen else { return prepare_compiled::<T>(params) };
    let params = params.clone();
    Box::new(move |prims, before| {
        let how = (&settings, &testing);
        if testing.mailbox != mailbox::Choice::None {
            return Err(Choice::refused(&params, "default where there is a mailbox").into());
        }
        if params.get("query").is_some_and(|query| query != "one") {
            return Err(Choice::refused(&params, "default for batches").into());
        }
        if matches!(params.get("traversal"), Some("driving-axis" | "f64")) {
            return Err(Choice::refused(&params, "default with this traversal").into());
        }
        if matches!(prims, PrimsRef::Mixed(set) if set.has_motion()) {
            return Err(Choice::refused(&params, "default where primitives move").into());
        }
        let tested = Tested::<T> { prims, how, before };
        chosen_tests::visit_tested(prims, choice, tested).unwrap_or_else(|| {
            Err(Choice::refused(&params, "default, or f64 for both kinds of primitives").into())
        })
    })
}

/// A structure that is built over a set, and answers by the tests of the set that it is shown.
struct Tested<'a, 'h, 'b, T: Structure<f32>> {
    prims: PrimsRef<'a, f32>,
    how: (&'h Settings<T::Config>, &'h TestChoice),
    before: Option<PreviousFrame<'b>>,
}

impl<'a, T: Structure<f32>> TestedSetVisitor<'a> for Tested<'a, '_, '_, T> {
    type Output = Result<Box<dyn Tracer<f32> + 'a>, BuildError>;

    fn visit<P: PrimSet<f32>>(self, set: &'a P) -> Self::Output {
        tested_as::<f32, _, T, true>(self.prims.primitives(), set, self.how, self.before)
    }
}

/// A registry entry for a generic structure and its description: `entry!(my_tree::MyTree,
/// my_tree::INFO)`. The type's only parameter is its scalar; it is a
/// [`Structure`](crate::structure::Structure) in f32 and in f64. Of f64, which is an option, no
/// query is compiled into the traversal. Where more is compiled, the function that prepares it in
/// f32 follows, and whether queries in f64 are compiled, so that the price of double precision is
/// measured on them.
#[macro_export]
macro_rules! entry {
    ($structure:path, $info:path) => {
        $crate::entry!($structure, $info, prepare_f32, false)
    };
    ($structure:path, $info:path, $prepare_f32:ident, $is_compiled_in_f64:literal) => {
        $crate::structures::Entry::new(
            &$info,
            |params| {
                use $structure as It;
                $crate::structures::$prepare_f32::<It<f32>>(params)
            },
            |params| {
                use $structure as It;
                $crate::structures::prepare::<f64, It<f64>, $is_compiled_in_f64>(params)
            },
        )
    };
}
use entry;
