//! From primitives to cells: the top grid, and its cells divided where lists are long.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::CellLists;
use crate::memory::{CountedItem, Limits};
use crate::parallel;
use crate::structure::{BuildError, too_many};
use crate::structures::irregular_grid::cells::{Cell, Cells, DIVIDED};
use crate::structures::irregular_grid::empty_boxes::EmptyBoxes;
use crate::structures::irregular_grid::lattice::Division;
use crate::structures::irregular_grid::place::{Pair, Placement};

/// How cells are divided.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    /// Lists no longer than this are left alone.
    pub(super) longest_list: usize,
    /// Parts wanted for each primitive of a cell that is divided.
    pub(super) density: f64,
    /// Cost of a traversal step, in units of a primitive test.
    pub(super) step_cost: f64,
    pub(super) limits: Limits,
    /// Limit for the references in all lists, but for that of memory.
    pub(super) max_references: u64,
    /// Limit of the factor by which the divisions on a path multiply references, and so of the
    /// average number of references per primitive.
    pub(super) max_growth: f64,
}

/// Divides. Parts with many primitives are divided by all threads of the pool; how the work is
/// shared out depends on the scene alone, so that any number of threads gives the same cells.
pub(super) fn subdivide<S: Scalar>(
    placement: Placement<'_, S>,
    settings: Settings,
) -> Result<Cells, BuildError> {
    let whole = placement.lattice.whole();
    let ids: Vec<u32> = (0..placement.primitives() as u32).collect();
    let pairs = placement.place_all(&ids, &whole);
    let growth = pairs.iter().map(Vec::len).sum::<usize>() as f64 / ids.len() as f64;
    let shared = SharedInput { placement, settings, stored: &AtomicU64::new(0) };
    shared.divide_large(&whole, &pairs, growth)
}

const REFERENCES: CountedItem = CountedItem::references("references in cells");

/// Divisions of more references than this are shared out.
const LARGE: usize = 1 << 13;
/// Into about so many groups of parts.
const GROUPS: usize = 32;

/// Above this number of primitives, a sample of them is placed first.
const SAMPLED: usize = 1 << 9;
/// Minimum size of the sample.
const SAMPLE: usize = 1 << 6;

/// Input shared by all threads.
#[derive(Clone, Copy)]
struct SharedInput<'a, S: Scalar> {
    placement: Placement<'a, S>,
    settings: Settings,
    /// Ids stored by all together.
    stored: &'a AtomicU64,
}

impl<S: Scalar> SharedInput<'_, S> {
    /// Cells of the parts of a division, whose entries come first.
    /// `growth`: references to a primitive on average, this division included.
    fn divide_large(
        &self,
        division: &Division,
        pairs: &[Vec<Pair>],
        growth: f64,
    ) -> Result<Cells, BuildError> {
        let count = division.count();
        let lists = CellLists::of_pairs(count, pairs.iter().flatten());
        let empty = EmptyBoxes::new(division.parts, |part| lists.at(part).is_empty());
        let mut groups: Vec<Range<usize>> = Vec::new();
        let wanted = (lists.references() + count) / GROUPS + 1;
        let (mut start, mut weight) = (0, 0);
        for part in 0..count {
            weight += lists.at(part).len() + 1;
            if weight >= wanted || part + 1 == count {
                groups.push(start..part + 1);
                (start, weight) = (part + 1, 0);
            }
        }
        let divide = |group: &Range<usize>| -> Result<Cells, BuildError> {
            let mut worker = Worker {
                shared: *self,
                cells: Cells::new(self.settings.limits.structure, group.len()),
                pairs: Vec::new(),
                known: HashMap::default(),
            };
            for (i, part) in group.clone().enumerate() {
                let entry = worker.part(lists.at(part), part, division, &empty, growth)?;
                worker.cells.entries[i] = entry;
            }
            Ok(worker.cells)
        };
        let divided = parallel::map(&groups, &divide);
        let mut cells = Cells::new(self.settings.limits.structure, count);
        cells.divided = 1;
        for (group, part) in groups.iter().zip(divided) {
            cells.absorb(part?, group.start, group.len())?;
        }
        empty.share(&mut cells.entries[..count]);
        Ok(cells)
    }
}

