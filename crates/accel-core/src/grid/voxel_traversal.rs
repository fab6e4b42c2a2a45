//! The traversal of a ray through a regular grid of voxels by t_next stepping.
//!
//! Paper: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics
//! 1987. Deviation: the parameter of the next plane is not accumulated (t += dt drifts by up to
//! tens of cells on long traversals) but recomputed from the plane's index, so that its error does
//! not grow with the number of steps.
//!
//! What is guaranteed, in the scalar of the traversal and to the ray's end: the part of the ray
//! between the exits of two successive cells lies within the second of them, grown by an error that
//! is independent of the number of steps. Three roundings of positions (plane, from_origin, their
//! sum) and two of factors (1 / direction, the product with it) keep a plane within 22 epsilon of
//! the scene's largest coordinate of where it is met (`proofs/voxel_planes.gappa`), for rays that
//! start within 8 magnitudes (`far_ray.rs`). Boxes are inserted padded by 64 of the same (`bounds_rule.rs`). So a cell may be
//! passed by whose corner or edge the ray cuts by less, never a primitive: what the ray meets in
//! that cell is listed in the cells before or after it as well, and those are not left before the
//! parameter of the hit. `rtbench verify --cases T1,T3,T4` compares both traversals with exact
//! integers.
//!
//! **Grids within cells.** The traversal of an inner grid has planes, and roundings, of its own. A
//! ray nearly within a side of the outer cell leaves an inner grid of exactly that box, by one
//! rounding, at any parameter, and what the rest of the cell holds is passed by while the outer
//! traversal, by another rounding, is still there. So an inner grid is that of the cell grown by
//! the padding of boxes. Between the cell's entry and exit the ray is within 22 epsilon of the
//! cell, so within the inner grid's box by 42 on every axis; the inner traversal, off by another
//! 22, does not leave that box before the outer one leaves the cell. Two rules follow for whoever
//! traverses both: a hit before an inner exit ends the inner traversal alone, for beyond the outer
//! exit only the outer lists are complete; and an inner traversal starts where the cell is entered,
//! but never before the outer traversal did, for planes beside the ray may be met at any parameter,
//! even an infinite one.

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::grid::cell_traversal::{CellPosition, CellTraversal, GridCell};

/// Position and size of the cells of a regular grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridFrame<S: Scalar> {
    bounds: Aabb<S>,
    lo: [S; 3],
    cell: [S; 3],
    inv_cell: [S; 3],
    n: [i32; 3],
}

impl<S: Scalar> GridFrame<S> {
    /// Divides `bounds` into `n` cells per axis; every axis of `bounds` must have a length > 0 and
    /// `n` at most [`crate::grid::resolution::MAX_PER_AXIS`].
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

    pub fn resolution(&self) -> [u32; 3] {
        self.n.map(|n| n as u32)
    }

    pub fn bounds(&self) -> Aabb<S> {
        self.bounds
    }

    pub fn cells(&self) -> usize {
        self.n.iter().map(|&n| n as usize).product()
    }

    /// The first and last cell per axis that `b` touches, clamped to the grid.
    #[inline(always)]
    pub fn range(&self, b: &Aabb<S>) -> ([i32; 3], [i32; 3]) {
        self.range_by(b, |from_low, k| from_low * self.inv_cell[k])
    }

    /// [`GridFrame::range`] with a division in place of the product by the inverse, as
    /// floor((x - lo) / cell) was computed in 1999: it decides differently on cell planes.
    pub fn range_by_division(&self, b: &Aabb<S>) -> ([i32; 3], [i32; 3]) {
        self.range_by(b, |from_low, k| from_low / self.cell[k])
    }

    #[inline(always)]
    fn range_by(&self, b: &Aabb<S>, cells: impl Fn(S, usize) -> S) -> ([i32; 3], [i32; 3]) {
        let (lo, hi) = (b.min.to_array(), b.max.to_array());
        let mut first = [0; 3];
        let mut last = [0; 3];
        for k in 0..3 {
            first[k] = self.clamped(cells(lo[k] - self.lo[k], k), k);
            last[k] = self.clamped(cells(hi[k] - self.lo[k], k), k);
        }
        (first, last)
    }

