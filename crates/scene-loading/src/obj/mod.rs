//! Wavefront OBJ with its materials (MTL), read by a parser of our own: `scan` checks every
//! line and keeps what matters, this file makes the scene of it once the text is gone. (The crate
//! tobj, which was used before, has errors without lines, panics on some MTL files, and takes two and
//! a half times the memory; a test still compares with it.)
//!
//! Vertices and normals are numbered anew from each change of material on, in the order of their
//! use, so that what no face uses is not in the scene.
//! Faces keep their order. A triangle becomes a [`Shape::Triangle`], or a [`Shape::Patch`] when
//! all its corners have normals. A larger face becomes a [`Shape::Polygon`]; it is split into
//! triangles instead when it has normals, when it is not flat, or when
//! [`ObjOptions::triangulate`] asks for it. Faces without area, lines, points and free-form
//! curves are left out, each with a warning that counts them. Texture coordinates are kept where a
//! material has a texture (`textures`); such faces are split into triangles, too.

pub mod export;
mod material;
mod scan;
mod textures;

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError};
use crate::input::decompress::decompress;
use crate::input::read::{confined, is_missing, read_at_most, read_file, scene_name};
use crate::limits::{self, MAX_ELEMENTS, MAX_MATERIALS};
use crate::obj::material::{MAX_LIBRARY_BYTES, parse_mtl};
use crate::obj::scan::{FaceLine, NONE, ObjScan, scan};
use crate::obj::textures::{ColorMaps, FaceTexcoords};
use crate::polygon::ear_clipping::{triangulate, triangulate_bent};
use crate::polygon::{area_vector, is_flat};
use crate::scene::{Material, Primitive, Scene, Shape, Warning};

/// The most names that a warning lists.
const MAX_NAMES: usize = 20;

/// How faces become primitives.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ObjOptions {
    /// Split every face with more than three corners, so that the scene is triangles only.
    pub triangulate: bool,
}

/// Loads an `.obj` or `.obj.zst` file and the `.mtl` files next to it.
///
/// # Errors
/// Any [`LoadError`] of reading and unpacking, and of [`parse_obj`].
pub fn load_obj(path: &Path, options: ObjOptions) -> Result<Scene, LoadError> {
    let bytes = decompress(path, read_file(path)?)?;
    parse_obj(path, bytes, options)
}

/// Parses OBJ text. `path` gives the scene its name and the folder of its `.mtl` files, and
/// appears in errors. Scenes have no lights and a camera that frames them.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::NotFinite`], [`LoadError::OutOfRange`] and
/// [`LoadError::IndexOutOfRange`] with the line in the OBJ or MTL file, and
/// [`LoadError::NoPrimitives`].
pub fn parse_obj(path: &Path, bytes: Vec<u8>, options: ObjOptions) -> Result<Scene, LoadError> {
    let mut scan = scan(path, bytes)?;
    let mut scene = Scene::new(scene_name(path));
    let ids = materials(path, &scan, &mut scene)?;
    let (faces, corners) = (std::mem::take(&mut scan.faces), std::mem::take(&mut scan.corners));
    let mut builder = Builder {
        path,
        options,
        scene,
        texcoords: FaceTexcoords::new(&scan),
        counts: Counts::default(),
        positions: Renumbered::new(scan.positions.len()),
        normals: Renumbered::new(scan.normals.len()),
        nameless: None,
        own: Vec::new(),
        own_n: Vec::new(),
        points: Vec::new(),
    };
    let mut switches = scan.switches.iter().peekable();
    let (mut material, mut started) = (None, false);
    let (mut rest, mut rest_n) = (corners.as_slice(), scan.normal_corners.as_slice());
    for (i, face) in faces.iter().enumerate() {
        while let Some((_, name)) = switches.next_if(|(before, _)| *before <= i) {
            let next = ids.get(*name).copied();
            if next != material && started {
                builder.new_numbers();
                started = false;
            }
            material = next;
        }
        started = true;
        let count = face.corners as usize;
        let (own, own_n);
        (own, rest) = rest.split_at_checked(count).unwrap_or_default();
        (own_n, rest_n) = rest_n.split_at_checked(count).unwrap_or_default();
        builder.add(*face, own, own_n, &scan, material)?;
    }
    let Builder { mut scene, counts, .. } = builder;
    if scene.primitives.is_empty() {
        let expected = "face (f) with an area";
        return Err(LoadError::NoPrimitives { place: FilePlace::file(path), expected });
    }
    report(path, &scan, &counts, &mut scene);
    scene.frame_camera();
    Ok(scene)
}

/// Parses MTL text: the materials in file order, without their textures.
///
/// # Errors
/// [`LoadError::Syntax`] and [`LoadError::NotFinite`] with the line.
pub fn parse_materials(path: &Path, bytes: Vec<u8>) -> Result<Vec<Material>, LoadError> {
    Ok(parse_mtl(path, bytes)?.into_iter().map(|(material, _)| material).collect())
}

