//! How the triangles of a list are tested: one by one, or eight at a time out of blocks.
//!
//! A structure keeps lists of ids and hands them to a sink. With `kernel=block` blocks of triangles
//! stand beside the ids, and a sink between the traversal and the query finds the blocks of a list
//! by where the list lies in memory. Traversals are the same for both kernels, and so are counters;
//! answers are equal to the last bit.
//!
//! A structure that has lists says [`HAS_LISTS`](crate::structure::Structure::HAS_LISTS) and
//! lists [`PARAM`] among its parameters.

use std::ops::ControlFlow;

use crate::geometry::scalar::Scalar;
use crate::memory::prefetch;
use crate::params::ParamSpec;
use crate::primitives::{Primitives, TriangleBlock, blocks};
use crate::query::sink::{Sink, end_of_query, steps_of_query};
use crate::update::ChangedLists;

/// The setting, for the parameter list of a structure whose lists are short, or so many that blocks
/// of them take too much memory: 320 bytes for a list in f32, however short.
pub const PARAM: ParamSpec = ParamSpec::choice("kernel", "scalar", &["scalar", "block"])
    .about("triangles of a list: tested one by one, or as blocks of eight (not with a mailbox)");

/// The same for a structure that blocks make faster on every scene. A mailbox takes precedence.
pub const BLOCK_PARAM: ParamSpec = ParamSpec { default: "block", ..PARAM };

/// In [`ListBlocks::first`]: no list begins there.
const NONE: u32 = u32::MAX;

/// The blocks of a structure's lists.
pub struct ListBlocks<S> {
    /// Address of the first id of all lists.
    base: usize,
    /// By the place of an id behind `base`: the first block of the list that begins there.
    first: Vec<u32>,
    blocks: Vec<TriangleBlock<S>>,
}

impl<S: Scalar> ListBlocks<S> {
    /// Blocks of these lists, which are parts of one array. `None` if the set has no blocks, there
    /// are too many, or lists lie too far apart.
    #[inline(never)]
    pub(crate) fn of(prims: &dyn Primitives<S>, lists: &[&[u32]]) -> Option<Self> {
        let address = |list: &[u32]| list.as_ptr() as usize;
        let full = || lists.iter().filter(|list| !list.is_empty());
        let base = full().map(|list| address(list)).min()?;
        let end = full().map(|list| address(list) + size_of_val(*list)).max()?;
        let (places, references) = ((end - base) / size_of::<u32>(), total(lists));
        if !blocks::serve(prims) || places > 2 * references + 1024 {
            return None;
        }
        let number: usize = full().map(|list| blocks::number_of::<S>(list.len())).sum();
        u32::try_from(number).ok().filter(|&n| n != NONE)?;
        let (mut first, mut next) = (vec![NONE; places], 0);
        for list in full() {
            first[(address(list) - base) / size_of::<u32>()] = next;
            next += blocks::number_of::<S>(list.len()) as u32;
        }
        Some(Self { base, first, blocks: blocks::of_lists(prims, 0, lists) })
    }

    /// The blocks of these lists, of which `changed` are others than those that these blocks are
    /// of: those are made anew, where they were if they are no more than before, else behind all
    /// others. What is left over stays until it is a third of all; all are made anew then.
    #[inline(never)]
    pub(crate) fn changed(
        mut self,
        prims: &dyn Primitives<S>,
        lists: &[&[u32]],
        changed: &ChangedLists,
    ) -> Option<Self> {
        let length_of = |list: &[u32]| blocks::number_of::<S>(list.len());
        let needed: usize = lists.iter().map(|list| length_of(list)).sum();
        let full = || lists.iter().filter(|list| !list.is_empty());
        let base = full().map(|list| list.as_ptr() as usize).min()?;
        let is_usable = changed.before.len() >= lists.len() && blocks::serve(prims);
        if !is_usable || self.blocks.len() > needed + needed / 2 {
            return Self::of(prims, lists);
        }
        let mut first = vec![NONE; total(lists)];
        let mut others = changed.changed.iter().map(|&number| number as usize).peekable();
        for (number, list) in lists.iter().enumerate() {
            let is_changed = others.next_if_eq(&number).is_some();
            if list.is_empty() {
                continue;
            }
            let place = (list.as_ptr() as usize - base) / size_of::<u32>();
            let before = self.first.get(changed.before[number] as usize);
            let mut at = before.copied().filter(|_| changed.had_ids(number));
            if is_changed {
                let room = at.map_or(0, |at| blocks::length(&self.blocks[at as usize..]));
                if room < length_of(list) {
                    at = u32::try_from(self.blocks.len()).ok();
                    blocks::push_list(prims, list, &mut self.blocks);
                } else if let Some(at) = at {
                    blocks::set_list(prims, list, &mut self.blocks[at as usize..]);
                }
            }
            *first.get_mut(place)? = at.filter(|&at| at != NONE)?;
        }
        Some(Self { base, first, blocks: self.blocks })
    }