    /// Truncation equals floor here: what is below 0 is clamped to 0 anyway.
    #[inline(always)]
    fn clamped(&self, x: S, axis: usize) -> i32 {
        x.to_index(self.n[axis] - 1)
    }

    /// Index of a cell, x fastest.
    #[inline(always)]
    pub fn index(&self, c: [i32; 3]) -> usize {
        (c[2] as usize * self.n[1] as usize + c[1] as usize) * self.n[0] as usize + c[0] as usize
    }

    /// A cell of this grid, for questions that no ray asks.
    pub fn cell(&self, coords: [i32; 3]) -> GridCell {
        GridCell { index: self.index(coords), coords }
    }

    /// Coordinates of the cell with that index.
    pub fn coords(&self, index: usize) -> [i32; 3] {
        let [nx, ny, _] = self.n.map(|n| n as usize);
        [index % nx, index / nx % ny, index / (nx * ny)].map(|i| i as i32)
    }

    /// Lengths of a cell's sides.
    pub fn cell_size(&self) -> [S; 3] {
        self.cell
    }

    /// The box of the cell with that index.
    pub fn cell_bounds(&self, index: usize) -> Aabb<S> {
        let at = self.coords(index);
        let plane = |k: usize, i: i32| self.lo[k] + S::from_i32(i) * self.cell[k];
        Aabb {
            min: Vec3::<S>::from_array(std::array::from_fn(|k| plane(k, at[k]))),
            max: Vec3::<S>::from_array(std::array::from_fn(|k| plane(k, at[k] + 1))),
        }
    }

    /// Starts a traversal, or `None` when the ray misses the box within its interval.
    #[inline(always)]
    pub fn traversal(&self, ray: &Ray<S>) -> Option<VoxelTraversal<S>> {
        self.traversal_from(ray, ray.t_min)
    }

    /// Starts a traversal at parameter `t_start` in place of the ray's `t_min`.
    #[inline(always)]
    pub fn traversal_from(&self, ray: &Ray<S>, t_start: S) -> Option<VoxelTraversal<S>> {
        let (t_in, _) = self.bounds.clip(ray.origin, ray.direction, t_start, ray.t_max)?;
        Some(self.traversal_at(ray, inverse_direction(ray), t_in))
    }

    /// Starts a traversal in the cell that holds, or is nearest to, the point of the ray at `t`,
    /// whether or not the ray meets the box there. `inverse` is [`inverse_direction`] of the ray.
    #[inline(always)]
    pub fn traversal_at(&self, ray: &Ray<S>, inverse: [S; 3], t: S) -> VoxelTraversal<S> {
        let o = ray.origin.to_array();
        let d = ray.direction.to_array();
        let p = ray.at(t).to_array();
        let stride = [1, self.n[0] as isize, self.n[0] as isize * self.n[1] as isize];
        let mut traversal = VoxelTraversal {
            t_next: [S::INFINITY; 3],
            plane: [S::ZERO; 3],
            plane_step: [S::ZERO; 3],
            cell: self.cell,
            from_origin: [S::ZERO; 3],
            inv_d: inverse,
            remaining: [0; 3],
            last: [0; 3],
            step: [0; 3],
            stride: [0; 3],
            offset: 0,
        };
        let mut at = [0; 3];
        for k in 0..3 {
            at[k] = self.clamped((p[k] - self.lo[k]) * self.inv_cell[k], k);
            // no direction (0 * infinity below would be NaN)
            if !inverse[k].is_finite() {
                traversal.last[k] = at[k];
                continue;
            }
            let up = d[k] > S::ZERO;
            traversal.step[k] = if up { 1 } else { -1 };
            traversal.last[k] = if up { self.n[k] - 1 } else { 0 };
            traversal.from_origin[k] = self.lo[k] - o[k];
            traversal.plane[k] = S::from_i32(at[k] + i32::from(up));
            traversal.plane_step[k] = if up { S::ONE } else { -S::ONE };
            traversal.remaining[k] = if up { self.n[k] - 1 - at[k] } else { at[k] };
            traversal.stride[k] = if up { stride[k] } else { -stride[k] };
            traversal.t_next[k] = traversal.plane_parameter(k);
        }
        traversal.offset = self.index(at) as isize;
        traversal
    }

