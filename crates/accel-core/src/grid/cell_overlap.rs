//! Rules for the cells that list a primitive: those its box touches, or those it overlaps itself.
//!
//! Papers: T. Akenine-Moeller, "Fast 3D Triangle-Box Overlap Testing", JGT 6(1), 2001 (separating
//! axes); J. Arvo, "A Simple Method for Box-Sphere Intersection Testing", Graphics Gems, 1990.
//!
//! Deviations: in f64, on the vertices and cell planes of the grid's scalar; of polygons and cones,
//! polygons are tested against their plane only, and cones keep the cells of their boxes. An exact
//! overlap is still wrong for a grid: a hit point is rounded, and so is the cell it is found in.
//! With a margin of the padding of boxes (`bounds_rule.rs`) it is right.

use glam::DVec3;

use crate::geometry::scalar::Scalar;
use crate::params::{ParamSpec, Params};
use crate::primitives::{Ball, PrimitiveKind, Primitives};

/// Rule for the cells that list a primitive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Insertion {
    /// Those that it overlaps itself, not its box.
    pub is_exact: bool,
    /// Cells are grown by the padding of boxes.
    pub is_padded: bool,
}

impl Insertion {
    pub(crate) const PADDED_BOX: Self = Self { is_exact: false, is_padded: true };

    /// The setting, for the parameter list of a structure.
    pub const PARAM: ParamSpec = ParamSpec::choice(
        "insertion",
        "padded-box",
        &["padded-box", "box", "exact", "padded-exact"],
    )
    .about(
        "cells of a primitive: of its padded box, or overlapped with the same margin; for \
                  comparison: without a margin (both lose hits on cell planes)",
    );

    /// Reads the setting; padded boxes for a structure without the parameter.
    pub fn of(params: &Params) -> Self {
        let rule = params.get(Self::PARAM.name).unwrap_or(Self::PARAM.default);
        Self { is_exact: rule.ends_with("exact"), is_padded: rule.starts_with("padded") }
    }
}

/// Returns whether primitive `id` may overlap the box from `low` to `high`; `balls` is room to work
/// in.
pub fn overlaps<S: Scalar>(
    prims: &dyn Primitives<S>,
    id: u32,
    (low, high): (DVec3, DVec3),
    balls: &mut Vec<Ball>,
) -> bool {
    balls.clear();
    prims.hull(id, balls);
    let (centre, half) = ((low + high) / 2.0, (high - low) / 2.0);
    match (prims.kind(id), balls.as_slice()) {
        (PrimitiveKind::Triangle, [a, b, c]) => {
            let corners = [a.center - centre, b.center - centre, c.center - centre];
            !is_separated(corners, half)
        }
        (PrimitiveKind::Sphere, [ball]) => {
            let from = (ball.center - centre).abs();
            let outside = (from - half).max(DVec3::ZERO);
            // a sphere is hollow: a cell deep inside is not overlapped
            let farthest = (from + half).length_squared();
            let r2 = ball.radius * ball.radius;
            outside.length_squared() <= r2 && farthest >= r2
        }
        (PrimitiveKind::Polygon, [a, b, rest @ ..]) => {
            // the plane of the first three corners that span one
            let normal = rest.iter().map(|c| (b.center - a.center).cross(c.center - a.center));
            let normal = normal.fold(DVec3::ZERO, |n, m| {
                if m.length_squared() > n.length_squared() { m } else { n }
            });
            let (least, most) = prims.extent(id, normal);
            let (at, reach) = (centre.dot(normal), half.dot(normal.abs()));
            at + reach >= least && at - reach <= most
        }
        // cones, and what moves: the hull of two places is more than its first corners
        _ => true,
    }
}

/// Returns whether an axis separates a triangle from the box of half-sides `half` about the origin;
/// the axes of the box itself are left out, as cells of the triangle's box are all that is asked.
fn is_separated(corners: [DVec3; 3], half: DVec3) -> bool {
    let [a, b, c] = corners;
    let edges = [b - a, c - b, a - c];
    let splits = |axis: DVec3| {
        let along = corners.map(|p| p.dot(axis));
        let least = along[0].min(along[1]).min(along[2]);
        let most = along[0].max(along[1]).max(along[2]);
        let reach = half.dot(axis.abs());
        least > reach || most < -reach
    };
    splits(edges[0].cross(edges[1]))
        || edges.iter().any(|e| [DVec3::X, DVec3::Y, DVec3::Z].iter().any(|k| splits(k.cross(*e))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{MixedSet, MixedSetBuilder};
    use glam::dvec3;

    fn set() -> MixedSet<f64> {
        let mut builder = MixedSetBuilder::default();
        builder.triangle([DVec3::ZERO, dvec3(4.0, 0.0, 0.0), dvec3(0.0, 4.0, 0.0)]).unwrap();
        builder.sphere(dvec3(0.0, 0.0, 0.0), 2.0).unwrap();
        let slanted = [dvec3(0., 0., 0.), dvec3(4., 0., 4.), dvec3(4., 4., 4.), dvec3(0., 4., 0.)];
        builder.polygon(&slanted).unwrap();
        builder.finish()
    }

    #[test]
    fn cells_within_the_box_of_a_shape_but_beside_it_are_excluded() {
        let set = set();
        let mut balls = Vec::new();
        let mut cell = |id: u32, at: DVec3| overlaps(&set, id, (at, at + 1.0), &mut balls);
        assert!(cell(0, dvec3(0.0, 0.0, -0.5)) && cell(0, dvec3(1.5, 1.5, 0.0)));
        assert!(!cell(0, dvec3(3.0, 3.0, -0.5)), "beyond the long side");
        assert!(cell(0, dvec3(2.0, 2.0, 0.0)), "touched in a corner");
        assert!(cell(1, dvec3(1.0, 0.5, 0.0)));
        assert!(!cell(1, dvec3(1.5, 1.5, 1.5)), "beside the ball, within its box");
        assert!(!cell(1, dvec3(-0.5, -0.5, -0.5)), "within the ball");
        assert!(cell(2, dvec3(2.0, 1.0, 2.0)) && !cell(2, dvec3(3.0, 1.0, 0.0)));
    }
}
