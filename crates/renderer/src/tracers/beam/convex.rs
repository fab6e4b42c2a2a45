//! Convex pieces of the image, and how a line cuts them.
//!
//! Paper: I. Sutherland, G. Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974. Deviation:
//! both sides of the cut are kept, so that what is cut off one piece is the next one, and nothing
//! of the image is lost. Corners within [`ON`] of a line count as on it: no corner is made twice.

use glam::DVec2;

/// Corners so near to a line, in pixels, are on it. Rounding moves them by less than 1e-13.
pub const ON: f64 = 1e-10;

/// An affine function of image coordinates: `slope . p + offset`. As a line it is where the
/// function is 0; its inside is where the function is positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// How it grows, per pixel.
    pub slope: DVec2,
    /// Its value at the origin of the tile.
    pub offset: f64,
}

impl Affine {
    /// The value at a point.
    #[inline]
    pub fn at(&self, p: DVec2) -> f64 {
        self.slope.dot(p) + self.offset
    }

    pub fn minus(&self, other: &Self) -> Self {
        Self { slope: self.slope - other.slope, offset: self.offset - other.offset }
    }

    /// Scaled so that values are distances in pixels; a line at infinity has the values 1 or -1
    /// everywhere. `None` for a function that is 0 everywhere or not finite.
    pub fn as_line(&self) -> Option<Self> {
        let length = self.slope.length();
        let size = if length > 0.0 { length } else { self.offset.abs() };
        let line = Self { slope: self.slope / size, offset: self.offset / size };
        (size > 0.0 && line.slope.is_finite() && line.offset.is_finite()).then_some(line)
    }
}

/// The edges of an outline: from each corner to the next.
pub fn edges<T: Copy>(corners: &[T]) -> impl Iterator<Item = (T, T)> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// A convex polygon of the image, corners in pixels from the origin of the tile, in order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ConvexPolygon {
    corners: Vec<DVec2>,
}

/// Result of cutting a piece by a line.
#[derive(Debug, Clone, PartialEq)]
pub enum CutSide {
    Inside,
    Outside,
    /// The part inside and the part outside.
    Both(ConvexPolygon, ConvexPolygon),
}

impl ConvexPolygon {
    /// The rectangle between two corners.
    pub fn rectangle(low: DVec2, high: DVec2) -> Self {
        let corners = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        Self { corners }
    }

    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Its area, square pixels.
    pub fn area(&self) -> f64 {
        self.fan().map(|(_, twice)| twice).sum::<f64>().abs() * 0.5
    }

    /// Its centre of mass; that of its corners when it has no area.
    pub fn centroid(&self) -> DVec2 {
        let Some(&first) = self.corners.first() else { return DVec2::ZERO };
        let (mut sum, mut weight) = (DVec2::ZERO, 0.0);
        for (place, twice) in self.fan() {
            sum += place * twice;
            weight += twice;
        }
        let inside = first + sum / (3.0 * weight);
        let mean = self.corners.iter().sum::<DVec2>() / self.corners.len() as f64;
        if inside.is_finite() { inside } else { mean }
    }

    /// The box around it.
    pub fn bounds(&self) -> [DVec2; 2] {
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        self.corners.iter().fold(start, |[low, high], p| [low.min(*p), high.max(*p)])
    }

    /// Triangles from the first corner on: three times their centre, seen from that corner, and
    /// twice their signed area.
    fn fan(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        let first = self.corners.first().copied().unwrap_or_default();
        self.corners.windows(2).skip(1).map(move |pair| {
            let (a, b) = (pair[0] - first, pair[1] - first);
            (a + b, a.perp_dot(b))
        })
    }

    /// True for each side of the line with a corner: inside, outside.
    pub fn sides(&self, line: &Affine) -> [bool; 2] {
        let mut sides = [false; 2];
        for p in &self.corners {
            let d = line.at(*p);
            sides[0] |= d > ON;
            sides[1] |= d < -ON;
        }
        sides
    }

