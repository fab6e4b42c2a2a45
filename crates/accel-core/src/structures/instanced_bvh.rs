//! A BVH over BVHs: an eight-wide tree over the boxes of copies, and one over each object.
//!
//! See [`crate::structures::instanced`] for the levels and [`crate::bvh`] for the
//! trees.

use crate::bvh::{self, WideBvh};
use crate::geometry::scalar::Scalar;
use crate::params::Params;
use crate::structure::StructureInfo;
use crate::structures::instanced::{InstancedStructure, Levels};
use crate::structures::obvhs::PRESET;
use crate::update::INSTANCES;

pub static INFO: StructureInfo = StructureInfo {
    paper: "Rubin, Whitted 1980; Wald, Benthin, Slusallek 2003",
    deviations: "objects in the space of their first copy; primitives are tested in the world, one by one",
    params: &[PRESET, INSTANCES],
    variants: &[],
    also_tested: &["", "preset=fastest"],
    ..StructureInfo::new(
        "instanced-bvh",
        "a BVH over copies of objects, which have BVHs of their own",
    )
};

/// A BVH over BVHs.
pub type InstancedBvh<S> = InstancedStructure<S, WideBvh<S>>;

impl<S: Scalar> Levels<S> for WideBvh<S> {
    fn settings(params: &Params) -> [Params; 2] {
        ["1", "4"].map(|leaf| {
            let own = [(PRESET.name, params.text(PRESET.name)), ("max-leaf", leaf)];
            bvh::INFO.defaults().taken(own)
        })
    }
}
