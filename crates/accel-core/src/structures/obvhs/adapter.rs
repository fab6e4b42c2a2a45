//! What it takes to get right answers from `obvhs` 0.4, and the boxes it is given.
//!
//! As shipped, its CwBvh loses every hit of a ray with a -0.0 direction component and every hit
//! nearer than t = 1e-4; both of its BVHs cap 1/0 at 2^23, so that a ray parallel to a face
//! "leaves" small far boxes; neither knows of hits at negative t; a NaN box gives wrong results
//! or a panic, and tens of thousands of
//! coincident centroids a quadratic build or a stack overflow. Its lengths are absolute: long
//! directions and large scenes overflow, short ones drown in its epsilons. The robust adapter:
//! tells it everything in units of the scene's size (powers of two, so that nothing is rounded),
//! adds +0.0 to the direction, sets reciprocals itself, starts the box tests a little before the
//! ray's origin, or where an interval begins that begins before it, pads boxes, refuses what is
//! not finite, and groups primitives with the same centre.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::ray::Ray as ObvhsRay;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::historical::bounds_rule::{BoundsOf, BoundsRule, PADDING_ULPS};
use crate::params::{ParamKind, ParamSpec, Params};
use crate::primitives::PrimSet;
use crate::structure::{BuildError, refuse_out_of_scale};

pub(crate) const PRESETS: &[&str] =
    &["fastest", "very-fast", "fast", "medium", "slow", "very-slow"];

/// The preset, for the parameter list of whatever is built by obvhs.
pub(crate) const PRESET: ParamSpec = ParamSpec {
    name: "preset",
    summary: "obvhs's build preset",
    default: "medium",
    kind: ParamKind::Choice(PRESETS),
};

pub(crate) const PARAMS: &[ParamSpec] = &[
    PRESET,
    ParamSpec {
        name: "adapter",
        summary: "robust gives right answers; direct is obvhs as its authors use it: its triangles, \
                  its test, its traversal (f32, triangles alone); as-shipped has our primitive tests \
                  in its traversal, rays and boxes unchanged",
        default: "robust",
        kind: ParamKind::Choice(&["robust", "direct", "as-shipped"]),
    },
    ParamSpec {
        name: "kernel",
        summary: "of adapter=robust, over triangles: block: those of a leaf (Bvh2) or of a node's \
                  leaves (CwBvh) in blocks of eight, tested at once, the faster in every scene \
                  measured; scalar: one by one, through their ids",
        default: "block",
        kind: ParamKind::Choice(&["scalar", "block"]),
    },
    #[cfg(feature = "compiled-tests")]
    PADDING,
];

/// What boxes and rays are padded by, for the price of it: with the feature `compiled-tests` alone.
#[cfg(feature = "compiled-tests")]
pub(crate) const PADDING: ParamSpec = ParamSpec {
    name: "padding",
    summary: "for comparison: none leaves out what keeps rounding from losing boxes that hold hits",
    default: "default",
    kind: ParamKind::Choice(&["default", "none"]),
};

/// Whether padding is left out.
pub(crate) fn is_unpadded(params: &Params) -> bool {
    params.get("padding") == Some("none")
}

/// What is wrong then.
pub(crate) const UNPADDED: &str = "boxes are not padded: hits at their faces are lost to rounding";

pub(crate) const VARIANTS: &[&str] = &["adapter=direct", "", "preset=fastest adapter=direct"];

/// What both rows do differently.
pub(crate) const DEVIATIONS: &str = "library code; our primitive tests, our robust ray setup; \
                                     nested boxes and too deep subtrees are halved at medians";

/// Settings that only the tests go through.
pub(crate) const ALSO_TESTED: &[&str] = &[
    "kernel=scalar",
    "preset=fastest",
    "preset=fastest kernel=scalar",
    "preset=very-fast",
    "preset=fast",
    "preset=slow",
    "preset=very-slow",
    "preset=very-slow adapter=direct",
    "adapter=as-shipped",
];

