//! `include/rtbench.h` in Rust: the same names, without their prefix, and the same layout.
//!
//! Nothing of this repository is needed here, so that plugins in Rust can take this file as it is:
//! `peers/rust/peer` does.

#![warn(missing_docs)]

use std::ffi::{c_char, c_int, c_void};
use std::fmt::Debug;

use bytemuck::{Pod, Zeroable};

/// Version of the interface: `RTBENCH_ABI_VERSION`.
pub const VERSION: u32 = 1;
/// Id of a ray that hits nothing: `RTBENCH_MISS`.
pub const MISS: u32 = u32::MAX;
/// Bit of `answers`: closest hits with triangles in f32; every plugin sets it.
pub const TRIANGLES_F32: u32 = 1;
/// Bit of `answers`: a query for shadow rays; without it they ask for closest hits.
pub const OCCLUSION: u32 = 2;
/// Bit of `answers`: the functions of [`Plugin::in_f64`].
pub const TRIANGLES_F64: u32 = 4;
/// Bit of `answers`: the plugin reads [`Scene::vertices`] and [`Scene::indices`].
pub const INDICES: u32 = 32;
/// Bit of `answers`: the plugin computes on a device. Its calls are timed by time of day, and have
/// whole batches.
pub const DEVICE: u32 = 64;
/// Value of `query`: each ray is traced to its end before the next one.
pub const ONE_RAY: u32 = 0;
/// Value of `query`: several rays are in flight, or are sorted.
pub const BATCH: u32 = 1;
/// Value of `test`: the plugin's own; answers are compared up to rounding.
pub const OWN_TEST: u32 = 0;
/// Value of `test`: [`Scene::intersect`]; answers are compared bit by bit.
pub const HOST_TEST: u32 = 1;
/// Kind of a setting: a whole number.
pub const INTEGER: u32 = 0;
/// Kind of a setting: a real number.
pub const REAL: u32 = 1;
/// Kind of a setting: one of its words.
pub const CHOICE: u32 = 2;
/// The one symbol of a plugin.
pub const SYMBOL: &[u8] = b"rtbench_plugin_describe\0";

/// Number type of coordinates: `f32`, or `f64` with [`TRIANGLES_F64`].
pub trait Real: Pod + PartialEq + Debug + Send + Sync {
    /// Fills a [`Hit`] up to its alignment.
    type Fill: Pod + PartialEq + Debug + Send + Sync;
    /// Room for a prepared ray.
    type Room;
    /// The functions of a plugin for this type.
    fn functions(plugin: &Plugin) -> &Functions<Self>;
}

impl Real for f32 {
    type Fill = [u32; 0];
    type Room = [u64; 16];
    fn functions(plugin: &Plugin) -> &Functions<Self> {
        &plugin.in_f32
    }
}

impl Real for f64 {
    type Fill = u32;
    type Room = [u64; 32];
    fn functions(plugin: &Plugin) -> &Functions<Self> {
        &plugin.in_f64
    }
}

/// `rtbench_ray`, 32 bytes, or `rtbench_ray_f64`, 64.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray<T = f32> {
    /// Start of the ray, world units.
    pub origin: [T; 3],
    /// Smallest parameter that counts as a hit.
    pub t_min: T,
    /// Direction, of any length.
    pub direction: [T; 3],
    /// Largest parameter that counts as a hit.
    pub t_max: T,
}

// SAFETY: eight numbers, all of which may be zero
unsafe impl<T: Real> Zeroable for Ray<T> {}
// SAFETY: eight numbers without padding
unsafe impl<T: Real> Pod for Ray<T> {}

/// `rtbench_hit`, 8 bytes, or `rtbench_hit_f64`, 16.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit<T: Real = f32> {
    /// Parameter, in multiples of the direction.
    pub t: T,
    /// Number of the triangle, or [`MISS`].
    pub id: u32,
    /// Fills the struct; not read.
    pub fill: T::Fill,
}

impl<T: Real> Hit<T> {
    /// The hit of a triangle, or [`MISS`].
    pub fn new(t: T, id: u32) -> Self {
        Self { t, id, fill: T::Fill::zeroed() }
    }
}

// SAFETY: numbers, all of which may be zero
unsafe impl<T: Real> Zeroable for Hit<T> {}
// SAFETY: without padding: `Fill` has the bytes that the alignment of `T` asks for (below)
unsafe impl<T: Real> Pod for Hit<T> {}

const _: () = assert!(size_of::<Ray<f32>>() == 32 && size_of::<Ray<f64>>() == 64);
const _: () = assert!(size_of::<Hit<f32>>() == 8 && size_of::<Hit<f64>>() == 16);

/// A setting that users can change.
#[repr(C)]
pub struct Setting {
    /// `a-z`, digits and hyphens.
    pub name: *const c_char,
    /// Description in one line.
    pub summary: *const c_char,
    /// The default, as a user would type it.
    pub initial: *const c_char,
    /// [`INTEGER`], [`REAL`] or [`CHOICE`].
    pub kind: u32,
    /// Least of a number.
    pub min: f64,
    /// Largest of a number.
    pub max: f64,
    /// Of a choice: its words with blanks between; else null.
    pub words: *const c_char,
}

