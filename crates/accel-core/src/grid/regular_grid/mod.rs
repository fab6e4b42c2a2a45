//! What the regular grids share: frame, placement, traversal. They differ in where cells are stored.
//!
//! `uniform_grid.rs` (an array), `hashed_grid.rs` (a hash table) and `bricked_grid.rs` (blocks)
//! are this grid over one [`CellStorage`] each, so they have the same cells and do the same work.

mod frustum_traversal;
mod side_by_side;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::block_lists::{BlockPlacement, CellRows, DenseRows, block_lists};
use crate::grid::cell_lists::{CellLists, ListOrder, Placement, TooManyReferences};
use crate::grid::cell_overlap::{Insertion, overlaps};
use crate::grid::cell_traversal::{CellPosition, CellTraversal, Traversal};
use crate::grid::resolution::{ResolutionInput, ResolutionRule, divided_bounds, resolve};
use crate::grid::voxel_traversal::{GridFrame, IndexedCell};
use crate::grid::voxel_traversal_lanes::MOST_CELLS;
use crate::historical::bounds_rule::{BoundsOf, BoundsRule};
use crate::memory::Counted;
use crate::memory::Limits;
use crate::params::Params;
use crate::params::config::{Config, Settings};
use crate::params::specs;
use crate::primitives::PrimSet;
use crate::query::batch;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel::ListBlocks;
use crate::query::side_by_side::InLanes;
use crate::query::sink::Sink;
use crate::structure::too_many;
use crate::structure::{BatchAnswers, Batches, BuildError, Structure, StructureStats};
use crate::update::{Change, ChangedLists, is_incremental, is_worth_changing};
use crate::variants::double_traversal::DoubleTraversal;
use side_by_side::InBlocks;

/// Where the lists of a grid's cells are kept.
pub trait CellStorage: Sized + Send + Sync + 'static {
    /// Bytes that so many cells take, about, whether they hold ids or not.
    fn cell_bytes(cells: u128) -> u128 {
        4 * cells
    }
    /// Bytes that a reference takes, at most.
    const REFERENCE_BYTES: u64 = 4;
    /// Whether the traversals that are there for comparison are compiled for it.
    const COMPARES_TRAVERSALS: bool = false;
    /// Whether rays of a batch can go side by side: what that takes is compiled for it.
    const HAS_BATCHES: bool = false;

    /// Its settings beside those of the grid.
    type Config: Config;

    /// Stores the lists that `contents` describes.
    ///
    /// # Errors
    /// [`TooManyReferences`] when they exceed `contents.max_references`.
    fn build<S: Scalar, P: PrimSet<S>>(
        contents: &Contents<S, P>,
        config: &Self::Config,
    ) -> Result<Self, TooManyReferences>;

    /// Changes the lists of cells that `moved` primitives were in, or are in now: those of `contents`, of the same
    /// grid. `None` where it stores lists in a way that has no room for that: they are to be built anew.
    fn change<S: Scalar, P: PrimSet<S>>(
        &mut self,
        _contents: &Contents<S, P>,
        _moved: &[u32],
    ) -> Option<ChangedLists> {
        None
    }

    /// The ids of a cell.
    fn list(&self, cell: &impl CellPosition) -> &[u32];
    /// Calls `each` with every list, in the order in which they stand; those that hold no ids may be left out.
    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32]));
    /// Cells that hold ids.
    fn occupied_cells(&self) -> u64;
    /// Ids in all cells together.
    fn references(&self) -> u64;
    /// Bytes occupied.
    fn bytes(&self) -> u64;
}

/// What a storage is built from: which primitive goes to which cells.
pub struct Contents<'a, S: Scalar, P: PrimSet<S>> {
    /// The grid.
    pub frame: GridFrame<S>,
    /// Number of primitives.
    pub primitives: usize,
    /// Order of ids in a cell.
    pub order: ListOrder,
    /// Limit for references.
    pub max_references: u64,
    boxes: BoundsOf<'a, S, P>,
    historical: bool,
    insertion: Insertion,
}

