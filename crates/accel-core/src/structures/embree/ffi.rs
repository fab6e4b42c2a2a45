//! The few declarations of Embree 3's C interface that we call, after its headers `rtcore_*.h`
//! (version 3.13, as Debian builds it: one instance level, no minimal curve width).

use std::ffi::{c_char, c_int, c_uint, c_void};

/// `RTCDevice`, `RTCScene` and `RTCGeometry`: pointers to what only the library knows.
pub(super) type Handle = *mut c_void;

pub(super) const GEOMETRY_TRIANGLE: c_int = 0;
pub(super) const GEOMETRY_USER: c_int = 120;
pub(super) const BUFFER_INDEX: c_int = 0;
pub(super) const BUFFER_VERTEX: c_int = 1;
pub(super) const FORMAT_UINT3: c_int = 0x5003;
pub(super) const FORMAT_FLOAT3: c_int = 0x9003;
pub(super) const QUALITY_LOW: c_int = 0;
pub(super) const QUALITY_MEDIUM: c_int = 1;
pub(super) const QUALITY_HIGH: c_int = 2;
pub(super) const SCENE_ROBUST: c_int = 1 << 2;
/// `RTC_INVALID_GEOMETRY_ID`.
pub(super) const INVALID: c_uint = c_uint::MAX;

/// `RTCRay`; in units of the scene's size, see `obvhs/adapter.rs`, but for what `direct.rs` asks.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: [f32; 3],
    pub(super) t_near: f32,
    pub(super) direction: [f32; 3],
    pub(super) time: f32,
    /// The end of the segment; a hit shortens it, minus infinity says "occluded".
    pub(super) t_far: f32,
    pub(super) mask: c_uint,
    pub(super) id: c_uint,
    pub(super) flags: c_uint,
}

/// `RTCHit`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub(super) struct Hit {
    pub(super) normal: [f32; 3],
    pub(super) uv: [f32; 2],
    pub(super) primitive: c_uint,
    pub(super) geometry: c_uint,
    pub(super) instance: c_uint,
}

impl Hit {
    /// Nothing found yet.
    pub(super) const NONE: Self = Self {
        normal: [0.0; 3],
        uv: [0.0; 2],
        primitive: INVALID,
        geometry: INVALID,
        instance: INVALID,
    };
}

/// `RTCRayHit`.
#[repr(C)]
pub(super) struct RayHit {
    pub(super) ray: Ray,
    pub(super) hit: Hit,
}

/// `RTCIntersectContext`. The library passes our pointer on to the callbacks.
#[repr(C)]
pub(super) struct Context {
    pub(super) flags: c_int,
    pub(super) filter: *const c_void,
    pub(super) instance: c_uint,
}

impl Context {
    /// As `rtcInitIntersectContext` makes it.
    pub(super) const NEW: Self = Self { flags: 0, filter: std::ptr::null(), instance: INVALID };
}

/// `RTCBounds`.
#[repr(C, align(16))]
pub(super) struct Bounds {
    pub(super) lower: [f32; 4],
    pub(super) upper: [f32; 4],
}

/// `RTCBoundsFunctionArguments`.
#[repr(C)]
pub(super) struct BoundsArguments {
    pub(super) user: *const c_void,
    pub(super) primitive: c_uint,
    pub(super) time_step: c_uint,
    pub(super) bounds: *mut Bounds,
}

/// `RTCIntersectFunctionNArguments` and `RTCOccludedFunctionNArguments`, which differ in what
/// `ray` points to: a [`RayHit`] or a [`Ray`]. For calls with one ray both begin with the ray.
#[repr(C)]
pub(super) struct PrimitiveArguments {
    pub(super) valid: *mut c_int,
    pub(super) user: *const c_void,
    pub(super) primitive: c_uint,
    pub(super) context: *mut Context,
    pub(super) ray: *mut Ray,
    pub(super) rays: c_uint,
    pub(super) geometry: c_uint,
}

/// `RTCFilterFunctionNArguments`, of calls with one ray.
#[repr(C)]
pub(super) struct FilterArguments {
    pub(super) valid: *mut c_int,
    pub(super) user: *const c_void,
    pub(super) context: *mut Context,
    pub(super) ray: *mut Ray,
    pub(super) hit: *const Hit,
    pub(super) rays: c_uint,
}

type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
type BoundsCallback = unsafe extern "C" fn(*const BoundsArguments);
type PrimitiveCallback = unsafe extern "C" fn(*const PrimitiveArguments);
pub(super) type FilterCallback = unsafe extern "C" fn(*const FilterArguments);

#[link(name = "embree3")]
unsafe extern "C" {
    pub(super) fn rtcNewDevice(config: *const c_char) -> Handle;
    pub(super) fn rtcReleaseDevice(device: Handle);
    pub(super) fn rtcGetDeviceError(device: Handle) -> c_int;
    pub(super) fn rtcSetDeviceMemoryMonitorFunction(
        device: Handle,
        monitor: MemoryMonitor,
        user: *mut c_void,
    );
    pub(super) fn rtcNewScene(device: Handle) -> Handle;
    pub(super) fn rtcReleaseScene(scene: Handle);
    pub(super) fn rtcSetSceneBuildQuality(scene: Handle, quality: c_int);
    pub(super) fn rtcSetSceneFlags(scene: Handle, flags: c_int);
    pub(super) fn rtcAttachGeometryByID(scene: Handle, geometry: Handle, id: c_uint);
    pub(super) fn rtcCommitScene(scene: Handle);
    pub(super) fn rtcNewGeometry(device: Handle, kind: c_int) -> Handle;
    pub(super) fn rtcReleaseGeometry(geometry: Handle);
    pub(super) fn rtcCommitGeometry(geometry: Handle);
    pub(super) fn rtcSetGeometryBuildQuality(geometry: Handle, quality: c_int);
    pub(super) fn rtcSetNewGeometryBuffer(
        geometry: Handle,
        buffer: c_int,
        slot: c_uint,
        format: c_int,
        stride: usize,
        count: usize,
    ) -> *mut c_void;
    pub(super) fn rtcSetGeometryOccludedFilterFunction(geometry: Handle, filter: FilterCallback);
    pub(super) fn rtcSetGeometryUserData(geometry: Handle, user: *const c_void);
    pub(super) fn rtcSetGeometryUserPrimitiveCount(geometry: Handle, count: c_uint);
    pub(super) fn rtcSetGeometryBoundsFunction(
        geometry: Handle,
        bounds: BoundsCallback,
        user: *const c_void,
    );
    pub(super) fn rtcSetGeometryIntersectFunction(geometry: Handle, call: PrimitiveCallback);
    pub(super) fn rtcSetGeometryOccludedFunction(geometry: Handle, call: PrimitiveCallback);
    pub(super) fn rtcIntersect1(scene: Handle, context: *mut Context, ray: *mut RayHit);
    pub(super) fn rtcOccluded1(scene: Handle, context: *mut Context, ray: *mut Ray);
}

/// Id of the geometry that holds triangles.
pub(super) const TRIANGLES: u32 = 0;
/// Id of the one that holds triangles which occlude nothing.
pub(super) const GLASS: u32 = 2;
