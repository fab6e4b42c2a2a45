//! Scenes and rays for the tests: random ones, and those that break things.

use accel_core::primitives::PrimsRef;
use accel_core::primitives::{Cone, MixedSet, MixedSetBuilder, TriangleSet, Watertight};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::{Entry, REGISTRY, find};
use accel_core::{Ray, Scalar, Vec3, Vector};
use glam::{DQuat, DVec3, dvec3};

/// A small seeded generator (an LCG with the multiplier of D. Knuth, TAOCP 2, 3.3.4).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn point(&mut self) -> DVec3 {
        dvec3(self.unit(), self.unit(), self.unit())
    }

    pub fn signed(&mut self) -> DVec3 {
        self.point() * 2.0 - 1.0
    }

    pub fn rotation(&mut self) -> DQuat {
        let axis = (self.signed() + dvec3(0.0, 0.0, 1e-9)).normalize();
        DQuat::from_axis_angle(axis, 7.0 * self.unit())
    }

    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }
}

/// A set of either kind.
pub enum Set<S: Buildable> {
    Triangles(TriangleSet<S, Watertight>),
    Mixed(MixedSet<S>),
}

impl<S: Buildable> Set<S> {
    pub fn prims(&self) -> PrimsRef<'_, S> {
        match self {
            Self::Triangles(set) => PrimsRef::Watertight(set),
            Self::Mixed(set) => PrimsRef::Mixed(set),
        }
    }
}