impl<S: Scalar, P: PrimSet<S>> Contents<'_, S, P> {
    /// First and last cell of primitive `id` on each axis.
    #[inline(always)]
    pub fn range(&self, id: u32) -> ([i32; 3], [i32; 3]) {
        if self.insertion != Insertion::PaddedBox {
            return self.range_compared(id);
        }
        let b = self.boxes.of(id);
        if self.historical { self.frame.range_by_division(&b) } else { self.frame.range(&b) }
    }

    /// The box that decides where primitive `id` goes.
    #[inline(always)]
    pub fn box_of(&self, id: u32) -> Aabb<S> {
        self.boxes.of(id)
    }

    /// By how much boxes are padded.
    pub fn padding(&self) -> S {
        self.boxes.padding()
    }

    #[cold]
    #[inline(never)]
    fn range_compared(&self, id: u32) -> ([i32; 3], [i32; 3]) {
        match self.insertion.is_padded() {
            true => self.frame.range(&self.boxes.of(id)),
            false => self.frame.range(&self.boxes.prims().bounds(id)),
        }
    }

    /// The cells of [`Contents::range`] that the primitive overlaps itself.
    #[cold]
    #[inline(never)]
    fn overlapped(&self, id: u32) -> Vec<[i32; 3]> {
        let margin = if self.insertion.is_padded() { self.boxes.padding().to_f64() } else { 0.0 };
        let wide = self.frame.in_double();
        let (first, last) = self.range(id);
        let (mut cells, mut balls) = (Vec::new(), Vec::new());
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let cell = wide.cell_bounds(wide.index([x, y, z])).expanded(margin);
                    let corners = (cell.min, cell.max);
                    if overlaps(self.boxes.prims(), id, corners, &mut balls) {
                        cells.push([x, y, z]);
                    }
                }
            }
        }
        cells
    }

    /// Calls `emit` with the coordinates of every cell primitive `id` goes to, x fastest.
    #[inline(always)]
    pub fn cells_of(&self, id: u32, mut emit: impl FnMut([i32; 3])) {
        if self.insertion.is_exact() {
            return self.overlapped(id).into_iter().for_each(emit);
        }
        let (first, last) = self.range(id);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    emit([x, y, z]);
                }
            }
        }
    }

    /// All references together, without visiting cells.
    pub fn count_references(&self) -> u64 {
        let cells = |id| {
            let (first, last) = self.range(id);
            (0..3).map(|k| (last[k] - first[k] + 1).max(0) as u64).product::<u64>()
        };
        (0..self.primitives as u32).map(cells).fold(0, u64::saturating_add)
    }

    /// The lists in one array, those of the frame's cells in their order.
    ///
    /// # Errors
    /// [`TooManyReferences`].
    pub fn dense_lists(&self) -> Result<CellLists, TooManyReferences> {
        if self.insertion.is_exact() {
            return self.lists(self.frame.cells(), |c| self.frame.index(c));
        }
        self.lists_of_rows(&DenseRows::new(self.frame.resolution()))
    }

    /// The lists in one array, where `rows` says; of boxes, not exact ones.
    pub(crate) fn lists_of_rows(
        &self,
        rows: &impl CellRows,
    ) -> Result<CellLists, TooManyReferences> {
        block_lists(rows, self.primitives, self.order, self.max_references, self)
    }

    /// The lists in one array, `cells` of them, cell `coords` at `index(coords)`.
    ///
    /// # Errors
    /// [`TooManyReferences`].
    pub fn lists(
        &self,
        cells: usize,
        index: impl Fn([i32; 3]) -> usize,
    ) -> Result<CellLists, TooManyReferences> {
        struct Indexed<'c, 'a, S: Scalar, P: PrimSet<S>, F>(&'c Contents<'a, S, P>, F);
        impl<S: Scalar, P: PrimSet<S>, F: Fn([i32; 3]) -> usize> Placement for Indexed<'_, '_, S, P, F> {
            #[inline(always)]
            fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
                self.0.cells_of(id, |c| emit((self.1)(c)));
            }
        }
        if !self.insertion.is_exact() {
            // before any cell is visited: identical primitives may be in all of them
            let needed = self.count_references();
            if needed > self.max_references {
                return Err(TooManyReferences(needed));
            }
        }
        let placement = Indexed(self, index);
        CellLists::build(cells, self.primitives, self.order, self.max_references, &placement)
    }
}

impl<S: Scalar, P: PrimSet<S>> BlockPlacement for Contents<'_, S, P> {
    #[inline(always)]
    fn block(&self, id: u32) -> ([i32; 3], [i32; 3]) {
        self.range(id)
    }
}

