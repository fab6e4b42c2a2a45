//! The walk of a ray through a regular grid of voxels by t_next stepping.
//!
//! Paper: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics
//! 1987. Deviation: the parameter of the next plane is not accumulated (t += dt drifts by up to tens
//! of cells on long walks) but recomputed from the plane's index, so that its error
//! does not grow with the number of steps.

use crate::aabb::Aabb;
use crate::ray::Ray;
use crate::scalar::{Scalar, Vec3, Vector};

/// Where the cells of a regular grid are.
#[derive(Debug, Clone, Copy)]
pub struct GridFrame<S: Scalar> {
    bounds: Aabb<S>,
    lo: [S; 3],
    cell: [S; 3],
    inv_cell: [S; 3],
    n: [i32; 3],
}

impl<S: Scalar> GridFrame<S> {
    /// Divides `bounds` into `n` cells an axis; every axis of `bounds` must have a length > 0 and
    /// `n` at most [`crate::resolution::MAX_PER_AXIS`].
    pub fn new(bounds: Aabb<S>, n: [u32; 3]) -> Self {
        let (lo, size) = (bounds.min.to_array(), bounds.size().to_array());
        let mut cell = [S::ONE; 3];
        let mut inv_cell = [S::ONE; 3];
        for k in 0..3 {
            cell[k] = size[k] / S::from_i32(n[k] as i32);
            inv_cell[k] = S::ONE / cell[k];
        }
        Self { bounds, lo, cell, inv_cell, n: n.map(|n| n as i32) }
    }

    /// Cells an axis.
    pub fn resolution(&self) -> [u32; 3] {
        self.n.map(|n| n as u32)
    }

    /// The divided box.
    pub fn bounds(&self) -> Aabb<S> {
        self.bounds
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.n.iter().map(|&n| n as usize).product()
    }

    /// The first and last cell an axis that `b` touches, clamped to the grid.
    #[inline(always)]
    pub fn range(&self, b: &Aabb<S>) -> ([i32; 3], [i32; 3]) {
        let (lo, hi) = (b.min.to_array(), b.max.to_array());
        let mut first = [0; 3];
        let mut last = [0; 3];
        for k in 0..3 {
            first[k] = self.clamped((lo[k] - self.lo[k]) * self.inv_cell[k], k);
            last[k] = self.clamped((hi[k] - self.lo[k]) * self.inv_cell[k], k);
        }
        (first, last)
    }

    /// [`GridFrame::range`] with a division in place of the product by the inverse, as
    /// floor((x - lo) / cell) was computed in 1999: it decides differently on cell planes.
    pub fn range_by_division(&self, b: &Aabb<S>) -> ([i32; 3], [i32; 3]) {
        let (lo, hi) = (b.min.to_array(), b.max.to_array());
        let mut first = [0; 3];
        let mut last = [0; 3];
        for k in 0..3 {
            first[k] = self.clamped((lo[k] - self.lo[k]) / self.cell[k], k);
            last[k] = self.clamped((hi[k] - self.lo[k]) / self.cell[k], k);
        }
        (first, last)
    }

    /// Truncation equals floor here: what is below 0 is clamped to 0 anyway.
    #[inline(always)]
    fn clamped(&self, x: S, axis: usize) -> i32 {
        x.to_i32().clamp(0, self.n[axis] - 1)
    }

    /// The box of the cell with an index.
    pub fn cell_box(&self, index: usize) -> Aabb<S> {
        let (nx, ny) = (self.n[0] as usize, self.n[1] as usize);
        let c = [index % nx, index / nx % ny, index / nx / ny];
        let plane = |k: usize, c: usize| self.lo[k] + S::from_i32(c as i32) * self.cell[k];
        let corner = |d: usize| Vec3::<S>::from_array([0, 1, 2].map(|k| plane(k, c[k] + d)));
        Aabb { min: corner(0), max: corner(1) }
    }

    /// Index of a cell, x fastest.
    #[inline(always)]
    pub fn index(&self, c: [i32; 3]) -> usize {
        (c[2] as usize * self.n[1] as usize + c[1] as usize) * self.n[0] as usize + c[0] as usize
    }

    /// Starts a walk, or `None` when the ray misses the box within its interval.
    #[inline(always)]
    pub fn walk(&self, ray: &Ray<S>) -> Option<VoxelWalk<S>> {
        self.walk_from(ray, ray.t_min)
    }

    /// Starts a walk at parameter `t_start` in place of the ray's `t_min`.
    #[inline(always)]
    pub fn walk_from(&self, ray: &Ray<S>, t_start: S) -> Option<VoxelWalk<S>> {
        let (t_in, _) = self.bounds.clip(ray.origin, ray.direction, t_start, ray.t_max)?;
        let o = ray.origin.to_array();
        let d = ray.direction.to_array();
        let p = ray.at(t_in).to_array();
        let stride = [1, self.n[0] as isize, self.n[0] as isize * self.n[1] as isize];
        let mut walk = VoxelWalk {
            t_next: [S::INFINITY; 3],
            plane: [S::ZERO; 3],
            plane_step: [S::ZERO; 3],
            cell: self.cell,
            from_origin: [S::ZERO; 3],
            inv_d: [S::INFINITY; 3],
            remaining: [0; 3],
            stride: [0; 3],
            offset: 0,
        };
        let mut at = [0; 3];
        for k in 0..3 {
            at[k] = self.clamped((p[k] - self.lo[k]) * self.inv_cell[k], k);
            if d[k] == S::ZERO {
                continue;
            }
            let up = d[k] > S::ZERO;
            walk.inv_d[k] = S::ONE / d[k];
            walk.from_origin[k] = self.lo[k] - o[k];
            walk.plane[k] = S::from_i32(at[k] + i32::from(up));
            walk.plane_step[k] = if up { S::ONE } else { -S::ONE };
            walk.remaining[k] = if up { self.n[k] - 1 - at[k] } else { at[k] };
            walk.stride[k] = if up { stride[k] } else { -stride[k] };
            walk.t_next[k] = walk.plane_parameter(k);
        }
        walk.offset = self.index(at) as isize;
        Some(walk)
    }
}