    /// Cuts it along a line ([`Affine::as_line`]).
    pub fn cut(&self, line: &Affine) -> CutSide {
        match self.sides(line) {
            [_, false] => return CutSide::Inside,
            [false, true] => return CutSide::Outside,
            [true, true] => {}
        }
        let n = self.corners.len() + 2;
        let (mut inside, mut outside) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for (a, b) in edges(&self.corners) {
            let (da, db) = (line.at(a), line.at(b));
            if da >= -ON {
                inside.push(a);
            }
            if da <= ON {
                outside.push(a);
            }
            if (da > ON && db < -ON) || (da < -ON && db > ON) {
                let crossing = a + (b - a) * (da / (da - db));
                inside.push(crossing);
                outside.push(crossing);
            }
        }
        CutSide::Both(Self { corners: inside }, Self { corners: outside })
    }

    /// Its parts by pixel.
    pub fn pixels(&self) -> Vec<Self> {
        let rows = strips(self.clone(), DVec2::Y).into_iter();
        rows.flat_map(|row| strips(row, DVec2::X)).collect()
    }
}

/// A piece cut at whole numbers along an axis.
fn strips(piece: ConvexPolygon, axis: DVec2) -> Vec<ConvexPolygon> {
    let [low, high] = piece.bounds();
    let (first, last) = (low.dot(axis).floor() as i64 + 1, high.dot(axis).ceil() as i64 - 1);
    let mut strips = Vec::new();
    let mut rest = piece;
    for border in first..=last {
        let line = Affine { slope: axis, offset: -(border as f64) };
        match rest.cut(&line) {
            CutSide::Inside => {}
            CutSide::Outside => break,
            CutSide::Both(beyond, before) => {
                strips.push(before);
                rest = beyond;
            }
        }
    }
    strips.push(rest);
    strips
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(x: f64, y: f64, offset: f64) -> Affine {
        Affine { slope: DVec2::new(x, y), offset }.as_line().unwrap()
    }

    #[test]
    fn areas_and_centroids() {
        let piece = ConvexPolygon::rectangle(DVec2::new(1.0, 2.0), DVec2::new(4.0, 4.0));
        assert_eq!((piece.area(), piece.centroid()), (6.0, DVec2::new(2.5, 3.0)));
        let CutSide::Both(inside, outside) = piece.cut(&line(-2.0, -3.0, 14.0)) else { panic!() };
        // the diagonal from (4, 2) to (1, 4)
        assert!((inside.area() - 3.0).abs() < 1e-15 && inside.corners().len() == 3);
        assert!((outside.area() - 3.0).abs() < 1e-15 && outside.corners().len() == 3);
        assert!((inside.centroid() - DVec2::new(2.0, 8.0 / 3.0)).length() < 1e-15);
    }

    #[test]
    fn cuts_keep_the_area_and_leave_what_they_touch() {
        let piece = ConvexPolygon::rectangle(DVec2::ZERO, DVec2::splat(8.0));
        for k in 0..200 {
            let angle = f64::from(k);
            let n = DVec2::from_angle(angle);
            let cut = line(n.x, n.y, -n.dot(DVec2::splat(4.0)) + (angle * 0.7).sin() * 3.0);
            let CutSide::Both(inside, outside) = piece.cut(&cut) else { panic!("{k}") };
            assert!((inside.area() + outside.area() - 64.0).abs() < 1e-12);
            // planted fault: the part that is cut off is dropped
            assert!((inside.area() - 64.0).abs() > 1e-3);
            assert_eq!(inside.cut(&cut), CutSide::Inside);
            assert_eq!(outside.cut(&cut), CutSide::Outside);
        }
        assert_eq!(piece.cut(&line(1.0, 0.0, 0.0)), CutSide::Inside);
        assert_eq!(piece.cut(&line(-1.0, 0.0, 0.5 * ON)), CutSide::Outside);
        assert_eq!(piece.cut(&Affine { slope: DVec2::ZERO, offset: -1.0 }), CutSide::Outside);
        assert_eq!(Affine { slope: DVec2::ZERO, offset: 0.0 }.as_line(), None);
    }

    #[test]
    fn the_pixels_of_a_piece_are_all_of_it() {
        let piece = ConvexPolygon::rectangle(DVec2::new(0.5, 1.25), DVec2::new(3.0, 2.5));
        let parts = piece.pixels();
        let areas: Vec<f64> = parts.iter().map(ConvexPolygon::area).collect();
        assert_eq!(areas, [0.375, 0.75, 0.75, 0.25, 0.5, 0.5]);
        assert_eq!(ConvexPolygon::rectangle(DVec2::ZERO, DVec2::ONE).pixels().len(), 1);
    }
}
