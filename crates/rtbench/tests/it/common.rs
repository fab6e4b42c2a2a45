//! A run without a process: captured outputs, a registry and a clock of the test's choice.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

use accel_core::geometry::far_ray::{Parameters, PlacedRay, place};
use accel_core::occluders;
use accel_core::params::config::Settings;
use accel_core::primitives::{PrimSet, Primitives};
use accel_core::query::counters::Counters;
use accel_core::query::kernel::ListBlocks;
use accel_core::query::sink::Sink;
use accel_core::structure::{
    BatchAnswers, Batches, BuildError, RayBatch, Structure, StructureInfo, StructureStats,
};
use accel_core::structures::{Entry, REGISTRY, brute_force, find, obvhs};
use accel_core::{Hit, Ray, Scalar};
use measurement::record::{RowRecord, RunRecord};
use measurement::scenes::{InstalledScenes, SceneSource};
use measurement::system::clock::{Clock, SteppingClock, SystemClock};
use measurement::system::world::World;
use rtbench::context::{Context, Terminal};

/// Brute force that forgets the first primitive, which the camera sees in the scenes of these
/// tests: the wrong structure that must be found out. (One that no ray meets could not be.)
pub struct Dropper<S> {
    ids: Vec<u32>,
    scalar: std::marker::PhantomData<S>,
}

impl<S: Scalar> Dropper<S> {
    /// One that forgets it, or nothing.
    pub fn of(prims: &dyn Primitives<S>, is_right: bool) -> Self {
        let first = u32::from(!is_right);
        Self { ids: (first..prims.len() as u32).collect(), scalar: std::marker::PhantomData }
    }
}

impl<S: Scalar> Structure<S> for Dropper<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        Ok(Self::of(prims, false))
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        sink.elementary_step(false);
        let _ = sink.test(&self.ids);
    }

    fn stats(&self) -> StructureStats {
        StructureStats { cells: 1, references: self.ids.len() as u64, ..StructureStats::default() }
    }
}

/// Closest hits of a batch, one ray and primitive after the other.
pub fn by_brute_force<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    rays: &[Ray<S>],
    reach: S,
    hits: &mut [Hit<S>],
) {
    for (ray, hit) in rays.iter().zip(hits) {
        let miss = Hit { t: ray.t_max, ..Hit::NONE };
        let (near, parameters) = match place(ray, reach) {
            PlacedRay::Near => (*ray, Parameters::SAME),
            PlacedRay::Moved(near, parameters) => (near, parameters),
            PlacedRay::Nowhere => {
                *hit = miss;
                continue;
            }
        };
        let setup = prims.setup(&near);
        let mut best = Hit { t: near.t_max, ..Hit::NONE };
        for id in 0..prims.len() as u32 {
            if let Some(t) = prims.intersect(id, &near, &setup, best.t)
                && (t < best.t || id < best.id)
            {
                best = Hit { t, id };
            }
        }
        *hit = if best.is_hit() { Hit { t: parameters.restored(best.t), ..best } } else { miss };
    }
}

/// A batch by brute force, where all primitives are opaque.
pub fn answered_by_brute_force<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
    let RayBatch { rays, reach, ref mut answers } = *batch;
    match answers {
        BatchAnswers::Closest(hits) => by_brute_force(prims, rays, reach, hits),
        BatchAnswers::Occlusion(blocked) => {
            let mut hits = vec![Hit::NONE; rays.len()];
            by_brute_force(prims, rays, reach, &mut hits);
            blocked.iter_mut().zip(hits).for_each(|(blocked, hit)| *blocked = hit.is_hit());
        }
    }
}

/// All files below a folder, in no order; of a file that file alone.
pub fn files_below(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| files_below(&path)).collect()
}

/// Fault planted into the batches of a structure.
pub trait BatchFault: Send + Sync + 'static {
    const BATCHES: Batches = Batches::Together;

    /// Answers the rays of a batch.
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>);
}

