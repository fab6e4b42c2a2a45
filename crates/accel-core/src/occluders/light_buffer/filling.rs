//! How the cells of a face are made: a coarse grid, and in its cells divisions where lists are
//! long and become shorter by it.
//!
//! What lies behind a primitive that hides the whole cell is left out first; a division is judged
//! by what then remains.

use glam::{DVec2, dvec2};

use crate::config;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::CellLists;
use crate::occluders::light_buffer::cell_part::{OutlineClipper, SPOT_BITS};
use crate::occluders::light_buffer::face_tree::{
    COVERED, Cells, DIVIDED, Face, LEVEL_BITS, LONG, Record,
};
use crate::occluders::light_buffer::margins::Margins;
use crate::occluders::light_buffer::projected::FaceCells;
use crate::parallel;
use crate::params::ParamSpec;

/// Subcells of a cell.
const FAN: usize = 16;
/// References that the cells of a coarse grid may have for each primitive, about.
const COARSE_GROWTH: f64 = 8.0;
/// In lists no longer than this it is not looked for what a division hides, if it only pays then.
const SHORT: usize = 48;
/// Rows of the coarse grid that are kept apart at once.
const ROWS_AT_ONCE: u32 = 32;

/// Finest cells per side of a face where the user leaves it open.
const AUTO_RESOLUTION: u32 = 16384;

config! {
    /// How the buffer is filled and asked.
    pub struct BufferConfig {
        /// finest cells per side of a face, at most; auto: 16384
        resolution: Option<u32> = ParamSpec::choice(
            "resolution",
            "auto",
            &["16", "32", "64", "128", "256", "512", "1024", "2048", "4096", "16384", "auto"],
        ) => |cells| cells.parse().ok(),
        /// cells with longer lists are divided
        divide: usize = ParamSpec::integer("divide", "16", 1, 1_000_000),
        /// cells are not divided further where that makes more references of one than this
        growth: f64 = ParamSpec::real("growth", "4", 1.0, 1e6),
        /// longer lists are left to wide-bvh
        longest: usize = ParamSpec::integer("longest", "512", 1, 1_000_000),
        /// MiB for the cells and lists of all lights; the rays to lights for which there is no
        /// room are left to wide-bvh
        pub(super) memory: usize = ParamSpec::integer("memory", "2048", 1, 1_000_000),
        /// rays one by one, or 16 of a batch in turns: each step asks for the memory of the next
        pub(super) is_batch: bool = ParamSpec::choice("query", "one", &["one", "batch"])
            => |query| query == "batch",
        /// full: what something that covers a cell hides is not listed; none: it is
        cut_off: bool = ParamSpec::choice("cut-off", "full", &["full", "none"]) => |cut| cut == "full",
    }
}

/// Makes the cells of a face.
pub(super) fn fill_face<S: Scalar>(
    shown: &FaceCells,
    config: &BufferConfig,
    margins: &Margins,
    out: &mut Cells<S>,
) -> Face<S> {
    let mut all = shown.footprints();
    let Some(first) = all.next() else { return Face::empty() };
    let bounds = (first.low, first.high);
    let (low, high) = all.fold(bounds, |(l, h), f| (l.min(f.low), h.max(f.high)));
    let finest = config.resolution.unwrap_or(AUTO_RESOLUTION).ilog2();
    let bits = coarse_bits(shown, high - low).min(finest);
    // whole levels below
    let shift = (finest - bits) / LEVEL_BITS * LEVEL_BITS;
    let first = out.cells.len() as u32;
    let (face, low, step) = Face::over(low, high, margins, [bits + shift, bits], first);
    out.cells.resize(out.cells.len() + (1 << (2 * bits)), 0);
    out.tally.inner += 1;
    let plan = FillPlan { shown, config, margins, low, step, shift, bits };
    plan.coarse(first, out);
    face
}

/// Input of all cells of a face.
struct FillPlan<'a> {
    shown: &'a FaceCells,
    config: &'a BufferConfig,
    margins: &'a Margins,
    low: DVec2,
    /// Extent of a finest cell.
    step: DVec2,
    /// Levels below the coarse grid, in bits.
    shift: u32,
    /// Bits of the coarse grid.
    bits: u32,
}

