//! Grids over grids: a uniform grid over the boxes of copies, and one over each object.
//!
//! See [`crate::structures::instanced`] for the levels and [`crate::structures::uniform_grid`] for
//! the grids.

use crate::geometry::scalar::Scalar;
use crate::params::specs;
use crate::params::{ParamSpec, Params};
use crate::structure::StructureInfo;
use crate::structures::instanced::{InstancedStructure, Levels};
use crate::structures::uniform_grid::{self, UniformGrid};
use crate::update::INSTANCES;

const OF_COPIES: ParamSpec =
    ParamSpec { name: "top-density", summary: "voxels per copy of an object", ..specs::DENSITY };

pub static INFO: StructureInfo = StructureInfo {
    paper: "Rubin, Whitted 1980; Wald, Benthin, Slusallek 2003",
    deviations: "objects in the space of their first copy; primitives are tested in the world",
    params: &[specs::DENSITY, OF_COPIES, specs::MAX_CELLS, specs::MAX_REFERENCES, INSTANCES],
    variants: &[],
    also_tested: &["", "density=8 top-density=0.5"],
    ..StructureInfo::new(
        "instanced-grid",
        "a grid over copies of objects, which have grids of their own",
    )
};

pub type InstancedGrid<S> = InstancedStructure<S, UniformGrid<S>>;

impl<S: Scalar> Levels<S> for UniformGrid<S> {
    fn settings(params: &Params) -> [Params; 2] {
        let limits = [specs::MAX_CELLS.name, specs::MAX_REFERENCES.name];
        [OF_COPIES.name, specs::DENSITY.name].map(|density| {
            let own = limits.map(|name| (name, params.text(name)));
            let own = own.into_iter().chain([(specs::DENSITY.name, params.text(density))]);
            uniform_grid::INFO.defaults().taken(own)
        })
    }
}
