//! Trial builds: each row once in a process of its own, before the scene is measured.
//!
//! Only a process can be ended when it takes too much, and only one that has done nothing else has
//! a peak of memory that says something: an allocator keeps what earlier builds gave back, and hands
//! it out again unseen. The peak is the largest resident set during the build (`VmHWM`, begun anew
//! through `/proc/self/clear_refs`, proc(5)) less the resident set before it; what loading gave back
//! is counted as there before, and the kernel counts in steps of up to a few hundred KiB. Elsewhere
//! than on Linux there is no peak and only the time is limited.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use accel_core::occluders::OccluderScalar;
use accel_core::structures::Buildable;
use renderer::Geometry;
use serde::{Deserialize, Serialize};

use crate::args::{Precision, TrialArgs};
use crate::context::Context;
use crate::error::Error;
use crate::export::numbers;
use crate::machine;
use crate::measured_row::{self, MeasuredRow};
use crate::plan::{Plan, PlanError};
use crate::pools;
use crate::scene_run::light_positions;
use crate::scene_source::LoadedScene;

/// How often the memory of a trial is looked at.
const POLL: Duration = Duration::from_millis(10);

/// What a build may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildLimits {
    /// Seconds, without loading.
    pub seconds: f64,
    /// Bytes of the process that loads the scene and builds.
    pub bytes: u64,
}

/// What is to be built.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialBuild {
    /// Scene.
    pub scene: String,
    /// Label of the row.
    pub row: String,
    /// Threads that build.
    pub threads: usize,
    /// Arithmetic.
    pub precision: Precision,
    /// What it may take.
    pub limits: BuildLimits,
}

/// What came of a trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// It ended within the limits. Whether the structure was built or refused shows when it is
    /// measured.
    Ended {
        /// Bytes that the build took at its peak, where it was built and the system tells.
        peak_bytes: Option<u64>,
    },
    /// It took too much, now or at a smaller size.
    OverLimit(String),
    /// Its process ended otherwise.
    Died(String),
}

impl TrialBuild {
    /// The trial of a row of a plan on a scene; none where the plan has no limits.
    pub fn of(plan: &Plan<'_>, scene: &str, row: &MeasuredRow<'_>) -> Option<Self> {
        Some(Self {
            scene: scene.to_owned(),
            row: row.label(),
            threads: plan.threads,
            precision: plan.precision,
            limits: plan.build_limits?,
        })
    }

    /// Builds in a process of its own.
    pub fn run(&self) -> Outcome {
        self.started().map_or_else(
            |e| Outcome::Died(format!("cannot start a process: {e}")),
            |mut child| {
                let (events, reader) = listen(&mut child);
                let outcome = self.watch(&mut child, &events);
                // one that is over is not hurt by this
                let _ = child.kill();
                let ended = child.wait();
                let said = reader.and_then(|reader| reader.join().ok()).unwrap_or_default();
                outcome.unwrap_or_else(|| {
                    let how = ended.map_or_else(|e| e.to_string(), |status| status.to_string());
                    Outcome::Died(format!(
                        "the process that built it ended with {how}: {}",
                        said.trim()
                    ))
                })
            },
        )
    }

    fn started(&self) -> std::io::Result<Child> {
        let precision = match self.precision {
            Precision::F32 => "f32",
            Precision::F64 => "f64",
        };
        Command::new(std::env::current_exe()?)
            .args(["child", "build", "--scene", &self.scene, "--row", &self.row])
            .args(["--threads", &self.threads.to_string(), "--precision", precision])
            // it stays open as long as we live: see `end_with_parent`
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
    }

