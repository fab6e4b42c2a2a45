//! Polygons that share edges and vertices, and polygons seen edge-on.
//!
//! The oracles share nothing with the tests: whole numbers say which tile of a planar tiling holds
//! a point, and a closed body is crossed an even number of times.

use accel_core::primitives::PrimsRef;
use accel_core::primitives::{MixedSet, MixedSetBuilder, PrimSet, Primitives};
use accel_core::registry::Buildable;
use accel_core::structures::REGISTRY;
use accel_core::{Ray, Scalar, Vec3, Vector};
use glam::{DVec3, I64Vec2, dvec3, i64vec2};

use crate::agreement::mismatches;
use crate::common::Random;

/// Tiles of a square: corners of whole numbers, in parts of 16 of a tile.
const SIDE: usize = 8;

/// Plane outlines of whole numbers that share all edges.
struct Tiling {
    outlines: Vec<Vec<I64Vec2>>,
}

impl Tiling {
    /// Quadrilaterals, wound at random; `with_triangles`: some of them cut in two, others in three,
    /// one of which is concave.
    fn new(random: &mut Random, with_triangles: bool) -> Self {
        let mut corners = Vec::new();
        for i in 0..=SIDE {
            for j in 0..=SIDE {
                let mut moved = |k: usize| match k {
                    0 | SIDE => 0,
                    _ => (random.unit() * 10.0) as i64 - 5,
                };
                corners.push(i64vec2(i as i64 * 16 + moved(i), j as i64 * 16 + moved(j)));
            }
        }
        let mut outlines = Vec::new();
        for tile in 0..SIDE * SIDE {
            let at = |i: usize, j: usize| corners[(tile / SIDE + i) * (SIDE + 1) + tile % SIDE + j];
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let middle = (a + b + c + d) / 4;
            match tile % 3 {
                0 if with_triangles => outlines.extend([vec![a, b, c], vec![a, c, d]]),
                1 if with_triangles => {
                    outlines.extend([
                        vec![a, b, middle, d],
                        vec![b, c, middle],
                        vec![c, d, middle],
                    ]);
                }
                _ => outlines.push(vec![a, b, c, d]),
            }
        }
        for outline in &mut outlines {
            let first = (random.unit() * outline.len() as f64) as usize;
            outline.rotate_left(first);
            if random.unit() < 0.5 {
                outline.reverse();
            }
        }
        Self { outlines }
    }

    /// The outlines that hold a point, given in eighths: none on whose border it lies.
    fn holders(&self, point: I64Vec2) -> Vec<u32> {
        let holds = |outline: &Vec<I64Vec2>| {
            let mut inside = false;
            for (i, &q) in outline.iter().enumerate() {
                let p = outline[(i + outline.len() - 1) % outline.len()] * 8 - point;
                let q = q * 8 - point;
                let side = p.perp_dot(q);
                if side == 0 && p.dot(q) <= 0 {
                    return false;
                }
                inside ^= (p.y > 0) != (q.y > 0) && (side > 0) == (q.y > p.y);
            }
            inside
        };
        (0..).zip(&self.outlines).filter(|(_, outline)| holds(outline)).map(|(id, _)| id).collect()
    }

    fn set<S: Scalar>(&self, place: impl Fn(I64Vec2) -> DVec3) -> MixedSet<S> {
        let mut set = MixedSetBuilder::<S>::default();
        for outline in &self.outlines {
            set.polygon(&outline.iter().map(|&p| place(p)).collect::<Vec<_>>()).unwrap();
        }
        set.finish()
    }

    /// A point of the tiling in eighths: a vertex, a point of an edge, or any.
    fn point(&self, random: &mut Random) -> I64Vec2 {
        let outline = random.one_of(&self.outlines.iter().collect::<Vec<_>>());
        let i = (random.unit() * outline.len() as f64) as usize;
        let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
        let k = random.one_of(&[0, 0, 1, 4, 7]);
        if random.unit() < 0.8 {
            p * 8 + (q - p) * k
        } else {
            (dvec3(random.unit(), random.unit(), 0.0) * 128.0 * SIDE as f64).truncate().as_i64vec2()
        }
    }
}

