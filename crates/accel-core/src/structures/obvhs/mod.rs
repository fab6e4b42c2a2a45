//! Bounding volume hierarchies of the crate `obvhs` 0.4, as its authors use them; their settings and
//! defects.
//!
//! A row by its plain name is the library as its authors use it (`direct.rs`). As such, its CwBvh
//! loses every hit of a ray with a -0.0 direction component and every hit nearer than t = 1e-4;
//! both of its BVHs cap 1/0 at 2^23, so that a ray parallel to a face "leaves" small far boxes;
//! neither knows of hits at negative t; a NaN box gives wrong results or a panic, and tens of
//! thousands of coincident centroids a quadratic build or a stack overflow. Its lengths are
//! absolute: long directions and large scenes overflow, short ones drown in its epsilons.
//!
//! `adapter=robust`, of its CwBvh, shows what it takes to have right answers all the same: it tells
//! the library everything in units of the scene's size (powers of two, so that nothing is rounded),
//! adds +0.0 to the direction, sets reciprocals itself, starts the box tests a little before the
//! ray's origin, or where an interval begins that begins before it, pads boxes, refuses what is not
//! finite, and groups primitives with the same centre: `bvh/node.rs` and `bvh/items.rs`.

mod builder;
pub mod bvh2;
pub mod cwbvh;
mod direct;
mod leaf_blocks;

use crate::bvh::build::PRESETS;
use crate::params::ParamSpec;

pub(crate) const PRESET: ParamSpec =
    ParamSpec::choice("preset", "medium", PRESETS).about("obvhs's build preset");

/// Chooses who sets up rays and tests primitives.
pub(crate) const ADAPTER: ParamSpec = ParamSpec::choice("adapter", "direct", &["direct", "robust"])
    .about(
        "direct is obvhs as its authors use it: its triangles, its test, its traversal (f32, \
         triangles alone; others are tested by ours in its callback); robust gives right answers",
    );

/// Triangles one by one, or in blocks.
pub(crate) const KERNEL: ParamSpec = ParamSpec::choice("kernel", "block", &["scalar", "block"])
    .about(
        "of adapter=robust, over triangles: block: those of a node's leaves in blocks of eight, \
         tested at once, the faster in every scene measured; scalar: one by one, by their ids",
    );

pub(crate) const DEVIATIONS: &str = "library code as its authors use it; a depth limit";

pub(crate) const DIRECT_DEFECT: &str = "obvhs as its authors use it loses hits at edges of \
                                        triangles, of rays with -0.0 components, near hits, hits \
                                        at negative t and far small boxes; of equal hits it takes \
                                        any";
