//! How rays are kept off the surfaces they leave, rule against rule: the cases S1 to S4 of
//! `rtbench verify`, each rule with the same scenes, hit points and directions. S1 draws triangles
//! up to 10^4 times as long as wide, spheres, cones and polygons of a size of 10^-8 to 10^8, up to
//! 1000 sizes from the origin.
//!
//! usage: offset_trials [RAYS [SEED [RULE...]]]: so many rays per case, precision and rule.

use accel_core::registry::Buildable;
use accel_core::{Hit, Vector};
use measurement::plan::ray_overrides::RULES;
use renderer::Geometry;
use renderer::ray_offset::OffsetRule;
use statistics::random::Random;
use studies::verify::cases::secondary::{Draw, draws};
use studies::verify::round::{OracleAnswer, Round};
use studies::verify::subject::with_brute_force;

/// Rays of a round.
const ROUND: usize = 500;

/// A start is far when it is more than so many epsilons of the scene's diagonal from the hit point:
/// 10^-5 diagonals in f32.
const FAR: f64 = 84.0;

/// What came of a rule: rays that hit where nothing is, mostly what they left; rays that miss what
/// is in their way; and, in scenes no farther from the origin than they are large, far starts.
#[derive(Debug, Clone, Default)]
struct Found {
    rays: u64,
    false_hits: u64,
    misses: u64,
    near_scenes: u64,
    far_starts: u64,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let rays = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(100_000);
    let seed = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(1);
    let named: Vec<String> = arguments.collect();
    let rules: Vec<_> = RULES
        .into_iter()
        .filter(|(name, _)| named.is_empty() || named.iter().any(|n| n == name))
        .collect();
    println!(
        "{:<7} {:<4} {:<15} {:>10} {:>10} {:>8} {:>10} {:>10}",
        "case", "", "rule", "rays", "false hits", "misses", "of rays", "far starts"
    );
    of_precision::<f32>(rays, seed, &rules);
    of_precision::<f64>(rays, seed, &rules);
}

fn of_precision<S: Buildable>(rays: usize, seed: u64, rules: &[(&str, OffsetRule)]) {
    for (case, draw) in draws::<S>() {
        let mut found = vec![Found::default(); rules.len()];
        let mut random = Random::new(seed, &format!("offset-trials/{case}/{}", S::NAME));
        // scenes too large or too small for the precision are drawn again
        while found.iter().any(|f| f.rays < rays as u64) {
            let Some((drawn, unmoved)) = drawn(draw, &random, OffsetRule::None) else {
                // a coordinate that the precision does not hold: another scene
                random.next_u64();
                continue;
            };
            for ((_, rule), found) in rules.iter().zip(&mut found) {
                if let Some((_, round)) = self::drawn(draw, &random, *rule) {
                    found.add(&round, &unmoved);
                }
            }
            random = drawn;
        }
        for ((rule, _), f) in rules.iter().zip(&found) {
            println!(
                "{case:<7} {:<4} {rule:<15} {:>10} {:>10} {:>8} {:>10} {:>10}",
                S::NAME,
                f.rays,
                f.false_hits,
                f.misses,
                f.near_scenes,
                f.far_starts,
            );
        }
    }
}

/// A round, and the stream after it.
fn drawn<S: Buildable>(
    draw: Draw<S>,
    random: &Random,
    rule: OffsetRule,
) -> Option<(Random, Round<S>)> {
    let mut random = random.clone();
    let round = draw(&mut random, ROUND, rule).ok()?;
    Some((random, round))
}

impl Found {
    fn add<S: Buildable>(&mut self, round: &Round<S>, unmoved: &Round<S>) {
        let mut hits = vec![Hit::NONE; round.rays.len()];
        let asked = with_brute_force(round.model.prims(), |tracer| {
            tracer.closest_hits(&round.rays, &mut hits);
        });
        if asked.is_err() {
            return;
        }
        let (diagonal, magnitude) = extent(&round.model);
        let is_near = magnitude <= diagonal;
        let far = FAR * S::EPSILON.to_f64() * diagonal;
        for (((ray, hit), expected), at) in
            round.rays.iter().zip(&hits).zip(&round.expected).zip(&unmoved.rays)
        {
            self.rays += 1;
            match expected {
                OracleAnswer::Miss => self.false_hits += u64::from(hit.is_hit()),
                _ => self.misses += u64::from(!expected.admits(hit)),
            }
            if is_near {
                let first = ray.origin.to_dvec3() + ray.direction.to_dvec3() * ray.t_min.to_f64();
                self.near_scenes += 1;
                self.far_starts += u64::from(first.distance(at.origin.to_dvec3()) > far);
            }
        }
    }
}

/// Diagonal and largest coordinate of a scene.
fn extent<S: Buildable>(model: &Geometry<S>) -> (f64, f64) {
    fn of<S: Buildable, P: accel_core::primitives::PrimSet<S>>(set: &P) -> (f64, f64) {
        let bounds = (0..set.len() as u32).map(|id| set.bounds(id)).reduce(|a, b| a.union(b));
        let diagonal = bounds.map_or(0.0, |b| (b.max - b.min).to_dvec3().length());
        (diagonal, set.magnitude().to_f64())
    }
    match model {
        Geometry::Triangles(set) => of(set),
        Geometry::Mixed(set) => of(set),
    }
}
