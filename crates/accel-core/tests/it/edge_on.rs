//! Triangles seen edge-on, and rays with components so small or so large that products of them have
//! few digits: no hit lies beyond its triangle, brute force is right, and all structures agree with
//! it to the last bit.

use accel_core::primitives::PrimsRef;
use accel_core::primitives::{PrimSet, Primitives, TriangleSet, Watertight};
use accel_core::registry::Buildable;
use accel_core::variants::triangle_tests::WatertightFallback;
use accel_core::{Hit, Ray, Scalar, Vector};
use glam::{DVec3, dvec3};

use crate::agreement::{Answers, agreed};
use crate::common::{Random, right_variants, squares, triangle_set};

fn set<S: Scalar>(triangles: &[[DVec3; 3]]) -> TriangleSet<S, Watertight> {
    triangle_set(triangles.iter().copied(), |_| false)
}

/// A lattice of 2 n n triangles over the square from 0 to n in x and z, at y = 0.
fn lattice(n: usize) -> Vec<[DVec3; 3]> {
    squares(n, n, |x, z| dvec3(x as f64, 0.0, z as f64))
}

/// The answers of brute force, after all structures were compared with them.
fn agreed_by_all<S: Buildable>(set: &TriangleSet<S>, rays: &[Ray<S>]) -> Vec<Hit<S>> {
    let tested: Vec<_> = right_variants().chain([("irregular-grid", "query=batch")]).collect();
    let Answers { hits, blocked } =
        agreed("", PrimsRef::Watertight(set), rays, 2 * rays.len(), &tested);
    assert!(hits.iter().map(Hit::is_hit).eq(blocked));
    hits
}

fn brute_force<S: Buildable>(set: &TriangleSet<S>, rays: &[Ray<S>]) -> Vec<Hit<S>> {
    Answers::expected(PrimsRef::Watertight(set), rays).hits
}

/// By how much the point of a hit lies outside of its triangle's box, in epsilons of the set's
/// largest coordinate.
fn outside<S: Scalar>(set: &TriangleSet<S>, ray: &Ray<S>, hit: &Hit<S>) -> f64 {
    let bounds = set.bounds(hit.id);
    let (lo, hi) = (bounds.min.to_dvec3(), bounds.max.to_dvec3());
    let p = ray.origin.to_dvec3() + ray.direction.to_dvec3() * hit.t.to_f64();
    (lo - p).max(p - hi).max_element() / (S::EPSILON * set.magnitude()).to_f64()
}

/// No hit of rays from within three magnitudes may be so far outside.
const MOST_OUTSIDE: f64 = 32.0;

/// Rays within the plane of a rotated lattice, or off it by an ulp or so.
fn within_a_plane<S: Scalar>(random: &mut Random) -> (TriangleSet<S>, Vec<Ray<S>>) {
    let rotation = random.rotation();
    let shift = random.signed() * random.one_of(&[0.0, 3.0]);
    let at = |p: DVec3| rotation * (p - dvec3(9.0, 0.0, 9.0)) + shift;
    let mut triangles = lattice(18);
    // large ones in the same plane, and some twice
    triangles.push([dvec3(-3.0, 0.0, -3.0), dvec3(23.0, 0.0, -5.0), dvec3(9.0, 0.0, 31.0)]);
    triangles.push([dvec3(0.0, 0.0, 0.0), dvec3(18.0, 0.0, 0.0), dvec3(18.0, 0.0, 18.0)]);
    triangles.extend_from_within(0..40);
    let set = set::<S>(&triangles.into_iter().map(|t| t.map(at)).collect::<Vec<_>>());
    let ulp = (S::EPSILON * set.magnitude()).to_f64();
    let rays = (0..200).map(|_| {
        let target = at(dvec3(18.0 * random.unit(), 0.0, 18.0 * random.unit()));
        let way = rotation * (random.signed() * dvec3(1.0, 0.0, 1.0));
        let off = random.signed() * ulp * random.one_of(&[0.0, 0.0, 1.0, 8.0]);
        let origin = target - way * random.one_of(&[5.0, 20.0, 40.0]);
        Ray::from_dvec3(origin + off, (target - origin) * random.one_of(&[1.0, 0.01, 300.0]))
    });
    (set, rays.collect())
}

