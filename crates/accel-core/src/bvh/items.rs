//! Input of the builders of BVHs: boxes in f32, checked, padded and grouped.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb as ObvhsAabb;
use wide::{f32x4, f64x4, i32x4};

use crate::bvh::node::RaySetup;
use crate::geometry::aabb::Aabb;
use crate::geometry::lanes::Four;
use crate::geometry::scalar::{Scalar, Vector};
use crate::historical::bounds_rule::{BoundsOf, BoundsRule, PADDING_ULPS};
use crate::memory::Limits;
use crate::parallel;
use crate::primitives::Primitives;
use crate::structure::BuildError;

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

/// By how much the box of a primitive grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Padding {
    /// By no more than the rounding of coordinates to f32, in units of the scene's size.
    Rounding,
    /// By [`PADDING_ULPS`] ulps of the scene's largest coordinate.
    OfScene,
    /// On each axis by so many epsilons of its own extent along that, and so many of its largest
    /// one.
    OfExtent { along: f64, largest: f64 },
}

impl Padding {
    /// By how far the point in which the watertight test hits a triangle in f32 lies outside of its
    /// box, beyond what grows with the distance of the hit: half an epsilon of both extents, and a
    /// little more (`bvh/node.rs`, `proofs/corner_boxes.gappa`).
    pub(crate) const OF_CORNERS: Self =
        Self::OfExtent { along: 0.5 + 1.0 / 32.0, largest: 0.5 + 1.0 / 32.0 };
}

/// The boxes of all primitives, checked, padded and grouped.
///
/// # Errors
/// [`BuildError`] for boxes that are not finite or do not fit in memory.
pub(crate) fn items_of<S: Scalar>(
    prims: &dyn Primitives<S>,
    limits: Limits,
    padding: Padding,
) -> Result<Items<S>, BuildError> {
    // a box and an id of each primitive, twice as many nodes
    limits.fits(96 * prims.len() as u128)?;
    let (single, setup) = boxes(prims, limits.structure, padding)?;
    let (boxes, groups) =
        if centres_coincide(&single) { grouped(&single) } else { (single, Groups::Single) };
    Ok(Items { boxes, groups, setup })
}

/// The boxes of all primitives in f32, by id, checked, in units of the scene's size.
pub(crate) fn boxes<S: Scalar>(
    prims: &dyn Primitives<S>,
    structure: &'static str,
    padding: Padding,
) -> Result<(Vec<ObvhsAabb>, RaySetup<S>), BuildError> {
    let boxes = BoundsOf::new(prims, BoundsRule::Padded)
        .map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
    let scale = BoxScale::new(boxes.scene().magnitude(), padding);
    let single = parallel::collect(prims.len(), |id| scale.padded(boxes.tight(id as u32)));
    Ok((single, scale.setup))
}

/// How boxes are padded, and in which unit they are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoxScale<S: Scalar> {
    padding: Padding,
    /// The scene's largest coordinate.
    magnitude: f64,
    pub(crate) setup: RaySetup<S>,
}

impl<S: Scalar> BoxScale<S> {
    fn new(magnitude: S, padding: Padding) -> Self {
        Self { padding, magnitude: magnitude.to_f64(), setup: RaySetup::new(magnitude) }
    }

    /// That of [`boxes`], without a look at all primitives.
    pub(super) fn of_set(prims: &dyn Primitives<S>, padding: Padding) -> Self {
        // the scene's box is padded twice
        let padded = S::ONE + S::EPSILON * S::from_f64(2.0 * PADDING_ULPS + 1.0);
        Self::new((prims.magnitude() * padded).greater(S::from_f64(1e-30)), padding)
    }

    /// Returns whether the boxes of primitives that have not moved are large enough in this scale,
    /// too.
    pub(super) fn serves(&self, before: &RaySetup<S>) -> bool {
        self.setup.unit() == before.unit()
    }

    /// The box of a primitive with these bounds.
    #[inline(always)]
    fn padded(&self, tight: Aabb<S>) -> ObvhsAabb {
        self.padded_part(tight.size().to_dvec3(), &tight)
    }

    /// The box of a part with these bounds of a primitive that has these extents.
    #[inline(always)]
    pub(super) fn padded_part<T: Scalar>(&self, extents: DVec3, part: &Aabb<T>) -> ObvhsAabb {
        // obvhs tests boxes in f32 whatever the scalar is, so f64 boxes need the padding of f32
        let epsilon = f64::from(f32::EPSILON);
        let margins = match self.padding {
            Padding::Rounding => f64x4::splat(0.0),
            Padding::OfScene => f64x4::splat(epsilon * PADDING_ULPS * self.magnitude),
            Padding::OfExtent { along, largest } => {
                (f64x4::of_axes(extents.to_array()) * along + extents.max_element() * largest)
                    * epsilon
            }
        };
        outward(part, margins, self.setup.unit())
    }

