//! The reader of AFF files: entities in the order of the file, and the files that it includes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::aff::motion::{Motion, rotation};
use crate::aff::world::{Branch, PrimitiveRange, RunOrigin, Step, World};
use crate::error::{FilePlace, LoadError, shortened};
use crate::input::{confined, read_at_most, text_of};
use crate::limits::{self, MAX_BYTES, MAX_LIGHTS, MAX_MATERIALS, MAX_NAME};
use crate::mesh::{FaceCounts, FirstAndCount};
use crate::nff::{light, surface, view};
use crate::scene::Material;
use crate::words::{Word, Words};
use glam::DAffine3;

/// How deep files may include others, and how many inclusions there may be.
const MAX_DEPTH: usize = 16;
const MAX_FILES: usize = 1 << 16;

const MAX_BRANCHES: usize = 1 << 20;

const MAX_FRAMES: u64 = 1 << 20;

const ENTITIES: &str =
    "an entity (v, l, la, b, f, fm, s, c, p, pp, m, tt, ttp, tpa, i, d, x, xs, }, k, a, am)";

/// Reads the bytes of a file and all that it includes.
pub(super) fn read_world(path: &Path, bytes: Vec<u8>) -> Result<World, LoadError> {
    let root = Branch { parent: 0, step: Step::Fixed(DAffine3::IDENTITY) };
    let mut reader = Reader {
        folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
        world: World { path: path.to_path_buf(), branches: vec![root], ..World::default() },
        budget: MAX_BYTES,
        ..Reader::default()
    };
    reader.file(path, bytes, 0)?;
    reader.finish(path)
}

/// A file that is being read.
pub(super) struct OpenedFile<'a> {
    pub words: Words<'a>,
    /// Origin of its next run of primitives.
    next: RunOrigin,
    /// The branch that it is included in, and how deep inclusions are there.
    base: usize,
    depth: usize,
}

#[derive(Default)]
pub(super) struct Reader {
    /// Folder of the first file; names of others are relative to it.
    folder: PathBuf,
    pub world: World,
    pub material: Option<u32>,
    /// Files with a higher level are not included.
    detail: u64,
    pub branch: usize,
    files: BTreeMap<PathBuf, usize>,
    included: usize,
    /// Bytes that may still be read.
    budget: u64,
    pub counts: FaceCounts,
    pub textured: FirstAndCount,
    /// Keys that go back in time.
    back: FirstAndCount,
    named_lights: Vec<String>,
}

impl Reader {
    fn file(&mut self, path: &Path, bytes: Vec<u8>, depth: usize) -> Result<(), LoadError> {
        let left = self.budget.checked_sub(bytes.len() as u64);
        self.budget = left.ok_or_else(|| LoadError::too_large(path, MAX_BYTES))?;
        let text = text_of(path, bytes)?;
        let next = self.files.len();
        let file = *self.files.entry(path.to_path_buf()).or_insert(next);
        let words = Words::new(path, &text).with_syntax(&['#', '%'], b"{}");
        let next = RunOrigin { inclusion: self.included, file, number: 0 };
        let mut opened = OpenedFile { words, next, base: self.branch, depth };
        while let Some(word) = opened.words.next() {
            self.entity(word, &mut opened)?;
        }
        if self.branch != opened.base {
            return Err(LoadError::unexpected_end(FilePlace::file(path), "}"));
        }
        Ok(())
    }

    fn entity(&mut self, word: Word<'_>, opened: &mut OpenedFile<'_>) -> Result<(), LoadError> {
        let words = &mut opened.words;
        let place = words.place(word.line);
        match word.text {
            "v" => {
                self.world.rest.camera = view(words, word)?;
                self.world.has_view = true;
            }
            "l" => self.add_light(words, place)?,
            "la" => {
                let name = name(words)?;
                self.add_light(words, place)?;
                self.named_lights.push(name);
            }
            "b" => self.world.rest.background = words.vector("background colour")?.to_array(),
            "f" => {
                let material = surface(words)?;
                self.material(material, place)?;
            }
            "fm" => {
                let material = extended(words)?;
                self.material(material, place)?;
            }
            "a" => {
                let (from, to) = (words.number("the start")?, words.number("the end")?);
                let frames = words.integer("the number of frames", 1, MAX_FRAMES)?;
                if to < from {
                    let expected = format!("at least the start, {from}");
                    return Err(LoadError::out_of_range(place, "the end", to, expected));
                }
                // the range check keeps it within u32
                self.world.clip = Some((from, to, frames as u32));
            }
            "am" => {
                words.vector("ambient light")?;
            }
            "d" => self.detail = words.integer("a level of detail", 0, u64::MAX)?,
            "i" => self.include(words, place, opened.depth)?,
            "k" => {
                let name = name(words)?;
                self.world.motions.insert(name, Motion::read(words, &mut self.back)?);
            }
            "x" => {
                let step = Step::Named(name(words)?);
                self.enter(step, words, place)?;
            }
            "xs" => {
                let scale = words.vector("a scale")?;
                let rotation = rotation(words)?;
                let translation = words.vector("a translation")?;
                let step = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
                self.enter(Step::Fixed(step), words, place)?;
            }
            "}" => {
                if self.branch == opened.base {
                    return Err(LoadError::syntax(place, "}", "as many { before it"));
                }
                self.branch = self.world.branches.get(self.branch).map_or(0, |b| b.parent);
            }
            "s" | "c" | "p" | "pp" | "m" | "tt" | "ttp" | "tpa" => {
                self.begin(word.text == "tpa", opened, place);
                self.shape(word, &mut opened.words)?;
                self.end();
            }
            other => return Err(LoadError::syntax(place, other, ENTITIES)),
        }
        Ok(())
    }

