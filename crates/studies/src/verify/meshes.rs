//! Shapes of the cases: meshes, whose coordinates are those of single precision; and surfaces of
//! polygons, sheets that tile a plane and closed bodies, neighbours with the same vertices at the edge
//! they share, all wound alike.

use glam::{DAffine3, DQuat, DVec3, dvec3};
use statistics::random::Random;

use crate::verify::draw::{direction, one_of, single, unit};
use crate::verify::round::Corners;
use crate::verify::surface::Outlines;

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

/// A square of `side` x `side` cells in the plane z = 0: squares, bent quadrilaterals, or bricks of
/// six vertices, two of them within straight edges.
pub fn tiling(random: &mut Random, side: usize) -> Outlines {
    let kind = random.below(3);
    let offsets: Vec<DVec3> = (0..(side + 1) * (side + 1))
        .map(|_| {
            let mut off = || (random.below(7) as f64 - 3.0) / 8.0;
            dvec3(off(), off(), 0.0)
        })
        .collect();
    let vertex = |x: usize, y: usize| {
        let off = if kind == 1 { offsets[y * (side + 1) + x] } else { DVec3::ZERO };
        dvec3(x as f64, y as f64, 0.0) + off
    };
    let cell = |from: usize, to: usize, y: usize| {
        let below = (from..=to).map(|x| vertex(x, y));
        below.chain((from..=to).rev().map(|x| vertex(x, y + 1))).collect()
    };
    let mut cells = Vec::new();
    for y in 0..side {
        // rows of bricks are staggered
        let is_cut = |x: &usize| kind != 2 || *x == 0 || *x == side || (x + y).is_multiple_of(2);
        let cuts: Vec<usize> = (0..=side).filter(is_cut).collect();
        cells.extend(cuts.windows(2).map(|ends| cell(ends[0], ends[1], y)));
    }
    cells
}

/// A cube of the lattice, each of its faces of `side` x `side` squares.
pub fn block(side: usize) -> Outlines {
    let far = side as f64;
    let face = |axis: usize, level: f64, u: f64, v: f64| {
        let corner = |u: f64, v: f64| {
            let mut p = [0.0; 3];
            p[axis] = level;
            let (u, v) = if level > 0.0 { (u, v) } else { (v, u) };
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
            DVec3::from_array(p)
        };
        vec![corner(u, v), corner(u + 1., v), corner(u + 1., v + 1.), corner(u, v + 1.)]
    };
    let cells = (0..side * side).map(|i| ((i % side) as f64, (i / side) as f64));
    cells
        .flat_map(|(u, v)| [0, 1, 2].map(|axis| [face(axis, 0.0, u, v), face(axis, far, u, v)]))
        .flatten()
        .collect()
}

/// A prism over a polygon of so many vertices around the z axis.
pub fn prism(around: usize, height: f64) -> Outlines {
    let vertex = |i: usize, z: f64| {
        let turn = (i % around) as f64 / around as f64 * std::f64::consts::TAU;
        dvec3(turn.cos(), turn.sin(), z)
    };
    let sides = (0..around).map(|i| {
        vec![vertex(i, 0.0), vertex(i + 1, 0.0), vertex(i + 1, height), vertex(i, height)]
    });
    let top = (0..around).map(|i| vertex(i, height)).collect();
    let bottom = (0..around).rev().map(|i| vertex(i, 0.0)).collect();
    sides.chain([top, bottom]).collect()
}

/// A ring around the z axis, of planar quadrilaterals.
pub fn ring(around: usize, tube: usize) -> Outlines {
    let turn = |i: usize, of: usize| (i % of) as f64 / of as f64 * std::f64::consts::TAU;
    let vertex = |i: usize, k: usize| {
        let (big, small) = (turn(i, around), turn(k, tube));
        let away = 1.0 + 0.4 * small.cos();
        dvec3(away * big.cos(), away * big.sin(), 0.4 * small.sin())
    };
    let cells = (0..around * tube).map(|i| (i / tube, i % tube));
    cells
        .map(|(i, k)| vec![vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1), vertex(i, k + 1)])
        .collect()
}

/// A closed body; some of its quadrilaterals as two triangles.
pub fn body(random: &mut Random) -> Outlines {
    let faces = match random.below(4) {
        0 => block(1),
        1 => block(2 + random.below(5)),
        2 => prism(3 + random.below(30), 0.2 + 3.0 * unit(random)),
        _ => ring(5 + random.below(20), 4 + random.below(8)),
    };
    let quarters = random.below(3);
    let split = |face: Vec<DVec3>| match face.as_slice() {
        &[a, b, c, d] if random.below(4) < quarters => vec![vec![a, b, c], vec![a, c, d]],
        _ => vec![face],
    };
    faces.into_iter().flat_map(split).collect()
}

