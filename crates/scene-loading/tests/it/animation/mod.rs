//! Scenes that move.

mod claims;
mod generated;
