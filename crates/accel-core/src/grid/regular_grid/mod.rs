//! Parts that regular grids share: frame, placement, traversal. They differ in cell storage.
//!
//! `uniform_grid.rs` (an array), `hashed_grid.rs` (a hash table) and `bricked_grid.rs` (blocks)
//! are this grid over one [`CellStorage`] each, so they have the same cells and do the same work.

mod contents;
mod frustum_traversal;
mod side_by_side;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::TooManyReferences;
use crate::grid::cell_traversal::{CellPosition, CellTraversal, Traversal};
use crate::grid::copies::{MOST_REFERENCES_A_COPY, are_copies};
use crate::grid::resolution::ResolutionRule;
use crate::grid::voxel_traversal::{GridFrame, IndexedCell};
use crate::grid::voxel_traversal_lanes::MOST_CELLS;
use crate::memory::{CountedItem, Limits};
use crate::params::config::{Config, Settings};
use crate::params::{ParamSpec, specs};
use crate::primitives::{PrimSet, Primitives};
use crate::query::batch;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::counters::{Counters, NoCounters};
use crate::query::kernel::ListBlocks;
use crate::query::side_by_side::LaneDriver;
use crate::query::sink::Sink;
use crate::structure::{Batches, BuildError, RayBatch, Structure, StructureStats, too_many};
use crate::update::{Change, ChangedLists, is_worth_changing};
use crate::variants::voxel_traversals::DoubleTraversal;
pub(crate) use contents::contents_of;
pub use contents::{Contents, GridConfig};
use side_by_side::BlockGrid;

/// Storage of the cell lists of a grid.
pub trait CellStorage: Sized + Send + Sync + 'static {
    /// Bytes that so many cells take, about, whether they hold ids or not.
    fn cell_bytes(cells: u128) -> u128 {
        4 * cells
    }
    /// Bytes that a reference takes, at most.
    const REFERENCE_BYTES: u64 = 4;
    /// True if the traversals that are there for comparison are compiled for it.
    const COMPARES_TRAVERSALS: bool = false;

    /// Its settings beside those of the grid.
    type Config: Config;

    /// Stores the lists that `contents` describes.
    ///
    /// # Errors
    /// [`TooManyReferences`] when they exceed `contents.max_references`.
    fn build<S: Scalar>(
        contents: &Contents<S>,
        config: &Self::Config,
    ) -> Result<Self, TooManyReferences>;

    /// Changes the lists of cells that `moved` primitives were in, or are in now: those of
    /// `contents`, of the same grid. `None` where it stores lists in a way that has no room for
    /// that: they are to be built anew.
    fn change<S: Scalar>(
        &mut self,
        _contents: &Contents<S>,
        _moved: &[u32],
    ) -> Option<ChangedLists> {
        None
    }

    /// The ids of a cell.
    fn list(&self, cell: &impl CellPosition) -> &[u32];
    /// Calls `each` with every list, in the order in which they stand; those that hold no ids may
    /// be left out.
    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32]));
    /// The number of cells that hold ids, the ids in all of them, and bytes.
    fn stats(&self) -> StructureStats;
}

/// The parameter of how rays of a batch are answered.
pub const QUERY_PARAM: ParamSpec = ParamSpec {
    summary: "batch has 32 rays of a batch take their steps side by side, with traversal=t-next and kernel=block \
              over triangles alone",
    ..specs::QUERY
};

/// The parameters of a regular grid with at most so many cells and references: how its cells are
/// made and traversed, what it does beside, and what comes behind mailboxes.
macro_rules! grid_params {
    ($cells:expr, $references:expr, [$($own:expr),*], [$($beside:expr),*] $(, $last:expr)*) => {
        &[
            $crate::params::specs::RESOLUTION,
            $crate::params::specs::DENSITY,
            $crate::params::specs::BOXES,
            $crate::params::specs::ORDER,
            $cells,
            $references,
            $($own,)*
            $crate::query::kernel::BLOCK_PARAM,
            $($beside,)*
            $crate::query::mailbox::PARAM,
            $crate::query::mailbox::SLOTS_PARAM,
            $($last,)*
        ]
    };
}
pub(crate) use grid_params;

