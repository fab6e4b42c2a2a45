//! The ways of many rays through a regular grid side by side: [`VoxelTraversal`] with a ray in each
//! lane, to the same bits.

use wide::i32x8;

use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray_lanes::LANES;
use crate::geometry::scalar::{EightOf, Scalar};
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};
use crate::query::side_by_side::{EIGHTS, RAYS};

/// Eight rays on their way, by axis and lane; kept as numbers, of which single lanes are replaced.
/// Fields as in [`VoxelTraversal`].
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct EightTraversals<S> {
    t_next: [[S; LANES]; 3],
    plane: [[S; LANES]; 3],
    plane_step: [[S; LANES]; 3],
    from_origin: [[S; LANES]; 3],
    inv_d: [[S; LANES]; 3],
    /// Whole numbers below 2^24.
    remaining: [[S; LANES]; 3],
    stride: [[i32; LANES]; 3],
    index: [i32; LANES],
}

/// Rays side by side, and where they are.
pub struct TraversalLanes<S>([EightTraversals<S>; EIGHTS]);

/// Cells that a grid may have for its rays to go side by side.
pub(super) const MOST_CELLS: usize = i32::MAX as usize;

impl<S: Scalar> TraversalLanes<S> {
    pub(super) fn idle() -> Self {
        let zero = [[S::ZERO; LANES]; 3];
        let idle = EightTraversals {
            t_next: zero,
            plane: zero,
            plane_step: zero,
            from_origin: zero,
            inv_d: zero,
            remaining: zero,
            stride: [[0; LANES]; 3],
            index: [0; LANES],
        };
        Self([idle; EIGHTS])
    }

    /// Sets a ray on its way in a grid of at most [`MOST_CELLS`].
    #[inline(always)]
    pub(super) fn begin(&mut self, lane: usize, ray: &VoxelTraversal<S>) {
        let (to, lane) = (&mut self.0[lane / LANES], lane % LANES);
        for axis in 0..3 {
            to.t_next[axis][lane] = ray.t_next[axis];
            to.plane[axis][lane] = ray.plane[axis];
            to.plane_step[axis][lane] = ray.plane_step[axis];
            to.from_origin[axis][lane] = ray.from_origin[axis];
            to.inv_d[axis][lane] = ray.inv_d[axis];
            to.remaining[axis][lane] = S::from_i32(ray.remaining[axis]);
            to.stride[axis][lane] = ray.stride[axis] as i32;
        }
        to.index[lane] = ray.offset as i32;
    }

    /// The indices of the cells that the lanes of a group have come to.
    #[inline(always)]
    pub(super) fn indices(&self, group: usize) -> [usize; LANES] {
        self.0[group].index.map(|index| index as usize)
    }

    /// Goes on to the next cells; a bit for each ray that does not, as it leaves the grid or comes
    /// to its end.
    #[inline(always)]
    pub(super) fn leave(&mut self, t_max: &[S; RAYS], frame: &GridFrame<S>) -> u32 {
        let cell = frame.cell_size();
        let mut over = 0;
        let ends = t_max.as_chunks::<LANES>().0;
        for (number, (eight, end)) in self.0.iter_mut().zip(ends).enumerate() {
            over |= eight.leave(EightOf::<S>::new(*end), &cell) << (number * LANES);
        }
        over
    }
}