/// Needles with edges of 11.2, 9.7 and 1.4, and rays half a degree off their planes.
fn beside_needles<S: Scalar>(random: &mut Random) -> (TriangleSet<S>, Vec<Ray<S>>) {
    let needle = [DVec3::ZERO, dvec3(11.2, 0.0, 0.0), dvec3(9.72, 0.0, 0.13)];
    let mut placed = Vec::new();
    let mut rays = Vec::new();
    for _ in 0..300 {
        let rotation = random.rotation();
        let shift = random.signed() * 290.0;
        placed.push(needle.map(|p| rotation * p + shift));
        let target = needle[1] * random.unit() + (needle[2] - needle[1]) * random.unit();
        let angle = random.one_of(&[0.0, 1e-7, 0.5_f64.to_radians()]);
        let turn = random.unit() * 7.0;
        let d = dvec3(turn.cos(), angle, turn.sin());
        let origin = target - d * random.one_of(&[20.0, 600.0]);
        rays.push(Ray::from_dvec3(rotation * origin + shift, rotation * d));
    }
    (set(&placed), rays)
}

/// Number of hits of all triangles, and of those outside.
fn counted<S: Scalar, P: PrimSet<S>>(
    set: &TriangleSet<S>,
    tests: &P,
    rays: &[Ray<S>],
) -> [usize; 2] {
    let mut counts = [0; 2];
    for ray in rays {
        let setup = tests.setup(ray);
        for id in 0..set.len() as u32 {
            if let Some(t) = tests.intersect(id, ray, &setup, ray.t_max) {
                counts[0] += 1;
                counts[1] += usize::from(outside(set, ray, &Hit { t, id }) > MOST_OUTSIDE);
            }
        }
    }
    counts
}

fn no_hit_lies_outside<S: Buildable>() {
    let mut random = Random::new(4);
    let mut found = [[0; 2]; 2];
    for round in 0..24 {
        let (set, rays) = if round % 3 == 2 {
            beside_needles::<S>(&mut random)
        } else {
            within_a_plane::<S>(&mut random)
        };
        agreed_by_all(&set, &rays);
        let of_round = counted(&set, &set, &rays);
        // planted fault: a test whose weights are rounding where a triangle is seen edge-on
        let of_planted = counted(&set, set.tested_by::<WatertightFallback>(), &rays);
        for k in 0..2 {
            found[0][k] += of_round[k];
            found[1][k] += of_planted[k];
        }
    }
    assert!(found[0][0] > 5000 && found[0][1] == 0 && found[1][1] > 0, "{found:?}");
}

#[test]
fn no_hit_lies_outside_its_triangle_in_f32() {
    no_hit_lies_outside::<f32>();
}

#[test]
fn no_hit_lies_outside_its_triangle_in_f64() {
    no_hit_lies_outside::<f64>();
}

