//! A run as a function, for programs in Rust.

use accel_core::occluders;
use accel_core::structures::Entry;
use measurement::plan::Plan;
use measurement::record::summary::summarize;
use measurement::record::{RunRecord, warnings};
use measurement::rounds::scene_run::SceneInput;
use measurement::scenes::InstalledScenes;
use measurement::settings::RunSettings;
use measurement::system::clock::{Clock, SystemClock};
use measurement::system::pools::Pools;
use measurement::system::progress::Progress;
use measurement::system::world::World;
use studies::run::conclusions::conclude;

use crate::commands::measuring::{begin, measure_one};
use crate::commands::run_state::{Budget, RowJournal};
use crate::error::Error;
use crate::program;

/// Measures what is asked for over the structures of a registry, in this process, and returns what
/// `rtbench run` would keep. Nothing is printed or written; a wrong answer is a
/// [`Verdict`](measurement::record::Verdict) of its row. Settings for several processes or a part
/// of a run are those of one process and the whole.
///
/// ```no_run
/// use rtbench::accel_core::structures::{REGISTRY, find};
/// use rtbench::measurement::settings::RunSettings;
///
/// let grid = find("uniform-grid").ok_or("there is none")?.defaults();
/// let mut settings = RunSettings::default();
/// settings.scenes.push("teapot".into());
/// settings.measuring.rounds = Some(3);
/// for density in [1, 4, 16] {
///     settings.structures.push(grid.clone().set("density", density)?.label());
/// }
/// for row in &rtbench::measure(REGISTRY, &settings)?.scenes[0].rows {
///     println!("{} {}: {:?}", row.structure, row.settings, row.verdict);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Error`] for settings that name what is not there or are out of range, for the first scene that
/// cannot be loaded or measured, and for threads that cannot be had.
pub fn measure(registry: &[Entry], settings: &RunSettings) -> Result<RunRecord, Error> {
    let settings = RunSettings { processes: 1, shard: None, ..settings.clone() };
    let plan = Plan::new(&settings, registry, occluders::REGISTRY, &InstalledScenes)?;
    let (clock, world) = (SystemClock::default(), program::world());
    let command_line: Vec<String> =
        std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect();
    let mut record = begin(&world, &command_line, &plan);
    let pools = Pools::new(plan.threads)?;
    let equipment = SceneInput {
        pools: &pools,
        clock: &clock,
        world: &world,
        progress: &Progress::new(false, 0, None),
        trials: &[],
        log: &RowJournal::new(None),
        laps: None,
    };
    let budget = Budget::new(&plan, clock.now(), 0);
    for (i, known) in plan.scenes.iter().enumerate() {
        let deadline = budget.deadline(clock.now(), plan.scenes.len() - i);
        record.scenes.push(measure_one(&plan, &**known, &equipment, deadline)?);
    }
    record.summary = summarize(&record.scenes, &record.settings);
    conclude(&mut record);
    record.complete = true;
    record.load[1] = world.load();
    record.peak_rss_bytes = world.peak_rss();
    record.warnings = warnings::of(&record);
    Ok(record)
}
