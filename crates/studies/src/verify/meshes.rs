//! Meshes of the cases; their coordinates are those of single precision.

use glam::{DVec3, dvec3};

use super::draw::{point, single};
use super::model::Corners;
use statistics::random::Random;

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
    let squares = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    squares
        .flat_map(|(x, y)| {
            let [a, b] = [corner(x, y), corner(x + 1, y)];
            let [c, d] = [corner(x + 1, y + 1), corner(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// Triangles of about `size` anywhere in the cube [-1, 1]^3.
pub fn soup(random: &mut Random, count: usize, size: f64) -> Vec<Corners> {
    (0..count)
        .map(|_| {
            let p = point(random);
            [p, single(p + point(random) * size), single(p + point(random) * size)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_icosphere_is_closed() {
        let faces = icosphere(2, dvec3(3.0, -7.0, 100.0));
        assert_eq!(faces.len(), 320);
        let mut edges = std::collections::BTreeMap::new();
        for f in &faces {
            for k in 0..3 {
                let mut ends = [f[k], f[(k + 1) % 3]].map(|p| p.to_array().map(f64::to_bits));
                ends.sort_unstable();
                *edges.entry(ends).or_insert(0) += 1;
            }
        }
        assert!(edges.len() == 480 && edges.values().all(|&n| n == 2));
    }
}
