//! Deliberately inexact or slow variants (accuracy study only).

pub mod chosen_tests;
pub mod sphere_tests;
pub mod triangle_tests;
pub mod voxel_traversals;
