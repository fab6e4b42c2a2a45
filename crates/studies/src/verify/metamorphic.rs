//! Metamorphic tests: a scene scaled, mirrored or renumbered. The answers must stay the same.

use accel_core::{Hit, Ray, Scalar, Vector};
use glam::DVec3;

use super::model::{Corners, Model, ray};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Invariant {
    /// The parameter of the hit, to the last bit, and the primitive.
    Bits,
    /// The primitive, where the oracle says which it is: sums are made in another order.
    Ids,
}

/// The same scene and rays, told differently.
#[derive(Debug)]
pub struct MetamorphicPair<S: Scalar> {
    pub name: String,
    pub same: Invariant,
    pub model: Model<S>,
    /// The rays, in the order of the round.
    pub rays: Vec<Ray<S>>,
    /// A parameter of the round is this much that of the pair: a power of two.
    pub factor: f64,
    /// For each id of the pair, that of the round; empty when they are the same.
    pub ids: Vec<u32>,
}

impl<S: Scalar> MetamorphicPair<S> {
    /// A pair with the same parameters, to the last bit, and the same ids.
    pub fn new(name: impl Into<String>, model: Model<S>, rays: Vec<Ray<S>>) -> Self {
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

/// A scene of triangles and the rays through it, from which pairs are made.
#[derive(Debug)]
pub struct OriginalScene<'a, S: Scalar> {
    pub triangles: &'a [Corners],
    pub rays: &'a [Ray<S>],
}

impl<S: Scalar> OriginalScene<'_, S> {
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
        let sign =
            DVec3::from_array([0, 1, 2].map(|k| if mask >> k & 1 == 1 { -1.0 } else { 1.0 }));
        self.moved(format!("mirrored {mask:03b}"), 1.0, |p| p * sign, |d| d * sign)
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
        let pair = self.moved(format!("axes {axes:?}, mirrored {mask:03b}"), 1.0, moved, moved)?;
        let same = if order == 0 { Invariant::Bits } else { Invariant::Ids };
        Some(MetamorphicPair { same, ..pair })
    }

    /// The triangles in another order: `order[new] = old`.
    pub fn renumbered(&self, order: Vec<u32>) -> Option<MetamorphicPair<S>> {
        let moved = order.iter().filter_map(|&old| self.triangles.get(old as usize).copied());
        let model = Model::triangles(&moved.collect::<Vec<_>>()).ok()?;
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
        let triangles: Vec<Corners> = self.triangles.iter().map(|t| t.map(&point)).collect();
        let told = |r: &Ray<S>| {
            let moved = ray(point(r.origin.to_dvec3()), direction(r.direction.to_dvec3()));
            let by = |t: S| S::from_f64(t.to_f64() / factor);
            Ray { t_min: by(r.t_min), t_max: by(r.t_max), ..moved }
        };
        let model = Model::triangles(&triangles).ok()?;
        let rays = self.rays.iter().map(told).collect();
        Some(MetamorphicPair { factor, ..MetamorphicPair::new(name, model, rays) })
    }
}