impl FillPlan<'_> {
    /// Makes the cells of the coarse grid, whose first is there.
    fn coarse<S: Scalar>(&self, first: u32, out: &mut Cells<S>) {
        let side = 1u32 << self.bits;
        let lists = self.coarse_lists();
        let row = |y: u32| {
            let mut filling = CellFiller {
                plan: self,
                out: Cells::new(),
                clip: OutlineClipper::default(),
                entries: Vec::new(),
            };
            let words: Vec<u32> = (0..side)
                .map(|x| {
                    let c = ((y << self.bits) + x) as usize;
                    let mut list = lists.at(c).to_vec();
                    let at = [x << self.shift, y << self.shift];
                    let (center, half) = self.rectangle(at, self.shift);
                    let cover = filling.prune(&mut list, center, half);
                    filling.cell(&list, cover, at, self.shift, [1.0, 1.0])
                })
                .collect();
            (words, filling.out)
        };
        for start in (0..side).step_by(ROWS_AT_ONCE as usize) {
            let end = (start + ROWS_AT_ONCE).min(side);
            let rows = parallel::map(start..end, &row);
            for (y, (words, cells)) in (start..end).zip(rows) {
                let moved = out.append(cells);
                let to = (first + (y << self.bits)) as usize;
                for (cell, word) in out.cells[to..].iter_mut().zip(words) {
                    *cell = moved(word);
                }
            }
        }
    }

    /// The numbers of the footprints in each cell of the coarse grid.
    fn coarse_lists(&self) -> CellLists {
        let cells = 1usize << (2 * self.bits);
        let batches = 0..self.shown.batches.len();
        let pairs = parallel::map(batches, &|batch| self.coarse_pairs(batch));
        CellLists::of_pairs(cells, pairs.iter().flatten())
    }

    /// The cells of the coarse grid that show a batch's footprints, with the numbers of these.
    fn coarse_pairs(&self, batch: usize) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for i in 0..self.shown.batches[batch].footprints.len() {
            let number = FaceCells::number(batch, i);
            self.cells_of(number, [0, 0], self.shift, self.bits, |c| pairs.push((c, number)));
        }
        pairs
    }

    /// Calls `emit` with each cell of a grid that shows the footprint: one of 2 to the power `bits`
    /// cells per side, of that size, which starts at `at`, in finest cells.
    fn cells_of(
        &self,
        number: u32,
        at: [u32; 2],
        shift: u32,
        bits: u32,
        mut emit: impl FnMut(u32),
    ) {
        let (f, batch) = self.shown.footprint(number);
        let (first, half) = self.rectangle(at, shift);
        let (cell, low) = (half * 2.0, first - half);
        // half a cell more on every side: the test below decides
        let last = DVec2::splat(f64::from((1u32 << bits) - 1));
        let from = ((f.low - low) / cell - 0.5).max(DVec2::ZERO);
        let to = ((f.high - low) / cell + 0.5).min(last);
        for y in from.y as u32..=to.y as u32 {
            for x in from.x as u32..=to.x as u32 {
                let center = first + dvec2(f64::from(x), f64::from(y)) * cell;
                if f.overlaps(batch.sides_of(f), center, half) {
                    emit((y << bits) + x);
                }
            }
        }
    }

    /// Centre and half extent of the cell of that size at `at`, in finest cells.
    fn rectangle(&self, at: [u32; 2], shift: u32) -> (DVec2, DVec2) {
        let half = self.step * (f64::from(1u32 << shift) * 0.5);
        (self.low + dvec2(f64::from(at[0]), f64::from(at[1])) * self.step + half, half)
    }

    /// A lower bound on the depth of a footprint within a cell.
    fn near(&self, number: u32, center: DVec2, half: DVec2) -> f64 {
        let (f, _) = self.shown.footprint(number);
        f.plane.as_ref().map_or(0.0, |plane| plane.near(center, half)).max(f.near)
    }
}

/// Makes cells one after the other.
struct CellFiller<'a, S> {
    plan: &'a FillPlan<'a>,
    out: Cells<S>,
    clip: OutlineClipper,
    entries: Vec<(f64, u32)>,
}

