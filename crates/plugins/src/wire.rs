//! Protocol between parent and child: requests and replies alternate, one line of JSON each.
//! Triangles, rays and answers are in shared memory.

use std::io::{self, BufRead, Write};
use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::description::Description;
use crate::instance::{Query, Stats};
use crate::stopwatch::CallTime;

/// Content of a segment of shared memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum SegmentContent {
    /// Nine numbers for each triangle, then a byte for each: not 0 where shadow rays pass.
    Scene,
    Rays,
    /// [`crate::abi::Hit`]s, or a byte for each ray. The child writes them.
    Answers,
}

/// Request of the parent.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Request {
    /// Asks for the description of the plugin.
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
        threads: usize,
    },
    /// To answer so many rays.
    Trace {
        query: Query,
        rays: usize,
    },
    /// To count from here on, or not.
    Count {
        on: bool,
    },
    Stats,
    Nothing,
    /// To destroy what was built.
    Destroy,
}

/// Reply of the child.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Reply {
    /// It is done, and what the call of the plugin took.
    Done(CallTime),
    /// Asks for the description of the plugin.
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