impl<S: Scalar> EightTraversals<S> {
    /// The end of a visit, and
    /// [`VoxelTraversal::advance`](super::cell_traversal::CellTraversal::advance).
    #[inline(always)]
    fn leave(&mut self, t_max: EightOf<S>, cell: &[S; 3]) -> u32 {
        let (splat, vector) = (EightOf::<S>::splat, EightOf::<S>::new);
        let zero = splat(S::ZERO);
        let [x, y, z] = [vector(self.t_next[0]), vector(self.t_next[1]), vector(self.t_next[2])];
        // of equal ones the lowest axis, as `VoxelTraversal::axis`; none is NaN
        let firsts =
            [x.at_most(y) & x.at_most(z), y.below(x) & y.at_most(z), z.below(x) & z.below(y)];
        let ahead = |axis: usize| firsts[axis] & vector(self.remaining[axis]);
        let goes_on =
            x.lesser(y).lesser(z).at_most(t_max) & zero.below(ahead(0) | ahead(1) | ahead(2));
        let mut index = i32x8::new(self.index);
        for axis in 0..3 {
            let moves = firsts[axis] & goes_on;
            let plane = vector(self.plane[axis]) + (moves & vector(self.plane_step[axis]));
            let t = (plane * splat(cell[axis]) + vector(self.from_origin[axis]))
                * vector(self.inv_d[axis]);
            let t = t.where_set(moves, vector(self.t_next[axis]));
            let remaining = vector(self.remaining[axis]) - (moves & splat(S::ONE));
            index += moves.to_mask() & i32x8::new(self.stride[axis]);
            self.plane[axis] = plane.to_array();
            self.t_next[axis] = t.to_array();
            self.remaining[axis] = remaining.to_array();
        }
        self.index = index.to_array();
        !goes_on.high_bits() & ((1 << LANES) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::aabb::Aabb;
    use crate::geometry::ray::Ray;
    use crate::geometry::ray_lanes::tests::rays_at_unit_cube;
    use crate::geometry::scalar::{Vec3, Vector};
    use crate::grid::cell_traversal::{CellPosition, CellTraversal};
    use crate::structures::test_scenes::Random;

    /// The cells of a ray that goes alone.
    fn alone<S: Scalar>(frame: &GridFrame<S>, ray: &Ray<S>) -> Vec<(usize, [i32; 3])> {
        let mut cells = Vec::new();
        let Some(mut traversal) = frame.traversal(ray) else { return cells };
        loop {
            cells.push((traversal.index(), traversal.coords()));
            if ray.t_max < traversal.t_exit() || !traversal.advance() {
                return cells;
            }
        }
    }

    fn steps_agree<S: Scalar>() {
        let mut random = Random(5);
        let bounds = Aabb { min: Vec3::<S>::splat(S::ZERO), max: Vec3::<S>::splat(S::ONE) };
        let frame = GridFrame::new(bounds, [16, 8, 32]);
        let (mut steps, mut missed, mut full) = (0, 0, 0);
        for round in 0..300 {
            let rays: [Ray<S>; RAYS] = rays_at_unit_cube(&mut random, round);
            let expected = rays.each_ref().map(|ray| alone(&frame, ray));
            let mut lanes = TraversalLanes::idle();
            let mut going = 0u32;
            for (lane, ray) in rays.iter().enumerate() {
                if let Some(traversal) = frame.traversal(ray) {
                    lanes.begin(lane, &traversal);
                    going |= 1 << lane;
                }
            }
            missed += going.count_zeros();
            let mut found = vec![Vec::new(); RAYS];
            let t_max = rays.each_ref().map(|ray| ray.t_max);
            while going != 0 {
                for lane in (0..RAYS).filter(|lane| going >> lane & 1 == 1) {
                    let index = lanes.indices(lane / LANES)[lane % LANES];
                    found[lane].push((index, frame.coords(index)));
                }
                going &= !lanes.leave(&t_max, &frame);
            }
            for (lane, ray) in rays.iter().enumerate() {
                assert_eq!(found[lane], expected[lane], "{ray:?}");
                full += usize::from(found[lane].len() > 16);
            }
            steps += found.iter().map(Vec::len).sum::<usize>();
        }
        assert!(steps > 50_000 && missed > 500 && full > 500, "{steps} {missed} {full}");
    }

    #[test]
    fn steps_in_lanes_are_those_of_one_ray() {
        steps_agree::<f32>();
        steps_agree::<f64>();
    }
}
