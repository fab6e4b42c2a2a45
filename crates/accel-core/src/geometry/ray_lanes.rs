//! Eight rays by axis and lane, for what is derived from all of them at once.

use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{EightOf, Scalar, Vector};

/// Rays of a group.
pub const LANES: usize = 8;

/// Their parts.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct RayLanes<S> {
    /// By axis.
    pub origin: [[S; LANES]; 3],
    /// By axis.
    pub direction: [[S; LANES]; 3],
    /// Smallest accepted parameters.
    pub t_min: [S; LANES],
    /// Largest accepted parameters.
    pub t_max: [S; LANES],
}

impl<S: Scalar> RayLanes<S> {
    /// Of these rays.
    #[inline(always)]
    pub fn of(rays: &[Ray<S>; LANES]) -> Self {
        let mut rows = [[S::ZERO; LANES]; LANES];
        for (row, ray) in rows.iter_mut().zip(rays) {
            let ([x, y, z], [dx, dy, dz]) = (ray.origin.to_array(), ray.direction.to_array());
            *row = [x, y, z, dx, dy, dz, ray.t_min, ray.t_max];
        }
        let columns = EightOf::<S>::transposed(rows.map(EightOf::<S>::new));
        let [x, y, z, dx, dy, dz, t_min, t_max] = columns.map(EightOf::<S>::to_array);
        Self { origin: [x, y, z], direction: [dx, dy, dz], t_min, t_max }
    }
}
