//! Random points and directions, drawn in single precision so that both precisions hold them.

use glam::{DVec3, dvec3};

use statistics::random::Random;

/// Uniform in [0, 1), with 24 bits.
pub fn unit(random: &mut Random) -> f64 {
    (random.next_u64() >> 40) as f64 / f64::from(1_u32 << 24)
}

/// Uniform in [-1, 1).
pub fn signed(random: &mut Random) -> f64 {
    unit(random) * 2.0 - 1.0
}

/// A point of the cube [-1, 1)^3.
pub fn point(random: &mut Random) -> DVec3 {
    single(dvec3(signed(random), signed(random), signed(random)))
}

/// A direction, uniform over the sphere.
pub fn direction(random: &mut Random) -> DVec3 {
    loop {
        let p = point(random);
        if (0.01..1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

/// One of `choices`, or the default where there are none.
pub fn one_of<T: Copy + Default>(random: &mut Random, choices: &[T]) -> T {
    choices.get(random.below(choices.len())).copied().unwrap_or_default()
}

/// A whole number in `-limit..=limit`.
pub fn random_integer(random: &mut Random, limit: u32) -> f64 {
    random.below(2 * limit as usize + 1) as f64 - f64::from(limit)
}

/// Rounded to single precision.
pub fn single(p: DVec3) -> DVec3 {
    p.as_vec3().as_dvec3()
}
