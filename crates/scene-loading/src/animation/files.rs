//! Files as frames: a path with a pattern as of printf, `frame%04d.obj`, for the numbers that there
//! are.
//!
//! The lowest number is that of the first frame; from there on none may be missing. Frames may
//! differ in all they have. What a file says to be instances holds within it, not from frame to
//! frame: it is not claimed.

use std::path::{Path, PathBuf};

use crate::animation::frames::Animation;
use crate::error::{FilePlace, LoadError};
use crate::input::read::{scene_name, unpacked_extension};
use crate::limits;
use crate::source::formats::{ENDINGS, ReadOptions, is_scene_path, load_scene};

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

/// True for a path that has a pattern in its last part.
pub(super) fn is_pattern(path: &Path) -> bool {
    name_of(path).is_some_and(|name| Pattern::of(name).is_some())
}

fn name_of(path: &Path) -> Option<&str> {
    path.file_name().and_then(|name| name.to_str())
}

/// Opens the sequence of a path with a pattern; reads no file yet.
pub(super) fn open(path: &Path) -> Result<Animation, LoadError> {
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
    let count = u32::try_from(numbers.len()).unwrap_or(u32::MAX);
    numbers.sort_unstable();
    let first = *numbers.first().ok_or_else(no_frames)?;
    let file = |number| path.with_file_name(pattern.name(number));
    if let Some((missing, found)) = (first..).zip(&numbers).find(|(due, found)| due != *found) {
        let (missing, later) = (file(missing), file(*found));
        let files = Box::new((missing, later));
        return Err(LoadError::MissingFrame { place: FilePlace::file(path), files });
    }
    let paths: Vec<PathBuf> = numbers.into_iter().map(file).collect();
    let load = move |index: u32| {
        let path = paths.get(index as usize).map(PathBuf::as_path).unwrap_or(Path::new(""));
        load_scene(path, ReadOptions::default())
    };
    // loaders of formats without a camera frame the scene: each frame would be framed anew
    let is_framed = ["obj", "ply", "stl", "bin"].contains(&unpacked_extension(path).as_str());
    let mut of_first = None;
    Ok(Animation::new(scene_name(path), count, move |index| {
        let mut scene = load(index)?;
        if is_framed {
            let camera = match of_first {
                Some(camera) => camera,
                None if index == 0 => scene.camera,
                None => load(0)?.camera,
            };
            scene.camera = *of_first.insert(camera);
        }
        scene.instances.clear();
        Ok(scene)
    }))
}
