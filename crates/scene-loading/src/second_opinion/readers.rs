//! The other readers: glTF files as the crate `gltf` reads them, by its own validation, its own
//! readers of accessors, its own matrices, with skins and morph targets applied a second time, to
//! points; OBJ files as the crate `tobj` reads them.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::Path;

use ::gltf::accessor::{DataType, Iter};
use ::gltf::mesh::Mode;
use ::gltf::{Accessor, Document, Gltf, Node, Primitive, Skin};
use glam::{DMat4, DVec3, Vec3};

use super::reading::Reading;
use crate::gltf::{OpenedFile, tree};
use crate::input::{confined, read_at_most};
use crate::polygon::{Outline, area_vector};

/// Its reading, and what it takes from our reader. It may panic and does not validate, so call it
/// only for files that our reader has accepted.
pub(super) fn by_gltf(bytes: &[u8], ours: &OpenedFile) -> Result<(Reading, Vec<String>), String> {
    let mut shared = BTreeSet::from(["buffers", "which triangles have no area"]);
    let alone = Gltf::from_slice(bytes);
    let document = match &alone {
        Ok(file) => &file.document,
        Err(_) => {
            shared.insert("the JSON, which it refuses alone");
            &ours.document
        }
    };
    let mut reader = SecondReader { ours, document, worlds: Vec::new(), shared };
    let reading = reader.read()?;
    let mut notes = vec![format!(
        "taken from our reader, so not checked: {}; not compared: normals, textures, cameras, lights",
        reader.shared.into_iter().collect::<Vec<_>>().join(", ")
    )];
    if let Err(error) = alone {
        notes.push(format!("gltf alone refuses the file: {error}"));
    }
    Ok((reading, notes))
}

struct SecondReader<'a> {
    ours: &'a OpenedFile,
    document: &'a Document,
    /// Placements of the nodes of the scene.
    worlds: Vec<Option<DMat4>>,
    /// Parts taken from our reader.
    shared: BTreeSet<&'static str>,
}

impl<'a> SecondReader<'a> {
    fn read(&mut self) -> Result<Reading, String> {
        let document = self.document;
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let roots = scene.iter().flat_map(|scene| scene.nodes());
        let mut stack: Vec<(Node<'a>, DMat4, bool)> =
            roots.map(|node| (node, DMat4::IDENTITY, true)).collect();
        let mut seen = Vec::new();
        self.worlds = vec![None; document.nodes().len()];
        while let Some((node, parent, is_seen)) = stack.pop() {
            let matrix = node.transform().matrix().map(|column| column.map(f64::from));
            let world = parent * DMat4::from_cols_array_2d(&matrix);
            let is_hidden = self.ours.extensions.hidden.contains(&node.index());
            if is_hidden {
                self.shared.insert("nodes that are not visible");
            }
            let is_seen = is_seen && !is_hidden;
            stack.extend(node.children().map(|child| (child, world, is_seen)));
            if let Some(slot) = self.worlds.get_mut(node.index()) {
                *slot = Some(world);
            }
            if is_seen {
                seen.push((node, world));
            }
        }
        let mut reading = Reading::new();
        for (node, world) in seen {
            for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
                self.primitive(&node, &primitive, world, &mut reading)?;
            }
        }
        Ok(reading)
    }

