//! Oracles of geometry: where lines meet triangles, by exact signs, and numbers of twice the digits
//! of f64. `verify` judges structures and tests of primitives by them, so no code is shared with
//! `accel-core`.

pub mod double_double;
pub mod triangles;