/// A ray on its way through a grid.
#[derive(Debug, Clone, Copy)]
pub struct VoxelWalk<S: Scalar> {
    /// Parameter at which the next plane of each axis is met.
    t_next: [S; 3],
    /// Index of that plane.
    plane: [S; 3],
    plane_step: [S; 3],
    cell: [S; 3],
    /// Lower corner of the grid minus the ray's origin.
    from_origin: [S; 3],
    inv_d: [S; 3],
    /// Cells left in the direction of each axis.
    remaining: [i32; 3],
    stride: [isize; 3],
    offset: isize,
}

impl<S: Scalar> VoxelWalk<S> {
    #[inline(always)]
    fn plane_parameter(&self, k: usize) -> S {
        (self.plane[k] * self.cell[k] + self.from_origin[k]) * self.inv_d[k]
    }

    /// Index of the current cell, x fastest.
    #[inline(always)]
    pub fn index(&self) -> usize {
        self.offset as usize
    }

    /// The axis whose plane is met first; of equal ones the lowest.
    #[inline(always)]
    fn axis(&self) -> usize {
        let [x, y, z] = self.t_next;
        let (k, t) = if y < x { (1, y) } else { (0, x) };
        if z < t { 2 } else { k }
    }

    /// Parameter at which the ray leaves the current cell.
    #[inline(always)]
    pub fn t_exit(&self) -> S {
        self.t_next[self.axis()]
    }

    /// Steps to the next cell; false when that would leave the grid.
    #[inline(always)]
    pub fn advance(&mut self) -> bool {
        let k = self.axis();
        if self.remaining[k] == 0 {
            return false;
        }
        self.remaining[k] -= 1;
        self.offset += self.stride[k];
        self.plane[k] += self.plane_step[k];
        self.t_next[k] = self.plane_parameter(k);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells_of(frame: &GridFrame<f64>, ray: &Ray<f64>) -> Vec<usize> {
        let mut out = Vec::new();
        if let Some(mut w) = frame.walk(ray) {
            out.push(w.index());
            while w.advance() {
                out.push(w.index());
            }
        }
        out
    }

    fn unit_frame(n: u32) -> GridFrame<f64> {
        let bounds = Aabb { min: glam::DVec3::ZERO, max: glam::DVec3::splat(f64::from(n)) };
        GridFrame::new(bounds, [n; 3])
    }

    #[test]
    fn visits_exactly_the_pierced_cells() {
        let n = 16;
        let frame = unit_frame(n);
        let mut state = 12345u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        for _ in 0..2000 {
            let o = glam::DVec3::new(random(), random(), random()) * 48.0 - 16.0;
            let target = glam::DVec3::new(random(), random(), random()) * f64::from(n);
            let ray = Ray::<f64>::new(o, target - o);
            let visited = cells_of(&frame, &ray);
            // oracle: every cell whose box the ray crosses by more than rounding
            let mut pierced = 0;
            for i in 0..frame.cells() {
                let c = [i % 16, i / 16 % 16, i / 256];
                let lo = glam::DVec3::new(c[0] as f64, c[1] as f64, c[2] as f64);
                let b = Aabb::<f64> { min: lo, max: lo + 1.0 };
                if let Some((a, z)) = b.clip(ray.origin, ray.direction, 0.0, f64::INFINITY)
                    && z - a > 1e-9
                {
                    pierced += 1;
                    assert!(visited.contains(&i), "{ray:?} misses cell {c:?}");
                }
            }
            assert!(visited.len() <= pierced + 3, "{} for {pierced}", visited.len());
        }
    }

    #[test]
    fn axis_parallel_rays_and_rays_in_cell_planes_end() {
        let frame = unit_frame(8);
        for k in 0..3 {
            for sign in [1.0, -1.0] {
                for zero in [0.0, -0.0] {
                    let mut d = [zero; 3];
                    d[k] = sign;
                    let mut o = [4.0; 3];
                    o[k] = if sign > 0.0 { -3.0 } else { 11.0 };
                    let ray = Ray::<f64>::new(o.into(), d.into());
                    assert_eq!(cells_of(&frame, &ray).len(), 8);
                }
            }
        }
    }

    #[test]
    fn an_origin_far_away_is_clamped_into_the_grid() {
        // HARD_CASES T4
        let frame = unit_frame(8);
        let ray = Ray::<f64>::new([-1e9, 8.0, 8.0].into(), [1.0, 0.0, 0.0].into());
        let cells = cells_of(&frame, &ray);
        assert_eq!(cells.len(), 8);
        assert!(cells.iter().all(|&c| c < frame.cells()));
    }
}
