//! The primitives of a scene as flat convex faces in double precision: concave polygons are cut
//! into convex parts, which keep the id of the polygon.
//!
//! Paper: S. Hertel, K. Mehlhorn, "Fast Triangulation of the Plane with Respect to Simple
//! Polygons", Information and Control 64, 1985 (triangles are joined where the result is convex).
//! Deviation: each triangle is joined to the first part that it fits; parts are not joined.

use accel_core::primitives::newell_normal;
use glam::DVec3;
use scene_loading::tessellate::triangulate;
use scene_loading::{Scene, Shape};

use super::convex::edges;

/// A turn of an outline counts as one to the other side beyond this sine.
const STRAIGHT: f64 = 1e-12;

/// The area of a polygon's triangles may differ from that of the polygon by this part.
const AREA_TOLERANCE: f64 = 1e-9;

/// A flat convex polygon.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The primitive that it is, or is a part of.
    pub id: u32,
    /// Its corners, world units, in order.
    pub corners: Vec<DVec3>,
}

/// All faces, by primitive.
#[derive(Debug, Clone, Default)]
pub struct Faces {
    faces: Vec<Face>,
    /// `faces[first[id]..first[id + 1]]` make up a primitive.
    first: Vec<u32>,
}

impl Faces {
    /// Faces of a scene. Spheres, cones and degenerate primitives have none.
    pub fn of(scene: &Scene) -> Self {
        let mut this = Self { faces: Vec::with_capacity(scene.primitives.len()), first: vec![0] };
        for (primitive, id) in scene.primitives.iter().zip(0..) {
            let outline = scene.outline(primitive.shape);
            if newell_normal(&outline) != DVec3::ZERO {
                if outline.len() == 3 || is_convex(&outline) {
                    this.faces.push(Face { id, corners: outline });
                } else {
                    let parts = convex_parts(&outline).into_iter();
                    this.faces.extend(parts.map(|corners| Face { id, corners }));
                }
            }
            this.first.push(this.faces.len() as u32);
        }
        this
    }

    pub fn of_primitive(&self, id: u32) -> &[Face] {
        let [begin, end] = [id as usize, id as usize + 1]
            .map(|i| self.first.get(i).map_or(self.faces.len(), |&f| f as usize));
        self.faces.get(begin..end).unwrap_or_default()
    }
}

/// A concave polygon as convex parts between its own corners.
fn convex_parts(outline: &[DVec3]) -> Vec<Vec<DVec3>> {
    let at = |part: &[u32]| part.iter().map(|&i| outline[i as usize]).collect::<Vec<DVec3>>();
    let mut parts: Vec<Vec<u32>> = Vec::new();
    for triangle in triangulate(outline).unwrap_or_default() {
        let joined = parts.iter().enumerate().find_map(|(number, part)| {
            let joined = joined(part, triangle)?;
            is_convex(&at(&joined)).then_some((number, joined))
        });
        match joined {
            Some((number, joined)) => parts[number] = joined,
            None => parts.push(triangle.to_vec()),
        }
    }
    parts.iter().map(|part| at(part)).collect()
}

/// A part with a triangle added where they have an edge in common.
fn joined(part: &[u32], [a, b, c]: [u32; 3]) -> Option<Vec<u32>> {
    for (place, (from, to)) in edges(part).enumerate() {
        let third = match (from, to) {
            edge if edge == (b, a) => c,
            edge if edge == (c, b) => a,
            edge if edge == (a, c) => b,
            _ => continue,
        };
        let mut joined = part.to_vec();
        joined.insert(place + 1, third);
        return Some(joined);
    }
    None
}

/// Polygons whose outline crosses itself: the triangles that ear clipping makes of them have
/// another area.
pub fn crossing_outlines(scene: &Scene) -> usize {
    let polygons =
        scene.primitives.iter().filter(|p| matches!(p.shape, Shape::Polygon { count: 4.., .. }));
    let crosses = |outline: &[DVec3]| {
        if is_convex(outline) {
            return false;
        }
        let twice = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a);
        let parts = triangulate(outline).unwrap_or_default().into_iter();
        let corners = parts.map(|triangle| triangle.map(|i| outline[i as usize]));
        let sum: f64 = corners.map(|[a, b, c]| twice(a, b, c).length()).sum();
        let whole: DVec3 = outline.windows(2).map(|w| twice(outline[0], w[0], w[1])).sum();
        (sum - whole.length()).abs() > AREA_TOLERANCE * sum
    };
    polygons.filter(|p| crosses(&scene.outline(p.shape))).count()
}

/// True when the outline turns one way only, and once.
fn is_convex(outline: &[DVec3]) -> bool {
    let normal = newell_normal(outline);
    let ways = edges(outline).map(|(a, b)| b - a).filter(|way| *way != DVec3::ZERO);
    let ways: Vec<DVec3> = ways.collect();
    let mut turned = 0.0;
    for (a, b) in edges(&ways) {
        let (sin, cos) = (a.cross(b).dot(normal), a.dot(b));
        if sin < -STRAIGHT * a.length() * b.length() {
            return false;
        }
        turned += sin.atan2(cos);
    }
    turned < 1.5 * std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Scene {
        let (mut scene, m) = Scene::of_one_material("polygon");
        let corners: Vec<DVec3> = corners.iter().map(|&[x, z]| DVec3::new(x, 2.0, z)).collect();
        scene.push_polygon(m, &corners);
        scene
    }

    fn parts(scene: &Scene) -> usize {
        Faces::of(scene).of_primitive(0).len()
    }

    #[test]
    fn convex_polygons_stay_whole_and_others_are_cut() {
        let square = polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert_eq!((parts(&square), crossing_outlines(&square)), (1, 0));
        let arrow = polygon(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]]);
        assert_eq!((parts(&arrow), crossing_outlines(&arrow)), (2, 0));
        // four triangles, two rectangles
        let angle = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let angle = polygon(&angle);
        assert!((2..4).contains(&parts(&angle)), "{}", parts(&angle));
        let area = |face: &Face| {
            let corners = &face.corners;
            let fan = corners[1..].windows(2).map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
            fan.sum::<DVec3>().length() / 2.0
        };
        let areas = Faces::of(&angle).of_primitive(0).iter().map(area).sum::<f64>();
        assert!((areas - 3.0).abs() < 1e-14, "{areas}");
        let flat = polygon(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]);
        assert_eq!((parts(&flat), crossing_outlines(&flat)), (0, 0));
        assert!(Faces::of(&flat).of_primitive(7).is_empty());
    }

    #[test]
    fn outlines_that_cross_themselves_are_found() {
        let tie = polygon(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
        assert_eq!(crossing_outlines(&tie), 1);
        let star = |i: i32| {
            let (sin, cos) = (f64::from(i * 2) / 5.0 * std::f64::consts::TAU).sin_cos();
            [cos, sin]
        };
        let pentagram: Vec<[f64; 2]> = (0..5).map(star).collect();
        assert_eq!(crossing_outlines(&polygon(&pentagram)), 1);
    }
}
