//! The regular grid with its cells in blocks: neighbours in space are neighbours in memory.
//!
//! Paper: S. Parker, W. Martin, P.-P. Sloan, P. Shirley, B. Smits, C. Hansen, "Interactive Ray
//! Tracing", I3D 1999: cells in bricks of a cache line, bricks in macro-bricks of a page, and one
//! table of offsets an axis, so that a cell's address is the sum of three look-ups.
//!
//! Deviations: macro-blocks have the size of (half) the L2 cache; blocks need not be cubes, so that
//! their sizes can be any power of two and flat grids waste nothing; macro-blocks are evened out
//! among themselves, so that less is padded. What stands in blocks is where a cell's list begins
//! (4 bytes per cell); lists follow each other in the same order. A list ends where the next one
//! begins: the last cell of a block looks into the next block for that.

use crate::config;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::{CellLists, TooManyReferences};
use crate::grid::cell_traversal::{CellPosition, Traversal};
use crate::grid::regular_grid::{CellStorage, Contents, QUERY_PARAM, RegularGrid, grid_params};
use crate::parallel;
use crate::params::ParamSpec;
use crate::params::specs;
use crate::structure::{StructureInfo, StructureStats};

config! {
    /// How large blocks are.
    pub struct BricksConfig {
        /// size of a block: a cache line of the machine (a power of two is used)
        block_bytes: u64 = ParamSpec::integer("block-bytes", CACHE_LINE, 4, 4096),
        /// size of a macro-block: half the L2 cache (a power of two is used)
        macro_block_bytes: u64 = ParamSpec::integer("macro-block-bytes", "262144", 4, 1 << 30),
    }
}

const CACHE_LINE: &str =
    if cfg!(all(target_arch = "aarch64", target_os = "macos")) { "128" } else { "64" };

pub static INFO: StructureInfo = StructureInfo {
    paper: "Parker, Martin, Sloan, Shirley, Smits, Hansen 1999",
    deviations: "macro-blocks of L2 size, not of a page; blocks need not be cubes",
    params: grid_params!(
        specs::MAX_CELLS,
        specs::MAX_REFERENCES,
        [BricksConfig::PARAMS[0], BricksConfig::PARAMS[1], Traversal::PARAM],
        [QUERY_PARAM]
    ),
    also_tested: &[
        "kernel=scalar",
        "query=batch",
        "query=batch density=20",
        "density=20",
        "block-bytes=4 macro-block-bytes=4",
        "traversal=driving-axis",
        "mailbox=hash",
    ],
    ..StructureInfo::new(
        "bricked-grid",
        "equal voxels in blocks of a cache line and macro-blocks of the L2 cache",
    )
};

/// A grid in blocks.
pub type BrickedGrid<S> = RegularGrid<S, BrickedCells>;

/// Bytes of a cell: where its list begins.
const CELL_BYTES: u64 = 4;

/// Place of a cell: the sum of one offset per axis.
#[derive(Debug, Clone)]
struct Layout {
    offsets: [Vec<usize>; 3],
    /// Cells, those of padding included.
    cells: usize,
}

impl Layout {
    fn new(n: [u32; 3], block_cells: u64, macro_cells: u64) -> Self {
        let n = n.map(|n| n as usize);
        let block = near_cube(n, block_cells as usize);
        let blocks: [usize; 3] = std::array::from_fn(|k| n[k].div_ceil(block[k]));
        let cells_per_block: usize = block.iter().product();
        let wanted = near_cube(blocks, (macro_cells as usize / cells_per_block).max(1));
        let macros: [usize; 3] = std::array::from_fn(|k| blocks[k].div_ceil(wanted[k]));
        let side: [usize; 3] = std::array::from_fn(|k| blocks[k].div_ceil(macros[k]));
        let cells_per_macro = cells_per_block * side.iter().product::<usize>();
        let strides = |n: [usize; 3], unit: usize| [unit, unit * n[0], unit * n[0] * n[1]];
        let (in_block, in_macro, of_macro) =
            (strides(block, 1), strides(side, cells_per_block), strides(macros, cells_per_macro));
        let offsets = std::array::from_fn(|k| {
            let offset = |i: usize| {
                let b = i / block[k];
                i % block[k] * in_block[k] + b % side[k] * in_macro[k] + b / side[k] * of_macro[k]
            };
            (0..n[k]).map(offset).collect()
        });
        Self { offsets, cells: cells_per_macro * macros.iter().product::<usize>() }
    }

