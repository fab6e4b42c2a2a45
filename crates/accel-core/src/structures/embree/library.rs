//! A committed scene of Embree, released when it is dropped.

use std::ffi::{CString, c_int, c_void};
use std::sync::atomic::{AtomicI64, Ordering};

use obvhs::aabb::Aabb as ObvhsAabb;

use crate::structures::embree::callbacks::{
    let_pass, occluded_primitive, test_primitive, test_triangle,
};
use crate::structures::embree::ffi::{self, FilterCallback, Handle};

/// Id of the geometry whose primitives are tested by callbacks.
const CALLBACKS: u32 = 1;

/// What the library is told to build.
pub(super) struct Input<'a> {
    /// Triangles that it tests itself, in the scene's unit.
    pub(super) triangles: Vec<[[f32; 3]; 3]>,
    /// Whether a callback is asked if one of them that it finds in an occlusion query counts.
    pub(super) has_filter: bool,
    /// Triangles that it tests itself, and that occlude nothing.
    pub(super) glass: Vec<[[f32; 3]; 3]>,
    /// Boxes of the primitives that callbacks test.
    pub(super) boxes: Vec<&'a ObvhsAabb>,
    /// `RTCBuildQuality`.
    pub(super) quality: c_int,
    /// Traverse so that rounding loses no box.
    pub(super) robust: bool,
    /// Threads that build.
    pub(super) threads: u64,
}

/// A device with one scene that is no longer changed.
pub(super) struct Library {
    device: Handle,
    scene: Handle,
    /// Bytes that the library holds; it has the address.
    bytes: Box<AtomicI64>,
}

// SAFETY: a committed scene may be asked from any thread ("rtcIntersect1 ... thread safe" in the
// manual of Embree 3), it is never changed again, and it is released by one owner.
unsafe impl Send for Library {}
// SAFETY: as above.
unsafe impl Sync for Library {}

impl Drop for Library {
    fn drop(&mut self) {
        // SAFETY: both are ours alone and released once; null is ignored by the library with an
        // error code, and never stored
        unsafe {
            ffi::rtcReleaseScene(self.scene);
            ffi::rtcReleaseDevice(self.device);
        }
    }
}

impl Library {
    /// Builds; `Err` is what the library says.
    pub(super) fn build(input: &Input) -> Result<Self, String> {
        let config = CString::new(format!("threads={}", input.threads))
            .map_err(|_| "a configuration with a zero byte".to_owned())?;
        // SAFETY: the string ends with a zero byte and lives until the call returns
        let device = unsafe { ffi::rtcNewDevice(config.as_ptr()) };
        if device.is_null() {
            // SAFETY: null asks for the error of the device that could not be made
            return Err(describe(unsafe { ffi::rtcGetDeviceError(device) }));
        }
        let bytes = Box::new(AtomicI64::new(0));
        // SAFETY: the device is live; the counter has an address of its own and is dropped after
        // the device (fields of `Library` are dropped after `Library::drop`)
        let this = unsafe {
            let counter = std::ptr::from_ref(&*bytes).cast::<c_void>().cast_mut();
            ffi::rtcSetDeviceMemoryMonitorFunction(device, count_bytes, counter);
            Self { device, scene: ffi::rtcNewScene(device), bytes }
        };
        this.check()?;
        // SAFETY: device and scene are live; geometries hold what is written before their commit
        unsafe {
            ffi::rtcSetSceneBuildQuality(this.scene, input.quality);
            ffi::rtcSetSceneFlags(this.scene, if input.robust { ffi::SCENE_ROBUST } else { 0 });
            if !input.triangles.is_empty() {
                let filter: Option<FilterCallback> =
                    if input.has_filter { Some(test_triangle) } else { None };
                this.attach_triangles(&input.triangles, input.quality, ffi::TRIANGLES, filter)?;
            }
            if !input.glass.is_empty() {
                this.attach_triangles(&input.glass, input.quality, ffi::GLASS, Some(let_pass))?;
            }
            if !input.boxes.is_empty() {
                this.attach_callbacks(input);
            }
            ffi::rtcCommitScene(this.scene);
        }
        this.check()?;
        Ok(this)
    }