pub type Named<S> = (&'static str, Set<S>, (DVec3, DVec3));

/// The set of these triangles, rounded.
pub fn triangle_set<S: Scalar>(
    triangles: impl IntoIterator<Item = [DVec3; 3]>,
    transmissive: impl Fn(u32) -> bool,
) -> TriangleSet<S, Watertight> {
    let rounded = |t: [DVec3; 3]| t.map(|p| Vec3::<S>::from_dvec3(p).to_array());
    TriangleSet::new(triangles.into_iter().map(rounded).collect(), transmissive).unwrap()
}

fn triangles<S: Buildable>(list: &[[DVec3; 3]], transmissive: impl Fn(u32) -> bool) -> Set<S> {
    Set::Triangles(triangle_set(list.iter().copied(), transmissive))
}

/// Two triangles for each of `m * n` squares between these corners.
pub fn squares<P: Copy>(m: usize, n: usize, corner: impl Fn(usize, usize) -> P) -> Vec<[P; 3]> {
    let square = |k: usize| {
        let (i, j) = (k % m, k / m);
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
        [[a, b, d], [a, d, c]]
    };
    (0..m * n).flat_map(square).collect()
}

/// A name, the set and its bounds.
pub fn all_scenes<S: Buildable>() -> Vec<Named<S>> {
    let mut r = Random::new(42);
    let unit = (DVec3::ZERO, DVec3::ONE);
    let soup: Vec<[DVec3; 3]> = (0..300)
        .map(|_| {
            let p = r.point();
            [p, p + r.signed() * 0.15, p + r.signed() * 0.15]
        })
        .collect();
    let lattice = squares(12, 12, |x, y| dvec3(x as f64 / 12.0, 0.5, y as f64 / 12.0));
    // twins in the same place, in the middle of others: the lowest id must win
    let mut twins = soup[..60].to_vec();
    twins.extend_from_slice(&soup[..60]);
    let one = [dvec3(0.2, 0.3, 0.5), dvec3(0.8, 0.4, 0.5), dvec3(0.4, 0.9, 0.5)];
    let stadium: Vec<[DVec3; 3]> = (0..200)
        .map(|_| {
            let p = dvec3(500.0, 500.0, 0.1) + r.point() * 0.5;
            [p, p + r.signed() * 0.05, p + r.signed() * 0.05]
        })
        .chain([
            [dvec3(0.0, 0.0, 0.0), dvec3(1000.0, 0.0, 0.0), dvec3(1000.0, 1000.0, 0.0)],
            [dvec3(0.0, 0.0, 0.0), dvec3(1000.0, 1000.0, 0.0), dvec3(0.0, 1000.0, 0.0)],
        ])
        .collect();
    let far: Vec<[DVec3; 3]> =
        soup.iter().map(|t| t.map(|p| p + dvec3(1234.0, -2048.0, 777.0))).collect();
    let mut all = vec![
        ("soup", triangles(&soup, |id| id % 7 == 0), unit),
        ("flat lattice", triangles(&lattice, |_| false), unit),
        ("twins", triangles(&twins, |_| false), unit),
        ("duplicates", triangles(&[one; 200], |_| false), unit),
        ("one triangle", triangles(&[one], |_| false), unit),
        (
            "stadium",
            triangles(&stadium, |_| false),
            (dvec3(499.0, 499.0, 0.0), dvec3(502.0, 502.0, 1.0)),
        ),
        (
            "far away",
            triangles(&far, |_| false),
            (dvec3(1234.0, -2048.0, 777.0), dvec3(1235.0, -2047.0, 778.0)),
        ),
        ("mixed", mixed(&mut r, false), unit),
        ("moving", mixed(&mut r, true), unit),
    ];
    all.extend(crate::instances::scenes());
    all
}

/// So many triangles of all sizes within the unit cube, half of them in a corner of it.
pub fn many_triangles(n: usize) -> TriangleSet<f32, Watertight> {
    let mut r = Random::new(5);
    let list = (0..n).map(|i| {
        let p = if i % 2 == 0 { r.point() } else { r.point() * 0.1 };
        let size = if i % 500 == 0 { 0.6 } else { 0.02 };
        let corners = [p, p + r.signed() * size, p + r.signed() * size];
        corners.map(|p| p.clamp(DVec3::ZERO, DVec3::ONE).as_vec3().to_array())
    });
    TriangleSet::new(list.collect(), |_| false).unwrap()
}

/// A triangle in f32.
pub type Corners = [[f32; 3]; 3];

/// A relief of 2 * side * side triangles over the unit square, `height` high.
pub fn relief(side: usize, height: f32, corner: [f32; 3], size: f32) -> Vec<Corners> {
    let point = |x: usize, y: usize| {
        let (u, v) = (x as f32 / side as f32, y as f32 / side as f32);
        let z = (u * 37.0).sin() * (v * 29.0).cos() * height;
        [corner[0] + u * size, corner[1] + v * size, corner[2] + z * size]
    };
    let mut triangles = Vec::with_capacity(2 * side * side);
    for y in 0..side {
        for x in 0..side {
            let [a, b, c, d] = [point(x, y), point(x + 1, y), point(x, y + 1), point(x + 1, y + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    triangles
}

/// Primitives of all kinds; two thirds of them move, if any do.
fn mixed<S: Buildable>(r: &mut Random, moving: bool) -> Set<S> {
    let mut set = MixedSetBuilder::<S>::default();
    for i in 0..240 {
        let p = r.point();
        match i % 5 {
            0 => set.sphere(p, 0.02 + 0.06 * r.unit()).unwrap(),
            1 => {
                let q = p + r.signed() * 0.2;
                let (a, b) = (0.01 + 0.05 * r.unit(), 0.05 * r.unit());
                set.cone(Cone::new(p, a, q, b)).unwrap();
            }
            2 => {
                // a concave arrow in an axis plane: exact planarity in f32 too
                let s = 0.05 + 0.1 * r.unit();
                let v = [(0.0, 0.0), (2.0, 0.0), (0.4, 0.4), (0.0, 2.0)]
                    .map(|(x, y)| p + dvec3(x, y, 0.0) * s);
                set.polygon(&v).unwrap();
            }
            3 => set.polygon(&[p, p + r.signed() * 0.1, p + r.signed() * 0.1]).unwrap(),
            _ => set.triangle([p, p + r.signed() * 0.1, p + r.signed() * 0.1]).unwrap(),
        }
        if moving && i % 3 != 0 {
            set.last_moves(r.signed() * 0.4, 1.0).unwrap();
        }
        if i % 11 == 0 {
            set.last_is_transmissive();
        }
    }
    Set::Mixed(set.finish())
}

/// Rays into, out of and past the box: random, axis-parallel with zeros of both signs, within
/// planes of the box, from far away, with short intervals.
pub fn rays_for<S: Buildable>(bounds: (DVec3, DVec3), r: &mut Random) -> Vec<Ray<S>> {
    let (lo, hi) = bounds;
    let size = hi - lo;
    let mut rays: Vec<Ray<S>> = Vec::new();
    let mut push = |o: DVec3, d: DVec3, t_min: f64, t_max: f64| {
        let time = S::from_f64((rays.len() % 16) as f64 / 15.0);
        rays.push(Ray::<S> {
            origin: Vec3::<S>::from_dvec3(o),
            direction: Vec3::<S>::from_dvec3(d),
            t_min: S::from_f64(t_min),
            t_max: S::from_f64(t_max),
            time,
        });
    };
    for i in 0..900 {
        let target = lo + size * r.point();
        let origin = match i % 3 {
            0 => lo + size * r.point(),
            1 => target + r.signed() * size * 3.0,
            _ => target + r.signed() * size * 100.0,
        };
        let d = target - origin;
        push(origin, d, 0.0, f64::INFINITY);
        push(origin, d.normalize_or(DVec3::X), 1e-3, d.length() * 1.5);
        push(origin, d, 0.25 * r.unit(), 0.5 + r.unit());
    }
    for i in 0..300 {
        let p = lo + size * r.point();
        let axis = i % 3;
        for sign in [1.0, -1.0] {
            for zero in [0.0, -0.0] {
                let mut d = [zero; 3];
                d[axis] = sign;
                let d = DVec3::from_array(d);
                push(p - d * size * 2.0, d, 0.0, f64::INFINITY);
                push(p, d, 0.0, f64::INFINITY);
            }
        }
    }
    // origins and directions on a coarse lattice: cell planes, edges, corners, diagonals
    for i in 0..600 {
        let q = |x: f64| (x * 12.0).floor() / 12.0;
        let p = r.point();
        let p = lo + size * dvec3(q(p.x), q(p.y), if i % 2 == 0 { q(p.z) } else { 0.5 });
        let d = r.signed();
        let d = dvec3((d.x * 2.5).trunc(), (d.y * 2.5).trunc(), (d.z * 2.5).trunc());
        if d != DVec3::ZERO {
            push(p - d * size, d * size, 0.0, f64::INFINITY);
            push(p, d, 0.0, f64::INFINITY);
        }
    }
    // tiny components
    for tiny in [1e-45, 1e-38, 1e-20, 1e-7] {
        for k in 0..3 {
            let mut d = [1.0; 3];
            d[k] = tiny;
            d[(k + 1) % 3] = -tiny;
            let d = DVec3::from_array(d);
            for _ in 0..10 {
                push(lo + size * r.point() - d * size, d, 0.0, f64::INFINITY);
            }
        }
    }
    rays
}

/// Settings written as in a variant: `leaf-size=3 group=8`.
pub fn settings(text: &str) -> impl Iterator<Item = (&str, &str)> + Clone {
    text.split_whitespace().map(|word| word.split_once('=').unwrap())
}

/// The structure of that name, by settings written so.
pub fn build<'a, S: Buildable>(
    prims: PrimsRef<'a, S>,
    name: &str,
    text: &str,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let entry = find(name).unwrap();
    entry.build(prims, &entry.params(settings(text)).unwrap())
}

/// Every structure, by name, in every variant that is measured and has no known defect.
pub fn right_variants() -> impl Iterator<Item = (&'static str, &'static str)> {
    let all =
        REGISTRY.iter().flat_map(|entry| entry.info.variants.iter().map(move |v| (entry, *v)));
    let is_right = |(entry, variant): &(&Entry, &str)| {
        (entry.info.known_defect)(&entry.params(settings(variant)).unwrap()).is_none()
    };
    all.filter(is_right).map(|(entry, variant)| (entry.info.name, variant))
}

/// An entry for a structure with a planted fault. Its queries are called, not compiled into its
/// traversal: `entry!` would compile all of them once more for each such structure.
macro_rules! planted_entry {
    ($structure:ident, $info:expr) => {
        accel_core::structures::Entry::new(
            &$info,
            |params| accel_core::structures::prepare::<f32, $structure<f32>, false>(params),
            |params| accel_core::structures::prepare::<f64, $structure<f64>, false>(params),
        )
    };
}
pub(crate) use planted_entry;
