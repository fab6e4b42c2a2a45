//! The binary tree that is collapsed: binned from the top down, over clusters in Morton order, or
//! agglomerated by obvhs.

pub(crate) mod agglomerated;
pub(super) mod binned;
mod boxes;
mod cut;
pub(super) mod morton;
mod sets;
