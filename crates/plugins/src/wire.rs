//! What a process of a plugin is started with and asked for, and the protocol between parent and
//! child: requests and replies alternate, one line of JSON each. Triangles, rays and answers are in
//! shared memory.

use std::io::{self, BufRead, Write};
use std::path::PathBuf;
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::description::Description;
use crate::instance::{Query, Stats};
use crate::shared::SharedSegment;
use crate::stopwatch::CallTime;

/// The way from parent to child.
#[cfg(unix)]
pub(crate) type Stream = std::os::unix::net::UnixStream;
/// Elsewhere no process of a plugin is started.
#[cfg(not(unix))]
pub(crate) type Stream = std::net::TcpStream;

/// Settings for running plugins.
#[derive(Debug, Clone)]
pub struct Options {
    /// This program, for processes of their own.
    pub program: PathBuf,
    /// Longest time of a build, and of a call that answers rays, in a separate process.
    pub limit: Duration,
    /// In this process: no limit, and what ends the plugin ends the run.
    pub in_process: bool,
    /// A row whose process ended is asked again in a new one.
    pub restarts: bool,
}

/// Settings for starting processes of a plugin.
#[derive(Debug, Clone)]
pub(crate) struct Launch {
    pub(crate) file: PathBuf,
    pub(crate) options: Options,
}

pub(crate) enum BuildReply {
    /// It took so many seconds.
    Built(f64),
    Refused(String),
    /// It took so many bytes at least, more than it may; its process was ended.
    TooLarge(u64),
}

/// The segments of shared memory, by their [`SegmentContent`].
pub(crate) type SharedParts = [Option<SharedSegment>; 3];

/// Content of a segment of shared memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum SegmentContent {
    /// Nine numbers for each triangle, then a byte for each: not 0 where shadow rays pass.
    Scene,
    Rays,
    /// [`crate::abi::Hit`]s, or a byte for each ray. The child writes them.
    Answers,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Request {
    Describe,
    /// To map a file, in place of the one before.
    Map {
        part: SegmentContent,
        file: PathBuf,
    },
    /// To build over so many triangles.
    Build {
        triangles: usize,
        is_double: bool,
        values: Vec<String>,
        /// Threads that build and trace.
        threads: usize,
    },
    /// To answer so many rays.
    Trace {
        query: Query,
        rays: usize,
    },
    Count {
        on: bool,
    },
    Stats,
    Nothing,
    Destroy,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Reply {
    /// It is done, and what the call of the plugin took.
    Done(CallTime),
    Description(Box<Description>),
    Stats(Stats),
    /// It is not done.
    Refused {
        message: String,
    },
}

pub(crate) fn send<T: Serialize>(to: &mut impl Write, message: &T) -> io::Result<()> {
    let mut line = serde_json::to_vec(message)?;
    line.push(b'\n');
    to.write_all(&line)?;
    to.flush()
}

/// Reads a line; none at the end.
///
/// # Errors
/// Those of the reader, and `InvalidData` for what is no message.
pub(crate) fn receive<T: DeserializeOwned>(from: &mut impl BufRead) -> io::Result<Option<T>> {
    let mut line = Vec::new();
    from.read_until(b'\n', &mut line)?;
    if line.is_empty() { Ok(None) } else { Ok(Some(serde_json::from_slice(&line)?)) }
}
