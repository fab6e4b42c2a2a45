//! Structures that come out of shared libraries, over the C interface `include/rtbench.h`.
//!
//! A plugin becomes a line of the registry of structures ([`entry`]). Its rows are measured as all
//! others are: the same rays in the same rounds, and every answer compared. By default a plugin
//! runs in a separate process ([`serve`] is what that one does), so that a crash, a hang or a
//! wild write costs its row and nothing else. Triangles, rays and answers are in shared memory; the
//! child reads the clock right before and after each call of the plugin, so that the way there and
//! back is in no time.

// What a plugin says can make nothing panic here.
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

pub mod abi;
mod description;
pub mod files;
mod instance;
mod library;
#[cfg_attr(not(unix), allow(dead_code))]
mod memory_watch;
mod near_rays;
mod registry;
#[cfg_attr(not(unix), allow(dead_code, unused_imports))]
mod remote;
#[cfg_attr(not(unix), allow(dead_code, unused_imports))]
mod serve;
#[cfg_attr(not(unix), allow(dead_code))]
mod shared;
mod stopwatch;
mod tracer;
#[cfg_attr(not(unix), allow(dead_code))]
mod wire;

pub use library::PluginError;
pub use registry::entry;
pub use serve::serve;
pub use wire::Options;
