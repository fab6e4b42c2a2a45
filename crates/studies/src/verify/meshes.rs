//! Meshes of the cases; their coordinates are those of single precision.

use glam::{DVec3, dvec3};

use super::draw::single;
use super::model::Corners;
use super::polygons::{block, ring};

/// A closed mesh around `center`: an icosahedron whose faces are divided by four `levels` times.
pub fn icosphere(levels: u32, center: DVec3) -> Vec<Corners> {
    let mut faces = icosahedron();
    for _ in 0..levels {
        faces = faces.iter().flat_map(divided).collect();
    }
    faces.iter().map(|f| f.map(|p| single(p + center))).collect()
}

/// The triangle as four; equal edges are divided equally, whichever way they run.
fn divided(&[a, b, c]: &Corners) -> [Corners; 4] {
    let middle = |p: DVec3, q: DVec3| (p + q).normalize();
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
}

/// The twenty triangles among the twelve corners (0, +-1, +-phi) and their rotations.
fn icosahedron() -> Vec<Corners> {
    let phi = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let signs = [(1.0, phi), (1.0, -phi), (-1.0, phi), (-1.0, -phi)];
    let corners: Vec<DVec3> = signs
        .iter()
        .flat_map(|&(a, b)| [dvec3(0.0, a, b), dvec3(a, b, 0.0), dvec3(b, 0.0, a)])
        .map(DVec3::normalize)
        .collect();
    let is_edge = |p: DVec3, q: DVec3| p.dot(q) > 0.4;
    let mut faces = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1) {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    faces.push([a, b, c]);
                }
            }
        }
    }
    faces
}

/// A sheet of `side` x `side` unit squares in the plane z = `height(x, y)`, two triangles each.
pub fn sheet(side: u32, height: impl Fn(f64, f64) -> f64) -> Vec<Corners> {
    let corner = |x: u32, y: u32| {
        let (x, y) = (f64::from(x), f64::from(y));
        single(dvec3(x, y, height(x, y)))
    };
    let square =
        |(x, y): (u32, u32)| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| corner(x + i, y + j));
    let squares = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    squares.flat_map(|at| halves(&square(at))).collect()
}

fn halves(square: &[DVec3]) -> [Corners; 2] {
    [[square[0], square[1], square[2]], [square[0], square[2], square[3]]]
}

/// A closed mesh around the z axis: a ring of `around` x `tube` squares, two triangles each.
pub fn torus(around: usize, tube: usize) -> Vec<Corners> {
    let faces = ring(around, tube).into_iter();
    faces.flat_map(|face| halves(&face)).map(|corners| corners.map(single)).collect()
}

/// A block of unit cubes, its corner at the origin: all of them, or every second as on a
/// chessboard.
#[derive(Debug, Clone, Copy)]
pub struct Cubes {
    pub side: i32,
    pub is_solid: bool,
}

impl Cubes {
    pub fn has(&self, at: [i32; 3]) -> bool {
        let is_within = at.iter().all(|x| (0..self.side).contains(x));
        is_within && (self.is_solid || at.iter().sum::<i32>() % 2 == 0)
    }

    /// The lowest corners of all of them.
    pub fn all(self) -> impl Iterator<Item = [i32; 3]> {
        let side = self.side;
        let places =
            (0..side * side * side).map(move |i| [i % side, i / side % side, i / side / side]);
        places.filter(move |at| self.has(*at))
    }
}

/// The twelve triangles of a unit cube, wound alike.
pub fn cube(at: [i32; 3]) -> impl Iterator<Item = Corners> {
    let low = DVec3::from_array(at.map(f64::from));
    let faces = block(1).into_iter().flat_map(|face| halves(&face));
    faces.map(move |corners| corners.map(|p| low + p))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of triangles that meet at each edge; the key's ends are sorted.
    fn edges(faces: &[Corners]) -> Vec<usize> {
        let mut edges = std::collections::BTreeMap::new();
        for f in faces {
            for k in 0..3 {
                let mut ends = [f[k], f[(k + 1) % 3]].map(|p| p.to_array().map(f64::to_bits));
                ends.sort_unstable();
                *edges.entry(ends).or_insert(0) += 1;
            }
        }
        edges.into_values().collect()
    }

    #[test]
    fn meshes_are_closed() {
        let ball = icosphere(2, dvec3(3.0, -7.0, 100.0));
        assert_eq!(ball.len(), 320);
        for (mesh, many) in [(ball, 480), (torus(5, 4), 60), (cube([2, 0, -3]).collect(), 18)] {
            let edges = edges(&mesh);
            assert!(edges.len() == many && edges.iter().all(|&n| n == 2), "{edges:?}");
        }
    }

    #[test]
    fn cubes_are_wound_alike_and_chessboards_half_full() {
        for triangle in cube([1, 2, 3]) {
            let [a, b, c] = triangle;
            let out = (a + b + c) / 3.0 - dvec3(1.5, 2.5, 3.5);
            assert!((b - a).cross(c - a).dot(out) > 0.0, "{triangle:?}");
        }
        assert_eq!(Cubes { side: 3, is_solid: false }.all().count(), 14);
        assert_eq!(Cubes { side: 3, is_solid: true }.all().count(), 27);
    }
}
