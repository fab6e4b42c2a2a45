//! Clusters of boxes: groups of primitives that deserve a grid of their own.
//!
//! * [`components`]: connected components of boxes closer than a gap (for HUG).
//! * [`agglomerate`]: repeated merging of the pair whose joint box wastes least (for adaptive
//!   grids).
//! * [`box_tree`]: the tree of boxes that both searches need to be fast.

pub mod agglomerate;
pub mod box_tree;
pub mod components;
