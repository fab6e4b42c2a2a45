//! `include/rtbench.h` in Rust: the same names, without their prefix, and the same layout.
//!
//! Nothing of this repository is needed here, so that plugins in Rust can take this file as it is:
//! `peers/rust/peer` does.

#![warn(missing_docs)]

use std::ffi::{c_char, c_int, c_void};

use bytemuck::{Pod, Zeroable};

/// What this program speaks: `RTBENCH_ABI_VERSION`.
pub const VERSION: u32 = 1;
/// `RTBENCH_MISS`.
pub const MISS: u32 = u32::MAX;
/// `RTBENCH_TRIANGLES_F32`.
pub const TRIANGLES_F32: u32 = 1;
/// `RTBENCH_OCCLUSION`.
pub const OCCLUSION: u32 = 2;
/// `RTBENCH_INDICES`.
pub const INDICES: u32 = 32;
/// `RTBENCH_ONE_RAY`.
pub const ONE_RAY: u32 = 0;
/// `RTBENCH_BATCH`.
pub const BATCH: u32 = 1;
/// `RTBENCH_OWN_TEST`.
pub const OWN_TEST: u32 = 0;
/// `RTBENCH_HOST_TEST`.
pub const HOST_TEST: u32 = 1;
/// `RTBENCH_INTEGER`.
pub const INTEGER: u32 = 0;
/// `RTBENCH_REAL`.
pub const REAL: u32 = 1;
/// `RTBENCH_CHOICE`.
pub const CHOICE: u32 = 2;
/// The one symbol of a plugin.
pub const SYMBOL: &[u8] = b"rtbench_plugin_describe\0";

/// `rtbench_ray`: 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Ray {
    /// Start, world units.
    pub origin: [f32; 3],
    /// Smallest accepted parameter.
    pub t_min: f32,
    /// Direction, of any length.
    pub direction: [f32; 3],
    /// Largest accepted parameter.
    pub t_max: f32,
}

/// `rtbench_hit`: 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// Parameter, in multiples of the direction.
    pub t: f32,
    /// Triangle, or [`MISS`].
    pub id: u32,
}

/// `rtbench_setting`.
#[repr(C)]
pub struct Setting {
    /// `a-z`, digits and hyphens.
    pub name: *const c_char,
    /// One line.
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

/// `rtbench_prepared`.
#[repr(C)]
pub struct Prepared {
    /// Room, which the host knows how to use.
    pub words: [u64; 16],
}

/// `rtbench_scene`.
#[repr(C)]
pub struct Scene {
    /// Bytes of this struct.
    pub size: u32,
    /// How many threads the build may use.
    pub threads: u32,
    /// How many.
    pub triangles: u64,
    /// Nine coordinates for each.
    pub positions: *const f32,
    /// A byte for each, not 0 where shadow rays pass; null where none does.
    pub transmissive: *const u8,
    /// The value of each setting as text, in the order described.
    pub settings: *const *const c_char,
    /// For the two functions below.
    pub host: *const c_void,
    /// Makes a ray ready for `intersect`.
    pub prepare: unsafe extern "C" fn(*const c_void, *const Ray, *mut Prepared),
    /// rtbench's triangle test.
    pub intersect:
        unsafe extern "C" fn(*const c_void, *const Prepared, u32, f32, *mut f32) -> c_int,
    /// With [`INDICES`]: how many vertices.
    pub vertex_count: u64,
    /// Three coordinates for each; null without [`INDICES`].
    pub vertices: *const f32,
    /// Three vertices for each triangle, likewise.
    pub indices: *const u32,
}

/// `rtbench_stats`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct Stats {
    /// Bytes of this struct.
    pub size: u32,
    /// Not 0 where the last two fields are counted.
    pub has_counters: u32,
    /// Bytes of the structure.
    pub bytes: u64,
    /// N_IN.
    pub inner_nodes: u64,
    /// N_V.
    pub leaves: u64,
    /// N_EV.
    pub empty_leaves: u64,
    /// N_OIV.
    pub references: u64,
    /// N_IT since the build.
    pub intersection_tests: u64,
    /// N_TS likewise.
    pub traversal_steps: u64,
}

/// Builds: `rtbench_plugin.build`.
pub type Build = unsafe extern "C" fn(*const Scene, *mut *mut c_void, *mut c_char, usize) -> c_int;
/// `rtbench_plugin.closest`.
pub type Closest = unsafe extern "C" fn(*mut c_void, *const Ray, *mut Hit, usize);
/// `rtbench_plugin.occluded`.
pub type Occluded = unsafe extern "C" fn(*mut c_void, *const Ray, *mut u8, usize);

/// `rtbench_plugin`.
#[repr(C)]
pub struct Plugin {
    /// [`VERSION`].
    pub abi_version: u32,
    /// Bytes of this struct.
    pub size: u32,
    /// Of its row.
    pub name: *const c_char,
    /// Of the structure.
    pub version: *const c_char,
    /// One line.
    pub summary: *const c_char,
    /// [`TRIANGLES_F32`] and other bits.
    pub answers: u32,
    /// [`ONE_RAY`] or [`BATCH`].
    pub query: u32,
    /// [`OWN_TEST`] or [`HOST_TEST`].
    pub test: u32,
    /// How many settings.
    pub settings_count: u32,
    /// That many.
    pub settings: *const Setting,
    /// Builds, or writes why not.
    pub build: Option<Build>,
    /// Writes closest hits.
    pub closest: Option<Closest>,
    /// Writes which rays are blocked; none without [`OCCLUSION`].
    pub occluded: Option<Occluded>,
    /// Says what was built.
    pub stats: Option<unsafe extern "C" fn(*mut c_void, *mut Stats)>,
    /// Turns counting on or off.
    pub count: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Frees what was built.
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
}

/// `rtbench_plugin_describe`.
pub type Describe = unsafe extern "C" fn() -> *const Plugin;
