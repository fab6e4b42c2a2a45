//! Keyframes of glTF animations: numbers at times, and what lies between them.
//!
//! Appendix C of the glTF 2.0 specification: steps, straight lines (of rotations along the shorter
//! arc), cubic Hermite splines with their tangents in the file.

use ::gltf::animation::Interpolation;
use glam::DQuat;

/// Keys of one sampler: at each time as many numbers as it is wide, for splines three times as many
/// (the tangent that leads in, the value, the one that leads out).
#[derive(Debug)]
pub(crate) struct Keys {
    /// Seconds, ascending, at least one.
    pub times: Vec<f64>,
    pub values: Vec<f64>,
    pub width: usize,
    pub interpolation: Interpolation,
}

impl Keys {
    /// Lists of `width` numbers for each key.
    pub fn lists(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 }
    }

    /// A list of a key: 0 for the value or the tangent that leads in.
    fn list(&self, key: usize, which: usize) -> &[f64] {
        let from = (key * self.lists() + which) * self.width;
        self.values.get(from..from + self.width).unwrap_or_default()
    }

    /// The value of a key.
    pub fn value(&self, key: usize) -> &[f64] {
        self.list(key, self.lists() / 2)
    }

    /// The numbers at a time; before the first key and behind the last those of it. Rotations go
    /// along the arc.
    pub fn at(&self, time: f64, is_rotation: bool) -> Vec<f64> {
        let next = self.times.partition_point(|&t| t <= time);
        let Some(key) = next.checked_sub(1) else { return self.value(0).to_vec() };
        let (Some(&from), Some(&to)) = (self.times.get(key), self.times.get(next)) else {
            return self.value(key).to_vec();
        };
        let (length, u) = (to - from, (time - from) / (to - from));
        let (a, b) = (self.value(key), self.value(next));
        match self.interpolation {
            Interpolation::Step => a.to_vec(),
            Interpolation::Linear => match (is_rotation, a, b) {
                (true, &[ax, ay, az, aw], &[bx, by, bz, bw]) => {
                    let [a, b] =
                        [DQuat::from_xyzw(ax, ay, az, aw), DQuat::from_xyzw(bx, by, bz, bw)];
                    a.normalize().slerp(b.normalize(), u).to_array().to_vec()
                }
                _ => a.iter().zip(b).map(|(a, b)| a + (b - a) * u).collect(),
            },
            Interpolation::CubicSpline => {
                let (u2, u3) = (u * u, u * u * u);
                let leaves = self.list(key, 2).iter().map(|m| m * length);
                let enters = self.list(next, 0).iter().map(|m| m * length);
                let ends = a
                    .iter()
                    .zip(b)
                    .map(|(a, b)| (2.0 * u3 - 3.0 * u2 + 1.0) * a + (3.0 * u2 - 2.0 * u3) * b);
                let bends =
                    leaves.zip(enters).map(|(m, n)| (u3 - 2.0 * u2 + u) * m + (u3 - u2) * n);
                ends.zip(bends).map(|(end, bend)| end + bend).collect()
            }
        }
    }

    /// Whether a scale of these keys gets through zero, or may.
    pub fn passes_zero(&self) -> bool {
        let first = self.value(0);
        let keeps = |key| {
            self.value(key)
                .iter()
                .zip(first)
                .all(|(a, b)| *a * *b > 0.0 && a.signum() == b.signum())
        };
        self.interpolation == Interpolation::CubicSpline || !(0..self.times.len()).all(keeps)
    }
}
