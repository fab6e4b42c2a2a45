//! How far points reach along a direction, and away from a place.
//!
//! In f64: this is what bounding volumes are made from, once a build, and squares of coordinates
//! that f32 cannot hold are no trouble here.

use glam::DVec3;

use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// A ball, for the convex hulls of [`crate::primitives::Primitives::hull`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    pub center: DVec3,
    /// Radius, world units; 0 for a point.
    pub radius: f64,
}

/// Appends a ball of that radius around each point.
pub(super) fn balls_around<S: Scalar>(points: &[[S; 3]], radius: f64, balls: &mut Vec<Ball>) {
    let ball = |&p| Ball { center: Vec3::<S>::from_array(p).to_dvec3(), radius };
    balls.extend(points.iter().map(ball));
}

/// Smallest and largest dot product of a point with `direction`; an empty interval (infinite,
/// minus infinite) without points.
pub(super) fn extent_of_points<S: Scalar>(points: &[[S; 3]], direction: DVec3) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &p| {
        let along = Vec3::<S>::from_array(p).to_dvec3().dot(direction);
        (lo.min(along), hi.max(along))
    })
}

/// Distance of `from` to the farthest point, world units; 0 without points.
pub(super) fn distance_to_points<S: Scalar>(points: &[[S; 3]], from: DVec3) -> f64 {
    let distance = |&p| Vec3::<S>::from_array(p).to_dvec3().distance(from);
    points.iter().map(distance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{
        Cone, MixedSet, MixedSetBuilder, PrimSet, Primitives, TriangleSet, Watertight,
    };
    use glam::dvec3;

    const BASE: DVec3 = dvec3(0.3, -0.2, 0.5);
    const APEX: DVec3 = dvec3(1.1, 0.7, -0.4);
    const CENTRE: DVec3 = dvec3(-0.4, 0.9, 2.0);

    /// Corners of a triangle, and of a quadrilateral in the plane of the first three.
    fn corners() -> [DVec3; 4] {
        let [a, b, c] = [dvec3(0.1, 0.2, 0.3), dvec3(1.0, -0.5, 0.4), dvec3(0.3, 0.8, 1.7)];
        [a, b, b + c - a, c]
    }

    /// One primitive of each kind, and as many points of its surface, the outermost ones among
    /// them but for 1e-3.
    fn primitives<S: Scalar>() -> (MixedSet<S>, Vec<Vec<DVec3>>) {
        let mut set = MixedSetBuilder::<S>::default();
        let [a, b, c, d] = corners();
        set.triangle([a, b, c]).unwrap();
        set.polygon(&[a, b, c, d]).unwrap();
        set.sphere(CENTRE, 0.7).unwrap();
        set.cone(Cone::new(BASE, 0.5, APEX, 0.2)).unwrap();
        set.cone(Cone::new(BASE, -0.3, APEX, -0.3)).unwrap();
        let points = vec![
            grid().map(|(u, v)| a + (b - a) * u * (1.0 - v) + (c - a) * v * u).collect(),
            grid().map(|(u, v)| a + (b - a) * u + (d - a) * v).collect(),
            grid().map(|(u, v)| CENTRE + 0.7 * on_sphere(u, v)).collect(),
            grid().map(|(u, v)| on_cone(0.5, 0.2, u, v)).collect(),
            grid().map(|(u, v)| on_cone(0.3, 0.3, u, v)).collect(),
        ];
        (set.finish(), points)
    }

    fn grid() -> impl Iterator<Item = (f64, f64)> {
        (0..=200).flat_map(|i| (0..=200).map(move |j| (f64::from(i) / 200.0, f64::from(j) / 200.0)))
    }

    fn on_sphere(u: f64, v: f64) -> DVec3 {
        let ((sin, cos), height) = ((u * std::f64::consts::TAU).sin_cos(), v * 2.0 - 1.0);
        (dvec3(cos, sin, 0.0) * (1.0 - height * height).sqrt()).with_z(height)
    }

    fn on_cone(base_radius: f64, apex_radius: f64, u: f64, v: f64) -> DVec3 {
        let axis = (APEX - BASE).normalize();
        let (x, y) = axis.any_orthonormal_pair();
        let (sin, cos) = (u * std::f64::consts::TAU).sin_cos();
        let radius = base_radius + (apex_radius - base_radius) * v;
        BASE.lerp(APEX, v) + (x * cos + y * sin) * radius
    }

    fn directions() -> Vec<DVec3> {
        let signs = [-1.0, 0.0, 1.0];
        let all = signs.iter().flat_map(|&x| signs.iter().map(move |&y| (x, y)));
        let all = all.flat_map(|(x, y)| signs.iter().map(move |&z| dvec3(x, y, z)));
        all.chain([(APEX - BASE) * 0.3, dvec3(0.1, -7.0, 2.0)]).collect()
    }

    /// Returns whether the interval holds the dot products of all points, up to `tolerance`.
    fn holds((lo, hi): (f64, f64), points: &[DVec3], n: DVec3, tolerance: f64) -> bool {
        points.iter().map(|p| p.dot(n)).all(|x| lo - tolerance <= x && x <= hi + tolerance)
    }

    fn extents_hold_the_surface_and_no_more<S: Scalar>() {
        let (set, surfaces) = primitives::<S>();
        let ulps = 8.0 * S::EPSILON.to_f64();
        for (id, points) in surfaces.iter().enumerate() {
            for n in directions() {
                let (lo, hi) = set.extent(id as u32, n);
                let (rounding, step) = (ulps * n.length(), 1e-3 * n.length());
                let what = format!("{} primitive {id} along {n}: {lo} {hi}", S::NAME);
                assert!(holds((lo, hi), points, n, rounding), "{what}");
                // planted faults: an interval that is a little too small must be noticed
                assert!(n == DVec3::ZERO || !holds((lo + step, hi), points, n, rounding), "{what}");
                assert!(n == DVec3::ZERO || !holds((lo, hi - step), points, n, rounding), "{what}");
            }
        }
    }

    #[test]
    fn extents_are_those_of_the_surface() {
        extents_hold_the_surface_and_no_more::<f32>();
        extents_hold_the_surface_and_no_more::<f64>();
    }

    #[test]
    fn distances_are_those_of_the_farthest_surface_point() {
        let (set, surfaces) = primitives::<f64>();
        for (id, points) in surfaces.iter().enumerate() {
            for from in [DVec3::ZERO, CENTRE, BASE, (BASE + APEX) * 0.5, dvec3(9.0, -4.0, 2.0)] {
                let distance = set.farthest(id as u32, from);
                let sampled = points.iter().map(|p| p.distance(from)).fold(0.0, f64::max);
                assert!(sampled <= distance + 1e-12, "primitive {id}: {sampled} {distance}");
                assert!(sampled >= distance - 1e-3, "primitive {id}: {sampled} {distance}");
            }
        }
    }

    /// Returns whether every point lies within the hull of the balls, up to `tolerance`, as far as
    /// these directions tell.
    fn hull_holds(balls: &[Ball], points: &[DVec3], tolerance: f64) -> bool {
        directions().into_iter().filter(|n| *n != DVec3::ZERO).all(|n| {
            let n = n.normalize();
            let reach = |b: &Ball| b.center.dot(n) + b.radius;
            let hi = balls.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
            points.iter().all(|p| p.dot(n) <= hi + tolerance)
        })
    }

    fn hulls_hold_the_surface<S: Scalar>() {
        let (set, surfaces) = primitives::<S>();
        let rounding = 8.0 * S::EPSILON.to_f64();
        for (id, points) in surfaces.iter().enumerate() {
            let mut balls = Vec::new();
            set.hull(id as u32, &mut balls);
            assert!(hull_holds(&balls, points, rounding), "{} primitive {id}", S::NAME);
            // planted fault: without any one of its balls the hull is too small
            for i in 0..balls.len() {
                let mut fewer = balls.clone();
                fewer.remove(i);
                assert!(!hull_holds(&fewer, points, rounding), "{} primitive {id}", S::NAME);
            }
        }
    }

    #[test]
    fn hulls_are_those_of_the_surface() {
        hulls_hold_the_surface::<f32>();
        hulls_hold_the_surface::<f64>();
    }

    #[test]
    fn triangle_sets_know_the_extents_of_mixed_ones() {
        let [a, b, c, _] = corners().map(|p| p.to_array());
        let triangles = TriangleSet::<f64, Watertight>::new(vec![[a, b, c]], |_| false).unwrap();
        let (mixed, _) = primitives::<f64>();
        for n in directions() {
            assert_eq!(triangles.extent(0, n), mixed.extent(0, n));
            assert_eq!(triangles.farthest(0, n), mixed.farthest(0, n));
        }
    }

    #[test]
    fn a_bent_polygon_reaches_as_far_as_its_plane() {
        // hits lie between the corners or on the plane, which those leave by a hundredth
        let corner = |x: f64, y: f64, z: f64| dvec3(x, y, x + y + z);
        let bent = [
            corner(0.0, 0.0, 0.01),
            corner(1.0, 0.0, -0.01),
            corner(1.0, 1.0, 0.01),
            corner(0.0, 1.0, -0.01),
        ];
        let mut set = MixedSetBuilder::<f64>::default();
        set.polygon(&bent).unwrap();
        let set = set.finish();
        let ray = crate::Ray::<f64>::new(dvec3(0.4, 0.6, 9.0), dvec3(0.0, 0.0, -1.0));
        let t = set.intersect(0, &ray, &set.setup(&ray), f64::INFINITY).unwrap();
        let normal = dvec3(-1.0, -1.0, 1.0);
        assert!(holds(set.extent(0, normal), &[ray.at(t)], normal, 0.0));
    }
}
