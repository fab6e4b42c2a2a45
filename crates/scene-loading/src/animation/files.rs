//! Files as frames: a path with a pattern as of printf, `frame%04d.obj`, for the numbers that there
//! are.
//!
//! The lowest number is that of the first frame; from there on none may be missing. Frames may
//! differ in all they have. What a file says to be instances holds within it, not from frame to
//! frame: it is not claimed.

use std::path::{Path, PathBuf};

use crate::animation::frames::{Animation, check_frame};
use crate::error::{FilePlace, LoadError};
use crate::input::read::{extension, read_file, scene_name};
use crate::limits;
use crate::scene::{Camera, Scene};
use crate::source::formats::{ENDINGS, ReadOptions, is_scene_path, parse_scene};
use crate::view_options::light_if_dark;

/// The most frames of a sequence.
const MAX_FRAMES: usize = 1 << 20;

/// The most digits of a number.
const MAX_DIGITS: usize = 9;

/// A name with a place for a number, which is the only one in it.
struct Pattern<'a> {
    before: &'a str,
    /// Digits at least, with zeros in front.
    width: usize,
    behind: &'a str,
}

impl<'a> Pattern<'a> {
    fn of(name: &'a str) -> Option<Self> {
        let (before, rest) = name.split_once('%')?;
        let (width, behind) = rest.split_once('d')?;
        let width = match width {
            "" => 1,
            digits => {
                digits.strip_prefix('0')?.parse().ok().filter(|n| (1..=MAX_DIGITS).contains(n))?
            }
        };
        (!behind.contains('%')).then_some(Self { before, width, behind })
    }

    fn name(&self, number: u32) -> String {
        format!("{}{number:0width$}{}", self.before, self.behind, width = self.width)
    }

    /// The number in a file's name, if it is one of these.
    fn number(&self, name: &str) -> Option<u32> {
        let digits = name.strip_prefix(self.before)?.strip_suffix(self.behind)?;
        let number = digits.parse().ok().filter(|_| digits.len() <= MAX_DIGITS)?;
        (self.name(number) == name).then_some(number)
    }
}

/// A sequence of files.
struct Files {
    name: String,
    paths: Vec<PathBuf>,
    /// Camera of the first frame, for formats without cameras.
    camera: Option<Camera>,
}

/// True for a path that has a pattern in its last part.
pub(super) fn is_pattern(path: &Path) -> bool {
    name_of(path).is_some_and(|name| Pattern::of(name).is_some())
}

fn name_of(path: &Path) -> Option<&str> {
    path.file_name().and_then(|name| name.to_str())
}

/// Opens the sequence of a path with a pattern; reads no file yet.
pub(super) fn open(path: &Path) -> Result<Box<dyn Animation>, LoadError> {
    let no_frames = || LoadError::NoFrames { place: FilePlace::file(path) };
    let pattern = name_of(path).and_then(Pattern::of).ok_or_else(no_frames)?;
    if !is_scene_path(path) {
        let valid = ENDINGS.join(", ");
        return Err(LoadError::UnknownFormat { place: FilePlace::file(path), valid });
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).map_err(|e| LoadError::io(folder, e))?;
    let number = |entry: std::fs::DirEntry| pattern.number(entry.file_name().to_str()?);
    let mut numbers: Vec<u32> = entries.flatten().filter_map(number).collect();
    limits::check(numbers.len(), MAX_FRAMES, "the number of frames", || FilePlace::file(path))?;
    numbers.sort_unstable();
    let first = *numbers.first().ok_or_else(no_frames)?;
    let file = |number| path.with_file_name(pattern.name(number));
    if let Some((missing, found)) = (first..).zip(&numbers).find(|(due, found)| due != *found) {
        let (missing, later) = (file(missing), file(*found));
        let files = Box::new((missing, later));
        return Err(LoadError::MissingFrame { place: FilePlace::file(path), files });
    }
    let paths = numbers.into_iter().map(file).collect();
    Ok(Box::new(Files { name: scene_name(path), paths, camera: None }))
}

impl Files {
    fn load(&self, index: u32) -> Result<Scene, LoadError> {
        check_frame(&self.name, index, self.frames())?;
        let path = self.paths.get(index as usize).map(PathBuf::as_path).unwrap_or(Path::new(""));
        parse_scene(path, read_file(path)?, ReadOptions::default())
    }

    /// True for formats without a camera, whose loaders frame the scene: each frame would be framed
    /// anew.
    fn is_framed(&self) -> bool {
        let path = self.paths.first().map(|path| path.to_string_lossy().to_ascii_lowercase());
        let path = path.unwrap_or_default();
        let path = path.strip_suffix(".gz").or(path.strip_suffix(".zst")).unwrap_or(&path);
        ["obj", "ply", "stl", "bin"].contains(&extension(Path::new(path)).as_str())
    }
}

impl Animation for Files {
    fn name(&self) -> &str {
        &self.name
    }

    fn frames(&self) -> u32 {
        u32::try_from(self.paths.len()).unwrap_or(u32::MAX)
    }

    fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        let mut scene = self.load(index)?;
        if self.is_framed() {
            scene.camera = match self.camera {
                Some(camera) => camera,
                None if index == 0 => scene.camera,
                None => self.load(0)?.camera,
            };
            self.camera = Some(scene.camera);
        }
        scene.name.clone_from(&self.name);
        scene.instances.clear();
        light_if_dark(&mut scene);
        Ok(scene)
    }
}
