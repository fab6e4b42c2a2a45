//! Deliberately inexact or slow variants (accuracy study only).

pub mod accumulating_traversal;
pub mod chosen_tests;
pub mod double_traversal;
pub mod sphere_tests;
pub mod triangle_tests;
