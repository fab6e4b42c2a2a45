//! What is built over.

use std::ffi::CStr;

use crate::{Peer, Real, Setting, abi};

/// A triangle: the coordinates of its corners.
pub type Triangle<T = f32> = [[T; 3]; 3];

/// What is built over. It is gone after the build.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a, T = f32> {
    /// At least one.
    pub triangles: &'a [Triangle<T>],
    /// A byte for each, not 0 where shadow rays pass; none where they pass nowhere.
    pub transmissive: Option<&'a [u8]>,
    /// The same triangles with each vertex once, for peers that ask for them.
    pub indexed: Option<Indexed<'a, T>>,
    /// How many threads the build may use.
    pub threads: usize,
    /// What the user says.
    pub settings: Settings<'a>,
}

/// Triangles as vertices and indices.
#[derive(Debug, Clone, Copy)]
pub struct Indexed<'a, T = f32> {
    /// Each once.
    pub vertices: &'a [[T; 3]],
    /// Three of them for each triangle.
    pub triangles: &'a [[u32; 3]],
}

/// The value of each setting.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    described: &'static [Setting],
    values: &'a [&'a str],
}

impl Settings<'_> {
    /// The word, or the number as text.
    ///
    /// # Panics
    /// If there is no such setting.
    pub fn text(&self, name: &str) -> &str {
        let at = self.described.iter().position(|setting| setting.name == name);
        at.and_then(|at| self.values.get(at))
            .unwrap_or_else(|| panic!("there is no setting {name}"))
    }

    /// The number.
    ///
    /// # Panics
    /// If there is no such setting, or it is none.
    pub fn integer(&self, name: &str) -> usize {
        self.text(name).parse().unwrap_or_else(|_| panic!("setting {name} is no whole number"))
    }
}

impl<T: Real> Scene<'_, T> {
    /// Whether shadow rays pass a triangle.
    pub fn is_transmissive(&self, id: usize) -> bool {
        self.transmissive.is_some_and(|flags| flags[id] != 0)
    }

    /// Reads what rtbench hands over, and does something with it.
    ///
    /// # Safety
    /// All that the scene points to is as rtbench.h says.
    ///
    /// # Errors
    /// Those of `f`, or that the scene is of an rtbench from before indices.
    pub(crate) unsafe fn read<P: Peer<T>, R>(
        scene: &abi::Scene<T>,
        f: impl FnOnce(&Scene<'_, T>) -> Result<R, String>,
    ) -> Result<R, String> {
        let described = P::DESCRIPTION.settings;
        let count = scene.triangles as usize;
        let has_indices =
            scene.size as usize >= size_of::<abi::Scene<T>>() && !scene.indices.is_null();
        if P::ASKS_INDICES && !has_indices {
            return Err("this rtbench hands over no indices".into());
        }
        // SAFETY: by the contract: as many triangles, flags and values as are said
        let (triangles, transmissive, values) = unsafe {
            (
                std::slice::from_raw_parts(scene.positions.cast::<Triangle<T>>(), count),
                (!scene.transmissive.is_null())
                    .then(|| std::slice::from_raw_parts(scene.transmissive, count)),
                (0..described.len()).map(|i| CStr::from_ptr(*scene.settings.add(i))),
            )
        };
        let values: Result<Vec<&str>, _> = values.map(CStr::to_str).collect();
        let values = values.map_err(|_| "a setting is not UTF-8")?;
        let indexed = has_indices.then(|| Indexed {
            // SAFETY: likewise
            vertices: unsafe {
                std::slice::from_raw_parts(scene.vertices.cast(), scene.vertex_count as usize)
            },
            // SAFETY: likewise
            triangles: unsafe { std::slice::from_raw_parts(scene.indices.cast(), count) },
        });
        f(&Scene {
            triangles,
            transmissive,
            indexed,
            threads: (scene.threads as usize).max(1),
            settings: Settings { described, values: &values },
        })
    }
}
