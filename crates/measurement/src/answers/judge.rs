//! Finds the wrong answers of a batch, and those that differ only where rounding decides.
//!
//! Each answer that differs from the one expected is put before the
//! [`Arbiter`](crate::answers::arbiter::Arbiter). What a structure answers with our primitive tests
//! must be right to the last bit. One that comes with a triangle test of its own (a plugin) may
//! answer otherwise where a ray passes an edge, where two surfaces meet, or where the interval of
//! the ray ends: *at an edge*. Answers at edges are wrong where they are more than rounding
//! explains ([`MOST_AT_EDGES`]).

use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar};
use rayon::prelude::*;

use crate::answers::oracle::Opinion;
use crate::answers::reference::Stage;
use crate::rays::batches::{Answers, Batch, BatchSet};
use crate::rays::exactness::{Exactness, is_apart};

/// Largest part of answers whose hit is lost, invented or elsewhere at an edge that rounding
/// explains. A ray from a surface is moved through it, so that a structure that ignores `t_min` in
/// shadow rays is at edges everywhere.
pub const MOST_AT_EDGES: f64 = 0.02;
/// So many may always be there.
const FEW: usize = 16;

/// Answers are decided so many at a time until so many are wrong; further ones that differ are
/// counted as wrong.
const ENOUGH_WRONG: usize = 64;

#[derive(Debug, Default)]
pub struct BatchVerdict {
    pub compared: usize,
    pub wrong: usize,
    /// Number of these that differ from the expected answer at an edge.
    pub edges: usize,
    /// The first wrong answer, in words.
    pub example: Option<String>,
}

/// Compares the answers to a batch of `set` with those expected.
pub fn judge<S: Buildable>(
    stage: &Stage<'_, S>,
    set: &BatchSet<'_, S>,
    batch: &Batch<'_, S>,
    answers: &Answers<S>,
    exactness: Exactness,
) -> BatchVerdict {
    let mut judged = BatchVerdict { compared: batch.rays.len(), ..BatchVerdict::default() };
    let (mut first, mut apart, mut first_apart) = (None, 0, None);
    let arbiter = stage.arbiter;
    let decide = |ray: &usize| arbiter.opinion((batch, set.stride), *ray, answers, exactness);
    let differing: Vec<usize> = batch.wrong(answers, exactness).collect();
    for rays in differing.chunks(ENOUGH_WRONG) {
        let is_decided = judged.wrong < ENOUGH_WRONG;
        let opinions = rays.par_iter().map(|ray| is_decided.then(|| decide(ray)).flatten());
        for (&ray, opinion) in rays.iter().zip(opinions.collect::<Vec<_>>()) {
            match opinion {
                Some(Opinion::Borderline) if exactness == Exactness::OwnTest => {
                    judged.edges += 1;
                    if batch.is_apart(answers, ray) {
                        apart += 1;
                        first_apart.get_or_insert(ray);
                    }
                }
                Some(Opinion::Right | Opinion::Borderline) => {}
                Some(Opinion::Wrong(_)) | None => {
                    judged.wrong += 1;
                    first.get_or_insert(ray);
                }
            }
        }
    }
    if apart > FEW && apart as f64 > MOST_AT_EDGES * judged.compared as f64 {
        judged.edges -= apart;
        judged.wrong += apart;
        first = first.or(first_apart);
    }
    judged.example = first.map(|first| {
        let (kind, ray) = (batch.name(), first * set.stride);
        let (said, expected) = (answers.describe(first), batch.expected.describe(first));
        let example = format!("{kind} ray {ray}: {said}, expected {expected}");
        match (exactness, batch.rays.get(first)) {
            (Exactness::OwnTest | Exactness::OurTest, Some(ray)) => {
                let primitives = stage.geometry.len();
                let fault = fault_name(ray, first, answers, &batch.expected, primitives);
                format!("{fault}: {example}")
            }
            _ => example,
        }
    });
    judged
}

/// Names the fault of ray `i`, answered with `said` instead of `expected`, in a scene of this many
/// primitives, by a searchable term.
fn fault_name<S: Scalar>(
    ray: &Ray<S>,
    i: usize,
    said: &Answers<S>,
    expected: &Answers<S>,
    primitives: usize,
) -> &'static str {
    match (said, expected) {
        (Answers::Hits(said), Answers::Hits(expected)) => match (said.get(i), expected.get(i)) {
            (Some(said), Some(expected)) => of_hit(ray, said, expected, primitives),
            _ => "no answer",
        },
        _ => "wrong occlusion",
    }
}

fn of_hit<S: Scalar>(
    ray: &Ray<S>,
    said: &Hit<S>,
    expected: &Hit<S>,
    primitives: usize,
) -> &'static str {
    if !said.is_hit() {
        return "drops a hit";
    }
    let (t, right) = (said.t.to_f64(), expected.t.to_f64());
    if t.is_nan() {
        "no answer written"
    } else if said.id as usize >= primitives {
        "wrong id: no such triangle"
    } else if t < ray.t_min.to_f64() {
        "accepts t < t_min"
    } else if t > ray.t_max.to_f64() {
        "accepts t > t_max"
    } else if !expected.is_hit() {
        "invents a hit"
    } else if said.id != expected.id && !is_apart(said, expected, ray) {
        "wrong id"
    } else if said.id == expected.id {
        "wrong t"
    } else if t > right {
        "drops a hit, and takes one behind it"
    } else {
        "invents a hit, nearer than all"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_have_names() {
        let mut ray = Ray::new([0.0f32; 3].into(), [0.0, 0.0, 1.0].into());
        (ray.t_min, ray.t_max) = (0.5, 9.0);
        let expected = Hit { t: 2.0, id: 3 };
        let hit = |t, id| Hit { t, id };
        let planted = [
            (Hit { t: 9.0, ..Hit::NONE }, "drops a hit"),
            (hit(3.0, 4), "drops a hit, and takes one behind it"),
            (hit(2.0, 4), "wrong id"),
            (hit(2.0, 70), "wrong id: no such triangle"),
            (hit(0.25, 3), "accepts t < t_min"),
            (hit(9.5, 3), "accepts t > t_max"),
            (hit(1.0, 3), "wrong t"),
            (hit(2.5, 3), "wrong t"),
            (hit(1.0, 4), "invents a hit, nearer than all"),
            (hit(f32::NAN, 0), "no answer written"),
        ];
        for (said, word) in planted {
            assert_eq!(of_hit(&ray, &said, &expected, 10), word, "{said:?}");
        }
        assert_eq!(of_hit(&ray, &hit(2.0, 3), &Hit::NONE, 10), "invents a hit");
        let (said, expected) = (Answers::Blocked(vec![true]), Answers::Blocked(vec![false]));
        assert_eq!(fault_name(&ray, 0, &said, &expected, 10), "wrong occlusion");
    }
}
