//! The oracles of `rtbench verify` refute what is wrong: each is shown a planted fault, and the
//! right answer beside it.

use accel_core::primitives::{PrimSet, TriangleSet};
use accel_core::{Hit, Ray, Vector};
use renderer::Geometry;
use renderer::ray_offset::OffsetRule;
use statistics::random::Random;
use studies::verify::cases::secondary::shells;
use studies::verify::catalogue::find;
use studies::verify::round::Round;

/// Rays of a round.
const RAYS: usize = 400;

/// Some rounds of a case in single precision.
fn rounds(id: &str) -> Vec<Round<f32>> {
    let single = find(id).unwrap().1.single;
    let draw = |number| single(&mut Random::new(number, "planted"), RAYS).unwrap();
    (0..6).map(draw).collect()
}

/// The answers that the oracle of a case refutes, told.
fn told(
    rounds: &[Round<f32>],
    answer: impl Fn(&Geometry<f32>, &Ray<f32>) -> Hit<f32>,
) -> Vec<String> {
    let mut wrong = Vec::new();
    for round in rounds {
        for (ray, expected) in round.rays.iter().zip(&round.expected) {
            let hit = answer(&round.model, ray);
            if !expected.admits(&hit) {
                wrong.push(format!("{ray:?}: {hit:?}, not {expected:?}"));
            }
        }
    }
    wrong
}

/// Number of answers that the oracle of a case refutes.
fn refuted(rounds: &[Round<f32>], answer: impl Fn(&Geometry<f32>, &Ray<f32>) -> Hit<f32>) -> usize {
    told(rounds, answer).len()
}

/// All hits of a ray, by parameter and id.
fn hits(prims: &impl PrimSet<f32>, ray: &Ray<f32>) -> Vec<Hit<f32>> {
    let setup = prims.setup(ray);
    let hit = |id| prims.intersect(id, ray, &setup, ray.t_max).map(|t| Hit { t, id });
    let mut all: Vec<Hit<f32>> = (0..prims.len() as u32).filter_map(hit).collect();
    // zeros of both signs are equal
    let order = |a: f32, b: f32| a.partial_cmp(&b).expect("no NaN");
    all.sort_by(|a, b| order(a.t, b.t).then(a.id.cmp(&b.id)));
    all
}

fn all_hits(model: &Geometry<f32>, ray: &Ray<f32>) -> Vec<Hit<f32>> {
    match model {
        Geometry::Triangles(set) => hits(set, ray),
        Geometry::Mixed(set) => hits(set, ray),
    }
}

fn first(model: &Geometry<f32>, ray: &Ray<f32>) -> Hit<f32> {
    all_hits(model, ray).first().copied().unwrap_or(Hit::NONE)
}

#[test]
fn swapped_ties_farther_hits_and_lost_triangles_are_refuted() {
    for id in ["G7", "T2", "T6", "T7", "Gr5", "Gr10", "K1", "R1"] {
        let rounds = rounds(id);
        assert_eq!(told(&rounds, first), [""; 0], "{id}");
        let lossy = |model: &Geometry<f32>, ray: &Ray<f32>| {
            let kept = all_hits(model, ray).into_iter().find(|h| h.id % 7 != 3);
            kept.unwrap_or(Hit::NONE)
        };
        assert!(refuted(&rounds, lossy) > 0, "{id}: a lost triangle");
        let last = |model: &Geometry<f32>, ray: &Ray<f32>| {
            all_hits(model, ray).last().copied().unwrap_or(Hit::NONE)
        };
        assert!(refuted(&rounds, last) > 0, "{id}: the farthest hit");
    }
    for id in ["G7", "G8", "T2"] {
        let rounds = rounds(id);
        let highest = |model: &Geometry<f32>, ray: &Ray<f32>| {
            let all = all_hits(model, ray);
            let tied = all.iter().take_while(|h| h.t == all[0].t);
            tied.last().copied().unwrap_or(Hit::NONE)
        };
        assert!(refuted(&rounds, highest) > 0, "{id}: the highest id");
    }
}

