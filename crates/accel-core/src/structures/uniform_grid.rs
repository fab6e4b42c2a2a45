//! The uniform grid: equal voxels, each with the list of primitives whose boxes touch it.
//!
//! Papers: A. Fujimoto, T. Tanaka, K. Iwata, "ARTS: Accelerated Ray-Tracing System", IEEE CG&A
//! 6(4), 1986; J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing",
//! Eurographics 1987 (the traversals, see `driving_axis_traversal.rs` and `voxel_traversal.rs`).
//!
//! Deviations: lists stand in one array (count, prefix sum, fill); boxes are padded by a few ulps
//! so that rounding loses nothing; the traversal recomputes plane parameters instead of
//! accumulating; a resolution that a rule gave is halved while it lists primitives more than 64
//! times on average. `boxes=historical order=reverse` is Havran and Sixta's (1999) grid as their
//! counters show it: its traversals also begin at the ray's origin, although hits only count beyond
//! the epsilon.

use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::{CellLists, TooManyReferences};
use crate::grid::cell_overlap::Insertion;
use crate::grid::cell_traversal::{CellPosition, Traversal};
use crate::grid::changed_cells::NewCells;
use crate::grid::regular_grid::{CellStorage, Contents, QUERY_PARAM, RegularGrid, grid_params};
use crate::params::Params;
use crate::params::specs;
use crate::structure::{StructureInfo, StructureStats};
use crate::update::{ChangedLists, INCREMENTAL};
use crate::variants::chosen_tests::{SPHERE_TEST, TRIANGLE_TEST};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Fujimoto, Tanaka, Iwata 1986; Amanatides, Woo 1987",
    deviations: "padded boxes; plane parameters recomputed, not accumulated",
    params: grid_params!(
        specs::MAX_CELLS,
        specs::MAX_REFERENCES,
        [Traversal::PARAM_OF_ALL, Insertion::PARAM],
        [QUERY_PARAM, INCREMENTAL],
        TRIANGLE_TEST,
        SPHERE_TEST
    ),
    variants: &[
        "",
        "resolution=heterogeneous density=1",
        "resolution=heterogeneous density=20",
        "resolution=auto",
        "traversal=driving-axis",
        "mailbox=hash",
    ],
    also_tested: &[
        "kernel=scalar",
        "query=batch",
        "query=batch density=20",
        "resolution=woo density=1",
        "resolution=regular density=1",
        "resolution=average-edge",
        "resolution=cubic",
        "traversal=driving-axis density=20",
        "mailbox=primitive density=8",
        "mailbox=array traversal=driving-axis",
        "mailbox=hash mailbox-slots=1 density=8",
        "traversal=f64",
        "insertion=padded-exact",
        "insertion=padded-exact density=20",
    ],
    known_defect,
    ..StructureInfo::new("uniform-grid", "equal voxels with lists of primitives, in one array")
};

fn known_defect(params: &Params) -> Option<&'static str> {
    match (Traversal::of(params), Insertion::of(params).is_padded) {
        (Traversal::Accumulate, _) => Some("accumulated parameters drift: cells are passed by"),
        (_, false) => Some("without a margin, hits on cell planes are lost to rounding"),
        _ => None,
    }
}

/// One list for every cell, in one array.
pub type UniformGrid<S> = RegularGrid<S, CellLists>;

impl CellStorage for CellLists {
    type Config = ();

    const COMPARES_TRAVERSALS: bool = true;

    fn build<S: Scalar>(contents: &Contents<S>, (): &()) -> Result<Self, TooManyReferences> {
        contents.dense_lists()
    }

    fn change<S: Scalar>(&mut self, contents: &Contents<S>, moved: &[u32]) -> Option<ChangedLists> {
        let frame = contents.frame;
        let gained = NewCells::of(contents, moved, |cell| frame.index(cell))?;
        self.change(moved, &gained)
    }

    #[inline(always)]
    fn list(&self, cell: &impl CellPosition) -> &[u32] {
        self.list(cell.index())
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let all = self.stats();
        StructureStats { cells: all.cells - all.empty_cells, ..all }
    }
}
