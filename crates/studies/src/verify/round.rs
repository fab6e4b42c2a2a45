//! A round drawn by a case from a seed: a scene, rays, the expected answers, and metamorphic tests of
//! them: the scene scaled, mirrored or renumbered, which must not change the answers.

use accel_core::primitives::{MixedSetBuilder, PrimitiveError, TriangleSet};
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar, Vector};
use glam::DVec3;
use renderer::Geometry;

pub use exact_geometry::triangles::Corners;

/// Triangles with the watertight test; the coordinates are rounded to `S`.
pub fn model_of<S: Buildable>(corners: &[Corners]) -> Result<Geometry<S>, PrimitiveError> {
    let rounded = corners.iter().map(|t| t.map(|p| p.to_array().map(S::from_f64))).collect();
    Ok(Geometry::Triangles(TriangleSet::new(rounded, |_| false)?))
}

/// The primitives of any kind that `add` puts into a builder.
pub fn mixed_model<S: Buildable>(
    add: impl FnOnce(&mut MixedSetBuilder<S>) -> Result<(), PrimitiveError>,
) -> Result<Geometry<S>, PrimitiveError> {
    let mut builder = MixedSetBuilder::default();
    add(&mut builder)?;
    Ok(Geometry::Mixed(builder.finish()))
}

pub(super) fn magnitude<S: Buildable>(model: &Geometry<S>) -> f64 {
    model.prims().primitives().magnitude().to_f64()
}

/// The corners of its triangles, which f64 holds exactly; none where it has other primitives.
pub(super) fn corners_of<S: Buildable>(model: &Geometry<S>) -> Option<Vec<Corners>> {
    let Geometry::Triangles(set) = model else { return None };
    let exact = |point: &[S; 3]| DVec3::from_array(point.map(S::to_f64));
    Some(set.triangles().iter().map(|triangle| triangle.each_ref().map(exact)).collect())
}

/// A ray with the interval [0, infinity], rounded to `S`.
pub fn ray<S: Scalar>(origin: DVec3, direction: DVec3) -> Ray<S> {
    Ray::from_dvec3(origin, direction)
}

/// The fewest rays that a round is drawn with, when so many are asked for: few, so that there are
/// many scenes.
pub const FEWEST_RAYS: usize = 500;

/// The most: many, so that large runs do not spend their time on building.
pub const MOST_RAYS: usize = 20_000;

/// Answer of a case's oracle for the closest hit of a ray. Agreement with brute force is required
/// in any case.
#[derive(Debug, Clone, PartialEq)]
pub enum OracleAnswer {
    /// Nothing: agreement is the only oracle.
    Anything,
    Miss,
    /// The tests of primitives break a law of geometry here, said in words: no answer is right.
    Broken(String),
    Hit {
        /// Primitive that is hit; any if `None`.
        id: Option<u32>,
        /// At a parameter in this closed interval.
        t: [f64; 2],
    },
}

impl OracleAnswer {
    /// A hit of whichever primitive, at `t` but for `slack`.
    pub fn hit_at(t: f64, slack: f64) -> Self {
        Self::Hit { id: None, t: [t - slack, t + slack] }
    }

    pub fn admits<S: Scalar>(&self, hit: &Hit<S>) -> bool {
        match *self {
            Self::Anything => true,
            Self::Miss => !hit.is_hit(),
            Self::Broken(_) => false,
            Self::Hit { id, t: [low, high] } => {
                let t = hit.t.to_f64();
                hit.is_hit() && id.is_none_or(|id| id == hit.id) && low <= t && t <= high
            }
        }
    }
}

pub struct Round<S: Buildable> {
    pub model: Geometry<S>,
    pub rays: Vec<Ray<S>>,
    pub expected: Vec<OracleAnswer>,
    /// True if each is blocked, where that is known otherwise than by its closest hit; or empty.
    pub blocked: Vec<bool>,
    /// Point lights, for what answers shadow rays alone.
    pub lights: Vec<DVec3>,
    /// Index of the light that each ray runs to.
    pub light_of: Vec<u32>,
    /// The frame before: structures are built over it, and then taken to the scene.
    pub before: Option<Geometry<S>>,
    /// Structures are built by each of these numbers of threads; by those there are where it is
    /// empty.
    pub threads: &'static [usize],
    /// The same in other guises, which must not change the answers.
    pub pairs: Vec<MetamorphicPair<S>>,
    /// For each ray the only primitives that it can meet, ids rising: those alone are tested for
    /// the reference, in scenes so large that all would take too long. Empty where all are.
    pub near: Vec<Vec<u32>>,
}

impl<S: Buildable> Round<S> {
    pub fn new(model: Geometry<S>) -> Self {
        Self {
            model,
            rays: Vec::new(),
            expected: Vec::new(),
            blocked: Vec::new(),
            lights: Vec::new(),
            light_of: Vec::new(),
            before: None,
            threads: &[],
            pairs: Vec::new(),
            near: Vec::new(),
        }
    }

    /// No more than so many rays: chains may have added some.
    pub fn truncate(&mut self, rays: usize) {
        self.rays.truncate(rays);
        self.expected.truncate(rays);
    }