/// Woop's test with this edge function; both sides.
fn woop(t: &[[f32; 3]; 3], ray: &Ray<f32>, edge: fn([f32; 4]) -> f32) -> Option<f32> {
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    let z = (0..3).max_by(|&a, &b| d[a].abs().total_cmp(&d[b].abs())).unwrap();
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let sheared = |v: &[f32; 3]| {
        let p = [v[x] - o[x], v[y] - o[y], v[z] - o[z]];
        [p[0] - d[x] / d[z] * p[2], p[1] - d[y] / d[z] * p[2], p[2]]
    };
    let [a, b, c] = [sheared(&t[0]), sheared(&t[1]), sheared(&t[2])];
    let u = edge([c[0], b[1], c[1], b[0]]);
    let v = edge([a[0], c[1], a[1], c[0]]);
    let w = edge([b[0], a[1], b[1], a[0]]);
    let (low, high) = (u.min(v).min(w), u.max(v).max(w));
    let t = (u * a[2] + v * b[2] + w * c[2]) / d[z] / (u + v + w);
    ((low >= 0.0 || high <= 0.0) && t >= ray.t_min && t <= ray.t_max).then_some(t)
}

fn nearest_by_woop(set: &TriangleSet<f32>, ray: &Ray<f32>, edge: fn([f32; 4]) -> f32) -> Hit<f32> {
    let hits = set
        .triangles()
        .iter()
        .zip(0..)
        .filter_map(|(t, id)| woop(t, ray, edge).map(|t| Hit { t, id }));
    hits.min_by(|a, b| a.t.total_cmp(&b.t)).unwrap_or(Hit::NONE)
}

#[test]
fn a_contracted_edge_function_leaks() {
    for id in ["G1", "G2"] {
        let rounds = rounds(id);
        let leaks = |edge: fn([f32; 4]) -> f32| {
            refuted(&rounds, |model, ray| match model {
                Geometry::Triangles(set) => nearest_by_woop(set, ray, edge),
                Geometry::Mixed(_) => Hit::NONE,
            })
        };
        assert_eq!(leaks(|[a, b, c, d]| a * b - c * d), 0, "{id}");
        assert!(leaks(|[a, b, c, d]| a.mul_add(b, -(c * d))) > 0, "{id}");
    }
}

/// The quadratic formula as in any textbook, for the sphere of G9.
fn textbook_sphere(_: &Geometry<f32>, ray: &Ray<f32>) -> Hit<f32> {
    let (o, d) = (ray.origin, ray.direction);
    let (a, b, c) = (d.dot(d), 2.0 * o.dot(d), o.dot(o) - 0.1 * 0.1);
    let discriminant = b * b - 4.0 * a * c;
    let t = (-b - discriminant.sqrt()) / (2.0 * a);
    if t >= 0.0 { Hit { t, id: 0 } } else { Hit::NONE }
}

#[test]
fn shapes_met_elsewhere_are_refuted() {
    for id in ["G9", "G10", "G11", "G12"] {
        let rounds = rounds(id);
        assert_eq!(told(&rounds, first), [""; 0], "{id}");
        let late = |model: &Geometry<f32>, ray: &Ray<f32>| {
            let hit = first(model, ray);
            Hit { t: hit.t * 1.05, ..hit }
        };
        assert!(refuted(&rounds, late) > 0, "{id}: late");
        let nothing = |_: &Geometry<f32>, _: &Ray<f32>| Hit::NONE;
        assert!(refuted(&rounds, nothing) > 0, "{id}: nothing");
    }
    assert!(refuted(&rounds("G9"), textbook_sphere) > 0);
    // rays are aimed at points of the plane, a parameter of 1 away: as if there were no outline
    assert!(refuted(&rounds("G12"), |_, _| Hit { t: 1.0, id: 0 }) > 0);
    // surfaces are seen from outside only
    let behind = |model: &Geometry<f32>, ray: &Ray<f32>| {
        let back = Ray { direction: -ray.direction, ..*ray };
        let hit = first(model, &back);
        if hit.is_hit() { Hit { t: 1.0, ..hit } } else { first(model, ray) }
    };
    assert!(refuted(&rounds("G11"), behind) > 0);
    assert!(
        refuted(&rounds("G6"), |_, _| Hit { t: 1.0, id: 0 }) > 0
            && refuted(&rounds("G6"), first) == 0
    );
}

