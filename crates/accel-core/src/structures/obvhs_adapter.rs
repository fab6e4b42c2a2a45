//! What it takes to get right answers from `obvhs` 0.4, and the boxes it is given.
//!
//! As shipped, its CwBvh loses every hit of a ray with a -0.0 direction component and every hit
//! nearer than t = 1e-4; both of its BVHs cap 1/0 at 2^23, so that a ray parallel to a face
//! "leaves" small far boxes; a NaN box gives wrong results or a panic, and tens of thousands of
//! coincident centroids a quadratic build or a stack overflow. The robust adapter: adds +0.0 to
//! the direction, sets reciprocals itself, starts the box tests a little before the ray's
//! origin, pads boxes, refuses what is not finite, and groups primitives with the same centre.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::ray::Ray as ObvhsRay;

use super::BuildError;
use crate::bounds_rule::{BoundsOf, BoundsRule, PADDING_ULPS};
use crate::params::{ParamKind, ParamSpec, Params};
use crate::primitives::PrimSet;
use crate::ray::Ray;
use crate::scalar::{Scalar, Vector};

pub(super) const PRESETS: &[&str] =
    &["fastest", "very-fast", "fast", "medium", "slow", "very-slow"];

pub(super) const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "preset",
        summary: "obvhs's build preset",
        default: "medium",
        kind: ParamKind::Choice(PRESETS),
    },
    ParamSpec {
        name: "adapter",
        summary: "robust gives right answers; as-shipped passes rays and boxes unchanged",
        default: "robust",
        kind: ParamKind::Choice(&["robust", "as-shipped"]),
    },
];

pub(super) const VARIANTS: &[&str] = &["", "preset=fastest", "adapter=as-shipped"];

/// Settings that only the tests go through.
pub(super) const ALSO_TESTED: &[&str] =
    &["preset=very-fast", "preset=fast", "preset=slow", "preset=very-slow"];

pub(super) fn known_defect(params: &Params) -> Option<&'static str> {
    (params.text("adapter") == "as-shipped").then_some(
        "obvhs as shipped loses hits of rays with -0.0 components, near hits and far small boxes",
    )
}

pub(super) fn build_params(params: &Params) -> obvhs::BvhBuildParams {
    use obvhs::BvhBuildParams as B;
    match params.text("preset") {
        "fastest" => B::fastest_build(),
        "very-fast" => B::very_fast_build(),
        "fast" => B::fast_build(),
        "slow" => B::slow_build(),
        "very-slow" => B::very_slow_build(),
        _ => B::medium_build(),
    }
}

/// The boxes a BVH is built over, and which primitives each stands for.
pub(super) struct Items {
    pub(super) boxes: Vec<ObvhsAabb>,
    pub(super) groups: Groups,
}

/// Primitives of a box: one each, unless many boxes share a centre.
pub(super) enum Groups {
    Single,
    /// `ids[starts[i]..starts[i + 1]]` belong to box `i`.
    Many {
        starts: Vec<u32>,
        ids: Vec<u32>,
    },
}

impl Groups {
    /// The primitives of the box whose number stands in `item`.
    #[inline(always)]
    pub(super) fn ids<'a>(&'a self, item: &'a u32) -> &'a [u32] {
        match self {
            Self::Single => std::slice::from_ref(item),
            Self::Many { starts, ids } => {
                let i = *item as usize;
                &ids[starts[i] as usize..starts[i + 1] as usize]
            }
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Single => 0,
            Self::Many { starts, ids } => (starts.len() + ids.len()) as u64 * 4,
        }
    }
}

/// More primitives with the same centre than this, in a sample, and they are grouped.
const TOLERATED_COINCIDENT: usize = 3;
const CENTRE_SAMPLE: usize = 4096;

/// The boxes of all primitives, checked, padded and grouped as the adapter setting says.
pub(super) fn items<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    params: &Params,
) -> Result<Items, BuildError> {
    let structure = params.structure();
    let robust = is_robust(params);
    let boxes = BoundsOf::new(prims, BoundsRule::Padded)
        .map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
    // obvhs tests boxes in f32 whatever the scalar is, so f64 boxes need the padding of f32
    let f32_padding = f64::from(f32::EPSILON) * PADDING_ULPS * boxes.scene().magnitude().to_f64();
    let margin = S::from_f64(f32_padding);
    let single: Vec<ObvhsAabb> = (0..prims.len() as u32)
        .map(|id| prims.bounds(id))
        .map(|tight| outward(&if robust { tight.expanded(margin) } else { tight }))
        .collect();
    if !robust || !centres_coincide(&single) {
        return Ok(Items { boxes: single, groups: Groups::Single });
    }
    Ok(grouped(&single))
}

pub(super) fn is_robust(params: &Params) -> bool {
    params.text("adapter") == "robust"
}

/// In f32, rounded outwards when the scalar is wider.
#[inline(always)]
fn outward<S: Scalar>(b: &crate::aabb::Aabb<S>) -> ObvhsAabb {
    let lo = b.min.to_array().map(|x| {
        let y = x.to_f64() as f32;
        if f64::from(y) > x.to_f64() { y.next_down() } else { y }
    });
    let hi = b.max.to_array().map(|x| {
        let y = x.to_f64() as f32;
        if f64::from(y) < x.to_f64() { y.next_up() } else { y }
    });
    ObvhsAabb::new(Vec3A::from_array(lo), Vec3A::from_array(hi))
}

