//! A scene that moves, frame by frame: the plan of `rtbench animate`.
//!
//! In each frame every row is updated (as its setting `update` says: built anew, refitted, changed
//! where something moved, or placed anew) and asked the same rays, in a seeded random order of
//! rows. Rounds are several structures of the same row, each taken from frame to frame by itself,
//! so that a frame is loaded and its right answers are found once. All answers of all frames are
//! checked.

pub mod measure;
pub mod quality;
pub mod record;
pub mod report;
pub mod verdict;

use accel_core::params::ParamKind;
use accel_core::structures::Entry;
use accel_core::update;
use measurement::plan::Plan;
use measurement::plan::error::PlanError;
use measurement::plan::rows::select;
use measurement::settings::MeasuringSettings;

/// Width and height of the image, unless it is said: of a quick run, and of another.
const SIZE: [u32; 2] = [48, 256];
const ROUNDS: [u32; 2] = [1, 3];
/// The rays asked for when none are named.
const RAYS: [&str; 2] = ["primary", "shadow"];
/// Tests of the oracle in a frame, at most: there are many frames.
const ORACLE_TESTS: u64 = 40_000_000;

#[derive(Debug)]
pub struct Animate<'r> {
    pub scene: String,
    pub frames: [u32; 2],
    /// The rows, and how they are measured; without scenes.
    pub plan: Plan<'r>,
    /// Structures of a row, each updated and timed.
    pub rounds: usize,
    /// Numbers of threads, each measured: one, and as many as are asked for.
    pub threads: Vec<usize>,
}

impl<'r> Animate<'r> {
    /// Validates what is asked for of the scene of that name, which has so many frames: the first
    /// and the last of them, or all, and structures, each with its settings if any; none means each
    /// at its defaults and with each of its updates.
    pub fn new(
        frames: Option<[u32; 2]>,
        structures: &[String],
        mut measuring: MeasuringSettings,
        (scene, count): (&str, u32),
        registry: &'r [Entry],
    ) -> Result<Self, PlanError> {
        let [first, last] = frames.unwrap_or([0, count.saturating_sub(1)]);
        if first > last || last >= count {
            return Err(PlanError::Invalid(format!(
                "--frames {first}..{last}: {scene} has {count} frames, numbered from 0"
            )));
        }
        let pick = |of: [u32; 2]| if measuring.quick { of[0] } else { of[1] };
        let rounds = measuring.rounds.unwrap_or(pick(ROUNDS));
        measuring.size.get_or_insert(pick(SIZE));
        measuring.rounds = Some(rounds);
        if measuring.rays.is_empty() {
            measuring.rays = RAYS.map(str::to_owned).into();
        }
        let structures = if structures.is_empty() { &all_updates(registry) } else { structures };
        let rows = select(registry, structures, &[])?;
        let mut plan = Plan::over(Vec::new(), rows, 0, &measuring, registry)?;
        plan.limits.oracle_tests = plan.limits.oracle_tests.min(ORACLE_TESTS);
        let mut threads = vec![1, plan.threads];
        threads.dedup();
        let (scene, rounds) = (scene.into(), rounds as usize);
        Ok(Self { scene, frames: [first, last], plan, rounds, threads })
    }
}

/// Every structure that is not too slow, at its defaults and with each other way to update it.
fn all_updates(registry: &[Entry]) -> Vec<String> {
    let rows = registry.iter().filter(|entry| !entry.info.sampled).flat_map(|entry| {
        let name = entry.info.name;
        let own = entry.info.params.iter().find(|spec| spec.name == update::REFIT.name);
        let ways = match own.map(|spec| &spec.kind) {
            Some(ParamKind::Choice(ways)) => ways.iter().skip(1).copied().collect(),
            _ => Vec::new(),
        };
        let ways = ways.into_iter().map(move |way| format!("{name}:update={way}"));
        // what is put off until rays come is another way to have less to do
        let lazy = entry.info.variants.iter().filter(|variant| variant.contains("build=lazy"));
        let lazy = lazy.map(move |variant| format!("{name} {variant}"));
        std::iter::once(name.to_owned()).chain(ways).chain(lazy)
    });
    rows.collect()
}