pub(crate) fn known_defect(params: &Params) -> Option<&'static str> {
    match params.text("adapter") {
        "robust" => is_unpadded(params).then_some(UNPADDED),
        "direct" => Some(
            "obvhs as its authors use it loses hits at edges of triangles, of rays with -0.0 \
             components, near hits, hits at negative t and far small boxes; of equal hits it takes \
             any",
        ),
        _ => Some(
            "obvhs as shipped loses hits of rays with -0.0 components, near hits, hits at negative t \
             and far small boxes",
        ),
    }
}

pub(crate) fn build_params(params: &Params) -> obvhs::BvhBuildParams {
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
pub(crate) struct Items<S: Scalar> {
    pub(crate) boxes: Vec<ObvhsAabb>,
    pub(crate) groups: Groups,
    pub(crate) setup: RaySetup<S>,
}

/// Primitives of a box: one each, unless many boxes share a centre.
pub(crate) enum Groups {
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
    pub(crate) fn ids<'a>(&'a self, item: &'a u32) -> &'a [u32] {
        match self {
            Self::Single => std::slice::from_ref(item),
            Self::Many { starts, ids } => {
                let i = *item as usize;
                &ids[starts[i] as usize..starts[i + 1] as usize]
            }
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
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
pub(crate) fn items<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    params: &Params,
) -> Result<Items<S>, BuildError> {
    let padding = match (is_robust(params), is_unpadded(params)) {
        (false, _) => Padding::None,
        (true, false) => Padding::OfScene,
        (true, true) => Padding::Rounding,
    };
    items_of(prims, params, padding)
}

/// By how much the box of a primitive grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Padding {
    /// Not at all, and coordinates are kept as they are: boxes for obvhs as shipped.
    None,
    /// By no more than the rounding of coordinates to f32, in units of the scene's size.
    Rounding,
    /// By [`PADDING_ULPS`] ulps of the scene's largest coordinate.
    OfScene,
    /// By [`CORNER_EPSILONS`] of its own extent.
    OfExtent,
}

/// A ray hits a triangle of which no corner is off by more than 4 epsilons of its distance on any axis
/// from the ray's origin (7 half epsilons in the sheared space, `primitives/shear.rs`, and a half in
/// depth); that is at most its extent and the hit's distance.
pub(crate) const CORNER_EPSILONS: f64 = 5.0;

/// [`items`], the padding given.
pub(crate) fn items_of<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    params: &Params,
    padding: Padding,
) -> Result<Items<S>, BuildError> {
    // a box and an id of each primitive, twice as many nodes
    params.fits(96 * prims.len() as u128)?;
    let (single, setup) = boxes(prims, params.structure(), padding)?;
    let (boxes, groups) = if padding != Padding::None && centres_coincide(&single) {
        grouped(&single)
    } else {
        (single, Groups::Single)
    };
    Ok(Items { boxes, groups, setup })
}

/// The boxes of all primitives in f32, by id, checked; if padded, in units of the scene's size.
pub(crate) fn boxes<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    structure: &'static str,
    padding: Padding,
) -> Result<(Vec<ObvhsAabb>, RaySetup<S>), BuildError> {
    if padding == Padding::None {
        // obvhs knows f32 alone
        refuse_out_of_scale::<S, f32>(prims.magnitude(), structure)?;
    }
    let boxes = BoundsOf::new(prims, BoundsRule::Padded)
        .map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
    // obvhs tests boxes in f32 whatever the scalar is, so f64 boxes need the padding of f32
    let magnitude = boxes.scene().magnitude();
    let setup = match padding {
        Padding::None => RaySetup::AsShipped,
        Padding::Rounding | Padding::OfScene | Padding::OfExtent => RaySetup::robust(magnitude),
    };
    let epsilon = f64::from(f32::EPSILON);
    let margin = |tight: &Aabb<S>| match padding {
        Padding::None | Padding::Rounding => 0.0,
        Padding::OfScene => epsilon * PADDING_ULPS * magnitude.to_f64(),
        Padding::OfExtent => epsilon * CORNER_EPSILONS * tight.size().to_dvec3().max_element(),
    };
    let padded = |tight: Aabb<S>| outward(&tight, margin(&tight), setup.unit());
    let single = (0..prims.len() as u32).map(|id| padded(prims.bounds(id))).collect();
    Ok((single, setup))
}