/// Box margin of cones in Havran and Sixta's uniform grid, as fitted to their counters.
const HISTORICAL_CONE_MARGIN: f64 = 0.0006;

/// The settings of [`crate::params::specs`] and of storage: what a structure does not list has its default.
#[derive(Debug, Clone)]
pub struct GridConfig<C> {
    resolution: ResolutionRule,
    density: f64,
    pub(crate) max_cells: u64,
    pub(crate) max_references: u64,
    pub(crate) historical: bool,
    order: ListOrder,
    insertion: Insertion,
    traversal: Traversal,
    pub(crate) is_incremental: bool,
    is_batch: bool,
    storage: C,
}

impl<C: Config> Config for GridConfig<C> {
    fn of(params: &Params) -> Self {
        let is_reverse = params.get("order") == Some("reverse");
        Self {
            resolution: params.resolution("resolution"),
            density: params.real("density"),
            max_cells: params.integer("max-cells"),
            max_references: params.integer("max-references"),
            historical: params.get("boxes") == Some("historical"),
            order: if is_reverse { ListOrder::Reverse } else { ListOrder::File },
            insertion: Insertion::of(params),
            traversal: Traversal::of(params),
            is_incremental: is_incremental(params),
            is_batch: params.get(specs::QUERY.name) == Some("batch"),
            storage: C::of(params),
        }
    }
}

/// A regular grid whose cells are kept in a `G`.
pub struct RegularGrid<S: Scalar, G> {
    frame: GridFrame<S>,
    storage: G,
    /// Traversals start at the ray's origin even if hits only count from `t_min` on, as in 1999.
    from_origin: bool,
    traversal: Traversal,
    is_batch: bool,
    /// For [`Traversal::Double`].
    wide_frame: GridFrame<f64>,
}

impl<S: Scalar, G: CellStorage> RegularGrid<S, G> {
    /// Where its cells are.
    pub fn frame(&self) -> &GridFrame<S> {
        &self.frame
    }

    /// The ids in the cell of those coordinates.
    pub fn list(&self, coords: [i32; 3]) -> &[u32] {
        self.storage.list(&self.frame.cell(coords))
    }
}

impl<S: Scalar, G: CellStorage> Structure<S> for RegularGrid<S, G> {
    const HAS_LISTS: bool = true;

    type Config = GridConfig<G::Config>;

