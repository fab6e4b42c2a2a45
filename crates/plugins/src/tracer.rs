//! A plugin of this process with the processes of its rows, and a row of it as a tracer of rtbench: in
//! a separate process, or in this one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use accel_core::geometry::far_ray;
use accel_core::memory::{MemoryLimit, OutOfMemory};
use accel_core::primitives::{Primitives, TriangleSet};
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::{Foreign, Origin, Tracer};
use accel_core::structure::{BuildError, StructureInfo, StructureStats};
use accel_core::{Hit, Ray};

use crate::abi;
use crate::description::Description;
use crate::instance::{Instance, PluginScalar, Stats};
use crate::library::Library;
use crate::near_rays::NearRays;
use crate::remote::Remote;
use crate::stopwatch::CallTime;
use crate::wire::{BuildReply, Launch};

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
    fn process(&self, row: &str) -> Result<Remote, String> {
        let found = self.waiting().remove(row);
        match found {
            Some(remote) => match remote.failure().map(str::to_owned) {
                Some(_) if self.launch.options.restarts => Remote::start(&self.launch),
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
    fn keep(&self, row: &str, remote: Remote) {
        self.waiting().insert(row.to_owned(), remote);
    }
}

/// Where a structure is.
enum Host<'a, S: PluginScalar> {
    Here(Box<Instance<S, &'a TriangleSet<S>>>),
    /// The process is given back when the tracer is dropped.
    Elsewhere(Option<Remote>),
}

struct State<'a, S: PluginScalar> {
    place: Host<'a, S>,
    /// Of calls since they were asked for.
    seconds: f64,
    all: CallTime,
    /// Origins within it are near.
    reach: S,
    failure: Option<String>,
}

pub(crate) struct PluginTracer<'a, S: PluginScalar> {
    plugin: Arc<Plugin>,
    /// The row's settings: a process is kept for each row.
    row: String,
    origin: Origin,
    build_seconds: f64,
    stats: Stats,
    state: Mutex<State<'a, S>>,
}

impl<'a, S: PluginScalar> PluginTracer<'a, S> {
    /// Builds over triangles, on as many threads as the current pool has.
    pub(crate) fn build(
        plugin: Arc<Plugin>,
        set: &'a TriangleSet<S>,
        row: String,
        values: &[String],
        memory: MemoryLimit,
    ) -> Result<Self, BuildError> {
        let structure = plugin.info.name;
        let refused = |message: String| BuildError::Library { structure, message };
        let mut origin = plugin.origin.clone();
        let (place, build_seconds, stats) = if let Some(library) = &plugin.library {
            let built = Instance::build(Arc::clone(library), set, values);
            let (instance, seconds) = built.map_err(refused)?;
            let stats = instance.stats();
            (Host::Here(Box::new(instance)), seconds, stats)
        } else {
            let mut remote = plugin.process(&row).map_err(BuildError::Died)?;
            let mut ask = || -> Result<(BuildReply, Stats), String> {
                let built = remote.build(set, values, memory.bytes())?;
                if !matches!(built, BuildReply::Built(_)) {
                    return Ok((built, Stats::default()));
                }
                origin.empty_call_s = remote.empty_call()?;
                Ok((built, remote.stats()?))
            };
            match ask() {
                Ok((BuildReply::Built(seconds), stats)) => {
                    (Host::Elsewhere(Some(remote)), seconds, stats)
                }
                Ok((BuildReply::Refused(message), _)) => {
                    plugin.keep(&row, remote);
                    return Err(refused(message));
                }
                // another scene may have room: its process is a new one
                Ok((BuildReply::TooLarge(bytes), _)) => {
                    let (needed, limit) = (bytes.into(), memory.bytes());
                    return Err(OutOfMemory { structure, needed, limit }.into());
                }
                Err(how) => {
                    plugin.keep(&row, remote);
                    return Err(BuildError::Died(how));
                }
            }
        };
        let reach = far_ray::reach(set.magnitude());
        let (all, failure) = (CallTime::default(), None);
        let state = Mutex::new(State { place, seconds: 0.0, all, reach, failure });
        Ok(Self { plugin, row, origin, build_seconds, stats, state })
    }

    fn state(&self) -> MutexGuard<'_, State<'a, S>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<S: PluginScalar> State<'_, S> {
    fn took(&mut self, took: Result<CallTime, String>) {
        match took {
            Ok(took) => {
                self.seconds += took.seconds;
                self.all += took;
            }
            Err(how) => {
                self.failure.get_or_insert(how);
            }
        }
    }

    fn closest(&mut self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        match NearRays::of(rays, self.reach) {
            Some(near) => near.closest(rays, hits, |rays, hits| self.closest_of_near(rays, hits)),
            None => self.closest_of_near(rays, hits),
        }
    }

    fn occluded(&mut self, rays: &[Ray<S>], blocked: &mut [bool]) {
        match NearRays::of(rays, self.reach) {
            Some(near) => near.occluded(blocked, |rays, own| self.occluded_of_near(rays, own)),
            None => self.occluded_of_near(rays, blocked),
        }
    }

