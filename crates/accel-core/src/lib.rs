//! Geometry, primitives and acceleration structures.
