//! Rays that leave a surface, and what keeps them from hitting it again.
//!
//! A hit point is never exactly on the surface, so that a ray from it may hit what it leaves
//! (acne), or, started too far away, miss what stands close (a leak). The default starts from the
//! hit refined onto the primitive and moves it along the geometric normal by a bound on what
//! rounding can do: a few ulps of the primitive's largest coordinate, and so nothing absolute. Its
//! interval then begins at 0.
//!
//! A sliver needs more than other triangles, but no more than the scene's largest coordinate
//! allows: beyond it the default triangle test computes in double precision
//! (`accel_core::primitives`). Another test (`triangle-test=moeller-trumbore`) may hit the sliver
//! that a ray leaves.
//!
//! Papers: C. Waechter, N. Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray
//! Tracing Gems, chapter 6, 2019 (offset along the normal in ulps of the coordinate); M. Pharr, W.
//! Jakob, G. Humphreys, *Physically Based Rendering*, 3rd edition, section 3.9, 2016 (the offset
//! as an error bound). Deviations: the bound is that of the whole primitive, because its corners
//! were rounded too; the hit point is projected back in double precision first.

use accel_core::registry::Buildable;
use accel_core::{Ray, Vec3, Vector};
use glam::DVec3;
use scene_loading::Scene;

use super::surface::{RefinedHit, SurfacePoint, largest};

/// In ulps of the scene's largest coordinate, for [`OffsetRule::SceneRelative`].
const SCENE_ULPS: f64 = 512.0;

/// A ray to a target ends so many offsets before it: a surface that the target stands on is met
/// too early by the rounding over the sine of the angle, here of down to 6 degrees.
const TARGET_MARGIN: f64 = 4.0;

/// How a ray is kept off the surface it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OffsetRule {
    None,
    /// Hits nearer than this do not count, world units; Havran and Sixta (1999) took 0.01.
    Fixed(f64),
    /// Hits nearer than 512 ulps of the scene's largest coordinate do not count.
    SceneRelative,
    /// The origin, on whatever side of the surface rounding left it, moves along the normal by 256
    /// ulps of each of its own coordinates; near zero by 2^-16 world units (Waechter, Binder 2019).
    UlpWise,
    /// The origin moves along the normal by so many epsilons of the precision times the largest
    /// coordinate of its primitive, or, off slivers, of up to that of the scene: by what rounding
    /// may do.
    ErrorBound(f64),
}

impl Default for OffsetRule {
    /// 3.8 suffice for triangles (`proofs/ray_offset.gappa`); for other primitives
    /// twice the least bound under which none was hit again: with 1, 50 of
    /// 90,000 rays from spheres were, and 123 of 28,000 from triangles in f64; with 2, none. With
    /// 4, none of 65 million rays hit what they left, or missed what stood in their way, probed or
    /// not; under [`OffsetRule::UlpWise`] 16,040 of 52 million that leave shapes and planes hit and
    /// 21,340 missed (example `offset_trials` of rtbench).
    fn default() -> Self {
        Self::ErrorBound(4.0)
    }
}

/// Makes rays that leave surfaces, in one scene and under one rule.
#[derive(Debug, Clone, Copy)]
pub struct RayOffset {
    rule: OffsetRule,
    /// The scene's largest coordinate, the eye's included.
    magnitude: f64,
}

impl RayOffset {
    /// `magnitude`: the largest coordinate of the scene and the eye, world units.
    pub fn new(rule: OffsetRule, magnitude: f64) -> Self {
        Self { rule, magnitude }
    }

    /// A ray from the surface along `direction`.
    pub fn along<S: Buildable>(&self, point: &SurfacePoint<'_>, direction: DVec3) -> Ray<S> {
        let origin = self.origin::<S>(point, direction);
        let mut ray = Ray::new(origin, Vec3::<S>::from_dvec3(direction));
        ray.t_min = S::from_f64(self.nearest::<S>());
        ray
    }

    /// A ray from the surface to `target`, of unit direction; what lies at the target itself does
    /// not count, so that a light may stand on a surface.
    pub fn to<S: Buildable>(&self, point: &SurfacePoint<'_>, target: DVec3) -> Ray<S> {
        let origin = || self.origin::<S>(point, target - point.position).to_dvec3();
        let (from, margin) = match self.rule {
            OffsetRule::ErrorBound(ulps) => {
                let origin = origin();
                let reach = largest(target).max(largest(origin));
                (origin, bound::<S>(ulps * TARGET_MARGIN, reach))
            }
            OffsetRule::UlpWise => (origin(), 0.0),
            _ => (point.position, 0.0),
        };
        let way = target - from;
        let length = way.length();
        let mut ray = Ray::from_dvec3(from, way / length);
        ray.t_min = S::from_f64(self.nearest::<S>());
        ray.t_max = S::from_f64(length - margin);
        ray
    }

