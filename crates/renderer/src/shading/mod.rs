//! Surfaces where rays meet them, and the rays that leave them.

pub mod foot;
pub mod leaving;
pub mod surface;
