//! Checks claims that primitives are copies.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec3};

use crate::geometry::scalar::Scalar;
use crate::primitives::Primitives;
use crate::primitives::instances::{ConfirmedCopy, Instance, Instances, Object, stretch};
use crate::primitives::support::Ball;

/// The largest factor by which a copy is larger or smaller than another one of its object, on any
/// axis: beyond it, the rounding of one is no small part of the other.
const LARGEST_FACTOR: f64 = 1024.0;

impl Instances {
    /// Those of the claims that hold for this set: disjoint ranges of its ids, each primitive of a
    /// copy where the transform between placements takes that of the first copy, up to the rounding
    /// of coordinates. What does not hold is an instance of nothing, and left out; so is what is
    /// alone then.
    pub fn confirmed<S: Scalar>(prims: &dyn Primitives<S>, claims: &[Instance]) -> Self {
        let mut claims: Vec<&Instance> = claims.iter().filter(|claim| claim.count > 0).collect();
        claims.sort_by_key(|claim| claim.first);
        let mut end = 0;
        claims.retain(|claim| {
            let is_apart = claim.first >= end
                && claim.first.checked_add(claim.count).is_some_and(|e| e as usize <= prims.len());
            if is_apart {
                end = claim.first + claim.count;
            }
            is_apart
        });
        let parts = claims.iter().map(|&claim| *claim).collect();
        let mut objects: Vec<(&Instance, Object)> = Vec::new();
        let mut places = HashMap::new();
        let mut hulls = Hulls::default();
        for claim in claims {
            let place = places.entry((claim.object, claim.count)).or_insert(objects.len());
            let Some((first, object)) = objects.get_mut(*place) else {
                let copies = vec![ConfirmedCopy { first: claim.first, to_first: None }];
                objects.push((claim, Object { count: claim.count, copies }));
                continue;
            };
            let from_first = claim.placement * first.placement.inverse();
            let to_first = inverse(from_first);
            if to_first.is_some() && hulls.agree([prims; 2], first, claim, from_first) {
                object.copies.push(ConfirmedCopy { first: claim.first, to_first });
            }
        }
        let objects = objects.into_iter().map(|(_, object)| object);
        Self { objects: objects.filter(|object| object.copies.len() > 1).collect(), parts }
    }

    /// The parts of `now`, which these are of, that are where the transform between their
    /// placements takes those of `before`, up to the rounding of coordinates.
    pub(super) fn rigid_parts<S: Scalar>(
        &self,
        now: &dyn Primitives<S>,
        before: &dyn Primitives<S>,
    ) -> Vec<Instance> {
        let Some(then) = before.instances() else { return Vec::new() };
        let mut hulls = Hulls::default();
        let mut is_rigid = |part: &Instance| {
            let Some(old) = then.part_of(part.first) else { return false };
            let from_old = part.placement * old.placement.inverse();
            (old.first, old.count, old.object) == (part.first, part.count, part.object)
                && inverse(from_old).is_some()
                && hulls.agree([before, now], old, part, from_old)
        };
        self.parts.iter().filter(|part| is_rigid(part)).copied().collect()
    }
}

/// The inverse where neither it nor the transform stretches much.
fn inverse(transform: DAffine3) -> Option<DAffine3> {
    let inverse = transform.inverse();
    let is_usable = |t: &DAffine3| t.is_finite() && stretch(&t.matrix3) <= LARGEST_FACTOR;
    (is_usable(&transform) && is_usable(&inverse)).then_some(inverse)
}

/// The factor by which a transform scales balls, if it keeps them balls.
fn uniform_scale(matrix: &DMat3) -> Option<f64> {
    let scale = matrix.determinant().abs().cbrt();
    let excess = *matrix * matrix.transpose() * (1.0 / (scale * scale)) - DMat3::IDENTITY;
    (stretch(&excess) < 1e-9).then_some(scale)
}

/// Room for the hulls of two primitives.
#[derive(Default)]
struct Hulls([Vec<Ball>; 2]);

