//! Trees of obvhs's presets whose answers are right, `wide-bvh` and `obvhs-cwbvh adapter=robust`:
//! intervals at negative t, rays within planes of triangles, and scenes whose trees are deep. The
//! answers are those of brute force.

use crate::agreement::{Answers, agreed};
use crate::common::{Random, squares, triangle_set};
use accel_core::Ray;
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{TriangleSet, Watertight};
use accel_core::registry::Buildable;
use accel_core::structures::find;
use glam::{DQuat, DVec3, dvec3};

/// Rows over such trees.
const ROWS: [(&str, &str); 2] = [("wide-bvh", ""), ("obvhs-cwbvh", "adapter=robust")];
const PRESETS: [&str; 6] = ["fastest", "very-fast", "fast", "medium", "slow", "very-slow"];

type Corners = [DVec3; 3];

fn set<S: Buildable>(triangles: &[Corners]) -> TriangleSet<S, Watertight> {
    triangle_set(triangles.iter().copied(), |id| id % 5 == 0)
}

/// All presets of both rows.
fn all_right<S: Buildable>(what: &str, triangles: &[Corners], rays: &[Ray<S>]) {
    let of = |(name, settings): (&'static str, &str)| {
        PRESETS.map(|preset| (name, format!("{settings} preset={preset}")))
    };
    let tested: Vec<_> = ROWS.into_iter().flat_map(of).collect();
    agreed(what, PrimsRef::Watertight(&set::<S>(triangles)), rays, 50, &tested);
}

