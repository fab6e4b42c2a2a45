//! A structure that a plugin built, in this process.

use std::collections::HashMap;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ops::Deref;
use std::sync::Arc;

use crate::abi;
use crate::library::Library;
use crate::stopwatch::{CallTime, Stopwatch};
use accel_core::primitives::{PrimSet, Primitives, Shear, TriangleSet};
use accel_core::{Hit, Ray, Scalar, Vec3, Vector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Rays that one thread traces at a time when there are several.
const CHUNK: usize = 4096;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Query {
    Closest,
    /// True if an opaque triangle is in the way.
    Occlusion,
}

/// Statistics reported by the plugin.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stats {
    pub bytes: u64,
    /// N_IN, N_V, N_EV, N_OIV.
    pub cells: [u64; 4],
    /// N_IT and N_TS so far, where it counts.
    pub work: Option<[u64; 2]>,
    /// A line for the notes of its row, or nothing.
    pub note: String,
}

/// Coordinates that plugins are asked with: `f32` or `f64`.
pub trait PluginScalar: Scalar + abi::Real {}

impl<S: Scalar + abi::Real> PluginScalar for S {}

/// A structure that a plugin built over the triangles of `H`.
pub struct Instance<S: PluginScalar, H> {
    library: Arc<Library>,
    built: *mut c_void,
    /// Calls are divided among the threads of the current pool.
    in_chunks: bool,
    /// Calls are timed by processor time.
    by_processor: bool,
    transmissive: Vec<u8>,
    // what the scene points to
    _set: H,
    _indexed: IndexedMesh<S>,
    _texts: Vec<CString>,
    _settings: Vec<*const c_char>,
    _scene: Box<abi::Scene<S>>,
}

// SAFETY: the functions of a plugin may be called by any thread (rtbench.h); what its scene points
// to does not change
unsafe impl<S: PluginScalar, H: Send> Send for Instance<S, H> {}
// SAFETY: likewise
unsafe impl<S: PluginScalar, H: Sync> Sync for Instance<S, H> {}

impl<S: PluginScalar, H: Deref<Target = TriangleSet<S>> + Sync> Instance<S, H> {
    /// Builds with a value for each setting, in their order; also the seconds that took. Threads
    /// are those of the current rayon pool.
    ///
    /// # Errors
    /// The reason for which the plugin refuses.
    pub fn build(library: Arc<Library>, set: H, values: &[String]) -> Result<(Self, f64), String> {
        let threads = rayon::current_num_threads();
        let opaque = |id: u32| set.is_opaque(id);
        let transmissive: Vec<u8> = if (0..set.len() as u32).all(opaque) {
            Vec::new()
        } else {
            (0..set.len() as u32).map(|id| u8::from(!opaque(id))).collect()
        };
        let texts: Result<Vec<CString>, _> =
            values.iter().map(|value| CString::new(value.as_str())).collect();
        let texts = texts.map_err(|_| "a setting holds a zero byte".to_owned())?;
        let settings: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        let asks = library.plugin.answers & abi::INDICES != 0;
        let indexed = if asks { IndexedMesh::of(set.triangles()) } else { IndexedMesh::default() };
        let scene = Box::new(abi::Scene {
            size: size_of::<abi::Scene<S>>() as u32,
            threads: threads as u32,
            triangles: set.len() as u64,
            positions: set.triangles().as_flattened().as_flattened().as_ptr(),
            transmissive: null_if_empty(&transmissive),
            settings: settings.as_ptr(),
            host: std::ptr::from_ref::<TriangleSet<S>>(&set).cast(),
            prepare: prepare::<S>,
            intersect: intersect::<S>,
            vertex_count: indexed.vertices.len() as u64,
            vertices: null_if_empty(indexed.vertices.as_flattened()),
            indices: null_if_empty(indexed.indices.as_flattened()),
        });
        let Some(build) = S::functions(&library.plugin).build else {
            return Err("it cannot build".into());
        };
        let mut message = [0u8; 512];
        let mut built = std::ptr::null_mut();
        let on_device = library.description.on_device;
        let (in_chunks, by_processor) = (threads > 1 && !on_device, threads == 1 && !on_device);
        let start = Stopwatch::start(by_processor);
        // SAFETY: by rtbench.h; the message is as long as is said
        let code = unsafe {
            build(&raw const *scene, &raw mut built, message.as_mut_ptr().cast(), message.len())
        };
        let CallTime { seconds, .. } = start.took();
        if code != 0 {
            let end = message.iter().position(|&b| b == 0).unwrap_or(message.len());
            let said = String::from_utf8_lossy(message.get(..end).unwrap_or_default());
            return Err(match said.trim() {
                "" => format!("it returned {code} without a reason"),
                said => said.to_owned(),
            });
        }
        let instance = Self {
            library,
            built,
            in_chunks,
            by_processor,
            transmissive,
            _set: set,
            _indexed: indexed,
            _texts: texts,
            _settings: settings,
            _scene: scene,
        };
        Ok((instance, seconds))
    }

