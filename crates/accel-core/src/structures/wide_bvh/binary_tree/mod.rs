//! The binary tree that is collapsed, where obvhs does not build it.

pub(super) mod binned;
mod boxes;
mod cut;
pub(super) mod morton;
mod sets;