/// Brute force, right ray by ray, whose batches have a fault; of each it counts a step.
pub struct Batched<S, F> {
    ids: Vec<u32>,
    of: std::marker::PhantomData<(S, F)>,
}

impl<S: Scalar, F: BatchFault> Structure<S> for Batched<S, F> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        Ok(Self { ids: (0..prims.len() as u32).collect(), of: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        sink.elementary_step(false);
        let _ = sink.test(&self.ids);
    }

    fn batches<P: PrimSet<S>>(&self, _: &P, _: Option<&ListBlocks<S>>) -> Batches {
        F::BATCHES
    }

    fn answer_batch<P: PrimSet<S>, C: Counters>(
        &self,
        prims: &P,
        _: Option<&ListBlocks<S>>,
        mut batch: RayBatch<'_, S>,
    ) -> C {
        F::answer(prims, &mut batch);
        let mut work = C::default();
        work.inner_step();
        work
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

/// Says that shadow rays are answered, and they are not; with `ALL` nor are closest hits.
pub struct Silent<const ALL: bool>;

impl<const ALL: bool> BatchFault for Silent<ALL> {
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        match &mut batch.answers {
            BatchAnswers::Closest(_) if !ALL => answered_by_brute_force(prims, batch),
            BatchAnswers::Closest(_) | BatchAnswers::Occlusion(_) => {}
        }
    }
}

/// It writes no answer.
pub type SilentAll<S> = Batched<S, Silent<true>>;
/// It writes no answer to a shadow ray.
pub type SilentShadows<S> = Batched<S, Silent<false>>;

/// Registry line of [`SilentAll`].
pub static SILENT: StructureInfo = planted("silent", "answers nothing");
/// Registry line of [`SilentShadows`].
pub static SILENT_SHADOWS: StructureInfo = planted("silent-shadows", "answers no shadow ray");

/// Registry line of a structure made for a test.
pub const fn planted(name: &'static str, summary: &'static str) -> StructureInfo {
    StructureInfo::new(name, summary)
}

const INFO: StructureInfo = planted("dropper", "forgets a primitive");
static DROPPER: StructureInfo = INFO;
static SHIPPED: StructureInfo =
    StructureInfo { known_defect: |_| Some("forgets on purpose"), ..INFO };

/// An entry that is wrong on purpose, `planted_entry!("at-zero", Boxes<S, BeginsAtZero>)`; batches
/// of [`Batched`] are compiled, and so asked, in f64 too.
macro_rules! planted_entry {
    ($name:literal, Batched<S, $fault:ty>) => {
        crate::common::planted_entry!($name, Batched, $fault, prepare_f32, true)
    };
    ($name:literal, $structure:ident<S, $fault:ty>) => {
        crate::common::planted_entry!($name, $structure, $fault, prepare_f32, false)
    };
    ($name:literal, $structure:ident, $fault:ty, $prepare:ident, $in_f64:literal) => {{
        type Wrong<S> = $structure<S, $fault>;
        static WRONG: accel_core::structure::StructureInfo =
            crate::common::planted($name, "wrong on purpose");
        accel_core::entry!(Wrong, WRONG, $prepare, $in_f64)
    }};
}
pub(crate) use planted_entry;

/// Real structures and the wrong one. The real ones are taken from the registry as the program
/// runs: named in a constant they would be compiled again with the tests, and not optimised.
pub static PLANTED: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let real = ["brute-force", "uniform-grid", "wide-bvh", "obvhs-bvh2", "obvhs-cwbvh"];
    let real = real.iter().filter_map(|name| find(name).copied());
    real.chain([accel_core::entry!(crate::common::Dropper, DROPPER)]).collect()
});

/// The wrong one, its defect declared.
pub static DECLARED: &[Entry] = &[
    accel_core::entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO),
    accel_core::entry!(crate::common::Dropper, SHIPPED),
];

/// The wrong one first, and brute force.
pub static WRONG_FIRST: &[Entry] = &[
    accel_core::entry!(crate::common::Dropper, DROPPER),
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
];

