//! Names the fault of an answer by a searchable term.

use accel_core::{Hit, Ray, Scalar};

use crate::rays::batches::Answers;
use crate::rays::exactness::is_apart;

/// Names the fault of ray `i`, answered with `said` instead of `expected`, in a scene of this many
/// primitives.
pub fn name<S: Scalar>(
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
        assert_eq!(name(&ray, 0, &said, &expected, 10), "wrong occlusion");
    }
}
