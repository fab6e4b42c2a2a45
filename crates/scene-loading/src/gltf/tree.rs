//! The tree of nodes: where each stands in the world, as the file says or in a pose, and where the
//! instances of its mesh stand (`EXT_mesh_gpu_instancing`).

use std::path::Path;

use ::gltf::Node;
use ::gltf::accessor::Dimensions;
use ::gltf::scene::Transform;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};

use crate::error::{FilePlace, LoadError, NOT_FINITE};
use crate::gltf::clip::Pose;
use crate::gltf::container::OpenedFile;

/// A node and where it is.
pub(crate) struct PlacedNode<'a> {
    pub node: Node<'a>,
    /// From its own space to the world.
    pub world: DMat4,
    /// In no pose is it collapsed or mirrored where it is not in others.
    pub is_steady: bool,
    /// It is not to be seen, in no pose: scaled to nothing, or hidden by `KHR_node_visibility`.
    pub is_hidden: bool,
}

/// All nodes of a scene once, parents first. The document need not be a tree: the crate accepts
/// cycles, and shared children would multiply.
pub(crate) fn placed<'a>(
    file: &'a OpenedFile,
    pose: Option<&Pose>,
) -> Result<Vec<PlacedNode<'a>>, LoadError> {
    let OpenedFile { path, document, extensions, .. } = file;
    let mut visited = vec![false; document.nodes().len()];
    let mut stack: Vec<(Node<'a>, Parent)> =
        file.scene()?.nodes().map(|node| (node, Parent::WORLD)).collect();
    stack.reverse();
    let mut placed = Vec::new();
    while let Some((node, parent)) = stack.pop() {
        let index = node.index();
        match visited.get_mut(index) {
            Some(seen) if !*seen => *seen = true,
            _ => {
                return Err(LoadError::NodeReachedTwice { place: file.place(), node: index });
            }
        }
        let world =
            parent.world * transform(path, &node, pose, extensions.translations.get(&index))?;
        if !world.is_finite() {
            let what = format!("node {index}: world transform");
            return Err(LoadError::not_finite(file.place(), what, NOT_FINITE));
        }
        let moved = pose.and_then(|pose| pose.of(index));
        let own = Parent {
            world,
            is_steady: parent.is_steady && pose.is_none_or(|pose| pose.is_steady(index)),
            is_hidden: parent.is_hidden || extensions.hidden.contains(&index),
            is_scaled: parent.is_scaled || moved.is_some_and(|moved| moved.scale.is_some()),
        };
        let first = stack.len();
        stack.extend(node.children().map(|child| (child, own)));
        if let Some(children) = stack.get_mut(first..) {
            children.reverse();
        }
        let is_nothing = DMat3::from_mat4(world) == DMat3::ZERO && !own.is_scaled;
        let is_hidden = own.is_hidden || is_nothing;
        placed.push(PlacedNode { node, world, is_steady: own.is_steady, is_hidden });
    }
    Ok(placed)
}

/// State that nodes inherit from their parent.
#[derive(Clone, Copy)]
struct Parent {
    world: DMat4,
    is_steady: bool,
    is_hidden: bool,
    /// Its scale, or one above it, is animated.
    is_scaled: bool,
}

impl Parent {
    const WORLD: Self =
        Self { world: DMat4::IDENTITY, is_steady: true, is_hidden: false, is_scaled: false };
}

/// The last row of a matrix may differ from 0, 0, 0, 1 by so much: programs invert in f32.
const ROW_TOLERANCE: f64 = 1e-5;