    /// Bytes that [`ListBlocks::of`] would take at most.
    pub(crate) fn bytes_for(lists: &[&[u32]]) -> u128 {
        let number: usize = lists.iter().map(|list| blocks::number_of::<S>(list.len())).sum();
        let places = 2 * total(lists) + 1024;
        (number * size_of::<TriangleBlock<S>>() + places * size_of::<u32>()) as u128
    }

    /// The blocks of a list, and what follows them.
    #[inline(always)]
    fn behind(&self, list: &[u32]) -> Option<&[TriangleBlock<S>]> {
        let place = (list.as_ptr() as usize).wrapping_sub(self.base) / size_of::<u32>();
        self.blocks.get(*self.first.get(place)? as usize..)
    }

    /// The number of a list for [`ListBlocks::of_number`]; 0 for one without ids.
    #[inline(always)]
    pub(crate) fn number(&self, list: &[u32]) -> u32 {
        if list.is_empty() {
            return 0;
        }
        let place = (list.as_ptr() as usize).wrapping_sub(self.base) / size_of::<u32>();
        // every list that has ids has blocks
        self.first[place] + 1
    }

    /// The blocks of a list that has ids, and what follows them.
    #[inline(always)]
    pub(crate) fn of_number(&self, number: u32) -> &[TriangleBlock<S>] {
        &self.blocks[number as usize - 1..]
    }

    /// Begins to load a list that has ids.
    #[inline(always)]
    pub(crate) fn prefetch(&self, number: u32) {
        prefetch(&self.blocks[number as usize - 1]);
    }

    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(self.first.as_slice()) + size_of_val(self.blocks.as_slice())) as u64
    }
}

fn total(lists: &[&[u32]]) -> usize {
    lists.iter().map(|list| list.len()).sum()
}

/// A sink that hands the blocks of lists on, and lists that have none as they are.
pub(crate) struct BlockSink<'b, 'q, S, K> {
    pub(crate) blocks: &'b ListBlocks<S>,
    pub(crate) query: &'q mut K,
}

/// Tests blocks apart from the traversal. Compiled into one function with it, questions of
/// occlusion had the uniform grid keep its state in memory, at half the speed.
#[inline(never)]
fn out_of_line<S: Scalar, K: Sink<S>>(
    query: &mut K,
    blocks: &[TriangleBlock<S>],
) -> ControlFlow<()> {
    query.test_blocks(blocks)
}

impl<S: Scalar, K: Sink<S>> Sink<S> for BlockSink<'_, '_, S, K> {
    const COUNTING: bool = K::COUNTING;
    const HAS_OTHER_TEST: bool = K::HAS_OTHER_TEST;
    steps_of_query!();
    end_of_query!();

    #[inline(always)]
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        match self.blocks.behind(ids) {
            Some(blocks) if self.query.is_any_hit() => out_of_line(self.query, blocks),
            Some(blocks) => self.query.test_blocks(blocks),
            None => self.query.test(ids),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{TriangleSet, Watertight};

    #[test]
    fn lists_are_found_by_where_they_lie() {
        let triangle = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
        let triangles = (0..30).map(|i| triangle(i as f32)).collect();
        let set = TriangleSet::<f32, Watertight>::new(triangles, |_| false).unwrap();
        let ids: Vec<u32> = (0..30).rev().collect();
        let lists = [&ids[..3], &ids[3..3], &ids[3..20], &ids[20..]];
        let blocks = ListBlocks::of(&set, &lists).unwrap();
        for list in lists.iter().filter(|list| !list.is_empty()) {
            let found = blocks.behind(list).unwrap();
            let n = found.iter().position(|b| !b.has_next()).unwrap() + 1;
            let held = found[..n].iter().flat_map(|block| {
                let (ids, n) = block.ids();
                ids.into_iter().take(n)
            });
            assert!(held.eq(list.iter().copied()));
        }
        // what is no list has no blocks: within one, behind all, elsewhere
        assert!(blocks.behind(&ids[1..3]).is_none());
        assert!(blocks.behind(&[7]).is_none());
        assert!(ListBlocks::of(&set, &[]).is_none());
    }
}