    fn closest_of_near(&mut self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        let took = match &mut self.place {
            Host::Here(instance) => {
                let asked: Vec<abi::Ray<S>> = rays.iter().map(abi::Ray::from).collect();
                let mut answers: Vec<abi::Hit<S>> =
                    hits.iter().map(|hit| abi::Hit::new(hit.t, hit.id)).collect();
                let took = instance.closest(&asked, &mut answers);
                for ((hit, answer), ray) in hits.iter_mut().zip(&answers).zip(rays) {
                    *hit = answer.as_ours(ray);
                }
                Ok(took)
            }
            Host::Elsewhere(Some(remote)) => remote.closest(rays, hits),
            Host::Elsewhere(None) => Ok(CallTime::default()),
        };
        self.took(took);
    }

    fn occluded_of_near(&mut self, rays: &[Ray<S>], blocked: &mut [bool]) {
        let took = match &mut self.place {
            Host::Here(instance) => {
                let asked: Vec<abi::Ray<S>> = rays.iter().map(abi::Ray::from).collect();
                let mut answers: Vec<u8> = blocked.iter().map(|&b| u8::from(b)).collect();
                let took = instance.occluded(&asked, &mut answers);
                blocked.iter_mut().zip(&answers).for_each(|(b, answer)| *b = *answer != 0);
                Ok(took)
            }
            Host::Elsewhere(Some(remote)) => remote.occluded(rays, blocked),
            Host::Elsewhere(None) => Ok(CallTime::default()),
        };
        self.took(took);
    }

    /// Calls `ask` while the plugin counts, and returns the work.
    fn counted(&mut self, ask: impl FnOnce(&mut Self)) -> WorkCounters {
        self.count(true);
        let before = self.work();
        ask(self);
        let after = self.work();
        self.count(false);
        let of = |i: usize| after[i].saturating_sub(before[i]);
        WorkCounters { intersection_tests: of(0), traversal_steps: of(1), ..Default::default() }
    }

    fn count(&mut self, on: bool) {
        match &mut self.place {
            Host::Here(instance) => instance.count(on),
            Host::Elsewhere(Some(remote)) => {
                let done = remote.count(on).map(|()| CallTime::default());
                self.took(done);
            }
            Host::Elsewhere(None) => {}
        }
    }

    fn work(&mut self) -> [u64; 2] {
        self.stats().work.unwrap_or_default()
    }

    fn stats(&mut self) -> Stats {
        let stats = match &mut self.place {
            Host::Here(instance) => Ok(instance.stats()),
            Host::Elsewhere(Some(remote)) => remote.stats(),
            Host::Elsewhere(None) => Ok(Stats::default()),
        };
        stats.unwrap_or_else(|how| {
            self.took(Err(how));
            Stats::default()
        })
    }
}

impl<S: PluginScalar> Drop for PluginTracer<'_, S> {
    fn drop(&mut self) {
        let mut state = self.state();
        if let Host::Elsewhere(remote) = &mut state.place
            && let Some(mut remote) = remote.take()
        {
            // how that ends is kept with the process
            let _ = remote.destroy();
            self.plugin.keep(&self.row, remote);
        }
    }
}

impl<S: PluginScalar> Tracer<S> for PluginTracer<'_, S> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        let n = rays.len().min(hits.len());
        self.state().closest(&rays[..n], &mut hits[..n]);
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        let n = rays.len().min(blocked.len());
        self.state().occluded(&rays[..n], &mut blocked[..n]);
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        let n = rays.len().min(hits.len());
        self.state().counted(|state| state.closest(&rays[..n], &mut hits[..n]))
    }

    fn count_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) -> WorkCounters {
        let n = rays.len().min(blocked.len());
        self.state().counted(|state| state.occluded(&rays[..n], &mut blocked[..n]))
    }

    fn stats(&self) -> StructureStats {
        let [inner_cells, cells, empty_cells, references] = self.stats.cells;
        let bytes = self.stats.bytes;
        StructureStats {
            inner_cells,
            cells,
            empty_cells,
            references,
            bytes,
            ..StructureStats::default()
        }
    }

    fn foreign(&self) -> Option<&dyn Foreign> {
        Some(self)
    }
}

impl<S: PluginScalar> Foreign for PluginTracer<'_, S> {
    fn origin(&self) -> &Origin {
        &self.origin
    }

    fn build_seconds(&self) -> f64 {
        self.build_seconds
    }

    fn take_seconds(&self) -> f64 {
        std::mem::take(&mut self.state().seconds)
    }

    fn share_of_other_threads(&self) -> f64 {
        let CallTime { seconds, by_others } = self.state().all;
        if seconds > 0.0 { by_others / seconds } else { 0.0 }
    }

    fn note(&self) -> Option<String> {
        let note = self.state().stats().note;
        let on_device = self.plugin.description.on_device;
        let parts = [if on_device { "timed by time of day" } else { "" }, &note];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }

    fn failure(&self) -> Option<String> {
        self.state().failure.clone()
    }

    fn has_counters(&self) -> bool {
        self.stats.work.is_some()
    }

    fn answers_batches(&self) -> bool {
        self.plugin.description.answers_batches
    }
}