/// Fills the scene's materials from the MTL files, each read once; of several materials of a name
/// the last counts. Names that are used but not defined get the default material under their name.
/// Returns the index of each name of [`ObjScan::used`].
fn materials(path: &Path, scan: &ObjScan, scene: &mut Scene) -> Result<Vec<u32>, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut maps = ColorMaps::default();
    let mut ids: HashMap<String, u32> = HashMap::new();
    let mut left = MAX_LIBRARY_BYTES;
    for (line, library) in &scan.libraries {
        let place = || FilePlace::line(path, *line);
        let Some(file) = confined(folder, library) else {
            let text = format!("{}: mtllib `{library}` leads out of the folder; not read", place());
            scene.warnings.push(Warning(text));
            continue;
        };
        if is_missing(&file) {
            let text = format!("{}: material file {} is missing", place(), file.display());
            scene.warnings.push(Warning(text));
            continue;
        }
        let bytes = read_at_most(&file, left)?;
        left -= bytes.len() as u64;
        let entries = parse_mtl(&file, bytes)?;
        maps.begin(&file);
        for (material, map) in entries {
            let id = match ids.get(&material.name) {
                Some(&known) => known,
                None => {
                    let id = new_id(scene, place)?;
                    ids.insert(material.name.clone(), id);
                    scene.materials.push(Material::default());
                    id
                }
            };
            if let Some(slot) = scene.materials.get_mut(id as usize) {
                *slot = material;
            }
            maps.set(id, map);
        }
    }
    maps.read(scan.used.iter().filter_map(|(_, name)| ids.get(name).copied()), scene);
    let (mut undefined, mut listed) = (0, Vec::new());
    let mut found = Vec::with_capacity(scan.used.len());
    for (line, name) in &scan.used {
        if let Some(&id) = ids.get(name) {
            found.push(id);
            continue;
        }
        let id = new_id(scene, || FilePlace::line(path, *line))?;
        ids.insert(name.clone(), id);
        scene.materials.push(Material { name: name.clone(), ..Material::default() });
        found.push(id);
        undefined += 1;
        if undefined <= MAX_NAMES {
            listed.push(format!("`{name}` (line {line})"));
        }
    }
    if undefined > 0 {
        let (file, count, more) = (path.display(), undefined, undefined - listed.len());
        let mut list = listed.join(", ");
        if more > 0 {
            list.push_str(&format!(" and {more} more"));
        }
        let text = format!("{file}: {count} materials are not defined and look default: {list}");
        scene.warnings.push(Warning(text));
    }
    Ok(found)
}

/// The index of the scene's next material.
fn new_id(scene: &Scene, place: impl FnOnce() -> FilePlace) -> Result<u32, LoadError> {
    let id = scene.materials.len();
    limits::check(id + 1, MAX_MATERIALS, "the number of materials", place)?;
    Ok(u32::try_from(id).unwrap_or(u32::MAX))
}

fn too_many(path: &Path, what: &str, count: usize) -> LoadError {
    let (place, what) = (FilePlace::file(path), what.to_string());
    LoadError::CountTooLarge { place, what, count: count as u64, limit: u32::MAX.into() }
}

/// Faces that were not taken as they are.
#[derive(Default)]
struct Counts {
    without_area: Tally,
    bent: Tally,
    without_texcoords: Tally,
}

/// How many, and the line of the first.
#[derive(Default)]
struct Tally {
    count: usize,
    first: u32,
}

impl Tally {
    fn add(&mut self, line: u32) {
        if self.count == 0 {
            self.first = line;
        }
        self.count += 1;
    }
}

/// New numbers for the elements of a list, in the order of their use since the last fresh start.
struct Renumbered {
    /// For each element the start it was last used after, and its number then.
    last: Vec<(u32, u32)>,
    start: u32,
}

impl Renumbered {
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
    texcoords: FaceTexcoords<'a>,
    counts: Counts,
    positions: Renumbered,
    normals: Renumbered,
    /// The material of faces before any `usemtl`.
    nameless: Option<u32>,
    own: Vec<u32>,
    own_n: Vec<u32>,
    points: Vec<DVec3>,
}

