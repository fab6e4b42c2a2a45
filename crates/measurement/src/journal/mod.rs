//! The journal of a run, `run.jsonl` in its output folder: what is finished stays finished,
//! whatever ends the program. [`lines`] has the format.

pub mod lines;
pub mod seal;

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::journal::lines::{Line, LineError, Manifest, RecoveredRun, read};
use crate::journal::seal::Seal;
use crate::system::files::{self, put};
use crate::system::interrupt::undisturbed;
use presentation::json::FormatError;

/// The journal's name in the output folder.
pub const NAME: &str = "run.jsonl";

/// The most bytes of a journal that are read: a full run writes about 2 MB.
const MAX_BYTES: u64 = 1 << 30;

#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    #[error("cannot write the journal {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{}: no run with -o was started here; expected the file {NAME}", folder.display())]
    None { folder: PathBuf },
    #[error("{}: {source}", path.display())]
    Lines { path: PathBuf, source: LineError },
    #[error("{}: more than {MAX_BYTES} bytes, too large for a journal", path.display())]
    TooLarge { path: PathBuf },
    #[error("{}: another run is writing to it", path.display())]
    Busy { path: PathBuf },
    #[error("{}: line {line}: {message}; start a new run in another folder", path.display())]
    NotOfPlan { path: PathBuf, line: usize, message: String },
    #[error(
        "{}: the settings differ from those of the interrupted run: {differences}; start a new run in another folder",
        folder.display()
    )]
    Differs { folder: PathBuf, differences: String },
    #[error(
        "{}: an earlier version of rtbench started this run and did not record its settings; \
         start a new run in another folder",
        path.display()
    )]
    NotAsked { path: PathBuf },
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// A journal that is open for appending, by this process alone.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    seal: Seal,
    /// Bytes of whole lines.
    length: u64,
}

impl Journal {
    /// Begins the journal of a new run in a folder, in place of the one that is there.
    pub fn begin(folder: &Path, manifest: Manifest) -> Result<Self, JournalError> {
        let mut journal = Self::open(folder, true)?;
        journal.cut()?;
        let first = Line::Begun(Box::new(manifest)).text()?;
        journal.write(&first, true)?;
        journal.seal = Seal::behind(&first);
        Ok(journal)
    }

    /// Opens the journal of a run that was begun; a torn last line is cut off.
    pub fn resume(folder: &Path) -> Result<(Self, RecoveredRun), JournalError> {
        let mut journal = Self::open(folder, false)?;
        let found = read(&journal.bytes()?)
            .map_err(|source| JournalError::Lines { path: journal.path.clone(), source })?;
        journal.length = found.whole as u64;
        journal.seal = found.seal.clone();
        journal.cut()?;
        Ok((journal, found))
    }

    fn open(folder: &Path, is_new: bool) -> Result<Self, JournalError> {
        let path = folder.join(NAME);
        let fail = |source| JournalError::Io { path: path.clone(), source };
        let mut options = OpenOptions::new();
        let file = match options.read(true).append(true).create(is_new).open(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound && !is_new => {
                return Err(JournalError::None { folder: folder.to_owned() });
            }
            other => other.map_err(fail)?,
        };
        if !file.metadata().map_err(fail)?.is_file() {
            return Err(fail(io::Error::other("not a regular file")));
        }
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(JournalError::Busy { path }),
            // of a file system without locks there is no lock
            Err(TryLockError::Error(e)) if e.kind() != io::ErrorKind::Unsupported => Err(fail(e)),
            _ => Ok(Self { file, path, seal: Seal::default(), length: 0 }),
        }
    }

    fn failed(&self, source: io::Error) -> JournalError {
        JournalError::Io { path: self.path.clone(), source }
    }

    fn bytes(&self) -> Result<Vec<u8>, JournalError> {
        let mut bytes = Vec::new();
        let mut file = &self.file;
        let begin = file.seek(SeekFrom::Start(0));
        let read = begin.and_then(|_| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
        read.map_err(|source| self.failed(source))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(JournalError::TooLarge { path: self.path.clone() });
        }
        Ok(bytes)
    }

    /// Takes away what is behind the whole lines.
    fn cut(&self) -> Result<(), JournalError> {
        self.file.set_len(self.length).map_err(|source| self.failed(source))
    }

    /// Appends a line: whole, or, where the system refuses it (a full disk), not at all.
    pub fn append(&mut self, line: &Line) -> Result<(), JournalError> {
        self.write(&line.text()?, true)
    }

    /// The same for a line that only says how far the run is: it need not outlive the machine, and
    /// costs no more than a write.
    pub fn note(&mut self, line: &Line) -> Result<(), JournalError> {
        self.write(&line.text()?, false)
    }

    fn write(&mut self, text: &str, is_synchronised: bool) -> Result<(), JournalError> {
        let text = self.seal.sealed(text) + "\n";
        let sync = |file: &File| if is_synchronised { file.sync_data() } else { Ok(()) };
        let written =
            undisturbed(|| self.file.write_all(text.as_bytes()).and_then(|()| sync(&self.file)));
        if let Err(source) = written {
            self.cut()?;
            return Err(self.failed(source));
        }
        self.length += text.len() as u64;
        Ok(())
    }

    /// Writer of the last line of an interrupted run. `temporary` is a folder for a journal whose
    /// own cannot be created again.
    pub fn last_line(&self, temporary: Option<PathBuf>) -> Result<LastLine, JournalError> {
        let fail = |source| self.failed(source);
        let file = self.file.try_clone().map_err(fail)?;
        // whatever the working directory is by then
        let path = std::path::absolute(&self.path).map_err(fail)?;
        Ok(LastLine { file, seal: self.seal.clone(), path, temporary })
    }

    /// Writes the journal anew where its file was removed; its folder must be there. Whether it
    /// was.
    pub fn restore(&mut self) -> Result<bool, JournalError> {
        if self.path.exists() {
            return Ok(false);
        }
        // a file that was removed can be read as long as it is open
        let bytes = self.bytes()?;
        let folder = self.path.parent().unwrap_or(Path::new("")).to_owned();
        let mut again = Self::open(&folder, true)?;
        let written =
            undisturbed(|| again.file.write_all(&bytes).and_then(|()| again.file.sync_data()));
        written.map_err(|source| self.failed(source))?;
        std::mem::swap(&mut self.file, &mut again.file);
        Ok(true)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Journal {
    /// The lock belongs to all descriptors of the file: that of [`LastLine`], and that of a process
    /// which is just being started, are closed later.
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}

/// Writer of the last line of a run that a signal ends. Where the journal's folder was removed since,
/// the journal is written anew first: a file that was removed can be read as long as it is open.
pub struct LastLine {
    file: File,
    seal: Seal,
    path: PathBuf,
    temporary: Option<PathBuf>,
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
    use crate::journal::lines::tests::manifest;

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
