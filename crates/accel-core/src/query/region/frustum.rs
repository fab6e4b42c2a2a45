//! A frustum: the part of space that a beam, a cone or the light towards a surface may touch.
//!
//! Papers: P. Heckbert, P. Hanrahan, "Beam Tracing Polygonal Objects", SIGGRAPH 1984 (pyramids);
//! J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984 (a cone is held by a pyramid around it);
//! E. Haines, J. Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", Eurographics
//! Workshop on Rendering 1991 (the name, and the tests by planes). Deviation: a frustum is the hull
//! of a near and a far outline, not of two boxes.
//!
//! All answers are conservative: rounding may add what a frustum just misses, never drop what it
//! meets.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::primitives::Ball;

/// Rounding errors of a plane's distance, in epsilons of the frustum's largest coordinate.
const TOLERANCE: f64 = 64.0 * f64::EPSILON;

/// The convex hull of two outlines with as many corners each, world units: a pyramid, a frustum or
/// a prism whose sides are flat.
#[derive(Debug, Clone)]
pub struct Frustum {
    near: Vec<DVec3>,
    far: Vec<DVec3>,
    /// Unit outward normals, and how far along them the frustum reaches.
    planes: Vec<(DVec3, f64)>,
    bounds: Aabb<f64>,
    /// From the near outline to the far one, of unit length.
    direction: DVec3,
    tolerance: f64,
}

impl Frustum {
    /// The hull of `near` and `far`: corner `k` of one is joined to corner `k` of the other, and
    /// what they enclose has flat sides. The longer list is cut to the length of the shorter; at
    /// least three corners are needed for a volume. Near corners may all be one point, an apex.
    pub fn new(near: &[DVec3], far: &[DVec3]) -> Self {
        let corners = near.len().min(far.len());
        let (near, far) = (near[..corners].to_vec(), far[..corners].to_vec());
        let all = || near.iter().chain(&far);
        let bounds = all().fold(Aabb::<f64>::empty(), |b, &p| b.union(Aabb { min: p, max: p }));
        let sum = |points: &[DVec3]| points.iter().sum::<DVec3>();
        let across = sum(&far) - sum(&near);
        let centre = (sum(&far) + sum(&near)) / (2 * corners).max(1) as f64;
        let magnitude = all().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let mut planes = Vec::with_capacity(corners + 2);
        let mut push = |normal: DVec3| {
            // a side that is no more than a line bounds nothing
            let Some(normal) = normal.try_normalize() else { return };
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in near.iter().chain(&far) {
                low = low.min(normal.dot(*p));
                high = high.max(normal.dot(*p));
            }
            let middle = normal.dot(centre);
            if high - middle <= middle - low {
                planes.push((normal, high));
            } else {
                planes.push((-normal, -low));
            }
        };
        for k in 0..corners {
            let next = (k + 1) % corners;
            let (here, there) = (far[next] - far[k], near[next] - near[k]);
            let edge = if here.length_squared() >= there.length_squared() { here } else { there };
            push((far[k] - near[k]).cross(edge));
        }
        for outline in [&near, &far] {
            push(outline_normal(outline));
        }
        let direction = across.normalize_or_zero();
        Self { near, far, planes, bounds, direction, tolerance: TOLERANCE * magnitude }
    }

    /// The pyramid from `apex` along unit or other directions, cut `reach` of their lengths away.
    pub fn pyramid(apex: DVec3, directions: &[DVec3], reach: f64) -> Self {
        let near = vec![apex; directions.len()];
        let far: Vec<DVec3> = directions.iter().map(|d| apex + *d * reach).collect();
        Self::new(&near, &far)
    }

    /// From the near outline to the far one, of unit length; zero when they have one centre.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// How far along the frustum a point lies; the first near corner has depth 0.
    pub fn depth(&self, point: DVec3) -> f64 {
        match self.near.first() {
            Some(&first) => (point - first).dot(self.direction),
            None => 0.0,
        }
    }

