//! The cases, by what they are about; [`super::catalogue`] lists them.

mod prelude;

pub(super) mod cells;
pub(super) mod copies;
pub(super) mod crossings;
pub(super) mod crowds;
pub(super) mod edge_on;
pub(super) mod extreme_components;
pub(super) mod geometry;
pub(super) mod intervals;
pub(super) mod motion;
pub(super) mod nested_planes;
pub(super) mod normals;
pub(super) mod polygons;
pub(super) mod ray;
pub mod secondary;
pub(super) mod shadow_rays;
pub(super) mod shapes;
pub mod shells;
pub(super) mod symmetry;
