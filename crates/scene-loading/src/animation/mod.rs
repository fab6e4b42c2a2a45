//! Scenes that move: a sequence of scenes at rest, a frame each.
//!
//! Frames are made when they are asked for, so that an animation takes the memory of one.
//!
//! Files as frames are a path with a pattern as of printf, `frame%04d.obj`, for the numbers that
//! there are. The lowest number is that of the first frame; from there on none may be missing.
//! Frames may differ in all they have. What a file says to be instances holds within it, not from
//! frame to frame: it is not claimed.

pub(crate) mod frames;
#[allow(clippy::indexing_slicing)]
mod generated;

use std::path::{Path, PathBuf};

use crate::aff;
pub use crate::animation::frames::Animation;
pub use crate::animation::generated::{ANIMATED, AnimatedEntry};
use crate::error::{FilePlace, LoadError, suggestion};
use crate::gltf;
use crate::input::{extension, read_file, scene_name, unpacked_extension};
use crate::limits;
use crate::source::formats::{ENDINGS, ReadOptions, is_scene_path, load_scene};
use crate::source::names::path_of_name;

/// Opens an animation by its name: a generated one, at its default size (`marbles`) or another
/// (`marbles:5`), or the path of a sequence of files (`frame%04d.obj`) of a
/// glTF file with an animation, or of an AFF file.
///
/// # Errors
/// [`LoadError::UnknownScene`] with all valid names and the nearest one, [`LoadError::Procedural`]
/// for a size that there is not, [`LoadError::NoFrames`], [`LoadError::MissingFrame`],
/// [`LoadError::UnknownFormat`], [`LoadError::Io`], and those of [`parse`].
pub fn open(name: &str) -> Result<Animation, LoadError> {
    if let Some(generated) = generated::open(name)? {
        return Ok(generated);
    }
    let path = path_of_name(name);
    if is_pattern(&path) {
        return Ok(open_sequence(&path)?.rebased());
    }
    if is_moving(&path) { parse(&path, read_file(&path)?) } else { Err(unknown(name)) }
}

/// True for formats that hold a whole animation in a file.
fn is_moving(path: &Path) -> bool {
    ["gltf", "glb", "aff"].contains(&extension(path).as_str())
}

/// The animation in the bytes of a glTF or AFF file, as its ending says. `path` gives it its name
/// and the folder of the files that it names, and appears in errors. Far from the origin, all
/// frames are moved near it as the first one is: [`Scene::origin`](crate::Scene::origin).
///
/// # Errors
/// [`LoadError::UnknownFormat`] for other endings, else those of the loader.
pub fn parse(path: &Path, bytes: Vec<u8>) -> Result<Animation, LoadError> {
    let animation = match extension(path).as_str() {
        "gltf" | "glb" => gltf::parse_animation(path, &bytes),
        "aff" => aff::parse(path, bytes),
        _ => Err(LoadError::UnknownFormat {
            place: FilePlace::file(path),
            valid: ".gltf, .glb, .aff".into(),
        }),
    };
    Ok(animation?.rebased())
}

fn unknown(name: &str) -> LoadError {
    let names: Vec<&str> = ANIMATED.iter().map(|entry| entry.name).collect();
    let valid = format!(
        "generated {} (with a size: marbles:5); sequences of files (frame%04d.obj); .gltf and .glb with an animation; .aff",
        names.join(", ")
    );
    LoadError::UnknownScene { name: name.to_owned(), suggestion: suggestion(name, &names), valid }
}

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
fn is_pattern(path: &Path) -> bool {
    name_of(path).is_some_and(|name| Pattern::of(name).is_some())
}

fn name_of(path: &Path) -> Option<&str> {
    path.file_name().and_then(|name| name.to_str())
}

/// Opens the sequence of a path with a pattern; reads no file yet.
fn open_sequence(path: &Path) -> Result<Animation, LoadError> {
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
    let animation = Animation::new(scene_name(path), count, move |index| {
        let path = paths.get(index as usize).map(PathBuf::as_path).unwrap_or(Path::new(""));
        let mut scene = load_scene(path, ReadOptions::default())?;
        scene.instances.clear();
        Ok(scene)
    });
    // loaders of formats without a camera frame the scene: each frame would be framed anew
    let is_framed = ["obj", "ply", "stl", "bin"].contains(&unpacked_extension(path).as_str());
    Ok(if is_framed { animation.seen_as_first() } else { animation })
}
