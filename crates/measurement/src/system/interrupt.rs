//! Ctrl-C, and the polite forms of being killed: the run is marked, and the program ends.
//!
//! A build can take minutes, so nothing waits for the work: a thread of its own writes the mark
//! and ends the process, as soon as no file is being written, and at the latest after [`GRACE`].

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long a file that is being written may keep the program from ending.
pub const GRACE: Duration = Duration::from_millis(500);

/// Held while a file is written.
static WRITING: Mutex<()> = Mutex::new(());

/// Set by the program itself: a library that takes over signals would surprise.
static IS_ARMED: AtomicBool = AtomicBool::new(false);

/// Lets [`watch`] take over the signals of this process.
pub fn arm() {
    IS_ARMED.store(true, SeqCst);
}

/// Writes files; a signal waits until it is done.
pub fn undisturbed<T>(write: impl FnOnce() -> T) -> T {
    let _held = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}

/// A line that says which signal ended the program.
pub type Mark = fn(i32) -> Option<String>;

/// What is said and marked when a signal comes.
#[derive(Debug)]
pub struct Unfinished {
    /// The journal, how it is marked, and its folder.
    pub journal: Option<(File, Mark, PathBuf)>,
    /// All scenes.
    pub scenes: usize,
    /// How many of them are finished.
    pub finished: Arc<AtomicUsize>,
}

impl Unfinished {
    /// In words.
    fn say(&self) -> String {
        let counts =
            format!("{} of {} scenes are finished", self.finished.load(SeqCst), self.scenes);
        match &self.journal {
            Some((_, _, folder)) => {
                let folder = folder.display();
                format!("interrupted: {counts} and kept; go on with: rtbench run --resume {folder}")
            }
            None => format!("interrupted: {counts}; with -o DIR they would be kept"),
        }
    }
}

/// From here on SIGINT, SIGTERM and SIGHUP mark the run and end the process with the code
/// 128 + signal.
///
/// # Errors
/// The system's, when signals cannot be had.
#[cfg(unix)]
pub fn watch(unfinished: Unfinished) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    if !IS_ARMED.swap(false, SeqCst) {
        return Ok(());
    }
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            end(unfinished, signal);
        }
    })?;
    Ok(())
}

/// Elsewhere than on Unix the system's own way of ending a process stays; the journal marks a run
/// as unfinished until it is over.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn watch(_: Unfinished) -> std::io::Result<()> {
    Ok(())
}

/// For work that can stop between two of its steps: the number of the first SIGINT, SIGTERM or
/// SIGHUP that comes from here on, and 0 until then. A second one ends the process at once, with the
/// code 128 + signal.
///
/// # Errors
/// The system's, when signals cannot be had.
#[cfg(unix)]
pub fn flag() -> std::io::Result<Arc<AtomicUsize>> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::flag::{register_conditional_shutdown, register_usize};

    let signalled = Arc::new(AtomicUsize::new(0));
    if IS_ARMED.swap(false, SeqCst) {
        let is_second = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // in this order: the first finds the flag down
            register_conditional_shutdown(signal, 128 + signal, Arc::clone(&is_second))?;
            signal_hook::flag::register(signal, Arc::clone(&is_second))?;
            register_usize(signal, Arc::clone(&signalled), signal as usize)?;
        }
    }
    Ok(signalled)
}

/// Elsewhere no signal is told.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn flag() -> std::io::Result<Arc<AtomicUsize>> {
    Ok(Arc::default())
}

#[cfg(unix)]
fn end(unfinished: Unfinished, signal: i32) -> ! {
    let begin = std::time::Instant::now();
    let held = loop {
        match WRITING.try_lock() {
            Ok(held) => break Some(held),
            Err(std::sync::TryLockError::Poisoned(held)) => break Some(held.into_inner()),
            Err(_) if begin.elapsed() >= GRACE => break None,
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let text = unfinished.say();
    if let (Some(_), Some((mut journal, mark, _))) = (&held, unfinished.journal)
        && let Some(line) = mark(signal)
    {
        let _ = journal.write_all((line + "\n").as_bytes());
    }
    // The bar may stand there.
    let _ = writeln!(std::io::stderr(), "\n{text}");
    std::process::exit(128 + signal)
}
