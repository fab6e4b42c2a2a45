//! Scalars, vectors, rays and boxes.

pub mod aabb;
pub mod box_test;
pub mod far_ray;
pub mod lanes;
pub mod ray;
pub mod ray_lanes;
pub mod scalar;
#[cfg(test)]
#[path = "../../tests/toy/mod.rs"]
mod toy;
