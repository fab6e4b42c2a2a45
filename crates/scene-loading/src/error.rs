//! Errors of loading a scene. Every error names the file, the line if there is one, what was found
//! and what would be valid.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::polygon::ear_clipping::SelfCrossing;

/// A file and, where the format has them, a line, or else a byte; printed as `file:line` or
/// `file: byte 80`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilePlace {
    /// The file as it was named to the loader.
    pub file: PathBuf,
    pub within: FileLocation,
}

/// Position in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileLocation {
    /// The file as a whole.
    Whole,
    /// A line, counted from 1.
    Line(usize),
    /// A byte of binary data, counted from 0 after decompression.
    Byte(usize),
}

impl FilePlace {
    /// The file as a whole.
    pub fn file(file: &Path) -> Self {
        Self { file: file.to_path_buf(), within: FileLocation::Whole }
    }

    /// A line of the file, counted from 1.
    pub fn line(file: &Path, line: usize) -> Self {
        Self { file: file.to_path_buf(), within: FileLocation::Line(line) }
    }

    /// A byte of a binary file, counted from 0 after decompression.
    pub fn byte(file: &Path, byte: usize) -> Self {
        Self { file: file.to_path_buf(), within: FileLocation::Byte(byte) }
    }
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.display();
        match self.within {
            FileLocation::Whole => write!(f, "{file}"),
            FileLocation::Line(line) => write!(f, "{file}:{line}"),
            FileLocation::Byte(byte) => write!(f, "{file}: byte {byte}"),
        }
    }
}

/// Why a scene could not be loaded.
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The operating system refused to read or write the file.
    #[error("{place}: {source}")]
    Io { place: FilePlace, source: std::io::Error },
    /// The file, or what it unpacks to, is larger than loaders accept.
    #[error("{place}: larger than the limit of {limit} bytes (after decompression)")]
    TooLarge { place: FilePlace, limit: u64 },
    /// A `.gz` or `.zst` file unpacks to so much that it can be no scene.
    #[error(
        "{place}: {packed} bytes unpack to more than {limit} (the limit is 64 MiB plus 200 times \
         the packed size)"
    )]
    Inflated { place: FilePlace, packed: u64, limit: u64 },
    /// A `.gz` or `.zst` stream is damaged.
    #[error("{place}: not a readable {format} stream: {message}")]
    Decompress { place: FilePlace, format: &'static str, message: String },
    /// The file name has none of the endings a loader is registered for.
    #[error("{place}: unknown scene format; valid endings: {valid}")]
    UnknownFormat { place: FilePlace, valid: String },
    /// Something else stands where the format asks for a number, a keyword, ...
    #[error("{place}: found {found}, expected {expected}")]
    Syntax { place: FilePlace, found: String, expected: String },
    /// The file ends in the middle of an entity.
    #[error("{place}: the file ends where {expected} was expected")]
    UnexpectedEnd { place: FilePlace, expected: String },
    /// A number is NaN or infinite.
    #[error("{place}: {what} is {found}, expected a finite number")]
    NotFinite { place: FilePlace, what: String, found: String },
    /// A number is finite but outside the values its quantity may have.
    #[error("{place}: {what} is {found}, expected {expected}")]
    OutOfRange { place: FilePlace, what: String, found: String, expected: String },
    /// A count that the rest of the file cannot possibly hold, or that is above a loader's cap.
    #[error("{place}: {what} is {count}, but at most {limit} are possible here")]
    CountTooLarge { place: FilePlace, what: String, count: u64, limit: u64 },
    /// An index refers to something that does not exist.
    #[error("{place}: {what} index {index} is out of range: {valid}")]
    IndexOutOfRange { place: FilePlace, what: String, index: String, valid: String },
    /// A face that must be split into triangles and is not.
    #[error("{place}: {source}")]
    Entangled { place: FilePlace, source: SelfCrossing },
    /// The file is well-formed but holds no primitive.
    #[error("{place}: no primitives; expected at least one {expected}")]
    NoPrimitives { place: FilePlace, expected: &'static str },
    /// The glTF or OBJ parser of a library reported an error after our own checks passed.
    #[error("{place}: {parser} reports: {message}")]
    Parser { place: FilePlace, parser: &'static str, message: String },
    /// The length in a GLB header differs from the file's.
    #[error("{place}: the GLB header states {declared} bytes, the file has {actual}")]
    GlbLength { place: FilePlace, declared: u64, actual: u64 },
    /// A part of a glTF file breaks a rule of the format.
    #[error("{place}: {object}: found {found}, expected {expected}")]
    Gltf { place: FilePlace, object: String, found: String, expected: String },
    /// A glTF accessor or buffer view reads beyond the bytes it has.
    #[error("{place}: {object} needs {needed} bytes, but only {available} are available")]
    PastBuffer { place: FilePlace, object: String, needed: u64, available: u64 },
    /// A reference leads out of the folder of the file that holds it.
    #[error(
        "{place}: `{uri}` leads out of the file's own folder; expected a relative path below it or a data: URI"
    )]
    OutsideFolder { place: FilePlace, uri: String },
    /// The source of a scene file lies outside its folder.
    #[error(
        "{place}: `{path}` leads out of the scene file's folder; expected a relative path below it \
         (--allow-outside reads it; only for scenes that you trust)"
    )]
    OutsideSource { place: FilePlace, path: String },
    /// A node of a glTF scene can be reached twice (a cycle, or two parents).
    #[error("{place}: node {node} is reached twice; expected a tree (each node has one parent)")]
    NodeReachedTwice { place: FilePlace, node: usize },
    /// A JSON scene or set file is malformed: `message` is the parser's, with the valid keys.
    #[error("{place}:{column}: {message}")]
    Json { place: FilePlace, column: usize, message: String },
    /// The file is not the one that the scene file describes.
    #[error("{place}: SHA-256 is {found}, expected {expected} (see the scene file)")]
    HashMismatch { place: FilePlace, expected: String, found: String },
    /// A procedural scene could not be generated.
    #[error("procedural scene `{spec}`: {message}")]
    Procedural { spec: String, message: String },
    /// No scene, set or file of that name.
    #[error("unknown scene `{name}`{suggestion}; valid: {valid}")]
    UnknownScene { name: String, suggestion: String, valid: String },
    /// No file has a name that fits the pattern of a sequence.
    #[error("{place}: no file matches this name with a number instead of %d")]
    NoFrames { place: FilePlace },
    /// A sequence of files has a hole.
    #[error("{place}: {} is missing, but {} exists", .files.0.display(), .files.1.display())]
    MissingFrame { place: FilePlace, files: Box<(PathBuf, PathBuf)> },
    /// A scene of which there is but one size.
    #[error("`{name}` does not come in sizes; those that do: {valid}")]
    NoSizes { name: String, valid: String },
    /// A scene that ships inside a package is not on this machine yet.
    #[error(
        "scene `{scene}` comes with the package {package} and is not on this machine (looked for {path}); fetch it with: rtbench scenes fetch {scene}"
    )]
    NotFetched { scene: String, package: String, path: String },
    /// A package could not be brought to this machine.
    #[error("cannot fetch the package {package}: {message}")]
    Fetch { package: String, message: String },
}