    /// 0 for a cell outside the grid: nobody asks for one.
    #[inline(always)]
    fn index(&self, c: [i32; 3]) -> usize {
        let of = |k: usize| self.offsets[k].get(c[k] as usize).copied().unwrap_or(0);
        of(0) + of(1) + of(2)
    }

    fn bytes(&self) -> usize {
        self.offsets.iter().map(|o| size_of_val(o.as_slice())).sum()
    }
}

/// Sides of a block of at most `cells` cells, powers of two: as near to a cube as the grid allows.
fn near_cube(n: [usize; 3], cells: usize) -> [usize; 3] {
    let mut side = [1; 3];
    while side.iter().product::<usize>() * 2 <= cells {
        let Some(k) = (0..3).filter(|&k| side[k] < n[k]).min_by_key(|&k| side[k]) else { break };
        side[k] *= 2;
    }
    side
}

/// Starts of lists, aligned so that blocks of up to 128 bytes do not straddle cache lines.
#[derive(Debug, Clone, Copy)]
#[repr(align(128))]
struct Line([u32; 32]);

/// The cells of a grid in blocks.
pub struct BrickedCells {
    layout: Layout,
    starts: Vec<Line>,
    ids: Vec<u32>,
    occupied: u64,
}

impl BrickedCells {
    #[inline(always)]
    fn start(&self, cell: usize) -> usize {
        self.starts.get(cell / 32).map_or(0, |line| line.0[cell % 32] as usize)
    }
}

impl CellStorage for BrickedCells {
    type Config = BricksConfig;

    /// A start, before and after it is laid in blocks.
    fn cell_bytes(cells: u128) -> u128 {
        8 * cells
    }

    fn build<S: Scalar>(
        contents: &Contents<S>,
        config: &BricksConfig,
    ) -> Result<Self, TooManyReferences> {
        let block_cells = config.block_bytes / CELL_BYTES;
        let macro_cells = config.macro_block_bytes / CELL_BYTES;
        let layout = Layout::new(contents.frame.resolution(), block_cells, macro_cells);
        let lists: CellLists = contents.lists(layout.cells, |c| layout.index(c))?;
        let occupied = (lists.cells() - lists.empty_cells()) as u64;
        let (starts, ids) = lists.into_parts();
        let line = |number: usize| {
            let part = &starts[32 * number..starts.len().min(32 * number + 32)];
            let mut line = Line([0; 32]);
            line.0[..part.len()].copy_from_slice(part);
            line
        };
        let starts = parallel::collect(starts.len().div_ceil(32), line);
        Ok(Self { layout, starts, ids, occupied })
    }

    #[inline(always)]
    fn list(&self, cell: &impl CellPosition) -> &[u32] {
        let i = self.layout.index(cell.coords());
        self.ids.get(self.start(i)..self.start(i + 1)).unwrap_or(&[])
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        let starts: Vec<usize> = self.starts.iter().flat_map(|l| l.0).map(|s| s as usize).collect();
        starts
            .windows(2)
            .filter(|at| at[0] < at[1])
            .filter_map(|at| self.ids.get(at[0]..at[1]))
            .for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let (starts, ids) = (self.starts.as_slice(), self.ids.as_slice());
        StructureStats {
            cells: self.occupied,
            references: ids.len() as u64,
            bytes: (self.layout.bytes() + size_of_val(starts) + size_of_val(ids)) as u64,
            ..StructureStats::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_its_own_place_and_blocks_stay_together() {
        for n in [[1, 1, 1], [5, 7, 9], [64, 64, 64], [33, 1, 70], [1000, 1, 1], [3, 129, 2]] {
            for (block, macro_block) in [(1, 1), (16, 16), (16, 512), (8, 1 << 16), (1024, 2)] {
                let layout = Layout::new(n, block, macro_block);
                let mut seen = vec![false; layout.cells];
                for z in 0..n[2] as i32 {
                    for y in 0..n[1] as i32 {
                        for x in 0..n[0] as i32 {
                            let i = layout.index([x, y, z]);
                            assert!(!std::mem::replace(&mut seen[i], true), "{n:?} {x} {y} {z}");
                        }
                    }
                }
            }
        }
        // 16 cells to a line of 64 bytes: 4 x 2 x 2
        let layout = Layout::new([64; 3], 16, 1 << 16);
        assert_eq!(layout.cells, 64 * 64 * 64);
        for c in [[0, 0, 0], [3, 1, 1], [2, 0, 1]] {
            assert_eq!(layout.index(c) / 16, 0, "{c:?}");
        }
        assert_eq!(layout.index([4, 0, 0]), 16);
    }
}
