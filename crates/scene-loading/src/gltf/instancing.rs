//! Placements of the instances of a node's mesh: `EXT_mesh_gpu_instancing`.

use ::gltf::accessor::Dimensions;
use ::gltf::{Document, Node};
use glam::{DMat4, DQuat, DVec3};

use crate::error::LoadError;
use crate::gltf::buffers::Buffers;
use crate::gltf::extensions::NodeExtensions;

/// From the space of each instance to that of the node; none where the node has no instances.
pub(crate) fn placements(
    document: &Document,
    buffers: &Buffers,
    extensions: &NodeExtensions,
    node: &Node<'_>,
) -> Result<Option<Vec<DMat4>>, LoadError> {
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
