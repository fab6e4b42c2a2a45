//! The regular grid with its cells in a hash table: only occupied cells take memory.
//!
//! Paper: A. Glassner, "Space Subdivision for Fast Ray Tracing", IEEE CG&A 4(10), 1984, keeps the
//! cells of his octree in a hash table under a computed name; here the name is a cell's index in a
//! regular grid (see `uniform_grid.rs` for the papers on those).
//!
//! Deviations: open addressing with linear probing in place of chains, multiplicative hashing
//! (D. Knuth, "The Art of Computer Programming", volume 3, section 6.4) and a reduction to the
//! table's size by a product, so that any size serves. Keys are 64 bits: a virtual grid of 2048^3
//! voxels has more cells than a u32. No random seed: the same scene gives the same table.
//! A look-up probes at most as far as the farthest key of the build, even in a full table. Keys are
//! taken in their order.

use std::ops::Range;

use crate::config;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::{CellLists, ListOrder, TooManyReferences};
use crate::grid::cell_traversal::{CellPosition, Traversal};
use crate::grid::changed_cells::NewCells;
use crate::grid::regular_grid::{CellStorage, Contents, QUERY_PARAM, RegularGrid, grid_params};
use crate::parallel::{map, parts, ranges, sort, split_mut};
use crate::params::ParamSpec;
use crate::params::specs;
use crate::structure::{StructureInfo, StructureStats};
use crate::update::{ChangedLists, INCREMENTAL};

config! {
    /// Parameters of the hash table.
    pub struct TableConfig {
        /// occupied part of the hash table; more is smaller and slower
        load_factor: f64 = ParamSpec::real("load-factor", "0.5", 0.05, 1.0),
        /// how keys are spread; 'constant' gives all the same first choice: the worst case
        multiplier: u64 = ParamSpec::choice("hash", "multiplicative", &["multiplicative", "constant"]) => |hash| {
            // times 0, every key hashes to 0
            if hash == "constant" { 0 } else { GOLDEN }
        },
    }
}

pub static INFO: StructureInfo = StructureInfo {
    paper: "Glassner 1984 (hashed cells); Amanatides, Woo 1987 (traversal)",
    deviations: "linear probing, multiplicative hash, no chains; boxes as in uniform-grid",
    params: grid_params!(
        specs::max_cells("68719476736", 1 << 60)
            .about("upper limit for the number of voxels, occupied or not"),
        ParamSpec { default: "134217728", ..specs::MAX_REFERENCES },
        [TableConfig::PARAMS[0], TableConfig::PARAMS[1], Traversal::PARAM],
        [QUERY_PARAM, INCREMENTAL]
    ),
    also_tested: &[
        "kernel=scalar",
        "query=batch",
        "query=batch density=20",
        "density=20",
        "load-factor=0.9",
        "traversal=driving-axis",
        "mailbox=array",
    ],
    ..StructureInfo::new(
        "hashed-grid",
        "equal voxels in a hash table: only occupied ones take memory",
    )
};

/// A grid in a hash table.
pub type HashedGrid<S> = RegularGrid<S, HashedCells>;

/// 2^64 divided by the golden ratio: spreads equal strides evenly (Knuth 6.4).
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Up to so many cells a reference, and so many more, lists are made cell by cell, which takes no
/// more memory than the slots do; beyond that they are sorted. The same table comes of both.
const CELLS_PER_REFERENCE: u64 = 4;
const FEW_CELLS: u64 = 1 << 16;

/// No cell has this index: there are at most 2^60.
const VACANT: u64 = u64::MAX;

#[derive(Debug, Clone, Copy)]
struct Slot {
    key: u64,
    start: u32,
    len: u32,
}

impl Slot {
    const VACANT: Self = Self { key: VACANT, start: 0, len: 0 };
}

/// Open addressing by cell index.
#[derive(Debug, Clone)]
struct Table {
    slots: Vec<Slot>,
    occupied: usize,
    /// The farthest that any key stands from its first choice.
    farthest: usize,
    multiplier: u64,
}

impl Table {
    fn new(capacity: usize, multiplier: u64) -> Self {
        let slots = vec![Slot::VACANT; capacity.max(1)];
        Self { slots, occupied: 0, farthest: 0, multiplier }
    }

    /// First choice of a key: its hash, scaled to the size of the table.
    #[inline(always)]
    fn home(&self, key: u64) -> usize {
        let hash = key.wrapping_mul(self.multiplier);
        ((u128::from(hash) * self.slots.len() as u128) >> 64) as usize
    }

