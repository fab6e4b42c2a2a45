//! A piece of the image, cut at the borders between pixels.

use glam::DVec2;

use super::convex::{Affine, ConvexPolygon, CutSide};

/// The parts of a piece by pixel.
pub fn pixels_of(piece: &ConvexPolygon) -> Vec<ConvexPolygon> {
    let mut parts = Vec::new();
    for row in strips(piece.clone(), DVec2::Y) {
        parts.extend(strips(row, DVec2::X));
    }
    parts
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

    #[test]
    fn the_pixels_of_a_piece_are_all_of_it() {
        let piece = ConvexPolygon::rectangle(DVec2::new(0.5, 1.25), DVec2::new(3.0, 2.5));
        let parts = pixels_of(&piece);
        let areas: Vec<f64> = parts.iter().map(ConvexPolygon::area).collect();
        assert_eq!(areas, [0.375, 0.75, 0.75, 0.25, 0.5, 0.5]);
        assert_eq!(pixels_of(&ConvexPolygon::rectangle(DVec2::ZERO, DVec2::ONE)).len(), 1);
    }
}
