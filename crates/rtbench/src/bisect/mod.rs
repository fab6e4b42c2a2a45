//! The commit that made something slower: commits between a good one and a bad one are built in a tree of files of
//! their own, and each is measured in turns with the good one, as `check --against` does.
//!
//! A commit is bad if a time of it is certainly longer than the good one's by more than the threshold, found twice;
//! good if that is certainly not so; what stays uncertain with more rounds, or cannot be built, is skipped, as
//! `git bisect skip` does, and its neighbours are asked.

mod error;
mod judge;
mod rows;
mod search;
mod trees;

pub use error::BisectError;
pub use judge::{Judge, Judged, Verdict};
pub use rows::{BisectRow, Chosen};
pub use search::{Found, search};
pub use trees::{Recipe, Trees, between};
