//! `include/rtbench.h` in Rust: the same names, without their prefix, and the same layout.

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
/// `RTBENCH_BATCH`.
pub const BATCH: u32 = 1;
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

impl Hit {
    /// An answer as ours: of a miss nothing but that is read.
    pub(crate) fn as_ours(&self, ray: &accel_core::Ray<f32>) -> accel_core::Hit<f32> {
        match self.id {
            MISS => accel_core::Hit { t: ray.t_max, id: accel_core::MISS },
            id => accel_core::Hit { t: self.t, id },
        }
    }
}

/// `rtbench_setting`.
#[repr(C)]
pub struct Setting {
    pub(crate) name: *const c_char,
    pub(crate) summary: *const c_char,
    pub(crate) initial: *const c_char,
    pub(crate) kind: u32,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) words: *const c_char,
}

/// `rtbench_prepared`.
#[repr(C)]
pub struct Prepared {
    pub(crate) words: [u64; 16],
}

/// `rtbench_scene`.
#[repr(C)]
pub struct Scene {
    pub(crate) size: u32,
    pub(crate) threads: u32,
    pub(crate) triangles: u64,
    pub(crate) positions: *const f32,
    pub(crate) transmissive: *const u8,
    pub(crate) settings: *const *const c_char,
    pub(crate) host: *const c_void,
    pub(crate) prepare: unsafe extern "C" fn(*const c_void, *const Ray, *mut Prepared),
    pub(crate) intersect:
        unsafe extern "C" fn(*const c_void, *const Prepared, u32, f32, *mut f32) -> c_int,
    pub(crate) vertex_count: u64,
    pub(crate) vertices: *const f32,
    pub(crate) indices: *const u32,
}

/// `rtbench_stats`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct Stats {
    pub(crate) size: u32,
    pub(crate) has_counters: u32,
    pub(crate) bytes: u64,
    pub(crate) inner_nodes: u64,
    pub(crate) leaves: u64,
    pub(crate) empty_leaves: u64,
    pub(crate) references: u64,
    pub(crate) intersection_tests: u64,
    pub(crate) traversal_steps: u64,
}

/// Builds: `rtbench_plugin.build`.
pub(crate) type Build =
    unsafe extern "C" fn(*const Scene, *mut *mut c_void, *mut c_char, usize) -> c_int;
/// `rtbench_plugin.closest`.
pub(crate) type Closest = unsafe extern "C" fn(*mut c_void, *const Ray, *mut Hit, usize);
/// `rtbench_plugin.occluded`.
pub(crate) type Occluded = unsafe extern "C" fn(*mut c_void, *const Ray, *mut u8, usize);

/// `rtbench_plugin`.
#[repr(C)]
pub struct Plugin {
    pub(crate) abi_version: u32,
    pub(crate) size: u32,
    pub(crate) name: *const c_char,
    pub(crate) version: *const c_char,
    pub(crate) summary: *const c_char,
    pub(crate) answers: u32,
    pub(crate) query: u32,
    pub(crate) test: u32,
    pub(crate) settings_count: u32,
    pub(crate) settings: *const Setting,
    pub(crate) build: Option<Build>,
    pub(crate) closest: Option<Closest>,
    pub(crate) occluded: Option<Occluded>,
    pub(crate) stats: Option<unsafe extern "C" fn(*mut c_void, *mut Stats)>,
    pub(crate) count: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    pub(crate) destroy: Option<unsafe extern "C" fn(*mut c_void)>,
}

/// `rtbench_plugin_describe`.
pub(crate) type Describe = unsafe extern "C" fn() -> *const Plugin;

impl From<&accel_core::Ray<f32>> for Ray {
    fn from(ray: &accel_core::Ray<f32>) -> Self {
        Self {
            origin: ray.origin.to_array(),
            t_min: ray.t_min,
            direction: ray.direction.to_array(),
            t_max: ray.t_max,
        }
    }
}

impl From<&Ray> for accel_core::Ray<f32> {
    fn from(ray: &Ray) -> Self {
        Self {
            t_min: ray.t_min,
            t_max: ray.t_max,
            ..Self::new(ray.origin.into(), ray.direction.into())
        }
    }
}
