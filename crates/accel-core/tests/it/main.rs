//! Tests of the crate from outside, in one program: each structure is compiled and linked once.

mod agreement;
mod caps;
mod cells;
mod common;
mod contributing;
mod differential;
mod duplicates;
mod edge_on;
mod frames;
mod instances;
mod leaving_faces;
mod memory;
mod motion;
mod nested_grids;
mod obvhs;
mod obvhs_direct;
mod octree_and_kd_tree;
mod planes_of_cells;
mod threads;
mod time_segments;
mod volumes;