pub(crate) fn is_robust(params: &Params) -> bool {
    params.text("adapter") == "robust"
}

/// Grown by a margin, in f32 and in the unit given (its reciprocal in world units), rounded outwards.
#[inline(always)]
fn outward<S: Scalar>(b: &Aabb<S>, margin: f64, unit: f64) -> ObvhsAabb {
    let lo = b.min.to_array().map(|x| {
        let exact = (x.to_f64() - margin) * unit;
        let y = exact as f32;
        if f64::from(y) > exact { y.next_down() } else { y }
    });
    let hi = b.max.to_array().map(|x| {
        let exact = (x.to_f64() + margin) * unit;
        let y = exact as f32;
        if f64::from(y) < exact { y.next_up() } else { y }
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

fn grouped(single: &[ObvhsAabb]) -> (Vec<ObvhsAabb>, Groups) {
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
    (boxes, Groups::Many { starts, ids: order })
}

/// How rays are told to obvhs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum RaySetup<S: Scalar> {
    /// Unchanged.
    AsShipped,
    /// Origins times `unit`, so that the scene's largest coordinate lies in [1, 2).
    Robust {
        /// A power of two.
        unit: S,
    },
}

impl<S: Scalar> RaySetup<S> {
    /// For a scene whose largest coordinate is `magnitude`.
    fn robust(magnitude: S) -> Self {
        Self::Robust { unit: magnitude.to_unit_size() }
    }

    /// What coordinates are multiplied by.
    pub(crate) fn unit(&self) -> f64 {
        match self {
            Self::AsShipped => 1.0,
            Self::Robust { unit } => unit.to_f64(),
        }
    }

    /// A box as the tree has it, in world units.
    pub(crate) fn world(&self, [low, high]: [[f32; 3]; 2]) -> Aabb<f64> {
        let [min, max] = [low, high].map(|p| Vec3::from_array(p).as_dvec3() / self.unit());
        Aabb { min, max }
    }

    /// The ray for obvhs.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &Ray<S>, length: Length) -> BoxRay<S> {
        match *self {
            Self::AsShipped => BoxRay::as_shipped(ray),
            Self::Robust { unit } => BoxRay::robust(ray, unit, length),
        }
    }

    /// Whether obvhs is to get bounds that rounding cannot make too small.
    #[inline(always)]
    pub(crate) fn is_robust(&self) -> bool {
        matches!(self, Self::Robust { .. })
    }
}

/// What the direction of a ray for boxes is as long as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Length {
    /// The ray's own in f32, its largest component in [1, 2) in f64 or where it starts earlier.
    Own,
    /// Its largest component lies in [1, 2).
    Unit,
    /// [`BRIEF`] times that.
    Brief,
}

/// A ray for box tests.
pub(crate) struct BoxRay<S: Scalar> {
    pub(crate) ray: ObvhsRay,
    pub(crate) parameters: BoxParameters<S>,
}

/// What our parameters are on a [`BoxRay`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoxParameters<S> {
    /// So many times ours.
    scale: S,
    /// Our `t` is at most `t * scale + lead`: how far the ray starts before the true origin, or a little
    /// more.
    lead: f32,
}

/// CwBvh ignores boxes that begin or end before t = 1e-4. A ray that starts this much before its origin
/// finds them, in units of the scene's size if the largest component of its direction is in [1, 2).
const LEAD: f32 = 1.0625e-4;
/// Of a direction this much shorter, 1e-4 is a tenth of an ulp: no padded box ends before it.
const BRIEF: f32 = f32::from_bits((127 - 14) << 23);

/// Half the side of a cube around the origin that holds the scene, in units of its size.
const CUBE: f64 = 3.0;

/// More than the rounding of both terms where a negative parameter and a lead are added: origins
/// lie within 16 of the cube's centre, and so leads are below 20.
const LEAD_SLACK: f32 = 32.0 * f32::EPSILON;

