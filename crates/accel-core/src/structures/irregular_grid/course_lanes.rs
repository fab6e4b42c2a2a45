//! Traverses the lattice with many rays side by side:
//! [`LatticeRayState`](super::course::LatticeRayState) axis by axis, with a ray in each lane, to
//! the same bits.

use std::ops::ControlFlow;

use wide::{i32x8, u32x8};

use crate::geometry::aabb::exit_factor;
use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::{EightOf, Scalar};
use crate::query::batch::{PlainStructure, Traverse};
use crate::query::side_by_side::{EIGHTS, LaneTraversal, RAYS};
use crate::query::sink::Sink;
use crate::structures::irregular_grid::IrregularGrid;
use crate::structures::irregular_grid::course::LatticeFrame;
use crate::structures::irregular_grid::voxels::Records;

/// Eight rays in lattice cells and where they are, by axis and lane; kept as numbers, of which
/// single lanes are replaced.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct EightCourses<S> {
    origin: [[S; LANES]; 3],
    direction: [[S; LANES]; 3],
    inverse: [[S; LANES]; 3],
    /// 0 on an axis along which the ray goes up, -1 where it goes down.
    down: [[i32; LANES]; 3],
    at: [[u32; LANES]; 3],
}

/// Eight rays that are to begin.
pub struct StartStates<S> {
    courses: EightCourses<S>,
    /// A bit for each that meets the lattice.
    meeting: u32,
}

/// Rays side by side, and where they are.
pub struct Courses<S: Scalar> {
    eights: [EightCourses<S>; EIGHTS],
    /// Records of the undivided voxels that the rays are in.
    records: [Records; EIGHTS],
}

/// Takes each ray of a batch the way that [`LatticeRayState`](super::course::LatticeRayState) takes.
impl<S: Scalar> LaneTraversal<S> for IrregularGrid<S> {
    type Eight = StartStates<S>;
    type State = Courses<S>;

    #[inline(always)]
    fn alone(&self) -> impl Traverse<S> {
        PlainStructure(self)
    }

    #[inline(always)]
    fn prepare(&self, rays: &RayLanes<S>) -> StartStates<S> {
        let (splat, vector) = (EightOf::<S>::splat, EightOf::<S>::new);
        let (zero, infinity) = (splat(S::ZERO), splat(S::INFINITY));
        let padding = splat(exit_factor());
        let mut courses = EightCourses::idle();
        let (mut start, mut end) = (zero - infinity, infinity);
        let mut meeting = zero.at_most(zero);
        for axis in 0..3 {
            let [low, per_length, size] = self.place.along(axis).map(splat);
            let origin = (vector(rays.origin[axis]) - low) * per_length;
            let direction = vector(rays.direction[axis]) * per_length;
            let inverse = splat(S::ONE) / direction;
            let moves = (inverse * zero).at_most(zero);
            let (low, high) = ((zero - origin) * inverse, (size - origin) * inverse);
            start = start.greater(low.lesser(high).where_set(moves, zero - infinity));
            end = end.lesser((low.greater(high) * padding).where_set(moves, infinity));
            meeting = meeting & (zero.at_most(origin) & origin.at_most(size) | moves);
            courses.origin[axis] = origin.to_array();
            courses.direction[axis] = direction.where_set(moves, zero).to_array();
            courses.inverse[axis] = inverse.where_set(moves, infinity).to_array();
            courses.down[axis] = (moves.to_mask() & !zero.at_most(direction).to_mask()).to_array();
        }
        start = start.greater(vector(rays.t_min));
        meeting = meeting & start.at_most(end.lesser(vector(rays.t_max)));
        for axis in 0..3 {
            let origin = vector(courses.origin[axis]);
            let entry = origin + vector(courses.direction[axis]) * start;
            courses.at[axis] = bytemuck::cast(self.place.within_along(axis, entry));
            let rests = infinity.at_most(vector(courses.inverse[axis]));
            courses.origin[axis] = splat(S::ZERO - S::ONE).where_set(rests, origin).to_array();
        }
        StartStates { courses, meeting: meeting.high_bits() }
    }

