//! The binary tree that is collapsed: binned from the top down, over clusters in Morton order, or
//! agglomerated by obvhs.

pub(crate) mod agglomerated;
pub(super) mod binned;
mod boxes;
mod cut;
pub(super) mod morton;
mod sets;

pub(super) const BINNED: &str = "binned";
pub(super) const MORTON: &str = "morton";

/// Names of the builders: ours, then obvhs's presets.
pub(super) const BUILDS: &[&str] =
    &[BINNED, MORTON, "fastest", "very-fast", "fast", "medium", "slow", "very-slow"];

/// Names of obvhs's build presets ([`agglomerated::preset_named`]).
pub(crate) const PRESETS: &[&str] = BUILDS.split_at(2).1;