    /// The least depth of any point of the box.
    pub fn least_depth(&self, cell: &Aabb<f64>) -> f64 {
        self.depth(least_along(cell, self.direction)) - self.tolerance
    }

    /// The box around the frustum.
    pub fn bounds(&self) -> Aabb<f64> {
        self.bounds
    }

    /// By how much the frustum is thought larger than it is, world units.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// False only when no point of the box lies in the frustum.
    #[inline]
    pub fn meets_box(&self, cell: &Aabb<f64>) -> bool {
        let Aabb { min, max } = self.bounds;
        if (cell.min - max).max(min - cell.max).max_element() > self.tolerance {
            return false;
        }
        let tolerance = self.tolerance;
        let meets = |(n, reach): &(DVec3, f64)| n.dot(least_along(cell, *n)) <= reach + tolerance;
        self.planes.iter().all(meets)
    }

    /// False when a side of the frustum has all the balls outside, and so their convex hull.
    #[inline]
    pub fn meets_balls(&self, balls: &[Ball]) -> bool {
        self.planes.iter().all(|&(normal, reach)| {
            let limit = reach + self.tolerance;
            balls.iter().any(|ball| normal.dot(ball.center) - ball.radius <= limit)
        })
    }

    /// The axis along which the frustum is longest.
    pub fn longest_axis(&self) -> usize {
        self.direction.abs().max_position()
    }

    /// The frustum made ready to be cut across an axis.
    pub fn across(&self, axis: usize) -> AxisFrustum<'_> {
        let upwards = self.direction[axis] >= 0.0;
        let along = |p: DVec3| if upwards { p[axis] } else { -p[axis] };
        let (mut near_max, mut far_min) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (n, f) in self.near.iter().zip(&self.far) {
            let (n, f) = (along(*n), along(*f));
            near_max = near_max.max(n);
            far_min = far_min.min(f);
            least = least.min(n.min(f));
            most = most.max(n.max(f));
        }
        AxisFrustum { frustum: self, axis, upwards, near_max, far_min, least, most }
    }
}

/// A frustum seen along an axis, mirrored so that it runs upwards.
#[derive(Debug, Clone, Copy)]
pub struct AxisFrustum<'a> {
    frustum: &'a Frustum,
    axis: usize,
    upwards: bool,
    /// Depths at which the near outline ends and the far one begins: planes between cut all edges.
    near_max: f64,
    far_min: f64,
    /// Depths at which the frustum begins and ends.
    least: f64,
    most: f64,
}

impl AxisFrustum<'_> {
    /// A box around the part of the frustum between the planes `from <= to` of the axis, if there
    /// is any. It is tight where both outlines lie outside the two planes.
    pub fn slice(&self, from: f64, to: f64) -> Option<Aabb<f64>> {
        let Self { frustum, near_max, far_min, .. } = *self;
        let (from, to) = if self.upwards { (from, to) } else { (-to, -from) };
        let (from, to) = (from - frustum.tolerance, to + frustum.tolerance);
        if to < self.least || from > self.most {
            return None;
        }
        if near_max > far_min {
            // so oblique that the outlines overlap: no plane cuts all edges
            return Some(frustum.bounds.expanded(frustum.tolerance));
        }
        let mut slice = Aabb::<f64>::empty();
        let mut include = |p: DVec3| slice = slice.union(Aabb { min: p, max: p });
        // where the planes cut the edges from near to far; they do, within the two
        let planes = [from.clamp(near_max, far_min), to.clamp(near_max, far_min)];
        for (&near, &far) in frustum.near.iter().zip(&frustum.far) {
            let way = far - near;
            let start = if self.upwards { near[self.axis] } else { -near[self.axis] };
            let length = way[self.axis].abs();
            let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
            for plane in planes {
                include(near + way * ((plane - start) * scale).clamp(0.0, 1.0));
            }
            if from < near_max {
                include(near);
            }
            if to > far_min {
                include(far);
            }
        }
        Some(slice.expanded(frustum.tolerance))
    }
}

