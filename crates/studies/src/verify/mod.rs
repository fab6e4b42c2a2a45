//! Do structures stay right on the hard cases? The catalogue as a registry, its oracles, and the
//! machinery that asks every structure and can repeat any single trial.
//!
//! The way of a check: [`catalogue`] (one line per case) -> a case draws a [`round::Round`] from a
//! seed: a scene, rays, and what its oracle expects of them -> [`judge`] asks a
//! [`subject::Subject`] and compares, with the oracle and with brute force -> [`report`]. A
//! [`replay::Replay`] names one trial, [`shrink`] reduces it to few triangles and a ray.

pub mod among_triangles;
mod answers;
pub mod cases;
pub mod catalogue;
pub mod check;
pub mod closed_form;
pub mod draw;
pub mod every_hit;
pub mod judge;
pub mod meshes;
mod mismatch;
pub mod replay;
pub mod report;
mod reproducer;
pub mod round;
pub mod shrink;
pub mod subject;
pub mod surface;
