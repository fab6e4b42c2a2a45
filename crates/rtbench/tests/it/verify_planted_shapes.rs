//! The cases of `rtbench verify` about polygons, cones, far intervals, times, copies, glass,
//! lights, frames and crowds: each catches a structure that is wrong on purpose, in f32 and in f64.

use accel_core::occluders;
use accel_core::params::config::Settings;
use accel_core::primitives::{PrimSet, Primitives};
use accel_core::query::sink::Sink;
use accel_core::registry::Buildable;
use accel_core::structure::{
    BatchAnswers, BuildError, RayBatch, Structure, StructureInfo, StructureStats,
};
use accel_core::structures::{Entry, brute_force};
use accel_core::update::{Change, INCREMENTAL};
use accel_core::{Aabb, Ray, Scalar, Vector};
use measurement::plan::rows::Row;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;
use statistics::random::Random;
use studies::verify::catalogue::{Case, Draw, find};
use studies::verify::judge::{Judge, RoundVerdict};
use studies::verify::subject::Subject;

use crate::common::{
    BatchFault, Batched, Folder, answered_by_brute_force, planted, planted_entry, run_with,
};
use crate::occluders::OCCLUDERS;
use crate::verify_planted::{BeginsAtZero, Boxes, HighestId, Lapse, Own, ShrinksBoxes};

/// Loses what only some cases have: a time, tiny primitives, denormal coordinates.
struct LosesOddities;
impl Lapse for LosesOddities {
    fn skips<S: Scalar>(ray: &Ray<S>, own: &Aabb<S>, _: S) -> bool {
        let least_normal = if S::NAME == "f32" { -126.0_f64 } else { -1022.0 }.exp2();
        let is_denormal = |x: S| 0.0 < x.abs().to_f64() && x.abs().to_f64() < least_normal;
        let corners = [own.min, own.max].map(Vector::to_array);
        let size = own.size().to_array().map(S::to_f64).into_iter().fold(0.0, f64::max);
        ray.time > S::ZERO || size < 1e-4 || corners.as_flattened().iter().any(|x| is_denormal(*x))
    }
}

/// Looks no farther than nine tenths of the way to a light.
struct EndsEarly;
impl Lapse for EndsEarly {
    fn skips<S: Scalar>(ray: &Ray<S>, own: &Aabb<S>, _: S) -> bool {
        let end = ray.t_max * S::from_f64(0.9);
        own.clip(ray.origin, ray.direction, ray.t_min, end).is_none()
    }
}

/// In batches, whatever is hit blocks a shadow ray.
struct GlassBlocks;
impl BatchFault for GlassBlocks {
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        let BatchAnswers::Occlusion(blocked) = &mut batch.answers else {
            return answered_by_brute_force(prims, batch);
        };
        for (ray, blocked) in batch.rays.iter().zip(&mut **blocked) {
            let setup = prims.setup(ray);
            let mut ids = 0..prims.len() as u32;
            *blocked = ids.any(|id| prims.intersect(id, ray, &setup, ray.t_max).is_some());
        }
    }
}

/// A list of ids; by several threads it loses some, and an update leaves it as it was.
struct Ids<S: Scalar> {
    boxes: Vec<Aabb<S>>,
}

