//! Primitives that move while the shutter is open: linear motion, as a time on the ray.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984: each ray has
//! a time, and primitives are where they are then. Structures see the bounds of the whole way, or
//! of a segment of it, as in A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2),
//! 1988: see [`crate::structures::time_segments`].
//!
//! The motion is a translation at constant velocity, which serves every kind of primitive: the ray
//! is moved the other way and meets the primitive at rest, in the shear that it has wherever it
//! begins. It is a view of a [`MixedSet`] and not part of its tests, so that sets at rest pay
//! nothing for it.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::mixed::MovingSetup;
use crate::primitives::prim_set::as_its_set;
use crate::primitives::triangle_block::{StartLanes, TriangleBlock};
use crate::primitives::watertight;
use crate::primitives::{Ball, MixedSet, PrimSet, PrimitiveKind, Primitives};

/// A mixed set as rays with a time see it.
#[derive(Debug)]
#[repr(transparent)]
pub struct MovingSet<S: Scalar> {
    set: MixedSet<S>,
}

impl<S: Scalar> MixedSet<S> {
    /// The same set as rays with a time see it.
    pub fn in_motion(&self) -> &MovingSet<S> {
        // SAFETY: `MovingSet` is a transparent wrapper of `MixedSet`.
        unsafe { &*std::ptr::from_ref(self).cast::<MovingSet<S>>() }
    }
}

impl<S: Scalar> MovingSet<S> {
    /// Lanes of a block that are hit, with their parameters.
    #[inline(always)]
    fn hits_in(
        &self,
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        MovingSetup { shear, moment, usual, .. }: &MovingSetup<S>,
        t_max: S,
    ) -> Option<(u32, [S; 8])> {
        let (motion, magnitude) = (self.set.motion(), self.set.magnitude());
        let from = if block.moves_as_one() {
            // a branch, and not what is looked up, is waited for: it is guessed, mostly right
            match motion.unusual_velocity(block.id(0)) {
                None => StartLanes::same(usual),
                Some(velocity) => StartLanes::same(&shear.moved_back(velocity, *moment, magnitude)),
            }
        } else {
            let velocities = block.ids().0.map(|id| motion.velocity_or_zero(id));
            StartLanes::each(velocities, shear, *moment, magnitude)
        };
        block.hits_from(&from, ray.t_min, shear, t_max, |lane| {
            let velocity = motion.velocity_or_zero(block.id(lane));
            let shear = shear.moved_back(velocity, *moment, magnitude);
            let relative = ray.moved_back(velocity, *moment);
            watertight::intersect(&block.triangle(lane), &relative, &shear, t_max)
        })
    }
}

impl<S: Scalar> Primitives<S> for MovingSet<S> {
    as_its_set!(S);
}

impl<S: Scalar> PrimSet<S> for MovingSet<S> {
    type RaySetup = MovingSetup<S>;

    const HAS_BLOCKS: bool = true;

    #[inline(always)]
    fn setup(&self, ray: &Ray<S>) -> Self::RaySetup {
        let (shear, motion) = (self.set.setup(ray), self.set.motion());
        let moment = motion.moment(ray.time);
        let usual = shear.moved_back(motion.usual_velocity(), moment, self.set.magnitude());
        let squared_length = ray.direction.dot(ray.direction);
        MovingSetup { shear, moment, usual, squared_length }
    }

    #[inline(always)]
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &Self::RaySetup, t_max: S) -> Option<S> {
        self.set.intersect_moved(id, ray, setup, t_max)
    }

    #[inline(always)]
    fn closest_in_block(
        &self,
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::RaySetup,
        best: &mut Hit<S>,
    ) {
        if let Some((lanes, t)) = self.hits_in(block, ray, setup, best.t) {
            block.take_closest(lanes, &t, best);
        }
    }

    #[inline(always)]
    fn is_blocked_in(
        &self,
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::RaySetup,
    ) -> bool {
        let hits = self.hits_in(block, ray, setup, ray.t_max);
        hits.is_some_and(|(lanes, _)| block.any_of(lanes, |id| self.is_opaque(id)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::scalar::{Vec3, Vector};
    use crate::primitives::{MixedSetBuilder, blocks};
    use crate::structures::test_scenes::Random;

    /// Tests of the moved ray, set up anew, and blocks of eight, against what is derived from the
    /// ray.
    fn is_as_set_up_anew<S: Scalar>() {
        let mut random = Random(8);
        let mut set = MixedSetBuilder::<S>::default();
        for i in 0..64 {
            let mut point = || random.point([1.0; 3]);
            set.triangle([point(), point(), point()]).unwrap();
            if i % 8 != 3 && i / 8 != 5 {
                set.last_moves(point() * 4.0 - DVec3::splat(2.0), 0.5).unwrap();
            }
        }
        let set = set.finish();
        let moving = set.in_motion();
        let (mut hits, mut blocked, mut as_one) = (0, 0, 0);
        for i in 0..2000 {
            let [from, to] = [0; 2].map(|_| Vec3::<S>::from_dvec3(random.point([1.0; 3])));
            let mut direction = (to - from).to_array();
            if i % 5 == 0 {
                direction[i % 3] = S::from_f64([0.0, -1e-42, 1e-20][i / 5 % 3]);
            }
            let time = S::from_f64(random.unit() * 0.5);
            let ray = Ray { time, ..Ray::new(from, Vec3::<S>::from_array(direction)) };
            let setup = moving.setup(&ray);
            let t_max = S::from_f64(1.5);
            let mut best = [Hit { t: t_max, id: u32::MAX }; 8];
            for id in 0..64 {
                let relative = ray.moved_back(set.motion().velocity_or_zero(id), time);
                let anew = set.intersect(id, &relative, &set.setup(&relative), t_max);
                let derived = moving.intersect(id, &ray, &setup, t_max);
                assert_eq!(anew.map(S::to_f64), derived.map(S::to_f64), "{} {id}", S::NAME);
                hits += u32::from(anew.is_some());
                let best = &mut best[id as usize / 8];
                if let Some(t) = anew.filter(|&t| t < best.t) {
                    *best = Hit { t, id };
                }
            }
            for (k, expected) in (0..).zip(best) {
                let ids = k * 8..k * 8 + if k == 7 { 5 } else { 8 };
                if expected.is_hit() && !ids.contains(&expected.id) {
                    continue;
                }
                let ids: Vec<u32> = ids.collect();
                let mut block = TriangleBlock::empty();
                blocks::set_list(&set, &ids, std::slice::from_mut(&mut block));
                as_one += u32::from(block.moves_as_one());
                let mut found = Hit { t: t_max, id: u32::MAX };
                moving.closest_in_block(&block, &ray, &setup, &mut found);
                assert_eq!(found, expected, "{} {i} {k}", S::NAME);
                let ray = Ray { t_max, ..ray };
                assert_eq!(moving.is_blocked_in(&block, &ray, &setup), expected.is_hit());
                blocked += u32::from(found.is_hit());
            }
        }
        assert!(hits > 1000 && blocked > 500, "{hits} {blocked}");
        assert!(as_one > 500 && as_one < 15_000, "both kinds of blocks: {as_one}");
    }

    #[test]
    fn derived_ray_setups_equal_fresh_ones() {
        is_as_set_up_anew::<f32>();
        is_as_set_up_anew::<f64>();
    }
}
