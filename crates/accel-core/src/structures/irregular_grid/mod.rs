//! An irregular grid: a coarse grid whose crowded cells are divided, with boxes of cells grown over
//! neighbours, so that a ray crosses what is empty in one step.
//!
//! Paper: A. Perard-Gayot, J. Kalojanov, P. Slusallek, "GPU Ray Tracing using Irregular Grids",
//! Computer Graphics Forum 36(2), Eurographics 2017.
//!
//! Deviations: cells are divided until lists are short or it no longer pays, by 1 to 8 along each
//! axis, where the paper gives every cell of the top grid one resolution; cells are not merged
//! before they grow; equal lists are stored once; a step never goes back along any axis, so that
//! rounding cannot trap a ray; CPU, one thread.
//!
//! A step: find the cell of a lattice point (`subdivide.rs`), test its list, leave its grown box
//! (`expand.rs`), go on at the lattice point there. Points are off by a few ulps of the scene, lists
//! have what lies within the padding of the box of their cell, which is more.

mod batch;
mod course;
mod empty_boxes;
mod expand;
mod lattice;
mod lists;
mod overlap;
mod subdivide;
mod voxels;

use glam::DVec3;

use super::{BuildError, Shape, Structure, StructureInfo, no_defect, specs};
use crate::bounds_rule::{BoundsOf, BoundsRule};
use crate::cell_overlap;
use crate::mailbox;
use crate::params::{ParamKind, ParamSpec, Params};
use crate::primitives::PrimSet;
use crate::ray::{Hit, Ray};
use crate::resolution::{ResolutionInput, ResolutionRule, resolve};
use crate::scalar::{Scalar, Vector};
use crate::sink::Sink;
use course::{Course, Place};
use lattice::{Division, Lattice};
use lists::Lists;
use subdivide::{Cells, DIVIDED, FIRST_PART, Settings, Source, TooLarge, subdivide};
use voxels::{Voxel, Voxels};

/// Registry line.
pub static INFO: StructureInfo = StructureInfo {
    name: "irregular-grid",
    summary: "coarse grid, crowded cells divided, boxes of cells grown over their neighbours",
    paper: "Perard-Gayot, Kalojanov, Slusallek 2017",
    deviations: "recursive division by cost, no merging, equal lists shared, CPU",
    params: &[
        ParamSpec {
            name: "build",
            summary: "quality divides further and lets boxes grow over more neighbours",
            default: "quality",
            kind: ParamKind::Choice(&["fast", "quality"]),
        },
        ParamSpec {
            name: "top-density",
            summary: "cells of the coarse grid wanted per primitive",
            default: "0.12",
            kind: ParamKind::Real { min: 1e-6, max: 1e3 },
        },
        ParamSpec {
            name: "longest-list",
            summary: "cells with no more primitives are not divided",
            default: "16",
            kind: ParamKind::Integer { min: 1, max: 1 << 20 },
        },
        ParamSpec {
            name: "step-cost",
            summary: "what a step costs, in tests of a primitive",
            default: "3",
            kind: ParamKind::Real { min: 0.0, max: 1e3 },
        },
        ParamSpec {
            name: "query",
            summary: "batch keeps 16 rays of a batch on their way at once and tests 8 triangles at \
                      a time; sets of other primitives are walked one ray after the other",
            default: "one",
            kind: ParamKind::Choice(&["one", "batch"]),
        },
        specs::MAX_REFERENCES,
        mailbox::PARAM,
        mailbox::SLOTS_PARAM,
    ],
    variants: &[""],
    also_tested: &[
        "build=fast",
        "query=batch",
        "top-density=4",
        "top-density=0.001 step-cost=0 longest-list=4",
        "build=fast longest-list=8 step-cost=1",
        "mailbox=hash",
        "mailbox=hash query=batch",
        "build=fast query=batch top-density=0.01 longest-list=5",
    ],
    known_defect: no_defect,
    sampled: false,
};

/// What the two builds differ in.
struct Effort {
    density: f64,
    most_neighbours: usize,
}

const FAST: Effort = Effort { density: 0.125, most_neighbours: 4 };
const QUALITY: Effort = Effort { density: 0.25, most_neighbours: 64 };

/// How to find the cell of a lattice point.
#[derive(Debug, Clone, Copy)]
struct Finder {
    top: [u32; 3],
    levels: [u32; 3],
}

impl Finder {
    fn resolution(&self) -> [u32; 3] {
        std::array::from_fn(|k| self.top[k] << self.levels[k])
    }

    /// The number of the cell at `p`.
    #[inline(always)]
    fn cell_at(&self, entries: &[u32], p: [u32; 3]) -> u32 {
        let mut shift = self.levels;
        let [x, y, z] = [p[0] >> shift[0], p[1] >> shift[1], p[2] >> shift[2]];
        let mut entry = entries[(x + self.top[0] * (y + self.top[1] * z)) as usize];
        while entry & DIVIDED != 0 {
            let logs = [entry >> 29 & 3, entry >> 27 & 3, entry >> 25 & 3];
            let mut part = [0; 3];
            for k in 0..3 {
                shift[k] -= logs[k];
                part[k] = p[k] >> shift[k] & ((1 << logs[k]) - 1);
            }
            let part = part[0] | part[1] << logs[0] | part[2] << (logs[0] + logs[1]);
            entry = entries[((entry & FIRST_PART) + part) as usize];
        }
        entry
    }
}

/// The structure.
pub struct IrregularGrid<S: Scalar> {
    voxels: Voxels,
    lists: Lists<S>,
    place: Place<S>,
    /// Several rays of a batch are on their way at once.
    is_batch: bool,
    shape: Shape,
}

