//! The uniform grid: equal voxels, each with the list of primitives whose boxes touch it.
//!
//! Papers: A. Fujimoto, T. Tanaka, K. Iwata, "ARTS: Accelerated Ray-Tracing System", IEEE CG&A
//! 6(4), 1986; J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing",
//! Eurographics 1987 (the walk, see `voxel_walk.rs`).
//!
//! Deviations: lists stand in one array (count, prefix sum, fill); boxes are padded by a few ulps
//! so that rounding loses nothing; the walk recomputes plane parameters instead of accumulating.
//! `boxes=historical order=reverse` is Havran and Sixta's (1999) grid as their counters show it:
//! its walks also begin at the ray's origin, although hits only count beyond the epsilon.

use super::{BuildError, Shape, Structure, StructureInfo, no_defect};
use crate::aabb::Aabb;
use crate::bounds_rule::{BoundsOf, BoundsRule};
use crate::cell_lists::{CellLists, ListOrder, Placement};
use crate::cell_walk::{CellPosition, CellWalk};
use crate::params::{ParamKind, ParamSpec, Params};
use crate::primitives::PrimSet;
use crate::ray::Ray;
use crate::resolution::{ResolutionInput, ResolutionRule, resolve};
use crate::scalar::{Scalar, Vector};
use crate::sink::Sink;
use crate::voxel_walk::GridFrame;

/// Registry line.
pub static INFO: StructureInfo = StructureInfo {
    name: "uniform-grid",
    summary: "equal voxels with lists of primitives, walked by t_next stepping",
    paper: "Fujimoto, Tanaka, Iwata 1986; Amanatides, Woo 1987",
    deviations: "padded boxes; plane parameters recomputed, not accumulated",
    params: &[
        ParamSpec {
            name: "resolution",
            summary: "rule for the number of voxels, or the number itself",
            default: "density",
            kind: ParamKind::Resolution,
        },
        ParamSpec {
            name: "density",
            summary: "voxels per primitive, D, for the rules that have it",
            default: "2",
            kind: ParamKind::Real { min: 1e-6, max: 1e6 },
        },
        ParamSpec {
            name: "boxes",
            summary: "boxes of primitives: padded by ulps, or as in 1999",
            default: "padded",
            kind: ParamKind::Choice(&["padded", "historical"]),
        },
        ParamSpec {
            name: "order",
            summary: "order of ids in a voxel: as in the file, or reversed as in 1999",
            default: "file",
            kind: ParamKind::Choice(&["file", "reverse"]),
        },
        ParamSpec {
            name: "max-cells",
            summary: "upper limit for the number of voxels",
            default: "67108864",
            kind: ParamKind::Integer { min: 1, max: 1 << 32 },
        },
        ParamSpec {
            name: "max-references",
            summary: "upper limit for the references in all voxels together",
            default: "536870912",
            kind: ParamKind::Integer { min: 1, max: (1 << 32) - 1 },
        },
    ],
    variants: &[
        "",
        "resolution=woo density=1",
        "resolution=heterogeneous density=1",
        "resolution=heterogeneous density=20",
        "resolution=regular density=1",
        "resolution=average-edge",
    ],
    known_defect: no_defect,
    sampled: false,
};

/// Box margin of cones in Havran and Sixta's uniform grid, as fitted to their counters.
const HISTORICAL_CONE_MARGIN: f64 = 0.0006;

/// A dense grid.
pub struct UniformGrid<S: Scalar> {
    frame: GridFrame<S>,
    lists: CellLists,
    /// Walks start at the ray's origin even if hits only count from `t_min` on, as in 1999.
    from_origin: bool,
}

/// Bounding-box insertion.
struct BoxPlacement<'a, S: Scalar, P: PrimSet<S>> {
    frame: GridFrame<S>,
    boxes: BoundsOf<'a, S, P>,
    historical: bool,
}

impl<S: Scalar, P: PrimSet<S>> Placement for BoxPlacement<'_, S, P> {
    #[inline(always)]
    fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
        let b = self.boxes.of(id);
        let (first, last) =
            if self.historical { self.frame.range_by_division(&b) } else { self.frame.range(&b) };
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                let row = self.frame.index([0, y, z]);
                for x in first[0]..=last[0] {
                    emit(row + x as usize);
                }
            }
        }
    }
}

impl<S: Scalar> Structure<S> for UniformGrid<S> {
    fn build<P: PrimSet<S>>(prims: &P, params: &Params) -> Result<Self, BuildError> {
        let structure = params.structure();
        let historical = params.text("boxes") == "historical";
        let rule = if historical {
            BoundsRule::Historical { cone_margin: HISTORICAL_CONE_MARGIN }
        } else {
            BoundsRule::Padded
        };
        let boxes = BoundsOf::new(prims, rule)
            .map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
        let frame = frame_of(prims, &boxes, params)?;
        let order =
            if params.text("order") == "reverse" { ListOrder::Reverse } else { ListOrder::File };
        let max_references = params.integer("max-references");
        let placement = BoxPlacement { frame, boxes, historical };
        let lists = CellLists::build(frame.cells(), prims.len(), order, max_references, &placement)
            .map_err(|e| BuildError::TooLarge {
                structure,
                what: "references in voxels",
                needed: u128::from(e.0),
                limit: u128::from(max_references),
            })?;
        Ok(Self { frame, lists, from_origin: historical })
    }

    #[inline(always)]
    fn walk<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let t_start = if self.from_origin { S::ZERO } else { ray.t_min };
        let Some(mut walk) = self.frame.walk_from(ray, t_start) else { return };
        loop {
            let list = self.lists.list(walk.index());
            sink.elementary_step(list.is_empty());
            if !list.is_empty() && sink.test(list).is_break() {
                return;
            }
            if sink.t_max() < walk.t_exit() || !walk.advance() {
                return;
            }
        }
    }

    fn shape(&self) -> Shape {
        Shape {
            inner_cells: 0,
            cells: self.lists.cells() as u64,
            empty_cells: self.lists.empty_cells() as u64,
            references: self.lists.references() as u64,
            resolution: Some(self.frame.resolution()),
            bytes: self.lists.bytes() as u64,
        }
    }
}

/// The grid that the settings `resolution`, `density` and `max-cells` ask for.
fn frame_of<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    boxes: &BoundsOf<S, P>,
    params: &Params,
) -> Result<GridFrame<S>, BuildError> {
    let rule = params.resolution("resolution");
    let max_cells = params.integer("max-cells");
    let input = ResolutionInput {
        bounds: boxes.scene(),
        primitives: prims.len(),
        density: params.real("density"),
        mean_longest_side: match rule {
            ResolutionRule::AverageEdge => mean_longest_side(prims),
            _ => 0.0,
        },
        max_cells,
    };
    let n = resolve(rule, &input).map_err(|needed| BuildError::TooLarge {
        structure: params.structure(),
        what: "number of voxels",
        needed,
        limit: u128::from(max_cells),
    })?;
    Ok(GridFrame::new(boxes.scene(), n))
}

fn mean_longest_side<S: Scalar, P: PrimSet<S>>(prims: &P) -> f64 {
    let longest =
        |b: Aabb<S>| b.size().to_array().into_iter().fold(0.0f64, |m, s| m.max(s.to_f64()));
    let sum: f64 = (0..prims.len() as u32).map(|id| longest(prims.bounds(id))).sum();
    sum / prims.len().max(1) as f64
}