/// A ray made ready for [`Scene::intersect`].
#[repr(C)]
pub struct Prepared<T: Real = f32> {
    /// Room, which the host knows how to use.
    pub words: T::Room,
}

/// Scene that a structure is built over; it stays valid until `destroy`.
#[repr(C)]
pub struct Scene<T: Real = f32> {
    /// Bytes of this struct.
    pub size: u32,
    /// Number of threads that the build may use.
    pub threads: u32,
    /// Number of triangles: at least 1, less than [`MISS`].
    pub triangles: u64,
    /// Nine coordinates for each.
    pub positions: *const T,
    /// A byte for each, not 0 where shadow rays pass; null where none does.
    pub transmissive: *const u8,
    /// The value of each setting as text, in the order described.
    pub settings: *const *const c_char,
    /// For the two functions below.
    pub host: *const c_void,
    /// Makes a ray ready for `intersect`.
    pub prepare: unsafe extern "C" fn(*const c_void, *const Ray<T>, *mut Prepared<T>),
    /// rtbench's watertight triangle test, of a prepared ray.
    pub intersect: Intersect<T>,
    /// With [`INDICES`]: how many vertices.
    pub vertex_count: u64,
    /// Three coordinates for each; null without [`INDICES`].
    pub vertices: *const T,
    /// Three vertices for each triangle, likewise.
    pub indices: *const u32,
}

/// Tests a triangle: `rtbench_scene.intersect`.
pub type Intersect<T = f32> =
    unsafe extern "C" fn(*const c_void, *const Prepared<T>, u32, T, *mut T) -> c_int;

/// Figures of what was built; zero where unknown.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Stats {
    /// Bytes of this struct.
    pub size: u32,
    /// Not 0 where the last two fields are counted.
    pub has_counters: u32,
    /// Bytes of the structure.
    pub bytes: u64,
    /// N_IN: number of inner nodes.
    pub inner_nodes: u64,
    /// N_V: number of leaves or cells.
    pub leaves: u64,
    /// N_EV: number of empty leaves.
    pub empty_leaves: u64,
    /// N_OIV: number of triangle references in leaves.
    pub references: u64,
    /// N_IT since the build.
    pub intersection_tests: u64,
    /// N_TS since the build: nodes visited.
    pub traversal_steps: u64,
    /// One line for the notes of the row, up to the first zero.
    pub note: [u8; 256],
}

// SAFETY: numbers, all of which may be zero
unsafe impl Zeroable for Stats {}

impl Stats {
    /// What a plugin is asked with.
    pub fn empty() -> Self {
        Self { size: size_of::<Self>() as u32, ..Self::zeroed() }
    }
}

/// Builds a structure: `rtbench_plugin.build`.
pub type Build<T = f32> =
    unsafe extern "C" fn(*const Scene<T>, *mut *mut c_void, *mut c_char, usize) -> c_int;
/// Finds closest hits: `rtbench_plugin.closest`.
pub type Closest<T = f32> = unsafe extern "C" fn(*mut c_void, *const Ray<T>, *mut Hit<T>, usize);
/// Finds blocked rays: `rtbench_plugin.occluded`.
pub type Occluded<T = f32> = unsafe extern "C" fn(*mut c_void, *const Ray<T>, *mut u8, usize);

/// The functions of a plugin for one number type.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Functions<T: Real> {
    /// Builds, or writes why not.
    pub build: Option<Build<T>>,
    /// Writes the closest hit of each ray.
    pub closest: Option<Closest<T>>,
    /// Writes which rays are blocked; none without [`OCCLUSION`].
    pub occluded: Option<Occluded<T>>,
    /// Says what was built.
    pub stats: Option<unsafe extern "C" fn(*mut c_void, *mut Stats)>,
    /// Turns counting on or off.
    pub count: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Frees what was built.
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
}

impl<T: Real> Functions<T> {
    /// Of a plugin without this number type.
    pub const NONE: Self = Self {
        build: None,
        closest: None,
        occluded: None,
        stats: None,
        count: None,
        destroy: None,
    };
}

/// Description of a plugin: `rtbench_plugin`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Plugin {
    /// Version of the interface: [`VERSION`].
    pub abi_version: u32,
    /// Bytes of this struct.
    pub size: u32,
    /// Name of its row: `a-z`, digits and hyphens.
    pub name: *const c_char,
    /// Version of the structure, as text.
    pub version: *const c_char,
    /// Description in one line.
    pub summary: *const c_char,
    /// [`TRIANGLES_F32`] and other bits.
    pub answers: u32,
    /// How it answers many rays in one call: [`ONE_RAY`] or [`BATCH`].
    pub query: u32,
    /// Whose triangle test decides: [`OWN_TEST`] or [`HOST_TEST`].
    pub test: u32,
    /// Number of elements of `settings`.
    pub settings_count: u32,
    /// Array of `settings_count` settings.
    pub settings: *const Setting,
    /// `build` to `destroy` for triangles in f32.
    pub in_f32: Functions<f32>,
    /// `build_f64` to `destroy_f64`, with [`TRIANGLES_F64`].
    pub in_f64: Functions<f64>,
}

/// Type of [`SYMBOL`]: `rtbench_plugin_describe`.
pub type Describe = unsafe extern "C" fn() -> *const Plugin;