/// Nothing but the wrong one.
pub static WRONG_ONLY: &[Entry] = &[accel_core::entry!(crate::common::Dropper, DROPPER)];

/// Exit code and output of a run.
pub struct Ended {
    pub code: u8,
    pub out: String,
    pub err: String,
}

/// Runs `rtbench` with the arguments, split at spaces, over that registry.
pub fn run_with(
    registry: &[Entry],
    scenes: &dyn SceneSource,
    clock: &dyn Clock,
    arguments: &str,
) -> Ended {
    run_over(registry, occluders::REGISTRY, scenes, clock, arguments)
}

/// The same with occluders of the test's choice.
pub fn run_over(
    registry: &[Entry],
    occluders: &[occluders::Entry],
    scenes: &dyn SceneSource,
    clock: &dyn Clock,
    arguments: &str,
) -> Ended {
    let world = World::fixed();
    run_in_world(registry, occluders, scenes, clock, &world, arguments)
}

/// The same in a world of the test's choice.
pub fn run_in_world(
    registry: &[Entry],
    occluders: &[occluders::Entry],
    scenes: &dyn SceneSource,
    clock: &dyn Clock,
    world: &World,
    arguments: &str,
) -> Ended {
    let terminal = Terminal { columns: Some(100), ..Terminal::default() };
    run_in_terminal(registry, occluders, scenes, clock, world, terminal, arguments)
}

/// The same in lines of so many characters, with the real registry and a clock on which every
/// interval is a millisecond.
pub fn run_within(width: usize, arguments: &str) -> Ended {
    let clock = SteppingClock::new(Duration::from_millis(1));
    let terminal = Terminal { found_width: Some(width), ..Terminal::default() };
    let world = World::fixed();
    let occluders = occluders::REGISTRY;
    run_in_terminal(REGISTRY, occluders, &InstalledScenes, &clock, &world, terminal, arguments)
}

fn run_in_terminal(
    registry: &[Entry],
    occluders: &[occluders::Entry],
    scenes: &dyn SceneSource,
    clock: &dyn Clock,
    world: &World,
    terminal: Terminal,
    arguments: &str,
) -> Ended {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let mut context = Context {
        occluders,
        terminal,
        ..Context::new(registry, scenes, clock, world, &mut out, &mut err)
    };
    let arguments = std::iter::once("rtbench").chain(arguments.split_whitespace());
    let code = rtbench::run(&mut context, arguments);
    let text = |bytes| String::from_utf8(bytes).expect("outputs are UTF-8");
    Ended { code, out: text(out), err: text(err) }
}

/// The same over the real registry (with the wrong structure beside it) and a real clock.
pub fn run(arguments: &str) -> Ended {
    run_with(&PLANTED, &InstalledScenes, &SystemClock::default(), arguments)
}

/// The same with a clock on which every interval is a millisecond.
pub fn run_stepping(arguments: &str) -> Ended {
    let clock = SteppingClock::new(Duration::from_millis(1));
    run_with(&PLANTED, &InstalledScenes, &clock, arguments)
}

/// A folder for outputs, and the record that a run left there.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self) -> String {
        self.0.path().to_str().expect("a path in UTF-8").to_owned()
    }

    pub fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.path().join(name)).expect("an output file")
    }

    pub fn record(&self) -> RunRecord {
        serde_json::from_str(&self.text("results.json")).expect("JSON that parses back")
    }

    pub fn csv(&self) -> Vec<std::collections::HashMap<String, String>> {
        self.csv_of("results.csv")
    }

    pub fn csv_of(&self, name: &str) -> Vec<std::collections::HashMap<String, String>> {
        csv::Reader::from_reader(self.text(name).as_bytes())
            .deserialize()
            .collect::<Result<_, _>>()
            .expect("CSV that parses back")
    }
}

/// The row of that label in the only scene.
pub fn row<'a>(record: &'a RunRecord, label: &str) -> &'a RowRecord {
    let rows = &record.scenes.first().expect("a scene").rows;
    rows.iter().find(|r| r.label() == label).expect("the row")
}
