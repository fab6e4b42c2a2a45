//! Scene descriptions of PBRT, version 4 (M. Pharr, W. Jakob, G. Humphreys,
//! pbrt.org/fileformat-v4), as far as a benchmark of acceleration structures needs them. Those of
//! versions 2 and 3 place shapes in the same way, and are read with a warning.
//!
//! - Shapes `trianglemesh`, `plymesh`, `bilinearmesh` (as quadrangles, split where they are bent)
//!   and `sphere` (whole; only under transforms that keep it one). Others are left out and counted.
//! - All transforms, attributes (`Attribute` for shapes, lights and materials), `Include` and
//!   `Import`; objects and their instances: each is a copy of the object's shapes, and noted in
//!   `Scene::instances`.
//! - The camera's place, direction and field of view. PBRT's camera space is left-handed: without
//!   `Scale -1 1 1` before it, the image here is the mirror image of PBRT's.
//! - `point`, `spot` (both as points) and `distant` lights (as in `tray_racing`). Area lights are
//!   plain surfaces, environments are left out; both are counted.
//! - Colours of `diffuse` and `coateddiffuse`, and of `matte` and its like of version 3;
//!   `conductor`s are mirrors, `dielectric`s glass. Textures and spectra are not read: what has one
//!   is grey.
//! - Everything else (film, sampler, media, ...) is passed over.
//!
//! Files that are named must lie in the folder of the first one, from which their names count.

mod looks;
mod params;
mod shapes;
pub(crate) mod state;
mod tokens;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DMat4;

use crate::error::{FilePlace, LoadError, shortened};
use crate::input::{confined, decompress, read_at_most, scene_name, text_of};
use crate::limits::{self, MAX_BYTES, MAX_LIGHTS, MAX_MATERIALS, MAX_WARNINGS};
use crate::mesh::{FaceCounts, FirstAndCount};
use crate::pbrt::looks::{LightEntry, add_lights};
use crate::pbrt::params::Params;
use crate::pbrt::shapes::ShapeSink;
use crate::pbrt::state::{Attributes, State};
use crate::ply::add_ply;
use crate::progress;
use crate::scene::{Camera, Material, Scene};
use crate::words::{Word, Words};

/// How deep files may include others, and how many there may be of all.
const MAX_INCLUDES: usize = 16;
const MAX_FILES: usize = 1 << 16;

/// Spheres under transforms that do not keep them spheres.
const ELLIPSOIDS: &str = "ellipsoids (spheres that their transform stretches) left out";

/// The most objects that instances may be made of.
const MAX_OBJECTS: usize = 1 << 20;

/// Parses a PBRT file, and reads the files that it names. `path` gives the scene its name and
/// appears in errors. `triangulate` splits quadrangles and the larger faces of PLY files.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::NotFinite`],
/// [`LoadError::OutOfRange`], [`LoadError::CountTooLarge`], [`LoadError::IndexOutOfRange`] with the
/// line, [`LoadError::OutsideFolder`], [`LoadError::Io`] and those of PLY for files that are
/// named, and [`LoadError::NoPrimitives`].
pub fn parse_pbrt(path: &Path, bytes: Vec<u8>, triangulate: bool) -> Result<Scene, LoadError> {
    let mut loader = Loader {
        folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
        triangulate,
        scene: Scene::new(scene_name(path)),
        budget: MAX_BYTES.saturating_sub(bytes.len() as u64),
        ..Loader::default()
    };
    loader.file(path, &text_of(path, bytes)?, 0)?;
    progress::end();
    if loader.state.depth() > 0 || loader.object.is_some() {
        let expected = "AttributeEnd or ObjectEnd for each beginning";
        return Err(LoadError::unexpected_end(FilePlace::file(path), expected));
    }
    let Loader { mut scene, camera, lights, counts, left_out, .. } = loader;
    if scene.primitives.is_empty() {
        let expected = "Shape trianglemesh, plymesh, bilinearmesh or sphere";
        return Err(LoadError::no_primitives(path, expected));
    }
    counts.warn(&mut scene);
    left_out.iter().for_each(|(what, tally)| tally.warn(what, &mut scene));
    match camera {
        Some(camera) => scene.camera = camera,
        None => scene.frame_camera(),
    }
    add_lights(&lights, &mut scene);
    Ok(scene)
}

#[derive(Default)]
struct Loader {
    folder: PathBuf,
    triangulate: bool,
    scene: Scene,
    camera: Option<Camera>,
    lights: Vec<LightEntry>,
    state: State,
    materials: HashMap<String, u32>,
    /// The material of shapes before any `Material`.
    plain: Option<u32>,
    /// The shapes of objects, placed as where they are defined.
    objects: HashMap<String, (u32, Rc<Scene>)>,
    /// The object that is being defined.
    object: Option<(String, Scene)>,
    counts: FaceCounts,
    /// Descriptions of omitted items.
    left_out: BTreeMap<String, FirstAndCount>,
    files: usize,
    /// Bytes that may still be read.
    budget: u64,
}

