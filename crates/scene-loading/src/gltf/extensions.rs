//! Extensions: which are read, which touch no geometry, and what those say that the crate `gltf`
//! does not know.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use ::gltf::json::Root;
use glam::DVec3;
use serde::Deserialize;

use crate::error::{LoadError, quote};

/// Extensions that are read.
const READ: [&str; 4] = ["KHR_lights_punctual", "KHR_mesh_quantization", INSTANCING, VISIBILITY];

const INSTANCING: &str = "EXT_mesh_gpu_instancing";
const VISIBILITY: &str = "KHR_node_visibility";

/// Extensions that pack geometry. A file may have the plain data beside it.
const PACKING: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// How names go on behind the vendor's letters where an extension is about looks, sound or
/// metadata.
#[rustfmt::skip]
const WITHOUT_GEOMETRY: [&str; 19] = [
    "animation_pointer", "articulations", "audio", "feature_metadata", "instance_features",
    "interactivity", "lights_", "lod", "materials_", "mesh_features", "mesh_variants",
    "node_hoverability", "node_selectability", "packing_", "primitive_outline",
    "structural_metadata", "techniques_webgl", "texture_", "xmp",
];

fn touches_geometry(name: &str) -> bool {
    let topic = name.split_once('_').map_or("", |(_, topic)| topic);
    !WITHOUT_GEOMETRY.iter().any(|known| topic.starts_with(known))
}

/// Refuses files that require what is not read here and may be geometry, before anything else is
/// missed in them (a mesh that is packed by an extension has no data of its own).
pub(super) fn check(path: &Path, json: &Root) -> Result<(), LoadError> {
    let required = json.extensions_required.iter().map(String::as_str);
    let unread = required.filter(|name| !READ.contains(name) && touches_geometry(name));
    let unread: Vec<String> = unread.take(8).map(quote).collect();
    if !unread.is_empty() {
        let expected = format!("none but {} and those that touch no geometry", READ.join(", "));
        return Err(LoadError::gltf(path, "extensionsRequired", unread.join(", "), expected));
    }
    let Some(packing) = packing(json) else { return Ok(()) };
    use ::gltf::Semantic::Positions;
    use ::gltf::json::validation::Checked::Valid;
    for (m, mesh) in json.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let accessor = primitive.attributes.get(&Valid(Positions));
            let accessor = accessor.and_then(|index| json.accessors.get(index.value()));
            if accessor.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none()) {
                let found = format!("positions without data in a file that uses {packing}");
                let object = format!("mesh {m} primitive {p}");
                return Err(LoadError::gltf(path, object, found, "a copy that is not packed"));
            }
        }
    }
    Ok(())
}

/// The extension that packs geometry in a file.
pub(super) fn packing(json: &Root) -> Option<&'static str> {
    PACKING.into_iter().find(|name| json.extensions_used.iter().any(|used| used == name))
}

/// A warning for each extension that a file uses and that is not read.
pub(super) fn warnings(json: &Root) -> Vec<String> {
    let names: BTreeSet<&String> =
        json.extensions_used.iter().chain(&json.extensions_required).collect();
    let unread = names.into_iter().filter(|name| !READ.contains(&name.as_str()));
    let text = |name: &String| match name {
        _ if PACKING.contains(&name.as_str()) => {
            format!("extension {} is not read: the copy that is not packed is", quote(name))
        }
        _ if touches_geometry(name) => {
            format!("extension {} is unknown and ignored", quote(name))
        }
        _ => format!("extension {} is not applied: it touches no geometry", quote(name)),
    };
    unread.map(text).collect()
}

/// Beyond this f32 rounds to a thousandth and more. Below it, no translation is read again.
const FAR: f32 = 16_384.0;

/// What the crate `gltf` does not read of nodes.
#[derive(Debug, Default)]
pub(crate) struct NodeExtensions {
    pub instancing: BTreeMap<usize, InstanceAttributes>,
    /// Nodes that are not to be seen, with all below them (`KHR_node_visibility`).
    pub hidden: BTreeSet<usize>,
    /// Translations in f64, where f32 is too coarse for one of a file; else none. What f64 cannot
    /// hold is left to the crate.
    pub translations: BTreeMap<usize, DVec3>,
}

/// Accessors of what places the instances of a node's mesh.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) struct InstanceAttributes {
    pub translation: Option<u32>,
    pub rotation: Option<u32>,
    pub scale: Option<u32>,
}

impl NodeExtensions {
    /// Reads them from the JSON of a file.
    pub fn read(path: &Path, json: &[u8], root: &Root) -> Result<Self, LoadError> {
        #[derive(Deserialize)]
        struct Document {
            #[serde(default)]
            nodes: Vec<Node>,
        }
        #[derive(Deserialize)]
        struct Node {
            extensions: Option<Extensions>,
            translation: Option<[f64; 3]>,
            matrix: Option<[f64; 16]>,
        }
        #[derive(Deserialize)]
        struct Extensions {
            #[serde(rename = "EXT_mesh_gpu_instancing")]
            instancing: Option<Instancing>,
            #[serde(rename = "KHR_node_visibility")]
            visibility: Option<Visibility>,
        }
        #[derive(Deserialize)]
        struct Instancing {
            #[serde(default)]
            attributes: InstanceAttributes,
        }
        #[derive(Deserialize)]
        struct Visibility {
            visible: Option<bool>,
        }
        let mut read = Self::default();
        let is_named = |name: &str| memchr::memmem::find(json, name.as_bytes()).is_some();
        let is_far = |x: &f32| x.abs() > FAR;
        let has_far = root.nodes.iter().any(|node| {
            node.translation.is_some_and(|t| t.iter().any(is_far))
                || node.matrix.is_some_and(|m| m.iter().skip(12).any(is_far))
        });
        if !has_far && !is_named(INSTANCING) && !is_named(VISIBILITY) {
            return Ok(read);
        }
        let document: Document =
            serde_json::from_slice(json).map_err(|error| LoadError::parser(path, error))?;
        for (node, Node { extensions, translation, matrix }) in
            document.nodes.into_iter().enumerate()
        {
            let exact = matrix.map(|[.., x, y, z, _]| [x, y, z]).or(translation);
            let exact = exact.filter(|_| has_far).map(DVec3::from_array);
            read.translations.extend(exact.map(|exact| (node, exact)));
            let Some(Extensions { instancing, visibility }) = extensions else { continue };
            if let Some(Instancing { attributes }) = instancing {
                read.instancing.insert(node, attributes);
            }
            if visibility.is_some_and(|visibility| visibility.visible == Some(false)) {
                read.hidden.insert(node);
            }
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn material_extensions_do_not_change_geometry() {
        #[rustfmt::skip]
        let known = [
            "KHR_materials_unlit", "KHR_texture_transform", "EXT_texture_webp", "KHR_texture_basisu",
            "KHR_materials_pbrSpecularGlossiness", "ADOBE_materials_clearcoat_specular",
            "EXT_lights_image_based", "KHR_xmp_json_ld", "KHR_animation_pointer", "MSFT_texture_dds",
        ];
        for name in known {
            assert!(!touches_geometry(name), "{name}");
        }
        for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_shape", "x", ""]
        {
            assert!(touches_geometry(name), "{name}");
        }
    }
}
