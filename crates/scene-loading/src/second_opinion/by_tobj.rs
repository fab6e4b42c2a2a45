//! OBJ files as the crate `tobj` reads them.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;

use super::reading::Reading;
use crate::input::read::{confined, read_at_most};
use crate::polygon::Outline;

/// The most bytes of material files that it is given: it takes some hundred bytes a material.
const MAX_LIBRARY_BYTES: u64 = 4 << 20;

/// Its reading, and the names of its materials, if readable. It may panic.
pub(super) fn read(
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
