//! Sample positions: Sobol's (0,2)-sequence, scrambled and shuffled by hashes.
//!
//! Papers: I. Sobol, "On the Distribution of Points in a Cube", 1967; A. Owen, "Randomly Permuted
//! (t,m,s)-Nets", 1995; B. Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020 (crate
//! `sobol_burley`); discs as in P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and
//! Square", JGT 2(3), 1997.
//!
//! Every pixel and purpose has a scramble of its own, made from the seed alone: the image does not
//! depend on threads, and purposes are not correlated. Any aligned 2^k samples are stratified, up
//! to 2^16: the sequences of the crate end there, and the next 2^16 samples are from another one.

use glam::DVec2;
use sobol_burley::{parts::hash, sample, sample_4d};

/// Samples of a sequence of crate `sobol_burley`.
const LONGEST: u32 = 1 << 16;

/// Purpose of samples; separates their patterns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Pixel,
    Lens,
    /// The time that the shutter is open.
    Time,
    /// The area of a light: its number, and the depth of the hit.
    Light(u32, u32),
    /// The microfacets of a mirror, at that depth.
    Facet(u32),
}

#[derive(Debug, Clone, Copy)]
pub struct Pattern {
    seed: u32,
}

impl Pattern {
    pub fn new(seed: u64, [x, y]: [u32; 2], purpose: Purpose) -> Self {
        let (kind, a, b) = match purpose {
            Purpose::Pixel => (0, 0, 0),
            Purpose::Lens => (1, 0, 0),
            Purpose::Time => (2, 0, 0),
            Purpose::Light(light, depth) => (3, light, depth),
            Purpose::Facet(depth) => (4, 0, depth),
        };
        let words = [seed as u32, (seed >> 32) as u32, x, y, kind, a, b];
        Self { seed: words.iter().fold(0x9e37_79b9, |h, &w| hash(h ^ hash(w))) }
    }

    /// Sample `i` of the unit interval.
    pub fn line(self, i: u32) -> f64 {
        unit(sample(i % LONGEST, 0, self.sequence(i)))
    }

    /// Sample `i` of the unit square.
    pub fn square(self, i: u32) -> DVec2 {
        let [x, y, ..] = sample_4d(i % LONGEST, 0, self.sequence(i));
        DVec2::new(unit(x), unit(y))
    }

    /// Sample `i` of the unit disc.
    pub fn disc(self, i: u32) -> DVec2 {
        concentric(self.square(i))
    }

    /// The seed of the sequence that sample `i` is from.
    fn sequence(self, i: u32) -> u32 {
        self.seed ^ hash(i / LONGEST)
    }
}

/// The middle of one of the 2^23 cells that the crate tells apart: never 0, never 1.
fn unit(x: f32) -> f64 {
    f64::from(x) + 0.5 / f64::from(1 << 23)
}

/// Shirley and Chiu's map from the square to the disc; keeps areas and neighbourhoods.
fn concentric(square: DVec2) -> DVec2 {
    let p = square * 2.0 - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, std::f64::consts::FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, std::f64::consts::FRAC_PI_2 - std::f64::consts::FRAC_PI_4 * (p.x / p.y))
    };
    DVec2::from_angle(angle) * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(seed: u64) -> Pattern {
        Pattern::new(seed, [3, 7], Purpose::Lens)
    }

    /// Returns whether every elementary interval of 2^a by 2^b cells has one of the 2^(a+b) points.
    fn is_net(points: &[DVec2]) -> bool {
        let bits = points.len().ilog2();
        (0..=bits).all(|a| {
            let (w, h) = (f64::from(1_u32 << a), f64::from(1_u32 << (bits - a)));
            let mut cells: Vec<[u32; 2]> =
                points.iter().map(|p| [(p.x * w) as u32, (p.y * h) as u32]).collect();
            cells.sort_unstable();
            cells.dedup();
            cells.len() == points.len()
        })
    }

    #[test]
    fn powers_of_two_are_nets_in_base_2_and_random_points_are_not() {
        for seed in 0..20 {
            for first in [0, 16, 32, 64, LONGEST - 16, LONGEST, 1 << 31] {
                let points: Vec<DVec2> =
                    (first..first + 16).map(|i| pattern(seed).square(i)).collect();
                assert!(is_net(&points), "{seed} {first}");
                // planted fault: another seed for each point
                let planted: Vec<DVec2> =
                    (0..16).map(|i| pattern(1000 * seed + u64::from(i)).square(i)).collect();
                assert!(!is_net(&planted));
            }
            let mut line: Vec<u32> =
                (0..64).map(|i| (pattern(seed).line(i) * 64.0) as u32).collect();
            line.sort_unstable();
            assert!(line.iter().copied().eq(0..64), "{seed}");
        }
    }

    #[test]
    fn patterns_differ_by_pixel_purpose_and_seed_and_repeat() {
        let p = |seed, x, purpose| Pattern::new(seed, [x, 0], purpose).square(5);
        let first = p(1, 0, Purpose::Lens);
        // the samples behind 2^16 are not the first ones again
        let pattern = Pattern::new(1, [0, 0], Purpose::Lens);
        assert_ne!(pattern.square(5), pattern.square(5 + LONGEST));
        assert_ne!(pattern.line(5), pattern.line(5 + LONGEST));
        assert_eq!(first, p(1, 0, Purpose::Lens));
        for other in [
            p(2, 0, Purpose::Lens),
            p(1 << 32, 0, Purpose::Lens),
            p(1, 1, Purpose::Lens),
            p(1, 0, Purpose::Pixel),
            p(1, 0, Purpose::Light(0, 1)),
            p(1, 0, Purpose::Light(1, 0)),
        ] {
            assert_ne!(first, other);
        }
    }

    #[test]
    fn the_disc_is_covered_evenly() {
        let points: Vec<DVec2> = (0..4096).map(|i| pattern(9).disc(i)).collect();
        assert!(points.iter().all(|p| p.length() < 1.0));
        let mean = points.iter().sum::<DVec2>() / 4096.0;
        assert!(mean.length() < 1e-3, "{mean}");
        for radius in [0.25, 0.5, 0.75] {
            let inside = points.iter().filter(|p| p.length() < radius).count() as f64 / 4096.0;
            assert!((inside - radius * radius).abs() < 0.01, "{radius}: {inside}");
        }
        assert_eq!(concentric(DVec2::splat(0.5)), DVec2::ZERO);
    }
}
