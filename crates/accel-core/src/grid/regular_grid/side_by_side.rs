//! A regular grid whose lists are blocks, its rays side by side.

use std::ops::ControlFlow;

use crate::geometry::ray::Ray;
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::Scalar;
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};
use crate::grid::voxel_traversal_lanes::TraversalLanes;
use crate::query::batch::Traverse;
use crate::query::kernel::ListBlocks;
use crate::query::side_by_side::{LaneTraversal, RAYS};
use crate::query::sink::Sink;
use crate::structure::{Structure, traverse_by_blocks};

/// The grid, where its traversals start, its lists by the indices of cells, and their blocks.
pub(super) struct BlockGrid<'a, S: Scalar, T, L> {
    pub(super) grid: &'a T,
    pub(super) frame: &'a GridFrame<S>,
    pub(super) from_origin: bool,
    pub(super) list: L,
    pub(super) blocks: &'a ListBlocks<S>,
}

/// Eight rays that are to begin; none where the grid is not met.
pub(crate) struct StartStates<S: Scalar>([Option<VoxelTraversal<S>>; LANES]);

impl<S: Scalar, T: Structure<S>, L> Traverse<S> for &BlockGrid<'_, S, T, L> {
    #[inline(always)]
    fn traverse_one<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        traverse_by_blocks(self.grid, self.blocks, ray, sink);
    }
}

impl<'a, S, T, L> LaneTraversal<S> for BlockGrid<'a, S, T, L>
where
    S: Scalar,
    T: Structure<S>,
    L: Fn(usize) -> &'a [u32],
{
    type Eight = StartStates<S>;
    type State = TraversalLanes<S>;

    #[inline(always)]
    fn alone(&self) -> impl Traverse<S> {
        self
    }

    #[inline(always)]
    fn prepare(&self, rays: &RayLanes<S>) -> StartStates<S> {
        let mut beginnings = [const { None }; LANES];
        for (lane, beginning) in beginnings.iter_mut().enumerate() {
            let ray = rays.ray(lane);
            let start = if self.from_origin { S::ZERO } else { ray.t_min };
            *beginning = self.frame.traversal_from(&ray, start);
        }
        StartStates(beginnings)
    }

    #[inline(always)]
    fn meeting(eight: &StartStates<S>) -> u32 {
        let met = eight.0.iter().enumerate();
        met.fold(0, |met, (lane, traversal)| met | u32::from(traversal.is_some()) << lane)
    }

    fn idle() -> TraversalLanes<S> {
        TraversalLanes::idle()
    }

    #[inline(always)]
    fn begin(&self, state: &mut Self::State, lane: usize, eight: &StartStates<S>, ray: usize) {
        if let Some(traversal) = &eight.0[ray] {
            state.begin(lane, traversal);
        }
    }

    #[inline(always)]
    fn arrive(&self, state: &mut TraversalLanes<S>) -> [u32; RAYS] {
        let mut lists = [0; RAYS];
        for (group, lists) in lists.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            for (list, index) in lists.iter_mut().zip(state.indices(group)) {
                *list = self.blocks.number((self.list)(index));
            }
        }
        lists
    }

    #[inline(always)]
    fn prefetch(&self, list: u32) {
        self.blocks.prefetch(list);
    }

    #[inline(always)]
    fn test<K: Sink<S>>(&self, list: u32, sink: &mut K) -> ControlFlow<()> {
        sink.test_blocks(self.blocks.of_number(list))
    }

    #[inline(always)]
    fn leave(&self, state: &mut TraversalLanes<S>, t_max: &[S; RAYS]) -> u32 {
        state.leave(t_max, self.frame)
    }
}