    /// Writes the closest hits; returns what that took. Slices are of one length.
    pub fn closest(&self, rays: &[abi::Ray<S>], hits: &mut [abi::Hit<S>]) -> CallTime {
        self.timed(rays, hits, |rays, hits| self.hits(rays, hits))
    }

    /// Writes 1 for blocked rays and 0 for others; returns what that took.
    pub fn occluded(&self, rays: &[abi::Ray<S>], blocked: &mut [u8]) -> CallTime {
        self.timed(rays, blocked, |rays, blocked| self.blocked(rays, blocked))
    }

    fn timed<A: Send>(
        &self,
        rays: &[abi::Ray<S>],
        answers: &mut [A],
        ask: impl Fn(&[abi::Ray<S>], &mut [A]) + Sync,
    ) -> CallTime {
        let start = Stopwatch::start(self.by_processor);
        if self.in_chunks {
            let chunks = rays.par_chunks(CHUNK).zip(answers.par_chunks_mut(CHUNK));
            chunks.for_each(|(rays, answers)| ask(rays, answers));
        } else {
            ask(rays, answers);
        }
        start.took()
    }

    fn hits(&self, rays: &[abi::Ray<S>], hits: &mut [abi::Hit<S>]) {
        let count = rays.len().min(hits.len());
        if let Some(closest) = self.functions().closest {
            // SAFETY: by rtbench.h; both have that many
            unsafe { closest(self.built, rays.as_ptr(), hits.as_mut_ptr(), count) };
        }
    }

    fn blocked(&self, rays: &[abi::Ray<S>], blocked: &mut [u8]) {
        let count = rays.len().min(blocked.len());
        match self.functions().occluded {
            Some(occluded) if self.library.description.has_occlusion => {
                // SAFETY: as above
                unsafe { occluded(self.built, rays.as_ptr(), blocked.as_mut_ptr(), count) };
            }
            _ => self.blocked_by_hits(rays, blocked),
        }
    }

    /// For plugins without a query of their own: asks for closest hits, on behind what is
    /// transmissive.
    fn blocked_by_hits(&self, rays: &[abi::Ray<S>], blocked: &mut [u8]) {
        let none = abi::Hit::new(S::ZERO, abi::MISS);
        for (rays, blocked) in rays.chunks(CHUNK).zip(blocked.chunks_mut(CHUNK)) {
            let mut hits = vec![none; rays.len()];
            self.hits(rays, &mut hits);
            for ((ray, hit), blocked) in rays.iter().zip(hits).zip(blocked) {
                let (mut ray, mut hit) = (*ray, hit);
                let lets_pass = |hit: &abi::Hit<S>| {
                    self.transmissive.get(hit.id as usize).is_some_and(|byte| *byte != 0)
                };
                while lets_pass(&hit) && hit.t >= ray.t_min && hit.t < ray.t_max {
                    ray.t_min = hit.t.next_up();
                    let mut next = [none];
                    self.hits(std::slice::from_ref(&ray), &mut next);
                    hit = next[0];
                }
                *blocked = u8::from(hit.id != abi::MISS && !lets_pass(&hit));
            }
        }
    }
}

impl<S: PluginScalar, H> Instance<S, H> {
    fn functions(&self) -> &abi::Functions<S> {
        S::functions(&self.library.plugin)
    }

    pub fn stats(&self) -> Stats {
        let mut stats = abi::Stats::empty();
        if let Some(ask) = self.functions().stats {
            // SAFETY: by rtbench.h
            unsafe { ask(self.built, &raw mut stats) };
        }
        Stats {
            bytes: stats.bytes,
            cells: [stats.inner_nodes, stats.leaves, stats.empty_leaves, stats.references],
            work: (stats.has_counters != 0 && self.functions().count.is_some())
                .then_some([stats.intersection_tests, stats.traversal_steps]),
            note: line_of(&stats.note),
        }
    }

    pub fn count(&self, on: bool) {
        if let Some(count) = self.functions().count {
            // SAFETY: by rtbench.h
            unsafe { count(self.built, c_int::from(on)) };
        }
    }
}

impl<S: PluginScalar, H> Drop for Instance<S, H> {
    fn drop(&mut self) {
        if let Some(destroy) = self.functions().destroy {
            // SAFETY: by rtbench.h; nobody asks it any more
            unsafe { destroy(self.built) };
        }
    }
}

