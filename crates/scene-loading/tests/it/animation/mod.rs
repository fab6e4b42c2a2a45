//! Scenes that move.

mod claims;
mod files;
mod generated;
mod gltf;
