//! A copy of a program's file, to be run beside it: the same code, elsewhere in memory and on disk.

use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// The file could not be copied.
#[derive(Debug, thiserror::Error)]
#[error("cannot copy {} into {}: {source}", program.display(), folder.display())]
pub struct CopyError {
    /// The program.
    program: PathBuf,
    /// The folder for temporary files.
    folder: PathBuf,
    /// The system's reason.
    source: io::Error,
}

/// The copy; it is removed with this.
#[derive(Debug)]
pub struct ProgramCopy {
    _folder: TempDir,
    path: PathBuf,
}

impl ProgramCopy {
    /// Copies the program, with its permissions, into a folder of its own within `temporary`.
    ///
    /// # Errors
    /// [`CopyError`].
    pub fn of(program: &Path, temporary: &Path) -> Result<Self, CopyError> {
        let made = || {
            let folder = tempfile::Builder::new().prefix("rtbench-copy-").tempdir_in(temporary)?;
            let name = program.file_name().unwrap_or("rtbench".as_ref());
            let path = folder.path().join(name);
            std::fs::copy(program, &path)?;
            Ok(Self { _folder: folder, path })
        };
        made().map_err(|source| CopyError {
            program: program.into(),
            folder: temporary.into(),
            source,
        })
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_is_the_same_and_goes_away() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        std::fs::write(&program, "code").unwrap();
        let copy = ProgramCopy::of(&program, folder.path()).unwrap();
        assert_eq!(std::fs::read(copy.path()).unwrap(), b"code");
        let path = copy.path().to_owned();
        assert!(path != program && path.ends_with("program"));
        drop(copy);
        assert!(!path.exists());
        let error = ProgramCopy::of(&folder.path().join("none"), folder.path()).unwrap_err();
        assert!(error.to_string().starts_with("cannot copy "), "{error}");
    }
}
