//! Parts of grids: frames, traversals, cell lists, resolution rules, placement of boxes.

pub(crate) mod block_lists;
pub mod cell_lists;
pub mod cell_overlap;
pub mod cell_traversal;
pub(crate) mod changed_cells;
pub(crate) mod copies;
pub mod distance_field;
pub mod driving_axis_traversal;
pub(crate) mod nested_grids;
pub mod regular_grid;
pub mod resolution;
mod sort_in_parts;
pub mod voxel_traversal;
mod voxel_traversal_lanes;