    #[inline(always)]
    fn meeting(eight: &StartStates<S>) -> u32 {
        eight.meeting
    }

    fn idle() -> Courses<S> {
        Courses { eights: [EightCourses::idle(); EIGHTS], records: [Records::NOTHING; EIGHTS] }
    }

    #[inline(always)]
    fn begin(&self, state: &mut Courses<S>, lane: usize, eight: &StartStates<S>, ray: usize) {
        let (to, from) = (&mut state.eights[lane / LANES], &eight.courses);
        let lane = lane % LANES;
        for axis in 0..3 {
            to.origin[axis][lane] = from.origin[axis][ray];
            to.direction[axis][lane] = from.direction[axis][ray];
            to.inverse[axis][lane] = from.inverse[axis][ray];
            to.down[axis][lane] = from.down[axis][ray];
            to.at[axis][lane] = from.at[axis][ray];
        }
    }

    #[inline(always)]
    fn arrive(&self, state: &mut Courses<S>) -> [u32; RAYS] {
        let mut lists = [0; RAYS];
        let pairs = state.eights.as_chunks::<2>().0.iter().zip(state.records.as_chunks_mut().0);
        for ((eights, records), lists) in pairs.zip(lists.as_chunks_mut().0) {
            *records = self.voxels.at_sixteen(&[eights[0].points(), eights[1].points()]);
            *lists =
                bytemuck::cast::<_, [u32; 2 * LANES]>([records[0].words(), records[1].words()]);
        }
        lists
    }

    #[inline(always)]
    fn prefetch(&self, list: u32) {
        self.lists.prefetch(list);
    }

    #[inline(always)]
    fn test<K: Sink<S>>(&self, list: u32, sink: &mut K) -> ControlFlow<()> {
        self.lists.test(list, sink)
    }

    #[inline(always)]
    fn leave(&self, state: &mut Courses<S>, t_max: &[S; RAYS]) -> u32 {
        let mut over = 0;
        let ends = t_max.as_chunks::<LANES>().0;
        for (number, (eight, records)) in state.eights.iter_mut().zip(&state.records).enumerate() {
            let ended = eight.leave(records, EightOf::<S>::new(ends[number]), &self.place);
            over |= ended << (number * LANES);
        }
        over
    }
}

impl<S: Scalar> EightCourses<S> {
    fn idle() -> Self {
        let zero = [[S::ZERO; LANES]; 3];
        Self {
            origin: zero,
            direction: zero,
            inverse: zero,
            down: [[0; LANES]; 3],
            at: [[0; LANES]; 3],
        }
    }

    #[inline(always)]
    fn points(&self) -> [u32x8; 3] {
        let [x, y, z] = self.at;
        [u32x8::new(x), u32x8::new(y), u32x8::new(z)]
    }