    /// The slot that holds `key`.
    #[inline(always)]
    fn find(&self, key: u64) -> Option<&Slot> {
        let mut at = self.home(key);
        for _ in 0..=self.farthest {
            let slot = self.slots.get(at)?;
            if slot.key == key {
                return Some(slot);
            }
            if slot.key == VACANT {
                return None;
            }
            at = if at + 1 == self.slots.len() { 0 } else { at + 1 };
        }
        None
    }

    /// The slot of `key`, taken if it is new; the table has room.
    fn slot(&mut self, key: u64) -> usize {
        let mut at = self.home(key);
        let mut distance = 0;
        while self.slots[at].key != key {
            if self.slots[at].key == VACANT {
                self.slots[at].key = key;
                self.occupied += 1;
                self.farthest = self.farthest.max(distance);
                break;
            }
            at = if at + 1 == self.slots.len() { 0 } else { at + 1 };
            distance += 1;
        }
        at
    }

    /// The table of these keys, taken in turn, with the lengths of their lists, which stand in the
    /// order of slots.
    fn of(cells: &[(u64, u32)], load_factor: f64, multiplier: u64) -> Self {
        let capacity = (cells.len() as f64 / load_factor).ceil() as usize;
        let mut table = Self::new(capacity.max(cells.len()), multiplier);
        for &(key, len) in cells {
            let at = table.slot(key);
            table.slots[at].len = len;
        }
        let mut sum = 0;
        for slot in &mut table.slots {
            slot.start = sum;
            sum += slot.len;
        }
        table
    }
}

/// The occupied cells of a grid, and those that were occupied in a frame before.
pub struct HashedCells {
    table: Table,
    ids: Vec<u32>,
    /// Keys at most: a table that a change would make fuller is built anew.
    most_keys: usize,
}

impl HashedCells {
    fn with_hash<S: Scalar>(
        contents: &Contents<S>,
        load_factor: f64,
        multiplier: u64,
    ) -> Result<Self, TooManyReferences> {
        let total = contents.count_references();
        if total > contents.max_references.min(u64::from(u32::MAX)) {
            return Err(TooManyReferences(total));
        }
        let frame = contents.frame;
        let built = |cells: &[(u64, u32)]| {
            let table = Table::of(cells, load_factor, multiplier);
            let most_keys = table.occupied.midpoint(table.slots.len());
            Self { table, ids: vec![0; total as usize], most_keys }
        };
        if frame.cells() as u64 <= CELLS_PER_REFERENCE * total + FEW_CELLS {
            let lists = contents.dense_lists()?;
            let cells = lists.lists().zip(0..).filter(|(list, _)| !list.is_empty());
            let cells: Vec<_> = cells.map(|(list, key)| (key, list.len() as u32)).collect();
            let mut hashed = built(&cells);
            hashed.fill(&|key| lists.list(key as usize));
            return Ok(hashed);
        }
        // a number that orders ids as their lists do
        let placed = |id: u32| if contents.order == ListOrder::File { id } else { !id };
        let mut pairs = Vec::with_capacity(total as usize);
        for id in 0..contents.primitives as u32 {
            contents.cells_of(id, |c| pairs.push((frame.index(c) as u64, placed(id))));
        }
        sort(&mut pairs);
        let lists = || pairs.chunk_by(|a, b| a.0 == b.0);
        let cells: Vec<_> = lists().map(|list| (list[0].0, list.len() as u32)).collect();
        let mut hashed = built(&cells);
        for list in lists() {
            let slot = hashed.table.slot(list[0].0);
            let start = hashed.table.slots[slot].start as usize;
            let ids = hashed.ids[start..].iter_mut();
            ids.zip(list).for_each(|(slot, &(_, id))| *slot = placed(id));
        }
        Ok(hashed)
    }

    /// Copies the list of each key to where its slot says, on all threads.
    fn fill<'a>(&mut self, list: &(dyn Fn(u64) -> &'a [u32] + Sync)) {
        let slots = &self.table.slots;
        let parts = ranges(slots.len(), parts(slots.len()));
        let length =
            |part: &Range<usize>| slots[part.clone()].iter().map(|slot| slot.len as usize).sum();
        let mut jobs: Vec<_> =
            parts.iter().zip(split_mut(&mut self.ids, parts.iter().map(length))).collect();
        map(&mut jobs, &|(part, ids)| {
            let mut next = 0;
            for slot in slots[(*part).clone()].iter().filter(|slot| slot.key != VACANT) {
                let end = next + slot.len as usize;
                ids[next..end].copy_from_slice(list(slot.key));
                next = end;
            }
        });
    }

    /// The most slots that a look-up may inspect.
    pub fn probe_bound(&self) -> usize {
        self.table.farthest + 1
    }
}