    /// What the process says of itself, or that it took too much; none where it ended unasked.
    fn watch(&self, child: &mut Child, events: &Receiver<Event>) -> Option<Outcome> {
        let BuildLimits { seconds, bytes } = self.limits;
        let too_long = || Outcome::OverLimit(format!("building took more than {seconds} s"));
        let too_much = |what: &str| {
            let limit = numbers::mebibytes(bytes);
            Outcome::OverLimit(format!("{what} took more than {limit} MiB of memory"))
        };
        let process = child.id().to_string();
        let mut begun: Option<Instant> = None;
        loop {
            match events.recv_timeout(POLL) {
                Ok(Event::Loaded) => begun = Some(Instant::now()),
                Ok(Event::Refused) => return Some(Outcome::Ended { peak_bytes: None }),
                Ok(Event::Built { peak_bytes, process_bytes, build_s }) => {
                    return Some(match () {
                        () if build_s > seconds => too_long(),
                        () if process_bytes.is_some_and(|n| n > bytes) => too_much("building"),
                        () => Outcome::Ended { peak_bytes },
                    });
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
            if begun.is_some_and(|begun| begun.elapsed().as_secs_f64() > seconds) {
                return Some(too_long());
            }
            if machine::resident(&process).is_some_and(|n| n > bytes) {
                return Some(too_much(if begun.is_some() {
                    "building"
                } else {
                    "loading the scene"
                }));
            }
        }
    }
}

/// A line of what the process prints.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Event {
    /// The scene is loaded, its primitives are made.
    Loaded,
    /// The structure is built.
    Built {
        /// What the build took at its peak.
        peak_bytes: Option<u64>,
        /// The largest resident set during the build.
        process_bytes: Option<u64>,
        /// Seconds.
        build_s: f64,
    },
    /// The structure refused the scene.
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

/// The process of a trial: loads, builds, says so.
///
/// # Errors
/// [`Error`] for a scene that cannot be loaded or a row that there is not.
pub fn build_here(context: &mut Context<'_>, args: &TrialArgs) -> Result<(), Error> {
    end_with_parent();
    let names = [args.row.clone()];
    let (structures, occluding) =
        measured_row::select(context.registry, context.occluders, &names, &[])?;
    let rows = structures.into_iter().map(MeasuredRow::from);
    let mut rows = rows.chain(occluding.into_iter().map(MeasuredRow::Occluder));
    let row = rows.next().ok_or(PlanError::NoRows)?;
    let scenes = context.scenes.resolve(std::slice::from_ref(&args.scene))?;
    for scene in scenes {
        let loaded = scene.load()?;
        let event = match args.precision {
            Precision::F32 => built::<f32>(context, &loaded, &row, args.threads)?,
            Precision::F64 => built::<f64>(context, &loaded, &row, args.threads)?,
        };
        say(context, &event)?;
    }
    Ok(())
}

fn built<S: Buildable + OccluderScalar>(
    context: &mut Context<'_>,
    loaded: &LoadedScene,
    row: &MeasuredRow<'_>,
    threads: u16,
) -> Result<Event, Error> {
    let geometry = Geometry::<S>::of(&loaded.scene)?;
    let lights = light_positions(&loaded.scene);
    let pool = pools::pool(usize::from(threads))?;
    say(context, &Event::Loaded)?;
    let before = machine::resident("self");
    let is_new = machine::reset_peak_rss();
    let start = context.clock.now();
    let built = pool.install(|| row.build(geometry.prims(), &lights));
    let build_s = context.clock.seconds_since(start);
    let process_bytes = machine::peak_rss().filter(|_| is_new);
    let peak_bytes = process_bytes.zip(before).map(|(peak, before)| peak.saturating_sub(before));
    Ok(match built {
        Ok(_) => Event::Built { peak_bytes, process_bytes, build_s },
        Err(_) => Event::Refused,
    })
}

fn say(context: &mut Context<'_>, event: &Event) -> Result<(), Error> {
    let format = |e: serde_json::Error| Error::Format { format: "JSON", message: e.to_string() };
    writeln!(context.out, "{}", serde_json::to_string(event).map_err(format)?)?;
    Ok(context.out.flush()?)
}

/// Ends this process when its standard input ends: whoever wanted the answer is gone, interrupted
/// or killed, and a build can go on for long.
fn end_with_parent() {
    std::thread::spawn(|| {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        std::process::exit(i32::from(crate::error::FAILURE));
    });
}
