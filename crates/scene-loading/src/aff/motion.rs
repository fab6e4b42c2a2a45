//! Keyframes (`k`): what is said of a name over time, and how it is read.

use std::collections::BTreeMap;

use crate::aff::spline::{Key, Track};
use crate::error::LoadError;
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::FirstAndCount;
use crate::scene::Scene;
use crate::words::Words;
use glam::{DAffine3, DQuat, DVec3};

/// The fewest keys of a track: the first and the last only shape the curve.
const FEWEST: u64 = 4;

/// Motion of a named object.
#[derive(Debug, Default)]
pub(super) struct Motion {
    pub translation: Option<Track<DVec3>>,
    pub rotation: Option<Track<DQuat>>,
    scale: Option<Track<DVec3>>,
    /// From a time on it is seen or not; seen before the first.
    visibility: Vec<(f64, bool)>,
}

/// Motions by names; of two of a name the later one counts.
pub(super) type Motions = BTreeMap<String, Motion>;

impl Motion {
    /// Scaled first, then turned, then moved.
    pub fn at(&self, time: f64) -> DAffine3 {
        let translation = self.translation.as_ref().map_or(DVec3::ZERO, |track| track.at(time));
        let rotation = self.rotation.as_ref().map_or(DQuat::IDENTITY, |track| track.at(time));
        let scale = self.scale.as_ref().map_or(DVec3::ONE, |track| track.at(time));
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    }

    pub fn is_visible(&self, time: f64) -> bool {
        let now = self.visibility.iter().take_while(|(from, _)| *from <= time).last();
        now.is_none_or(|(_, visible)| *visible)
    }

    /// True when it may vanish or be mirrored: what follows it is no rigid part.
    pub fn is_unsteady(&self) -> bool {
        let keys = self.scale.iter().flat_map(|track| &track.0).map(|key| key.value);
        let hides = self.visibility.iter().any(|(_, visible)| !visible);
        hides || keys.clone().zip(keys.skip(1)).any(|(a, b)| a != b)
    }

    /// Reads what stands behind the name, from the brace on; counts keys that go back in time.
    pub fn read(words: &mut Words<'_>, back: &mut FirstAndCount) -> Result<Self, LoadError> {
        words.keyword("{")?;
        let mut motion = Self::default();
        loop {
            let word = words.any("a kind of keys or }")?;
            let place = words.place(word.line);
            let fewest = match word.text {
                "}" => return Ok(motion),
                "transl" | "rot" | "scale" => FEWEST,
                "visibility" => 1,
                other => {
                    let expected = "transl, rot, scale, visibility or }";
                    return Err(LoadError::syntax(place, other, expected));
                }
            };
            let count = words.integer("the number of keys", fewest, MAX_ELEMENTS as u64)?;
            // a key has at least two numbers and four characters
            let room = words.remaining() / 4 + 1;
            limits::check(count as usize, room, "the number of keys", || place)?;
            match word.text {
                "transl" => motion.translation = Some(Track(keys(words, count, back, value)?)),
                "scale" => motion.scale = Some(Track(keys(words, count, back, value)?)),
                "rot" => {
                    let keys = keys(words, count, back, rotation)?;
                    motion.rotation = Some(Track::of_rotations(keys));
                }
                _ => {
                    let mut last = None;
                    for _ in 0..count {
                        let time = time(words, &mut last, back)?;
                        let visible = words.integer("whether it is visible", 0, 1)? == 1;
                        motion.visibility.push((time, visible));
                    }
                }
            }
        }
    }
}

/// An axis and degrees about it; about no axis nothing is turned.
pub(super) fn rotation(words: &mut Words<'_>) -> Result<DQuat, LoadError> {
    let axis = words.vector("an axis")?;
    let angle = words.number("an angle")?.to_radians();
    Ok(axis.try_normalize().map_or(DQuat::IDENTITY, |axis| DQuat::from_axis_angle(axis, angle)))
}

fn value(words: &mut Words<'_>) -> Result<DVec3, LoadError> {
    words.vector("the values of a key")
}

fn keys<T>(
    words: &mut Words<'_>,
    count: u64,
    back: &mut FirstAndCount,
    value: impl Fn(&mut Words<'_>) -> Result<T, LoadError>,
) -> Result<Vec<Key<T>>, LoadError> {
    let mut last = None;
    let mut keys = Vec::new();
    for _ in 0..count {
        let time = time(words, &mut last, back)?;
        let value = value(words)?;
        let shape = words.vector("tension, continuity and bias")?.to_array();
        keys.push(Key { time, value, shape });
    }
    Ok(keys)
}

/// The time of a key; one before that of the key in front is counted.
fn time(
    words: &mut Words<'_>,
    last: &mut Option<f64>,
    back: &mut FirstAndCount,
) -> Result<f64, LoadError> {
    let line = words.peek().map_or(0, |word| word.line);
    let time = words.number("the time of a key")?;
    if last.is_some_and(|last| last > time) {
        back.add(|| words.place(line));
    }
    *last = Some(time);
    Ok(time)
}

/// A triangle and its keys.
pub(super) struct AnimatedPatch {
    /// The first of its three vertices, and of its three normals.
    pub first: [usize; 2],
    /// Times, ascending, with corners and normals.
    pub keys: Vec<(f64, [[DVec3; 2]; 3])>,
}

impl AnimatedPatch {
    /// Sets its corners and normals as at a time; before the first key and behind the last as
    /// there.
    pub fn set(&self, time: f64, scene: &mut Scene) {
        let next = self.keys.partition_point(|(at, _)| *at <= time);
        let (Some(before), Some(behind)) =
            (self.keys.get(next.saturating_sub(1)), self.keys.get(next).or(self.keys.last()))
        else {
            return;
        };
        let length = behind.0 - before.0;
        let share = if length > 0.0 { ((time - before.0) / length).clamp(0.0, 1.0) } else { 0.0 };
        for (i, (a, b)) in before.1.iter().zip(&behind.1).enumerate() {
            let lists = [&mut scene.vertices, &mut scene.normals];
            for ((list, first), (a, b)) in lists.into_iter().zip(self.first).zip(a.iter().zip(b)) {
                if let Some(slot) = list.get_mut(first + i) {
                    *slot = *a + (*b - *a) * share;
                }
            }
        }
    }
}