fn null_if_empty<T>(items: &[T]) -> *const T {
    if items.is_empty() { std::ptr::null() } else { items.as_ptr() }
}

/// Text up to the first zero, in one line.
fn line_of(bytes: &[u8]) -> String {
    let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
    String::from_utf8_lossy(text).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Data that the host keeps in a plugin's `rtbench_prepared`.
struct PreparedRay<S: Scalar> {
    ray: Ray<S>,
    shear: Shear<S>,
}

impl<S: PluginScalar> PreparedRay<S> {
    const FITS: () = assert!(
        size_of::<Self>() <= size_of::<abi::Prepared<S>>()
            && align_of::<Self>() <= align_of::<abi::Prepared<S>>()
    );
}

/// # Safety
/// `host` is that of a scene, the others are valid.
unsafe extern "C" fn prepare<S: PluginScalar>(
    host: *const c_void,
    ray: *const abi::Ray<S>,
    prepared: *mut abi::Prepared<S>,
) {
    const { PreparedRay::<S>::FITS };
    // SAFETY: by the contract; there is room (above)
    unsafe {
        let set = &*host.cast::<TriangleSet<S>>();
        let ray = Ray::from(&*ray);
        prepared.cast::<PreparedRay<S>>().write(PreparedRay { shear: set.setup(&ray), ray });
    }
}

/// # Safety
/// `host` is that of a scene, `prepared` comes of `prepare`, `t` can be written.
unsafe extern "C" fn intersect<S: PluginScalar>(
    host: *const c_void,
    prepared: *const abi::Prepared<S>,
    id: u32,
    t_max: S,
    t: *mut S,
) -> c_int {
    // SAFETY: by the contract
    let (set, ready) =
        unsafe { (&*host.cast::<TriangleSet<S>>(), &*prepared.cast::<PreparedRay<S>>()) };
    if id as usize >= set.len() {
        return 0;
    }
    match set.intersect(id, &ready.ray, &ready.shear, t_max) {
        Some(found) => {
            // SAFETY: by the contract
            unsafe { *t = found };
            1
        }
        None => 0,
    }
}

/// Vertices, each once, and three of them for each triangle.
#[derive(Debug, Default, PartialEq)]
struct IndexedMesh<S> {
    vertices: Vec<[S; 3]>,
    indices: Vec<[u32; 3]>,
}

impl<S: Scalar> IndexedMesh<S> {
    /// Vertices that agree in all bits are one; in the order in which triangles have them first.
    fn of(triangles: &[[[S; 3]; 3]]) -> Self {
        let mut places: HashMap<[u64; 3], u32> = HashMap::with_capacity(triangles.len());
        let mut vertices = Vec::new();
        let mut index = |corner: &[S; 3]| {
            *places.entry(corner.map(|x| x.to_f64().to_bits())).or_insert_with(|| {
                vertices.push(*corner);
                (vertices.len() - 1) as u32
            })
        };
        let indices = triangles.iter().map(|[a, b, c]| [index(a), index(b), index(c)]).collect();
        Self { vertices, indices }
    }
}

impl<S: PluginScalar> abi::Hit<S> {
    /// An answer as ours: of a miss nothing but that is read.
    pub(crate) fn as_ours(&self, ray: &Ray<S>) -> Hit<S> {
        match self.id {
            abi::MISS => Hit { t: ray.t_max, id: accel_core::MISS },
            id => Hit { t: self.t, id },
        }
    }
}

impl<S: Scalar> From<&Ray<S>> for abi::Ray<S> {
    fn from(ray: &Ray<S>) -> Self {
        Self {
            origin: ray.origin.to_array(),
            t_min: ray.t_min,
            direction: ray.direction.to_array(),
            t_max: ray.t_max,
        }
    }
}

impl<S: Scalar> From<&abi::Ray<S>> for Ray<S> {
    fn from(ray: &abi::Ray<S>) -> Self {
        let vector = Vec3::<S>::from_array;
        let (t_min, t_max) = (ray.t_min, ray.t_max);
        Self { t_min, t_max, ..Self::new(vector(ray.origin), vector(ray.direction)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_one_line() {
        assert_eq!(line_of(b"  two\nlines\0and a rest"), "two lines");
        assert_eq!(line_of(b"\xff without an end"), "\u{fffd} without an end");
        assert_eq!(line_of(&abi::Stats::empty().note), "");
    }

    #[test]
    fn shared_vertices_are_one() {
        let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0]];
        let both = IndexedMesh::of(&[[a, b, c], [c, b, d]]);
        // zeros of both signs are two
        assert_eq!(both.vertices.len(), 4);
        assert_eq!(both.indices, [[0, 1, 2], [2, 1, 3]]);
    }
}