    fn enter(
        &mut self,
        step: Step,
        words: &mut Words<'_>,
        place: FilePlace,
    ) -> Result<(), LoadError> {
        words.keyword("{")?;
        self.world.branches.push(Branch { parent: self.branch, step });
        self.branch = self.world.branches.len() - 1;
        limits::check(self.branch, MAX_BRANCHES, "the number of transforms", || place)
    }

    fn include(
        &mut self,
        words: &mut Words<'_>,
        place: FilePlace,
        depth: usize,
    ) -> Result<(), LoadError> {
        let level = words.integer("a level of detail", 0, u64::MAX)?;
        let name = name(words)?;
        if level > self.detail {
            return Ok(());
        }
        limits::check(depth + 1, MAX_DEPTH, "the depth of included files", || place.clone())?;
        self.included += 1;
        limits::check(self.included, MAX_FILES, "the number of included files", || place.clone())?;
        let path = confined(&self.folder, &name)
            .ok_or_else(|| LoadError::OutsideFolder { place, uri: shortened(&name) })?;
        let bytes = read_at_most(&path, self.budget)?;
        self.file(&path, bytes, depth + 1)
    }

    /// Has primitives that follow belong to a part: that of those before, if nothing is between.
    fn begin(&mut self, is_soft: bool, opened: &mut OpenedFile<'_>, place: FilePlace) {
        let (scene, branch, origin) = (&self.world.rest, self.branch, opened.next);
        let of = |part: &PrimitiveRange| (part.branch, part.is_soft, part.origin.inclusion);
        if self.world.parts.last().map(of) == Some((branch, is_soft, origin.inclusion)) {
            return;
        }
        opened.next.number += 1;
        let here = |length: usize| length..length;
        self.world.parts.push(PrimitiveRange {
            branch,
            object: 0,
            origin,
            is_soft,
            primitives: here(scene.primitives.len()),
            vertices: here(scene.vertices.len()),
            normals: here(scene.normals.len()),
            spheres: here(scene.spheres.len()),
            cones: here(scene.cones.len()),
            place,
        });
    }

    /// Has the last part end here.
    fn end(&mut self) {
        let scene = &self.world.rest;
        let Some(part) = self.world.parts.last_mut() else { return };
        part.primitives.end = scene.primitives.len();
        part.vertices.end = scene.vertices.len();
        part.normals.end = scene.normals.len();
        part.spheres.end = scene.spheres.len();
        part.cones.end = scene.cones.len();
    }

    fn finish(mut self, path: &Path) -> Result<World, LoadError> {
        let scene = &mut self.world.rest;
        if scene.primitives.is_empty() {
            let expected = "primitive (s, c, p, pp, m, tt, ttp, tpa)";
            return Err(LoadError::no_primitives(path, expected));
        }
        self.counts.warn(scene);
        self.textured.warn("textured shapes or meshes: their images are not read", scene);
        self.back.warn("keys that go back in time", scene);
        let keyed = |name: &&String| self.world.motions.contains_key(*name);
        let moved = self.named_lights.iter().filter(keyed).count();
        if moved > 0 {
            let path = path.display();
            scene.warn(format!("{path}: {moved} lights with keyframes stay in place"));
        }
        // a run that a file makes whenever it is included is the same object
        let mut objects = BTreeMap::new();
        for part in &mut self.world.parts {
            let next = objects.len() as u32;
            let what = (part.origin.file, part.origin.number, part.primitives.len());
            part.object = *objects.entry(what).or_insert(next);
        }
        self.world.parts.retain(|part| !part.primitives.is_empty());
        Ok(self.world)
    }

    fn add_light(&mut self, words: &mut Words<'_>, place: FilePlace) -> Result<(), LoadError> {
        self.world.lights.push((self.branch, light(words)?));
        limits::check(self.world.lights.len(), MAX_LIGHTS, "the number of lights", || place)
    }

    fn material(&mut self, material: Material, place: FilePlace) -> Result<(), LoadError> {
        self.material = Some(self.world.rest.push_material(material));
        let count = self.world.rest.materials.len();
        limits::check(count, MAX_MATERIALS, "the number of materials", || place)
    }

    /// The current material, or a grey one where a primitive comes before the first.
    pub fn current_material(&mut self) -> u32 {
        let scene = &mut self.world.rest;
        *self.material.get_or_insert_with(|| scene.push_material(Material::default()))
    }
}

/// A name without blanks.
pub(super) fn name(words: &mut Words<'_>) -> Result<String, LoadError> {
    let word = words.any("a name")?;
    limits::check(word.text.len(), MAX_NAME, "the length of a name", || words.place(word.line))?;
    Ok(word.text.to_owned())
}

/// What stands behind an `fm`: ambient, diffuse and specular colour, exponent, transmittance, index
/// of refraction.
pub(super) fn extended(words: &mut Words<'_>) -> Result<Material, LoadError> {
    words.vector("ambient colour")?;
    let diffuse = words.vector("diffuse colour")?;
    let specular = words.vector("specular colour")?;
    let share = diffuse.max_element();
    Ok(Material {
        color: if share > 0.0 { (diffuse / share).to_array() } else { [0.0; 3] },
        diffuse: share,
        specular: specular.max_element(),
        shine: words.number("shine")?,
        transmittance: words.number("transmittance T")?,
        refraction_index: words.number("index of refraction")?,
        ..Material::default()
    })
}
