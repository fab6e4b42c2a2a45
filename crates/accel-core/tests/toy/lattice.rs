//! All triangles of a lattice, all rays from one lattice to another: what the test in few digits
//! says against integers, and what structures find of it.

use std::ops::ControlFlow;

use super::exact::{Answer, across, answer, height, point};
use super::float::Toy;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::params::config::Settings;
use crate::primitives::{PrimSet, Primitives, TriangleSet, Watertight};
use crate::query::sink::Sink;
use crate::structure::{Structure, StructureInfo};
use crate::structures::{kd_tree, octree, recursive_grid, uniform_grid};

/// Few digits, and yet so many that the padding of boxes, 64 epsilons, is smaller than the scene.
type T = Toy<14>;
type Triangles = TriangleSet<T, Watertight>;

/// Coordinates of corners: none a short fraction, so that all that is computed is rounded; the one
/// in the middle is that of a plane of cells, nearly.
const CORNERS: [f64; 3] = [-0.93, -0.06, 0.81];
/// Coordinates of origins: beyond the scene, up to nearly 8 magnitudes, on it, within it.
const ORIGINS: [f64; 4] = [-7.3, -0.93, 0.33, 2.6];
/// Coordinates that rays aim at: corners, middles of edges, and of faces.
const TARGETS: [f64; 5] = [-0.93, -0.43, -0.06, 0.44, 0.81];

/// What `proofs/` has, in epsilons of the scene's largest coordinate.
const CORNERS_MOVED: f64 = 25.0;
const ACROSS: f64 = 25.0 + 12.1;
const ALONG: f64 = 41.0;

fn grid<const N: usize>(along: [f64; N]) -> Vec<[T; 3]> {
    let at = |i: usize| [i % N, i / N % N, i / (N * N)].map(|k| T::from_f64(along[k]));
    (0..N * N * N).map(at).collect()
}

fn triangles() -> Vec<[[T; 3]; 3]> {
    let corners = grid(CORNERS);
    let n = corners.len();
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
    let all = pairs.flat_map(|(a, b)| (b + 1..n).map(move |c| [a, b, c]));
    all.map(|t| t.map(|i| corners[i])).collect()
}

fn rays() -> Vec<Ray<T>> {
    let vector = Vec3::<T>::from_array;
    let targets = grid(TARGETS);
    let to = |o: [T; 3]| {
        let rays =
            targets.iter().map(move |&target| Ray::new(vector(o), vector(target) - vector(o)));
        rays.filter(Ray::is_traceable)
    };
    grid(ORIGINS).into_iter().flat_map(to).collect()
}

/// Notes what a structure offers up to a parameter.
struct Offered {
    ids: Vec<bool>,
    t_max: T,
}

impl Sink<T> for Offered {
    const COUNTING: bool = false;

    fn t_max(&self) -> T {
        self.t_max
    }

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        ids.iter().for_each(|&id| self.ids[id as usize] = true);
        ControlFlow::Continue(())
    }

    fn elementary_step(&mut self, _: bool) {}

    fn inner_step(&mut self) {}
}

/// How many of those hit a structure does not offer to a ray: on its whole way, and, of every 16th
/// hit, on a way that ends there.
type Lost = Box<dyn Fn(&Ray<T>, &[(u32, T)]) -> usize>;

fn losses<G: Structure<T>>(set: &Triangles, info: &StructureInfo, settings: &str) -> Lost {
    let set_one = |params, word: &str| match word.split_once('=') {
        Some((name, value)) => crate::params::Params::set(params, name, value).unwrap(),
        None => panic!("{word}"),
    };
    let params = settings.split_whitespace().fold(info.defaults(), set_one);
    let built = G::build(set, &Settings::of(&params)).unwrap();
    let count = set.len();
    Box::new(move |ray, hits| {
        let offered = |t_max: T| {
            let mut sink = Offered { ids: vec![false; count], t_max };
            built.traverse(&Ray { t_max, ..*ray }, &mut sink);
            sink.ids
        };
        let all = offered(T::INFINITY);
        let lost = hits.iter().filter(|(id, _)| !all[*id as usize]).count();
        let ends = hits.iter().step_by(16).filter(|(id, t)| !offered(*t)[*id as usize]);
        lost + ends.count()
    })
}