impl<S: Scalar> BoxRay<S> {
    #[inline(always)]
    fn robust(ray: &Ray<S>, unit: S, length: Length) -> Self {
        let is_own = length == Length::Own && size_of::<S>() == size_of::<f32>();
        if ray.t_min < S::ZERO {
            return Self::starting_earlier(ray, unit);
        }
        let mut shorter = if is_own { S::ONE } else { to_unit_length(ray) };
        let mut lead = 0.0;
        if length == Length::Brief {
            shorter = shorter * S::from_f64(f64::from(BRIEF));
            lead = LEAD;
        }
        let origin = to_f32::<S>(ray.origin * unit);
        Self::scaled(ray, origin, unit, shorter, lead)
    }

    /// Of a ray whose interval begins before its origin.
    #[cold]
    #[inline(never)]
    fn starting_earlier(ray: &Ray<S>, unit: S) -> Self {
        let shorter = to_unit_length(ray);
        let (start, lead) = earlier_start(ray, unit, shorter);
        Self::scaled(ray, start, unit, shorter, lead)
    }

    #[inline(always)]
    fn scaled(ray: &Ray<S>, origin: Vec3, unit: S, shorter: S, lead: f32) -> Self {
        let origin = Vec3A::from(origin);
        let direction = Vec3A::from(to_f32::<S>(ray.direction * shorter)) + Vec3A::ZERO;
        let scale = unit / shorter;
        // all axes at once
        let is_small = direction.abs().cmplt(Vec3A::splat(1e-30));
        let large = Vec3A::splat(f32::from_bits(0x7180_0000)).copysign(direction);
        let ray = ObvhsRay {
            origin,
            direction,
            inv_direction: Vec3A::select(is_small, large, direction.recip()),
            tmin: 0.0,
            tmax: f32::INFINITY,
        };
        Self { ray, parameters: BoxParameters { scale, lead } }
    }

    #[inline(always)]
    fn as_shipped(ray: &Ray<S>) -> Self {
        let (t_min, t_max) = (ray.t_min.to_f64() as f32, ray.t_max.to_f64() as f32);
        let (o, d) = (to_f32::<S>(ray.origin), to_f32::<S>(ray.direction));
        Self {
            ray: ObvhsRay::new(o.into(), d.into(), t_min, t_max),
            parameters: BoxParameters::SAME,
        }
    }
}

impl<S: Scalar> BoxParameters<S> {
    /// Ours.
    const SAME: Self = Self { scale: S::ONE, lead: 0.0 };

    /// Whether its origin is not the true one.
    #[inline(always)]
    pub(crate) fn starts_earlier(&self) -> bool {
        self.lead > 0.0
    }

    /// Where hits from `t_min` on may begin; no rounding makes it too large. A ray whose interval
    /// begins before its origin starts there, at 0.
    #[cfg(feature = "embree")]
    #[inline(always)]
    pub(crate) fn start(&self, t_min: S) -> f32 {
        ((t_min * self.scale).to_f64() as f32).max(0.0) * (1.0 - 4.0 * f32::EPSILON)
    }

    /// A bound for obvhs's box tests that no rounding makes too small.
    #[inline(always)]
    pub(crate) fn bound(&self, t_max: S) -> f32 {
        let t = (t_max * self.scale).to_f64() as f32;
        // 0 * infinity: `max` gives 0 for NaN
        (t + self.lead).max(0.0) * (1.0 + 4.0 * f32::EPSILON)
    }
}

/// What brings the largest component of a direction into [1, 2).
#[inline(always)]
fn to_unit_length<S: Scalar>(ray: &Ray<S>) -> S {
    let [x, y, z] = ray.direction.to_array();
    x.abs().greater(y.abs()).greater(z.abs()).to_unit_size()
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
        // finite, but no product of them is
        let far = |x: f32| [[x; 3], [x * 0.9, x, x], [x, x * 0.9, x]];
        let set = vec![good, far(3e38), far(-3e38)];
        let set = TriangleSet::<f32, Watertight>::new(set, |_| false).unwrap();
        for entry in crate::structures::REGISTRY.iter().filter(|e| e.info.name != "brute-force") {
            let params = entry.params([]).unwrap();
            let result = entry.build(crate::primitives::PrimsRef::Watertight(&set), &params);
            assert!(
                matches!(result, Err(BuildError::OutOfScale { exponent: 127, .. })),
                "{} accepts it",
                entry.info.name
            );
        }
    }
}
