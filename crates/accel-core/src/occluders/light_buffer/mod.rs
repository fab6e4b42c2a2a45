//! The light buffer: around each point light a cube of directions, whose cells list what a shadow
//! ray from there may meet, sorted by depth.
//!
//! Paper: E. Haines, D. Greenberg, "The Light Buffer: A Shadow-Testing Accelerator", IEEE CG&A
//! 6(9), 1986.
//!
//! Deviations: a face is not one grid but covers only what it shows, and its cells divide into
//! 4 x 4 where lists are long, down to the resolution asked for (a flat cube fails on scenes whose
//! detail is clustered); lists that remain long are left to a structure; records say in which part
//! of a cell a primitive is seen (`cell_part.rs`), so that few are tested; depths are lengths along
//! the axis of the face, which order as distances do. Everything is conservative (see
//! `margins.rs`), so that answers are those of every structure.
//!
//! To be read in this order: `direction_cube.rs`; `projected.rs`, with `footprint.rs` and
//! `facing.rs`; `filling.rs`, whose result is in `face_tree.rs`; `answer.rs`.

mod answer;
mod cell_part;
mod direction_cube;
mod face_tree;
mod facing;
mod filling;
mod footprint;
mod margins;
mod projected;
mod remainder;
#[cfg(test)]
mod tests;

use glam::DVec3;

use self::direction_cube::{Cube, Cubes};
use self::face_tree::{Cells, ID_LIMIT, INDEX_LIMIT};
use self::filling::{BufferConfig, fill_face};
use self::margins::Margins;
use self::projected::{Bodies, FaceCells};
use self::remainder::Remainder;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::historical::bounds_rule::BoundsRule;
use crate::occluders::BoxedOccluder;
use crate::params::config::Settings;
use crate::primitives::{PrimSet, PrimsRef};
use crate::registry::Buildable;
use crate::structure::{BuildError, StructureInfo, bounds_of};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Haines, Greenberg 1986",
    deviations: "faces cover only what they show; cells divide 4 x 4 where lists are long and list \
                 nothing behind what covers them; lists that stay long are left to a BVH",
    params: BufferConfig::PARAMS,
    also_tested: &[
        "resolution=64",
        "resolution=128 cut-off=none",
        "resolution=16 divide=1 longest=2",
        "resolution=512 divide=1000000 longest=1000000",
        "resolution=4096 divide=1 growth=64",
        "resolution=1024 divide=16 longest=64 memory=1",
        "query=batch",
        "query=batch resolution=16 divide=1 longest=2",
    ],
    ..StructureInfo::new(
        "light-buffer",
        "a cube of directions around each light, lists of occluders sorted by depth",
    )
};

/// A built light buffer with its primitives.
struct LightBuffer<'a, S: Scalar, P> {
    prims: &'a P,
    cubes: Cubes<S>,
    cells: Cells<S>,
    /// Answers what the buffer does not.
    remainder: Remainder<'a, S, P>,
    is_batch: bool,
}

/// Builds a light buffer; see [`crate::occluders::Entry::build`].
///
/// # Errors
/// [`BuildError`] when the set cannot be served.
pub fn build<'a, S: Buildable>(
    prims: PrimsRef<'a, S>,
    lights: &[DVec3],
    settings: &Settings<BufferConfig>,
) -> Result<BoxedOccluder<'a, S>, BuildError> {
    Ok(match prims {
        PrimsRef::Watertight(p) => Box::new(LightBuffer::new(p, prims, lights, settings)?),
        PrimsRef::Mixed(p) if p.has_motion() => {
            Box::new(LightBuffer::new(p.in_motion(), prims, lights, settings)?)
        }
        PrimsRef::Mixed(p) => Box::new(LightBuffer::new(p, prims, lights, settings)?),
    })
}

impl<'a, S: Buildable, P: PrimSet<S>> LightBuffer<'a, S, P> {
    fn new(
        prims: &'a P,
        any: PrimsRef<'a, S>,
        lights: &[DVec3],
        settings: &Settings<BufferConfig>,
    ) -> Result<Self, BuildError> {
        let structure = settings.structure();
        if prims.is_empty() {
            return Err(BuildError::NoPrimitives { structure });
        }
        let is_below = |limit, what, needed| {
            let error = BuildError::TooLarge { structure, what, needed, limit };
            if needed < limit { Ok(()) } else { Err(error) }
        };
        is_below(ID_LIMIT, "number of primitives", prims.len() as u128)?;
        bounds_of(prims, BoundsRule::Padded, structure)?;
        let of_lights = lights.iter().fold(0.0, |m: f64, l| m.max(l.abs().max_element()));
        let margins = Margins::new::<S>(prims.magnitude().to_f64().max(of_lights));
        let bodies = Bodies::of(prims, margins.position);
        let mut cells = Cells::new();
        let mut cubes = Cubes::new(prims, &margins);
        for &light in lights {
            let position = Vec3::<S>::from_dvec3(light);
            let before = cells.extent();
            let faces = FaceCells::around(&bodies, position.to_dvec3(), &margins)
                .map(|shown| fill_face(&shown, settings, &margins, &mut cells));
            let needed = cells.cells.len().max(cells.records.len()) as u128;
            is_below(INDEX_LIMIT, "number of cells or references", needed)?;
            if cells.bytes() > settings.memory << 20 {
                cells.cut(before);
                break;
            }
            cubes.all.push(Cube { position, faces });
        }
        cells.cells.shrink_to_fit();
        cells.records.shrink_to_fit();
        let remainder = Remainder::new(prims, any);
        if cells.tally.long > 0 || cubes.all.len() < lights.len() {
            remainder.make()?;
        }
        Ok(Self { prims, cubes, cells, remainder, is_batch: settings.is_batch })
    }
}
