//! Two levels over a scene of copies: a structure over the boxes of all copies, and one over each
//! object.
//!
//! Papers: S. M. Rubin, T. Whitted, "A 3-Dimensional Representation for Fast Rendering of Complex
//! Scenes", SIGGRAPH 1980 (objects within the spaces of others, rays carried into them); I. Wald,
//! C. Benthin, P. Slusallek, "Distributed Interactive Ray Tracing of Dynamic Scenes", PVG 2003 (two
//! levels of the same structure, the lower ones built once and never again).
//!
//! Deviations: an object's structure stands in the space of its first copy, so that this one's rays
//! need not be carried anywhere. It says which primitives to test; they are tested where they
//! stand, in the world, as by all other structures: answers are theirs to the bit. What copies do
//! not share by rounding, and what carrying a ray adds, is a margin of the boxes. Primitives that
//! are copies of nothing are one more object. A scene without copies is one object. With
//! `update=instances` each rigid part is an object, also one that stands alone, and between frames
//! the upper structure alone is built (`frames.rs`).

mod frames;
mod object;
mod sinks;

use crate::bvh::{self, WideBvh};
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::{Config, Settings};
use crate::params::{ParamSpec, Params, specs};
use crate::primitives::instances::{self, ConfirmedCopy};
use crate::primitives::{Instance, Primitives};
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::sink::{ErasedSink, Sink};
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};
use crate::structures::obvhs::PRESET;
use crate::structures::uniform_grid::{self, UniformGrid};
use crate::update::{Change, INSTANCES, is_by_instances};
use frames::{FirstCopy, Frames, ROOM_FOR_FRAMES};
use object::{Boxes, Copy, Members, Object, margin, padding_of};
use sinks::WorldSink;

const PAPERS: &str = "Rubin, Whitted 1980; Wald, Benthin, Slusallek 2003";

pub static GRID_INFO: StructureInfo = StructureInfo {
    paper: PAPERS,
    deviations: "objects in the space of their first copy; primitives are tested in the world",
    params: &[specs::DENSITY, OF_COPIES, specs::MAX_CELLS, specs::MAX_REFERENCES, INSTANCES],
    variants: &[],
    also_tested: &["", "density=8 top-density=0.5"],
    ..StructureInfo::new(
        "instanced-grid",
        "a grid over copies of objects, which have grids of their own",
    )
};

pub static BVH_INFO: StructureInfo = StructureInfo {
    paper: PAPERS,
    deviations: "objects in the space of their first copy; primitives are tested in the world, one by one",
    params: &[PRESET, INSTANCES],
    variants: &[],
    also_tested: &["", "preset=fastest"],
    ..StructureInfo::new(
        "instanced-bvh",
        "a BVH over copies of objects, which have BVHs of their own",
    )
};

const OF_COPIES: ParamSpec =
    ParamSpec { name: "top-density", summary: "voxels per copy of an object", ..specs::DENSITY };

pub type InstancedGrid<S> = InstancedStructure<S, UniformGrid<S>>;

/// A BVH over BVHs.
pub type InstancedBvh<S> = InstancedStructure<S, WideBvh<S>>;

/// Chooses the structure of both levels.
pub trait Levels<S: Scalar>: Structure<S> {
    /// The settings of the structure over copies, and of those over objects.
    fn settings(params: &Params) -> [Params; 2];
}

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

impl<S: Scalar> Levels<S> for WideBvh<S> {
    fn settings(params: &Params) -> [Params; 2] {
        ["1", "4"].map(|leaf| {
            let own = [(PRESET.name, params.text(PRESET.name)), ("max-leaf", leaf)];
            bvh::INFO.defaults().taken(own)
        })
    }
}

/// A structure over copies of objects that have structures of the same kind.
pub struct InstancedStructure<S: Scalar, T> {
    upper: T,
    copies: Vec<Copy<S>>,
    objects: Vec<Object<T>>,
    /// With `update=instances`: what an update needs beside.
    frames: Option<Frames<S>>,
}

/// Objects that stand several times, of rigid `parts` each that stands alone, and whatever is left,
/// before anything is built.
fn plan<S: Scalar>(
    prims: &dyn Primitives<S>,
    parts: &[Instance],
) -> Vec<(Members, instances::Object)> {
    let mut known = prims.instances().map(|instances| instances.all().to_vec()).unwrap_or_default();
    let mut copies: Vec<u32> =
        known.iter().flat_map(|o| &o.copies).map(|copy| copy.first).collect();
    copies.sort_unstable();
    let alone = parts.iter().filter(|part| copies.binary_search(&part.first).is_err());
    known.extend(alone.map(|part| {
        let copies = vec![ConfirmedCopy { first: part.first, to_first: None }];
        instances::Object { count: part.count, copies }
    }));
    let mut is_copied = vec![false; prims.len()];
    for object in &known {
        for copy in &object.copies {
            is_copied[copy.first as usize..][..object.count as usize].fill(true);
        }
    }
    let is_all = known.is_empty();
    let mut planned: Vec<_> =
        known.into_iter().map(|object| (Members::Consecutive, object)).collect();
    let left: Vec<u32> = (0..prims.len() as u32).filter(|&id| !is_copied[id as usize]).collect();
    if !left.is_empty() {
        let copies = vec![ConfirmedCopy { first: 0, to_first: None }];
        let rest = instances::Object { count: left.len() as u32, copies };
        let members = if is_all { Members::Consecutive } else { Members::List(left) };
        planned.push((members, rest));
    }
    planned
}

impl<S: Scalar, T: Structure<S>> InstancedStructure<S, T> {
    #[inline(never)]
    fn traverse_erased<const COUNTED: bool>(
        &self,
        ray: &Ray<S>,
        query: ErasedSink<'_, S, COUNTED>,
    ) {
        self.upper.traverse(ray, &mut WorldSink::new(&self.copies, &self.objects, ray, query));
    }
}