/// From a node's own space to its parent's. `exact` is its translation in f64, if it is known.
fn transform(
    path: &Path,
    node: &Node<'_>,
    pose: Option<&Pose>,
    exact: Option<&DVec3>,
) -> Result<DMat4, LoadError> {
    let object = format!("node {}", node.index());
    let moved = pose.and_then(|pose| pose.of(node.index()));
    let matrix = match node.transform() {
        Transform::Matrix { .. } if moved.is_some_and(|moved| moved.is_placed()) => {
            let found = "a matrix although it is animated";
            return Err(LoadError::gltf(path, object, found, "translation, rotation and scale"));
        }
        Transform::Matrix { matrix } => {
            let mut matrix = DMat4::from_cols_array_2d(&matrix.map(|c| c.map(f64::from)));
            if let Some(exact) = exact {
                matrix.w_axis = exact.extend(matrix.w_axis.w);
            }
            matrix
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let rotation = moved.and_then(|moved| moved.rotation).unwrap_or(rotation);
            if !(rotation.length() > 0.0 && rotation.is_finite()) {
                let found = format!("rotation {rotation}");
                return Err(LoadError::gltf(path, object, found, "a quaternion other than 0"));
            }
            let [translation, scale] =
                [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            let translation = exact.copied().unwrap_or(translation);
            DMat4::from_scale_rotation_translation(
                moved.and_then(|moved| moved.scale).unwrap_or(scale),
                rotation.normalize(),
                moved.and_then(|moved| moved.translation).unwrap_or(translation),
            )
        }
    };
    if !matrix.is_finite() {
        return Err(LoadError::not_finite(FilePlace::file(path), object, NOT_FINITE));
    }
    if !matrix.row(3).abs_diff_eq(DVec4::W, ROW_TOLERANCE) {
        let found = format!("a matrix with last row {}", matrix.row(3));
        return Err(LoadError::gltf(path, object, found, "0, 0, 0, 1"));
    }
    Ok(DAffine3::from_mat4(matrix).into())
}

/// From the space of each instance to that of the node; none where the node has no instances.
pub(crate) fn placements(
    file: &OpenedFile,
    node: &Node<'_>,
) -> Result<Option<Vec<DMat4>>, LoadError> {
    let OpenedFile { document, buffers, extensions, .. } = file;
    let object = format!("node {}: EXT_mesh_gpu_instancing", node.index());
    let Some(attributes) = extensions.instancing.get(&node.index()) else { return Ok(None) };
    let read = |index: Option<u32>, what, dimensions, normalized| {
        let Some(index) = index else { return Ok(None) };
        let accessor = document.accessors().nth(index as usize).ok_or_else(|| {
            let expected = format!("one of {}, counted from 0", document.accessors().len());
            buffers.invalid(&object, &format!("accessor {index}"), &expected)
        })?;
        buffers.numbers(accessor, what, dimensions, normalized).map(Some)
    };
    let translations =
        read(attributes.translation, "translations of instances", Dimensions::Vec3, false)?;
    let rotations = read(attributes.rotation, "rotations of instances", Dimensions::Vec4, true)?;
    let scales = read(attributes.scale, "scales of instances", Dimensions::Vec3, false)?;
    let lists = [(&translations, 3), (&rotations, 4), (&scales, 3)];
    let mut counts = lists.iter().filter_map(|(list, width)| Some(list.as_ref()?.len() / width));
    let Some(count) = counts.next() else { return Ok(None) };
    if let Some(other) = counts.find(|&other| other != count) {
        let found = format!("attributes of {count} and of {other} instances");
        return Err(buffers.invalid(&object, &found, "as many of each"));
    }
    let vector = |list: &Option<Vec<f64>>, i: usize, usual: f64| {
        let xyz = list.as_ref().and_then(|list| list.as_chunks::<3>().0.get(i));
        xyz.map_or(DVec3::splat(usual), |xyz| DVec3::from_array(*xyz))
    };
    let mut placements = Vec::with_capacity(count);
    for i in 0..count {
        let rotation = rotations.as_ref().and_then(|list| list.as_chunks::<4>().0.get(i));
        let rotation = rotation.map_or(DQuat::IDENTITY, |xyzw| DQuat::from_array(*xyzw));
        if rotation.length_squared() == 0.0 {
            let found = format!("a rotation of 0, 0, 0, 0 of instance {i}");
            return Err(buffers.invalid(&object, &found, "a quaternion other than 0"));
        }
        placements.push(DMat4::from_scale_rotation_translation(
            vector(&scales, i, 1.0),
            rotation.normalize(),
            vector(&translations, i, 0.0),
        ));
    }
    Ok(Some(placements))
}
