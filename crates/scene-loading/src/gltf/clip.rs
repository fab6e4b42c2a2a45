//! An animation of a glTF file, read and checked: which node's what follows which keys, numbers at
//! times, and what lies between them.
//!
//! Appendix C of the glTF 2.0 specification: steps, straight lines (of rotations along the shorter
//! arc), cubic Hermite splines with their tangents in the file.

use std::collections::BTreeMap;

use crate::error::LoadError;
use crate::gltf::container::OpenedFile;
use crate::limits::{self, MAX_ELEMENTS};
use ::gltf::Accessor;
use ::gltf::accessor::Dimensions;
use ::gltf::animation::{Interpolation, Property};
use ::gltf::json::validation::Checked;
use glam::{DQuat, DVec3};

/// How the nodes of a scene stand at a moment: animated values by node.
#[derive(Debug, Default)]
pub(crate) struct Pose(BTreeMap<usize, NodePose>);

/// Animated values of a node; `None` where the file's own values apply.
#[derive(Debug, Default)]
pub(crate) struct NodePose {
    pub translation: Option<DVec3>,
    pub rotation: Option<DQuat>,
    pub scale: Option<DVec3>,
    pub weights: Option<Vec<f64>>,
    /// Its scale gets through zero somewhere in the animation, or may.
    is_unsteady: bool,
}

impl Pose {
    pub fn of(&self, node: usize) -> Option<&NodePose> {
        self.0.get(&node)
    }

    pub fn is_steady(&self, node: usize) -> bool {
        self.of(node).is_none_or(|pose| !pose.is_unsteady)
    }
}

impl NodePose {
    pub fn is_placed(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.scale.is_some()
    }
}

/// The first animation of a file.
pub(crate) struct Clip {
    /// Keys of each sampler that a channel uses.
    samplers: Vec<Option<Keys>>,
    channels: Vec<Channel>,
}

struct Channel {
    node: usize,
    property: Property,
    sampler: usize,
}

impl Clip {
    /// Reads the first animation.
    pub fn read(file: &OpenedFile) -> Result<Self, LoadError> {
        let OpenedFile { path, document, .. } = file;
        let Some(animation) = document.as_json().animations.first() else {
            return Err(LoadError::gltf(path, "document", "no animations", "at least one"));
        };
        let mut clip = Self { samplers: Vec::new(), channels: Vec::new() };
        clip.samplers.resize_with(animation.samplers.len(), || None);
        let mut numbers = 0;
        for (c, channel) in animation.channels.iter().enumerate() {
            let invalid = |found: &str, expected: &str| {
                LoadError::gltf(path, format!("animation 0 channel {c}"), found, expected)
            };
            let (node, s) = (channel.target.node.value(), channel.sampler.value());
            let Checked::Valid(property) = channel.target.path else {
                let expected = "translation, rotation, scale or weights";
                return Err(invalid("another path", expected));
            };
            let Some(target) = document.nodes().nth(node) else {
                let expected = format!("one of {}, counted from 0", document.nodes().len());
                return Err(invalid(&format!("target node {node}"), &expected));
            };
            let width = match property {
                Property::Translation | Property::Scale => 3,
                Property::Rotation => 4,
                Property::MorphTargetWeights => {
                    let meshes = target.mesh();
                    let targets = meshes.iter().flat_map(|mesh| mesh.primitives());
                    targets.map(|primitive| primitive.morph_targets().len()).max().unwrap_or(0)
                }
            };
            if width == 0 {
                let found = "weights of a node without morph targets";
                return Err(invalid(found, "a mesh with targets"));
            }
            let Some(slot) = clip.samplers.get_mut(s) else {
                return Err(invalid(&format!("sampler {s}"), "one of the animation's"));
            };
            let keys = match slot {
                Some(keys) => keys,
                None => {
                    let keys = read_keys(file, s, property, width)?;
                    numbers += keys.values.len();
                    let what = "the numbers of all keys";
                    limits::check(numbers, MAX_ELEMENTS, what, || file.place())?;
                    slot.insert(keys)
                }
            };
            if keys.width != width {
                let found = format!("a sampler of {} numbers", keys.width);
                return Err(invalid(&found, &format!("one of {width}")));
            }
            let is_zero = |key: usize| keys.value(key).iter().all(|&x| x == 0.0);
            if property == Property::Rotation && (0..keys.times.len()).any(is_zero) {
                return Err(invalid("a rotation of 0, 0, 0, 0", "a quaternion other than 0"));
            }
            clip.channels.push(Channel { node, property, sampler: s });
        }
        if clip.channels.is_empty() {
            return Err(LoadError::gltf(path, "animation 0", "no channels", "at least one"));
        }
        Ok(clip)
    }

