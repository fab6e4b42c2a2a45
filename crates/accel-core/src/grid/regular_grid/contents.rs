//! Assignment of primitives to the cells of a regular grid, and its settings.

use std::ops::Range;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::block_lists::{
    BlockPlacement, CellRows, DenseRows, block_lists, cells_in, each_cell_in,
};
use crate::grid::cell_lists::{CellLists, ListOrder, Placement, TooManyReferences};
use crate::grid::cell_overlap::{Insertion, overlaps};
use crate::grid::cell_traversal::Traversal;
use crate::grid::resolution::{ResolutionInput, ResolutionRule, divided_bounds, resolve};
use crate::grid::voxel_traversal::GridFrame;
use crate::historical::bounds_rule::{BoundsOf, BoundsRule};
use crate::memory::Limits;
use crate::parallel::map_parts;
use crate::params::config::Config;
use crate::params::{Params, specs};
use crate::primitives::Primitives;
use crate::structure::{BuildError, bounds_of};
use crate::update::is_incremental;

/// Input of a cell storage: the primitives of each cell.
pub struct Contents<'a, S: Scalar> {
    pub frame: GridFrame<S>,
    pub primitives: usize,
    /// Order of ids in a cell.
    pub order: ListOrder,
    pub max_references: u64,
    boxes: BoundsOf<'a, S>,
    historical: bool,
    insertion: Insertion,
}

impl<S: Scalar> Contents<'_, S> {
    /// First and last cell of primitive `id` on each axis.
    #[inline(always)]
    pub fn range(&self, id: u32) -> ([i32; 3], [i32; 3]) {
        if self.insertion != Insertion::PADDED_BOX {
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
        if self.insertion.is_padded {
            self.frame.range(&self.boxes.of(id))
        } else {
            self.frame.range(&self.boxes.prims().bounds(id))
        }
    }

    /// The cells of [`Contents::range`] that the primitive overlaps itself.
    #[cold]
    #[inline(never)]
    fn overlapped(&self, id: u32) -> Vec<[i32; 3]> {
        let margin = if self.insertion.is_padded { self.boxes.padding().to_f64() } else { 0.0 };
        let wide = self.frame.in_double();
        let (mut cells, mut balls) = (Vec::new(), Vec::new());
        each_cell_in(self.range(id), |at| {
            let cell = wide.cell_bounds(wide.index(at)).expanded(margin);
            if overlaps(self.boxes.prims(), id, (cell.min, cell.max), &mut balls) {
                cells.push(at);
            }
        });
        cells
    }

    /// Calls `emit` with the coordinates of every cell primitive `id` goes to, x fastest.
    #[inline(always)]
    pub fn cells_of(&self, id: u32, emit: impl FnMut([i32; 3])) {
        if self.insertion.is_exact {
            return self.overlapped(id).into_iter().for_each(emit);
        }
        each_cell_in(self.range(id), emit);
    }

    /// All references together, without visiting cells.
    pub fn count_references(&self) -> u64 {
        let cells = |id| cells_in(self.range(id));
        let of_part = |ids: Range<u32>| ids.map(cells).fold(0, u64::saturating_add);
        map_parts(self.primitives, of_part).into_iter().fold(0, u64::saturating_add)
    }

    /// The lists in one array, those of the frame's cells in their order.
    ///
    /// # Errors
    /// [`TooManyReferences`].
    pub fn dense_lists(&self) -> Result<CellLists, TooManyReferences> {
        if self.insertion.is_exact {
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
        index: impl Fn([i32; 3]) -> usize + Sync,
    ) -> Result<CellLists, TooManyReferences> {
        struct IndexedContents<'c, 'a, S: Scalar, F>(&'c Contents<'a, S>, F);
        impl<S: Scalar, F: Fn([i32; 3]) -> usize + Sync> Placement for IndexedContents<'_, '_, S, F> {
            #[inline(always)]
            fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
                self.0.cells_of(id, |c| emit((self.1)(c)));
            }
        }
        if !self.insertion.is_exact {
            // before any cell is visited: identical primitives may be in all of them
            let needed = self.count_references();
            if needed > self.max_references {
                return Err(TooManyReferences(needed));
            }
        }
        let placement = IndexedContents(self, index);
        CellLists::build(cells, self.primitives, self.order, self.max_references, &placement)
    }
}

impl<S: Scalar> BlockPlacement for Contents<'_, S> {
    #[inline(always)]
    fn block(&self, id: u32) -> ([i32; 3], [i32; 3]) {
        self.range(id)
    }
}

/// Box margin of cones in Havran and Sixta's uniform grid, as fitted to their counters.
const HISTORICAL_CONE_MARGIN: f64 = 0.0006;

/// The settings of [`crate::params::specs`], and those of a structure's own: what a structure does
/// not list has its default.
#[derive(Debug, Clone)]
pub struct GridConfig<C> {
    pub(super) resolution: ResolutionRule,
    density: f64,
    pub(crate) max_cells: u64,
    pub(crate) max_references: u64,
    pub(crate) historical: bool,
    order: ListOrder,
    insertion: Insertion,
    pub(super) traversal: Traversal,
    pub(crate) is_incremental: bool,
    pub(super) is_batch: bool,
    pub(crate) own: C,
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
            own: C::of(params),
        }
    }
}

/// Frame and placement under the settings.
pub(crate) fn contents_of<'a, S: Scalar, C>(
    prims: &'a dyn Primitives<S>,
    limits: Limits,
    config: &GridConfig<C>,
) -> Result<Contents<'a, S>, BuildError> {
    let &GridConfig { order, max_references, historical, insertion, .. } = config;
    let rule = BoundsRule::of(historical, HISTORICAL_CONE_MARGIN);
    let boxes = bounds_of(prims, rule, limits.structure)?;
    let frame = frame_of(prims, &boxes, limits.structure, config)?;
    let primitives = prims.len();
    Ok(Contents { frame, primitives, order, max_references, boxes, historical, insertion })
}

/// The grid that the settings `resolution`, `density` and `max-cells` ask for.
fn frame_of<S: Scalar, C>(
    prims: &dyn Primitives<S>,
    boxes: &BoundsOf<S>,
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

fn mean_longest_side<S: Scalar>(prims: &dyn Primitives<S>) -> f64 {
    let longest =
        |b: Aabb<S>| b.size().to_array().into_iter().fold(0.0f64, |m, s| m.max(s.to_f64()));
    let sum: f64 = (0..prims.len() as u32).map(|id| longest(prims.bounds(id))).sum();
    sum / prims.len().max(1) as f64
}
