//! From a name on the command line to a scene.
//!
//! A name is the path of a scene file or scene description, the name of a set, of a scene
//! description in the catalogue (`balls-tess`; of a generated scene also `balls-tess:5`), or a
//! generator's specification (`balls`, `balls:5`). The
//! catalogue holds what `scenes/` held when the program was compiled, then a folder `scenes` in
//! the current one, then a folder named by the user; later entries replace earlier ones.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{LoadError, Place};
use crate::fetch::Places;
use crate::obj::ObjOptions;
use crate::scene::{Scene, Warning};
use crate::scene_file::{SceneFile, Source};
use crate::scene_set::SceneSet;
use crate::source_embedded::{ASSETS, SCENES, SETS};
use crate::source_formats::{ENDINGS, is_scene_path, parse_scene};
use crate::source_hash::{sha256_of_bytes, sha256_of_scene};
use crate::source_names::path_of_name;
use crate::source_procedural::{families, generate, tessellate};
use crate::source_read::{extension, lossy_text, read_file, scene_name};

/// All scenes that have a name.
#[derive(Debug, Clone, Default)]
pub struct SceneCatalogue {
    pub(crate) scenes: BTreeMap<String, Described>,
    sets: BTreeMap<String, SceneSet>,
}

/// A scene description and where it was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Described {
    path: PathBuf,
    /// From the program itself, which then has the files it refers to as well.
    embedded: bool,
    pub(crate) file: SceneFile,
}

/// A scene that is known but not loaded.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneRef {
    /// Name in tables: `balls:5`, `kitchen`, the stem of a path.
    pub name: String,
    from: From,
}

#[derive(Debug, Clone, PartialEq)]
enum From {
    Spd(String),
    File(PathBuf),
    Described(Box<Described>),
}

/// A scene in memory, and what a result has to say about its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScene {
    /// The scene.
    pub scene: Scene,
    /// Hash of the loaded scene: [`sha256_of_scene`].
    pub sha256: String,
    /// Where it came from, in words: `generated: balls:4`, `obvhs 0.4.0: assets/...`.
    pub source: String,
    /// Licence of the geometry, where known.
    pub licence: Option<String>,
}

impl SceneCatalogue {
    /// The catalogue that the program carries.
    ///
    /// # Errors
    /// None in a program that passed its tests, which load every embedded file.
    pub fn embedded() -> Result<Self, LoadError> {
        let mut catalogue = Self::default();
        for (path, text) in SCENES {
            catalogue.add_scene(Path::new(path), text, true)?;
        }
        for (path, text) in SETS {
            catalogue.add_set(Path::new(path), text)?;
        }
        Ok(catalogue)
    }

    /// The embedded catalogue, with `./scenes` where there is one, and with `folder`.
    ///
    /// # Errors
    /// Those of [`SceneCatalogue::add_folder`].
    pub fn open(folder: Option<&Path>) -> Result<Self, LoadError> {
        let mut catalogue = Self::embedded()?;
        let local = Path::new("scenes");
        if local.is_dir() {
            catalogue.add_folder(local)?;
        }
        if let Some(folder) = folder {
            catalogue.add_folder(folder)?;
        }
        Ok(catalogue)
    }

    /// Adds `*.json` of the folder and `effects/*.json` as scenes and `sets/*.json` as sets.
    ///
    /// # Errors
    /// [`LoadError::Io`] when the folder cannot be read, else those of [`SceneFile::parse`] and
    /// [`SceneSet::parse`].
    pub fn add_folder(&mut self, folder: &Path) -> Result<(), LoadError> {
        let effects = folder.join("effects");
        let mut scenes = json_files(folder)?;
        if effects.is_dir() {
            scenes.append(&mut json_files(&effects)?);
        }
        for path in scenes {
            self.add_scene(&path, &lossy_text(read_file(&path)?), false)?;
        }
        let sets = folder.join("sets");
        if sets.is_dir() {
            for path in json_files(&sets)? {
                self.add_set(&path, &lossy_text(read_file(&path)?))?;
            }
        }
        Ok(())
    }

    fn add_scene(&mut self, path: &Path, text: &str, embedded: bool) -> Result<(), LoadError> {
        let file = SceneFile::parse(path, text)?;
        self.scenes
            .insert(file.name.clone(), Described { path: path.to_path_buf(), embedded, file });
        Ok(())
    }

