//! Surfaces where rays meet them, and the rays that leave them.

pub mod ray_offset;
pub mod refined_hit;
pub mod surface;
