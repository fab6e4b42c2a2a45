//! Rays within the planes of nested cells: blocks of unit cubes, whose faces lie in the planes of
//! whatever cells a structure makes, and rays along those planes with components so small that two
//! roundings of one plane lie on either side of the whole scene.

use crate::agreement::agreed;
use crate::common::{Random, right_variants, triangle_set};
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{TriangleSet, Watertight};
use accel_core::registry::Buildable;
use accel_core::{Ray, Vec3, Vector};
use glam::DVec3;

/// The smallest component that is not zero.
const SMALLEST: f64 = 1e-45;

/// Every second cube of a block of unit cubes, or all of them; 12 triangles each.
fn block<S: Buildable>(n: [u32; 3], whole: bool) -> TriangleSet<S, Watertight> {
    let mut triangles = Vec::new();
    for i in 0..n[0] * n[1] * n[2] {
        let at = [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
        if !whole && (at[0] + at[1] + at[2]) % 2 == 1 {
            continue;
        }
        let low = DVec3::from_array(at.map(f64::from));
        for axis in 0..3 {
            let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
            (u[(axis + 1) % 3], v[(axis + 2) % 3]) = (1.0, 1.0);
            for side in [0.0, 1.0] {
                let mut p = low;
                p[axis] += side;
                triangles.push([p, p + u, p + u + v]);
                triangles.push([p, p + u + v, p + v]);
            }
        }
    }
    triangle_set(triangles, |_| false)
}

/// Along one axis, the other two components of sizes from `smallest` to 1e-3, drawn evenly by
/// their logarithms, of either sign, one in five of them zero. The origin lies on a lattice line,
/// three in four 3 to 13 units outside of the block.
fn rays<S: Buildable>(
    n: [u32; 3],
    smallest: f64,
    count: usize,
    random: &mut Random,
) -> Vec<Ray<S>> {
    let sizes = smallest.log10()..-3.0;
    let mut ray = |i: usize| {
        let (mut o, mut d) = ([0.0; 3], [0.0; 3]);
        let axis = i % 3;
        for k in 0..3 {
            o[k] = (random.unit() * f64::from(n[k] + 1)).floor();
            let size = 10f64.powf(sizes.start + (sizes.end - sizes.start) * random.unit());
            d[k] = if random.unit() < 0.2 { 0.0 } else { size };
            if random.unit() < 0.5 {
                d[k] = -d[k];
            }
        }
        let up = random.unit() < 0.5;
        d[axis] = if up { 1.0 } else { -1.0 };
        if random.unit() < 0.75 {
            let outside = 3.0 + 10.0 * random.unit();
            o[axis] = if up { -outside } else { f64::from(n[axis]) + outside };
        }
        Ray::new(
            Vec3::<S>::from_array(o.map(S::from_f64)),
            Vec3::<S>::from_array(d.map(S::from_f64)),
        )
    };
    (0..count).map(&mut ray).collect()
}

/// Every structure in every variant; more of those whose traversals or levels differ.
fn tested() -> impl Iterator<Item = (&'static str, &'static str)> {
    // an octree cuts aligned faces for ever
    right_variants().filter(|(name, _)| *name != "octree").chain([
        ("octree", "max-depth=6"),
        ("recursive-grid", "max-depth=8 threshold=2"),
        ("two-level-grid", "density=0.01 leaf-density=20"),
        ("hug", "size-classes=4 min-objects=2"),
        ("adaptive-grid", "m=0.1 split=2 levels=8"),
        ("irregular-grid", "query=batch"),
        ("octree", "max-depth=6 traversal=neighbour"),
        ("octree", "max-depth=6 traversal=point-location"),
    ])
}

fn blocks_agree<S: Buildable>() {
    let mut random = Random::new(18);
    let tested: Vec<_> = tested().collect();
    let sizes = [[12; 3], [16; 3], [2; 3], [24, 3, 10], [5, 24, 7], [9, 4, 24], [8; 3]];
    for (i, n) in sizes.into_iter().enumerate() {
        let set = block::<S>(n, i == 3);
        let count = (8_000_000 / set.triangles().len()).min(2000);
        let rays = rays(n, SMALLEST, count, &mut random);
        agreed(&format!("{n:?}"), PrimsRef::Watertight(&set), &rays, 10, &tested);
    }
}

#[test]
fn blocks_of_cubes_agree_with_brute_force_in_f32() {
    blocks_agree::<f32>();
}

#[test]
fn blocks_of_cubes_agree_with_brute_force_in_f64() {
    blocks_agree::<f64>();
}