impl Builder<'_> {
    /// The material changes: vertices are numbered anew.
    fn new_numbers(&mut self) {
        self.positions.start += 1;
        self.normals.start += 1;
    }

    /// Adds a face with the indices of its corners and of their normals.
    fn add(
        &mut self,
        face: FaceLine,
        corners: &[u32],
        normals: &[u32],
        scan: &ObjScan,
        material: Option<u32>,
    ) -> Result<(), LoadError> {
        let material = match material {
            Some(id) => id,
            None => self.default_material(),
        };
        // a face makes at most as many vertices and primitives as it has corners
        let size = self.scene.vertices.len().max(self.scene.primitives.len()) + corners.len();
        if size > MAX_ELEMENTS {
            let place = || FilePlace::line(self.path, face.line as usize);
            limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", place)?;
        }
        self.texcoords.next_face(corners.len());
        // Reused from face to face: files have millions.
        let (mut own, mut own_n) = (std::mem::take(&mut self.own), std::mem::take(&mut self.own_n));
        let mut points = std::mem::take(&mut self.points);
        own.clear();
        own_n.clear();
        points.clear();
        let scene = &mut self.scene;
        let number = |&i: &u32| self.positions.number(i, &scan.positions, &mut scene.vertices);
        own.extend(corners.iter().filter_map(number));
        let number = |&i: &u32| self.normals.number(i, &scan.normals, &mut scene.normals);
        own_n.extend(normals.iter().filter(|i| **i != NONE).filter_map(number));
        if !face.smooth {
            own_n.clear();
        }
        if own.len() != corners.len() {
            return Err(too_many(self.path, "vertices", scene.vertices.len()));
        }
        points.extend(corners.iter().filter_map(|&i| scan.positions.get(i as usize)));
        self.face(material, &own, &own_n, &points, face)?;
        (self.own, self.own_n, self.points) = (own, own_n, points);
        Ok(())
    }

    fn default_material(&mut self) -> u32 {
        let scene = &mut self.scene;
        *self.nameless.get_or_insert_with(|| scene.push_material(Material::default()))
    }

    fn face(
        &mut self,
        material: u32,
        corners: &[u32],
        normals: &[u32],
        points: &[DVec3],
        face: FaceLine,
    ) -> Result<(), LoadError> {
        let Some(area) = area_vector(points) else {
            self.counts.without_area.add(face.line);
            return Ok(());
        };
        let textured =
            self.scene.materials.get(material as usize).is_some_and(|m| m.texture.is_some());
        let textured = textured && {
            let known = self.texcoords.are_known();
            if !known {
                self.counts.without_texcoords.add(face.line);
            }
            known
        };
        if corners.len() == 3 {
            self.push(material, corners, normals, textured, [0, 1, 2]);
            return Ok(());
        }
        let flat = is_flat(points, area);
        if !flat {
            self.counts.bent.add(face.line);
        }
        if flat && normals.is_empty() && !textured && !self.options.triangulate {
            self.scene.push_polygon(material, points);
            return Ok(());
        }
        let pieces = if flat { triangulate(points) } else { triangulate_bent(points, area) };
        let pieces = pieces.map_err(|source| LoadError::Entangled {
            place: FilePlace::line(self.path, face.line as usize),
            source,
        })?;
        for piece in pieces {
            let piece = piece.map(|i| i as usize);
            let place = piece.map(|i| points.get(i).copied().unwrap_or_default());
            if area_vector(&place).is_some() {
                self.push(material, corners, normals, textured, piece);
            }
        }
        Ok(())
    }

    fn push(
        &mut self,
        material: u32,
        corners: &[u32],
        normals: &[u32],
        textured: bool,
        piece: [usize; 3],
    ) {
        let pick = |from: &[u32]| match piece.map(|i| from.get(i).copied()) {
            [Some(a), Some(b), Some(c)] => Some([a, b, c]),
            _ => None,
        };
        let shape = match (pick(corners), pick(normals)) {
            (Some(v), Some(n)) => Shape::Patch { v, n },
            (Some(v), None) => Shape::Triangle { v },
            (None, _) => return,
        };
        self.scene.primitives.push(Primitive { shape, material });
        if textured && let Some(texcoords) = self.texcoords.of(piece) {
            self.scene.last_is_textured(texcoords);
        }
    }
}

/// One warning for each kind of thing that was left out or changed.
fn report(path: &Path, scan: &ObjScan, counts: &Counts, scene: &mut Scene) {
    let file = path.display();
    let mut warn = |count: usize, text: String| {
        if count > 0 {
            scene.warnings.push(Warning(text));
        }
    };
    let Tally { count, first } = counts.without_area;
    warn(count, format!("{file}: {count} faces without area left out (first: line {first})"));
    let Tally { count, first } = counts.bent;
    warn(count, format!("{file}: {count} faces that are not flat split (first: line {first})"));
    let Tally { count, first } = counts.without_texcoords;
    let what = "faces of textured materials without texture coordinates have the plain colour";
    warn(count, format!("{file}: {count} {what} (first: line {first})"));
    warn(scan.lines, format!("{file}: {} line elements left out", scan.lines));
    warn(scan.points, format!("{file}: {} point elements left out", scan.points));
    warn(scan.curves, format!("{file}: {} free-form curves and surfaces left out", scan.curves));
    if let Some((line, word)) = &scan.first_unknown {
        let count = scan.unknown;
        let text = format!("{file}:{line}: {count} lines with unknown keywords (first: {word})");
        warn(count, text);
    }
}