/// Returns whether the origin, in the plane of the lattice, lies within that triangle or on its
/// border; the products are exact.
fn holds(triangle: &[DVec3; 3], o: DVec3) -> bool {
    let side = |a: DVec3, b: DVec3| (b.x - a.x) * (o.z - a.z) - (b.z - a.z) * (o.x - a.x);
    let [a, b, c] = *triangle;
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// A ray that starts in the plane of a flat scene, and leaves it by a component however small, hits
/// what is at its origin, and nothing else.
fn flat_scenes_are_hit_where_they_are_left<S: Buildable>(components: &[f64]) {
    let mut random = Random::new(5);
    let triangles = lattice(10);
    let set = set::<S>(&triangles);
    let mut rays = Vec::new();
    for i in 0..1500 {
        let coordinate = |random: &mut Random| match i % 3 {
            0 => (10.0 * random.unit()).floor(),
            1 => (160.0 * random.unit()).floor() / 16.0,
            _ => (640.0 * random.unit()).floor() / 16.0 - 15.0,
        };
        let o = dvec3(coordinate(&mut random), 0.0, coordinate(&mut random));
        let length = random.one_of(&[1.0, 1.0, 0.07, 130.0]);
        let mut d = random.signed() * length;
        d.y = random.one_of(components) * random.one_of(&[1.0, -1.0]);
        if i % 4 == 0 {
            d[[0, 2][i / 4 % 2]] = random.one_of(components);
        }
        rays.push(Ray::<S>::from_dvec3(o, d));
    }
    agreed_by_all(&set, &rays);
    // behind the origin, too: zero is rounded to either side
    rays.iter_mut().for_each(|ray| ray.t_min = S::from_f64(-20.0));
    let found = brute_force(&set, &rays);
    let mut at_origin = 0;
    for (ray, hit) in rays.iter().zip(&found) {
        let o = ray.origin.to_dvec3();
        if hit.is_hit() {
            assert!(holds(&triangles[hit.id as usize], o), "{ray:?} {hit:?}");
            assert!(hit.t.to_f64().abs() < 1e-13, "{ray:?} {hit:?}");
            at_origin += 1;
        } else {
            // on the outermost edges either answer is right
            let is_within = [o.x, o.z].iter().all(|x| (1e-9..10.0).contains(x));
            assert!(!is_within, "{ray:?} {hit:?}");
        }
    }
    assert!(at_origin > 300 && at_origin < 1300, "{at_origin}");
    // planted fault: corners in subnormal numbers
    let planted = set.tested_by::<WatertightFallback>();
    let nearest = |ray: &Ray<S>| {
        let setup = planted.setup(ray);
        let of = |id| Some(Hit { t: planted.intersect(id, ray, &setup, ray.t_max)?, id });
        let nearer = |a: Hit<S>, b: Hit<S>| if b.t < a.t { b } else { a };
        (0..set.len() as u32).filter_map(of).reduce(nearer).unwrap_or(Hit::NONE)
    };
    let wrong = rays.iter().zip(&found).filter(|(ray, hit)| nearest(ray) != **hit).count();
    assert!(wrong > 30, "{wrong}");
}

#[test]
fn flat_scenes_and_subnormal_components_in_f32() {
    flat_scenes_are_hit_where_they_are_left::<f32>(&[1e-45, 3e-45, 1e-44, 1e-42, 1e-38, 1e-30]);
}

#[test]
fn flat_scenes_and_subnormal_components_in_f64() {
    flat_scenes_are_hit_where_they_are_left::<f64>(&[5e-324, 1e-323, 1e-320, 1e-308, 1e-300]);
}

/// Rays with one, two or three components multiplied to extreme sizes, and what each would be with
/// the longest component brought to 1, in f64.
fn extreme_rays(random: &mut Random, sizes: &[f64], tilted: bool) -> Vec<(Ray<f32>, Ray<f64>)> {
    let make = |i: usize| {
        let target = random.point() * 10.0;
        let mut origin = random.point() * 30.0 - 10.0;
        let mut d = target - origin;
        let size = random.one_of(sizes);
        if !tilted {
            origin = origin.floor();
            d = d.floor() + 0.5;
        }
        for k in (0..3).filter(|k| [0b001, 0b011, 0b111, 0b110, 0b100][i % 5] >> k & 1 == 1) {
            d[(k + i) % 3] = d[(k + i) % 3] / 32.0 * size;
        }
        let narrow = Ray::<f32>::from_dvec3(origin, d);
        let d = narrow.direction.as_dvec3();
        (narrow, Ray::new(narrow.origin.as_dvec3(), d / d.abs().max_element()))
    };
    (0..1500).map(make).filter(|(ray, _)| ray.is_traceable()).collect()
}

/// Triangles about a lattice of points: nothing that a ray nearly misses in one of two precisions.
fn soup() -> Vec<[DVec3; 3]> {
    let mut random = Random::new(6);
    let all = (0..400).map(|_| {
        let p = random.point() * 10.0;
        [p, p + random.signed() * 2.0, p + random.signed() * 2.0].map(|p| p.as_vec3().as_dvec3())
    });
    all.collect()
}

#[test]
fn components_of_any_size_find_what_the_same_ray_finds_in_f64() {
    let triangles = soup();
    let (narrow, wide) = (set::<f32>(&triangles), set::<f64>(&triangles));
    let mut random = Random::new(7);
    for sizes in [&[1e30, 1e35, 3e38][..], &[1e-45, 1e-42, 1e-38, 1e-30]] {
        let rays = extreme_rays(&mut random, sizes, sizes[0] > 1.0);
        let (ours, theirs): (Vec<_>, Vec<_>) = rays.into_iter().unzip();
        let found = agreed_by_all(&narrow, &ours);
        let right = brute_force(&wide, &theirs);
        let hit = right.iter().filter(|h| h.is_hit()).count();
        assert!(hit > ours.len() / 8, "{hit} of {}", ours.len());
        let mut other = 0;
        for (i, ray) in ours.iter().enumerate() {
            if found[i].id != right[i].id {
                other += 1;
                continue;
            }
            // the parameter is the nearest that f32 has
            let scale = ray.direction.as_dvec3().abs().max_element();
            let t = right[i].t / scale;
            let slack = 3e-5 * t.abs() + 3e-45;
            let is_near = (f64::from(found[i].t) - t).abs() <= slack || t > 3.4e38;
            assert!(!found[i].is_hit() || is_near, "{ray:?} {:?} {t:e}", found[i]);
        }
        // an edge may be met by a ray of one precision and missed by that of the other
        assert!(other <= 3, "{other} of {}", ours.len());
        // planted fault: the test alone, without the lengths brought to a common size
        if sizes[0] > 1.0 {
            let lost = ours.iter().zip(&found).filter(|(ray, hit)| {
                let setup = narrow.setup(ray);
                hit.is_hit() && narrow.intersect(hit.id, ray, &setup, ray.t_max) != Some(hit.t)
            });
            assert!(lost.count() > 10);
        }
    }
}