#[test]
fn metamorphic_laws_hold_without_another_structure() {
    for id in
        ["Gr12", "R8", "G14", "G15", "G16", "S7", "K1dense", "Q9", "Q10", "Q12fan", "Q12denormal"]
    {
        let rounds = rounds(id);
        assert_eq!(told(&rounds, first), [""; 0], "{id}");
        let nothing = |_: &Geometry<f32>, _: &Ray<f32>| Hit::NONE;
        assert!(refuted(&rounds, nothing) > 0, "{id}: nothing");
        let last = |model: &Geometry<f32>, ray: &Ray<f32>| {
            all_hits(model, ray).last().copied().unwrap_or(Hit::NONE)
        };
        assert!(refuted(&rounds, last) > 0, "{id}: the farthest hit");
    }
    // from the plane of a flat scene nothing is met, at whatever parameter
    let in_the_plane = |_: &Geometry<f32>, _: &Ray<f32>| Hit { t: 7.0, id: 0 };
    let false_hits = told(&rounds("R9"), in_the_plane);
    assert!(false_hits.iter().any(|told| told.ends_with("not Miss")));
    // a sliver met where none of it is
    let far_off = |model: &Geometry<f32>, ray: &Ray<f32>| {
        let hit = first(model, ray);
        Hit { t: hit.t + 20.0 / ray.direction.length(), ..hit }
    };
    assert!(refuted(&rounds("G16"), far_off) > refuted(&rounds("G16"), first));
    // intervals that begin at 0, and hits that are met again
    let from_zero = |model: &Geometry<f32>, ray: &Ray<f32>| {
        first(model, &Ray { t_min: ray.t_min.max(0.0), ..*ray })
    };
    assert!(refuted(&rounds("R8"), from_zero) > 0);
    let again = |model: &Geometry<f32>, ray: &Ray<f32>| {
        first(model, &Ray { t_min: ray.t_min.next_down(), ..*ray })
    };
    for id in ["R8", "G15", "S7"] {
        let rounds = rounds(id);
        assert!(refuted(&rounds, again) > 0, "{id}");
    }
}

#[test]
fn lost_and_farther_hits_of_polygons_and_slender_cones_are_refuted() {
    for id in ["Q1", "Q2", "Q2slivers", "Q3", "Q3flat", "Q6"] {
        let rounds = rounds(id);
        assert_eq!(told(&rounds, first), [""; 0], "{id}");
        let nothing = |_: &Geometry<f32>, _: &Ray<f32>| Hit::NONE;
        assert!(refuted(&rounds, nothing) > 0, "{id}: nothing");
        let late = |model: &Geometry<f32>, ray: &Ray<f32>| {
            let hit = first(model, ray);
            Hit { t: hit.t * 1.05, ..hit }
        };
        assert!(refuted(&rounds, late) > 0, "{id}: late");
        assert!(refuted(&rounds, |_, _| Hit { t: 1.0, id: 0 }) > 0, "{id}: anywhere");
    }
}

#[test]
fn shadow_rays_blocked_by_glass_are_refuted() {
    let stopped = |round: &Round<f32>| {
        let asked = round.rays.iter().zip(&round.blocked);
        asked.filter(|(ray, blocked)| first(&round.model, ray).is_hit() != **blocked).count()
    };
    assert!(rounds("Q9").iter().map(stopped).sum::<usize>() > 50);
    assert_eq!(rounds("Q10").iter().map(stopped).sum::<usize>(), 0);
}

#[test]
fn a_fixed_offset_skips_shells() {
    let skipped = |rule| {
        let mut random = Random::new(1, "shells");
        let rounds = (0..20).map(|_| shells::<f32>(&mut random, 200, rule).unwrap());
        let wrong = |round: Round<f32>| {
            let asked = round.rays.iter().zip(&round.expected);
            asked.filter(|(ray, e)| !e.admits(&first(&round.model, ray))).count()
        };
        rounds.map(wrong).sum::<usize>()
    };
    assert_eq!(skipped(OffsetRule::default()), 0);
    assert!(skipped(OffsetRule::Fixed(1e-4)) > 100);
    // met twice: the one that is left
    assert!(skipped(OffsetRule::None) > 100);
}