impl Loader {
    fn file(&mut self, path: &Path, text: &str, depth: usize) -> Result<(), LoadError> {
        let mut words = Words::new(path, text).of_pbrt();
        if depth == 0 {
            progress::begin(text.len());
        }
        while let Some(word) = words.next() {
            if depth == 0 {
                progress::at(text.len() - words.remaining());
            }
            if !word.is_directive() {
                let expected = "a directive as Shape, Translate, AttributeBegin";
                return Err(LoadError::syntax(words.place(word.line), word.text, expected));
            }
            self.statement(word, &mut words, depth)?;
        }
        words.check_closed()
    }

    fn statement(
        &mut self,
        word: Word<'_>,
        words: &mut Words<'_>,
        depth: usize,
    ) -> Result<(), LoadError> {
        let (path, line) = (words.path, word.line);
        let place = || FilePlace::line(path, line);
        if self.state.statement(word, words)? {
            return Ok(());
        }
        match word.text {
            "WorldBegin" => {
                self.state.now = Attributes::default();
                self.state.name_system("world", DMat4::IDENTITY, place)?;
            }
            "Camera" => self.camera(word, words)?,
            "LightSource" => self.light(word, words)?,
            "AreaLightSource" => {
                words.quoted("type")?;
                Params::read(words, line, None)?;
                self.state.now.shines = true;
            }
            "Material" => {
                let kind = words.name("type")?;
                let params = self.params(words, line, "material")?;
                self.state.now.material = Some(self.material("", &kind, &params)?);
            }
            "MakeNamedMaterial" => {
                let name = words.name("name")?;
                let params = self.params(words, line, "material")?;
                let kind = params.string("type").unwrap_or_default().to_owned();
                let id = self.material(&name, &kind, &params)?;
                self.materials.insert(name, id);
            }
            "NamedMaterial" => {
                let name = words.name("name")?;
                let Some(&id) = self.materials.get(&name) else {
                    return Err(LoadError::syntax(place(), &name, "a named material before it"));
                };
                self.state.now.material = Some(id);
            }
            "ObjectBegin" => {
                let name = words.name("name")?;
                if self.object.is_some() {
                    return Err(LoadError::syntax(place(), "ObjectBegin", "ObjectEnd before it"));
                }
                let count = self.objects.len() + 1;
                limits::check(count, MAX_OBJECTS, "the number of objects", place)?;
                self.state.save(place)?;
                self.object = Some((name, Scene::default()));
            }
            "ObjectEnd" => {
                let Some((name, mut object)) = self.object.take() else {
                    return Err(LoadError::syntax(place(), "ObjectEnd", "ObjectBegin before it"));
                };
                self.scene.warnings.append(&mut object.warnings);
                let number = self.objects.len() as u32;
                self.objects.insert(name, (number, Rc::new(object)));
                self.state.restore(word.text, place)?;
            }
            "ObjectInstance" => self.instance(word, words)?,
            "Shape" => self.shape(word, words)?,
            "Include" | "Import" => self.include(word, words, depth)?,
            "Attribute" => self.attribute(word, words)?,
            "WorldEnd" | "SurfaceIntegrator" | "VolumeIntegrator" | "Renderer" | "Volume" => {
                let what = "statements from before PBRT version 4; read as far as both agree";
                self.leave_out(what.into(), place);
                words.pass_over();
            }
            "Accelerator" | "ColorSpace" | "Film" | "Integrator" | "MakeNamedMedium"
            | "MediumInterface" | "Option" | "PixelFilter" | "ReverseOrientation" | "Sampler"
            | "Texture" | "TransformTimes" => words.pass_over(),
            other => {
                let expected = "a directive of PBRT, version 4";
                return Err(LoadError::syntax(place(), other, expected));
            }
        }
        Ok(())
    }

    /// `Attribute "shape" ...`: parameters for statements of a kind that follow.
    fn attribute(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), LoadError> {
        let target = words.name("target")?;
        let known = ["shape", "light", "material"].into_iter().find(|known| *known == target);
        let Some(known) = known else {
            let params = Params::read(words, word.line, None)?;
            let what = format!("attributes of {} left out", shortened(&target));
            self.leave_out(what, || params.place());
            return Ok(());
        };
        let params = self.params(words, word.line, known)?;
        params.check_depth()?;
        self.state.now.inherited.insert(known, Rc::new(params));
        Ok(())
    }

    /// The parameters of a statement of a kind that `Attribute` may give some.
    fn params(&self, words: &mut Words<'_>, line: usize, kind: &str) -> Result<Params, LoadError> {
        Params::read(words, line, self.state.now.inherited.get(kind))
    }

    fn camera(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), LoadError> {
        let kind = words.name("type")?;
        let params = Params::read(words, word.line, None)?;
        let from_world = self.state.now.transform;
        let to_world = from_world.inverse();
        self.camera = Some(looks::camera(&params, from_world)?);
        for what in looks::left_out_of_camera(&kind, &params)? {
            self.leave_out(what, || params.place());
        }
        self.state.name_system("camera", to_world, || params.place())
    }

