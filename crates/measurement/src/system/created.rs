//! What a command creates before its work is done, so that an unwritable path or a full disk is
//! found at once; what is still empty when the command ends, because it was refused or failed, is
//! taken back.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

/// Files and folders that were not there before. Dropped, it removes those that are still empty;
/// what was there, empty or not, stays as it was.
#[derive(Debug, Default)]
pub struct CreatedFiles {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl CreatedFiles {
    /// Opens a file for writing, and creates it where there is none. Its content stays.
    pub fn file(&mut self, path: &Path) -> Result<File, WriteError> {
        let error = |source| WriteError { path: path.to_owned(), source };
        let was_there = path.exists();
        let mut options = OpenOptions::new();
        let file = options.create(true).write(true).truncate(false).open(path).map_err(error)?;
        if !was_there {
            // what a link points to, and whatever the working directory is by then
            self.files.push(fs::canonicalize(path).map_err(error)?);
        }
        Ok(file)
    }

    /// Creates a folder and those that it lies in, where there are none.
    pub fn folder(&mut self, path: &Path) -> Result<(), WriteError> {
        let missing: Vec<&Path> =
            path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        let made = fs::create_dir_all(path);
        // those that were made before one failed, too
        let made_now = missing.into_iter().rev().filter_map(|p| fs::canonicalize(p).ok());
        self.folders.extend(made_now);
        made.map_err(|source| WriteError { path: path.to_owned(), source })
    }

    /// Nothing is taken back: what is empty is meant to be.
    pub fn keep(&mut self) {
        self.files.clear();
        self.folders.clear();
    }
}

impl Drop for CreatedFiles {
    fn drop(&mut self) {
        for file in &self.files {
            if fs::metadata(file).is_ok_and(|m| m.is_file() && m.len() == 0) {
                let _ = fs::remove_file(file);
            }
        }
        for folder in self.folders.iter().rev() {
            // refused where something is in it
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Creates the files that are named and written later.
pub fn create<'p>(
    paths: impl IntoIterator<Item = &'p Option<PathBuf>>,
) -> Result<CreatedFiles, WriteError> {
    let mut created = CreatedFiles::default();
    for path in paths.into_iter().flatten() {
        created.file(path)?;
    }
    Ok(created)
}

/// A file or folder cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    pub path: PathBuf,
    pub source: io::Error,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn only_new_and_empty_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("old"), "text").unwrap();
        fs::write(at("old and empty"), "").unwrap();
        fs::create_dir(at("old folder")).unwrap();
        let mut created = CreatedFiles::default();
        for name in ["old", "old and empty", "new"] {
            created.file(&at(name)).unwrap();
        }
        created.file(&at("filled")).unwrap().write_all(b"text").unwrap();
        for name in ["old folder", "new folder/inner", "filled folder/inner"] {
            created.folder(&at(name)).unwrap();
        }
        fs::write(at("filled folder/file"), "text").unwrap();
        assert!(at("new").exists() && at("new folder/inner").exists());
        drop(created);
        for name in ["old", "old and empty", "old folder", "filled", "filled folder/file"] {
            assert!(at(name).exists(), "{name}");
        }
        for name in ["new", "new folder", "filled folder/inner"] {
            assert!(!at(name).exists(), "{name}");
        }
        assert_eq!(fs::read_to_string(at("old")).unwrap(), "text");
    }

    #[test]
    fn folders_created_before_a_failure_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "text").unwrap();
        let mut created = CreatedFiles::default();
        assert!(created.folder(&folder.path().join("file/inner")).is_err());
        assert!(created.file(&folder.path().join("none/file")).is_err());
        drop(created);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
