//! A plugin in a separate process, as its parent sees it.
//!
//! The process is started once for each row and kept between rounds, so that its allocator is as
//! warm as ours. A reply that does not come in time, or none at all, ends it: what is asked later
//! is refused.

use std::io::{self, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use accel_core::primitives::{Primitives, TriangleSet};
use accel_core::{Hit, Ray};
use bytemuck::Pod;

use crate::abi;
use crate::description::Description;
use crate::instance::{PluginScalar, Query, Stats};
use crate::memory_watch;
use crate::shared::{SharedSegment, folder};
use crate::stopwatch::CallTime;
use crate::wire::{
    BuildReply, Launch, Reply, Request, SegmentContent, SharedParts, Stream, receive, send,
};

/// Time limit for the start of a process.
const START: Duration = Duration::from_secs(20);
/// Interval of checks whether it has started.
const POLL: Duration = Duration::from_millis(1);
/// Time limit for a process to end after its connection was closed.
const LAST_WORDS: Duration = Duration::from_millis(50);
/// Bytes of a triangle in the process's own copy beside its corners: flags and spare capacity.
const COPY_EXTRA: usize = 12;
/// Bytes of a plugin's output that are kept.
const TAIL: usize = 500;

const UNEXPECTED: &str = "its process sent an unexpected reply";

/// Has the C library ask for huge pages for a plugin's memory, as rtbench's own heap does for that
/// of all other rows; what the user says goes first.
const HEAP_TUNABLES: (&str, &str) = ("GLIBC_TUNABLES", "glibc.malloc.hugetlb=1");

/// A running process with a plugin.
pub(crate) struct Remote {
    process: Child,
    stream: BufReader<Stream>,
    limit: Duration,
    parts: SharedParts,
    said: Arc<Mutex<Vec<u8>>>,
    /// Somebody may hang up on it.
    is_watched: bool,
    failure: Option<String>,
}

impl Remote {
    #[cfg(not(unix))]
    pub(crate) fn start(_: &Launch) -> Result<Self, String> {
        Err("plugins run in separate processes on Unix only".into())
    }

    /// Starts a process; the words of the error say why there is none.
    #[cfg(unix)]
    pub(crate) fn start(launch: &Launch) -> Result<Self, String> {
        let cannot = |e: io::Error| format!("its process cannot be started: {e}");
        let place =
            tempfile::Builder::new().prefix("rtbench-").tempdir_in(folder()).map_err(cannot)?;
        let socket = place.path().join("socket");
        let listener = std::os::unix::net::UnixListener::bind(&socket).map_err(cannot)?;
        listener.set_nonblocking(true).map_err(cannot)?;
        let mut process = Command::new(&launch.options.program);
        if std::env::var_os(HEAP_TUNABLES.0).is_none() {
            process.env(HEAP_TUNABLES.0, HEAP_TUNABLES.1);
        }
        let mut process = process
            .args(["--quiet", "child", "plugin"])
            .arg("--file")
            .arg(&launch.file)
            .arg("--socket")
            .arg(&socket)
            // it stays open as long as we live: it ends when this ends
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(cannot)?;
        let said = Arc::new(Mutex::new(Vec::new()));
        if let Some(out) = process.stdout.take() {
            keep_tail(out, Arc::clone(&said));
        }
        if let Some(err) = process.stderr.take() {
            keep_tail(err, Arc::clone(&said));
        }
        let begun = Instant::now();
        let stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(e) if e.kind() != io::ErrorKind::WouldBlock => return Err(cannot(e)),
                Err(_) => {}
            }
            let ended = process.try_wait().map_err(cannot)?;
            if ended.is_some() || begun.elapsed() > START {
                let _ = process.kill();
                let how = process.wait().map_err(cannot)?;
                return Err(format!("its process did not start ({how}){}", tail(&said)));
            }
            std::thread::sleep(POLL);
        };
        stream.set_nonblocking(false).map_err(cannot)?;
        let limit = launch.options.limit;
        stream.set_read_timeout(Some(limit)).map_err(cannot)?;
        stream.set_write_timeout(Some(limit)).map_err(cannot)?;
        let (stream, parts) = (BufReader::new(stream), SharedParts::default());
        Ok(Self { process, stream, limit, parts, said, is_watched: false, failure: None })
    }

    /// Its exit status, if it has ended.
    pub(crate) fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    pub(crate) fn describe(&mut self) -> Result<Description, String> {
        match self.ask(&Request::Describe, "describing itself")? {
            Reply::Description(description) => Ok(*description),
            Reply::Refused { message } => Err(message),
            _ => Err(self.ends(UNEXPECTED.into())),
        }
    }

    /// Builds with a value for each setting, in their order, for as many threads as the current
    /// pool has.
    pub(crate) fn build<S: PluginScalar>(
        &mut self,
        set: &TriangleSet<S>,
        values: &[String],
        most_bytes: Option<u64>,
    ) -> Result<BuildReply, String> {
        let (triangles, values, threads) =
            (set.len(), values.to_vec(), rayon::current_num_threads());
        let corners = size_of::<[[S; 3]; 3]>();
        let scene = self.part(SegmentContent::Scene, (corners + 1) * triangles)?;
        let (positions, flags) = scene.split_at_mut(corners * triangles);
        positions.copy_from_slice(bytemuck::cast_slice(set.triangles()));
        for (flag, id) in flags.iter_mut().take(triangles).zip(0..) {
            *flag = u8::from(!set.is_opaque(id));
        }
        let doing = format!("building over {triangles} triangles");
        // beside the structure it has its own copy of the triangles
        let copy = ((corners + COPY_EXTRA) * triangles) as u64;
        let excess = most_bytes.and_then(|most| {
            let stream = self.stream.get_ref().try_clone().ok()?;
            memory_watch::watch(self.process.id(), most.saturating_add(copy), stream)
        });
        self.is_watched = excess.is_some();
        let is_double = size_of::<S>() == size_of::<f64>();
        let reply = self.ask(&Request::Build { triangles, is_double, values, threads }, &doing);
        self.is_watched = false;
        if let Some(bytes) = excess.and_then(|excess| excess()) {
            return Ok(BuildReply::TooLarge(bytes.saturating_sub(copy)));
        }
        match reply? {
            Reply::Done(took) => Ok(BuildReply::Built(took.seconds)),
            Reply::Refused { message } => Ok(BuildReply::Refused(message)),
            _ => Err(self.ends(UNEXPECTED.into())),
        }
    }

    /// Closest hits of rays; `hits` holds what counts where none is written. Returns what the call
    /// took.
    pub(crate) fn closest<S: PluginScalar>(
        &mut self,
        rays: &[Ray<S>],
        hits: &mut [Hit<S>],
    ) -> Result<CallTime, String> {
        let before = hits.iter().map(|hit| abi::Hit::new(hit.t, hit.id));
        let (took, answers) = self.trace(Query::Closest, rays, before)?;
        for ((hit, answer), ray) in hits.iter_mut().zip(answers).zip(rays) {
            *hit = answer.as_ours(ray);
        }
        Ok(took)
    }

    /// The same of occlusions.
    pub(crate) fn occluded<S: PluginScalar>(
        &mut self,
        rays: &[Ray<S>],
        blocked: &mut [bool],
    ) -> Result<CallTime, String> {
        let (took, answers) =
            self.trace(Query::Occlusion, rays, blocked.iter().copied().map(u8::from))?;
        blocked.iter_mut().zip(answers).for_each(|(blocked, answer)| *blocked = *answer != 0);
        Ok(took)
    }

    /// Asks for answers; `before` has what counts where none is written.
    fn trace<S: PluginScalar, A: Pod>(
        &mut self,
        query: Query,
        asked: &[Ray<S>],
        before: impl ExactSizeIterator<Item = A>,
    ) -> Result<(CallTime, &[A]), String> {
        let (rays, count) = (asked.len(), before.len());
        let part = self.part_of(SegmentContent::Rays, rays)?;
        part.iter_mut().zip(asked).for_each(|(to, ray)| *to = abi::Ray::<S>::from(ray));
        let answers = self.part_of(SegmentContent::Answers, count)?;
        answers.iter_mut().zip(before).for_each(|(to, answer)| *to = answer);
        let what = match query {
            Query::Closest => "closest hits",
            Query::Occlusion => "occlusion",
        };
        let doing = format!("tracing {rays} rays ({what})");
        let took = self.done(&Request::Trace { query, rays }, &doing)?;
        Ok((took, self.part_of(SegmentContent::Answers, count)?))
    }

    pub(crate) fn count(&mut self, on: bool) -> Result<(), String> {
        self.done(&Request::Count { on }, "turning counting on or off").map(|_| ())
    }

    pub(crate) fn stats(&mut self) -> Result<Stats, String> {
        match self.ask(&Request::Stats, "saying what it built")? {
            Reply::Stats(stats) => Ok(stats),
            _ => Err(self.ends(UNEXPECTED.into())),
        }
    }

    pub(crate) fn destroy(&mut self) -> Result<(), String> {
        self.done(&Request::Destroy, "destroying what it built").map(|_| ())
    }

    /// Median seconds of a call that asks for nothing, there and back.
    pub(crate) fn empty_call(&mut self) -> Result<f64, String> {
        const CALLS: usize = 101;
        let mut seconds = Vec::with_capacity(CALLS);
        for _ in 0..CALLS {
            let start = Instant::now();
            self.done(&Request::Nothing, "doing nothing")?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        Ok(seconds.get(CALLS / 2).copied().unwrap_or_default())
    }

    /// Memory of so many items that the process has mapped, too.
    fn part_of<T: Pod>(&mut self, part: SegmentContent, count: usize) -> Result<&mut [T], String> {
        let bytes = size_of::<T>() * count;
        let part = self.part(part, bytes)?;
        Ok(bytemuck::cast_slice_mut(part.get_mut(..bytes).unwrap_or_default()))
    }

    /// Memory of at least so many bytes that the process has mapped, too.
    fn part(&mut self, part: SegmentContent, bytes: usize) -> Result<&mut [u8], String> {
        let place = part as usize;
        if self.parts[place].as_ref().is_none_or(|part| part.bytes().len() < bytes) {
            let (shared, file) = SharedSegment::new(bytes)
                .map_err(|e| self.ends(format!("cannot share memory with its process: {e}")))?;
            let request = Request::Map { part, file: file.path().to_owned() };
            self.done(&request, "mapping the memory it shares")?;
            self.parts[place] = Some(shared);
        }
        Ok(self.parts[place].as_mut().map(SharedSegment::bytes_mut).unwrap_or_default())
    }

    fn done(&mut self, request: &Request, doing: &str) -> Result<CallTime, String> {
        match self.ask(request, doing)? {
            Reply::Done(took) => Ok(took),
            Reply::Refused { message } => Err(self.ends(format!("fails while {doing}: {message}"))),
            _ => Err(self.ends(UNEXPECTED.into())),
        }
    }

    /// One request and its reply; what goes wrong ends the process.
    fn ask(&mut self, request: &Request, doing: &str) -> Result<Reply, String> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        let sent = send(self.stream.get_mut(), request);
        let reply = sent.and_then(|()| receive::<Reply>(&mut self.stream));
        let late = [io::ErrorKind::WouldBlock, io::ErrorKind::TimedOut];
        match reply {
            Ok(Some(reply)) => Ok(reply),
            Err(e) if late.contains(&e.kind()) => {
                let limit = self.limit.as_secs_f64();
                Err(self.ends(format!(
                    "hangs: no answer within {limit} s while {doing}; its process was ended"
                )))
            }
            Err(e) if e.kind() == io::ErrorKind::InvalidData => {
                Err(self.ends(format!("its process sent an invalid reply while {doing}: {e}")))
            }
            Ok(None) | Err(_) => {
                if self.is_watched {
                    // it does not see that before its build is done
                    std::thread::sleep(LAST_WORDS);
                    let _ = self.process.kill();
                }
                let how = self.process.wait().map_or_else(|e| e.to_string(), |s| s.to_string());
                let how = format!("crashes: its process ended with {how} while {doing}");
                Err(self.ends(how + &tail(&self.said)))
            }
        }
    }

    /// Ends the process, and says so from here on.
    fn ends(&mut self, how: String) -> String {
        let _ = self.process.kill();
        let _ = self.process.wait();
        self.failure.get_or_insert(how).clone()
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Reads what a process prints, and keeps the end of it.
fn keep_tail(mut from: impl Read + Send + 'static, into: Arc<Mutex<Vec<u8>>>) {
    std::thread::spawn(move || {
        let mut buffer = [0; 4096];
        while let Ok(read @ 1..) = from.read(&mut buffer) {
            let mut kept = into.lock().unwrap_or_else(PoisonError::into_inner);
            kept.extend_from_slice(buffer.get(..read).unwrap_or_default());
            let surplus = kept.len().saturating_sub(TAIL);
            kept.drain(..surplus);
        }
    });
}

/// The last that was printed, for the end of a message.
fn tail(said: &Mutex<Vec<u8>>) -> String {
    let said = said.lock().unwrap_or_else(PoisonError::into_inner);
    let text = String::from_utf8_lossy(&said);
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let last = lines.get(lines.len().saturating_sub(2)..).unwrap_or_default().join("; ");
    if last.is_empty() { String::new() } else { format!(": {last}") }
}
