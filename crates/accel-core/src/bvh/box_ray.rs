//! Rays as boxes in f32 are tested with them, and what a ray's parameters are there.

use glam::{Vec3, Vec3A};
use obvhs::ray::Ray as ObvhsRay;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::{Ray, unit_factor};
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::{Scalar, Vector};

/// How rays are told to a tree: in units of the scene's size, so that its largest coordinate lies
/// in [1, 2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct RaySetup<S> {
    /// A power of two.
    unit: S,
}

impl<S: Scalar> RaySetup<S> {
    /// For a scene whose largest coordinate is `magnitude`.
    pub(super) fn new(magnitude: S) -> Self {
        Self { unit: magnitude.to_unit_size() }
    }

    /// Factor that coordinates are multiplied by.
    pub(crate) fn unit(&self) -> f64 {
        self.unit.to_f64()
    }

    /// A box as the tree has it, in world units.
    pub(crate) fn world(&self, [low, high]: [[f32; 3]; 2]) -> Aabb<f64> {
        let [min, max] = [low, high].map(|p| Vec3::from_array(p).as_dvec3() / self.unit());
        Aabb { min, max }
    }

    /// The ray as boxes see it.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &Ray<S>, length: Length) -> BoxRay<S> {
        BoxRay::new(ray, self.unit, length)
    }

    /// [`RaySetup::ray`] of [`Length::Own`] for eight rays whose intervals begin at their origins
    /// or later.
    #[inline(always)]
    pub(crate) fn ray_lanes(&self, rays: &RayLanes<S>) -> BoxRayLanes<S> {
        let unit = self.unit;
        let is_own = size_of::<S>() == size_of::<f32>();
        let mut lanes = BoxRayLanes {
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            parameters: [BoxParameters { scale: unit, lead: 0.0 }; LANES],
        };
        for lane in 0..LANES {
            let direction = [0, 1, 2].map(|k| rays.direction[k][lane]);
            let shorter = if is_own { S::ONE } else { unit_factor(direction) };
            lanes.parameters[lane].scale = unit / shorter;
            for (k, d) in direction.into_iter().enumerate() {
                lanes.origin[k][lane] = (rays.origin[k][lane] * unit).to_f64() as f32;
                // -0 becomes 0
                lanes.direction[k][lane] = (d * shorter).to_f64() as f32 + 0.0;
            }
        }
        lanes
    }
}

/// Rule for the length of the ray direction in box tests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Length {
    /// The ray's own in f32, its largest component in [1, 2) in f64 or where it starts earlier.
    Own,
    /// Its largest component lies in [1, 2) times [`BRIEF`].
    Brief,
}

/// A ray for box tests.
pub(crate) struct BoxRay<S: Scalar> {
    pub(crate) origin: Vec3A,
    pub(crate) direction: Vec3A,
    pub(crate) parameters: BoxParameters<S>,
}

/// Eight of them, by axis and lane.
pub(crate) struct BoxRayLanes<S: Scalar> {
    pub(crate) origin: [[f32; LANES]; 3],
    pub(crate) direction: [[f32; LANES]; 3],
    pub(crate) parameters: [BoxParameters<S>; LANES],
}

/// Maps our ray parameters to those of a [`BoxRay`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoxParameters<S> {
    /// Ratio of its parameters to ours.
    scale: S,
    /// Our `t` is at most `t * scale + lead`: how far the ray starts before the true origin, or a
    /// little more.
    lead: f32,
}

/// CwBvh ignores boxes that begin or end before t = 1e-4. A ray that starts this much before its
/// origin finds them, in units of the scene's size if the largest component of its direction is in
/// [1, 2).
const LEAD: f32 = 1.0625e-4;
/// For a direction shorter by this factor, 1e-4 is a tenth of an ulp: no padded box ends before it.
const BRIEF: f32 = f32::from_bits((127 - 14) << 23);

/// Half the side of a cube around the origin that holds the scene, in units of its size.
const CUBE: f64 = 3.0;

