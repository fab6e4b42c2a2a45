//! Scenes that move.

mod aff;
mod claims;
mod files;
mod generated;
mod gltf;
