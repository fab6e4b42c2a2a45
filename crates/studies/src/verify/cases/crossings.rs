//! Closed meshes crossed from outside: a ray that comes from outside and goes on for ever crosses a
//! closed surface an even number of times. No oracle is needed.
//!
//! What is exactly true, and so demanded. The watertight test moves every corner into a plane
//! across the ray, by the same arithmetic in each of the triangles that share it, and then finds by
//! exact signs which triangles hold the plane's origin. What is tested is thus a closed mesh in the
//! plane, and its map covers almost every point of the plane by an even number of triangles (its
//! degree modulo 2 is 0). Where the origin lies on an edge or a corner, all triangles that touch it
//! are hit, and their number says nothing. So the origin is thought of as moved by an infinitely
//! small step in x and by one infinitely smaller still in y (H. Edelsbrunner, E. P. Muecke,
//! "Simulation of Simplicity", 1990), and the triangles that are hit and hold the moved point are
//! counted. That number is even, always; when a test loses a triangle or finds one too many, it is
//! odd.
//!
//! A structure's own crossings follow by a chain: the interval begins anew just after each hit. A
//! chain sees one triangle of those at equal parameters, that of the lowest id.

use robust::{Coord, orient2d};

use super::*;
use crate::verify::meshes::{Cubes, cube, torus};

/// Links of a chain that are asked.
const LINKS: usize = 60;

pub fn crossings<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let side = one_of(random, &[2.0, 3.0, 4.0]);
    let kind = random.below(4);
    let is_lattice = kind == 3;
    // origins lie outside, and near enough to be left there (8 times the largest coordinate)
    let (middle, size) = match kind {
        3 => (DVec3::splat(side / 2.0), side),
        _ => (DVec3::ZERO, 2.0),
    };
    let mesh: Vec<Corners> = match kind {
        0 => icosphere(2, DVec3::ZERO),
        1 => icosphere(2, DVec3::ZERO).iter().map(|t| t.map(bumped)).collect(),
        2 => torus(20, 8),
        _ => {
            let cubes = Cubes { side: side as i32, is_solid: random.below(2) == 0 };
            cubes.all().flat_map(cube).collect()
        }
    };
    Ok(Round::new(model_of::<S>(&mesh)?).filled(rays, |round| {
        let target = match random.below(3) {
            0 => point_within(random, &mesh),
            _ => on_edge(random, &mesh),
        };
        let ray = if is_lattice && random.below(2) == 0 {
            // through corners and edges of many cubes, exactly
            let d = DVec3::from([(); 3].map(|()| random_integer(random, 2)));
            ray(target - d * (side + 1.0), d)
        } else {
            let origin = single(middle + direction(random) * (size + 3.0 * unit(random)));
            ray(origin, target - origin)
        };
        push_hits(round, ray, LINKS, |model, hits| {
            let times = crossed(model, &ray, hits);
            (times % 2 == 1).then(|| format!("a closed mesh is crossed {times} times"))
        });
    }))
}

/// A point of the unit sphere, moved out or in.
fn bumped(p: DVec3) -> DVec3 {
    single(p * (1.0 + 0.3 * (p.x * 7.0).sin() * (p.y * 5.0 + p.z * 9.0).cos()))
}

/// Number of these triangles that contain the origin of the plane across the ray, moved a little.
fn crossed<S: Buildable>(model: &Geometry<S>, ray: &Ray<S>, hits: &[Hit<S>]) -> usize {
    let Geometry::Triangles(set) = model else { return 0 };
    let hit = hits.iter().filter_map(|hit| set.triangles().get(hit.id as usize));
    hit.filter(|triangle| holds_moved_origin(triangle.each_ref().map(|p| sheared(ray, p)))).count()
}

/// A corner in the plane across the ray, as the watertight test computes it.
fn sheared<S: Scalar>(ray: &Ray<S>, p: &[S; 3]) -> Coord<f64> {
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    let [ax, ay, az] = d.map(S::abs);
    let (x, y, z) = if ax > ay && ax > az {
        (1, 2, 0)
    } else if ay > az && ay >= ax {
        (2, 0, 1)
    } else {
        (0, 1, 2)
    };
    let inverse = S::ONE / d[z];
    let depth = p[z] - o[z];
    let at = |k: usize| ((p[k] - o[k]) - d[k] * inverse * depth).to_f64();
    Coord { x: at(x), y: at(y) }
}

/// Returns whether the triangle holds the origin after a step in x and a far smaller one in y.
fn holds_moved_origin([a, b, c]: [Coord<f64>; 3]) -> bool {
    let side = |p: Coord<f64>, q: Coord<f64>| {
        let exact = orient2d(p, q, Coord { x: 0.0, y: 0.0 });
        // on the edge: how that changes with x, then with y
        let moved = [exact, p.y - q.y, q.x - p.x];
        moved.into_iter().find(|s| *s != 0.0).map_or(0, |s| if s > 0.0 { 1 } else { -1 })
    };
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides[0] != 0 && sides.iter().all(|s| *s == sides[0]) && orient2d(a, b, c) != 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exactly_one_triangle_around_a_corner_holds_the_moved_origin() {
        let coord = |x: f64, y: f64| Coord { x, y };
        for many in [3, 4, 6, 8, 12] {
            let rim: Vec<_> = (0..many)
                .map(|i| (f64::from(i) / f64::from(many) * std::f64::consts::TAU).sin_cos())
                .map(|(y, x)| coord((x * 8.0).round(), (y * 8.0).round()))
                .collect();
            let around = (0..rim.len()).map(|i| [coord(0., 0.), rim[i], rim[(i + 1) % rim.len()]]);
            assert_eq!(around.filter(|t| holds_moved_origin(*t)).count(), 1, "{many}");
        }
        let [left, right] = [coord(-1.0, 0.0), coord(1.0, 0.0)];
        assert!(holds_moved_origin([left, right, coord(0.0, 1.0)]));
        assert!(!holds_moved_origin([left, right, coord(0.0, -1.0)]));
        assert!(!holds_moved_origin([left, right, coord(3.0, 0.0)]));
    }

    #[test]
    fn a_lost_triangle_breaks_the_parity_of_crossings() {
        let mesh = torus(20, 8);
        let model = model_of::<f32>(&mesh).unwrap();
        let mut crossings = 0;
        let random = &mut Random::new(1, "crossings");
        for _ in 0..300 {
            let target = on_edge(random, &mesh);
            let origin = single(direction(random) * 9.0);
            let ray: Ray<f32> = ray(origin, target - origin);
            let hits = every_hit(&model, &ray);
            let all = crossed(&model, &ray, &hits);
            assert_eq!(all % 2, 0, "{ray:?}");
            crossings += all;
            for lost in 0..hits.len() {
                let mut some = hits.clone();
                some.remove(lost);
                // unless the neighbour at its edge holds the point
                let left = crossed(&model, &ray, &some);
                assert!(left + 1 == all || left == all);
            }
        }
        assert!(crossings > 600);
    }
}