impl LoadError {
    pub(crate) fn io(file: &Path, source: std::io::Error) -> Self {
        Self::Io { place: FilePlace::file(file), source }
    }

    pub(crate) fn syntax(place: FilePlace, found: &str, expected: impl Into<String>) -> Self {
        Self::Syntax { place, found: quote(found), expected: expected.into() }
    }

    pub(crate) fn unexpected_end(place: FilePlace, expected: impl ToString) -> Self {
        Self::UnexpectedEnd { place, expected: expected.to_string() }
    }

    pub(crate) fn not_finite(place: FilePlace, what: impl ToString, found: impl ToString) -> Self {
        Self::NotFinite { place, what: what.to_string(), found: found.to_string() }
    }

    pub(crate) fn out_of_range(
        place: FilePlace,
        what: impl ToString,
        found: impl ToString,
        expected: impl ToString,
    ) -> Self {
        let (what, found, expected) = (what.to_string(), found.to_string(), expected.to_string());
        Self::OutOfRange { place, what, found, expected }
    }

    pub(crate) fn too_many(place: FilePlace, what: impl ToString, count: u64, limit: u64) -> Self {
        Self::CountTooLarge { place, what: what.to_string(), count, limit }
    }

    pub(crate) fn bad_index(
        place: FilePlace,
        what: impl ToString,
        index: impl ToString,
        valid: impl ToString,
    ) -> Self {
        let (what, index, valid) = (what.to_string(), index.to_string(), valid.to_string());
        Self::IndexOutOfRange { place, what, index, valid }
    }

    pub(crate) fn no_primitives(file: &Path, expected: &'static str) -> Self {
        Self::NoPrimitives { place: FilePlace::file(file), expected }
    }

    pub(crate) fn too_large(file: &Path, limit: u64) -> Self {
        Self::TooLarge { place: FilePlace::file(file), limit }
    }

    pub(crate) fn procedural(spec: &str, error: impl ToString) -> Self {
        Self::Procedural { spec: spec.to_owned(), message: error.to_string() }
    }

    /// An error of the crate `gltf`, in its words.
    pub(crate) fn parser(file: &Path, message: impl ToString) -> Self {
        let (place, message) = (FilePlace::file(file), message.to_string());
        Self::Parser { place, parser: "gltf", message }
    }

    pub(crate) fn gltf(
        file: &Path,
        object: impl ToString,
        found: impl ToString,
        expected: impl ToString,
    ) -> Self {
        let (place, object) = (FilePlace::file(file), object.to_string());
        Self::Gltf { place, object, found: found.to_string(), expected: expected.to_string() }
    }
}

/// What was found in place of a finite number, where all that is known is that it is none.
pub(crate) const NOT_FINITE: &str = "NaN or infinite";

/// ` (did you mean ...?)` with the valid name that is nearest to a misspelt one, if it is near. A
/// size behind the name does not count.
pub(crate) fn suggestion(name: &str, valid: &[&str]) -> String {
    let head = name.split(':').next().unwrap_or(name).to_lowercase();
    let nearest = valid.iter().map(|valid| (strsim::damerau_levenshtein(&head, valid), valid));
    match nearest.min() {
        Some((distance, valid)) if distance <= (valid.len() / 3).max(1) => {
            format!(" (did you mean `{valid}`?)")
        }
        _ => String::new(),
    }
}

/// Text from a file, quoted for a message and cut to a readable length.
pub(crate) fn quote(text: &str) -> String {
    format!("`{}`", shortened(text))
}

/// Text from a file without control characters, cut to a readable length.
pub(crate) fn shortened(text: &str) -> String {
    const LONGEST: usize = 40;
    let clean: String =
        text.chars().take(LONGEST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    let more = if text.chars().nth(LONGEST).is_some() { "..." } else { "" };
    clean + more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_file_and_line() {
        let place = FilePlace::line(Path::new("a/b.nff"), 7);
        let error = LoadError::syntax(place, "fish", "an entity keyword");
        assert_eq!(error.to_string(), "a/b.nff:7: found `fish`, expected an entity keyword");
    }

    #[test]
    fn quotes_are_short_and_printable() {
        assert_eq!(quote("a\u{7}b"), "`a\u{fffd}b`");
        assert!(quote(&"x".repeat(1000)).len() < 50);
    }
}
