//! The last line of a journal whose run a signal ends. Where the journal's folder was removed
//! since, the journal is written anew first: a file that was removed can be read as long as it is
//! open.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::journal::lines::Line;
use crate::journal::seal::Seal;
use crate::system::files;
use crate::system::files::put;

pub struct LastLine {
    pub(super) file: File,
    pub(super) seal: Seal,
    pub(super) path: PathBuf,
    pub(super) temporary: Option<PathBuf>,
}

impl LastLine {
    /// Says which signal it was; the folder where the journal is then, if that is not where it was.
    ///
    /// # Errors
    /// The system's: where the journal is gone, it could not be written anywhere else.
    pub fn write(mut self, signal: i32) -> io::Result<Option<PathBuf>> {
        let line = Line::Interrupted(signal).text().map_err(io::Error::other)?;
        let written = self.file.write_all((self.seal.sealed(&line) + "\n").as_bytes());
        if is_at(&self.file, &self.path) {
            return written.map(|()| None);
        }
        let mut bytes = Vec::new();
        self.file.seek(SeekFrom::Start(0))?;
        self.file.read_to_end(&mut bytes)?;
        let folder = self.path.parent().unwrap_or(Path::new("")).to_owned();
        // what another run put there stays
        if !self.path.exists() {
            let again = fs::create_dir_all(&folder).and_then(|()| put(&self.path, &bytes));
            if again.is_ok() {
                return Ok(Some(folder));
            }
        }
        let within = self.temporary.ok_or(io::ErrorKind::NotFound)?;
        let folder = files::create(&within)?;
        put(&folder.join(self.path.file_name().unwrap_or_default()), &bytes)?;
        Ok(Some(folder))
    }
}

/// Returns whether the file is what lies there.
fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let id = |m: &fs::Metadata| (m.dev(), m.ino());
        matches!((file.metadata(), fs::metadata(path)), (Ok(own), Ok(there)) if id(&own) == id(&there))
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::lines::{read, tests::manifest};
    use crate::journal::{Journal, NAME};

    /// The lines of the journal in a folder; the last one says that it was interrupted.
    fn lines(folder: &Path) -> usize {
        let bytes = fs::read(folder.join(NAME)).unwrap();
        assert!(read(&bytes).unwrap().died_in.is_none(), "it is marked");
        bytes.iter().filter(|&&b| b == b'\n').count()
    }

    #[test]
    fn a_journal_that_was_removed_is_written_anew() {
        let within = tempfile::tempdir().unwrap();
        let (out, temporary) = (within.path().join("a/out"), within.path().join("temporary"));
        fs::create_dir(&temporary).unwrap();
        /// Callback for a folder's fate.
        type FolderFate = fn(&Path);
        let fates: [(FolderFate, bool); 4] = [
            (|_| {}, true),
            (|out| fs::remove_dir_all(out.parent().unwrap()).unwrap(), true),
            (
                |out| {
                    fs::remove_dir_all(out).unwrap();
                    fs::write(out, "mine").unwrap();
                },
                false,
            ),
            // another run's
            (
                |out| {
                    fs::remove_dir_all(out).unwrap();
                    fs::create_dir(out).unwrap();
                    fs::write(out.join(NAME), "theirs").unwrap();
                },
                false,
            ),
        ];
        for (fate, is_there) in fates {
            let _ = fs::remove_file(&out);
            fs::create_dir_all(&out).unwrap();
            let mut journal = Journal::begin(&out, manifest()).unwrap();
            journal.append(&Line::Scene(0)).unwrap();
            let last = journal.last_line(Some(temporary.clone())).unwrap();
            fate(&out);
            let folder = last.write(2).unwrap().unwrap_or_else(|| out.clone());
            assert_eq!(folder == out, is_there);
            assert!(is_there || folder.starts_with(&temporary));
            assert_eq!(lines(&folder), 3);
        }
        assert_eq!(fs::read_to_string(out.join(NAME)).unwrap(), "theirs");
    }

    #[test]
    fn a_journal_that_has_no_place_left_is_an_error() {
        let within = tempfile::tempdir().unwrap();
        let out = within.path().join("out");
        fs::create_dir(&out).unwrap();
        let journal = Journal::begin(&out, manifest()).unwrap();
        let last = journal.last_line(None).unwrap();
        fs::remove_dir_all(&out).unwrap();
        fs::write(&out, "mine").unwrap();
        assert!(last.write(2).is_err());
    }
}