impl CellStorage for HashedCells {
    type Config = TableConfig;

    /// Only occupied cells take memory: the reference that occupies one counts its slots.
    fn cell_bytes(_: u128) -> u128 {
        0
    }
    /// An id, and the slots of a table that is half full.
    const REFERENCE_BYTES: u64 = 4 + 2 * size_of::<Slot>() as u64;

    fn build<S: Scalar>(
        contents: &Contents<S>,
        config: &TableConfig,
    ) -> Result<Self, TooManyReferences> {
        Self::with_hash(contents, config.load_factor, config.multiplier)
    }

    fn change<S: Scalar>(&mut self, contents: &Contents<S>, moved: &[u32]) -> Option<ChangedLists> {
        let Self { table, ids, most_keys } = self;
        let (frame, mut has_room) = (contents.frame, true);
        let gained = NewCells::of(contents, moved, |coords| {
            let key = frame.index(coords) as u64;
            has_room &= table.occupied < *most_keys || table.find(key).is_some();
            if has_room { table.slot(key) } else { 0 }
        })?;
        if !has_room {
            return None;
        }
        let starts = table.slots.iter().map(|slot| slot.start).chain([ids.len() as u32]);
        let mut lists = CellLists::of_parts(starts.collect(), std::mem::take(ids));
        let changed = lists.change(moved, &gained);
        let (starts, changed_ids) = lists.into_parts();
        for (slot, at) in table.slots.iter_mut().zip(starts.windows(2)) {
            (slot.start, slot.len) = (at[0], at[1] - at[0]);
        }
        *ids = changed_ids;
        changed
    }

    #[inline(always)]
    fn list(&self, cell: &impl CellPosition) -> &[u32] {
        let Some(slot) = self.table.find(cell.index() as u64) else { return &[] };
        self.ids.get(slot.start as usize..(slot.start + slot.len) as usize).unwrap_or(&[])
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.table
            .slots
            .iter()
            .filter_map(|s| self.ids.get(s.start as usize..(s.start + s.len) as usize))
            .for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let (slots, ids) = (self.table.slots.as_slice(), self.ids.as_slice());
        StructureStats {
            cells: slots.iter().filter(|slot| slot.len > 0).count() as u64,
            references: ids.len() as u64,
            bytes: (size_of_val(slots) + size_of_val(ids)) as u64,
            ..StructureStats::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::regular_grid::{GridConfig, contents_of};
    use crate::params::config::Settings;
    use crate::structures::test_scenes::mixed_scene;

    #[test]
    fn a_constant_hash_and_a_full_table_hold_the_same_lists() {
        // HARD_CASES Gr7
        let set = mixed_scene::<f64>(60, 7, [1.0; 3]);
        let mut sparse = 0;
        for (name, value) in [("density", "4"), ("resolution", "48x48x48")] {
            let settings: Settings<GridConfig<TableConfig>> =
                Settings::of(&INFO.defaults().set(name, value).unwrap());
            let contents = contents_of(&set, settings.limits(), &settings).unwrap();
            let frame = contents.frame;
            let dense = contents.lists(frame.cells(), |c| frame.index(c)).unwrap();
            let dense_up_to = CELLS_PER_REFERENCE * dense.references() as u64 + FEW_CELLS;
            sparse += u32::from(frame.cells() as u64 > dense_up_to);
            for (load, multiplier) in [(0.5, GOLDEN), (1.0, GOLDEN), (1.0, 0), (0.3, 0)] {
                let hashed = HashedCells::with_hash(&contents, load, multiplier).unwrap();
                let occupied = dense.cells() - dense.empty_cells();
                assert_eq!(hashed.table.occupied, occupied);
                assert!(hashed.probe_bound() <= occupied);
                if load == 1.0 {
                    assert_eq!(hashed.table.slots.len(), occupied);
                }
                let n = frame.resolution().map(|n| n as i32);
                for i in 0..n[0] * n[1] * n[2] {
                    let c = [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
                    assert_eq!(hashed.list(&frame.cell(c)), dense.list(frame.index(c)), "{c:?}");
                }
            }
        }
        assert_eq!(sparse, 1, "both ways are taken");
        let settings: Settings<GridConfig<TableConfig>> = Settings::of(&INFO.defaults());
        let contents = contents_of(&set, settings.limits(), &settings).unwrap();
        let usual = HashedCells::with_hash(&contents, 0.5, GOLDEN).unwrap();
        assert!(usual.probe_bound() <= 64, "{}", usual.probe_bound());
    }
}
