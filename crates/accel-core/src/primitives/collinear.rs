//! Triangles and polygons without area: found exactly, once, when a set is made.
//!
//! Three distinct corners on a slanted line become a sliver with an area when a ray's shear rounds
//! them, and that sliver can be hit. So a corner set is first looked at with exact predicates
//! (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", 1997, through the crate `robust`): points are on one line exactly when their three
//! axis-parallel projections are.

use glam::DVec3;
use robust::{Coord, orient2d};

use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// A triangle as it is, or, where its corners lie on one line, as the outermost two of them, one
/// twice: the same bounds, and the shape in which every triangle test finds no area.
pub(super) fn without_sliver<S: Scalar>(corners: [[S; 3]; 3]) -> [[S; 3]; 3] {
    let points = corners.map(|p| Vec3::<S>::from_array(p).to_dvec3());
    if !are_collinear(&points) {
        return corners;
    }
    // on a line, the box of two points is that of all exactly when they are the outermost
    let [a, b, c] = corners;
    let size = |i: usize, j: usize| (points[i] - points[j]).abs().max_element();
    let (ab, bc, ca) = (size(0, 1), size(1, 2), size(2, 0));
    if ab >= bc && ab >= ca {
        [a, b, a]
    } else if bc >= ca {
        [b, c, b]
    } else {
        [c, a, c]
    }
}

/// Returns whether all points lie on one line; decided exactly.
pub(super) fn are_collinear(points: &[DVec3]) -> bool {
    let Some((&a, rest)) = points.split_first() else { return true };
    let Some(&b) = rest.iter().find(|&&p| p != a) else { return true };
    rest.iter().all(|&c| is_on_line(a, b, c))
}

/// Whether `c` lies on the line through `a` and `b`.
fn is_on_line(a: DVec3, b: DVec3, c: DVec3) -> bool {
    // sin^2 of the angle at `a`: the differences and the products are off by 2^-52 or so
    let (u, v) = (b - a, c - a);
    if u.cross(v).length_squared() > 1e-24 * u.length_squared() * v.length_squared() {
        return false;
    }
    // by powers of two along each axis: products of small coordinates do not underflow
    let unit = a.abs().max(b.abs()).max(c.abs()).to_array().map(f64::to_unit_size);
    [(0, 1), (1, 2), (2, 0)].into_iter().all(|(x, y)| {
        let flat = |p: DVec3| Coord { x: p[x] * unit[x], y: p[y] * unit[y] };
        orient2d(flat(a), flat(b), flat(c)) == 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    #[test]
    fn collinear_to_the_last_bit() {
        let along = dvec3(0.1, -0.7, 0.3).as_vec3().as_dvec3();
        let line = [DVec3::ZERO, along, along * 2.0, along * -5.0];
        assert!(are_collinear(&line));
        for k in 0..3 {
            let mut off = line;
            off[2][k] = off[2][k].next_up();
            assert!(!are_collinear(&off), "axis {k}");
        }
        assert!(are_collinear(&[]) && are_collinear(&[along; 4]));
        assert!(!are_collinear(&[DVec3::ZERO, DVec3::X, DVec3::Y]));
        for size in [1e-150, 1e-170, 1e-300, 1e200] {
            let corner = |x: f64, y: f64| dvec3(x * size, y * size, 0.5);
            assert!(!are_collinear(&[corner(0.0, 0.0), corner(1.0, 0.0), corner(0.3, 1e-3)]));
            assert!(are_collinear(&[corner(0.0, 0.0), corner(1.0, 2.0), corner(0.5, 1.0)]));
        }
    }

    #[test]
    fn slivers_keep_their_box_and_others_their_corners() {
        let p = |k: f32| [0.1_f32 * k, -0.7 * k, 0.3 * k];
        for order in [[1.0, 2.0, 4.0], [2.0, 4.0, 1.0], [4.0, 1.0, 2.0], [2.0, 1.0, 4.0]] {
            let flat = without_sliver(order.map(p));
            for k in 0..3 {
                let mut ends = flat.map(|c| c[k]);
                ends.sort_by(f32::total_cmp);
                let mut right = [p(1.0)[k], p(4.0)[k]];
                right.sort_by(f32::total_cmp);
                assert_eq!([ends[0], ends[2]], right);
            }
            assert!(flat[0] == flat[2]);
        }
        let whole = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1e-30, 0.0]];
        assert_eq!(without_sliver(whole), whole);
    }
}
