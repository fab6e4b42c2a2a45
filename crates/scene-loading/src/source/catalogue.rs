//! From a name on the command line to a scene.
//!
//! A name is the path of a scene file or scene description, the name of a set, of a scene
//! description in the catalogue (`balls-tess`; of a generated scene also `balls-tess:5`), or a
//! generator's specification (`balls`, `balls:5`). The
//! catalogue holds what `scenes/` held when the program was compiled, then a folder `scenes` in
//! the current one, then a folder named by the user; later entries replace earlier ones.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{FilePlace, LoadError, suggestion};
use crate::input::{extension, read_at_most, scene_name, text_of};
use crate::limits::MAX_JSON;
use crate::procedural::generators;
use crate::scene_file::SceneFile;
use crate::scene_file::set::SceneSet;
use crate::source::formats::{ENDINGS, is_scene_path};
use crate::source::names::{name_of_path, path_of_name};
use crate::source::scene_ref::{DescribedScene, SceneOrigin, SceneRef};

macro_rules! embed {
    ($($path:literal),* $(,)?) => {
        &[$((concat!("scenes/", $path), include_str!(concat!("../../scenes/", $path)))),*]
    };
}

/// Scene files: path in the repository and text.
static SCENES: &[(&str, &str)] = embed![
    "balls-tess.json",
    "effects/effect-all.json",
    "effects/effect-focus.json",
    "effects/effect-gloss.json",
    "effects/effect-hard-shadows.json",
    "effects/effect-mirror.json",
    "effects/effect-motion.json",
    "effects/effect-plain.json",
    "effects/effect-refraction.json",
    "effects/effect-smooth-normals.json",
    "effects/effect-soft-shadows.json",
    "effects/effect-supersampling.json",
    "effects/effect-textures.json",
    "gears-tess.json",
    "gears8-tess.json",
    "kitchen.json",
    "pavilion.json",
    "sponza.json",
    "tree-tess.json",
];

/// Set files: path in the repository and text.
static SETS: &[(&str, &str)] = embed![
    "sets/effects.json",
    "sets/real.json",
    "sets/small.json",
    "sets/spd.json",
    "sets/speed.json",
];

/// All scenes that have a name.
#[derive(Debug, Clone, Default)]
pub struct SceneCatalogue {
    pub(super) scenes: BTreeMap<String, DescribedScene>,
    sets: BTreeMap<String, SceneSet>,
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
            self.add_scene(&path, &json_text(&path)?, false)?;
        }
        let sets = folder.join("sets");
        if sets.is_dir() {
            for path in json_files(&sets)? {
                self.add_set(&path, &json_text(&path)?)?;
            }
        }
        Ok(())
    }

    fn add_scene(&mut self, path: &Path, text: &str, embedded: bool) -> Result<(), LoadError> {
        let described = DescribedScene::parse(path, text, embedded)?;
        self.scenes.insert(described.file.name.clone(), described);
        Ok(())
    }

    /// Files among a set's scenes are named relative to the set file.
    fn add_set(&mut self, path: &Path, text: &str) -> Result<(), LoadError> {
        let mut set = SceneSet::parse(path, text)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        // names of scenes have neither dots nor separators
        for file in set.scenes.iter_mut().filter(|name| name.contains(['/', '\\', '.'])) {
            *file = name_of_path(folder.join(path_of_name(file)).as_os_str());
        }
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
            let of_set = self.sets.get(name).map(|set| set.scenes.as_slice());
            for name in of_set.unwrap_or(std::slice::from_ref(name)) {
                let scene = self.find(name)?;
                if !scenes.contains(&scene) {
                    scenes.push(scene);
                }
            }
        }
        Ok(scenes)
    }

    fn find(&self, name: &str) -> Result<SceneRef, LoadError> {
        let path = &path_of_name(name);
        let of_file = || Ok(SceneRef::new(scene_name(path), SceneOrigin::File(path.clone())));
        let described = |described| SceneOrigin::Described(Box::new(described));
        // a file of that name is meant, even if it is called like a generator's size
        if name.contains(':') && is_scene_path(path) && path.is_file() {
            return of_file();
        }
        let found = match self.scenes.get(name) {
            Some(found) => Some(found.clone()),
            None => self.of_size(name)?,
        };
        if let Some(found) = found {
            return Ok(SceneRef::new(name, described(found)));
        }
        let family = name.split(':').next().unwrap_or(name);
        if families().contains(&family) {
            return Ok(SceneRef::new(name, SceneOrigin::Spd(name.to_string())));
        }
        if extension(path) == "json" {
            let found = DescribedScene::parse(path, &json_text(path)?, false)?;
            return Ok(SceneRef::new(found.file.name.clone(), described(found)));
        }
        if is_scene_path(path) {
            std::fs::metadata(path).map_err(|e| LoadError::io(path, e))?;
            return of_file();
        }
        if path.is_file() {
            let valid = format!("{}, .json", ENDINGS.join(", "));
            return Err(LoadError::UnknownFormat { place: FilePlace::file(path), valid });
        }
        Err(self.unknown(name))
    }

    fn unknown(&self, name: &str) -> LoadError {
        let generated = families();
        let scenes: Vec<&str> = self.scenes.keys().map(String::as_str).collect();
        let sets: Vec<&str> = self.sets.keys().map(String::as_str).collect();
        let suggestion = suggestion(name, &[&generated[..], &scenes, &sets].concat());
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

/// The text of a scene or set file.
fn json_text(path: &Path) -> Result<String, LoadError> {
    text_of(path, read_at_most(path, MAX_JSON)?)
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

/// The names of the generators.
fn families() -> Vec<&'static str> {
    generators().map(|entry| entry.name).collect()
}