impl<S: Scalar> CellFiller<'_, S> {
    /// Leaves out of a cell's list what is hidden everywhere in it; says from which depth on
    /// everything is.
    fn prune(&self, list: &mut Vec<u32>, center: DVec2, half: DVec2) -> Option<f64> {
        let FillPlan { config, margins, .. } = self.plan;
        if !(config.cut_off && margins.can_multiply) {
            return None;
        }
        // directions that rounding brings into the cell are covered too
        let grown = half + margins.direction * 2.0;
        let far = |&i: &u32| {
            let (f, batch) = self.plan.shown.footprint(i);
            // a little less: footprints end where the face does, cells may not
            let plane = f.plane.as_ref().filter(|_| f.spans(center, half * 0.99))?;
            plane.covers(batch.edges_of(plane), center, grown)
        };
        let far = list.iter().filter_map(far).min_by(f64::total_cmp)? * (1.0 + margins.depth);
        list.retain(|&i| self.plan.near(i, center, half) <= far);
        Some(far)
    }

    /// Makes a cell of the footprints in `list`, dividing it where that pays. The first of
    /// `growth` says how many references each of those of the coarse cell has become, the second
    /// by how much the last division made them more: the next makes them more by at least about
    /// as much, so that one which would be given up need not be tried.
    fn cell(
        &mut self,
        list: &[u32],
        cover: Option<f64>,
        at: [u32; 2],
        shift: u32,
        growth: [f64; 2],
    ) -> u32 {
        let config = self.plan.config;
        let is_given_up = growth[0] * growth[1] > config.growth;
        if list.len() <= config.divide || shift < LEVEL_BITS || is_given_up {
            return self.leaf(list, cover, at, shift);
        }
        let below = shift - LEVEL_BITS;
        let sub = |k: u32| [at[0] + ((k & 3) << below), at[1] + ((k >> LEVEL_BITS) << below)];
        let mut parts: [(Vec<u32>, Option<f64>); FAN] = Default::default();
        let mut total = 0;
        for &i in list {
            self.plan.cells_of(i, at, below, LEVEL_BITS, |k| parts[k as usize].0.push(i));
        }
        let all: usize = parts.iter().map(|(part, _)| part.len()).sum();
        let is_hopeless = all as f64 * growth[0] > config.growth * list.len() as f64;
        if is_hopeless && list.len() <= SHORT {
            return self.leaf(list, cover, at, shift);
        }
        for (k, (part, part_cover)) in parts.iter_mut().enumerate() {
            let (center, half) = self.plan.rectangle(sub(k as u32), below);
            *part_cover = self.prune(part, center, half);
            total += part.len();
        }
        let more = (total as f64 / list.len() as f64).max(1.0);
        let growth = [growth[0] * more, more];
        // not worth it where nearly every primitive is seen in nearly every part
        if total * 4 > list.len() * FAN * 3 || growth[0] > config.growth {
            return self.leaf(list, cover, at, shift);
        }
        let first = self.out.cells.len();
        self.out.cells.resize(first + FAN, 0);
        self.out.tally.inner += 1;
        for (k, (part, cover)) in parts.iter().enumerate() {
            let word = self.cell(part, *cover, sub(k as u32), below, growth);
            self.out.cells[first + k] = word;
        }
        first as u32 | DIVIDED
    }

    fn leaf(&mut self, list: &[u32], cover: Option<f64>, at: [u32; 2], shift: u32) -> u32 {
        let tally = &mut self.out.tally;
        tally.leaves += 1;
        if list.is_empty() {
            tally.empty += 1;
            return 0;
        }
        let plan = self.plan;
        let (center, half) = plan.rectangle(at, shift);
        self.entries.clear();
        self.entries.extend(list.iter().map(|&i| (plan.near(i, center, half), i)));
        self.entries.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let first = self.out.records.len() as u32;
        let below = |x: f64| S::from_f64(x * (1.0 - plan.margins.depth)).next_down();
        let records = &mut self.out.records;
        if let Some(far) = cover {
            let near = S::from_f64(far).next_up();
            records.push(Record { near, id: COVERED, ..Record::end() });
            tally.covered += 1;
        }
        if self.entries.len() > plan.config.longest {
            tally.long += 1;
            let near = below(self.entries.first().map_or(0.0, |e| e.0));
            records.push(Record { near, id: LONG, ..Record::end() });
        } else {
            tally.references += self.entries.len() as u64;
            let spot = half * (2.0 / f64::from(1u32 << SPOT_BITS));
            for &(near, i) in &self.entries {
                let (f, batch) = plan.shown.footprint(i);
                let sides = batch.sides_of(f);
                let part = self.clip.part([f.low, f.high], sides, center - half, spot);
                records.push(Record { near: below(near), id: f.id, part });
            }
        }
        records.push(Record::end());
        first
    }
}

/// The resolution of a coarse grid, 2 to this power: about as many cells as footprints, fewer
/// where these are large.
fn coarse_bits(shown: &FaceCells, size: DVec2) -> u32 {
    let (mut n, mut area, mut edges) = (0.0, 0.0, 0.0);
    for f in shown.footprints() {
        let part = (f.high - f.low) / size;
        n += 1.0;
        area += part.x * part.y;
        edges += part.x + part.y;
    }
    let references = |r: f64| area * r * r + edges * r + n;
    let fits = |&bits: &u32| {
        let side = f64::from(1u32 << bits);
        side * side <= n * 2.0 && references(side) <= n * COARSE_GROWTH
    };
    (0..=8).rev().find(fits).unwrap_or(0)
}
