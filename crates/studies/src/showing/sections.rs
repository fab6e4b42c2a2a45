//! The cells of a structure that are drawn: elementary ones, or those at a depth.

use accel_core::Aabb;
use accel_core::query::cells::{CellKind, NoCells};
use accel_core::query::tracer::Tracer;

use super::plane::Plane;

/// Section of a cell by a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Left, lower, right, upper.
    pub ends: [f64; 4],
    /// References in it, or below it.
    pub references: u64,
    /// True if it is divided further.
    pub is_inner: bool,
}

/// A cell as a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    pub bounds: Aabb<f64>,
    /// References in it, or below it.
    pub references: u64,
}

struct DrawnCell<T> {
    place: T,
    references: u64,
    is_inner: bool,
}

/// The cells that `place` has a place for: elementary ones or, with a depth, those at that depth
/// and the elementary ones above.
fn drawn<T>(
    tracer: &dyn Tracer<f32>,
    depth: Option<u32>,
    mut place: impl FnMut(&Aabb<f64>) -> Option<T>,
) -> Result<Vec<DrawnCell<T>>, NoCells> {
    let mut all: Vec<DrawnCell<T>> = Vec::new();
    // the cell that those below are part of
    let mut around: Option<usize> = None;
    tracer.cells(&mut |cell| {
        let references = cell.ids.len() as u64;
        let is_inner = cell.kind == CellKind::Inner;
        let is_drawn = match depth {
            // a voxel that holds grids may list primitives, too
            None => !is_inner || references > 0,
            Some(depth) if cell.depth > depth => {
                if let Some(around) = around.and_then(|i| all.get_mut(i)) {
                    around.references += references;
                }
                return;
            }
            Some(depth) => !is_inner || cell.depth == depth,
        };
        around = None;
        if is_drawn && let Some(place) = place(&cell.bounds) {
            around = Some(all.len());
            all.push(DrawnCell { place, references, is_inner });
        }
    })?;
    Ok(all)
}

/// Sections of a structure's cells by a plane: all, or with a depth those at that depth and the
/// leaves above; large ones first.
pub fn sections(
    tracer: &dyn Tracer<f32>,
    plane: &Plane,
    depth: Option<u32>,
) -> Result<Vec<Section>, NoCells> {
    let mut all: Vec<Section> = drawn(tracer, depth, |bounds| plane.cut(bounds))?
        .into_iter()
        .map(|cell| Section {
            ends: cell.place,
            references: cell.references,
            is_inner: cell.is_inner,
        })
        .collect();
    // cells of a hierarchy of boxes overlap: none hides a smaller one
    let area = |s: &Section| (s.ends[2] - s.ends[0]) * (s.ends[3] - s.ends[1]);
    all.sort_by(|a, b| area(b).total_cmp(&area(a)));
    Ok(all)
}

/// The cells that hold primitives as boxes; with a depth as [`sections`].
pub fn bodies(tracer: &dyn Tracer<f32>, depth: Option<u32>) -> Result<Vec<Body>, NoCells> {
    let all = drawn(tracer, depth, |bounds| Some(*bounds))?;
    let body =
        |cell: DrawnCell<Aabb<f64>>| Body { bounds: cell.place, references: cell.references };
    Ok(all.into_iter().map(body).filter(|body| body.references > 0).collect())
}