pub struct LevelsConfig<S: Scalar, T: Structure<S>> {
    levels: [T::Config; 2],
    is_by_instances: bool,
}

impl<S: Scalar, T: Structure<S>> Clone for LevelsConfig<S, T> {
    fn clone(&self) -> Self {
        Self { levels: self.levels.clone(), is_by_instances: self.is_by_instances }
    }
}

impl<S: Scalar, T: Levels<S>> Config for LevelsConfig<S, T> {
    fn of(params: &Params) -> Self {
        let levels = T::settings(params).map(|own| T::Config::of(&own));
        Self { levels, is_by_instances: is_by_instances(params) }
    }
}

impl<S: Scalar, T: Levels<S>> Structure<S> for InstancedStructure<S, T> {
    const DUPLICATES: bool = T::DUPLICATES;

    type Config = LevelsConfig<S, T>;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError> {
        let structure = settings.structure();
        let [over_copies, over_objects] = settings.levels.clone().map(|own| settings.with(own));
        // a mark and a box of each primitive
        settings.fits((1 + size_of::<Aabb<S>>()) as u128 * prims.len() as u128)?;
        let parts = if settings.is_by_instances {
            prims.instances().map(|instances| instances.parts()).unwrap_or_default()
        } else {
            &[]
        };
        let planned = plan(prims, parts);
        let mut frames = (!parts.is_empty()).then(Frames::default);
        let is_whole = matches!(&planned[..], [(_, object)] if object.copies.len() == 1);
        let magnitude = prims.magnitude();
        let padding = padding_of(magnitude);
        let (mut objects, mut copies) = (Vec::new(), Vec::<Copy<S>>::new());
        let mut boxes = Vec::new();
        for (members, instances::Object { count, copies: placed }) in planned {
            for &ConfirmedCopy { first, to_first } in placed.iter().rev() {
                // the first copy comes last, and its boxes stay
                boxes.clear();
                let ids = (0..count).map(|own| members.id(first, own));
                boxes.extend(ids.map(|id| prims.bounds(id)));
                let bounds = boxes.iter().fold(Aabb::empty(), |all, own| all.union(*own));
                copies.push(Copy { bounds, object: objects.len() as u32, first, to_first });
            }
            if !is_whole {
                let own = margin(placed.iter().map(|copy| copy.to_first), magnitude.to_f64());
                let own = if frames.is_some() { own * ROOM_FOR_FRAMES } else { own };
                if let Some(frames) = &mut frames {
                    let first = placed.first().map_or(0, |copy| copy.first);
                    frames.objects.push(FirstCopy::of(&members, first, prims, own));
                }
                let margin = S::from_f64(S::EPSILON.to_f64() * own).greater(padding);
                boxes.iter_mut().for_each(|own| *own = own.expanded(margin));
            }
            let structure = T::build(&Boxes(&boxes), &over_objects)?;
            objects.push(Object { structure, members, count });
        }
        boxes.clear();
        boxes.extend(copies.iter().map(|copy| copy.bounds));
        if let Some(far) = boxes.iter().position(|bounds| !bounds.is_finite()) {
            return Err(BuildError::NonFiniteBounds { structure, id: copies[far].first });
        }
        let upper = T::build(&Boxes(&boxes), &over_copies)?;
        for copy in &mut copies {
            copy.bounds = copy.bounds.expanded(padding);
        }
        if let Some(frames) = &mut frames {
            frames.tight = boxes;
        }
        Ok(Self { upper, copies, objects, frames })
    }

    fn update(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
        moved: &[u32],
    ) -> Result<Change, BuildError> {
        let count = |object: u32| self.objects[object as usize].count;
        let placed =
            self.frames.as_mut().is_some_and(|f| f.place(&mut self.copies, count, prims, moved));
        if placed {
            let [over_copies, _] = settings.levels.clone().map(|own| settings.with(own));
            if let Some(frames) = &self.frames {
                self.upper = T::build(&Boxes(&frames.tight), &over_copies)?;
            }
            return Ok(Change::Updated);
        }
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        if K::COUNTING {
            self.traverse_erased::<true>(ray, ErasedSink::new(sink))
        } else {
            self.traverse_erased::<false>(ray, ErasedSink::new(sink))
        }
    }

    /// N_IN holds all cells of the upper structure. An object's cells count once, however often it
    /// stands.
    fn stats(&self) -> StructureStats {
        let upper = self.upper.stats();
        let mut all = StructureStats {
            inner_cells: upper.inner_cells + upper.cells,
            bytes: upper.bytes
                + size_of_val(self.copies.as_slice()) as u64
                + self.frames.as_ref().map_or(0, Frames::bytes),
            ..StructureStats::default()
        };
        for object in &self.objects {
            let own = object.structure.stats();
            all.inner_cells += own.inner_cells;
            all.cells += own.cells;
            all.empty_cells += own.empty_cells;
            all.references += own.references;
            all.bytes += own.bytes + (object.members.bytes() + size_of::<Object<T>>()) as u64;
        }
        all
    }

    /// Cells of a scene without copies; those of an object with several copies belong to no single
    /// place.
    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let [Object { structure, .. }] = &self.objects[..] else { return Err(IN_NO_PLACE) };
        if self.copies.len() > 1 {
            return Err(IN_NO_PLACE);
        }
        self.upper.cells(&mut |cell| each(Cell::inner(cell.bounds, cell.depth)))?;
        structure.cells(each)
    }
}

const IN_NO_PLACE: NoCells = NoCells("an object's cells stand for all of its copies");
