//! Memory that two processes share: a file that both map, in memory where the system has such a
//! place.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use memmap2::{Mmap, MmapMut};
use tempfile::NamedTempFile;

/// Smallest part, bytes.
const LEAST: usize = 1 << 16;

/// Folder in memory on Linux.
const IN_MEMORY: &str = "/dev/shm";

/// Best folder for temporary files.
pub(crate) fn folder() -> PathBuf {
    let in_memory = Path::new(IN_MEMORY);
    if in_memory.is_dir() { in_memory.into() } else { std::env::temp_dir() }
}

/// A part of the memory.
pub(crate) struct SharedSegment {
    map: Map,
}

enum Map {
    Writable(MmapMut),
    /// A write here ends the process.
    ReadOnly(Mmap),
}

impl SharedSegment {
    /// At least so many bytes, with the file that somebody else is to map before it is dropped.
    pub(crate) fn new(bytes: usize) -> io::Result<(Self, NamedTempFile)> {
        let bytes = bytes.max(LEAST).checked_next_power_of_two().unwrap_or(bytes);
        let file = tempfile::Builder::new().prefix("rtbench-").tempfile_in(folder())?;
        file.as_file().set_len(bytes as u64)?;
        // SAFETY: nobody makes the file shorter: it has no name once both have mapped it
        let map = unsafe { MmapMut::map_mut(file.as_file())? };
        Ok((Self { map: Map::Writable(map) }, file))
    }

    /// Maps a segment of another process, writable if `writes`.
    pub(crate) fn of(file: &Path, writes: bool) -> io::Result<Self> {
        let map = if writes {
            let file = File::options().read(true).write(true).open(file)?;
            // SAFETY: as above
            Map::Writable(unsafe { MmapMut::map_mut(&file)? })
        } else {
            // SAFETY: as above
            Map::ReadOnly(unsafe { Mmap::map(&File::open(file)?)? })
        };
        Ok(Self { map })
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        match &self.map {
            Map::Writable(map) => map,
            Map::ReadOnly(map) => map,
        }
    }

    /// All of it; nothing where it must not be written.
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        match &mut self.map {
            Map::Writable(map) => map,
            Map::ReadOnly(_) => &mut [],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_segments_show_writes_and_refuse_them_if_read_only() {
        let (mut own, file) = SharedSegment::new(100).unwrap();
        assert_eq!(own.bytes().len(), LEAST);
        own.bytes_mut()[7] = 42;
        let mut others = SharedSegment::of(file.path(), true).unwrap();
        let mut read_only = SharedSegment::of(file.path(), false).unwrap();
        assert_eq!((others.bytes()[7], read_only.bytes()[7]), (42, 42));
        assert!(read_only.bytes_mut().is_empty());
        others.bytes_mut()[7] = 2;
        drop(file);
        assert_eq!(own.bytes()[7], 2);
    }
}