    fn light(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), LoadError> {
        let kind = words.name("type")?;
        let params = self.params(words, word.line, "light")?;
        let place = || params.place();
        limits::check(self.lights.len() + 1, MAX_LIGHTS, "the number of lights", place)?;
        match looks::light(&kind, &params, self.state.now.transform)? {
            Some(light) => self.lights.push(light),
            None => self.leave_out(format!("lights {} left out", shortened(&kind)), place),
        }
        Ok(())
    }

    fn material(&mut self, name: &str, kind: &str, params: &Params) -> Result<u32, LoadError> {
        let count = self.scene.materials.len() + 1;
        limits::check(count, MAX_MATERIALS, "the number of materials", || params.place())?;
        if params.has_texture() {
            self.leave_out("materials with textures have a plain colour".into(), || params.place());
        }
        Ok(self.scene.push_material(looks::material(name, kind, params)?))
    }

    /// Counts what is not as the file says.
    fn leave_out(&mut self, what: String, place: impl FnOnce() -> FilePlace) {
        let is_new = !self.left_out.contains_key(&what);
        let is_full = is_new && self.left_out.len() >= MAX_WARNINGS;
        let what = if is_full { "more of other kinds".into() } else { what };
        self.left_out.entry(what).or_default().add(place);
    }

    fn shape(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), LoadError> {
        let kind = words.name("type")?;
        let params = self.params(words, word.line, "shape")?;
        let place = || params.place();
        let material = self.state.now.material.unwrap_or_else(|| {
            let scene = &mut self.scene;
            *self.plain.get_or_insert_with(|| scene.push_material(Material::default()))
        });
        let ply = match (kind.as_str(), params.string("filename")) {
            ("plymesh", Some(name)) => Some(self.read(name, place)?),
            ("plymesh", None) => {
                return Err(LoadError::syntax(place(), "plymesh", "a \"string filename\""));
            }
            _ => None,
        };
        let mut sink = self.sink(material);
        let is_there = match kind.as_str() {
            "trianglemesh" => sink.mesh(&params, 3).map(|()| true),
            "bilinearmesh" => sink.mesh(&params, 4).map(|()| true),
            "sphere" => sink.sphere(&params),
            "plymesh" => {
                let (vertices, normals) = (sink.scene.vertices.len(), sink.scene.normals.len());
                let (path, bytes) = ply.unwrap_or_default();
                add_ply(&path, &bytes, sink.triangulate, material, sink.scene)?;
                sink.place_since(vertices, normals, &path).map(|()| true)
            }
            _ => Ok(false),
        }?;
        if !is_there {
            let what = match kind.as_str() {
                "sphere" => ELLIPSOIDS.to_owned(),
                _ => format!("shapes {} left out", shortened(&kind)),
            };
            self.leave_out(what, place);
        } else if self.state.now.shines {
            self.leave_out("area lights are plain surfaces".into(), place);
        }
        Ok(())
    }

    fn instance(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), LoadError> {
        let name = words.name("name")?;
        let place = || words.place(word.line);
        if self.object.is_some() {
            return Err(LoadError::syntax(place(), "ObjectInstance", "ObjectEnd before it"));
        }
        let Some((number, object)) = self.objects.get(&name).cloned() else {
            return Err(LoadError::syntax(place(), &name, "an object before it"));
        };
        for _ in 0..self.sink(0).instance(&object, number, place)? {
            self.leave_out(ELLIPSOIDS.into(), place);
        }
        Ok(())
    }

    /// Adds shapes of a material, under the current transform, to the object that is being
    /// defined, or else to the scene.
    fn sink(&mut self, material: u32) -> ShapeSink<'_> {
        ShapeSink {
            scene: self.object.as_mut().map_or(&mut self.scene, |(_, object)| object),
            counts: &mut self.counts,
            transform: self.state.now.transform,
            material,
            triangulate: self.triangulate,
        }
    }

    fn include(
        &mut self,
        word: Word<'_>,
        words: &mut Words<'_>,
        depth: usize,
    ) -> Result<(), LoadError> {
        let name = words.name("filename")?;
        let place = || words.place(word.line);
        limits::check(depth + 1, MAX_INCLUDES, "the depth of Include", place)?;
        let (path, bytes) = self.read(&name, place)?;
        let text = text_of(&path, bytes)?;
        let before = self.state.now.clone();
        self.file(&path, &text, depth + 1)?;
        if word.text == "Import" {
            self.state.now = before;
        }
        Ok(())
    }

    /// The path and the bytes, unpacked, of a file that is named; all files together stay within the
    /// limit of one.
    fn read(
        &mut self,
        name: &str,
        place: impl Fn() -> FilePlace,
    ) -> Result<(PathBuf, Vec<u8>), LoadError> {
        let path = confined(&self.folder, name)
            .ok_or_else(|| LoadError::OutsideFolder { place: place(), uri: shortened(name) })?;
        self.files += 1;
        limits::check(self.files, MAX_FILES, "the number of files", place)?;
        let bytes = decompress(&path, read_at_most(&path, self.budget)?)?;
        let left = self.budget.checked_sub(bytes.len() as u64);
        self.budget = left.ok_or_else(|| LoadError::too_large(&path, MAX_BYTES))?;
        Ok((path, bytes))
    }
}