fn centre_key(b: &ObvhsAabb) -> [u32; 3] {
    // + 0.0 makes -0.0 and 0.0 the same key
    (b.center() + Vec3A::ZERO).to_array().map(f32::to_bits)
}

/// Looks at a regular sample: a cluster large enough to make the build quadratic shows in it.
fn centres_coincide(boxes: &[ObvhsAabb]) -> bool {
    let stride = boxes.len().div_ceil(CENTRE_SAMPLE).max(1);
    let mut keys: Vec<_> = boxes.iter().step_by(stride).map(centre_key).collect();
    keys.sort_unstable();
    keys.chunk_by(|a, b| a == b).any(|run| run.len() > TOLERATED_COINCIDENT)
}

fn grouped(single: &[ObvhsAabb]) -> Items {
    let mut order: Vec<u32> = (0..single.len() as u32).collect();
    order.sort_by_key(|&i| (centre_key(&single[i as usize]), i));
    let mut boxes = Vec::new();
    let mut starts = vec![0];
    for run in
        order.chunk_by(|&a, &b| centre_key(&single[a as usize]) == centre_key(&single[b as usize]))
    {
        let mut all = single[run[0] as usize];
        for &i in &run[1..] {
            all = all.union(&single[i as usize]);
        }
        boxes.push(all);
        starts.push(starts[starts.len() - 1] + run.len() as u32);
    }
    Items { boxes, groups: Groups::Many { starts, ids: order } }
}

/// A ray for obvhs's box tests, and how far before the true origin it starts.
pub(super) struct BoxRay {
    pub(super) ray: ObvhsRay,
    /// Parameter offset: a hit at `t` lies at `t + lead` on `ray`.
    pub(super) lead: f32,
}

/// CwBvh ignores boxes that end before t = 1e-4; twice that is a safe start.
const LEAD: f32 = 2e-4;

impl BoxRay {
    #[inline(always)]
    pub(super) fn robust<S: Scalar>(ray: &Ray<S>, lead: bool) -> Self {
        let direction = to_f32::<S>(ray.direction) + Vec3::ZERO;
        let lead = if lead { LEAD } else { 0.0 };
        let origin = to_f32::<S>(ray.origin) - direction * lead;
        let reciprocal = |d: f32| {
            if d.abs() < 1e-30 { f32::from_bits(0x7180_0000).copysign(d) } else { 1.0 / d }
        };
        let inv =
            Vec3A::new(reciprocal(direction.x), reciprocal(direction.y), reciprocal(direction.z));
        let ray = ObvhsRay {
            origin: origin.into(),
            direction: direction.into(),
            inv_direction: inv,
            tmin: 0.0,
            tmax: f32::INFINITY,
        };
        Self { ray, lead }
    }

    #[inline(always)]
    pub(super) fn as_shipped<S: Scalar>(ray: &Ray<S>) -> Self {
        let (t_min, t_max) = (ray.t_min.to_f64() as f32, ray.t_max.to_f64() as f32);
        let (o, d) = (to_f32::<S>(ray.origin), to_f32::<S>(ray.direction));
        Self { ray: ObvhsRay::new(o.into(), d.into(), t_min, t_max), lead: 0.0 }
    }

    /// A bound for obvhs's box tests that no rounding makes too small.
    #[inline(always)]
    pub(super) fn bound<S: Scalar>(&self, t_max: S) -> f32 {
        (t_max.to_f64() as f32 + self.lead) * (1.0 + 4.0 * f32::EPSILON)
    }
}

#[inline(always)]
fn to_f32<S: Scalar>(v: crate::Vec3<S>) -> Vec3 {
    let [x, y, z] = v.to_array();
    Vec3::new(x.to_f64() as f32, y.to_f64() as f32, z.to_f64() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{MixedSetBuilder, PrimitiveError, TriangleSet, Watertight};

    #[test]
    fn coincident_centres_are_grouped_and_nothing_is_lost() {
        let mut builder = MixedSetBuilder::<f32>::default();
        for i in 0..1000u32 {
            let centre = if i % 2 == 0 { glam::DVec3::ZERO } else { glam::DVec3::X * f64::from(i) };
            builder.sphere(centre, 0.1 + f64::from(i) * 1e-4).unwrap();
        }
        let set = builder.finish();
        let entry = crate::structures::find("obvhs-bvh2").unwrap();
        let items = items(&set, &entry.params([]).unwrap()).unwrap();
        let Groups::Many { ids, .. } = &items.groups else { panic!("not grouped") };
        assert_eq!(items.boxes.len(), 501);
        let mut sorted = ids.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_not_finite_never_reaches_a_structure() {
        let good = [[0.0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut triangles = vec![good; 4];
            triangles[2][1][0] = bad;
            let set = TriangleSet::<f32, Watertight>::new(triangles, |_| false);
            assert_eq!(set.unwrap_err(), PrimitiveError::NotFinite { id: 2 });
        }
        // finite, but the scene's size is not
        let far = |x: f32| [[x; 3], [x * 0.9, x, x], [x, x * 0.9, x]];
        let set = vec![good, far(3e38), far(-3e38)];
        let set = TriangleSet::<f32, Watertight>::new(set, |_| false).unwrap();
        for entry in crate::structures::REGISTRY.iter().filter(|e| e.info.name != "brute-force") {
            let params = entry.params([]).unwrap();
            let result = entry.build(crate::structures::PrimsRef::Watertight(&set), &params);
            assert!(
                matches!(result, Err(BuildError::NonFiniteBounds { id: 1, .. })),
                "{} accepts it",
                entry.info.name
            );
        }
    }
}