    fn origin<S: Buildable>(&self, point: &SurfacePoint<'_>, direction: DVec3) -> Vec3<S> {
        let RefinedHit { position, normal, magnitude } = point.refined;
        // an apex has no normal: straight ahead
        let normal = if normal == DVec3::ZERO { direction.normalize_or_zero() } else { normal };
        let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
        match self.rule {
            OffsetRule::ErrorBound(ulps) => {
                Vec3::<S>::from_dvec3(position + side * bound::<S>(ulps, magnitude))
            }
            OffsetRule::UlpWise => ulp_wise::<S>(Vec3::<S>::from_dvec3(point.position), side),
            _ => Vec3::<S>::from_dvec3(point.position),
        }
    }

    /// The smallest parameter that counts.
    fn nearest<S: Buildable>(&self) -> f64 {
        match self.rule {
            OffsetRule::None | OffsetRule::UlpWise | OffsetRule::ErrorBound(_) => 0.0,
            OffsetRule::Fixed(epsilon) => epsilon,
            OffsetRule::SceneRelative => self.magnitude * S::EPSILON.to_f64() * SCENE_ULPS,
        }
    }
}

/// See [`OffsetRule::UlpWise`]; the numbers are those of the paper.
fn ulp_wise<S: Buildable>(origin: Vec3<S>, side: DVec3) -> Vec3<S> {
    const NEAR_ZERO: f64 = 1.0 / 32.0;
    const STEP_NEAR_ZERO: f64 = 1.0 / 65536.0;
    const ULPS: f64 = 256.0;
    let at = origin.to_array();
    let along = side.to_array();
    Vec3::<S>::from_array(std::array::from_fn(|k| {
        let size = at[k].abs();
        let step = if size.to_f64() < NEAR_ZERO {
            STEP_NEAR_ZERO
        } else {
            // whole ulps, as the paper adds whole numbers to the bits
            (size.next_up() - size).to_f64() * ULPS
        };
        S::from_f64(at[k].to_f64() + step * along[k])
    }))
}

/// Rounding error of a surface whose largest coordinate is `magnitude`.
fn bound<S: Buildable>(ulps: f64, magnitude: f64) -> f64 {
    magnitude * S::EPSILON.to_f64() * ulps
}

/// The largest coordinate of a scene and its eye, world units.
pub(crate) fn magnitude(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    let scene_size = if bounds.is_empty() { 1.0 } else { bounds.reach() };
    scene_size.max(largest(scene.camera.from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surfaces;
    use accel_core::primitives::{MoellerTrumbore, TriangleTest, Watertight};
    use glam::dvec3;
    use scene_loading::Scene;

    /// Rays off slivers of sides of 1 by 10^-2 to 10^-4: how many hit what they leave.
    fn off_slivers<S: Buildable, T: TriangleTest<S>>(rule: OffsetRule) -> u32 {
        let mut state = 11_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(0x5851_f42d);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let rounded = |p: DVec3| Vec3::<S>::from_dvec3(p);
        let (mut hits, offset) = (0, RayOffset::new(rule, 2.0));
        for _ in 0..2_000 {
            let mut point = || dvec3(random(), random(), random()) * 2.0 - 1.0;
            let (a, along, aside) = (point(), point().normalize(), point());
            let thin = 10.0_f64.powf(-2.0 - 2.0 * random());
            let corners = [a, a + along, a + along * random() + aside * thin].map(rounded);
            let (mut scene, material) = Scene::of_one_material("sliver");
            scene.push_triangle(material, corners.map(Vector::to_dvec3));
            let surfaces = Surfaces::new(&scene, false);
            let [a, b, c] = corners.map(Vector::to_dvec3);
            for _ in 0..10 {
                let (u, v) = (random() * 0.5, random() * 0.5);
                let p = a * (1.0 - u - v) + b * u + c * v;
                let from = surfaces.at(0, p);
                let direction = dvec3(random() - 0.5, random() - 0.5, random() - 0.5);
                let target = p + direction;
                for ray in [offset.along::<S>(&from, direction), offset.to(&from, target)] {
                    let setup = T::setup(&ray, S::from_f64(2.0));
                    let hit = T::intersect(&corners.map(Vector::to_array), &ray, &setup, ray.t_max);
                    hits += u32::from(hit.is_some());
                }
            }
        }
        hits
    }

    #[test]
    fn slivers_are_not_hit_again() {
        assert_eq!(off_slivers::<f32, Watertight>(OffsetRule::default()), 0);
        assert_eq!(off_slivers::<f64, Watertight>(OffsetRule::default()), 0);
        // planted: no offset, too small a one, another test
        assert!(off_slivers::<f32, Watertight>(OffsetRule::None) > 1_000);
        assert!(off_slivers::<f32, Watertight>(OffsetRule::ErrorBound(0.01)) > 100);
        assert!(off_slivers::<f32, MoellerTrumbore>(OffsetRule::default()) > 100);
    }
}
