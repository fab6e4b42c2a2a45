//! A scene that has a name, until it is loaded: a generated one, a file, or what a JSON file
//! describes.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::error::{FilePlace, LoadError, shortened};
use crate::fetch::{PackageAsset, Places};
use crate::input::{confined, read_file};
use crate::procedural;
use crate::scene::{Scene, Warning};
use crate::scene_file::{SceneFile, Source};
use crate::second_opinion::{SecondOpinion, second_opinion};
use crate::source::formats::{ReadOptions, load_scene, parse_scene};
use crate::source::hash::{sha256_of_bytes, sha256_of_scene};
use crate::tessellate::tessellate;
use crate::view_options::{ViewOptions, light_if_dark};

/// Files that scene files refer to: path in the repository and bytes.
static ASSETS: &[(&str, &[u8])] = &[
    ("scenes/pavilion.glb", include_bytes!("../../scenes/pavilion.glb")),
    (
        "scenes/effects/effect-textures.gltf",
        include_bytes!("../../scenes/effects/effect-textures.gltf"),
    ),
];

/// A scene that is known but not loaded.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneRef {
    /// Name in tables: `balls:5`, `kitchen`, the stem of a path.
    pub name: String,
    pub(crate) from: SceneOrigin,
    /// View and lights instead of the scene's own.
    pub view: ViewOptions,
    /// Files that its file names may lie outside its folder.
    outside: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SceneOrigin {
    Spd(String),
    File(PathBuf),
    Described(Box<DescribedScene>),
}

/// A scene in memory, and what a result has to say about its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScene {
    pub scene: Scene,
    /// Hash of the loaded scene: [`sha256_of_scene`].
    pub sha256: String,
    /// Origin in words: `generated: balls:4`, `obvhs 0.4.0: assets/...`.
    pub source: String,
    /// Licence of the geometry, where known.
    pub licence: Option<String>,
}

impl SceneRef {
    pub(crate) fn new(name: impl Into<String>, from: SceneOrigin) -> Self {
        Self { name: name.into(), from, view: ViewOptions::default(), outside: false }
    }

    /// The description it was resolved from, unless it is a plain file or generated.
    pub fn description(&self) -> Option<&SceneFile> {
        match &self.from {
            SceneOrigin::Described(described) => Some(&described.file),
            SceneOrigin::Spd(_) | SceneOrigin::File(_) => None,
        }
    }

    /// Lets the source of a scene file lie outside its folder, as only files of one's own should.
    pub fn allow_outside(&mut self) {
        self.outside = true;
    }

    /// Loads or generates the scene. One without lights gets one at the eye, with a warning, unless
    /// its scene file says that it has none (`"lights": []`). One that is far from the origin of
    /// its coordinates is moved near it: [`Scene::origin`].
    ///
    /// # Errors
    /// [`LoadError::NotFetched`] when its package is not on this machine,
    /// [`LoadError::HashMismatch`], or the error of the loader, of the generator or of
    /// [`ViewOptions::apply`].
    pub fn load(&self) -> Result<LoadedScene, LoadError> {
        self.load_from(&Places::from_env())
    }

    /// [`SceneRef::load`] with the folders of packages given.
    ///
    /// # Errors
    /// As [`SceneRef::load`].
    pub fn load_from(&self, places: &Places) -> Result<LoadedScene, LoadError> {
        let (mut scene, source, licence) = match &self.from {
            SceneOrigin::Spd(spec) => {
                (generate(spec)?, format!("generated: {spec}"), Some("CC0-1.0 (SPD)".to_string()))
            }
            SceneOrigin::File(path) => {
                let options = ReadOptions { outside: self.outside, ..ReadOptions::default() };
                let scene = load_scene(path, options)?;
                (scene, path.display().to_string(), None)
            }
            SceneOrigin::Described(described) => {
                let (scene, source) = described.load(places, self.outside)?;
                (scene, source, described.file.licence.clone())
            }
        };
        scene.name.clone_from(&self.name);
        self.view.apply(&mut scene)?;
        if self.description().is_none_or(|file| file.lights.is_none()) {
            light_if_dark(&mut scene);
        }
        scene.bring_near();
        Ok(LoadedScene { sha256: sha256_of_scene(&scene), scene, source, licence })
    }

    /// Second opinion of another reader on the scene's file; `None` for scenes without one.
    ///
    /// # Errors
    /// As [`SceneRef::load`].
    pub fn second_opinion(&self) -> Result<Option<SecondOpinion>, LoadError> {
        let path = match &self.from {
            SceneOrigin::Spd(_) => None,
            SceneOrigin::File(path) => Some(path.clone()),
            SceneOrigin::Described(described) => {
                described.source_path(&Places::from_env(), self.outside)?
            }
        };
        path.map(|path| second_opinion(&path, read_file(&path)?)).transpose()
    }