    /// The same grid in f64, its planes where `S` has them but for the rounding of their sums.
    pub fn in_double(&self) -> GridFrame<f64> {
        let wide = |v: [S; 3]| v.map(S::to_f64);
        let cell = wide(self.cell);
        let (bounds, lo) = (self.bounds.in_double(), wide(self.lo));
        GridFrame { bounds, lo, cell, inv_cell: cell.map(|c| 1.0 / c), n: self.n }
    }
}

/// A cell of a grid by its index.
pub(super) struct IndexedCell<'a, S: Scalar> {
    pub(super) frame: &'a GridFrame<S>,
    pub(super) index: usize,
}

impl<S: Scalar> CellPosition for IndexedCell<'_, S> {
    #[inline(always)]
    fn index(&self) -> usize {
        self.index
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        self.frame.coords(self.index)
    }
}

/// Divides the cells of a grid, each by a grid of its own, which is made anew for each ray that
/// comes by, in place of being stored.
#[derive(Debug, Clone, Copy)]
pub struct CellDivision<S: Scalar> {
    /// Lower corner of the first cell, and how far apart those of two cells are.
    lo: [S; 3],
    pitch: [S; 3],
    /// Sides of a cell.
    side: [S; 3],
    inv_side: [S; 3],
}

impl<S: Scalar> CellDivision<S> {
    /// Margin of the cells of `frame`, whose grids reach `padding` beyond them.
    pub fn new(frame: &GridFrame<S>, padding: S) -> Self {
        let side = frame.cell.map(|cell| cell + padding + padding);
        Self {
            lo: frame.lo.map(|lo| lo - padding),
            pitch: frame.cell,
            side,
            inv_side: side.map(|side| S::ONE / side),
        }
    }

    /// The grid of `n` cells per axis, at least 1, that divides the cell of those coordinates.
    #[inline(always)]
    pub fn grid(&self, coords: [i32; 3], n: [u8; 3]) -> GridFrame<S> {
        let (mut lo, mut hi, mut cell, mut inv_cell) = (self.lo, self.lo, self.side, self.inv_side);
        for k in 0..3 {
            let parts = S::from_i32(i32::from(n[k]));
            lo[k] += S::from_i32(coords[k]) * self.pitch[k];
            hi[k] = lo[k] + self.side[k];
            cell[k] = self.side[k] / parts;
            inv_cell[k] = self.inv_side[k] * parts;
        }
        let bounds = Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) };
        GridFrame { bounds, lo, cell, inv_cell, n: n.map(i32::from) }
    }
}

/// 1 / direction; an infinity on the axes that the ray is perpendicular to, or so nearly that it
/// never leads to another cell.
#[inline(always)]
pub fn inverse_direction<S: Scalar>(ray: &Ray<S>) -> [S; 3] {
    ray.direction.to_array().map(|d| S::ONE / d)
}

/// A ray on its way through a grid.
#[derive(Debug, Clone, Copy)]
pub struct VoxelTraversal<S: Scalar> {
    /// Parameter at which the next plane of each axis is met.
    pub(crate) t_next: [S; 3],
    /// Index of that plane.
    pub(crate) plane: [S; 3],
    pub(crate) plane_step: [S; 3],
    pub(crate) cell: [S; 3],
    /// Lower corner of the grid minus the ray's origin.
    pub(crate) from_origin: [S; 3],
    pub(crate) inv_d: [S; 3],
    /// Cells left in the direction of each axis.
    pub(crate) remaining: [i32; 3],
    /// The outermost cell in the direction of each axis; the current one where it has none.
    pub(crate) last: [i32; 3],
    /// 1, -1, or 0 on an axis without direction.
    pub(crate) step: [i32; 3],
    pub(crate) stride: [isize; 3],
    pub(crate) offset: isize,
}

