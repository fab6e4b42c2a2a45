//! Cuts long thin triangles into parts with boxes of their own, where boxes of whole triangles
//! overlap everywhere.
//!
//! Papers: M. Ernst, G. Greiner, "Early Split Clipping for Bounding Volume Hierarchies", RT 2007
//! (boxes are halved before the build until they are small); T. Karras, T. Aila, "Fast Parallel
//! Construction of High-Quality Bounding Volume Hierarchies", HPG 2013 (what is cut: boxes much
//! larger than what is in them; at multiples of powers of two, so that neighbours are cut alike).
//! Deviations: nothing is cut unless thin triangles have most of the area of all boxes; a half is
//! that of the whole triangle, within the box that is cut.
//!
//! The watertight test hits a mean of a triangle's rounded corners. The same mean of the corners
//! themselves is a point of one part, and the hit is off by what `node.rs` says of the whole
//! triangle. So the box of a part is padded as that of the whole would be.

use std::ops::Range;

use glam::DVec3;
use obvhs::aabb::Aabb as ObvhsAabb;

use super::items::{BoxScale, Groups, Items, Padding};
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::memory::Limits;
use crate::parallel::map_parts;
use crate::params::{ParamSpec, Params};
use crate::primitives::Primitives;
use crate::structure::BuildError;

pub(super) const SPLIT: ParamSpec =
    ParamSpec::choice("split", "auto", &["auto", NEVER, ALWAYS]).about(
        "cut long thin triangles into parts: where their boxes have most of the area of all, never, or all triangles",
    );
const NEVER: &str = "never";
const ALWAYS: &str = "always";

/// Which triangles are cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Splitting {
    /// Thin ones, where they have most of the area of all boxes.
    Auto,
    Never,
    /// All that are large.
    Always,
}

/// A box of more times the least area that such a triangle can have around it is that of a thin one.
const THIN: f64 = 16.0;
/// Thin triangles are cut where they have this part of the area of all boxes: 0.05 at most in the
/// scenes of the catalogue, but for *sticks*, 0.9999.
const MOST: f64 = 0.5;
/// A box is cut that is larger by this factor, squared, than that of a thin triangle in the mean:
/// into 5.2 parts each in *sticks*.
const FINENESS: f64 = 4.0;
/// No triangle is cut into boxes smaller by this factor, squared, than its own.
const FINEST: f64 = 64.0;
/// No shorter side is cut, in the scene's largest coordinate: a cut is rounded, in f64, by less than
/// 2^-50 of that, and a box padded by 2^-29 of the triangle's extent more than it needs.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Triangles looked at to tell what is cut.
const SAMPLE: usize = 1024;

/// The triangles of a set, and how they are cut.
struct Cuts<'a, S> {
    triangles: &'a [[[S; 3]; 3]],
    /// Ratio of areas from which on a triangle is thin.
    thin: f64,
    /// Half the area of the largest box that is not cut.
    largest: f64,
    /// The longest side that is not cut.
    shortest: f64,
}

impl Splitting {
    pub(super) fn of(params: &Params) -> Self {
        match params.text(SPLIT.name) {
            NEVER => Self::Never,
            ALWAYS => Self::Always,
            _ => Self::Auto,
        }
    }

    /// The boxes of a set of primitives, those of triangles that are cut in parts.
    ///
    /// # Errors
    /// [`BuildError`] for boxes that do not fit in memory.
    pub(super) fn cut<S: Scalar>(
        self,
        prims: &dyn Primitives<S>,
        items: Items<S>,
        padding: Padding,
        limits: Limits,
    ) -> Result<Items<S>, BuildError> {
        let triangles = prims.triangles().filter(|_| self != Self::Never && prims.is_watertight());
        let (Some(triangles), Groups::Single) = (triangles, &items.groups) else {
            return Ok(items);
        };
        let thin = if self == Self::Always { 0.0 } else { THIN };
        let shortest = SHORTEST * prims.magnitude().to_f64();
        let mut cuts = Cuts { triangles, thin, largest: 0.0, shortest };
        // no step in which the same triangle of each of many like objects comes next
        let step = triangles.len().div_ceil(SAMPLE) | 1;
        // none where all have no area
        let has_most = |cuts: &Cuts<'_, S>| cuts.share_and_side(step).0 >= MOST;
        if triangles.is_empty() || self == Self::Auto && !has_most(&cuts) {
            return Ok(items);
        }
        cuts.largest = (cuts.share_and_side(1).1 / FINENESS).powi(2);
        let mut scale = BoxScale::of_set(prims, padding);
        scale.setup = items.setup;
        let parts = map_parts(triangles.len(), |ids| cuts.parts(ids, &scale));
        let count = parts.iter().map(|(_, ids)| ids.len()).sum::<usize>();
        limits.fits(96 * count as u128)?;
        let (boxes, ids): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        let groups = Groups::Many { starts: (0..=count as u32).collect(), ids: ids.concat() };
        Ok(Items { boxes: boxes.concat(), groups, setup: items.setup })
    }
}