/// The greatest errors seen, in epsilons of the largest coordinate.
#[derive(Default, Debug)]
struct Seen {
    hits: usize,
    /// How far inside of the outline rays pass that are hits, but not as computed.
    inside: f64,
    /// How far outside those pass that are none, but are as computed.
    outside: f64,
    /// How far outside of its triangle's box the point at a hit's parameter lies.
    beyond_box: f64,
    /// Hits, exact or computed, that the other does not have.
    lost: usize,
    invented: usize,
}

#[test]
fn no_hit_of_a_lattice_is_lost_or_invented() {
    let all = triangles();
    let set = Triangles::new(all.clone(), |_| false).unwrap();
    let of_uniform =
        |settings| losses::<uniform_grid::UniformGrid<T>>(&set, &uniform_grid::INFO, settings);
    let of_octree = |settings| losses::<octree::Octree<T>>(&set, &octree::INFO, settings);
    let structures = [
        ("uniform-grid", of_uniform("density=20")),
        ("driving axis", of_uniform("density=20 traversal=driving-axis")),
        ("octree", of_octree("")),
        ("octree by neighbours", of_octree("traversal=neighbour")),
        ("octree by location", of_octree("traversal=point-location")),
        ("kd-tree", losses::<kd_tree::KdTree<T>>(&set, &kd_tree::INFO, "max-leaf=4")),
        (
            "recursive-grid",
            losses::<recursive_grid::RecursiveGrid<T>>(&set, &recursive_grid::INFO, ""),
        ),
        // planted: boxes that are not padded
        ("not padded", of_uniform("density=20 insertion=box")),
    ];
    let exact: Vec<_> = all.iter().map(|t| t.map(point)).collect();
    let epsilon = T::EPSILON.to_f64() * set.magnitude().to_f64();
    let (mut lost, mut seen) = ([0; 8], Seen::default());
    for ray in rays() {
        let setup = set.setup(&ray);
        let [o, d] = [ray.origin, ray.direction].map(|v| point(v.to_array()));
        let mut hits = Vec::new();
        for id in 0..set.len() as u32 {
            let hit = set.intersect(id, &ray, &setup, T::INFINITY);
            hits.extend(hit.map(|t| (id, t)));
            let triangle = exact[id as usize];
            let expected = answer(triangle, o, d);
            if expected == Answer::Flat {
                continue;
            }
            seen.beyond_box = seen.beyond_box.max(hit.map_or(0.0, |t| {
                let at = ray.origin.to_dvec3() + ray.direction.to_dvec3() * t.to_f64();
                let tight = set.bounds(id);
                let (low, high) = (tight.min.to_dvec3() - at, at - tight.max.to_dvec3());
                low.max(high).max_element() / epsilon
            }));
            // a ray from a triangle may begin on either side of it
            let is_right = hit.is_some() == (expected == Answer::Hit);
            if is_right || height(triangle, o) < ACROSS * epsilon {
                continue;
            }
            let distance = across(triangle, o, d) / epsilon;
            let most = if hit.is_some() { &mut seen.outside } else { &mut seen.inside };
            *most = most.max(distance);
            let (which, bound) = match hit {
                Some(_) => (&mut seen.invented, ACROSS),
                None => (&mut seen.lost, CORNERS_MOVED),
            };
            *which += usize::from(distance > bound);
        }
        seen.hits += hits.len();
        for (lost, (_, losses)) in lost.iter_mut().zip(&structures) {
            *lost += losses(&ray, &hits);
        }
    }
    println!("{seen:?}, lost {lost:?}");
    let [of_structures @ .., planted] = lost;
    assert_eq!(of_structures, [0; 7], "{:?}", structures.map(|(name, _)| name));
    assert!(planted > 100 && seen.hits > 1_000_000, "{planted} {seen:?}");
    assert_eq!((seen.lost, seen.invented), (0, 0), "{seen:?}");
    assert!(seen.inside > 1.0 && seen.outside > 1.0, "{seen:?}");
    assert!(seen.beyond_box < ACROSS + ALONG, "{seen:?}");
}