/// The ids whose tests the line of the ray passes, whatever the parameter.
fn met<S: Scalar>(set: &MixedSet<S>, ray: &Ray<S>) -> Vec<u32> {
    let ray = Ray { t_min: -S::INFINITY, ..*ray };
    let setup = set.setup(&ray);
    let is_met = |id: &u32| set.intersect(*id, &ray, &setup, S::INFINITY).is_some();
    (0..set.len() as u32).filter(is_met).collect()
}

/// The test as it was: an upward edge counts at x > 0, a downward one at x >= 0, so that neighbours
/// of one winding refuse their edge both. Rays along the z axis, whole numbers.
fn old_rule(outline: &[I64Vec2], point: I64Vec2) -> bool {
    let mut inside = false;
    for (i, &q) in outline.iter().enumerate() {
        let p = outline[(i + outline.len() - 1) % outline.len()] * 8 - point;
        let q = q * 8 - point;
        let is_right = (p.perp_dot(q) > 0) == (q.y > p.y);
        inside ^= (p.y > 0) != (q.y > 0) && is_right;
    }
    inside
}

fn tilings_have_no_gaps<S: Scalar>() {
    let mut random = Random::new(11);
    let planes = [
        [dvec3(1.0, 0.0, 0.0), dvec3(0.0, 1.0, 0.0)],
        [dvec3(1.0, 2.0, -1.0), dvec3(0.0, 1.0, 3.0)],
        [dvec3(0.0, -3.0, 1.0), dvec3(2.0, 1.0, 1.0)],
    ];
    let (mut asked, mut within, mut leaks) = (0, 0, 0);
    for round in 0..12 {
        let with_triangles = round % 2 == 1;
        let tiling = Tiling::new(&mut random, with_triangles);
        let [u, v] = planes[round % 3];
        let eighths = |p: I64Vec2| u * (p.x as f64 / 8.0) + v * (p.y as f64 / 8.0);
        let set = tiling.set::<S>(|p| eighths(p * 8));
        for _ in 0..1500 {
            let point = tiling.point(&mut random);
            if point.min_element() <= 0 || point.max_element() >= 128 * SIDE as i64 {
                continue;
            }
            let off = (random.signed() * 300.0).round();
            if off.dot(u.cross(v)) == 0.0 {
                continue;
            }
            let met = met(&set, &Ray::<S>::from_dvec3(eighths(point) + off, -off));
            let holders = tiling.holders(point);
            assert!(!met.is_empty(), "{} {round} {point} from {off}", S::NAME);
            assert!(with_triangles || met.len() == 1, "{} {round} {point}: {met:?}", S::NAME);
            assert!(holders.is_empty() || met == holders, "{round} {point}: {met:?} {holders:?}");
            within += usize::from(!holders.is_empty());
            asked += 1;
            leaks += usize::from(tiling.outlines.iter().all(|outline| !old_rule(outline, point)));
        }
    }
    assert!(asked > 10_000 && within > 1000 && leaks > 500, "{asked} {within} {leaks}");
}

#[test]
fn tilings_have_no_gaps_in_f32() {
    tilings_have_no_gaps::<f32>();
}

#[test]
fn tilings_have_no_gaps_in_f64() {
    tilings_have_no_gaps::<f64>();
}

/// A closed box of n n quadrilaterals a side, each wound at random, and its vertices.
fn closed_box(random: &mut Random, n: usize) -> (Vec<[DVec3; 4]>, Vec<DVec3>) {
    let rotation = random.rotation();
    let shift = random.signed() * random.one_of(&[0.0, 0.3, 40.0]);
    let size = random.signed() + dvec3(2.0, 2.0, 2.0);
    let mut faces = Vec::new();
    let bump = random.one_of(&[0.0, 0.0, 0.3]);
    let place = |p: [usize; 3]| {
        let at = DVec3::from_array(p.map(|x| x as f64 / n as f64)) - 0.5;
        // the same for each face that has the vertex; quadrilaterals are not planar then
        let out = 1.0 + bump * (at.x * 17.0 + at.y * 31.0 + at.z * 57.0).sin();
        rotation * (at * out * size) + shift
    };
    for axis in 0..3 {
        for (i, j, end) in (0..n * n * 2).map(|k| (k / 2 / n, k / 2 % n, k % 2 * n)) {
            let mut face = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
                let mut p = [0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (end, i + a, j + b);
                place(p)
            });
            face.rotate_left((random.unit() * 4.0) as usize);
            if random.unit() < 0.5 {
                face.reverse();
            }
            faces.push(face);
        }
    }
    let mut vertices = faces.concat();
    vertices.push(place([n; 3]));
    (faces, vertices)
}