    /// # Safety
    /// Before the commit of the scene.
    unsafe fn attach_triangles(
        &self,
        triangles: &[[[f32; 3]; 3]],
        quality: c_int,
        id: u32,
        occluded: Option<FilterCallback>,
    ) -> Result<(), String> {
        let count = triangles.len();
        // SAFETY: the buffers have the size asked for, and the library has checked that; each
        // triangle has three vertices of its own, one after the other
        unsafe {
            let geometry = ffi::rtcNewGeometry(self.device, ffi::GEOMETRY_TRIANGLE);
            ffi::rtcSetGeometryBuildQuality(geometry, quality);
            let buffer =
                |kind, format, n| ffi::rtcSetNewGeometryBuffer(geometry, kind, 0, format, 12, n);
            let vertices = buffer(ffi::BUFFER_VERTEX, ffi::FORMAT_FLOAT3, 3 * count);
            let indices = buffer(ffi::BUFFER_INDEX, ffi::FORMAT_UINT3, count);
            if vertices.is_null() || indices.is_null() {
                ffi::rtcReleaseGeometry(geometry);
                self.check()?;
                return Err("no buffer for the triangles".to_owned());
            }
            std::ptr::copy_nonoverlapping(triangles.as_ptr(), vertices.cast(), count);
            let indices = indices.cast::<u32>();
            for i in 0..3 * count {
                indices.add(i).write(i as u32);
            }
            if let Some(filter) = occluded {
                ffi::rtcSetGeometryOccludedFilterFunction(geometry, filter);
            }
            ffi::rtcCommitGeometry(geometry);
            ffi::rtcAttachGeometryByID(self.scene, geometry, id);
            ffi::rtcReleaseGeometry(geometry);
        }
        Ok(())
    }

    /// # Safety
    /// Before the commit of the scene, which reads the boxes.
    unsafe fn attach_callbacks(&self, input: &Input) {
        // SAFETY: `input` lives until the scene is committed, and no box is asked for after that
        unsafe {
            let geometry = ffi::rtcNewGeometry(self.device, ffi::GEOMETRY_USER);
            ffi::rtcSetGeometryBuildQuality(geometry, input.quality);
            ffi::rtcSetGeometryUserPrimitiveCount(geometry, input.boxes.len() as u32);
            let boxes = std::ptr::from_ref(&input.boxes).cast();
            ffi::rtcSetGeometryUserData(geometry, boxes);
            ffi::rtcSetGeometryBoundsFunction(geometry, box_of, std::ptr::null());
            ffi::rtcSetGeometryIntersectFunction(geometry, test_primitive);
            ffi::rtcSetGeometryOccludedFunction(geometry, occluded_primitive);
            ffi::rtcCommitGeometry(geometry);
            ffi::rtcAttachGeometryByID(self.scene, geometry, CALLBACKS);
            ffi::rtcReleaseGeometry(geometry);
        }
    }

    fn check(&self) -> Result<(), String> {
        // SAFETY: the device is live
        match unsafe { ffi::rtcGetDeviceError(self.device) } {
            0 => Ok(()),
            code => Err(describe(code)),
        }
    }

    /// The scene, for queries.
    pub(super) fn scene(&self) -> Handle {
        self.scene
    }

    /// Bytes that the library holds, its copy of the triangles included.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed).max(0) as u64
    }
}

/// `RTCError` in words.
fn describe(code: c_int) -> String {
    let name = match code {
        2 => "invalid argument",
        3 => "invalid operation",
        4 => "out of memory",
        5 => "unsupported CPU",
        6 => "cancelled",
        _ => "unknown",
    };
    format!("Embree error {code} ({name})")
}

/// # Safety
/// Called by the library with the counter that it was given.
unsafe extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: `counter` is the `AtomicI64` of a live `Library`
    unsafe { &*counter.cast::<AtomicI64>() }.fetch_add(bytes as i64, Ordering::Relaxed);
    true
}

/// # Safety
/// Called by the library while it builds, with the list that it was given.
unsafe extern "C" fn box_of(arguments: *const ffi::BoundsArguments) {
    // SAFETY: the library passes valid pointers, and an index below the count that it was given
    unsafe {
        let arguments = &*arguments;
        let boxes = &*arguments.user.cast::<Vec<&ObvhsAabb>>();
        let b = boxes[arguments.primitive as usize];
        let bounds = &mut *arguments.bounds;
        bounds.lower[..3].copy_from_slice(&b.min.to_array());
        bounds.upper[..3].copy_from_slice(&b.max.to_array());
    }
}