/// The corner of a box that lies least far along a direction.
#[inline(always)]
fn least_along(cell: &Aabb<f64>, direction: DVec3) -> DVec3 {
    DVec3::select(direction.cmpgt(DVec3::ZERO), cell.min, cell.max)
}

/// A normal of a flat outline, of any length; zero when it has no area.
fn outline_normal(outline: &[DVec3]) -> DVec3 {
    let Some(&first) = outline.first() else { return DVec3::ZERO };
    outline.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    /// A frustum along any axis, and a point within it for two numbers and a share each.
    fn random_frustum(random: &mut Random) -> (Frustum, impl Fn(&mut Random) -> DVec3 + use<>) {
        let apex = random.point([2.0; 3]) - DVec3::ONE;
        let forward = (random.point([2.0; 3]) - DVec3::ONE).normalize();
        let (u, v) = forward.any_orthonormal_pair();
        let (half, begin) = (0.01 + 0.4 * random.unit(), random.unit() * 0.5);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let directions = corners.map(|(a, b)| forward + (u * a + v * b) * half);
        let near = directions.map(|d| apex + d * begin);
        let far = directions.map(|d| apex + d * 3.0);
        let inside = move |random: &mut Random| {
            let (a, b) = (random.unit() * 2.0 - 1.0, random.unit() * 2.0 - 1.0);
            let along = begin + (3.0 - begin) * random.unit();
            apex + (forward + (u * a + v * b) * half) * along
        };
        (Frustum::new(&near, &far), inside)
    }

    #[test]
    fn boxes_and_balls_with_a_point_of_the_frustum_overlap_it() {
        let mut random = Random(11);
        let (mut boxes_missed, mut balls_missed) = (0, 0);
        for _ in 0..400 {
            let (frustum, inside) = random_frustum(&mut random);
            for _ in 0..50 {
                let p = inside(&mut random);
                let size = random.point([0.2; 3]);
                let lo = p - size * random.point([1.0; 3]);
                let cell = Aabb::<f64> { min: lo, max: lo + size };
                assert!(frustum.meets_box(&cell));
                assert!(frustum.least_depth(&cell) <= frustum.depth(p));
                assert!(frustum.meets_balls(&[Ball { center: p, radius: 0.0 }]));
                for axis in 0..3 {
                    let (from, to) = (p[axis] - random.unit() * 0.1, p[axis] + random.unit() * 0.1);
                    let slice = frustum.across(axis).slice(from, to).expect("it holds the point");
                    assert!(slice.min.cmple(p).all() && slice.max.cmpge(p).all());
                }
                let elsewhere = random.point([8.0; 3]) - DVec3::splat(4.0);
                let away = Aabb::<f64> { min: elsewhere, max: elsewhere + size };
                boxes_missed += u32::from(!frustum.meets_box(&away));
                let ball = Ball { center: elsewhere, radius: 0.1 };
                balls_missed += u32::from(!frustum.meets_balls(&[ball]));
            }
        }
        // the tests have power: most of 20,000 places are not in the frustum
        assert!(boxes_missed > 15_000 && balls_missed > 15_000, "{boxes_missed} {balls_missed}");
    }

    #[test]
    fn slices_are_tight_away_from_the_ends() {
        let directions = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)];
        let directions = directions.map(|(y, z)| DVec3::new(1.0, y, z));
        let frustum = Frustum::pyramid(DVec3::ZERO, &directions, 10.0);
        let slice = frustum.across(0).slice(4.0, 5.0).unwrap();
        assert!((slice.max.y - 0.5).abs() < 1e-9 && (slice.min.z + 0.5).abs() < 1e-9);
        let across = frustum.across(0);
        assert!(across.slice(10.1, 11.0).is_none() && across.slice(-1.0, -0.1).is_none());
    }
}