    fn add_set(&mut self, path: &Path, text: &str) -> Result<(), LoadError> {
        let set = SceneSet::parse(path, text)?;
        self.sets.insert(set.name.clone(), set);
        Ok(())
    }

    /// The scene descriptions, by name.
    pub fn scenes(&self) -> impl Iterator<Item = &SceneFile> {
        self.scenes.values().map(|described| &described.file)
    }

    /// The sets, by name.
    pub fn sets(&self) -> impl Iterator<Item = &SceneSet> {
        self.sets.values()
    }

    /// Turns names into scenes, in their order; sets are expanded, repeated scenes come once.
    ///
    /// # Errors
    /// [`LoadError::UnknownScene`] with all valid names and the nearest one; for paths
    /// [`LoadError::Io`], [`LoadError::UnknownFormat`] and those of [`SceneFile::parse`].
    pub fn resolve(&self, names: &[String]) -> Result<Vec<SceneRef>, LoadError> {
        let mut scenes: Vec<SceneRef> = Vec::new();
        for name in names {
            let found = match self.sets.get(name) {
                Some(set) => {
                    set.scenes.iter().map(|name| self.find(name)).collect::<Result<Vec<_>, _>>()?
                }
                None => vec![self.find(name)?],
            };
            for scene in found {
                if !scenes.contains(&scene) {
                    scenes.push(scene);
                }
            }
        }
        Ok(scenes)
    }

    fn find(&self, name: &str) -> Result<SceneRef, LoadError> {
        if let Some(described) = self.scenes.get(name) {
            let from = From::Described(Box::new(described.clone()));
            return Ok(SceneRef { name: name.to_string(), from });
        }
        if let Some(described) = self.of_size(name)? {
            let from = From::Described(Box::new(described));
            return Ok(SceneRef { name: name.to_string(), from });
        }
        let family = name.split(':').next().unwrap_or(name);
        if families().contains(&family) {
            return Ok(SceneRef { name: name.to_string(), from: From::Spd(name.to_string()) });
        }
        let path = path_of_name(name);
        let path = path.as_path();
        if extension(path) == "json" {
            let file = SceneFile::parse(path, &lossy_text(read_file(path)?))?;
            let described = Described { path: path.to_path_buf(), embedded: false, file };
            let name = described.file.name.clone();
            return Ok(SceneRef { name, from: From::Described(Box::new(described)) });
        }
        if is_scene_path(path) {
            std::fs::metadata(path).map_err(|e| LoadError::io(path, e))?;
            return Ok(SceneRef { name: scene_name(path), from: From::File(path.to_path_buf()) });
        }
        if path.is_file() {
            let valid = format!("{}, .json", ENDINGS.join(", "));
            return Err(LoadError::UnknownFormat { place: Place::file(path), valid });
        }
        Err(self.unknown(name))
    }

    fn unknown(&self, name: &str) -> LoadError {
        let generated = families();
        let (scenes, sets): (Vec<&str>, Vec<&str>) = (
            self.scenes.keys().map(String::as_str).collect(),
            self.sets.keys().map(String::as_str).collect(),
        );
        // A misspelt generator with a size is near the generator's name.
        let head = name.split(':').next().unwrap_or(name).to_lowercase();
        let nearest = generated
            .iter()
            .chain(&scenes)
            .chain(&sets)
            .map(|valid| (strsim::damerau_levenshtein(&head, valid), *valid))
            .min();
        let suggestion = match nearest {
            Some((distance, valid)) if distance <= (valid.len() / 3).max(1) => {
                format!(" (did you mean `{valid}`?)")
            }
            _ => String::new(),
        };
        let valid = format!(
            "generated {} (with a size: balls:5); scenes {}; sets {}; paths ending in {}, .json",
            generated.join(", "),
            scenes.join(", "),
            sets.join(", "),
            ENDINGS.join(", ")
        );
        LoadError::UnknownScene { name: name.to_string(), suggestion, valid }
    }
}

impl SceneRef {
    /// The description it was resolved from, unless it is a plain file or generated.
    pub fn description(&self) -> Option<&SceneFile> {
        match &self.from {
            From::Described(described) => Some(&described.file),
            From::Spd(_) | From::File(_) => None,
        }
    }

    /// Loads or generates the scene.
    ///
    /// # Errors
    /// [`LoadError::NotFetched`] when its package is not on this machine,
    /// [`LoadError::HashMismatch`], or the error of the loader or generator.
    pub fn load(&self) -> Result<LoadedScene, LoadError> {
        self.load_from(&Places::from_env())
    }