impl<S: Scalar> Structure<S> for Ids<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        let is_lost = |id: u32| rayon::current_num_threads() == 3 && !id.is_multiple_of(2);
        let padded = |id| {
            let bounds = prims.bounds(id);
            bounds.expanded(S::from_f64(1e-3))
        };
        let nowhere = Aabb::empty();
        let boxes =
            (0..prims.len() as u32).map(|id| if is_lost(id) { nowhere } else { padded(id) });
        Ok(Self { boxes: boxes.collect() })
    }

    fn update(
        &mut self,
        _: &dyn Primitives<S>,
        _: &Settings<()>,
        _: &[u32],
    ) -> Result<Change, BuildError> {
        Ok(Change::Updated)
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        for (id, own) in (0..).zip(&self.boxes) {
            let enters = own.clip(ray.origin, ray.direction, ray.t_min, sink.t_max());
            if enters.is_some() && sink.test(&[id]).is_break() {
                return;
            }
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

static THREADS: StructureInfo = planted("octree", "wrong on purpose");
static STALE: StructureInfo =
    StructureInfo { params: &[INCREMENTAL], ..planted("hashed-grid", "wrong on purpose") };

static FAULTS: &[Entry] = &[
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    planted_entry!("at-zero", Boxes<S, BeginsAtZero>),
    planted_entry!("shrunk", Boxes<S, ShrinksBoxes>),
    planted_entry!("oddities", Boxes<S, LosesOddities>),
    planted_entry!("early", Boxes<S, EndsEarly>),
    planted_entry!("highest", Own<S, HighestId>),
    planted_entry!("glass-blocks", Batched<S, GlassBlocks>),
    // under names that the cases ask for
    planted_entry!("kd-tree", Own<S, HighestId>),
    accel_core::entry!(Ids, THREADS),
    accel_core::entry!(Ids, STALE),
];

#[test]
fn motion_copies_glass_lights_frames_and_crowds_catch_their_faults() {
    catches_each(FAULTY);
}

#[test]
fn polygons_slender_cones_and_far_intervals_catch_their_faults() {
    catches_each(FAULTY_SHAPES);
}

/// In both precisions the structure is wrong, and brute force, where the case asks it, is not.
fn catches_each(faulty: &[(&str, &str, u32)]) {
    for (case, structure, rays) in faulty {
        let folder = Folder::new();
        let check = format!("verify --cases {case} -s {structure},brute-force --rays {rays}");
        let check = format!("{check} -o {}", folder.path());
        let ended = run_with(FAULTS, &InstalledScenes, &SystemClock::default(), &check);
        assert_eq!(ended.code, 4, "{check}: {}{}", ended.out, ended.err);
        for row in folder.csv_of("verify.csv") {
            let of = (row["structure"].as_str(), row["mismatches"].as_str());
            assert_eq!(of.1 == "0", of.0 == "brute-force", "{case} {structure} {row:?}");
        }
    }
}

#[test]
fn an_occluder_that_sees_every_light_is_refuted() {
    fn wrong<S: Buildable>(draw: Draw<S>, occluder: &'static occluders::Entry) -> usize {
        let round = draw(&mut Random::new(1, "lights"), 300).unwrap();
        let row = Row::defaults(occluder).unwrap();
        match Judge::new(&round).unwrap().judge(&Subject::Occluder(row)) {
            RoundVerdict::Asked(wrong, _) => wrong.len(),
            other => panic!("{other:?}"),
        }
    }
    let &Case { single, double, .. } = find("Q10occluders").unwrap().1;
    let [right, bright] = OCCLUDERS else { panic!("two occluders") };
    assert_eq!((wrong(single, right), wrong(double, right)), (0, 0));
    assert!(wrong(single, bright) > 50 && wrong(double, bright) > 50);
}

/// Cases, structures, and rays that are enough.
const FAULTY: &[(&str, &str, u32)] = &[
    ("Q7", "oddities", 200),
    ("Q8", "oddities", 2000),
    ("Q9", "glass-blocks", 300),
    ("Q10", "early", 3000),
    ("Q11", "hashed-grid", 3000),
    ("Q12equal", "kd-tree", 1000),
    ("Q12fan", "highest", 1500),
    ("Q12denormal", "oddities", 500),
    ("K3", "octree", 3000),
];

/// The same of polygons, cones and far rays.
const FAULTY_SHAPES: &[(&str, &str, u32)] = &[
    ("Q1", "shrunk", 500),
    ("Q2", "shrunk", 1000),
    ("Q2slivers", "shrunk", 1000),
    ("Q3", "shrunk", 1000),
    ("Q3flat", "shrunk", 1000),
    ("Q4", "at-zero", 300),
    ("Q6", "shrunk", 500),
];
