//! Scenes that a JSON file describes.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::error::{FilePlace, LoadError, shortened};
use crate::fetch::{PackageAsset, Places};
use crate::input::read::{confined, read_file};
use crate::scene::{Scene, Warning};
use crate::scene_file::{SceneFile, Source};
use crate::source::embedded::ASSETS;
use crate::source::embedded::{generate, tessellate};
use crate::source::formats::{ReadOptions, parse_scene};
use crate::source::hash::sha256_of_bytes;

/// A scene description and where it was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DescribedScene {
    pub path: PathBuf,
    /// From the program itself, which then has the files it refers to as well.
    pub embedded: bool,
    pub file: SceneFile,
    /// Its source may lie outside its folder.
    pub outside: bool,
}

impl DescribedScene {
    pub fn load(&self, places: &Places) -> Result<(Scene, String), LoadError> {
        let (mut scene, source) = match &self.file.source {
            Source::Spd(spec) => (generate(spec)?, format!("generated: {spec}")),
            Source::Shapes(shapes) => {
                (self.file.inline(&self.path, shapes)?, self.path.display().to_string())
            }
            Source::File(name) => {
                let path = self.source_file(name)?;
                let embedded = ASSETS.iter().find(|(asset, _)| Path::new(asset) == path);
                let bytes: Cow<'_, [u8]> = match embedded {
                    Some((_, bytes)) if self.embedded => Cow::Borrowed(bytes),
                    _ => Cow::Owned(read_file(&path)?),
                };
                (self.parse(&path, bytes.into_owned())?, path.display().to_string())
            }
            Source::Crate(asset) => {
                let path = self.located(asset, places)?;
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

    /// The file that holds the geometry, if one on this machine does.
    pub fn source_path(&self, places: &Places) -> Result<Option<PathBuf>, LoadError> {
        Ok(match &self.file.source {
            Source::Spd(_) | Source::Shapes(_) => None,
            Source::File(_) if self.embedded => None,
            Source::File(name) => Some(self.source_file(name)?),
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
    fn source_file(&self, name: &str) -> Result<PathBuf, LoadError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if self.outside {
            return Ok(folder.join(name));
        }
        confined(folder, name).ok_or_else(|| LoadError::OutsideSource {
            place: FilePlace::file(&self.path),
            path: shortened(name),
        })
    }

    fn parse(&self, path: &Path, bytes: Vec<u8>) -> Result<Scene, LoadError> {
        self.check_hash(path, &bytes)?;
        let options = ReadOptions { triangulate: self.file.triangulate, outside: self.outside };
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
