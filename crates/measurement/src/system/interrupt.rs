//! Ctrl-C, and the polite forms of being killed: the run is marked, and the program ends.
//!
//! A build can take minutes, so nothing waits for the work: a thread of its own writes the mark
//! and ends the process, as soon as no file is being written, and at the latest after [`GRACE`].
//! Work that can stop between two of its steps has a [`flag`] instead, and ends by itself.

use std::io;
#[cfg(unix)]
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
#[cfg(any(unix, test))]
use std::time::Instant;

use presentation::outside::line;

/// What a program that is asked to end is left, whatever comes: so long may a file that is being
/// written keep it from ending, and so long are further signals the same request. `timeout` sends
/// its signal to the process and then to the group that the process is in, and a terminal's Ctrl-C
/// may come through a wrapper once more.
pub const GRACE: Duration = Duration::from_millis(500);

/// Held while a file is written.
static WRITING: Mutex<()> = Mutex::new(());

/// True if the scene being measured has whole rounds that a signal must not lose.
static HAS_ROUNDS: AtomicBool = AtomicBool::new(false);
/// True if a signal waits until they are kept.
static IS_STOPPING: AtomicBool = AtomicBool::new(false);
/// True if their scene is written.
static IS_SCENE_KEPT: AtomicBool = AtomicBool::new(false);

/// How long the row that a signal interrupts may still take; after that the rounds are lost.
#[cfg(unix)]
const LAST_ROW: Duration = Duration::from_secs(5);
/// How long the scene may take to be written after a signal. Slurm kills 30 seconds after it.
#[cfg(unix)]
const LAST_SCENE: Duration = Duration::from_secs(20);

/// From here to [`rounds_ended`] a signal ends the rounds of the scene, and the program when the
/// scene is written.
pub fn let_rounds_end() {
    HAS_ROUNDS.store(true, SeqCst);
}

pub fn rounds_ended() {
    HAS_ROUNDS.store(false, SeqCst);
}

/// Returns whether a signal waits for the scene being measured.
pub fn is_stopping() -> bool {
    IS_STOPPING.load(SeqCst)
}

/// Ends the program if a signal waits for the scene that was just written.
pub fn end_if_stopping() {
    if is_stopping() {
        IS_SCENE_KEPT.store(true, SeqCst);
        loop {
            std::thread::park();
        }
    }
}

/// Waits until the scene is written, at most as long as [`LAST_ROW`] and [`LAST_SCENE`] allow, or
/// until the signal comes again.
#[cfg(unix)]
fn wait_for_scene(signals: &mut signal_hook::iterator::Signals) {
    let begin = Instant::now();
    let mut first = Some(begin);
    while !IS_SCENE_KEPT.load(SeqCst) {
        let limit = if HAS_ROUNDS.load(SeqCst) { LAST_ROW } else { LAST_SCENE };
        let is_again =
            signals.pending().any(|_| request(&mut first, Instant::now()) == Request::Again);
        if begin.elapsed() >= limit || is_again {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

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

/// Marks a journal with the signal that ends the program; another folder, where the journal is not
/// in its own any more.
pub type Mark = Box<dyn FnOnce(i32) -> io::Result<Option<PathBuf>> + Send>;

/// Output and journal mark of an interrupted run.
pub struct InterruptedOutput {
    pub journal: Option<(Mark, PathBuf)>,
    pub scenes: usize,
    pub finished: Arc<AtomicUsize>,
}

impl InterruptedOutput {
    /// Marks the journal, if files may be written, and says so.
    fn end(self, signal: i32, may_write: bool) -> String {
        let counts =
            format!("{} of {} scenes are finished", self.finished.load(SeqCst), self.scenes);
        let Some((mark, folder)) = self.journal else {
            return format!("interrupted: {counts}; use -o DIR to keep them");
        };
        let folder = match if may_write { mark(signal) } else { Ok(None) } {
            Ok(another) => another.unwrap_or(folder),
            Err(why) => return format!("interrupted: {counts}, and the journal is lost: {why}"),
        };
        let folder = folder.display().to_string();
        let folder = line(&folder);
        format!("interrupted: {counts}, kept; resume with: rtbench run --resume {folder}")
    }
}

/// From here on SIGINT, SIGTERM and SIGHUP mark the run and end the process with the code
/// 128 + signal.
#[cfg(unix)]
pub fn watch(unfinished: InterruptedOutput) -> std::io::Result<()> {
    take_over(move |mut signals| {
        if let Some(signal) = signals.forever().next() {
            if HAS_ROUNDS.load(SeqCst) {
                IS_STOPPING.store(true, SeqCst);
                wait_for_scene(&mut signals);
            }
            end(unfinished, signal);
        }
    })
}

/// Gives the signals of this process to a thread of their own; nothing unless [`arm`] was called.
#[cfg(unix)]
fn take_over(
    listen: impl FnOnce(signal_hook::iterator::Signals) + Send + 'static,
) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    if IS_ARMED.swap(false, SeqCst) {
        let signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])?;
        std::thread::Builder::new().name("signals".into()).spawn(|| listen(signals))?;
    }
    Ok(())
}

