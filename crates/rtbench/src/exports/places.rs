//! Finds outputs that are the same file under two names, or that would overwrite an input.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::exports::outputs::OutputError;

/// Refuses outputs of which two are the same file, or one is an input.
///
/// # Errors
/// [`OutputError::SameFile`] or [`OutputError::IsRead`] for the first such output.
pub fn refuse_shared(outputs: &[PathBuf], inputs: &[PathBuf]) -> Result<(), OutputError> {
    let read: BTreeSet<PathBuf> = inputs.iter().filter_map(|path| place(path)).collect();
    let mut written = BTreeSet::new();
    for path in outputs {
        let Some(place) = place(path) else { continue };
        if read.contains(&place) {
            return Err(OutputError::IsRead(path.clone()));
        }
        if !written.insert(place) {
            return Err(OutputError::SameFile(path.clone()));
        }
    }
    Ok(())
}

/// The identity of a file under any of its names; of one that does not exist yet, the path it will
/// have. None for standard output, pipes and devices, which hold nothing to destroy.
fn place(path: &Path) -> Option<PathBuf> {
    if path.as_os_str() == "-" || path.metadata().is_ok_and(|found| !found.is_file()) {
        return None;
    }
    if let Some(file) = identity(path) {
        return Some(file);
    }
    let absolute = std::path::absolute(path).ok()?;
    let mut behind = Vec::new();
    let mut folder = absolute.as_path();
    while let (Some(name), Some(parent)) = (folder.file_name(), folder.parent()) {
        behind.push(name);
        folder = parent;
        if let Ok(real) = folder.canonicalize() {
            return Some(behind.iter().rev().fold(real, |place, name| place.join(name)));
        }
    }
    Some(absolute)
}

/// Device and inode: equal for all links to one file.
#[cfg(unix)]
fn identity(path: &Path) -> Option<PathBuf> {
    use std::os::unix::fs::MetadataExt;
    let found = path.metadata().ok()?;
    Some(format!("{}:{}", found.dev(), found.ino()).into())
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}