/// Rays at the vertices and edges of a box, from within it and from elsewhere; those from within
/// first, so many.
fn rays_at_box<S: Scalar>(
    random: &mut Random,
    faces: &[[DVec3; 4]],
    n: usize,
) -> (Vec<Ray<S>>, usize) {
    let center = faces.iter().flatten().sum::<DVec3>() / (4 * faces.len()) as f64;
    let rays = (0..n).map(|i| {
        let face = random.one_of(faces);
        let k = (random.unit() * 4.0) as usize;
        let between = random.one_of(&[0.0, 0.0, 0.5, 0.37]);
        let target = face[k].lerp(face[(k + 1) % 4], between);
        let origin = if i < n / 2 {
            center + random.signed() * 0.1 * random.one_of(&[0.0, 1.0])
        } else {
            // in the plane of a face, or anywhere
            match i % 3 {
                0 => target + (face[(k + 2) % 4] - face[k]) * (random.unit() - 0.5) * 9.0,
                _ => target + random.signed() * 6.0,
            }
        };
        Ray::from_dvec3(origin, target - origin)
    });
    (rays.collect(), n / 2)
}

fn closed_bodies_are_crossed_an_even_number_of_times<S: Buildable>() {
    let mut random = Random::new(12);
    let mut crossings = 0;
    for round in 0..40 {
        let n = [1, 1, 2, 5][round % 4];
        let (faces, _) = closed_box(&mut random, n);
        let mut set = MixedSetBuilder::<S>::default();
        for (i, [a, b, c, d]) in faces.iter().copied().enumerate() {
            // triangles beside polygons
            if round % 5 == 4 && i % 3 == 0 {
                set.triangle([a, b, c]).unwrap();
                set.triangle([a, c, d]).unwrap();
            } else {
                set.polygon(&[a, b, c, d]).unwrap();
            }
        }
        let set = set.finish();
        let (rays, within) = rays_at_box::<S>(&mut random, &faces, 800);
        for (i, ray) in rays.iter().enumerate() {
            let met = met(&set, ray);
            let is_closed = round % 5 == 4 || met.len() % 2 == 0;
            assert!(is_closed, "{} {round}: {ray:?} {met:?}", S::NAME);
            let setup = set.setup(ray);
            let is_ahead = |&&id: &&u32| set.intersect(id, ray, &setup, S::INFINITY).is_some();
            let ahead = met.iter().filter(is_ahead).count();
            assert!(i >= within || ahead > 0, "{} {round}: {ray:?} escapes", S::NAME);
            crossings += met.len();
        }
        if round % 4 == 0 {
            let wrong = mismatches(REGISTRY, "box", PrimsRef::Mixed(&set), &rays);
            assert!(wrong.is_empty(), "{} {wrong:#?}", S::NAME);
        }
    }
    assert!(crossings > 40_000, "{crossings}");
}

#[test]
fn closed_bodies_are_crossed_an_even_number_of_times_in_f32() {
    closed_bodies_are_crossed_an_even_number_of_times::<f32>();
}

#[test]
fn closed_bodies_are_crossed_an_even_number_of_times_in_f64() {
    closed_bodies_are_crossed_an_even_number_of_times::<f64>();
}

/// By how much the point of a hit lies outside of the box of its primitive, in epsilons of the
/// set's largest coordinate.
fn outside<S: Scalar>(set: &MixedSet<S>, ray: &Ray<S>, id: u32, t: S) -> f64 {
    let bounds = set.bounds(id);
    let (lo, hi) = (bounds.min.to_dvec3(), bounds.max.to_dvec3());
    let p = ray.origin.to_dvec3() + ray.direction.to_dvec3() * t.to_f64();
    (lo - p).max(p - hi).max_element() / (S::EPSILON * set.magnitude()).to_f64()
}

/// The padding of boxes has so many epsilons for the point of a hit.
const MOST_OUTSIDE: f64 = 42.0;

