//! Wavefront OBJ with its materials (MTL), read by a parser of our own: `scan` checks every line
//! and keeps what matters, this file makes the scene of it once the text is gone. (The crate tobj,
//! which was used before, has errors without lines, panics on some MTL files, and takes two and a
//! half times the memory; a test still compares with it.)
//!
//! Vertices and normals are numbered anew from each change of material on, in the order of their
//! use, so that what no face uses is not in the scene.
//! Faces keep their order. A triangle stays one, or becomes a patch when all its corners have
//! normals. A larger face becomes a polygon; it is split into triangles instead when it has
//! normals, when it is not flat, or when [`ObjOptions::triangulate`] asks for it. Faces without
//! area, lines, points and free-form curves are left out, each with a warning that counts them.
//! Texture coordinates are kept where a material has a texture (`textures`); such faces are split
//! into triangles, too.
//!
//! Geometry alone is needed: damaged normals, texture coordinates and materials make faces flat or
//! plain, and a face is left out only where one of its own corners is NaN; all with warnings.

mod contents;
mod libraries;
mod maps;
mod material;
mod rows;
mod scan;

use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError};
use crate::input::scene_name;
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::{FaceCounts, FirstAndCount, add_face};
use crate::obj::contents::{FaceLine, ObjScan};
use crate::obj::libraries::Materials;
use crate::obj::maps::{are_known, texcoords_of};
use crate::obj::material::parse_mtl;
use crate::obj::scan::scan;
use crate::scene::{Material, Scene};

/// How faces become primitives.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ObjOptions {
    /// Split every face with more than three corners, so that the scene is triangles only.
    pub triangulate: bool,
}

/// Parses OBJ text. `path` gives the scene its name and the folder of its `.mtl` files, and
/// appears in errors. Scenes have no lights and a camera that frames them.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::CountTooLarge`] and [`LoadError::IndexOutOfRange`] with the
/// line in the OBJ or MTL file, and [`LoadError::NoPrimitives`].
pub fn parse_obj(path: &Path, bytes: Vec<u8>, options: ObjOptions) -> Result<Scene, LoadError> {
    let scan = scan(path, bytes)?;
    let mut scene = Scene::new(scene_name(path));
    let materials = libraries::read(path, &scan, &mut scene)?;
    let mut builder = Builder {
        path,
        options,
        scene,
        materials: &materials,
        counts: FaceCounts::default(),
        without_texcoords: FirstAndCount::default(),
        positions: FreshIndices::new(scan.positions.len()),
        normals: FreshIndices::new(scan.normals.len()),
        nameless: None,
        own: Vec::new(),
        own_n: Vec::new(),
        points: Vec::new(),
    };
    let mut switches = scan.switches.iter().peekable();
    let (mut material, mut started) = (None, false);
    let mut rests =
        [&scan.corners, &scan.normal_corners, &scan.texcoord_corners].map(Vec::as_slice);
    for (i, face) in scan.faces.iter().enumerate() {
        while let Some((_, name)) = switches.next_if(|(before, _)| *before <= i) {
            let next = name.and_then(|name| materials.ids.get(name).copied());
            if next != material && started {
                // the material changes: vertices are numbered anew
                builder.positions.start += 1;
                builder.normals.start += 1;
                started = false;
            }
            material = next;
        }
        started = true;
        let own = rests.each_mut().map(|rest| {
            let (own, after) = rest.split_at_checked(face.corners as usize).unwrap_or_default();
            *rest = after;
            own
        });
        builder.add(*face, own, &scan, material)?;
    }
    let Builder { mut scene, counts, without_texcoords, .. } = builder;
    if scene.primitives.is_empty() {
        return Err(LoadError::no_primitives(path, "face (f) with an area"));
    }
    counts.warn(&mut scene);
    let what = "faces of textured materials without texture coordinates have the plain colour";
    without_texcoords.warn(what, &mut scene);
    scan.odd.warn(&mut scene);
    if let Some((line, word)) = &scan.first_unknown {
        let (file, count) = (path.display(), scan.unknown);
        scene.warn(format!("{file}:{line}: {count} lines with unknown keywords (first: {word})"));
    }
    scene.frame_camera();
    Ok(scene)
}

