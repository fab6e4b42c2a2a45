//! What is wrong or dear on purpose: for the accuracy study only.

pub mod accumulating_traversal;
pub mod chosen_tests;
#[cfg(feature = "compiled-tests")]
pub mod compiled_tests;
pub mod double_traversal;
pub mod sphere_tests;
pub mod triangle_tests;
