//! glTF files as the crate `gltf` reads them by itself: its own validation, its own readers of
//! accessors, its own matrices.

use std::path::Path;

use ::gltf::mesh::Mode;
use ::gltf::{Gltf, Node};
use glam::{DMat4, Vec3};

use super::reading::Reading;
use crate::gltf::buffers::Buffers;
use crate::polygon::area_vector;

/// What it finds. It may panic, and believes what it reads: for files that our reader has accepted.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Reading, String> {
    let Gltf { document, blob } = Gltf::from_slice(bytes).map_err(|e| e.to_string())?;
    let buffers = Buffers::load(path, &document, blob).map_err(|e| e.to_string())?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots = scene.iter().flat_map(|scene| scene.nodes());
    let mut stack: Vec<(Node<'_>, DMat4)> = roots.map(|node| (node, DMat4::IDENTITY)).collect();
    let mut reading = Reading::new();
    while let Some((node, parent)) = stack.pop() {
        let matrix = node.transform().matrix().map(|column| column.map(f64::from));
        let world = parent * DMat4::from_cols_array_2d(&matrix);
        stack.extend(node.children().map(|child| (child, world)));
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
            let reader = primitive.reader(|buffer| buffers.bytes(buffer.index()));
            let Some(positions) = reader.read_positions() else { continue };
            let positions: Vec<_> =
                positions.map(|p| world.transform_point3(Vec3::from_array(p).as_dvec3())).collect();
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            let triangles: Vec<[u32; 3]> = match primitive.mode() {
                Mode::Triangles => indices.as_chunks().0.to_vec(),
                Mode::TriangleStrip => {
                    indices.windows(3).filter_map(|w| w.first_chunk().copied()).collect()
                }
                Mode::TriangleFan => match indices.split_first() {
                    Some((&first, rest)) => rest
                        .windows(2)
                        .filter_map(|w| Some([first, *w.first()?, *w.get(1)?]))
                        .collect(),
                    None => Vec::new(),
                },
                _ => continue,
            };
            let mut count = 0;
            for triangle in triangles {
                let corners = triangle.map(|i| positions.get(i as usize).copied());
                let [Some(a), Some(b), Some(c)] = corners else { continue };
                if area_vector(&[a, b, c]).is_some() {
                    count += 1;
                    [a, b, c].into_iter().for_each(|corner| reading.bounds.include(corner));
                }
            }
            reading.add(primitive.material().name().unwrap_or_default(), count);
        }
    }
    Ok(reading)
}