impl<S: Scalar> VoxelTraversal<S> {
    #[inline(always)]
    fn plane_parameter(&self, k: usize) -> S {
        (self.plane[k] * self.cell[k] + self.from_origin[k]) * self.inv_d[k]
    }

    /// Parameter spent in one cell along each axis; infinite without direction.
    #[inline(always)]
    pub(crate) fn per_cell(&self) -> [S; 3] {
        std::array::from_fn(|k| (self.cell[k] * self.inv_d[k]).abs())
    }

    /// Parameter of the plane that comes `planes` after the next one on axis `k`.
    #[inline(always)]
    pub fn plane_ahead(&self, k: usize, planes: i32) -> S {
        if self.step[k] == 0 {
            return S::INFINITY;
        }
        let plane = self.plane[k] + self.plane_step[k] * S::from_i32(planes);
        (plane * self.cell[k] + self.from_origin[k]) * self.inv_d[k]
    }

    /// Moves so many cells forward on each axis at once; false when that would leave the grid.
    /// Axes without direction do not move.
    #[inline(always)]
    pub fn jump(&mut self, cells: [i32; 3]) -> bool {
        for (k, n) in cells.into_iter().enumerate() {
            if n <= 0 || self.step[k] == 0 {
                continue;
            }
            if n > self.remaining[k] {
                return false;
            }
            self.remaining[k] -= n;
            self.offset += self.stride[k] * n as isize;
            self.plane[k] += self.plane_step[k] * S::from_i32(n);
            self.t_next[k] = self.plane_parameter(k);
        }
        true
    }

    /// The axis whose plane is met first; of equal ones the lowest.
    #[inline(always)]
    pub(crate) fn axis(&self) -> usize {
        let [x, y, z] = self.t_next;
        let (k, t) = if y < x { (1, y) } else { (0, x) };
        if z < t { 2 } else { k }
    }
}

impl<S: Scalar> CellPosition for VoxelTraversal<S> {
    #[inline(always)]
    fn index(&self) -> usize {
        self.offset as usize
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        std::array::from_fn(|k| self.last[k] - self.step[k] * self.remaining[k])
    }
}

impl<S: Scalar> CellTraversal<S> for VoxelTraversal<S> {
    #[inline(always)]
    fn t_exit(&self) -> S {
        self.t_next[self.axis()]
    }

