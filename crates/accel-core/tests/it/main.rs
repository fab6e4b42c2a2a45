//! Tests of the crate from outside, in one program: each structure is compiled and linked once.

mod agreement;
mod builders;
mod caps;
mod cells;
mod chosen_tests;
mod common;
mod contributing;
mod differential;
mod duplicates;
mod edge_on;
mod far_intervals;
mod frames;
mod grids;
mod instances;
/// The exact cells of a ray, which the study of accuracy has, too.
#[path = "../../../studies/src/accuracy/integer_ray.rs"]
mod integer_ray;
mod leaving_faces;
mod lines_of_registries;
mod mailbox_numbers;
mod mailboxes;
mod memory;
mod motion;
mod nested_grids;
mod obvhs;
mod obvhs_direct;
mod octree_and_kd_tree;
mod packets;
mod planes_of_cells;
mod polygons;
mod proofs;
mod recursive_grid;
/// Scenes and rays that unit tests have, too. They name what they need as seen from the crate.
#[path = "../../src/structures/test_scenes.rs"]
mod test_scenes;
mod threads;
mod tightness;
mod time_segments;
mod volumes;
mod voxel_traversals;

use accel_core::{geometry, primitives, query};
