//! Boxes of primitives: padded, or as in 1999.

#![warn(missing_docs)]

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::parallel::collect;
use crate::primitives::{PrimitiveKind, Primitives};

/// How the box of a primitive is made from its tight bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BoundsRule {
    /// Tight bounds grown by 64 ulps of the scene's largest coordinate, so that the rounding of a
    /// hit point or of a cell plane never loses a primitive.
    Padded,
    /// Havran and Sixta (1999), as fitted to their counters: polygons and patches thinner than
    /// 0.02 on an axis get 0.02 more on both sides of it; cones and cylinders grow by the margin
    /// given here; spheres are exact; the scene's box grows by 0.001. Absolute lengths: only
    /// right for scenes of SPD's size.
    Historical {
        /// Added to every side of a cone's or cylinder's box.
        cone_margin: f64,
    },
}

impl BoundsRule {
    /// The rule of 1999 with this margin for cones, or today's.
    pub(crate) fn of(historical: bool, cone_margin: f64) -> Self {
        if historical { Self::Historical { cone_margin } } else { Self::Padded }
    }
}

/// Ulps (of the scene's largest coordinate) by which padded boxes grow, for all structures, so that
/// the ray is in a cell that lists a triangle where it is nearest to what it hits of it
/// (`proofs/padding.gappa`). Across the ray a hit is off by 25 for the rounding of sheared corners
/// (`proofs/corners.gappa`), for a ray that starts within 8 magnitudes (`far_ray.rs`), and by 12.1
/// for that of weights (`primitives/precise.rs`, `proofs/weights.gappa`). The rest are 22 for the
/// planes of cells (`proofs/voxel_planes.gappa`), 3.5 for where boxes are placed
/// (`proofs/cell_placement.gappa`), and the rounding of the box; where rays enter and leave needs
/// less (`proofs/box_clip.gappa`). The parameter told is that of a
/// point up to 41 along the ray from there (`proofs/parameter.gappa`), for which there is no room
/// if every rounding is at its worst at once: it matters to hits nearer to each other, or to an end
/// of the interval, than that. In 24 million hits of random triangles and needles, a third of them
/// from 8 magnitudes away, no point lay further than 11 outside of its triangle's box.
pub(crate) const PADDING_ULPS: f64 = 64.0;

/// The side that a cell must at least have where boxes are padded by so much.
pub(crate) fn smallest_cell<S: Scalar>(padding: S) -> f64 {
    padding.to_f64() * 16.0
}

/// The boxes of a set of primitives under one rule.
#[derive(Clone, Copy)]
pub struct BoundsOf<'a, S: Scalar> {
    prims: &'a dyn Primitives<S>,
    triangles: Option<&'a [[[S; 3]; 3]]>,
    rule: BoundsRule,
    scene: Aabb<S>,
    padding: S,
}

impl<'a, S: Scalar> BoundsOf<'a, S> {
    /// Looks at all primitives once. `Err(id)` names the farthest one when
    /// the scene's box is too large for the scalar.
    pub fn new(prims: &'a dyn Primitives<S>, rule: BoundsRule) -> Result<Self, u32> {
        let mut this = Self {
            prims,
            triangles: prims.triangles(),
            rule,
            scene: Aabb::empty(),
            padding: S::ZERO,
        };
        let scene = match rule {
            BoundsRule::Padded => prims.scene_bounds(),
            BoundsRule::Historical { .. } => {
                (0..prims.len() as u32).fold(Aabb::empty(), |all, id| all.union(this.of(id)))
            }
        };
        // sets hold finite coordinates only, but the sum of two can still overflow
        if !(scene.is_finite() && scene.size().is_finite()) {
            let far = |id: &u32| {
                prims.bounds(*id).magnitude() >= scene.magnitude() || !prims.bounds(*id).is_finite()
            };
            return Err((0..prims.len() as u32).find(far).unwrap_or(0));
        }
        match rule {
            BoundsRule::Padded => {
                let ulp = S::EPSILON * scene.magnitude();
                // a scene at the very origin still needs a box with an inside
                this.padding = (ulp * S::from_f64(PADDING_ULPS)).greater(S::from_f64(1e-30));
                this.scene = scene.expanded(this.padding + this.padding);
            }
            BoundsRule::Historical { .. } => this.scene = scene.expanded(S::from_f64(1e-3)),
        }
        Ok(this)
    }

    /// Primitives that the structure was built over.
    pub fn prims(&self) -> &'a dyn Primitives<S> {
        self.prims
    }

    /// The box of the whole scene.
    pub fn scene(&self) -> Aabb<S> {
        self.scene
    }

    /// By how much [`BoundsRule::Padded`] grows every box; 0 for the other rule.
    pub fn padding(&self) -> S {
        self.padding
    }

    /// The side that a cell must at least have for the padding not to drown it; 0 for the
    /// historical rule.
    pub fn smallest_cell(&self) -> f64 {
        smallest_cell(self.padding)
    }

    /// The boxes of all primitives, by all threads.
    pub(crate) fn all(&self) -> Vec<Aabb<S>> {
        collect(self.prims.len(), |id| self.of(id as u32))
    }

    /// The box of primitive `id`, as the set has it.
    #[inline(always)]
    pub(crate) fn tight(&self, id: u32) -> Aabb<S> {
        match self.triangles {
            Some(triangles) => {
                Aabb::of_triangle(&triangles[id as usize].map(Vec3::<S>::from_array))
            }
            None => self.prims.bounds(id),
        }
    }

    /// The box of primitive `id`, as the rule has it.
    #[inline(always)]
    pub fn of(&self, id: u32) -> Aabb<S> {
        let tight = self.tight(id);
        match self.rule {
            BoundsRule::Padded => tight.expanded(self.padding),
            BoundsRule::Historical { cone_margin } => match self.prims.kind(id) {
                PrimitiveKind::Sphere => tight,
                PrimitiveKind::Cone => tight.expanded(S::from_f64(cone_margin)),
                PrimitiveKind::Triangle | PrimitiveKind::Polygon => thickened(tight),
            },
        }
    }
}

fn thickened<S: Scalar>(tight: Aabb<S>) -> Aabb<S> {
    let thin = S::from_f64(0.02);
    let (mut lo, mut hi) = (tight.min.to_array(), tight.max.to_array());
    for k in 0..3 {
        if hi[k] - lo[k] < thin {
            hi[k] += thin;
            lo[k] = lo[k] - thin;
        }
    }
    Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
}
