//! What can go wrong while a scene is loaded. Every error names the file, the line where there is
//! one, what was found there and what would have been valid.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file and, where the format has them, a line; printed as `file:line`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file as it was named to the loader.
    pub file: PathBuf,
    /// Line number counted from 1, or `None` for binary files and for the file as a whole.
    pub line: Option<usize>,
}

impl Place {
    /// The file as a whole.
    pub fn file(file: &Path) -> Self {
        Self { file: file.to_path_buf(), line: None }
    }

    /// A line of the file, counted from 1.
    pub fn line(file: &Path, line: usize) -> Self {
        Self { file: file.to_path_buf(), line: Some(line) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.file.display()),
            None => write!(f, "{}", self.file.display()),
        }
    }
}

/// Why a scene could not be loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The operating system refused to read or write the file.
    #[error("{place}: {source}")]
    Io {
        /// The file.
        place: Place,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file, or what it unpacks to, is larger than loaders accept.
    #[error("{place}: larger than the limit of {limit} bytes (after decompression)")]
    TooLarge {
        /// The file.
        place: Place,
        /// The limit in bytes.
        limit: u64,
    },
    /// A `.gz` or `.zst` stream is damaged.
    #[error("{place}: not a readable {format} stream: {message}")]
    Decompress {
        /// The file.
        place: Place,
        /// `gzip` or `zstd`.
        format: &'static str,
        /// What the decompressor said.
        message: String,
    },
    /// The file name has none of the endings a loader is registered for.
    #[error("{place}: unknown scene format; valid endings: {valid}")]
    UnknownFormat {
        /// The file.
        place: Place,
        /// The valid endings, comma-separated.
        valid: String,
    },
    /// Something else stands where the format asks for a number, a keyword, ...
    #[error("{place}: found {found}, expected {expected}")]
    Syntax {
        /// Where.
        place: Place,
        /// The offending text, shortened.
        found: String,
        /// What is valid there.
        expected: String,
    },
    /// The file ends in the middle of an entity.
    #[error("{place}: the file ends where {expected} was expected")]
    UnexpectedEnd {
        /// The last line.
        place: Place,
        /// What was still to come.
        expected: String,
    },
    /// A number is NaN or infinite.
    #[error("{place}: {what} is {found}, expected a finite number")]
    NotFinite {
        /// Where.
        place: Place,
        /// Which quantity.
        what: String,
        /// The number as written.
        found: String,
    },
    /// A number is finite but outside the values its quantity may have.
    #[error("{place}: {what} is {found}, expected {expected}")]
    OutOfRange {
        /// Where.
        place: Place,
        /// Which quantity.
        what: String,
        /// The value as written.
        found: String,
        /// The valid values.
        expected: String,
    },
    /// A sphere with a negative radius, or a cone whose radii differ in sign.
    #[error("{place}: {what} is {radius}, expected {expected}")]
    NegativeRadius {
        /// Where.
        place: Place,
        /// Which radius.
        what: &'static str,
        /// The radius found, in world units.
        radius: f64,
        /// The valid radii.
        expected: &'static str,
    },
    /// A count that the rest of the file cannot possibly hold, or that is above a loader's cap.
    #[error("{place}: {what} says {count}, but at most {limit} are possible here")]
    CountTooLarge {
        /// Where.
        place: Place,
        /// What is counted.
        what: String,
        /// The count as stated.
        count: u64,
        /// The largest count that is possible.
        limit: u64,
    },
    /// An index refers to something that does not exist.
    #[error("{place}: {what} index {index} is out of range: {valid}")]
    IndexOutOfRange {
        /// Where.
        place: Place,
        /// What is indexed.
        what: String,
        /// The index as written.
        index: String,
        /// The valid range in words.
        valid: String,
    },
    /// The file is well-formed but holds no primitive.
    #[error("{place}: no primitives; expected at least one {expected}")]
    NoPrimitives {
        /// The file.
        place: Place,
        /// What the format calls its primitives.
        expected: &'static str,
    },
    /// The glTF or OBJ parser of a library reported an error after our own checks passed.
    #[error("{place}: {parser} says: {message}")]
    Parser {
        /// The file.
        place: Place,
        /// The library.
        parser: &'static str,
        /// Its message, or its panic's.
        message: String,
    },
    /// The length in a GLB header differs from the file's.
    #[error("{place}: the GLB header states {declared} bytes, the file has {actual}")]
    GlbLength {
        /// The file.
        place: Place,
        /// Length in the header, bytes.
        declared: u64,
        /// Length of the file, bytes.
        actual: u64,
    },
    /// A part of a glTF file breaks a rule of the format.
    #[error("{place}: {object}: found {found}, expected {expected}")]
    Gltf {
        /// The file.
        place: Place,
        /// Which object of the document: `mesh 3 primitive 0`.
        object: String,
        /// What was found.
        found: String,
        /// What is valid.
        expected: String,
    },
    /// A glTF accessor or buffer view reads beyond the bytes it has.
    #[error("{place}: {object} needs {needed} bytes, but only {available} are there")]
    PastBuffer {
        /// The file.
        place: Place,
        /// Which accessor or view.
        object: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes there.
        available: u64,
    },
    /// A reference leads out of the folder of the file that holds it.
    #[error(
        "{place}: `{uri}` leads out of the file's own folder; expected a relative path below it or a data: URI"
    )]
    OutsideFolder {
        /// The file.
        place: Place,
        /// The reference as written.
        uri: String,
    },
    /// A node of a glTF scene can be reached twice (a cycle, or two parents).
    #[error("{place}: node {node} is reached twice; expected a tree (each node has one parent)")]
    NodeReachedTwice {
        /// The file.
        place: Place,
        /// Index of the node.
        node: usize,
    },
    /// A JSON scene or set file is malformed: `message` is the parser's, with the valid keys.
    #[error("{place}:{column}: {message}")]
    Json {
        /// File and line.
        place: Place,
        /// Column counted from 1.
        column: usize,
        /// What was found and expected.
        message: String,
    },
    /// The file is not the one that the scene file describes.
    #[error("{place}: SHA-256 is {found}, expected {expected} (see the scene file)")]
    HashMismatch {
        /// The file with the wrong content.
        place: Place,
        /// Hash in the scene file, hexadecimal.
        expected: String,
        /// Hash of the file, hexadecimal.
        found: String,
    },
    /// A procedural scene could not be generated.
    #[error("procedural scene `{spec}`: {message}")]
    Procedural {
        /// The specification as given, `balls:5`.
        spec: String,
        /// The generator's message.
        message: String,
    },
    /// No scene, set or file of that name.
    #[error("unknown scene `{name}`{suggestion}; valid: {valid}")]
    UnknownScene {
        /// The name as given.
        name: String,
        /// ` (did you mean ...?)` or empty.
        suggestion: String,
        /// All valid names and forms.
        valid: String,
    },
    /// A scene of which there is but one size.
    #[error("`{name}` does not come in sizes; those that do: {valid}")]
    NoSizes {
        /// The name as given.
        name: String,
        /// The names of scenes that have sizes.
        valid: String,
    },
    /// A scene that ships inside a package is not on this machine yet.
    #[error(
        "scene `{scene}` comes with the package {package} and is not on this machine (looked for {path}); fetch it with: rtbench scenes fetch {scene}"
    )]
    NotFetched {
        /// Name of the scene.
        scene: String,
        /// Package and version.
        package: String,
        /// Path inside the package.
        path: String,
    },
    /// A package could not be brought to this machine.
    #[error("cannot fetch the package {package}: {message}")]
    Fetch {
        /// Package and version.
        package: String,
        /// What cargo or the system said.
        message: String,
    },
}

impl LoadError {
    pub(crate) fn io(file: &Path, source: std::io::Error) -> Self {
        Self::Io { place: Place::file(file), source }
    }

    pub(crate) fn syntax(place: Place, found: &str, expected: impl Into<String>) -> Self {
        Self::Syntax { place, found: quote(found), expected: expected.into() }
    }
}

/// Text from a file, quoted for a message and cut to a readable length.
pub(crate) fn quote(text: &str) -> String {
    const LONGEST: usize = 40;
    let clean: String =
        text.chars().take(LONGEST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    let more = if text.chars().nth(LONGEST).is_some() { "..." } else { "" };
    format!("`{clean}{more}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_file_and_line() {
        let error =
            LoadError::syntax(Place::line(Path::new("a/b.nff"), 7), "fish", "an entity keyword");
        assert_eq!(error.to_string(), "a/b.nff:7: found `fish`, expected an entity keyword");
    }

    #[test]
    fn quotes_are_short_and_printable() {
        assert_eq!(quote("a\u{7}b"), "`a\u{fffd}b`");
        assert!(quote(&"x".repeat(1000)).len() < 50);
    }
}