    fn primitive(
        &mut self,
        node: &Node<'a>,
        primitive: &Primitive<'a>,
        world: DMat4,
        reading: &mut Reading,
    ) -> Result<(), String> {
        let Some(accessor) = primitive.get(&::gltf::Semantic::Positions) else { return Ok(()) };
        if accessor.count() == 0 || primitive.indices().is_some_and(|i| i.count() == 0) {
            return Ok(());
        }
        let mut positions = self.vectors(accessor)?;
        self.morph(node, primitive, &mut positions)?;
        let skinned = match node.skin() {
            Some(skin) => self.skinned(&skin, primitive, &positions),
            None => None,
        };
        let is_skinned = skinned.is_some();
        let positions = skinned.unwrap_or(positions);
        let mut worlds = vec![if is_skinned { DMat4::IDENTITY } else { world }];
        if node.skin().is_none() {
            let placements = tree::placements(self.ours, node);
            if let Some(placements) = placements.map_err(|error| error.to_string())? {
                self.shared.insert("where instances are");
                worlds = placements.into_iter().map(|placement| world * placement).collect();
            }
        }
        let triangles = self.triangles(primitive, positions.len());
        for world in worlds {
            let points: Vec<DVec3> = positions.iter().map(|&p| world.transform_point3(p)).collect();
            let mut count = 0;
            for triangle in &triangles {
                let corners = triangle.map(|i| points.get(i as usize).copied());
                let [Some(a), Some(b), Some(c)] = corners else { continue };
                if area_vector(&[a, b, c]).is_some() {
                    count += 1;
                    [a, b, c].into_iter().for_each(|corner| reading.bounds.include(corner));
                }
            }
            reading.add(primitive.material().name().unwrap_or_default(), count);
        }
        Ok(())
    }

