//! Curves through keys with tension, continuity and bias, of places and of rotations.
//!
//! D. Kochanek, R. Bartels, "Interpolating Splines with Local Tension, Continuity, and Bias
//! Control", SIGGRAPH 1984, with tangents scaled for keys that are not equally far apart; of
//! rotations the same over the logarithms of quaternions, by K. Shoemake's squad ("Animating
//! Rotation with Quaternion Curves", SIGGRAPH 1985), as in D. Eberly's code that BART comes with.
//! Deviation: there, of two keys that are more than half a turn apart as quaternions, the later one
//! is negated only between the second and the last but one; here it is everywhere, so that the
//! curve has no kink.

use glam::{DQuat, DVec3};

/// A key: seconds, a place or a rotation, tension, continuity and bias.
#[derive(Debug, Clone, Copy)]
pub(super) struct Key<T> {
    pub time: f64,
    pub value: T,
    pub shape: [f64; 3],
}

/// At least four keys. The curve goes from the second to the last but one, and jumps where two have
/// the same time; a key that goes back in time counts only for those behind it (BART's own robot
/// has one).
#[derive(Debug)]
pub(super) struct Track<T>(pub Vec<Key<T>>);

/// Four keys, the curve between the middle ones, and how far on it a time is, from 0 to 1.
struct Segment<'a, T> {
    keys: &'a [Key<T>; 4],
    share: f64,
}

impl<T> Track<T> {
    /// End of the curve.
    fn last(&self) -> Option<T>
    where
        T: Copy,
    {
        self.0.iter().rev().nth(1).map(|key| key.value)
    }

    /// Segment of a time, clamped to the first and last; `None` for an empty segment.
    fn segment(&self, time: f64) -> Option<Segment<'_, T>> {
        let windows = || self.0.windows(4).filter_map(|keys| keys.first_chunk::<4>());
        let keys = windows().find(|[_, _, to, _]| time < to.time).or_else(|| windows().last())?;
        let [_, from, to, _] = keys;
        if to.time <= from.time {
            return None;
        }
        let share = ((time - from.time) / (to.time - from.time)).clamp(0.0, 1.0);
        Some(Segment { keys, share })
    }
}

impl<T> Segment<'_, T> {
    /// Weights of the chords before and behind the second key in the tangent that leaves it.
    fn leaves(&self) -> [f64; 2] {
        let [before, from, to, _] = self.keys;
        let [tension, continuity, bias] = from.shape;
        let scale = (1.0 - tension) * part(to.time - from.time, to.time - before.time);
        [scale * (1.0 + continuity) * (1.0 + bias), scale * (1.0 - continuity) * (1.0 - bias)]
    }

    /// Weights of the chords before and behind the third key in the tangent that enters it.
    fn enters(&self) -> [f64; 2] {
        let [_, from, to, behind] = self.keys;
        let [tension, continuity, bias] = to.shape;
        let scale = (1.0 - tension) * part(to.time - from.time, behind.time - from.time);
        [scale * (1.0 - continuity) * (1.0 + bias), scale * (1.0 + continuity) * (1.0 - bias)]
    }
}

impl Track<DVec3> {
    /// The place at a time.
    pub fn at(&self, time: f64) -> DVec3 {
        let Some(segment) = self.segment(time) else { return self.last().unwrap_or_default() };
        let [p0, p1, p2, p3] = segment.keys.each_ref().map(|key| key.value);
        let ([a, b], [c, d]) = (segment.leaves(), segment.enters());
        let leaves = a * (p1 - p0) + b * (p2 - p1);
        let enters = c * (p2 - p1) + d * (p3 - p2);
        let u = segment.share;
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * p1
            + (3.0 * u2 - 2.0 * u3) * p2
            + (u3 - 2.0 * u2 + u) * leaves
            + (u3 - u2) * enters
    }
}

impl Track<DQuat> {
    /// Turns quaternions around that are more than half a turn from the one before.
    pub fn of_rotations(mut keys: Vec<Key<DQuat>>) -> Self {
        let mut last: Option<DQuat> = None;
        for key in &mut keys {
            if last.is_some_and(|last| last.dot(key.value) < 0.0) {
                key.value = -key.value;
            }
            last = Some(key.value);
        }
        Self(keys)
    }