struct Worker<'a, S: Scalar> {
    shared: SharedInput<'a, S>,
    cells: Cells,
    /// Pairs of the current division.
    pairs: Vec<Pair>,
    /// Lists that are stored, by their hash.
    known: HashMap<u64, u32, BuildHasherDefault<IdHasher>>,
}

impl<S: Scalar> Worker<'_, S> {
    /// Makes entries for the parts that `pairs` speaks of; the number of the first.
    fn divide(&mut self, division: &Division, growth: f64) -> Result<u32, BuildError> {
        let (first_entry, count) = (self.cells.entries.len(), division.count());
        self.cells.entries.resize(first_entry + count, 0);
        self.cells.check()?;
        self.cells.divided += 1;
        let lists = CellLists::of_pairs(count, self.pairs.iter());
        let empty = EmptyBoxes::new(division.parts, |part| lists.at(part).is_empty());
        for part in 0..count {
            let entry = self.part(lists.at(part), part, division, &empty, growth)?;
            self.cells.entries[first_entry + part] = entry;
        }
        empty.share(&mut self.cells.entries[first_entry..first_entry + count]);
        Ok(first_entry as u32)
    }

    /// The entry of a part with these ids; of no meaning for an empty one that another part's
    /// entry stands for.
    fn part(
        &mut self,
        ids: &[u32],
        part: usize,
        division: &Division,
        empty: &EmptyBoxes,
        growth: f64,
    ) -> Result<u32, BuildError> {
        let first = division.part(part);
        if !ids.is_empty() {
            return self.entry(ids, first, division.shift, growth);
        }
        let (corner, last) = empty.around(part);
        if corner != part {
            return Ok(0);
        }
        let last = |k: usize| division.first[k] + ((last[k] + 1) << division.shift[k]) - 1;
        self.cell(&[], first, std::array::from_fn(last))
    }

    /// The entry of a cell with these ids: it is divided if that pays.
    fn entry(
        &mut self,
        ids: &[u32],
        first: [u32; 3],
        levels: [u32; 3],
        growth: f64,
    ) -> Result<u32, BuildError> {
        let n = ids.len();
        let settings = self.shared.settings;
        if n > settings.longest_list
            && let Some(division) = self.division(n, first, levels)
            && (n <= SAMPLED || self.may_pay(ids, &division, growth))
        {
            let large = if n > LARGE {
                let pairs = self.shared.placement.place_all(ids, &division);
                self.pairs.clear();
                self.pairs.extend(pairs.iter().flatten());
                Some(pairs)
            } else {
                self.shared.placement.place(ids, &division, &mut self.pairs);
                None
            };
            let parts = division.count() as f64;
            let half_area = |levels| {
                let [x, y, z] = self.size(levels);
                x * y + y * z + z * x
            };
            // a line that meets the cell meets a part with this probability
            let met = half_area(division.shift) / half_area(levels);
            let step = settings.step_cost;
            let divided = (step * parts + self.pairs.len() as f64) * met;
            let pays = divided < step + n as f64;
            let growth = growth * self.pairs.len() as f64 / n as f64;
            if pays && growth <= settings.max_growth && !self.repeats(n, division.count()) {
                let logs: [u32; 3] = std::array::from_fn(|k| levels[k] - division.shift[k]);
                let entry = match large {
                    Some(pairs) => {
                        let cells = self.shared.divide_large(&division, &pairs, growth)?;
                        let at = self.cells.entries.len();
                        self.cells.entries.resize(at + division.count(), 0);
                        self.cells.absorb(cells, at, division.count())?;
                        at as u32
                    }
                    None => self.divide(&division, growth)?,
                };
                return Ok(DIVIDED | logs[0] << 29 | logs[1] << 27 | logs[2] << 25 | entry);
            }
        }
        self.cell(ids, first, std::array::from_fn(|k| first[k] + (1 << levels[k]) - 1))
    }

    /// Returns whether a sample of the primitives suggests that a division pays; placing all of
    /// them in vain costs as much as that many parts.
    fn may_pay(&mut self, ids: &[u32], division: &Division, growth: f64) -> bool {
        let every = ids.len() / SAMPLE;
        let sample: Vec<u32> = ids.iter().copied().step_by(every).collect();
        self.shared.placement.place(&sample, division, &mut self.pairs);
        let predicted = growth * self.pairs.len() as f64 / sample.len() as f64;
        // twice: a sample may mislead
        predicted <= 2.0 * self.shared.settings.max_growth
            && !self.repeats(sample.len(), division.count())
    }

    /// Returns whether a part would have the whole list and others most of it: the primitives meet
    /// in a point or line, and would do so in parts of any size.
    fn repeats(&self, n: usize, parts: usize) -> bool {
        if self.pairs.len() < 2 * n {
            return false;
        }
        let mut counts = vec![0usize; parts];
        for &(part, _) in &self.pairs {
            counts[part as usize] += 1;
        }
        counts.contains(&n)
    }

    /// Sides of a cell of that size.
    fn size(&self, levels: [u32; 3]) -> [f64; 3] {
        let side = self.shared.placement.lattice.side;
        std::array::from_fn(|k| side[k] * f64::from(1u32 << levels[k]))
    }

    /// How to divide a cell with so many primitives, if it can be.
    fn division(&self, n: usize, first: [u32; 3], levels: [u32; 3]) -> Option<Division> {
        let size = self.size(levels);
        let volume: f64 = size.iter().product();
        let per_length = (self.shared.settings.density * n as f64 / volume).cbrt();
        let shift: [u32; 3] = std::array::from_fn(|k| {
            let log = (size[k] * per_length).log2().round().clamp(0.0, 3.0);
            levels[k].saturating_sub(log as u32)
        });
        let parts = std::array::from_fn(|k| 1 << (levels[k] - shift[k]));
        (shift != levels).then_some(Division { first, shift, parts })
    }

    fn cell(&mut self, ids: &[u32], first: [u32; 3], last: [u32; 3]) -> Result<u32, BuildError> {
        self.cells.references += ids.len() as u64;
        let stored = self.shared.stored.fetch_add(ids.len() as u64, Ordering::Relaxed);
        let list = self.list(ids);
        let Settings { limits, max_references, .. } = self.shared.settings;
        if stored > limits.most(&REFERENCES, max_references).min(u64::from(u32::MAX)) {
            return Err(too_many(limits, &REFERENCES, max_references, stored));
        }
        let number = self.cells.cells.len() as u32;
        self.cells.cells.push(Cell {
            first: first.map(|x| x as u16),
            last: last.map(|x| x as u16),
            list,
        });
        Ok(number)
    }

    /// Stores a list and returns its place; equal lists are stored once.
    fn list(&mut self, ids: &[u32]) -> u32 {
        if ids.is_empty() {
            return 0;
        }
        let mut hash = IdHasher::default();
        ids.iter().for_each(|&id| hash.write_u32(id));
        let at = self.cells.lists.len() as u32;
        let known = *self.known.entry(hash.finish()).or_insert(at);
        // another list of the same hash is stored again, which does no harm
        if known != at && self.cells.list(known) == ids {
            return known;
        }
        self.cells.lists.push(ids.len() as u32);
        self.cells.lists.extend_from_slice(ids);
        at
    }
}

/// A quick hash of numbers: a product each, its high bits folded in (the multiplier of D. Knuth,
/// TAOCP 2, 3.3.4).
#[derive(Debug, Default, Clone, Copy)]
struct IdHasher(u64);

impl Hasher for IdHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&b| self.write_u32(b.into()));
    }
    fn write_u32(&mut self, x: u32) {
        let h = (self.0 ^ u64::from(x)).wrapping_mul(6364136223846793005);
        self.0 = h ^ h >> 32;
    }
    fn write_u64(&mut self, x: u64) {
        // what is hashed here is a hash
        self.0 = x;
    }
}