/// Elsewhere than on Unix the system's own way of ending a process stays; the journal marks a run
/// as unfinished until it is over.
#[cfg(not(unix))]
pub fn watch(_: InterruptedOutput) -> std::io::Result<()> {
    Ok(())
}

/// For work that can stop between two of its steps: the number of the first SIGINT, SIGTERM or
/// SIGHUP that comes from here on, and 0 until then. One that comes later than [`GRACE`] after the
/// first ends the process at once, with the code 128 + signal.
#[cfg(unix)]
pub fn flag() -> std::io::Result<Arc<AtomicUsize>> {
    let signalled = Arc::new(AtomicUsize::new(0));
    let told = Arc::clone(&signalled);
    take_over(move |mut signals| {
        let mut first = None;
        for signal in signals.forever() {
            match request(&mut first, Instant::now()) {
                Request::First => told.store(signal as usize, SeqCst),
                Request::Same => {}
                Request::Again => signal_hook::low_level::exit(128 + signal),
            }
        }
    })?;
    Ok(signalled)
}

#[cfg(any(unix, test))]
#[derive(Debug, PartialEq, Eq)]
enum Request {
    /// To end when the step is done.
    First,
    /// That again, by whatever sent the first.
    Same,
    /// To end at once.
    Again,
}

/// Interprets a signal that arrives now; `first` is when the first one did.
#[cfg(any(unix, test))]
fn request(first: &mut Option<Instant>, now: Instant) -> Request {
    match *first {
        None => {
            *first = Some(now);
            Request::First
        }
        Some(first) if now.saturating_duration_since(first) < GRACE => Request::Same,
        Some(_) => Request::Again,
    }
}

/// Elsewhere no signal is told.
#[cfg(not(unix))]
pub fn flag() -> std::io::Result<Arc<AtomicUsize>> {
    Ok(Arc::default())
}

#[cfg(unix)]
fn end(unfinished: InterruptedOutput, signal: i32) -> ! {
    let begin = Instant::now();
    let held = loop {
        match WRITING.try_lock() {
            Ok(held) => break Some(held),
            Err(std::sync::TryLockError::Poisoned(held)) => break Some(held.into_inner()),
            Err(_) if begin.elapsed() >= GRACE => break None,
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let text = unfinished.end(signal, held.is_some());
    // The bar may stand there.
    let _ = writeln!(std::io::stderr(), "\n{text}");
    std::process::exit(128 + signal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_that_comes_twice_at_once_is_one_request() {
        let begin = Instant::now();
        let mut first = None;
        let mut after = |ms| request(&mut first, begin + Duration::from_millis(ms));
        assert_eq!(after(0), Request::First);
        assert_eq!([0, 1, 499].map(&mut after), [Request::Same, Request::Same, Request::Same]);
        // counted from the first, not from the one before
        assert_eq!(after(500), Request::Again);
    }
}
