//! Excess of the offset of a ray from the surface it leaves.
//!
//! For each hit and direction the smallest safe offset is bisected: the least one along the
//! geometric normal, from the refined hit point, with which the primitive's own test no longer
//! finds the primitive that is left. What a rule takes instead, over that, is how loose it is; less
//! is a self-hit. Primitives beside the one that is left may be found wrongly, too: at most 10^-5
//! diagonals away, where the same ray does not meet them in double precision.

use accel_core::primitives::{PrimSet, PrimsRef};
use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;
use renderer::Geometry;
use renderer::surface::RefinedHit;

use super::secondary_rays::{
    Columns, Departure, GAP, SecondaryRays, SecondaryWork, height, quantile,
};
use crate::accuracy::record::in_a_million;

/// The least offset that is tried, in epsilons of the primitive's largest coordinate. It stands for
/// any less than it with which a ray is safe that is not without.
const LEAST: f64 = 1.0 / 1024.0;

/// Halvings of an interval of a factor of 2: the offset is known to 1 in 64.
const HALVINGS: u32 = 6;

/// The smallest safe offset of each departure, and who judges the rules by it.
pub struct SmallestOffsets<'a> {
    needed: Vec<f64>,
    hits: Vec<RefinedHit>,
    /// The primitives, whose own tests are asked without a structure, in both precisions.
    own: PrimsRef<'a, f32>,
    exact: PrimsRef<'a, f64>,
}

impl<'a> SmallestOffsets<'a> {
    /// Over the primitives of the scene in both precisions.
    pub fn new(
        secondary: &SecondaryRays<'_>,
        geometry: &'a Geometry<f32>,
        double: &'a Geometry<f64>,
    ) -> Self {
        let own = geometry.prims();
        let departures = &secondary.departures;
        let hits: Vec<RefinedHit> = departures.iter().map(|d| secondary.point(d).refined).collect();
        let smallest =
            |(d, refined): (&Departure, &RefinedHit)| smallest_offset(own, d.id, refined, d.out);
        let needed = departures.iter().zip(&hits).map(smallest).collect();
        Self { needed, hits, own, exact: double.prims() }
    }

    /// How loose a rule is: the offsets of its outward rays over the smallest.
    pub fn columns(&self, secondary: &SecondaryRays<'_>, work: &SecondaryWork<'_>) -> Columns {
        let mut found = OffsetComparison::default();
        let ids = secondary.departures.iter().map(|d| d.id).zip(&self.needed);
        for ((id, needed), (point, ray, hit)) in ids.zip(work.outcomes()) {
            found.add(*needed, height(point, ray), is_hit(self.own, id, ray));
            let is_false = hit.id != id && refutes(self.exact, hit, ray, GAP * secondary.diagonal);
            found.false_hits += u64::from(is_false);
        }
        found.ratios.sort_by(f64::total_cmp);
        let rays = self.needed.len() as u64;
        vec![
            ("found again by their own test in 10^6", in_a_million(found.self_hits, rays)),
            ("times the smallest, median", quantile(&found.ratios, 0.5)),
            ("times the smallest, most", quantile(&found.ratios, 1.0)),
            ("others falsely hit in 10^6", in_a_million(found.false_hits, rays)),
        ]
    }

    /// How many rays need an offset, and how large a one.
    pub fn words(&self) -> String {
        let needing = self.needed.iter().zip(&self.hits).filter(|(needed, _)| **needed > 0.0);
        let mut units: Vec<f64> = needing.map(|(needed, refined)| needed / unit(refined)).collect();
        units.sort_by(f64::total_cmp);
        format!(
            "{} of them need an offset: {:.3} epsilons of the primitive's largest coordinate in the \
             median, {:.3} at most",
            units.len(),
            quantile(&units, 0.5),
            quantile(&units, 1.0),
        )
    }
}

/// An epsilon of the primitive's largest coordinate.
fn unit(refined: &RefinedHit) -> f64 {
    f64::from(f32::EPSILON) * refined.magnitude
}

/// A rule's offsets against the smallest ones.
#[derive(Debug, Default)]
struct OffsetComparison {
    self_hits: u64,
    /// Hits of another primitive where none is.
    false_hits: u64,
    /// Chosen over smallest, where one is needed.
    ratios: Vec<f64>,
}

impl OffsetComparison {
    /// Adds a ray: the offset needed and the one chosen, the height over the surface of its first
    /// point that counts, world units.
    fn add(&mut self, needed: f64, chosen: f64, is_self_hit: bool) {
        self.self_hits += u64::from(is_self_hit);
        if needed > 0.0 {
            self.ratios.push(chosen / needed);
        }
    }
}

/// Asks the primitive's own test.
fn is_hit<S: Scalar>(prims: PrimsRef<'_, S>, id: u32, ray: &Ray<S>) -> bool {
    fn asked<S: Scalar, P: PrimSet<S>>(set: &P, id: u32, ray: &Ray<S>) -> bool {
        set.intersect(id, ray, &set.setup(ray), ray.t_max).is_some()
    }
    match prims {
        PrimsRef::Watertight(set) => asked(set, id, ray),
        PrimsRef::Mixed(set) => asked(set, id, ray),
    }
}

/// Returns whether a hit no farther than `near` is not there.
fn refutes(exact: PrimsRef<'_, f64>, hit: &Hit<f32>, ray: &Ray<f32>, near: f64) -> bool {
    hit.is_hit() && f64::from(hit.t) <= near && !is_hit(exact, hit.id, &ray.widened())
}

