//! Structures from one frame of an animation to the next.
//!
//! A frame is a set of primitives at rest. Where two frames have the same primitives, under the
//! same ids at other places, a structure may be taken from one to the other
//! ([`Structure::update`](crate::structure::Structure::update)) in less time than building it anew
//! takes: a BVH by new boxes for its nodes, a grid by new lists for the cells that something left
//! or entered, a structure of two levels by building the upper one alone. I. Wald, W. R. Mark, J.
//! Guenther, S. Boulos, T. Ize, W. Hunt, S. G. Parker, P. Shirley, "State of the Art in Ray Tracing
//! Animated Scenes", Computer Graphics Forum 28(6), 2009, has what is known of these.

use crate::geometry::scalar::Scalar;
use crate::params::{ParamSpec, Params};
use crate::primitives::Primitives;

/// The setting of a structure that can be refitted; of no effect on a scene at rest.
pub const REFIT: ParamSpec = ParamSpec::choice("update", REBUILD, &[REBUILD, "refit"])
    .about("between frames: built anew, or boxes alone are (built anew as rebuild-at says)");

/// The setting of a grid whose lists can be changed cell by cell; of no effect on a scene at rest.
pub const INCREMENTAL: ParamSpec = ParamSpec::choice("update", REBUILD, &[REBUILD, "incremental"])
    .about(
        "between frames: built anew, or the lists alone that something moved into or out of (built \
              anew where the grid's box or resolution changes, or most primitives move)",
    );

/// The setting of a structure of two levels; of no effect on a scene at rest.
pub const INSTANCES: ParamSpec = ParamSpec::choice("update", REBUILD, &[REBUILD, "instances"]).about("between frames: built anew, or the upper level alone is, over rigid parts where they stand now");

const REBUILD: &str = "rebuild";

/// With `update=refit`: the factor by which the expected cost may grow before the tree is rebuilt.
pub(crate) fn refitted_until(params: &Params) -> Option<f64> {
    (params.get(REFIT.name) == Some("refit")).then(|| params.real(REBUILD_AT.name))
}

/// Returns whether the upper level alone is to be made anew.
pub(crate) fn is_by_instances(params: &Params) -> bool {
    params.get(INSTANCES.name) == Some("instances")
}

/// Returns whether lists are to be changed cell by cell.
pub(crate) fn is_incremental(params: &Params) -> bool {
    params.get(INCREMENTAL.name) == Some("incremental")
}

/// Returns whether lists are to be changed where so many of the primitives moved: of most, a build
/// is no more work.
pub(crate) fn is_worth_changing(moved: usize, primitives: usize) -> bool {
    moved <= primitives / 2
}

/// When a refitted tree is built anew.
pub const REBUILD_AT: ParamSpec = ParamSpec::real("rebuild-at", "1.5", 1.0, 1e9).about("of update=refit: a tree is built anew where its expected cost exceeds so many times that of the \
              tree built last");

/// Result of [`Structure::update`](crate::structure::Structure::update).
#[derive(Debug)]
pub enum Change {
    /// It was built anew.
    Rebuilt,
    Updated,
    /// The lists of some cells were changed, and stand elsewhere now.
    Lists(ChangedLists),
}

/// Lists that changed in an update, by their numbers in the order of
/// [`Structure::lists`](crate::structure::Structure::lists).
#[derive(Debug)]
pub struct ChangedLists {
    /// Former start of each list in the array of all lists, and the end of the last one.
    pub(crate) before: Vec<u32>,
    /// Numbers of those that have lost or gained a primitive, or hold one that moved; ascending.
    pub(crate) changed: Vec<u32>,
}

impl ChangedLists {
    /// Returns whether a list held a primitive before.
    pub(crate) fn had_ids(&self, number: usize) -> bool {
        self.before.get(number + 1).is_some_and(|end| self.before[number] < *end)
    }
}

/// The primitives of `after` that are not those of `before` under the same ids: others by kind, by
/// a vertex or by a radius. None where the sets are of different lengths.
pub fn moved<S: Scalar>(before: &dyn Primitives<S>, after: &dyn Primitives<S>) -> Option<Vec<u32>> {
    if before.len() != after.len() {
        return None;
    }
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let mut has_moved = |id: u32| {
        if before.is_opaque(id) != after.is_opaque(id) {
            return true;
        }
        if let (Some(before), Some(after)) = (before.corners(id), after.corners(id)) {
            return before != after;
        }
        a.clear();
        b.clear();
        before.hull(id, &mut a);
        after.hull(id, &mut b);
        before.kind(id) != after.kind(id) || a != b
    };
    Some((0..before.len() as u32).filter(|&id| has_moved(id)).collect())
}
