//! A plugin of this process: what it is, where it runs, and the processes of its rows.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use accel_core::query::tracer::Origin;
use accel_core::structure::StructureInfo;

use crate::description::Description;
use crate::library::Library;
use crate::remote::Remote;
use crate::wire::Launch;

/// A plugin of this process.
pub(crate) struct Plugin {
    pub(crate) info: &'static StructureInfo,
    pub(crate) description: Description,
    pub(crate) origin: Origin,
    pub(crate) library: Option<Arc<Library>>,
    pub(crate) launch: Launch,
    /// Processes that wait, by the rows that they are of.
    pub(crate) waiting: Mutex<BTreeMap<String, Remote>>,
}

impl Plugin {
    fn waiting(&self) -> MutexGuard<'_, BTreeMap<String, Remote>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The process of a row: the one that waits for it, or a new one.
    pub(crate) fn process(&self, row: &str) -> Result<Remote, String> {
        let found = self.waiting().remove(row);
        match found {
            Some(remote) => match remote.failure().map(str::to_owned) {
                Some(_) if self.launch.restarts => Remote::start(&self.launch),
                Some(how) => {
                    // in a run a row that ended its process is not tried again
                    self.keep(row, remote);
                    Err(how)
                }
                None => Ok(remote),
            },
            None => Remote::start(&self.launch),
        }
    }

    /// Keeps a process for the next time that its row is built.
    pub(crate) fn keep(&self, row: &str, remote: Remote) {
        self.waiting().insert(row.to_owned(), remote);
    }
}