/// World units; 0 where the refined point itself, rounded, is safe.
fn smallest_offset(own: PrimsRef<'_, f32>, id: u32, refined: &RefinedHit, out: DVec3) -> f64 {
    let is_hit = |offset| is_hit(own, id, &lifted(refined, offset, out));
    let least = LEAST * unit(refined);
    let mut safe = least * f64::from(1 << 24);
    // from above: whatever rounding does below, nothing larger is hit
    while safe > least && !is_hit(safe / 2.0) {
        safe /= 2.0;
    }
    if safe <= least {
        return if is_hit(0.0) { least } else { 0.0 };
    }
    let mut hit = safe / 2.0;
    for _ in 0..HALVINGS {
        let middle = (hit + safe) / 2.0;
        *(if is_hit(middle) { &mut hit } else { &mut safe }) = middle;
    }
    safe
}

/// A ray that starts so far over the refined hit, rounded.
fn lifted(refined: &RefinedHit, offset: f64, out: DVec3) -> Ray<f32> {
    let side = refined.normal * refined.normal.dot(out).signum();
    let from = refined.position + side * offset;
    Ray::from_dvec3(from, out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::draw::{direction, unit as random_unit};
    use glam::dvec3;
    use renderer::surface::Surfaces;
    use scene_loading::Scene;
    use statistics::random::Random;

    /// Slanted triangles far from the origin, and rays off them.
    fn drawn(ask: impl FnOnce(PrimsRef<'_, f32>, &[(u32, RefinedHit, DVec3)])) {
        let mut random = Random::new(3, "smallest offsets");
        let (mut scene, material) = Scene::of_one_material("slanted");
        for _ in 0..200 {
            let at = direction(&mut random) * 40.0;
            let corners = [(); 3].map(|()| at + direction(&mut random) * 3.0);
            scene.push_triangle(material, corners);
        }
        let surfaces = Surfaces::new(&scene, false);
        let mut rays = Vec::new();
        for id in 0..scene.primitives.len() as u32 {
            let outline = scene.outline(scene.primitives[id as usize].shape);
            for _ in 0..20 {
                let (u, v) = (random_unit(&mut random) * 0.5, random_unit(&mut random) * 0.5);
                let p = outline[0] * (1.0 - u - v) + outline[1] * u + outline[2] * v;
                rays.push((id, surfaces.at(id, p).refined, direction(&mut random)));
            }
        }
        let geometry = Geometry::<f32>::of(&scene).unwrap();
        ask(geometry.prims(), &rays);
    }

    /// A planted rule: so many times the smallest offset.
    fn planted(times: f64) -> OffsetComparison {
        let mut found = OffsetComparison::default();
        drawn(|own, rays| {
            for (id, refined, out) in rays {
                let needed = smallest_offset(own, *id, refined, *out);
                let is_self_hit = is_hit(own, *id, &lifted(refined, needed * times, *out));
                found.add(needed, needed * times, is_self_hit);
            }
            assert!(found.ratios.len() > rays.len() / 10);
            found.ratios.sort_by(f64::total_cmp);
        });
        found
    }

    #[test]
    fn the_smallest_offset_is_safe_and_less_is_not() {
        let exact = planted(1.0);
        assert_eq!(exact.self_hits, 0);
        assert_eq!((quantile(&exact.ratios, 0.0), quantile(&exact.ratios, 1.0)), (1.0, 1.0));
        // planted: half of it
        let half = planted(0.5);
        assert!(half.self_hits as usize > half.ratios.len() / 2, "{}", half.self_hits);
        assert_eq!(quantile(&half.ratios, 1.0), 0.5);
        // planted: nothing at all
        let none = planted(0.0);
        assert!(none.self_hits >= half.self_hits && quantile(&none.ratios, 1.0) == 0.0);
    }

    #[test]
    fn twice_the_smallest_offset_is_a_ratio_of_two() {
        let double = planted(2.0);
        assert_eq!(double.self_hits, 0);
        for share in [0.0, 0.5, 0.99, 1.0] {
            assert_eq!(quantile(&double.ratios, share), 2.0);
        }
    }

    #[test]
    fn false_hits_are_refuted() {
        let (mut scene, material) = Scene::of_one_material("floor");
        scene.push_triangle(material, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        let geometry = Geometry::<f64>::of(&scene).unwrap();
        let exact = geometry.prims();
        let ray = |z: f32| Ray::<f32>::new(glam::vec3(0.2, 0.2, z), glam::Vec3::Z);
        let hit = Hit { t: 1e-3, id: 0 };
        assert!(!refutes(exact, &hit, &ray(-1e-3), 0.1));
        // planted: from above, where the ray leaves
        assert!(refutes(exact, &hit, &ray(1e-3), 0.1));
        assert!(
            !refutes(exact, &hit, &ray(1e-3), 1e-4) && !refutes(exact, &Hit::NONE, &ray(1e-3), 0.1)
        );
    }

    #[test]
    fn spheres_are_left_outwards() {
        let (mut scene, material) = Scene::of_one_material("ball");
        scene.push_sphere(material, dvec3(30.0, -7.0, 11.0), 2.0);
        let geometry = Geometry::<f32>::of(&scene).unwrap();
        let own = geometry.prims();
        let mut random = Random::new(5, "balls");
        let mut needs = 0;
        for _ in 0..2000 {
            let n = direction(&mut random);
            let refined =
                Surfaces::new(&scene, false).at(0, dvec3(30.0, -7.0, 11.0) + n * 2.0).refined;
            let any = direction(&mut random);
            let out = if any.dot(n) < 0.0 { -any } else { any };
            let smallest = smallest_offset(own, 0, &refined, out);
            assert!(smallest < 4.0 * unit(&refined), "{smallest}");
            needs += u32::from(smallest > 0.0);
        }
        assert!(needs > 200, "{needs}");
    }
}