    /// [`SceneRef::load`] with the folders of packages given.
    ///
    /// # Errors
    /// As [`SceneRef::load`].
    pub fn load_from(&self, places: &Places) -> Result<LoadedScene, LoadError> {
        let (mut scene, source, licence) = match &self.from {
            From::Spd(spec) => {
                (generate(spec)?, format!("generated: {spec}"), Some("CC0-1.0 (SPD)".to_string()))
            }
            From::File(path) => {
                let scene = parse_scene(path, read_file(path)?, ObjOptions::default())?;
                (scene, path.display().to_string(), None)
            }
            From::Described(described) => {
                let (scene, source) = described.load(places)?;
                (scene, source, described.file.licence.clone())
            }
        };
        scene.name.clone_from(&self.name);
        Ok(LoadedScene { sha256: sha256_of_scene(&scene), scene, source, licence })
    }

    /// Brings the scene's package to this machine and checks the file; returns its path, or
    /// `None` for scenes that need no package.
    ///
    /// # Errors
    /// Those of [`Places::fetch`], and [`LoadError::HashMismatch`].
    pub fn fetch(&self) -> Result<Option<PathBuf>, LoadError> {
        let From::Described(described) = &self.from else { return Ok(None) };
        let Source::Crate(asset) = &described.file.source else { return Ok(None) };
        let path = Places::from_env().fetch(asset)?;
        described.check_hash(&path, &read_file(&path)?)?;
        Ok(Some(path))
    }
}

impl Described {
    fn load(&self, places: &Places) -> Result<(Scene, String), LoadError> {
        let (mut scene, source) = match &self.file.source {
            Source::Spd(spec) => (generate(spec)?, format!("generated: {spec}")),
            Source::Shapes(shapes) => {
                (self.file.inline(&self.path, shapes)?, self.path.display().to_string())
            }
            Source::File(name) => {
                let path = self.path.parent().unwrap_or(Path::new("")).join(name);
                let embedded = ASSETS.iter().find(|(asset, _)| Path::new(asset) == path);
                let bytes: Cow<'_, [u8]> = match embedded {
                    Some((_, bytes)) if self.embedded => Cow::Borrowed(bytes),
                    _ => Cow::Owned(read_file(&path)?),
                };
                (self.parse(&path, bytes.into_owned())?, path.display().to_string())
            }
            Source::Crate(asset) => {
                let path = places.locate(asset).ok_or_else(|| LoadError::NotFetched {
                    scene: self.file.name.clone(),
                    package: asset.package(),
                    path: asset.path.clone(),
                })?;
                let source = format!("{}: {}", asset.package(), asset.path);
                let mut scene = self.parse(&path, read_file(&path)?)?;
                // results carry warnings: they name the package, not the folder of this machine
                let (place, package) = (path.display().to_string(), asset.package() + ": ");
                let folder = place.strip_suffix(&asset.path).filter(|folder| !folder.is_empty());
                for Warning(text) in &mut scene.warnings {
                    *text = folder.map_or(text.clone(), |folder| text.replace(folder, &package));
                }
                (scene, source)
            }
        };
        self.file.apply(&self.path, &mut scene)?;
        if let Some(options) = self.file.tessellate {
            let warnings = std::mem::take(&mut scene.warnings);
            scene = tessellate(&scene, options.resolution)?;
            scene.warnings.splice(0..0, warnings);
        }
        Ok((scene, source))
    }

    fn parse(&self, path: &Path, bytes: Vec<u8>) -> Result<Scene, LoadError> {
        self.check_hash(path, &bytes)?;
        parse_scene(path, bytes, ObjOptions { triangulate: self.file.triangulate })
    }

    fn check_hash(&self, path: &Path, bytes: &[u8]) -> Result<(), LoadError> {
        let Some(expected) = &self.file.sha256 else { return Ok(()) };
        let found = sha256_of_bytes(bytes);
        if expected.eq_ignore_ascii_case(&found) {
            return Ok(());
        }
        let (place, expected) = (Place::file(path), expected.clone());
        Err(LoadError::HashMismatch { place, expected, found })
    }
}

fn json_files(folder: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let entries = std::fs::read_dir(folder).map_err(|e| LoadError::io(folder, e))?;
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| extension(path) == "json" && path.is_file())
        .collect();
    paths.sort();
    Ok(paths)
}