impl<S: Scalar> Cuts<'_, S> {
    /// What part of the area of all boxes is that of thin triangles, and the root of that area in
    /// the mean; every so many triangles are looked at.
    fn share_and_side(&self, step: usize) -> (f64, f64) {
        let (mut all, mut thin, mut sides, mut count) = (0.0, 0.0, 0.0, 0u32);
        for triangle in self.triangles.iter().step_by(step) {
            let corners = corners(triangle);
            let area = Aabb::<f64>::of_triangle(&corners).half_area();
            all += area;
            if self.is_thin(&corners, area) {
                thin += area;
                sides += area.sqrt();
                count += 1;
            }
        }
        (thin / all, sides / f64::from(count.max(1)))
    }

    /// Returns whether a triangle whose box has this area is thin.
    fn is_thin(&self, [a, b, c]: &[DVec3; 3], area: f64) -> bool {
        area >= self.thin * (*b - *a).cross(*c - *a).abs().element_sum()
    }

    /// The boxes of the parts of some triangles, and whose each is.
    fn parts(&self, ids: Range<u32>, scale: &BoxScale<S>) -> (Vec<ObvhsAabb>, Vec<u32>) {
        let (mut boxes, mut owners, mut waiting) = (Vec::new(), Vec::new(), Vec::new());
        for id in ids {
            let corners = corners(&self.triangles[id as usize]);
            let whole = Aabb::<f64>::of_triangle(&corners);
            let (extents, area) = (whole.size(), whole.half_area());
            let largest = match self.is_thin(&corners, area) {
                true => self.largest.max(area / (FINEST * FINEST)),
                false => f64::INFINITY,
            };
            waiting.push(whole);
            while let Some(part) = waiting.pop() {
                let is_large = part.half_area() > largest;
                match is_large.then(|| halves(&corners, &part, self.shortest)).flatten() {
                    Some(halves) => waiting.extend(halves),
                    None => {
                        boxes.push(scale.padded_part(extents, &part));
                        owners.push(id);
                    }
                }
            }
        }
        (boxes, owners)
    }
}

/// Boxes around what of a triangle is in a box, on both sides of a plane near the middle of its
/// longest side; none where that is no longer than `shortest`.
fn halves(corners: &[DVec3; 3], part: &Aabb<f64>, shortest: f64) -> Option<[Aabb<f64>; 2]> {
    let size = part.size();
    let axis = size.max_position();
    if size[axis] <= shortest {
        return None;
    }
    // at most a quarter of the side from its middle
    let step = 0.5 * size[axis].log2().floor().exp2();
    let plane = ((part.min[axis] + part.max[axis]) * 0.5 / step).round() * step;
    let mut sides = [Aabb::<f64>::empty(); 2];
    let mut add = |side: bool, p: DVec3| {
        let side = &mut sides[usize::from(side)];
        *side = side.union(Aabb { min: p, max: p });
    };
    for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
        let is_above = a[axis] > plane;
        add(is_above, a);
        if is_above != (b[axis] > plane) {
            let mut between = a.lerp(b, (plane - a[axis]) / (b[axis] - a[axis]));
            between[axis] = plane;
            add(false, between);
            add(true, between);
        }
    }
    let within =
        |side: Aabb<f64>| Aabb::<f64> { min: side.min.max(part.min), max: side.max.min(part.max) };
    let halves = sides.map(within);
    halves.iter().all(|half| half.min.cmple(half.max).all()).then_some(halves)
}

fn corners<S: Scalar>(triangle: &[[S; 3]; 3]) -> [DVec3; 3] {
    triangle.map(|p| DVec3::from_array(p.map(Scalar::to_f64)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::config::Settings;
    use crate::primitives::{TriangleSet, Watertight};

    fn cut(corners: Vec<[[f32; 3]; 3]>, splitting: Splitting) -> Items<f32> {
        let set = TriangleSet::<f32, Watertight>::new(corners, |_| false).unwrap();
        let limits = Settings::<()>::of(&crate::bvh::INFO.defaults()).limits();
        let items = crate::bvh::items::items_of(&set, limits, Padding::OF_CORNERS).unwrap();
        splitting.cut(&set, items, Padding::OF_CORNERS, limits).unwrap()
    }

    /// Triangles from one corner of a cube to the other, of this width.
    fn diagonals(width: f32) -> Vec<[[f32; 3]; 3]> {
        let from = |i: u8| f32::from(i) / 100.0 - 1.0;
        (0..100).map(from).map(|x| [[x; 3], [x + 1.0; 3], [x + width, x, x - width]]).collect()
    }

    #[test]
    fn thin_triangles_are_cut_where_they_have_most_of_the_area() {
        let boxes = |width: f32, splitting| cut(diagonals(width), splitting).boxes.len();
        assert_eq!(boxes(1e-3, Splitting::Never), 100);
        assert!((400..900).contains(&boxes(1e-3, Splitting::Auto)));
        assert_eq!(boxes(0.5, Splitting::Auto), 100);
        assert!(boxes(0.5, Splitting::Always) > 400);
        // as large as all of the thin ones together
        let mut mixed = diagonals(1e-3);
        mixed.push([[-9.0; 3], [9.0, -9.0, 9.0], [-9.0, 9.0, 0.0]]);
        assert_eq!(cut(mixed, Splitting::Auto).boxes.len(), 101);
    }

    #[test]
    fn parts_cover_a_triangle_and_overlap_little() {
        let triangles = diagonals(1e-3);
        let Items { boxes, groups: Groups::Many { ids, .. }, setup } =
            cut(triangles.clone(), Splitting::Auto)
        else {
            panic!("nothing was cut")
        };
        let area: f32 = boxes.iter().map(ObvhsAabb::half_area).sum();
        assert!(area < 0.4 * 300.0 * setup.unit().powi(2) as f32, "{area}");
        for (id, corners) in triangles.iter().map(corners).enumerate() {
            for place in 0..=1000 {
                let p = corners[0].lerp(corners[1], f64::from(place) / 1000.0) * setup.unit();
                let holds = |b: &ObvhsAabb| {
                    b.min.as_dvec3().cmple(p).all() && b.max.as_dvec3().cmpge(p).all()
                };
                let mut own = boxes.iter().zip(&ids).filter(|(_, owner)| **owner == id as u32);
                assert!(own.any(|(b, _)| holds(b)), "{id} {p}");
            }
        }
    }
}