/// Turned, stretched by up to `most` along an axis, and moved; or left on the lattice, where most
/// is 1.
pub fn placed(random: &mut Random, outlines: &Outlines, most: f64) -> Outlines {
    if most == 1.0 && random.below(2) == 0 {
        return outlines.clone();
    }
    let scale = most.powf(unit(random)) * one_of(random, &[1.0, 0.1, 7.3]);
    let turn = DQuat::from_axis_angle(direction(random), unit(random) * std::f64::consts::TAU);
    let stretch = DAffine3::from_scale(dvec3(scale, 1.0, 1.0));
    let away = direction(random) * scale * one_of(random, &[0.0, 1.0, 30.0]);
    let place = DAffine3::from_rotation_translation(turn, away) * stretch;
    let placed = |p: &DVec3| single(place.transform_point3(*p));
    outlines.iter().map(|outline| outline.iter().map(placed).collect()).collect()
}

/// The same polygons: as they are, all wound the other way, or each as chance has it.
pub fn wound(random: &mut Random, outlines: &Outlines) -> Outlines {
    let kind = random.below(3);
    let wound = |outline: &Vec<DVec3>| {
        let is_kept = kind == 0 || (kind == 1 && random.below(2) == 0);
        if is_kept { outline.clone() } else { outline.iter().rev().copied().collect() }
    };
    outlines.iter().map(wound).collect()
}

/// A closed outline that crosses itself, goes round twice, or has a hole by a bridge; in the plane
/// z = 0.
pub fn tangled(random: &mut Random) -> Vec<DVec3> {
    let flat = |points: &[(f64, f64)]| points.iter().map(|&(x, y)| dvec3(x, y, 0.0)).collect();
    match random.below(5) {
        0 => flat(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.)]),
        // the parts are not equal
        1 => flat(&[(0., 0.), (2., 1.5), (2., 0.), (0.5, 2.)]),
        2 => {
            let points = 5 + 2 * random.below(5);
            let vertex = |i: usize| {
                let turn = (i * 2) as f64 / points as f64 * std::f64::consts::TAU;
                single(dvec3(1.0 + turn.cos(), 1.0 + turn.sin(), 0.0))
            };
            (0..points).map(vertex).collect()
        }
        3 => {
            let once: Vec<DVec3> = flat(&[(0., 0.), (2., 0.), (2., 2.), (0., 2.)]);
            once.repeat(2)
        }
        _ => {
            let [x, y] = [(); 2].map(|()| 0.25 + random.below(8) as f64 / 8.0);
            let outer = [(0., 0.), (2., 0.), (2., 2.), (0., 2.), (0., 0.)];
            let hole = [(x, y), (x, y + 0.5), (x + 0.5, y + 0.5), (x + 0.5, y), (x, y)];
            flat(&outer.into_iter().chain(hole).collect::<Vec<_>>())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// How often each edge is there, once for each way it is run through.
    fn edges(outlines: &[impl AsRef<[DVec3]>]) -> BTreeMap<[[u64; 3]; 2], [u32; 2]> {
        let mut edges = BTreeMap::new();
        for outline in outlines.iter().map(AsRef::as_ref) {
            for (i, a) in outline.iter().enumerate() {
                let b = outline[(i + 1) % outline.len()];
                let ends = [*a, b].map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
                let (ends, way) =
                    if ends[0] < ends[1] { (ends, 0) } else { ([ends[1], ends[0]], 1) };
                edges.entry(ends).or_insert([0, 0])[way] += 1;
            }
        }
        edges
    }

    #[test]
    fn meshes_are_closed() {
        let ball = icosphere(2, dvec3(3.0, -7.0, 100.0));
        assert_eq!(ball.len(), 320);
        for (mesh, many) in [(ball, 480), (torus(5, 4), 60), (cube([2, 0, -3]).collect(), 18)] {
            let edges = edges(&mesh);
            assert!(edges.len() == many && edges.values().all(|[a, b]| a + b == 2), "{edges:?}");
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

    #[test]
    fn bodies_are_closed_and_wound_alike() {
        let random = &mut Random::new(4, "polygons");
        for outlines in [block(1), block(3), prism(3, 1.0), prism(12, 0.3), ring(5, 4)] {
            let placed = placed(random, &outlines, 10.0);
            assert!(edges(&placed).values().all(|ways| *ways == [1, 1]));
        }
    }

    #[test]
    fn tilings_have_a_rim_and_no_other_open_edge() {
        for seed in 0..30 {
            let side = 5 + seed as usize % 2;
            let outlines = tiling(&mut Random::new(seed, "tilings"), side);
            let rim = edges(&outlines).values().filter(|ways| **ways != [1, 1]).count();
            assert_eq!(rim, 4 * side, "{seed}");
            let area = |o: &Vec<DVec3>| {
                let next = o.iter().skip(1).chain(o.first());
                o.iter().zip(next).map(|(a, b)| a.truncate().perp_dot(b.truncate())).sum::<f64>()
            };
            assert!(outlines.iter().all(|outline| area(outline) > 0.0), "{seed}");
        }
    }
}