impl<S: Scalar> Structure<S> for IrregularGrid<S> {
    fn build<P: PrimSet<S>>(prims: &P, params: &Params) -> Result<Self, BuildError> {
        let structure = params.structure();
        let boxes = BoundsOf::new(prims, BoundsRule::Padded)
            .map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
        let effort = if params.text("build") == "fast" { FAST } else { QUALITY };
        let input = ResolutionInput {
            bounds: boxes.scene(),
            primitives: prims.len(),
            density: params.real("top-density"),
            mean_longest_side: 0.0,
            max_cells: u64::from(FIRST_PART) / 8,
            smallest_cell: boxes.smallest_cell(),
        };
        let too_large = |what, needed: u128, limit: u128| BuildError::TooLarge {
            structure,
            what,
            needed,
            limit,
        };
        let top = resolve(ResolutionRule::Density, &input)
            .map_err(|needed| too_large("number of cells", needed, input.max_cells.into()))?;
        let lattice = Lattice::new(&boxes.scene(), top, boxes.smallest_cell());
        let settings = Settings {
            longest_list: params.integer("longest-list") as usize,
            density: effort.density,
            step_cost: params.real("step-cost"),
            max_references: params.integer("max-references"),
        };
        let mut cells = subdivide(&lattice, &Padded(&boxes), settings).map_err(
            |TooLarge { what, needed, limit }| too_large(what, needed.into(), limit.into()),
        )?;
        let finder = Finder { top: lattice.top, levels: lattice.levels };
        expand::expand(&mut cells, &finder, effort.most_neighbours);
        let empty = cells.cells.iter().filter(|cell| cell.list == 0).count();
        let mut shape = Shape {
            inner_cells: cells.divided,
            cells: cells.cells.len() as u64,
            empty_cells: empty as u64,
            references: cells.references,
            ..Shape::default()
        };
        let lists = Lists::of(&mut cells, prims);
        let voxels = voxels_of(&cells, &lattice);
        shape.bytes = (size_of_val(voxels.records.as_slice()) + lists.bytes()) as u64;
        let a_length = lattice.side.map(|side| S::from_f64(1.0 / side));
        Ok(Self {
            voxels,
            lists,
            place: Place::new(boxes.scene().min, a_length, finder.resolution()),
            is_batch: params.text("query") == "batch",
            shape,
        })
    }

    #[inline(always)]
    fn walk<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let Some((course, mut at)) = Course::of(ray, &self.place) else { return };
        loop {
            let voxel = self.voxels.at(at);
            sink.elementary_step(voxel.list() == 0);
            if voxel.list() != 0 && self.lists.test(voxel.list(), sink).is_break() {
                return;
            }
            let exit = course.exit(&voxel);
            // not finite: it leaves through no face, or the planes' parameters overflow
            if sink.t_max() < exit.t
                || !exit.t.is_finite()
                || !course.advance(&mut at, &exit, &self.place)
            {
                return;
            }
        }
    }

    fn closest_batch<P: PrimSet<S>>(
        &self,
        _prims: &P,
        rays: &[Ray<S>],
        reach: S,
        hits: &mut [Hit<S>],
    ) -> bool {
        if let Lists::Blocks(blocks) = &self.lists {
            self.trace_closest(blocks, rays, reach, hits);
            return true;
        }
        false
    }

    fn occlusion_batch<P: PrimSet<S>>(
        &self,
        prims: &P,
        rays: &[Ray<S>],
        reach: S,
        blocked: &mut [bool],
    ) -> bool {
        if let Lists::Blocks(blocks) = &self.lists {
            self.trace_occlusions(blocks, prims, rays, reach, blocked);
            return true;
        }
        false
    }

    fn shape(&self) -> Shape {
        self.shape
    }
}

/// The records of all parts.
fn voxels_of(cells: &Cells, lattice: &Lattice) -> Voxels {
    let mut records = vec![Voxel::NOTHING; cells.entries.len()];
    let whole = Division { first: [0; 3], shift: lattice.levels, parts: lattice.top };
    let mut waiting = vec![(0, whole)];
    while let Some((begin, division)) = waiting.pop() {
        for part in 0..division.count() {
            let entry = cells.entries[begin + part];
            records[begin + part] = if entry & DIVIDED == 0 {
                let cell = &cells.cells[entry as usize];
                Voxel::leaf(cell.first, cell.last.map(|x| x + 1), cell.list)
            } else {
                let first = division.part(part);
                let logs = [entry >> 29 & 3, entry >> 27 & 3, entry >> 25 & 3];
                let shift = std::array::from_fn(|k| division.shift[k] - logs[k]);
                let number = entry & FIRST_PART;
                waiting.push((
                    number as usize,
                    Division { first, shift, parts: logs.map(|log| 1 << log) },
                ));
                Voxel::divided(first, shift, logs, number)
            };
        }
    }
    Voxels::new(records, lattice.top, lattice.levels)
}

/// The primitives with padded boxes.
struct Padded<'a, S: Scalar, P: PrimSet<S>>(&'a BoundsOf<'a, S, P>);

impl<S: Scalar, P: PrimSet<S>> Source for Padded<'_, S, P> {
    fn len(&self) -> u32 {
        self.0.prims().len() as u32
    }

    fn bounds(&self, id: u32) -> (DVec3, DVec3) {
        let b = self.0.of(id);
        (b.min.to_dvec3(), b.max.to_dvec3())
    }

    fn triangle(&self, id: u32) -> Option<[DVec3; 3]> {
        self.0.prims().corners(id).map(|corners| corners.map(|p| p.to_dvec3()))
    }

    fn overlaps(&self, id: u32, low: DVec3, high: DVec3) -> bool {
        cell_overlap::overlaps(self.0.prims(), id, (low, high), &mut Vec::new())
    }

    fn margin(&self) -> f64 {
        self.0.padding().to_f64()
    }
}