/// A regular grid whose cells are kept in a `G`.
pub struct RegularGrid<S: Scalar, G> {
    frame: GridFrame<S>,
    storage: G,
    /// Traversals start at the ray's origin even if hits only count from `t_min` on, as in 1999.
    from_origin: bool,
    traversal: Traversal,
    is_batch: bool,
    /// Used by [`Traversal::Double`] only.
    wide_frame: GridFrame<f64>,
}

impl<S: Scalar, G: CellStorage> RegularGrid<S, G> {
    /// Position and size of its cells.
    pub fn frame(&self) -> &GridFrame<S> {
        &self.frame
    }

    /// The grid as its rays go side by side: one type, whatever the set and the counters.
    #[inline(always)]
    fn with_blocks<'a>(
        &'a self,
        blocks: &'a ListBlocks<S>,
    ) -> BlockGrid<'a, S, Self, impl Fn(usize) -> &'a [u32]> {
        let frame = &self.frame;
        let list = move |index| self.storage.list(&IndexedCell { frame, index });
        BlockGrid { grid: self, frame, from_origin: self.from_origin, list, blocks }
    }

    /// The ids in the cell of those coordinates.
    pub fn list(&self, coords: [i32; 3]) -> &[u32] {
        self.storage.list(&self.frame.cell(coords))
    }
}

impl<S: Scalar, G: CellStorage> Structure<S> for RegularGrid<S, G> {
    const HAS_LISTS: bool = true;

    type Config = GridConfig<G::Config>;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError> {
        let (contents, storage) =
            stored::<S, G, _>(prims, settings.limits(), settings, &settings.own)?;
        let (frame, from_origin) = (contents.frame, settings.historical);
        let (wide_frame, traversal) = (frame.in_double(), settings.traversal);
        let is_batch =
            settings.is_batch && traversal == Traversal::TNext && frame.cells() <= MOST_CELLS;
        Ok(Self { frame, storage, from_origin, traversal, is_batch, wide_frame })
    }

    fn update(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
        moved: &[u32],
    ) -> Result<Change, BuildError> {
        if settings.is_incremental && is_worth_changing(moved.len(), prims.len()) {
            let mut contents = contents_of(prims, settings.limits(), settings)?;
            let references = CountedItem { bytes: G::REFERENCE_BYTES, ..REFERENCES };
            contents.max_references = settings.limits().most(&references, settings.max_references);
            if contents.frame == self.frame
                && let Some(lists) = self.storage.change(&contents, moved)
            {
                return Ok(Change::Lists(lists));
            }
        }
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let t_start = if self.from_origin { S::ZERO } else { ray.t_min };
        match self.traversal {
            Traversal::TNext => {
                if let Some(traversal) = self.frame.traversal_from(ray, t_start) {
                    visit(traversal, &self.storage, sink);
                }
            }
            // refused: see `chosen_tests`
            Traversal::DrivingAxis | Traversal::Double if K::HAS_OTHER_TEST => {}
            Traversal::DrivingAxis => {
                if let Some(traversal) = self.frame.driving_traversal_from(ray, t_start) {
                    visit(traversal, &self.storage, sink);
                }
            }
            // the parameter of other grids does not offer what follows
            Traversal::Accumulate | Traversal::Double if !G::COMPARES_TRAVERSALS => {}
            Traversal::Accumulate => {
                if let Some(traversal) = self.frame.accumulating_traversal_from(ray, t_start) {
                    visit(traversal, &self.storage, sink);
                }
            }
            Traversal::Double => {
                if let Some(traversal) = DoubleTraversal::from(&self.wide_frame, ray, t_start) {
                    visit(traversal, &self.storage, sink);
                }
            }
        }
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.storage.lists(each);
    }