    fn build<P: PrimSet<S>>(
        prims: &P,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError> {
        let (contents, storage) = stored::<S, P, G>(prims, settings.limits(), settings)?;
        let (frame, from_origin) = (contents.frame, settings.historical);
        let (wide_frame, traversal) = (frame.in_double(), settings.traversal);
        let is_batch =
            settings.is_batch && traversal == Traversal::TNext && frame.cells() <= MOST_CELLS;
        Ok(Self { frame, storage, from_origin, traversal, is_batch, wide_frame })
    }

    fn update<P: PrimSet<S>>(
        &mut self,
        prims: &P,
        settings: &Settings<Self::Config>,
        moved: &[u32],
    ) -> Result<Change, BuildError> {
        if settings.is_incremental && is_worth_changing(moved.len(), prims.len()) {
            let mut contents = contents_of(prims, settings.limits(), settings)?;
            let references = Counted { bytes: G::REFERENCE_BYTES, ..REFERENCES };
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
    fn batches_of_blocks(&self) -> Batches {
        if G::HAS_BATCHES && self.is_batch { Batches::Together } else { Batches::RayByRay }
    }

    #[inline(always)]
    fn answer_batch_by_blocks<P: PrimSet<S>>(
        &self,
        blocks: &ListBlocks<S>,
        prims: &P,
        rays: &[Ray<S>],
        reach: S,
        answers: BatchAnswers<'_, S>,
    ) {
        if G::HAS_BATCHES {
            let grid = &InBlocks {
                grid: self,
                frame: &self.frame,
                from_origin: self.from_origin,
                list: |index| self.storage.list(&IndexedCell { frame: &self.frame, index }),
                blocks,
            };
            batch::answer::<InLanes, _, _, _>(grid, prims, rays, reach, answers);
        }
    }

    fn stats(&self) -> StructureStats {
        let cells = self.frame.cells() as u64;
        StructureStats {
            inner_cells: 0,
            cells,
            empty_cells: cells - self.storage.occupied_cells(),
            references: self.storage.references(),
            resolution: Some(self.frame.resolution()),
            bytes: self.storage.bytes(),
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        for cell in 0..self.frame.cells() {
            let list = self.list(self.frame.coords(cell));
            each(Cell::elementary(self.frame.cell_bounds(cell), 0, list));
        }
        Ok(())
    }
}

/// Visits cells until nothing closer can follow.
#[inline(always)]
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

/// References a primitive, on average, beyond which a computed resolution is made coarser. On the
/// scenes of 1999 no rule needs more than 12.
const REFERENCES_A_PRIMITIVE: u64 = 64;

/// Contents under the settings, and their storage. A resolution that is not given in
/// voxels is halved as long as it lists primitives too often: copies of one large primitive would
/// otherwise each go to all voxels.
///
/// # Errors
/// [`BuildError`] when the scene is too large for the scalar or the grid for its limits.
pub fn stored<'a, S: Scalar, P: PrimSet<S>, G: CellStorage>(
    prims: &'a P,
    limits: Limits,
    config: &GridConfig<G::Config>,
) -> Result<(Contents<'a, S, P>, G), BuildError> {
    let mut contents = contents_of(prims, limits, config)?;
    let hard_limit = contents.max_references;
    let references = Counted { bytes: G::REFERENCE_BYTES, ..REFERENCES };
    let is_given = matches!(config.resolution, ResolutionRule::Fixed(_));
    let soft_limit = (REFERENCES_A_PRIMITIVE * prims.len() as u64).max(1 << 20);
    loop {
        let is_final = is_given || contents.frame.cells() == 1;
        let allowed = if is_final { hard_limit } else { hard_limit.min(soft_limit) };
        contents.max_references = limits.most(&references, allowed);
        limits.fits(G::cell_bytes(contents.frame.cells() as u128))?;
        match G::build(&contents, &config.storage) {
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

/// Frame and placement under the settings.
pub(crate) fn contents_of<'a, S: Scalar, P: PrimSet<S>, C>(
    prims: &'a P,
    limits: Limits,
    config: &GridConfig<C>,
) -> Result<Contents<'a, S, P>, BuildError> {
    let structure = limits.structure;
    let &GridConfig { order, max_references, historical, insertion, .. } = config;
    let rule = if historical {
        BoundsRule::Historical { cone_margin: HISTORICAL_CONE_MARGIN }
    } else {
        BoundsRule::Padded
    };
    let boxes =
        BoundsOf::new(prims, rule).map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
    let frame = frame_of(prims, &boxes, structure, config)?;
    let primitives = prims.len();
    Ok(Contents { frame, primitives, order, max_references, boxes, historical, insertion })
}

const REFERENCES: Counted = Counted::references("references in voxels");

/// The grid that the settings `resolution`, `density` and `max-cells` ask for.
fn frame_of<S: Scalar, P: PrimSet<S>, C>(
    prims: &P,
    boxes: &BoundsOf<S, P>,
    structure: &'static str,
    config: &GridConfig<C>,
) -> Result<GridFrame<S>, BuildError> {
    let &GridConfig { resolution: rule, density, max_cells, .. } = config;
    let input = ResolutionInput {
        bounds: boxes.scene(),
        primitives: prims.len(),
        density,
        mean_longest_side: if rule.reads_sides() { mean_longest_side(prims) } else { 0.0 },
        max_cells,
        smallest_cell: boxes.smallest_cell(),
    };
    let n = resolve(rule, &input).map_err(|needed| BuildError::TooLarge {
        structure,
        what: "number of voxels",
        needed,
        limit: u128::from(max_cells),
    })?;
    Ok(GridFrame::new(divided_bounds(rule, boxes.scene(), n), n))
}

fn mean_longest_side<S: Scalar, P: PrimSet<S>>(prims: &P) -> f64 {
    let longest =
        |b: Aabb<S>| b.size().to_array().into_iter().fold(0.0f64, |m, s| m.max(s.to_f64()));
    let sum: f64 = (0..prims.len() as u32).map(|id| longest(prims.bounds(id))).sum();
    sum / prims.len().max(1) as f64
}
