//! Trial builds: each row once in a separate process, before the scene is measured.
//!
//! Only a process can be ended when it takes too much, and only one that has done nothing else has
//! a peak of memory that says something: an allocator keeps what earlier builds gave back, and
//! hands it out again unseen. The peak is the largest resident set during the build (`VmHWM`, begun
//! anew through `/proc/self/clear_refs`, proc(5)) less the resident set before it; what loading
//! gave back is counted as there before, and the kernel counts in steps of up to a few hundred KiB.
//! Elsewhere than on Linux there is no peak and only the time is limited.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::scenes::ViewOptions;
use crate::settings::Precision;
use crate::system::machine;
use presentation::numbers;

/// Interval at which the memory of a trial is checked.
const POLL: Duration = Duration::from_millis(10);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildLimits {
    pub seconds: f64,
    /// Bytes of the process that loads the scene and builds.
    pub bytes: u64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct TrialBuild {
    pub scene: String,
    /// View and lights that replace those of the scene: occluders are built for lights.
    pub view: ViewOptions,
    pub row: String,
    pub threads: usize,
    pub precision: Precision,
    pub limits: BuildLimits,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TrialOutcome {
    /// It ended within the limits. Whether the structure was built or refused shows when it is
    /// measured.
    Ended {
        /// Peak bytes of the build, if it was built and the system reports them.
        peak_bytes: Option<u64>,
    },
    /// It took too much, now or at a smaller size.
    OverLimit(String),
    /// Its process ended otherwise.
    Died(String),
}

impl TrialBuild {
    /// Builds in a separate process.
    pub fn run(&self) -> TrialOutcome {
        let mut child = match self.started() {
            Ok(child) => child,
            Err(e) => return TrialOutcome::Died(format!("cannot start a process: {e}")),
        };
        let (events, reader) = listen(&mut child);
        let outcome = self.watch(&mut child, &events);
        // one that is over is not hurt by this
        let _ = child.kill();
        let ended = child.wait();
        let said = reader.and_then(|reader| reader.join().ok()).unwrap_or_default();
        outcome.unwrap_or_else(|| {
            let (how, said) =
                (ended.map_or_else(|e| e.to_string(), |s| s.to_string()), said.trim());
            TrialOutcome::Died(format!("the process that built it ended with {how}: {said}"))
        })
    }

    fn started(&self) -> std::io::Result<Child> {
        Command::new(std::env::current_exe()?)
            .args(["child", "build", "--scene", &self.scene, "--row", &self.row])
            .args(["--threads", &self.threads.to_string()])
            .args(["--precision", self.precision.name()])
            .args(self.view.arguments())
            // it stays open as long as we live: it ends when this ends
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
    }

    /// Waits for the report of the process, or its excess of memory; `None` if the process died.
    fn watch(&self, child: &mut Child, events: &Receiver<Event>) -> Option<TrialOutcome> {
        let BuildLimits { seconds, bytes } = self.limits;
        let too_long = || TrialOutcome::OverLimit(format!("building took more than {seconds} s"));
        let too_much = |what: &str| {
            let limit = numbers::mebibytes(bytes);
            TrialOutcome::OverLimit(format!("{what} took more than {limit} MiB of memory"))
        };
        let process = child.id().to_string();
        let mut begun: Option<Instant> = None;
        loop {
            match events.recv_timeout(POLL) {
                Ok(Event::Loaded) => begun = Some(Instant::now()),
                Ok(Event::Refused) => return Some(TrialOutcome::Ended { peak_bytes: None }),
                Ok(Event::Built { peak_bytes, process_bytes, build_s }) => {
                    return Some(if build_s > seconds {
                        too_long()
                    } else if process_bytes.is_some_and(|n| n > bytes) {
                        too_much("building")
                    } else {
                        TrialOutcome::Ended { peak_bytes }
                    });
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
            if begun.is_some_and(|begun| begun.elapsed().as_secs_f64() > seconds) {
                return Some(too_long());
            }
            if machine::resident(&process).is_some_and(|n| n > bytes) {
                let what = begun.map_or("loading the scene", |_| "building");
                return Some(too_much(what));
            }
        }
    }
}

/// A line of what the process prints.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Event {
    /// The scene is loaded, its primitives are made.
    Loaded,
    Built {
        peak_bytes: Option<u64>,
        /// The largest resident set during the build.
        process_bytes: Option<u64>,
        build_s: f64,
    },
    Refused,
}

/// Threads that read what the process prints: its events, and the last of its complaints.
fn listen(child: &mut Child) -> (Receiver<Event>, Option<std::thread::JoinHandle<String>>) {
    let (sender, events) = channel();
    if let Some(stdout) = child.stdout.take() {
        std::thread::spawn(move || {
            let lines = BufReader::new(stdout).lines().map_while(Result::ok);
            for event in lines.filter_map(|line| serde_json::from_str(&line).ok()) {
                if sender.send(event).is_err() {
                    return;
                }
            }
        });
    }
    let complaints = child.stderr.take().map(|mut stderr| {
        std::thread::spawn(move || {
            let mut said = String::new();
            let _ = stderr.read_to_string(&mut said);
            said
        })
    });
    (events, complaints)
}
