//! Compares our reading of a file with another reader's: the crate `tobj` for OBJ files, the crate
//! `gltf` for glTF. Notes name what such a reader takes from ours and cannot check.
//!
//! Both panic on some files. Such a panic is caught here (`catch_unwind`), as nothing that it may
//! leave half done outlives the call, and said to be the other reader's opinion. Both take memory
//! without limit from some files that ours refuses or reads in bounds, so they are asked only about
//! files that ours has read, and only up to [`MAX_BYTES`].

mod readers;
mod reading;

use std::path::Path;

use self::reading::Reading;
use crate::error::LoadError;
use crate::gltf::{OpenedFile, catch_panic, parse_gltf};
use crate::input::{decompress, end_lines_with_lf, unpacked_extension, without_mark};
use crate::obj::{ObjOptions, parse_obj};

/// The most bytes, after decompression, of a file that another reader is asked about: 64 MiB.
pub const MAX_BYTES: usize = 64 << 20;

/// Opinion of another reader about a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SecondOpinion {
    /// The same triangles, bounds and materials, or where they differ.
    Asked {
        /// `tobj` or `gltf`.
        reader: &'static str,
        /// Triangles that it finds; those without area do not count.
        triangles: u64,
        /// Differences from our reader; empty if it agrees.
        differences: Vec<String>,
        /// Limits of the comparison: rules and code that it shares with ours.
        notes: Vec<String>,
    },
    /// The file is larger than [`MAX_BYTES`].
    TooLarge,
    /// There is no other reader of the format.
    NoReader,
}

impl SecondOpinion {
    /// In words, a line or more; nothing where there is no other reader.
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::NoReader => Vec::new(),
            Self::TooLarge => vec!["too large to be read a second time".into()],
            Self::Asked { reader, triangles, differences, notes } => {
                let said = |text: &String| format!("second reader: {text}");
                let mut lines: Vec<String> = differences.iter().map(said).collect();
                if differences.is_empty() {
                    lines.push(format!(
                        "{reader} reads the same: {triangles} triangles, bounds, materials"
                    ));
                }
                lines.extend(notes.iter().map(said));
                lines
            }
        }
    }
}

/// Reads a file by our reader and by another. `path` names the format and the folder of what the
/// bytes refer to.
///
/// # Errors
/// [`LoadError`] when ours cannot read it.
pub fn second_opinion(path: &Path, bytes: Vec<u8>) -> Result<SecondOpinion, LoadError> {
    let is_gltf = match unpacked_extension(path).as_str() {
        "gltf" | "glb" => true,
        "obj" => false,
        _ => return Ok(SecondOpinion::NoReader),
    };
    let bytes = decompress(path, bytes)?;
    if bytes.len() > MAX_BYTES {
        return Ok(SecondOpinion::TooLarge);
    }
    if is_gltf {
        let ours = Reading::of(&parse_gltf(path, &bytes)?);
        let bytes = without_mark(path, &bytes)?;
        let opened = OpenedFile::read(path, bytes)?;
        return Ok(compared(
            "gltf",
            &ours,
            catch_panic(|| readers::by_gltf(bytes, &opened)).flatten(),
        ));
    }
    let mut ours = Reading::of(&parse_obj(path, bytes.clone(), ObjOptions::default())?);
    let mut more = Vec::new();
    // marks and ends of lines are no matter of opinion
    let mut bytes = without_mark(path, &bytes)?.to_vec();
    end_lines_with_lf(&mut bytes);
    let theirs = catch_panic(|| readers::by_tobj(path, &bytes)).flatten().map(|(mut theirs, known)| {
        match known {
            Ok(known) => ours.know_only(&known),
            Err(error) => {
                more.push(format!("tobj cannot read the materials: {error}"));
                ours.know_only(&[].into());
                theirs.know_only(&[].into());
            }
        }
        let notes = "taken from our reader, so not checked: which faces have no area; not compared: \
                     normals, textures";
        (theirs, vec![notes.to_owned()])
    });
    let mut opinion = compared("tobj", &ours, theirs);
    if let SecondOpinion::Asked { differences, .. } = &mut opinion {
        differences.append(&mut more);
    }
    Ok(opinion)
}

fn compared(
    reader: &'static str,
    ours: &Reading,
    theirs: Result<(Reading, Vec<String>), String>,
) -> SecondOpinion {
    let (triangles, differences, notes) = match theirs {
        Ok((theirs, notes)) => (theirs.total(), ours.differences(&theirs, reader), notes),
        Err(error) => (0, vec![format!("{reader} refuses it: {error}")], Vec::new()),
    };
    SecondOpinion::Asked { reader, triangles, differences, notes }
}
