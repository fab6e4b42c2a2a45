//! A hierarchy of slab volumes, traversed with a priority queue.
//!
//! Paper: T. L. Kay, J. T. Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986: volumes between
//! parallel planes of a few fixed directions, a hierarchy made by median cuts, and a traversal that
//! always goes on with the volume the ray enters first, so that it may stop as soon as the next
//! entry lies beyond the nearest hit. A ray's dot products with the directions are computed once.
//!
//! Deviations: a cut halves along the axis on which the centres of boxes spread most; leaves may
//! hold several primitives and nodes have up to 2, 4 or 8 children (cuts of cuts); the diagonals
//! are not of unit length, and volumes are padded (see `bounding_volumes/slabs.rs`); the queue
//! lives on the stack until it outgrows its room.
//!
//! Counters: a node taken from the queue is a step, an elementary one if it is a leaf; nodes that
//! were tested and missed, or were left in the queue, are none.

mod entry_queue;
mod hierarchy;

use self::hierarchy::{Hierarchy, KayKajiyaConfig};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::historical::bounds_rule::BoundsRule;
use crate::params::config::Settings;
use crate::primitives::Primitives;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats, bounds_of};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Kay, Kajiya 1986",
    deviations: "cuts on the axis of widest spread; leaves and branching of any size; padded",
    params: KayKajiyaConfig::PARAMS,
    also_tested: &[
        "leaf-size=4 branching=4",
        "directions=3",
        "directions=4 branching=8",
        "leaf-size=16",
        "kernel=block leaf-size=8",
    ],
    ..StructureInfo::new(
        "kay-kajiya",
        "hierarchy of slab volumes, nearest entry first by a priority queue",
    )
};

/// A hierarchy of slab volumes.
pub struct KayKajiya<S: Scalar> {
    hierarchy: ByDirections<S>,
}

/// By the number of directions.
enum ByDirections<S: Scalar> {
    Three(Hierarchy<S, 3>),
    Four(Hierarchy<S, 4>),
    Seven(Hierarchy<S, 7>),
}

/// The value of an expression over the hierarchy, whatever the number of directions.
macro_rules! of_hierarchy {
    ($this:ident, $hierarchy:ident => $value:expr) => {
        match &$this.hierarchy {
            ByDirections::Three($hierarchy) => $value,
            ByDirections::Four($hierarchy) => $value,
            ByDirections::Seven($hierarchy) => $value,
        }
    };
}

impl<S: Scalar> Structure<S> for KayKajiya<S> {
    const HAS_LISTS: bool = true;
    const DUPLICATES: bool = false;

    type Config = KayKajiyaConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<KayKajiyaConfig>,
    ) -> Result<Self, BuildError> {
        let boxes = bounds_of(prims, BoundsRule::Padded, settings.structure())?;
        let hierarchy = match settings.directions {
            3 => ByDirections::Three(Hierarchy::new(&boxes, settings)?),
            4 => ByDirections::Four(Hierarchy::new(&boxes, settings)?),
            _ => ByDirections::Seven(Hierarchy::new(&boxes, settings)?),
        };
        Ok(Self { hierarchy })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        of_hierarchy!(self, hierarchy => hierarchy.traverse(ray, sink))
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        of_hierarchy!(self, hierarchy => hierarchy.lists().for_each(each))
    }

    fn stats(&self) -> StructureStats {
        of_hierarchy!(self, hierarchy => hierarchy.stats())
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        of_hierarchy!(self, hierarchy => hierarchy.show(each));
        Ok(())
    }
}
