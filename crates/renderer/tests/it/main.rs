//! The integration tests of the renderer, one binary: each further one costs a link.

mod beam;
mod common;
mod cone;
mod convergence;
mod flat_scenes;
mod gating;
mod hard_cases;
mod instances;
mod same_image;
