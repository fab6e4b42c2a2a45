//! The voxel traversal in f64, whatever the scalar of primitives and rays is.
//!
//! Paper: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics
//! 1987, as `voxel_traversal.rs` has it. Deviation: the planes are those of the grid in `S`, in
//! f64; only the parameter at which a cell is left is rounded back.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};

/// A ray on its way through a grid.
#[derive(Debug, Clone, Copy)]
pub struct DoubleTraversal(VoxelTraversal<f64>);

impl DoubleTraversal {
    /// Starts a traversal at parameter `t_start`; `frame` is [`GridFrame::in_double`] of the
    /// grid's.
    #[inline(always)]
    pub fn from<S: Scalar>(frame: &GridFrame<f64>, ray: &Ray<S>, t_start: S) -> Option<Self> {
        let wide = Ray {
            origin: ray.origin.to_dvec3(),
            direction: ray.direction.to_dvec3(),
            t_min: ray.t_min.to_f64(),
            t_max: ray.t_max.to_f64(),
            time: ray.time.to_f64(),
        };
        frame.traversal_from(&wide, t_start.to_f64()).map(Self)
    }
}

impl CellPosition for DoubleTraversal {
    #[inline(always)]
    fn index(&self) -> usize {
        self.0.index()
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        self.0.coords()
    }
}

impl<S: Scalar> CellTraversal<S> for DoubleTraversal {
    #[inline(always)]
    fn t_exit(&self) -> S {
        S::from_f64(CellTraversal::<f64>::t_exit(&self.0))
    }

    #[inline(always)]
    fn advance(&mut self) -> bool {
        CellTraversal::<f64>::advance(&mut self.0)
    }
}