    #[inline(always)]
    fn leave(&mut self, records: &Records, t_max: EightOf<S>, place: &LatticeFrame<S>) -> u32 {
        let (splat, vector) = (EightOf::<S>::splat, EightOf::<S>::new);
        let down: [i32x8; 3] =
            [i32x8::new(self.down[0]), i32x8::new(self.down[1]), i32x8::new(self.down[2])];
        let planes = records.far_planes(&down);
        let exit = |axis: usize| {
            let distance = EightOf::<S>::from_i32(planes[axis]) - vector(self.origin[axis]);
            distance * vector(self.inverse[axis])
        };
        let exits = [exit(0), exit(1), exit(2)];
        let t = exits[0].lesser(exits[1]).lesser(exits[2]);
        let infinity = splat(S::INFINITY);
        let goes_on = t.at_most(t_max) & t.absolute().below(infinity);
        // below zero where it is over
        let mut left: i32x8 = !goes_on.to_mask();
        let mut to = [i32x8::ZERO; 3];
        for axis in 0..3 {
            let exit = vector(self.origin[axis]) + vector(self.direction[axis]) * t;
            let (there, at) = (place.within_along(axis, exit), bytemuck::cast(self.at[axis]));
            let down = down[axis];
            let onward = (there ^ down).max(i32x8::new(at) ^ down) ^ down;
            let beyond = planes[axis] + down;
            to[axis] = exits[axis].at_most(t).to_mask().select(beyond, onward);
            left |= to[axis].simd_gt(place.last_along(axis)) | to[axis];
        }
        let is_over: i32x8 = left >> 31;
        for (at, to) in self.at.iter_mut().zip(to) {
            // one that is over is somewhere in the lattice, too
            *at = bytemuck::cast(to & !is_over);
        }
        left.to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ray::Ray;
    use crate::geometry::ray_lanes::tests::rays_at_unit_cube;
    use crate::params::config::Settings;
    use crate::primitives::{TriangleSet, Watertight};
    use crate::structure::Structure;
    use crate::structures::irregular_grid::INFO;
    use crate::structures::irregular_grid::course::LatticeRayState;
    use crate::structures::test_scenes::Random;

    /// The lists of a ray that goes alone.
    fn alone<S: Scalar>(grid: &IrregularGrid<S>, ray: &Ray<S>) -> Vec<u32> {
        let mut lists = Vec::new();
        if let Some((course, mut at)) = LatticeRayState::of(ray, &grid.place) {
            loop {
                let voxel = grid.voxels.at(at);
                lists.push(voxel.list());
                if !course.leave(&mut at, &voxel, ray.t_max, &grid.place) {
                    break;
                }
            }
        }
        lists
    }

    /// A dense part in a sparse one.
    fn steps_agree<S: Scalar>() {
        let mut random = Random(11);
        let corner = |p: glam::DVec3| p.to_array().map(S::from_f64);
        let triangles = (0..3000).map(|i| {
            let size = if i % 5 == 0 { 1.0 } else { 0.125 };
            let at = random.point([size; 3]);
            [at, at + random.point([0.1 * size; 3]), at + random.point([0.1 * size; 3])].map(corner)
        });
        let set = TriangleSet::<S, Watertight>::new(triangles.collect(), |_| false).unwrap();
        let params = INFO.defaults().set("longest-list", 4).unwrap();
        let grid = IrregularGrid::<S>::build(&set, &Settings::of(&params)).unwrap();
        let (mut steps, mut missed, mut full) = (0, 0, 0);
        for round in 0..400 {
            let rays: [Ray<S>; LANES] = rays_at_unit_cube(&mut random, round);
            let expected = rays.each_ref().map(|ray| alone(&grid, ray));
            let beginnings = grid.prepare(&RayLanes::of(&rays));
            let mut courses = IrregularGrid::idle();
            // among other lanes, which go on for ever
            let lanes = [round, round + 9, round + 18, round + 27];
            let lanes: Vec<usize> = (0..LANES).map(|i| (lanes[i % 4] + i / 4) % RAYS).collect();
            let mut found = vec![Vec::new(); LANES];
            let mut going = 0u32;
            for (i, &lane) in lanes.iter().enumerate() {
                let meets = beginnings.meeting >> i & 1 == 1;
                assert_eq!(meets, !expected[i].is_empty());
                missed += u32::from(!meets);
                if meets {
                    grid.begin(&mut courses, lane, &beginnings, i);
                    going |= 1 << lane;
                }
            }
            let mut t_max = [S::ZERO; RAYS];
            lanes.iter().zip(&rays).for_each(|(&lane, ray)| t_max[lane] = ray.t_max);
            while going != 0 {
                let lists = grid.arrive(&mut courses);
                for (i, &lane) in lanes.iter().enumerate() {
                    if going >> lane & 1 == 1 {
                        found[i].push(lists[lane]);
                    }
                }
                going &= !grid.leave(&mut courses, &t_max);
            }
            assert_eq!(found, expected, "{rays:?}");
            steps += found.iter().map(Vec::len).sum::<usize>();
            full += found.iter().flatten().filter(|list| **list != 0).count();
        }
        assert!(steps > 4000 && missed > 100 && full > 500, "{steps} {missed} {full}");
    }

    #[test]
    fn steps_in_lanes_are_those_of_one_ray() {
        steps_agree::<f32>();
        steps_agree::<f64>();
    }
}