    /// The box around some primitives.
    #[inline(always)]
    pub(crate) fn around(&self, prims: &dyn Primitives<S>, ids: &[u32]) -> ObvhsAabb {
        let of = |id: &u32| self.padded(prims.bounds(*id));
        ids.iter().fold(ObvhsAabb::empty(), |all, id| all.union(&of(id)))
    }
}

/// Grown by a margin on each axis, in f32 and in the unit given (its reciprocal in world units),
/// rounded outwards.
#[inline(always)]
pub(crate) fn outward<S: Scalar>(b: &Aabb<S>, margins: f64x4, unit: f64) -> ObvhsAabb {
    let [min, max] = [b.min, b.max].map(|corner| f64x4::of_axes(corner.to_array().map(S::to_f64)));
    let low = rounded_down((min - margins) * unit);
    let negated_high = rounded_down(-(max + margins) * unit);
    let corner = |lanes: f32x4| {
        let [x, y, z, _] = lanes.to_array();
        Vec3A::new(x, y, z)
    };
    ObvhsAabb::new(corner(low), -corner(negated_high))
}

/// The largest numbers that are no larger; -0 is before 0. Without branches, as nobody can guess which
/// way a number was rounded.
#[inline(always)]
fn rounded_down(exact: f64x4) -> f32x4 {
    let nearest = f32x4::new(exact.to_array().map(|x| x as f32));
    // -1 where the next lower one is wanted
    let places = !f64x4::new(nearest.to_array().map(f64::from)).at_most(exact);
    // of negative numbers the larger ones have the smaller bits
    let in_order = |bits: i32x4| bits ^ ((bits >> 31) & i32x4::splat(i32::MAX));
    bytemuck::cast(in_order(in_order(bytemuck::cast(nearest)) + places))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::node::{BoxRay, Length, Node, NodeRay, WIDTH};
    use crate::bvh::parts::Splitting;
    use crate::geometry::ray::Ray;
    use crate::params::config::Settings;
    use crate::primitives::{MixedSetBuilder, PrimSet, TriangleSet, Watertight};
    use crate::structures::test_scenes::Random;

    #[test]
    fn numbers_are_rounded_outwards() {
        let around = |exact: f64| {
            let point = Aabb { min: DVec3::splat(exact), max: DVec3::splat(exact) };
            outward::<f64>(&point, f64x4::splat(0.0), 1.0)
        };
        for x in [0.0, 1e-45, 1e-40, 1.0, 1.5, 3e7, 1e30, 1.0 - f32::EPSILON / 2.0] {
            for x in [x, -x] {
                let next = x.next_up();
                for part in [0.0, 0.25, 0.5, 0.75] {
                    let exact = f64::from(x) + part * (f64::from(next) - f64::from(x));
                    let high = if part == 0.0 { x } else { next };
                    let around = around(exact);
                    assert_eq!([around.min, around.max], [x, high].map(Vec3A::splat), "{exact}");
                }
            }
        }
        // what is rounded to a zero has its sign
        for exact in [1e-60, 0.1, 16_777_217.0, 1e-46, 123.456] {
            for exact in [exact, -exact] {
                let around = around(exact);
                let [low, high] = [around.min, around.max].map(|p| f64::from(p.x));
                assert!(low <= exact && exact <= high, "{exact} {low} {high}");
                assert!(around.min.x.next_up() >= around.max.x, "{exact}");
            }
        }
    }

    #[test]
    fn coincident_centres_are_grouped_and_nothing_is_lost() {
        let mut builder = MixedSetBuilder::<f32>::default();
        for i in 0..1000u32 {
            let centre = if i % 2 == 0 { glam::DVec3::ZERO } else { glam::DVec3::X * f64::from(i) };
            builder.sphere(centre, 0.1 + f64::from(i) * 1e-4).unwrap();
        }
        let set = builder.finish();
        let limits = Settings::<()>::of(&crate::bvh::INFO.defaults()).limits();
        let items = items_of(&set, limits, Padding::OfScene).unwrap();
        let Groups::Many { ids, .. } = &items.groups else { panic!("not grouped") };
        assert_eq!(items.boxes.len(), 501);
        let mut sorted = ids.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..1000).collect::<Vec<_>>());
    }

    /// One of these powers of ten, evenly by logarithm.
    fn power(random: &mut Random, low: f64, high: f64) -> f64 {
        10f64.powf(low + (high - low) * random.unit())
    }

    fn signed(random: &mut Random) -> DVec3 {
        random.point([2.0; 3]) - 1.0
    }

    /// Half of them flat on an axis, a third narrow; far from the origin of coordinates, or around
    /// it.
    fn triangle(random: &mut Random) -> [DVec3; 3] {
        let (size, at) = (power(random, -5.0, 0.0), signed(random) * power(random, -6.0, 0.0));
        let narrow = if random.unit() < 0.3 { power(random, -5.0, 0.0) } else { 1.0 };
        let mut edges = [signed(random) * size, signed(random) * (size * narrow)];
        let axis = (random.unit() * 6.0) as usize;
        if axis < 3 {
            edges.iter_mut().for_each(|e| e[axis] = 0.0);
        }
        let [a, b] = edges;
        [at - (a + b) / 3.0, at + a, at + b].map(|p| p.clamp(DVec3::splat(-1.0), DVec3::ONE))
    }

    /// At a point of a triangle, often on its outline, from however near.
    fn ray(random: &mut Random, [a, b, c]: [DVec3; 3]) -> Ray<f32> {
        let [u, v] = [0; 2].map(|_| if random.unit() < 0.3 { 0.0 } else { random.unit() });
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let point = a + (b - a) * u + (c - a) * v;
        let mut d = signed(random);
        if random.unit() < 0.5 {
            let part = power(random, -4.0, 0.0);
            d[(random.unit() * 3.0) as usize] *= part;
        }
        let t = match (random.unit() * 3.0) as u32 {
            0 => 0.0,
            1 => power(random, -8.0, -5.0) * (random.unit() - 0.2),
            _ => power(random, -5.0, 0.5),
        };
        let mut o = (point - d * t).as_vec3();
        for k in 0..3 {
            for _ in 0..(random.unit() * 5.0) as u32 {
                o[k] = if random.unit() < 0.5 { o[k].next_up() } else { o[k].next_down() };
            }
        }
        Ray::new(o, d.as_vec3())
    }

    /// By ray: whether the triangle is hit, and whether a box of it is met.
    fn hits_and_boxes(rounds: u32, splitting: Splitting, padding: Padding) -> Vec<[bool; 2]> {
        let mut random = Random(71);
        let mut all = Vec::new();
        for _ in 0..rounds {
            let triangles: [_; WIDTH] =
                std::array::from_fn(|_| triangle(&mut random).map(|p| p.as_vec3()));
            let corners = triangles.map(|t| t.map(|p| p.to_array())).to_vec();
            let set = TriangleSet::<f32, Watertight>::new(corners, |_| false).unwrap();
            let limits = Settings::<()>::of(&crate::bvh::INFO.defaults()).limits();
            let (boxes, setup) = boxes(&set, "", padding).unwrap();
            let items = Items { boxes, groups: Groups::Single, setup };
            let Items { boxes, groups, setup } =
                splitting.cut(&set, items, padding, limits).unwrap();
            let owners: Vec<usize> =
                (0..boxes.len() as u32).map(|i| groups.ids(&i)[0] as usize).collect();
            let nodes = boxes.chunks(WIDTH).map(|boxes| {
                let mut node = Node::empty();
                for (child, b) in boxes.iter().enumerate() {
                    node.set_box(child, b.min.to_array(), b.max.to_array());
                }
                node
            });
            let nodes: Vec<Node> = nodes.collect();
            for number in 0..WIDTH * 8 {
                let id = number % WIDTH;
                let ray = ray(&mut random, triangles[id].map(|p| p.as_dvec3()));
                if ray.direction.abs().max_element() < 1e-3 {
                    continue;
                }
                let hit = set.intersect(id as u32, &ray, &set.setup(&ray), f32::INFINITY);
                let BoxRay { origin, direction, parameters } = setup.ray(&ray, Length::Own);
                let of_nodes = NodeRay::of(origin, direction, true);
                let end = parameters.bound(hit.unwrap_or(f32::INFINITY));
                let is_met = nodes.iter().zip(owners.chunks(WIDTH)).any(|(node, owners)| {
                    let met = of_nodes.test(node, end).0;
                    (0..).zip(owners).any(|(child, owner)| *owner == id && met >> child & 1 == 1)
                });
                all.push([hit.is_some(), is_met]);
            }
        }
        all
    }

    #[test]
    fn a_triangle_that_is_hit_has_a_box_that_is_met() {
        for (splitting, rounds) in [(Splitting::Never, 40_000), (Splitting::Always, 8000)] {
            let all = hits_and_boxes(rounds, splitting, Padding::OF_CORNERS);
            let count = |wanted: [bool; 2]| all.iter().filter(|found| **found == wanted).count();
            assert_eq!(count([true, false]), 0, "{splitting:?}");
            let counts = [count([true, true]), count([false, false])].map(|n| n as u32);
            assert!(
                counts[0] > 25 * rounds && 4 * counts[1] > 5 * rounds,
                "{splitting:?} {counts:?}"
            );
            // planted fault: boxes that are not padded
            let unpadded = hits_and_boxes(2000, splitting, Padding::Rounding);
            assert!(unpadded.contains(&[true, false]), "{splitting:?}");
        }
    }
}
