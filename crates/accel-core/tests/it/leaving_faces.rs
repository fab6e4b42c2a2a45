//! Rays that start on a face, or a few ulps beside it: `wide-bvh` leaves out boxes that end behind
//! a ray's origin, and does not pad them for what rounding may do to a hit elsewhere. Its answers
//! must be those of brute force all the same.

use accel_core::primitives::PrimsRef;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Vec3, Vector};
use glam::DVec3;

use crate::agreement::agreed;
use crate::common::{Random, triangle_set};

/// One of these powers of ten, evenly by logarithm.
fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(low + (high - low) * random.unit())
}

/// A triangle of two edges along axes, the longer of which passes a point that may be close to the
/// origin of coordinates: there a ray starts so near the edge that no corner tells it from one that
/// starts on the edge.
fn square_face(random: &mut Random) -> [DVec3; 3] {
    let mut axes = [0, 1, 2];
    axes.rotate_left((random.unit() * 3.0) as usize);
    let a = random.signed() * power(random, -8.0, 0.0);
    let (mut along, mut across) = (DVec3::ZERO, DVec3::ZERO);
    along[axes[0]] = power(random, -2.0, 0.0);
    across[axes[1]] = random.signed().x;
    let part = random.unit();
    [a - along * part, a + along * (1.0 - part), a + across]
}

/// Triangles of sizes 1e-4 to 1, some of them flat on an axis, some up to 10^4 times as long as
/// wide.
fn faces(random: &mut Random, count: usize) -> Vec<[DVec3; 3]> {
    let mut face = || {
        if random.unit() < 0.3 {
            return square_face(random).map(|p| p.as_vec3().as_dvec3());
        }
        let a = random.signed();
        let size = power(random, -4.0, 0.0);
        let wide = if random.unit() < 0.3 { power(random, -4.0, 0.0) } else { 1.0 };
        let mut edges = [random.signed() * size, random.signed() * size * wide];
        let axis = (random.unit() * 6.0) as usize;
        if axis < 3 {
            edges.iter_mut().for_each(|e| e[axis] = 0.0);
        }
        [a, a + edges[0], a + edges[1]].map(|p| p.as_vec3().as_dvec3())
    };
    (0..count).map(|_| face()).collect()
}

/// From a face, or up to 64 ulps beside it, in any direction, or nearly along the face, or along an
/// axis but for tiny components.
fn rays<S: Buildable>(random: &mut Random, faces: &[[DVec3; 3]], count: usize) -> Vec<Ray<S>> {
    let mut ray = || {
        let [a, b, c] = faces[(random.unit() * faces.len() as f64) as usize];
        let [u, v] = [random.unit(), random.unit()].map(|x| if x < 0.1 { 0.0 } else { x });
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let normal = (b - a).cross(c - a).normalize_or(DVec3::X);
        let side = random.unit() - 0.5;
        let off = side.signum() * 2.0 * side.abs() * power(random, -7.0, -5.2);
        let mut d = random.signed();
        match (random.unit() * 4.0) as u32 {
            0 => d = d.reject_from(normal) + normal * power(random, -7.0, -1.0) * side,
            1 => {
                let axis = (random.unit() * 3.0) as usize;
                let long = d[axis].signum();
                d *= power(random, -30.0, -2.0);
                d[axis] = long;
            }
            _ => {}
        }
        if random.unit() < 0.1 {
            d *= power(random, -15.0, 15.0);
        }
        let beside = if random.unit() < 0.5 {
            normal * off
        } else {
            random.signed() * power(random, -10.0, -6.0)
        };
        let o = a + (b - a) * u + (c - a) * v + beside;
        let far =
            if random.unit() < 0.1 { d.normalize_or(DVec3::X) * 9.0 * side } else { DVec3::ZERO };
        let mut ray = Ray::<S>::from_dvec3(o + far, d);
        if random.unit() < 0.1 {
            ray.t_min = S::from_f64(side * 1e-5);
        }
        ray
    };
    (0..count).map(|_| ray()).collect()
}

/// Every other ray in a batch of eight nearly parallel rays.
fn in_batch<S: Buildable>(random: &mut Random, rays: Vec<Ray<S>>) -> Vec<Ray<S>> {
    let mut all = Vec::new();
    for (i, ray) in rays.into_iter().enumerate() {
        if i % 16 < 8 {
            all.push(ray);
            continue;
        }
        let apart = power(random, -8.0, -1.0);
        let place = (random.unit() * 8.0) as usize;
        for other in 0..8 {
            let mut near = |v: Vec3<S>, size: f64| {
                let off = random.signed() * size;
                Vec3::<S>::from_dvec3(v.to_dvec3() * (DVec3::ONE + off))
            };
            let moved = Ray {
                origin: near(ray.origin, apart),
                direction: near(ray.direction, apart),
                ..ray
            };
            all.push(if other == place { ray } else { moved });
        }
    }
    all
}

/// Rays by how they are answered: hits, and hits within 2^-16.
fn hits_of_agreed_rounds<S: Buildable>(rounds: u64) -> [usize; 2] {
    let rows = [
        ("wide-bvh", ""),
        ("wide-bvh", "query=batch"),
        ("wide-bvh", "query=packets"),
        ("wide-bvh", "max-leaf=1"),
        ("obvhs-cwbvh", "adapter=robust"),
    ];
    let mut counts = [0; 2];
    for round in 0..rounds {
        let mut random = Random::new(round + 1);
        let faces = faces(&mut random, 200);
        let set = triangle_set::<S>(faces.iter().copied(), |_| false);
        let rays = rays::<S>(&mut random, &faces, 5_000);
        let rays = in_batch(&mut random, rays);
        let scene = format!("round {round}");
        let expected = agreed(&scene, PrimsRef::Watertight(&set), &rays, rays.len(), &rows).hits;
        counts[0] += expected.iter().filter(|h| h.is_hit()).count();
        let near = |hit: &&Hit<S>| hit.is_hit() && hit.t.abs().to_f64() < 2f64.powi(-16);
        counts[1] += expected.iter().filter(near).count();
    }
    counts
}

#[test]
fn rays_from_faces_are_answered_as_by_brute_force() {
    let single = hits_of_agreed_rounds::<f32>(10);
    let double = hits_of_agreed_rounds::<f64>(3);
    assert!(single[0] > 60_000 && single[1] > 30_000, "{single:?}");
    assert!(double[0] > 15_000 && double[1] > 5_000, "{double:?}");
}