    /// The first and the last time of a key, seconds.
    pub fn span(&self) -> [f64; 2] {
        let times = || self.samplers.iter().flatten();
        let first = times().filter_map(|keys| keys.times.first()).copied();
        let last = times().filter_map(|keys| keys.times.last()).copied();
        [first.fold(f64::INFINITY, f64::min), last.fold(f64::NEG_INFINITY, f64::max)]
    }

    /// How the nodes stand at a time.
    pub fn pose(&self, time: f64) -> Pose {
        let mut pose = Pose::default();
        for channel in &self.channels {
            let Some(Some(keys)) = self.samplers.get(channel.sampler) else { continue };
            let values = keys.at(time, channel.property == Property::Rotation);
            let node = pose.0.entry(channel.node).or_default();
            match (channel.property, values.as_slice()) {
                (Property::Translation, &[x, y, z]) => node.translation = Some(DVec3::new(x, y, z)),
                (Property::Scale, &[x, y, z]) => {
                    node.scale = Some(DVec3::new(x, y, z));
                    node.is_unsteady = keys.passes_zero();
                }
                (Property::Rotation, &[x, y, z, w]) => {
                    node.rotation = Some(DQuat::from_xyzw(x, y, z, w));
                }
                (Property::MorphTargetWeights, _) => node.weights = Some(values),
                _ => {}
            }
        }
        pose
    }
}

/// The keys of a sampler for what it is used for first.
fn read_keys(
    file: &OpenedFile,
    sampler: usize,
    property: Property,
    width: usize,
) -> Result<Keys, LoadError> {
    let OpenedFile { path, document, buffers, .. } = file;
    let object = format!("animation 0 sampler {sampler}");
    let json = document.as_json().animations.first();
    let missing = || {
        let expected = "input, output and a known interpolation";
        LoadError::gltf(path, &object, "nothing", expected)
    };
    let json = json.and_then(|animation| animation.samplers.get(sampler)).ok_or_else(missing)?;
    let Checked::Valid(interpolation) = json.interpolation else { return Err(missing()) };
    let accessor = |index: usize| -> Result<Accessor<'_>, LoadError> {
        document.accessors().nth(index).ok_or_else(missing)
    };
    let times =
        buffers.numbers(accessor(json.input.value())?, "key times", Dimensions::Scalar, false)?;
    let mut pairs = times.iter().zip(times.iter().skip(1)).enumerate();
    if let Some((i, (before, time))) = pairs.find(|(_, (before, time))| before >= time) {
        let found = format!("key {} at {time:?} behind {before:?}", i + 1);
        return Err(LoadError::gltf(path, &object, found, "times that ascend"));
    }
    let (dimensions, normalized) = match property {
        Property::Translation | Property::Scale => (Dimensions::Vec3, false),
        Property::Rotation => (Dimensions::Vec4, true),
        Property::MorphTargetWeights => (Dimensions::Scalar, true),
    };
    let values = buffers.numbers(accessor(json.output.value())?, "keys", dimensions, normalized)?;
    let keys = Keys { times, values, width, interpolation };
    let needed = keys.times.len().saturating_mul(width).saturating_mul(keys.lists());
    if keys.values.len() != needed {
        let found = format!("{} numbers for {} times", keys.values.len(), keys.times.len());
        let expected = format!("{needed} ({interpolation:?})");
        return Err(LoadError::gltf(path, &object, found, expected));
    }
    Ok(keys)
}

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

    /// Returns whether a scale of these keys gets through zero, or may.
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
