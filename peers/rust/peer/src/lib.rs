//! What the peers in Rust share: `rtbench.h` over a type, as `peers/common/peer.h` is for C++.
//!
//! A plugin is a `cdylib` with a type that is a [`Peer`], and a line `peer::export!(ThatType);`. It answers one ray
//! after the other, with a triangle test of its own. A panic in its build is the reason why it is not built;
//! one in a query ends the process, as nothing may unwind through the interface.

#[path = "../../../../crates/plugins/src/abi.rs"]
pub mod abi;
mod built;
mod description;
mod memory;
mod panics;
mod scene;
mod threads;
pub mod trial;
pub mod triangle;

use std::mem::MaybeUninit;

pub use abi::{Hit, Ray, Real, Stats};
pub use description::{
    Described, Description, Kind, Setting, describe, describe_both, locked_version,
};
pub use scene::{Indexed, Scene, Settings, Triangle};

/// What a library does with shadow rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shadows {
    /// It has no query for them: rtbench asks for closest hits.
    None,
    /// Its query passes by triangles that let light pass.
    Filtered,
    /// Its query stops at every triangle: where some let light pass, it is asked of a second structure, over the
    /// others alone, which is built and counted with the first.
    All,
}

/// A structure of a library, over triangles with coordinates of type `T`.
pub trait Peer<T: Real = f32>: Sized + Send + Sync + 'static {
    /// The row and its settings.
    const DESCRIPTION: Description;
    /// Its query for shadow rays.
    const SHADOWS: Shadows;
    /// Whether it wants [`Scene::indexed`].
    const ASKS_INDICES: bool = false;
    /// Whether it has several rays of a call in flight: then it has [`Peer::closest_all`] and [`Peer::occluded_all`]
    /// of its own.
    const ANSWERS_BATCHES: bool = false;
    /// Whether it computes on a device: see `RTBENCH_DEVICE`.
    const ON_DEVICE: bool = false;
    /// The `Cargo.lock` by which it is compiled.
    const LOCK: &'static str = include_str!("../../Cargo.lock");
    /// Whether it builds with rayon: then in a pool of as many threads as it may use.
    const USES_RAYON: bool;

    /// Builds.
    ///
    /// # Errors
    /// The reason why it is not built; a panic is one, too.
    fn build(scene: &Scene<'_, T>) -> Result<Self, String>;

    /// The closest hit of a ray, if there is one.
    fn closest(&self, ray: &Ray<T>) -> Option<Hit<T>>;

    /// Whether something is in the way. Not asked with [`Shadows::None`].
    fn occluded(&self, ray: &Ray<T>) -> bool {
        self.closest(ray).is_some()
    }

    /// Writes the closest hit of each ray; of a miss `t` is not read.
    #[inline(always)]
    fn closest_all(&self, rays: &[Ray<T>], hits: &mut [MaybeUninit<Hit<T>>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            hit.write(self.closest(ray).unwrap_or(Hit::new(ray.t_max, abi::MISS)));
        }
    }

    /// Writes 1 for each ray with something in the way, else 0. Not asked with [`Shadows::None`].
    #[inline(always)]
    fn occluded_all(&self, rays: &[Ray<T>], blocked: &mut [MaybeUninit<u8>]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            blocked.write(u8::from(self.occluded(ray)));
        }
    }

    /// Adds nodes and references; bytes are those that the process has allocated, or what this sets.
    fn stats(&self, stats: &mut Stats);
}

/// Exports the one symbol of a plugin, for a [`Peer`]; with a second one, over `f64`, for both precisions.
#[macro_export]
macro_rules! export {
    ($peer:ty) => {
        $crate::export!(=> $crate::describe::<$peer>());
    };
    ($peer:ty, $peer_f64:ty) => {
        $crate::export!(=> $crate::describe_both::<$peer, $peer_f64>());
    };
    (=> $described:expr) => {
        /// `rtbench_plugin_describe` of rtbench.h.
        #[unsafe(no_mangle)]
        pub extern "C" fn rtbench_plugin_describe() -> *const $crate::abi::Plugin {
            static PLUGIN: std::sync::OnceLock<$crate::Described> = std::sync::OnceLock::new();
            PLUGIN.get_or_init(|| $described).as_ptr()
        }
    };
}