/// Rays along a plane of tiles, at all angles below a tenth.
fn hits_lie_within_their_polygon<S: Buildable>() {
    let mut random = Random::new(13);
    let (mut hits, mut planted) = (0, 0);
    for round in 0..16 {
        let tiling = Tiling::new(&mut random, false);
        let rotation = random.rotation();
        let shift = random.signed() * random.one_of(&[0.0, 0.0, 100.0]);
        let bent = random.one_of(&[0.0, 0.0, 2.0]);
        let place = |p: I64Vec2| {
            let up = bent * (p.x as f64 * 7.0 + p.y as f64 * 3.0).sin();
            rotation * dvec3(p.x as f64 - 64.0, p.y as f64 - 64.0, up) + shift
        };
        let set = tiling.set::<S>(place);
        let normal = rotation * DVec3::Z;
        let rays: Vec<Ray<S>> = (0..400)
            .map(|_| {
                let point = tiling.point(&mut random);
                let target = place(point / 8);
                let turn = random.unit() * 7.0;
                let along = rotation * dvec3(turn.cos(), turn.sin(), 0.0);
                let angle = random.one_of(&[0.0, 1e-8, 3e-8, 1e-6, 1e-4, 1e-3, 1e-2, 0.1]);
                let way = (along + normal * angle) * random.one_of(&[3.0, 40.0, 90.0, 300.0]);
                let mut ray =
                    Ray::<S>::from_dvec3(target - way, way * random.one_of(&[1.0, 0.03, 20.0]));
                ray.t_min = S::from_f64(random.one_of(&[0.0, 0.0, -30.0]));
                ray
            })
            .collect();
        for ray in &rays {
            let setup = set.setup(ray);
            for (id, outline) in (0..).zip(&tiling.outlines) {
                let Some(t) = set.intersect(id, ray, &setup, S::INFINITY) else { continue };
                hits += 1;
                let off = outside(&set, ray, id, t);
                assert!(off <= MOST_OUTSIDE, "{} {round} {ray:?} {id} {t}: {off}", S::NAME);
                // planted fault: the parameter of the plane
                let n = Vec3::<S>::from_dvec3(normal);
                let anchor = Vec3::<S>::from_dvec3(place(outline[0]));
                let of_plane = n.dot(anchor - ray.origin) / n.dot(ray.direction);
                let off = outside(&set, ray, id, of_plane);
                planted += usize::from(off.is_nan() || off > MOST_OUTSIDE);
            }
        }
        let wrong = mismatches(REGISTRY, "tiles", PrimsRef::Mixed(&set), &rays);
        assert!(wrong.is_empty(), "{} {round} {wrong:#?}", S::NAME);
    }
    assert!(hits > 5000 && planted > 100, "{hits} {planted}");
}

#[test]
fn hits_lie_within_their_polygon_in_f32() {
    hits_lie_within_their_polygon::<f32>();
}

#[test]
fn hits_lie_within_their_polygon_in_f64() {
    hits_lie_within_their_polygon::<f64>();
}

/// Share of the square from -1 to 1 that an outline covers, by rays of a lattice.
fn covered(outline: &[DVec3], lattice: usize) -> f64 {
    let mut set = MixedSetBuilder::<f32>::default();
    set.polygon(outline).unwrap();
    let set = set.finish();
    let at = |i: usize| (i as f64 + 0.5) / lattice as f64 * 2.0 - 1.0;
    let hits = (0..lattice * lattice)
        .filter(|i| {
            let ray = Ray::from_dvec3(dvec3(at(i / lattice), at(i % lattice), 3.0), -DVec3::Z);
            !met(&set, &ray).is_empty()
        })
        .count();
    hits as f64 / (lattice * lattice) as f64
}

#[test]
fn outlines_that_cross_themselves_have_their_area() {
    let corner = |x: f64, y: f64| dvec3(x, y, 0.0);
    let bow_tie = [corner(-1.0, -1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, 1.0)];
    assert!((covered(&bow_tie, 100) - 0.5).abs() < 0.02, "{}", covered(&bow_tie, 100));
    // a square with a square hole, by a bridge along the lattice of rays
    let hole = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(0.5, 0.5),
        corner(0.5, -0.5),
        corner(-0.5, -0.5),
        corner(-0.5, 0.5),
        corner(0.5, 0.5),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    for turned in 0..hole.len() {
        let mut outline = hole;
        outline.rotate_left(turned);
        assert_eq!(covered(&outline, 100), 0.75, "{turned}");
        outline.reverse();
        assert_eq!(covered(&outline, 100), 0.75, "{turned}");
    }
}