    /// With the rays that `add` adds, called until there are so many.
    pub fn filled(mut self, rays: usize, mut add: impl FnMut(&mut Self)) -> Self {
        while self.rays.len() < rays {
            add(&mut self);
        }
        self.truncate(rays);
        self
    }

    pub fn push(&mut self, ray: Ray<S>, expected: OracleAnswer) {
        self.rays.push(ray);
        self.expected.push(expected);
    }

    /// The same of a ray that may have no direction, or numbers that are none: such a one is left
    /// out.
    pub fn push_traceable(&mut self, ray: Ray<S>, expect: impl FnOnce(&Self) -> OracleAnswer) {
        if ray.is_traceable() {
            self.push(ray, expect(self));
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Invariant {
    /// The parameter of the hit, to the last bit, and the primitive.
    Bits,
    /// The primitive, where the oracle says which it is: sums are made in another order.
    Ids,
}

/// The same scene and rays, told differently.
pub struct MetamorphicPair<S: Buildable> {
    pub name: String,
    pub same: Invariant,
    pub model: Geometry<S>,
    /// The rays, in the order of the round.
    pub rays: Vec<Ray<S>>,
    /// A parameter of the round is this much that of the pair: a power of two.
    pub factor: f64,
    /// For each id of the pair, that of the round; empty when they are the same.
    pub ids: Vec<u32>,
}

impl<S: Buildable> MetamorphicPair<S> {
    /// A pair with the same parameters, to the last bit, and the same ids.
    pub fn new(name: impl Into<String>, model: Geometry<S>, rays: Vec<Ray<S>>) -> Self {
        let (same, name) = (Invariant::Bits, name.into());
        Self { name, same, model, rays, factor: 1.0, ids: Vec::new() }
    }

    /// The answer of the pair, told as one of the round.
    pub fn told_back(&self, hit: Hit<S>) -> Hit<S> {
        let t = S::from_f64(hit.t.to_f64() * self.factor);
        let id =
            if hit.is_hit() { *self.ids.get(hit.id as usize).unwrap_or(&hit.id) } else { hit.id };
        Hit { t, id }
    }
}

/// The round in other guises, where its scene is of triangles.
impl<S: Buildable> Round<S> {
    /// Everything by `2^exponent`: `t` keeps its bits.
    pub fn scaled(&self, exponent: i32) -> Option<MetamorphicPair<S>> {
        let by = 2.0_f64.powi(exponent);
        self.moved(format!("scaled by 2^{exponent}"), 1.0, |p| p * by, |d| d * by)
    }

    /// Directions alone by `2^exponent`: `t` becomes `2^-exponent` times as large.
    pub fn with_direction_scaled(&self, exponent: i32) -> Option<MetamorphicPair<S>> {
        let by = 2.0_f64.powi(exponent);
        self.moved(format!("direction by 2^{exponent}"), by, |p| p, |d| d * by)
    }

    /// The axes whose bit is set in `mask`, mirrored.
    pub fn mirrored(&self, mask: u8) -> Option<MetamorphicPair<S>> {
        self.permuted(0, mask)
    }

    /// The axes in another order, the `order`-th of six, and mirrored as well.
    pub fn permuted(&self, order: usize, mask: u8) -> Option<MetamorphicPair<S>> {
        const ORDERS: [[usize; 3]; 6] =
            [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let axes = ORDERS.get(order)?;
        let moved = |p: DVec3| {
            let at = |k: usize| if mask >> k & 1 == 1 { -p[axes[k]] } else { p[axes[k]] };
            DVec3::from_array([0, 1, 2].map(at))
        };
        let (same, name) = match order {
            0 => (Invariant::Bits, format!("mirrored {mask:03b}")),
            _ => (Invariant::Ids, format!("axes {axes:?}, mirrored {mask:03b}")),
        };
        Some(MetamorphicPair { same, ..self.moved(name, 1.0, moved, moved)? })
    }

    /// The triangles in another order: `order[new] = old`.
    pub fn renumbered(&self, order: Vec<u32>) -> Option<MetamorphicPair<S>> {
        let triangles = corners_of(&self.model)?;
        let moved = order.iter().filter_map(|&old| triangles.get(old as usize).copied());
        let model = model_of(&moved.collect::<Vec<_>>()).ok()?;
        let pair = MetamorphicPair::new("renumbered", model, self.rays.to_vec());
        Some(MetamorphicPair { ids: order, ..pair })
    }

    /// `None` when the numbers do not fit.
    fn moved(
        &self,
        name: String,
        factor: f64,
        point: impl Fn(DVec3) -> DVec3,
        direction: impl Fn(DVec3) -> DVec3,
    ) -> Option<MetamorphicPair<S>> {
        let triangles = corners_of(&self.model)?;
        let moved: Vec<Corners> = triangles.iter().map(|t| t.map(&point)).collect();
        let told = |r: &Ray<S>| {
            let moved = ray(point(r.origin.to_dvec3()), direction(r.direction.to_dvec3()));
            let by = |t: S| S::from_f64(t.to_f64() / factor);
            Ray { t_min: by(r.t_min), t_max: by(r.t_max), ..moved }
        };
        let model = model_of(&moved).ok()?;
        let rays = self.rays.iter().map(told).collect();
        Some(MetamorphicPair { factor, ..MetamorphicPair::new(name, model, rays) })
    }
}