    /// The rotation at a time, of unit length.
    pub fn at(&self, time: f64) -> DQuat {
        let Some(segment) = self.segment(time) else { return self.last().unwrap_or_default() };
        let [q0, q1, q2, q3] = segment.keys.each_ref().map(|key| key.value);
        let chord = |from: DQuat, to: DQuat| logarithm(from.conjugate() * to);
        let between = chord(q1, q2);
        let ([a, b], [c, d]) = (segment.leaves(), segment.enters());
        let leaves = a * chord(q0, q1) + b * between;
        let enters = c * between + d * chord(q2, q3);
        let from = q1 * exponential(0.5 * (leaves - between));
        let to = q2 * exponential(0.5 * (between - enters));
        let u = segment.share;
        arc(arc(q1, q2, u), arc(from, to, u), 2.0 * u * (1.0 - u)).normalize()
    }
}

/// A part of a time; of none nothing.
fn part(of: f64, all: f64) -> f64 {
    if all > 0.0 { of / all } else { 0.0 }
}

/// Axis times half the angle, of a quaternion of unit length.
fn logarithm(q: DQuat) -> DVec3 {
    let v = DVec3::new(q.x, q.y, q.z);
    let length = v.length();
    if length == 0.0 { DVec3::ZERO } else { v * (length.atan2(q.w) / length) }
}

/// The inverse of [`logarithm`].
fn exponential(v: DVec3) -> DQuat {
    let angle = v.length();
    let (sin, cos) = angle.sin_cos();
    let v = if angle == 0.0 { DVec3::ZERO } else { v * (sin / angle) };
    DQuat::from_xyzw(v.x, v.y, v.z, cos)
}

/// Between two quaternions along the arc, the longer one too: a curve does not jump to the other
/// side.
fn arc(a: DQuat, b: DQuat, share: f64) -> DQuat {
    let angle = a.dot(b).clamp(-1.0, 1.0).acos();
    let sin = angle.sin();
    if sin < 1e-6 {
        return a;
    }
    a * (((1.0 - share) * angle).sin() / sin) + b * ((share * angle).sin() / sin)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn key<T>(time: f64, value: T) -> Key<T> {
        Key { time, value, shape: [0.0; 3] }
    }

    #[test]
    fn curves_go_through_their_keys_and_stay_at_the_ends() {
        let x = |x: f64| DVec3::new(x, 0.0, 0.0);
        let keys = [(-1.0, 5.0), (0.0, 0.0), (1.0, 1.0), (3.0, 3.0), (4.0, 4.0)];
        let track = Track(keys.map(|(time, at)| key(time, x(at))).to_vec());
        // two keys at once: a jump
        let mut jump = track.0.clone();
        jump[2].time = 3.0;
        let jump = Track(jump);
        assert!((jump.at(2.999).x - 1.0).abs() < 0.01 && jump.at(3.0).x == 3.0);
        for (time, expected) in [(-9.0, 0.0), (0.0, 0.0), (1.0, 1.0), (3.0, 3.0), (9.0, 3.0)] {
            assert!((track.at(time).x - expected).abs() < 1e-12, "{time}");
        }
        // unequal keys on a straight line are passed at the same speed: 2 in the middle of 1 and 3
        assert!((track.at(2.0).x - 2.0).abs() < 1e-12, "{}", track.at(2.0));
        // tension 1: the tangents vanish
        let still = track.0.iter().map(|key| Key { shape: [1.0, 0.0, 0.0], ..*key }).collect();
        let still = Track(still);
        assert!((still.at(0.25).x - (3.0 / 16.0 - 2.0 / 64.0)).abs() < 1e-12);
    }

    #[test]
    fn rotations_about_one_axis_are_as_fast_as_their_keys_say() {
        let turn = |angle: f64| DQuat::from_rotation_z(angle);
        let quarter = |i: f64| key(i, turn(i * FRAC_PI_2));
        // the quaternion of the third key is written the other way round
        let mut keys: Vec<_> = (0..6).map(|i| quarter(f64::from(i))).collect();
        keys[2].value = -keys[2].value;
        let track = Track::of_rotations(keys);
        for time in [1.0, 1.25, 2.0, 2.5, 3.75, 4.0] {
            let angle = track.at(time).angle_between(turn(time * FRAC_PI_2));
            assert!(angle < 1e-6, "{time}: {angle}");
        }
        assert!(track.at(99.0).angle_between(turn(4.0 * FRAC_PI_2)) < 1e-6);
    }
}