    #[inline(always)]
    fn batches<P: PrimSet<S>>(&self, _: &P, blocks: Option<&ListBlocks<S>>) -> Batches {
        let is_together = self.is_batch && blocks.is_some();
        if is_together { Batches::Together } else { Batches::RayByRay }
    }

    #[inline(always)]
    fn answer_batch<P: PrimSet<S>, C: Counters>(
        &self,
        prims: &P,
        blocks: Option<&ListBlocks<S>>,
        batch: RayBatch<'_, S>,
    ) -> C {
        if let Some(blocks) = blocks {
            let grid = &self.with_blocks(blocks);
            batch::answer::<LaneDriver, NoCounters, _, _, _>(grid, prims, batch, None);
        }
        C::default()
    }

    fn stats(&self) -> StructureStats {
        let (cells, resolution) = (self.frame.cells() as u64, Some(self.frame.resolution()));
        let occupied = self.storage.stats();
        StructureStats { cells, empty_cells: cells - occupied.cells, resolution, ..occupied }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        for cell in 0..self.frame.cells() {
            let list = self.list(self.frame.coords(cell));
            each(Cell::elementary(self.frame.cell_bounds(cell), 0, list));
        }
        Ok(())
    }
}

/// Visits cells until nothing closer can follow. A function for each traversal: in one for all four
/// registers are short.
#[inline(never)]
fn visit<S: Scalar>(
    mut traversal: impl CellTraversal<S>,
    storage: &impl CellStorage,
    sink: &mut impl Sink<S>,
) {
    loop {
        let list = storage.list(&traversal);
        sink.elementary_step(list.is_empty());
        if !list.is_empty() && sink.test(list).is_break() {
            return;
        }
        if sink.t_max() < traversal.t_exit() || !traversal.advance() {
            return;
        }
    }
}

const REFERENCES: CountedItem = CountedItem::references("references in voxels");

/// References a primitive, on average, beyond which a computed resolution is made coarser. On the
/// scenes of 1999 no rule needs more than 12.
const MAX_REFS_PER_PRIM: u64 = 64;

/// How many references a computed resolution may have.
fn soft_limit<S: Scalar>(prims: &dyn Primitives<S>) -> u64 {
    let number = prims.len() as u64;
    if are_copies(prims) {
        return MOST_REFERENCES_A_COPY * number;
    }
    (MAX_REFS_PER_PRIM * number).max(1 << 20)
}

/// Contents under the settings, and their storage. A resolution that is not given in
/// voxels is halved as long as it lists primitives too often: copies of one large primitive would
/// otherwise each go to all voxels.
///
/// # Errors
/// [`BuildError`] when the scene is too large for the scalar or the grid for its limits.
pub fn stored<'a, S: Scalar, G: CellStorage, C>(
    prims: &'a dyn Primitives<S>,
    limits: Limits,
    config: &GridConfig<C>,
    own: &G::Config,
) -> Result<(Contents<'a, S>, G), BuildError> {
    let mut contents = contents_of(prims, limits, config)?;
    let hard_limit = contents.max_references;
    let references = CountedItem { bytes: G::REFERENCE_BYTES, ..REFERENCES };
    let is_given = matches!(config.resolution, ResolutionRule::Fixed(_));
    let soft_limit = if is_given { hard_limit } else { soft_limit(prims) };
    loop {
        let is_final = is_given || contents.frame.cells() == 1;
        let allowed = if is_final { hard_limit } else { hard_limit.min(soft_limit) };
        contents.max_references = limits.most(&references, allowed);
        limits.fits(G::cell_bytes(contents.frame.cells() as u128))?;
        match G::build(&contents, own) {
            Ok(storage) => return Ok((contents, storage)),
            // memory alone is no reason for another resolution
            Err(TooManyReferences(n)) if is_final || n <= allowed => {
                return Err(too_many(limits, &references, hard_limit, n));
            }
            Err(_) => {
                let halved = contents.frame.resolution().map(|n| n.div_ceil(2));
                contents.frame = GridFrame::new(contents.frame.bounds(), halved);
            }
        }
    }
}