    fn triangles(&self, primitive: &Primitive<'_>, vertices: usize) -> Vec<[u32; 3]> {
        let reader = primitive.reader(|buffer| self.ours.buffers.bytes(buffer.index()));
        let indices: Vec<u32> = match (primitive.indices(), reader.read_indices()) {
            (None, _) => (0..vertices as u32).collect(),
            (_, Some(indices)) => indices.into_u32().collect(),
            // all zeros: no triangle has an area
            (Some(_), None) => Vec::new(),
        };
        match primitive.mode() {
            Mode::Triangles => indices.as_chunks().0.to_vec(),
            Mode::TriangleStrip => {
                indices.windows(3).filter_map(|w| w.first_chunk().copied()).collect()
            }
            Mode::TriangleFan => match indices.split_first() {
                Some((&first, rest)) => {
                    rest.windows(2).filter_map(|w| Some([first, *w.first()?, *w.get(1)?])).collect()
                }
                None => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    /// The vectors of an accessor: the crate knows floats in a buffer view.
    fn vectors(&mut self, accessor: Accessor<'a>) -> Result<Vec<DVec3>, String> {
        let wide = |v: [f32; 3]| Vec3::from_array(v).as_dvec3();
        let buffers = &self.ours.buffers;
        if accessor.data_type() == DataType::F32 && accessor.view().is_some() {
            let read = Iter::<[f32; 3]>::new(accessor, |buffer| buffers.bytes(buffer.index()));
            return Ok(read.ok_or("no vectors")?.map(wide).collect());
        }
        self.shared.insert("quantized vectors and those without data");
        let read = buffers.vectors(accessor, "vectors").map_err(|error| error.to_string())?;
        Ok(read.into_iter().map(wide).collect())
    }

    fn morph(
        &mut self,
        node: &Node<'a>,
        primitive: &Primitive<'a>,
        positions: &mut [DVec3],
    ) -> Result<(), String> {
        let weights = node.weights().or(node.mesh().and_then(|mesh| mesh.weights()));
        for (target, &weight) in primitive.morph_targets().zip(weights.unwrap_or_default()) {
            if let Some(accessor) = target.positions().filter(|_| weight != 0.0) {
                let moves = self.vectors(accessor)?;
                positions.iter_mut().zip(moves).for_each(|(p, by)| *p += by * f64::from(weight));
            }
        }
        Ok(())
    }

    /// The vertices in the world; none where they cannot follow the skin.
    fn skinned(
        &self,
        skin: &Skin<'_>,
        primitive: &Primitive<'_>,
        positions: &[DVec3],
    ) -> Option<Vec<DVec3>> {
        let buffers = &self.ours.buffers;
        let joints: Option<Vec<DMat4>> =
            skin.joints().map(|joint| *self.worlds.get(joint.index())?).collect();
        let (joints, reader) = (joints?, primitive.reader(|buffer| buffers.bytes(buffer.index())));
        let skin_reader = skin.reader(|buffer| buffers.bytes(buffer.index()));
        let inverse: Option<Vec<DMat4>> = skin_reader.read_inverse_bind_matrices().map(|all| {
            let wide = |m: [[f32; 4]; 4]| DMat4::from_cols_array_2d(&m.map(|c| c.map(f64::from)));
            all.map(wide).collect()
        });
        let follow = |joint: usize, p: DVec3| {
            let p = match &inverse {
                Some(inverse) => inverse.get(joint)?.transform_point3(p),
                None => p,
            };
            Some(joints.get(joint)?.transform_point3(p))
        };
        let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
        let mut firsts: Vec<usize> = Vec::new();
        for set in 0.. {
            let (joints, weights) = (reader.read_joints(set), reader.read_weights(set));
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            let joints: Vec<[u16; 4]> = joints.into_u16().collect();
            if set == 0 {
                firsts = joints.iter().map(|joints| usize::from(joints[0])).collect();
            }
            let bonds = joints.into_iter().zip(weights.into_f32());
            for (((joints, weights), sum), &p) in bonds.zip(&mut sums).zip(positions) {
                for (joint, weight) in joints.into_iter().zip(weights.map(f64::from)) {
                    if weight != 0.0 {
                        sum.0 += follow(joint.into(), p)? * weight;
                        sum.1 += weight;
                    }
                }
            }
        }
        let placed = sums.iter().zip(&firsts).zip(positions).map(|((sum, &first), &p)| {
            if sum.1 > 0.0 { Some(sum.0 / sum.1) } else { follow(first, p) }
        });
        placed.collect::<Option<Vec<DVec3>>>().filter(|_| !firsts.is_empty())
    }
}

/// The most bytes of material files that it is given: it takes some hundred bytes a material.
const MAX_LIBRARY_BYTES: u64 = 4 << 20;

/// Its reading, and the names of its materials, if readable. It may panic.
pub(super) fn by_tobj(
    path: &Path,
    mut bytes: &[u8],
) -> Result<(Reading, Result<BTreeSet<String>, String>), String> {
    let options =
        tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let left = Cell::new(MAX_LIBRARY_BYTES);
    let library = |name: &Path| {
        let name = name.to_string_lossy();
        // as much of it as fits: each mention is read again
        let file = confined(folder, &name).ok_or(tobj::LoadError::OpenFileFailed)?;
        let text = read_at_most(&file, left.get()).map_err(|_| tobj::LoadError::OpenFileFailed)?;
        left.set(left.get() - text.len() as u64);
        tobj::load_mtl_buf(&mut text.as_slice())
    };
    let (models, materials) =
        tobj::load_obj_buf(&mut bytes, &options, library).map_err(|e| e.to_string())?;
    let mut reading = Reading::new();
    let name_of = |id: Option<usize>| {
        let material = materials.as_ref().ok().zip(id).and_then(|(all, id)| all.get(id));
        material.map_or("", |material| material.name.as_str())
    };
    let mut corners: Vec<DVec3> = Vec::new();
    for tobj::Model { mesh, .. } in &models {
        let mut rest = mesh.indices.as_slice();
        let mut arities = mesh.face_arities.iter();
        let mut triangles = 0;
        while !rest.is_empty() {
            // without arities all faces are triangles
            let arity = if mesh.face_arities.is_empty() {
                3
            } else {
                arities.next().map_or(rest.len(), |&n| n as usize)
            };
            let (face, after) = rest.split_at(arity.clamp(1, rest.len()));
            rest = after;
            corners.clear();
            corners.extend(face.iter().filter_map(|&i| {
                let xyz = mesh.positions.get(3 * i as usize..)?.first_chunk::<3>()?;
                Some(DVec3::from_array(*xyz))
            }));
            if Outline::of(&corners).has_area() {
                triangles += (corners.len() as u64).saturating_sub(2);
                corners.iter().for_each(|&corner| reading.bounds.include(corner));
            }
        }
        reading.add(name_of(mesh.material_id), triangles);
    }
    let known = materials
        .map(|all| all.into_iter().map(|material| material.name).collect())
        .map_err(|error| error.to_string());
    Ok((reading, known))
}
