//! Translations of nodes in f64. The crate `gltf` reads them as f32: houses of a city that each
//! stand at 5,400 km would be half a metre off, every one otherwise.

use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::Root;
use glam::DVec3;
use serde::Deserialize;

use crate::error::LoadError;
use crate::gltf::rules::parser_error;

/// Beyond this f32 rounds to a thousandth and more. Below it, nothing is read again.
const FAR: f32 = 16_384.0;

/// By node, where one of a file is far away; else none. What f64 cannot hold is left to the crate.
pub(super) fn translations(
    path: &Path,
    json: &[u8],
    root: &Root,
) -> Result<BTreeMap<usize, DVec3>, LoadError> {
    #[derive(Deserialize)]
    struct Document {
        #[serde(default)]
        nodes: Vec<Node>,
    }
    #[derive(Deserialize)]
    struct Node {
        translation: Option<[f64; 3]>,
        matrix: Option<[f64; 16]>,
    }
    let is_far = |x: &f32| x.abs() > FAR;
    let is_far_node = |node: &::gltf::json::Node| {
        node.translation.is_some_and(|t| t.iter().any(is_far))
            || node.matrix.is_some_and(|m| m.iter().skip(12).any(is_far))
    };
    if !root.nodes.iter().any(is_far_node) {
        return Ok(BTreeMap::new());
    }
    let document: Document =
        serde_json::from_slice(json).map_err(|error| parser_error(path, error.to_string()))?;
    let exact = |node: Node| match (node.translation, node.matrix) {
        (_, Some([.., x, y, z, _])) => Some(DVec3::new(x, y, z)),
        (translation, None) => translation.map(DVec3::from_array),
    };
    let all = document.nodes.into_iter().enumerate();
    Ok(all.filter_map(|(i, node)| Some((i, exact(node)?))).collect())
}