/// A sphere of radius 1 around `centre`: an icosahedron whose triangles are divided into four
/// `levels` times.
fn icosphere(levels: usize, centre: DVec3) -> Vec<Corners> {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let corner = |i: usize| {
        let (a, b) = ([1.0, -1.0][i & 1], [g, -g][i >> 1 & 1]);
        [dvec3(0.0, a, b), dvec3(a, b, 0.0), dvec3(b, 0.0, a)][i >> 2].normalize()
    };
    // three corners that are neighbours of each other make a face
    let near = |a: DVec3, b: DVec3| a.distance(b) < 1.1;
    let mut faces: Vec<Corners> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let t = [a, b, c].map(corner);
                if near(t[0], t[1]) && near(t[1], t[2]) && near(t[2], t[0]) {
                    faces.push(t);
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces.iter().map(|t| t.map(|p| p + centre)).collect()
}

/// Rays around and within a sphere of radius 1 at `centre`, at intervals that begin before the
/// origin.
fn backward_rays<S: Buildable>(n: usize, centre: DVec3, random: &mut Random) -> Vec<Ray<S>> {
    (0..n)
        .map(|i| {
            let reach = [0.5, 1.5, 4.0, 20.0][i % 4];
            let origin = centre + random.signed() * reach;
            let mut direction = match i % 5 {
                0 => centre + random.signed() * 0.7 - origin,
                1 => [DVec3::X, -DVec3::Y, DVec3::Z][i % 3],
                _ => random.signed(),
            };
            direction *= [1.0, 0.01, 30.0][i % 3];
            let mut ray = Ray::<S>::from_dvec3(origin, direction);
            let (t_min, t_max) = match i % 7 {
                0..3 => (-2.0, f64::INFINITY),
                3 => (-2.0, -0.1),
                4 => (-1e30, 0.0),
                5 => (f64::NEG_INFINITY, f64::INFINITY),
                _ => (-3.0 * random.unit(), 3.0 * random.unit()),
            };
            (ray.t_min, ray.t_max) = (S::from_f64(t_min), S::from_f64(t_max));
            ray
        })
        .collect()
}

fn negative_intervals<S: Buildable>() {
    let mut random = Random::new(1);
    for centre in [DVec3::ZERO, dvec3(40.0, -3.0, 7.0)] {
        let sphere = icosphere(4, centre);
        let rays = backward_rays::<S>(6000, centre, &mut random);
        all_right("negative t", &sphere, &rays);
        // each hit alone, at an interval of no length
        let set = set::<S>(&sphere);
        let expected = Answers::expected(PrimsRef::Watertight(&set), &rays);
        let hits = rays.iter().zip(&expected.hits).filter(|(_, hit)| hit.is_hit());
        let alone: Vec<_> = hits.map(|(r, h)| Ray { t_min: h.t, t_max: h.t, ..*r }).collect();
        all_right("one t", &sphere, &alone);
    }
}

#[test]
fn intervals_may_begin_before_the_origin_in_f32() {
    negative_intervals::<f32>();
}

#[test]
fn intervals_may_begin_before_the_origin_in_f64() {
    negative_intervals::<f64>();
}

#[test]
fn wrong_hits_of_unmodified_obvhs_in_negative_intervals_are_caught() {
    // planted fault: the library as it is
    let sphere = icosphere(4, DVec3::ZERO);
    let rays: Vec<Ray<f32>> = backward_rays(1500, DVec3::ZERO, &mut Random::new(2));
    let set = set(&sphere);
    let expected = Answers::expected(PrimsRef::Watertight(&set), &rays);
    for name in ["obvhs-bvh2", "obvhs-cwbvh"] {
        let entry = find(name).unwrap();
        assert!((entry.info.known_defect)(&entry.defaults()).is_some());
        let tracer = entry.build(PrimsRef::Watertight(&set), &entry.defaults()).unwrap();
        let n = Answers::of(&*tracer, &rays, &expected).differing(&expected).len();
        assert!(n > 100, "{name}: {n}");
    }
}

/// Spheres in one another: octahedra, each a little larger than the last.
fn shells(n: usize) -> Vec<Corners> {
    (0..n)
        .flat_map(|k| {
            let r = 1.0 + k as f64 / n as f64;
            (0..8).map(move |octant| {
                let side = |axis: usize| if octant >> axis & 1 == 1 { r } else { -r };
                [DVec3::X * side(0), DVec3::Y * side(1), DVec3::Z * side(2)]
            })
        })
        .collect()
}

/// Rays between shells of radius 1 to 2, from within and from without.
fn shell_rays<S: Buildable>(n: usize) -> Vec<Ray<S>> {
    let mut random = Random::new(3);
    let ray = |i: usize| {
        let origin = random.signed() * [0.2, 1.0, 3.0][i % 3];
        Ray::from_dvec3(origin, random.signed() - origin * f64::from(i.is_multiple_of(2)))
    };
    (0..n).map(ray).collect()
}

#[test]
fn nested_shells_are_served() {
    // 12,000 triangles, whose agglomeration is 1,500 levels deep; more than 4,096 boxes
    all_right("1,500 shells", &shells(1500), &shell_rays::<f32>(400));
    all_right("1,500 shells", &shells(1500)[..1500], &shell_rays::<f64>(400));
}

#[test]
fn twenty_thousand_nested_shells_are_served() {
    // one side of each, so that all boxes lie in one another
    let sides: Vec<Corners> = shells(20_000).into_iter().skip(7).step_by(8).collect();
    all_right("20,000 shells", &sides, &shell_rays::<f32>(300));
}

/// A square of `2 n n` triangles in a plane turned at random, with rays within that plane: what is
/// left of the plane after rounding decides which triangles they hit, and where.
fn in_plane<S: Buildable>(n: usize, random: &mut Random) -> (Vec<Corners>, Vec<Ray<S>>) {
    let axis = random.signed().normalize_or(DVec3::X);
    let turn = DQuat::from_axis_angle(axis, random.unit() * 6.0);
    let place = |x: f64, y: f64| turn * dvec3(x - 0.5, y - 0.5, 0.3);
    let corner = |i: usize, j: usize| place(i as f64 / n as f64, j as f64 / n as f64);
    let triangles = squares(n, n, corner);
    let rays = (0..2000).map(|i| {
        let whole = |x: f64| (x * n as f64).round() / n as f64;
        let (mut x, mut y) = (3.0 * random.unit() - 1.0, 3.0 * random.unit() - 1.0);
        let (mut u, mut v) = (random.unit(), random.unit());
        if i % 2 == 0 {
            // through corners
            [x, y, u, v] = [x, y, u, v].map(whole);
        }
        let origin = place(x, y);
        Ray::from_dvec3(origin, place(u, v) - origin)
    });
    (triangles, rays.filter(Ray::is_traceable).collect())
}

/// Rays in planes of triangles: equal parameters everywhere, and the lowest id is the answer.
fn rays_in_planes<S: Buildable>() {
    let mut random = Random::new(4);
    for n in [1, 5, 16, 40, 64] {
        for _ in 0..3 {
            let (triangles, rays) = in_plane::<S>(n, &mut random);
            all_right("in a plane", &triangles, &rays);
        }
    }
}

#[test]
fn rays_within_planes_of_triangles_hit_the_lowest_id_in_f32() {
    rays_in_planes::<f32>();
}

#[test]
fn rays_within_planes_of_triangles_hit_the_lowest_id_in_f64() {
    rays_in_planes::<f64>();
}