impl Hulls {
    fn agree<S: Scalar>(
        &mut self,
        [of_first, of_copy]: [&dyn Primitives<S>; 2],
        first: &Instance,
        copy: &Instance,
        from_first: DAffine3,
    ) -> bool {
        let scale = uniform_scale(&from_first.matrix3);
        let magnitude = of_first.magnitude().greater(of_copy.magnitude());
        let rounding = S::EPSILON.to_f64() * magnitude.to_f64();
        let tolerance = 2.0 * rounding * (1.0 + stretch(&from_first.matrix3));
        let is_copy = |a: &Ball, b: &Ball| {
            let off = (from_first.transform_point3(a.center) - b.center).abs();
            let has_radius = match scale {
                _ if a.radius == 0.0 => b.radius == 0.0,
                Some(scale) => (a.radius * scale - b.radius).abs() <= tolerance,
                None => false,
            };
            off.cmple(DVec3::splat(tolerance)).all() && has_radius
        };
        let [own, other] = &mut self.0;
        (0..copy.count).all(|k| {
            own.clear();
            other.clear();
            of_first.hull(first.first + k, own);
            of_copy.hull(copy.first + k, other);
            of_first.kind(first.first + k) == of_copy.kind(copy.first + k)
                && own.len() == other.len()
                && own.iter().zip(other.iter()).all(|(a, b)| is_copy(a, b))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{MixedSetBuilder, TriangleSet};

    fn moved(by: f64) -> DAffine3 {
        DAffine3::from_translation(DVec3::X * by) * DAffine3::from_rotation_z(by)
    }

    fn triangles(placements: &[DAffine3]) -> (TriangleSet<f32>, Vec<Instance>) {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 1.0, 0.2)];
        let mut all = Vec::new();
        let mut claims = Vec::new();
        for (i, placement) in placements.iter().enumerate() {
            for z in [0.0, 0.7] {
                let at = |p: DVec3| placement.transform_point3(p + DVec3::Z * z).as_vec3();
                all.push(corners.map(|p| at(p).to_array()));
            }
            claims.push(Instance {
                object: 3,
                first: 2 * i as u32,
                count: 2,
                placement: *placement,
            });
        }
        (TriangleSet::new(all, |_| false).unwrap(), claims)
    }

    #[test]
    fn claimed_copies_are_confirmed_or_refused() {
        let places = [0.0, 5.0, -3.0].map(moved);
        let (set, claims) = triangles(&places);
        let found = Instances::confirmed(&set, &claims);
        assert_eq!((found.objects(), found.copies(), found.copied_primitives()), (1, 3, 4));
        let back =
            found.all()[0].copies[1].to_first.unwrap().transform_point3(places[1].translation);
        assert!(back.length() < 1e-12, "{back}");

        // planted: another place, ranges that overlap or end beyond the set, transforms without an
        // inverse
        let mut wrong = claims.clone();
        wrong[1].placement.translation.x += 1e-5;
        assert_eq!(Instances::confirmed(&set, &wrong).copies(), 2);
        wrong[2].first = 3;
        assert_eq!(Instances::confirmed(&set, &wrong).copies(), 0);
        for placement in [DAffine3::ZERO, DAffine3::from_scale(DVec3::splat(f64::NAN))] {
            let wrong: Vec<_> = claims.iter().map(|c| Instance { placement, ..*c }).collect();
            assert_eq!(Instances::confirmed(&set, &wrong).copies(), 0);
        }
        let beyond = claims.iter().map(|c| Instance { count: u32::MAX, ..*c }).collect::<Vec<_>>();
        assert_eq!(Instances::confirmed(&set, &beyond), Instances::default());
    }

    #[test]
    fn spheres_are_copies_only_where_they_stay_spheres() {
        let copies = |scale: DVec3, radius: f64| {
            let placement = DAffine3::from_scale(scale);
            let mut set = MixedSetBuilder::<f64>::default();
            set.sphere(DVec3::ONE, 0.5).unwrap();
            set.sphere(placement.transform_point3(DVec3::ONE), radius).unwrap();
            let set = set.finish();
            let claim = |first, placement| Instance { object: 0, first, count: 1, placement };
            Instances::confirmed(&set, &[claim(0, DAffine3::IDENTITY), claim(1, placement)])
                .copies()
        };
        assert_eq!(copies(DVec3::splat(2.0), 1.0), 2);
        assert_eq!(copies(DVec3::splat(2.0), 1.1), 0);
        assert_eq!(copies(DVec3::new(2.0, 2.0, 1.9), 1.0), 0);
    }
}