    #[inline(always)]
    fn advance(&mut self) -> bool {
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
    use crate::structures::test_scenes::Random;
    use glam::DVec3;

    /// The cells of a traversal; its coordinates and exits are compared with the indices on the
    /// way.
    fn collect(frame: &GridFrame<f64>, traversal: Option<impl CellTraversal<f64>>) -> Vec<usize> {
        let mut out = Vec::new();
        let Some(mut w) = traversal else { return out };
        let mut last_exit = f64::NEG_INFINITY;
        loop {
            assert_eq!(frame.index(w.coords()), w.index());
            assert!(w.t_exit() >= last_exit - 1e-9 * last_exit.abs());
            last_exit = w.t_exit();
            out.push(w.index());
            if !w.advance() {
                return out;
            }
        }
    }

    /// The cells of the t_next and of the driving-axis traversal, which miss no pierced one. They
    /// are the same but at ties, where both may touch another cell on an edge or corner.
    fn visited(frame: &GridFrame<f64>, ray: &Ray<f64>) -> [Vec<usize>; 2] {
        let driven = collect(frame, frame.driving_traversal_from(ray, ray.t_min));
        let visited = [collect(frame, frame.traversal(ray)), driven];
        let missed = |&(i, _): &(_, _)| visited.iter().any(|cells| !cells.contains(&i));
        let missed = pierced(frame, ray).find(missed);
        assert_eq!(missed, None, "{ray:?} visits {visited:?}");
        visited
    }

    /// Every cell whose inside the ray crosses by more than rounding, and its corner.
    fn pierced(frame: &GridFrame<f64>, ray: &Ray<f64>) -> impl Iterator<Item = (usize, DVec3)> {
        let (o, d) = (ray.origin, ray.direction);
        let corner = |i| (i, DVec3::from(frame.coords(i).map(f64::from)));
        (0..frame.cells()).map(corner).filter(move |&(_, lo)| {
            // rays within a face's plane pierce neither neighbour
            let within = |k| d[k] != 0.0 || (o[k] > lo[k] && o[k] < lo[k] + 1.0);
            let crossed = Aabb::<f64> { min: lo, max: lo + 1.0 }.clip(o, d, 0.0, f64::INFINITY);
            (0..3).all(within) && crossed.is_some_and(|(a, z)| z - a > 1e-9)
        })
    }

    fn unit_frame(n: u32) -> GridFrame<f64> {
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::splat(f64::from(n)) };
        GridFrame::new(bounds, [n; 3])
    }

    #[test]
    fn visits_exactly_the_pierced_cells() {
        let n = 16;
        let frame = unit_frame(n);
        let mut random = Random(12345);
        for _ in 0..2000 {
            let o = random.point([48.0; 3]) - 16.0;
            let ray = Ray::<f64>::new(o, random.point([f64::from(n); 3]) - o);
            let [next, driven] = visited(&frame, &ray);
            assert_eq!(driven, next, "{ray:?}");
            let pierced = pierced(&frame, &ray).count();
            assert!(next.len() <= pierced + 3, "{} for {pierced}", next.len());
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
                    assert_eq!(visited(&frame, &ray).map(|cells| cells.len()), [8, 8]);
                }
            }
        }
    }

    #[test]
    fn an_origin_far_away_is_clamped_into_the_grid() {
        // HARD_CASES T4
        let frame = unit_frame(8);
        let ray = Ray::<f64>::new([-1e9, 8.0, 8.0].into(), [1.0, 0.0, 0.0].into());
        let [cells, _] = visited(&frame, &ray);
        assert_eq!(cells.len(), 8);
        assert!(cells.iter().all(|&c| c < frame.cells()));
    }

    #[test]
    fn lattice_ties_miss_no_pierced_cell_in_either_traversal() {
        // HARD_CASES T2: lattice origins, directions {-7..7}^3; half-integer sums keep it exact
        let frame = unit_frame(8);
        for d in (0..15i32.pow(3)).map(|i| [i % 15 - 7, i / 15 % 15 - 7, i / 225 - 7]) {
            if d == [0; 3] {
                continue;
            }
            let ray = Ray::<f64>::new([4.0, 3.0, 5.0].into(), d.map(f64::from).into());
            assert!(visited(&frame, &ray).iter().all(|cells| cells.len() <= 22), "{d:?}");
        }
    }

    #[test]
    fn directions_too_small_to_invert_are_no_directions() {
        // HARD_CASES R2: 0 * infinity once ended the traversal at the first cell
        let bounds = Aabb { min: glam::Vec3::ZERO, max: glam::Vec3::splat(8.0) };
        let frame = GridFrame::<f32>::new(bounds, [8; 3]);
        let ray = Ray::<f32>::new([4.0, -1.0, 4.0].into(), [1e-45, 1.0, -1e-45].into());
        let mut traversal = frame.traversal(&ray).unwrap();
        let mut driven = frame.driving_traversal_from(&ray, 0.0).unwrap();
        for _ in 0..7 {
            assert!(traversal.advance() && driven.advance());
        }
        assert!(!traversal.advance() && !driven.advance());
    }
}
