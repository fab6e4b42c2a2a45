//! The functions of a plugin.

use std::ffi::{c_char, c_int, c_void};
use std::mem::MaybeUninit;

use crate::abi::{self, Hit, Ray, Real};
use crate::scene::{Scene, Triangle};
use crate::{Peer, Shadows, Stats, memory, panics, threads};

/// What a peer built.
struct Built<P> {
    all: P,
    /// Without triangles that let shadow rays pass, with [`Shadows::All`] where there are such.
    opaque: Option<P>,
    bytes: u64,
}

impl<P> Built<P> {
    fn new<T: Real>(scene: &Scene<'_, T>) -> Result<Self, String>
    where
        P: Peer<T>,
    {
        if !P::USES_RAYON {
            return Self::counted(scene);
        }
        // before bytes are counted: its threads are not of the structure
        threads::pool(scene.threads)?.install(|| Self::counted(scene))
    }

    fn counted<T: Real>(scene: &Scene<'_, T>) -> Result<Self, String>
    where
        P: Peer<T>,
    {
        let before = memory::allocated();
        let all = P::build(scene)?;
        let others = opaque_triangles::<P, T>(scene);
        let only_them =
            |triangles| Scene { triangles, transmissive: None, indexed: None, ..*scene };
        let opaque =
            others.as_ref().map(|triangles| P::build(&only_them(triangles))).transpose()?;
        drop(others);
        let bytes = memory::allocated().saturating_sub(before);
        Ok(Self { all, opaque, bytes })
    }
}

/// The triangles that shadow rays do not pass, for a peer that needs them apart.
fn opaque_triangles<P: Peer<T>, T: Real>(scene: &Scene<'_, T>) -> Option<Vec<Triangle<T>>> {
    let are_some = (0..scene.triangles.len()).any(|id| scene.is_transmissive(id));
    if P::SHADOWS != Shadows::All || !are_some {
        return None;
    }
    let opaque =
        |(id, triangle): (usize, &Triangle<T>)| (!scene.is_transmissive(id)).then_some(*triangle);
    let mut others: Vec<Triangle<T>> =
        scene.triangles.iter().enumerate().filter_map(opaque).collect();
    if others.is_empty() {
        // there is nothing to build over: a point that nothing hits
        others.push([[T::zeroed(); 3]; 3]);
    }
    Some(others)
}

/// `rtbench_plugin.build`.
///
/// # Safety
/// As rtbench.h says.
pub(crate) unsafe extern "C" fn build<P: Peer<T>, T: Real>(
    scene: *const abi::Scene<T>,
    built: *mut *mut c_void,
    message: *mut c_char,
    message_size: usize,
) -> c_int {
    // SAFETY: by the contract
    let attempt = || unsafe { Scene::read::<P, _>(&*scene, Built::<P>::new::<T>) };
    let reason = match panics::as_reason(attempt) {
        Ok(whole) => {
            // SAFETY: by the contract
            unsafe { *built = Box::into_raw(Box::new(whole)).cast() };
            return 0;
        }
        Err(reason) => reason,
    };
    if message_size > 0 {
        // no letter is cut
        let room = message_size - 1;
        let length = if reason.len() <= room {
            reason.len()
        } else {
            (0..=room).rev().find(|at| reason.is_char_boundary(*at)).unwrap_or(0)
        };
        // SAFETY: there is room for that many and a zero
        unsafe {
            std::ptr::copy_nonoverlapping(reason.as_ptr(), message.cast(), length);
            *message.add(length) = 0;
        }
    }
    1
}

/// `rtbench_plugin.closest`. A panic ends the process.
///
/// # Safety
/// As rtbench.h says.
pub(crate) unsafe extern "C" fn closest<P: Peer<T>, T: Real>(
    built: *mut c_void,
    rays: *const Ray<T>,
    hits: *mut Hit<T>,
    count: usize,
) {
    // SAFETY: by the contract
    let (all, rays, hits) = unsafe {
        (&(*built.cast::<Built<P>>()).all, slice_of(rays, count), slice_to_write(hits, count))
    };
    all.closest_all(rays, hits);
}

/// `rtbench_plugin.occluded`. A panic ends the process.
///
/// # Safety
/// As rtbench.h says.
pub(crate) unsafe extern "C" fn occluded<P: Peer<T>, T: Real>(
    built: *mut c_void,
    rays: *const Ray<T>,
    blocked: *mut u8,
    count: usize,
) {
    // SAFETY: by the contract
    let (built, rays, blocked) = unsafe {
        (&*built.cast::<Built<P>>(), slice_of(rays, count), slice_to_write(blocked, count))
    };
    built.opaque.as_ref().unwrap_or(&built.all).occluded_all(rays, blocked);
}

/// # Safety
/// There are that many.
unsafe fn slice_of<'a, T>(first: *const T, count: usize) -> &'a [T] {
    match count {
        0 => &[],
        // SAFETY: by the contract
        _ => unsafe { std::slice::from_raw_parts(first, count) },
    }
}

/// # Safety
/// There is room for that many, and nobody else has it.
unsafe fn slice_to_write<'a, T>(first: *mut T, count: usize) -> &'a mut [MaybeUninit<T>] {
    match count {
        0 => &mut [],
        // SAFETY: by the contract
        _ => unsafe { std::slice::from_raw_parts_mut(first.cast(), count) },
    }
}

/// `rtbench_plugin.stats`.
///
/// # Safety
/// As rtbench.h says.
pub(crate) unsafe extern "C" fn stats<P: Peer<T>, T: Real>(built: *mut c_void, stats: *mut Stats) {
    // SAFETY: by the contract
    let (built, room) = unsafe { (&*built.cast::<Built<P>>(), (*stats).size as usize) };
    let mut known = Stats { bytes: built.bytes, ..Stats::empty() };
    for part in std::iter::once(&built.all).chain(&built.opaque) {
        part.stats(&mut known);
    }
    // an rtbench from before the note has a smaller one
    let bytes = size_of::<Stats>().min(room);
    known.size = bytes as u32;
    // SAFETY: there is room for so many, and nothing of the struct is padding
    unsafe { std::ptr::copy_nonoverlapping((&raw const known).cast::<u8>(), stats.cast(), bytes) };
}

/// `rtbench_plugin.destroy`.
///
/// # Safety
/// As rtbench.h says.
pub(crate) unsafe extern "C" fn destroy<P>(built: *mut c_void) {
    // SAFETY: by the contract: it is of `build`, and nobody asks it any more
    drop(unsafe { Box::from_raw(built.cast::<Built<P>>()) });
}
