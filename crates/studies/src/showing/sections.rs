//! The cells of a structure that are drawn: elementary ones, or those at a depth.

use accel_core::Aabb;
use accel_core::query::cells::{CellKind, NoCells};
use accel_core::query::tracer::Tracer;

use super::plane::Plane;

/// A cell, and where it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnCell<P> {
    pub place: P,
    /// References in it, or below it.
    pub references: u64,
}

/// A cell cut by a plane: left, lower, right, upper.
pub type Section = DrawnCell<[f64; 4]>;

/// A cell as a box.
pub type Body = DrawnCell<Aabb<f64>>;

/// The cells that `place` has a place for: elementary ones or, with a depth, those at that depth
/// and the elementary ones above.
fn drawn<P>(
    tracer: &dyn Tracer<f32>,
    depth: Option<u32>,
    mut place: impl FnMut(&Aabb<f64>) -> Option<P>,
) -> Result<Vec<DrawnCell<P>>, NoCells> {
    let mut all: Vec<DrawnCell<P>> = Vec::new();
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
            all.push(DrawnCell { place, references });
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
    let mut all = drawn(tracer, depth, |bounds| plane.cut(bounds))?;
    // cells of a hierarchy of boxes overlap: none hides a smaller one
    let area = |s: &Section| (s.place[2] - s.place[0]) * (s.place[3] - s.place[1]);
    all.sort_by(|a, b| area(b).total_cmp(&area(a)));
    Ok(all)
}

/// The cells that hold primitives as boxes; with a depth as [`sections`].
pub fn bodies(tracer: &dyn Tracer<f32>, depth: Option<u32>) -> Result<Vec<Body>, NoCells> {
    let mut all = drawn(tracer, depth, |bounds| Some(*bounds))?;
    all.retain(|body| body.references > 0);
    Ok(all)
}
