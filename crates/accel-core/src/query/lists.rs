//! Lists of primitives as sinks test them: ids, or triangles eight at a time.

use std::ops::ControlFlow;

use crate::geometry::scalar::Scalar;
use crate::memory::prefetch;
use crate::primitives::{IdSet, Primitives, TriangleBlock, blocks};
use crate::query::sink::Sink;

/// Lists by their numbers.
#[derive(Debug)]
pub(crate) enum Lists<S> {
    /// At its number the list's length, then the ids.
    Ids(Vec<u32>),
    /// Its number is that of its first block.
    Blocks(Vec<TriangleBlock<S>>),
}

/// Future places of non-empty lists.
pub(crate) struct Layout {
    pub(crate) numbers: Vec<u32>,
    /// They are kept as so many blocks or ids.
    end: usize,
    is_blocks: bool,
}

impl Layout {
    /// Layout in blocks if the set has them; `None` if a number would reach `limit`.
    pub(crate) fn of<S: Scalar>(
        prims: &dyn Primitives<S>,
        lists: &[&[u32]],
        limit: u32,
    ) -> Option<Self> {
        let (is_blocks, mut end) = (blocks::serve(prims), 0);
        let number = |list: &&[u32]| {
            let number = u32::try_from(end).ok().filter(|number| *number < limit);
            end += if is_blocks { blocks::number_of::<S>(list.len()) } else { 1 + list.len() };
            number
        };
        let numbers = lists.iter().map(number).collect::<Option<Vec<u32>>>()?;
        Some(Self { numbers, end, is_blocks })
    }

    /// Bytes of all lists.
    pub(crate) fn bytes<S: Scalar>(&self) -> usize {
        self.end * if self.is_blocks { size_of::<TriangleBlock<S>>() } else { size_of::<u32>() }
    }

    /// The lists that this is the layout of; made by the threads of the current rayon pool.
    pub(crate) fn filled<S: Scalar>(
        &self,
        prims: &dyn Primitives<S>,
        lists: &[&[u32]],
    ) -> Lists<S> {
        if self.is_blocks {
            return Lists::Blocks(blocks::of_lists(prims, 0, lists));
        }
        let mut ids = Vec::with_capacity(self.end);
        for list in lists {
            ids.push(list.len() as u32);
            ids.extend_from_slice(list);
        }
        Lists::Ids(ids)
    }
}

impl<S: Scalar> Lists<S> {
    /// Makes the blocks of the same lists over primitives of which some have moved; false where
    /// these would not be such lists.
    pub(crate) fn refresh(&mut self, prims: &dyn Primitives<S>, moved: &IdSet) -> bool {
        let (serve, are_blocks) = (blocks::serve(prims), matches!(self, Self::Blocks(_)));
        if let (Self::Blocks(all), true) = (self, serve) {
            blocks::refresh(prims, all, moved);
        }
        serve == are_blocks
    }

    /// Hands a list to a sink.
    #[inline(always)]
    pub(crate) fn test<K: Sink<S>>(&self, number: u32, sink: &mut K) -> ControlFlow<()> {
        let number = number as usize;
        match self {
            Self::Ids(ids) => {
                let n = ids.get(number).map_or(0, |&n| n as usize);
                sink.test(ids.get(number + 1..number + 1 + n).unwrap_or(&[]))
            }
            Self::Blocks(blocks) => sink.test_blocks(&blocks[number..]),
        }
    }

    /// Begins to load the beginning of a list that is not empty.
    #[inline(always)]
    pub(crate) fn prefetch(&self, number: u32) {
        match self {
            Self::Ids(ids) => prefetch(&ids[number as usize]),
            Self::Blocks(blocks) => prefetch(&blocks[number as usize]),
        }
    }

    /// The ids of a list.
    pub(crate) fn ids(&self, number: u32, into: &mut Vec<u32>) {
        into.clear();
        let number = number as usize;
        match self {
            Self::Ids(ids) => into.extend(ids[number + 1..].iter().take(ids[number] as usize)),
            Self::Blocks(all) => blocks::ids_of_list(&all[number..], into),
        }
    }

    /// Bytes of all lists.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Ids(ids) => size_of_val(ids.as_slice()),
            Self::Blocks(blocks) => size_of_val(blocks.as_slice()),
        }
    }
}
