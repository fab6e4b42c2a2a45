//! Wavefront OBJ with its materials (MTL), parsed by the crate `tobj` after a scan of our own
//! (`obj_scan`) that finds what tobj lets through and gives errors their lines.
//!
//! Faces keep their order. A triangle becomes a [`Shape::Triangle`], or a [`Shape::Patch`] when
//! all its corners have normals. A larger face becomes a [`Shape::Polygon`]; it is split into
//! triangles instead when it has normals, when it is not flat, or when
//! [`ObjOptions::triangulate`] asks for it. Faces without area, lines, points and free-form
//! curves are left out, each with a warning that counts them. Texture coordinates are kept where a
//! material has a texture (`obj_textures`); such faces are split into triangles, too.

use std::collections::HashMap;
use std::io::{Cursor, Read};
use std::path::Path;

use glam::DVec3;

use crate::error::{LoadError, Place};
use crate::obj_material::{Mtl, parse_mtl};
use crate::obj_polygon::{area_vector, is_flat, triangulate};
use crate::obj_scan::{FaceLine, ObjScan, scan};
use crate::obj_textures::{ColorMaps, FaceTexcoords};
use crate::scene::{Material, Primitive, Scene, Shape, Warning};
use crate::source_read::{MAX_BYTES, confined, decompress, lossy_text, read_file, scene_name};

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
    let bytes = decompress(path, read_file(path)?, MAX_BYTES)?;
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
    let scan = scan(path, lossy_text(bytes))?;
    let mut scene = Scene::new(scene_name(path));
    let ids = materials(path, &scan, &mut scene)?;
    let models = parse_models(path, &scan, &ids)?;
    let mut faces = scan.faces.iter();
    let mut builder = Builder {
        path,
        options,
        scene,
        texcoords: FaceTexcoords::new(&scan),
        counts: Counts::default(),
        pieces: vec![],
    };
    for model in &models {
        builder.add(&model.mesh, &mut faces)?;
    }
    let Builder { mut scene, counts, .. } = builder;
    if scene.primitives.is_empty() {
        let expected = "face (f) with an area";
        return Err(LoadError::NoPrimitives { place: Place::file(path), expected });
    }
    report(path, &scan, &counts, &mut scene);
    scene.frame_camera();
    Ok(scene)
}

/// Fills the scene's materials from the MTL files; names that are used but not defined get the
/// default material under their name. Returns the index of each name.
fn materials(
    path: &Path,
    scan: &ObjScan,
    scene: &mut Scene,
) -> Result<HashMap<String, usize>, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut maps = ColorMaps::default();
    for (line, library) in &scan.libraries {
        let place = Place::line(path, *line);
        let Some(file) = confined(folder, library) else {
            let text = format!("{place}: mtllib `{library}` leads out of the folder; not read");
            scene.warnings.push(Warning(text));
            continue;
        };
        if !file.exists() {
            let text = format!("{place}: material file {} is missing", file.display());
            scene.warnings.push(Warning(text));
            continue;
        }
        let Mtl { materials, maps: found } = parse_mtl(&file, read_file(&file)?)?;
        maps.found(&file, scene.materials.len(), found);
        scene.materials.extend(materials);
    }
    let mut ids: HashMap<String, usize> = HashMap::new();
    for (i, material) in scene.materials.iter().enumerate() {
        ids.insert(material.name.clone(), i);
    }
    maps.read(scan.used.iter().filter_map(|(_, name)| ids.get(name).copied()), scene);
    let mut undefined: Vec<String> = Vec::new();
    for (line, name) in &scan.used {
        if !ids.contains_key(name) {
            undefined.push(format!("`{name}` (line {line})"));
            ids.insert(name.clone(), scene.materials.len());
            scene.materials.push(Material { name: name.clone(), ..Material::default() });
        }
    }
    if !undefined.is_empty() {
        let (file, count) = (path.display(), undefined.len());
        let list = undefined.join(", ");
        let text = format!("{file}: {count} materials are not defined and look default: {list}");
        scene.warnings.push(Warning(text));
    }
    Ok(ids)
}