/// More than the rounding of both terms where a negative parameter and a lead are added: origins
/// lie within 16 of the cube's centre, and so leads are below 20.
const LEAD_SLACK: f32 = 32.0 * f32::EPSILON;

impl<S: Scalar> BoxRay<S> {
    #[inline(always)]
    fn new(ray: &Ray<S>, unit: S, length: Length) -> Self {
        if ray.t_min < S::ZERO {
            return Self::starting_earlier(ray, unit);
        }
        let is_own = length == Length::Own && size_of::<S>() == size_of::<f32>();
        let mut shorter = if is_own { S::ONE } else { ray.unit_factor() };
        let mut lead = 0.0;
        if length == Length::Brief {
            shorter = shorter * S::from_f64(f64::from(BRIEF));
            lead = LEAD;
        }
        let origin = to_f32::<S>(ray.origin * unit);
        Self::scaled(ray, origin, unit, shorter, lead)
    }

    /// Moves the origin of a ray whose interval begins before it.
    #[cold]
    #[inline(never)]
    fn starting_earlier(ray: &Ray<S>, unit: S) -> Self {
        let shorter = ray.unit_factor();
        let (start, lead) = earlier_start(ray, unit, shorter);
        Self::scaled(ray, start, unit, shorter, lead)
    }

    #[inline(always)]
    fn scaled(ray: &Ray<S>, origin: Vec3, unit: S, shorter: S, lead: f32) -> Self {
        let origin = Vec3A::from(origin);
        let direction = Vec3A::from(to_f32::<S>(ray.direction * shorter)) + Vec3A::ZERO;
        let scale = unit / shorter;
        Self { origin, direction, parameters: BoxParameters { scale, lead } }
    }

    /// This for obvhs, up to `t_max`.
    #[inline(always)]
    pub(crate) fn for_obvhs(&self, t_max: S) -> ObvhsRay {
        let (origin, direction) = (self.origin, self.direction);
        // all axes at once
        let is_small = direction.abs().cmplt(Vec3A::splat(1e-30));
        let large = Vec3A::splat(f32::from_bits(0x7180_0000)).copysign(direction);
        let inv_direction = Vec3A::select(is_small, large, direction.recip());
        let tmax = self.parameters.bound(t_max);
        ObvhsRay { origin, direction, inv_direction, tmin: 0.0, tmax }
    }
}

impl<S: Scalar> BoxParameters<S> {
    /// Returns whether its origin is not the true one.
    #[inline(always)]
    pub(crate) fn starts_earlier(&self) -> bool {
        self.lead > 0.0
    }

    /// A bound for box tests that no rounding makes too small (`proofs/ray_end.gappa`).
    #[inline(always)]
    pub(crate) fn bound(&self, t_max: S) -> f32 {
        let t = (t_max * self.scale).to_f64() as f32;
        // 0 * infinity: `max` gives 0 for NaN
        (t + self.lead).max(0.0) * (1.0 + 2.0 * f32::EPSILON)
    }
}

/// The start of a ray whose interval begins before its origin, and its lead: at the begin of the
/// interval, or where the ray enters the cube around the scene if that is later.
fn earlier_start<S: Scalar>(ray: &Ray<S>, unit: S, shorter: S) -> (Vec3, f32) {
    let origin = ray.origin.to_dvec3() * unit.to_f64();
    let direction = ray.direction.to_dvec3() * shorter.to_f64();
    let (o, d) = (origin.to_array(), direction.to_array());
    let mut start = ray.t_min.to_f64() * (unit / shorter).to_f64();
    for k in 0..3 {
        if d[k] != 0.0 {
            start = start.max((-CUBE.copysign(d[k]) - o[k]) / d[k]);
        }
    }
    // never later than rays without negative parameters
    let start = start.min(0.0) - f64::from(LEAD);
    ((origin + direction * start).as_vec3(), -start as f32 + LEAD_SLACK)
}

#[inline(always)]
fn to_f32<S: Scalar>(v: crate::Vec3<S>) -> Vec3 {
    let [x, y, z] = v.to_array();
    Vec3::new(x.to_f64() as f32, y.to_f64() as f32, z.to_f64() as f32)
}