    /// Brings the scene's package to this machine and checks the file; returns its path, or
    /// `None` for scenes that need no package.
    ///
    /// # Errors
    /// Those of [`Places::fetch`], and [`LoadError::HashMismatch`].
    pub fn fetch(&self) -> Result<Option<PathBuf>, LoadError> {
        let SceneOrigin::Described(described) = &self.from else { return Ok(None) };
        let Source::Crate(asset) = &described.file.source else { return Ok(None) };
        let path = Places::from_env().fetch(asset)?;
        described.check_hash(&path, &read_file(&path)?)?;
        Ok(Some(path))
    }
}

/// A scene description and where it was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DescribedScene {
    pub path: PathBuf,
    /// From the program itself, which then has the files it refers to as well.
    pub embedded: bool,
    pub file: SceneFile,
}

impl DescribedScene {
    /// # Errors
    /// Those of [`SceneFile::parse`].
    pub fn parse(path: &Path, text: &str, embedded: bool) -> Result<Self, LoadError> {
        Ok(Self { path: path.into(), embedded, file: SceneFile::parse(path, text)? })
    }

    /// The scene, and its origin in words; `outside`: its source may lie outside its folder.
    pub fn load(&self, places: &Places, outside: bool) -> Result<(Scene, String), LoadError> {
        let (mut scene, source) = match &self.file.source {
            Source::Spd(spec) => (generate(spec)?, format!("generated: {spec}")),
            Source::Shapes(shapes) => {
                (self.file.inline(&self.path, shapes)?, self.path.display().to_string())
            }
            Source::File(name) => {
                let path = self.source_file(name, outside)?;
                let embedded = ASSETS.iter().find(|(asset, _)| Path::new(asset) == path);
                let bytes: Cow<'_, [u8]> = match embedded {
                    Some((_, bytes)) if self.embedded => Cow::Borrowed(bytes),
                    _ => Cow::Owned(read_file(&path)?),
                };
                (self.parsed(&path, bytes.into_owned(), outside)?, path.display().to_string())
            }
            Source::Crate(asset) => {
                let path = self.located(asset, places)?;
                let source = format!("{}: {}", asset.package(), asset.path);
                let mut scene = self.parsed(&path, read_file(&path)?, outside)?;
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
            scene = tessellate(&scene, &options)
                .map_err(|error| LoadError::procedural(&scene.name, error))?;
            scene.warnings.splice(0..0, warnings);
        }
        Ok((scene, source))
    }

    /// The file that holds the geometry, if one on this machine does.
    pub fn source_path(
        &self,
        places: &Places,
        outside: bool,
    ) -> Result<Option<PathBuf>, LoadError> {
        Ok(match &self.file.source {
            Source::Spd(_) | Source::Shapes(_) => None,
            Source::File(_) if self.embedded => None,
            Source::File(name) => Some(self.source_file(name, outside)?),
            Source::Crate(asset) => Some(self.located(asset, places)?),
        })
    }

    fn located(&self, asset: &PackageAsset, places: &Places) -> Result<PathBuf, LoadError> {
        places.locate(asset).ok_or_else(|| LoadError::NotFetched {
            scene: self.file.name.clone(),
            package: asset.package(),
            path: asset.path.clone(),
        })
    }

    /// The file that a scene file names as its source.
    fn source_file(&self, name: &str, outside: bool) -> Result<PathBuf, LoadError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if outside {
            return Ok(folder.join(name));
        }
        confined(folder, name).ok_or_else(|| LoadError::OutsideSource {
            place: FilePlace::file(&self.path),
            path: shortened(name),
        })
    }

    fn parsed(&self, path: &Path, bytes: Vec<u8>, outside: bool) -> Result<Scene, LoadError> {
        self.check_hash(path, &bytes)?;
        let options = ReadOptions { triangulate: self.file.triangulate, outside };
        parse_scene(path, bytes, options)
    }

    pub fn check_hash(&self, path: &Path, bytes: &[u8]) -> Result<(), LoadError> {
        let Some(expected) = &self.file.sha256 else { return Ok(()) };
        let found = sha256_of_bytes(bytes);
        if expected.eq_ignore_ascii_case(&found) {
            return Ok(());
        }
        let (place, expected) = (FilePlace::file(path), expected.clone());
        Err(LoadError::HashMismatch { place, expected, found })
    }
}

/// Generates `balls` or `balls:5`.
fn generate(spec: &str) -> Result<Scene, LoadError> {
    procedural::generate(spec).map_err(|error| LoadError::procedural(spec, error))
}