/// Runs tobj over the cleaned text. It gets our table of materials through one `mtllib` that is
/// put in front, so that it splits the faces by material.
fn parse_models(
    path: &Path,
    scan: &ObjScan,
    ids: &HashMap<String, usize>,
) -> Result<Vec<tobj::Model>, LoadError> {
    let options = tobj::LoadOptions {
        single_index: false,
        triangulate: false,
        ignore_points: true,
        ignore_lines: true,
    };
    let mut input = Cursor::new(b"mtllib checked\n").chain(Cursor::new(scan.text.as_slice()));
    let known = |_: &Path| Ok((Vec::new(), ids.clone().into_iter().collect()));
    let (models, _) = tobj::load_obj_buf(&mut input, &options, known)
        .map_err(|error| parser_error(path, error.to_string()))?;
    Ok(models)
}

fn parser_error(path: &Path, message: String) -> LoadError {
    LoadError::Parser { place: Place::file(path), parser: "tobj", message }
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

struct Builder<'a> {
    path: &'a Path,
    options: ObjOptions,
    scene: Scene,
    texcoords: FaceTexcoords<'a>,
    counts: Counts,
    pieces: Vec<[usize; 3]>,
}

impl Builder<'_> {
    /// Adds one of tobj's meshes: the faces from one `usemtl` to the next.
    fn add(
        &mut self,
        mesh: &tobj::Mesh,
        lines: &mut std::slice::Iter<'_, FaceLine>,
    ) -> Result<(), LoadError> {
        if mesh.indices.is_empty() {
            return Ok(());
        }
        let lost = || parser_error(self.path, "faces do not match the file's".into());
        let material = match mesh.material_id {
            Some(id) => u32::try_from(id).map_err(|_| lost())?,
            None => self.default_material(),
        };
        let base = u32::try_from(self.scene.vertices.len()).map_err(|_| lost())?;
        let base_n = u32::try_from(self.scene.normals.len()).map_err(|_| lost())?;
        self.scene.vertices.extend(triples(&mesh.positions));
        self.scene.normals.extend(triples(&mesh.normals));
        // Reused from face to face: files have millions.
        let (mut own, mut own_n, mut points) = (Vec::new(), Vec::new(), Vec::new());
        let mut rest = mesh.indices.as_slice();
        let mut rest_n = mesh.normal_indices.as_slice();
        let mut arities = mesh.face_arities.iter();
        while !rest.is_empty() {
            // tobj leaves the arities out when all faces are triangles.
            let arity = arities.next().map_or(3, |&n| n as usize);
            let face = *lines.next().ok_or_else(lost)?;
            self.texcoords.next_face(arity);
            let (corners, after) = rest.split_at_checked(arity).ok_or_else(lost)?;
            rest = after;
            let mut normals: &[u32] = &[];
            if !rest_n.is_empty() {
                (normals, rest_n) = rest_n.split_at_checked(arity).ok_or_else(lost)?;
            }
            own.clear();
            own.extend(corners.iter().map(|i| base + i));
            own_n.clear();
            if face.smooth {
                own_n.extend(normals.iter().map(|i| base_n + i));
            }
            points.clear();
            points.extend(own.iter().filter_map(|&i| self.scene.vertices.get(i as usize)));
            self.face(material, &own, &own_n, &points, face);
        }
        Ok(())
    }

    fn default_material(&mut self) -> u32 {
        let found = self.scene.materials.iter().position(|m| m.name.is_empty());
        match found.and_then(|i| u32::try_from(i).ok()) {
            Some(id) => id,
            None => self.scene.push_material(Material::default()),
        }
    }

    fn face(
        &mut self,
        material: u32,
        corners: &[u32],
        normals: &[u32],
        points: &[DVec3],
        face: FaceLine,
    ) {
        let Some(area) = area_vector(points) else {
            self.counts.without_area.add(face.line);
            return;
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
            return;
        }
        let flat = is_flat(points, area);
        if !flat {
            self.counts.bent.add(face.line);
        }
        if flat && normals.is_empty() && !textured && !self.options.triangulate {
            self.scene.push_polygon(material, points);
            return;
        }
        let mut pieces = std::mem::take(&mut self.pieces);
        triangulate(points, area, &mut pieces);
        for &piece in &pieces {
            self.push(material, corners, normals, textured, piece);
        }
        self.pieces = pieces;
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

fn triples(values: &[f64]) -> impl Iterator<Item = DVec3> {
    values.chunks_exact(3).map(DVec3::from_slice)
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
        let text = format!("{file}:{line}: {count} lines with unknown keywords (first: `{word}`)");
        warn(count, text);
    }
}