/// Parses MTL text: the materials in file order, without their textures. Damaged lines are left
/// out.
///
/// # Errors
/// [`LoadError::CountTooLarge`] with the line, [`LoadError::Syntax`] for UTF-16.
pub fn parse_materials(path: &Path, bytes: Vec<u8>) -> Result<Vec<Material>, LoadError> {
    Ok(parse_mtl(path, bytes)?.entries.into_iter().map(|(material, _)| material).collect())
}

/// New numbers for the elements of a list, in the order of their use since the last fresh start.
struct FreshIndices {
    /// For each element the start it was last used after, and its number then.
    last: Vec<(u32, u32)>,
    start: u32,
}

impl FreshIndices {
    fn new(count: usize) -> Self {
        Self { last: vec![(0, 0); count], start: 1 }
    }

    /// The number of an element; at its first use it is added to `to`.
    fn number(&mut self, element: u32, from: &[DVec3], to: &mut Vec<DVec3>) -> Option<u32> {
        let last = self.last.get_mut(element as usize)?;
        if last.0 != self.start {
            *last = (self.start, u32::try_from(to.len()).ok()?);
            to.push(*from.get(element as usize)?);
        }
        Some(last.1)
    }
}

struct Builder<'a> {
    path: &'a Path,
    options: ObjOptions,
    scene: Scene,
    materials: &'a Materials,
    counts: FaceCounts,
    without_texcoords: FirstAndCount,
    positions: FreshIndices,
    normals: FreshIndices,
    /// The material of faces before any `usemtl`.
    nameless: Option<u32>,
    own: Vec<u32>,
    own_n: Vec<u32>,
    points: Vec<DVec3>,
}

impl Builder<'_> {
    /// Adds a face with the indices of its corners, of their normals, and of their texture
    /// coordinates.
    fn add(
        &mut self,
        face: FaceLine,
        [corners, normals, texcoords]: [&[u32]; 3],
        scan: &ObjScan,
        material: Option<u32>,
    ) -> Result<(), LoadError> {
        let Self { path, options, scene, materials, counts, own, own_n, points, .. } = self;
        let place = || FilePlace::line(path, face.line as usize);
        let material = match material {
            Some(id) => id,
            None => *self.nameless.get_or_insert_with(|| scene.push_material(Material::default())),
        };
        // a face makes at most three times as many vertices and primitives as it has corners
        let size = scene.vertices.len().max(scene.primitives.len()) + 3 * corners.len();
        limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", place)?;
        let has_damaged = |indices: &[u32], of: &[DVec3]| {
            indices.iter().any(|&i| of.get(i as usize).is_some_and(|v| v.is_nan()))
        };
        if scan.odd.positions.is_any() && has_damaged(corners, &scan.positions) {
            counts.unusable.add(place);
            return Ok(());
        }
        // reused from face to face: files have millions
        own.clear();
        own_n.clear();
        points.clear();
        let number = |&i: &u32| self.positions.number(i, &scan.positions, &mut scene.vertices);
        own.extend(corners.iter().filter_map(number));
        let is_damaged = scan.odd.normals.is_any() && has_damaged(normals, &scan.normals);
        if face.smooth && !is_damaged {
            let number = |&i: &u32| self.normals.number(i, &scan.normals, &mut scene.normals);
            own_n.extend(normals.iter().filter_map(number));
        }
        if own.len() != corners.len() {
            let (place, count) = (FilePlace::file(path), scene.vertices.len() as u64);
            return Err(LoadError::too_many(place, "vertices", count, u32::MAX.into()));
        }
        points.extend(corners.iter().filter_map(|&i| scan.positions.get(i as usize)));
        let is_textured =
            scene.materials.get(material as usize).is_some_and(|m| m.texture.is_some());
        let is_placed = is_textured && are_known(texcoords, &scan.texcoords);
        let may_stay = own_n.is_empty() && !is_placed && !options.triangulate;
        let push = |piece: [usize; 3], scene: &mut Scene| {
            let pick = |from: &[u32]| match piece.map(|i| from.get(i).copied()) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            };
            let Some(v) = pick(own) else { return };
            scene.push_corners(material, v, pick(own_n));
            let placement = materials.placements.get(&material);
            if is_placed
                && let Some(uv) = texcoords_of(piece, texcoords, &scan.texcoords, placement)
            {
                scene.last_is_textured(uv);
            }
        };
        let is_there = add_face(material, points, may_stay, scene, counts, place, push)?;
        if is_there && is_textured && !is_placed {
            self.without_texcoords.add(place);
        }
        Ok(())
    }
}
