//! A run as a function, for programs in Rust.

use std::io;

use accel_core::occluders;
use accel_core::structures::Entry;
use measurement::plan::Plan;
use measurement::record::RunRecord;
use measurement::scenes::InstalledScenes;
use measurement::settings::RunSettings;
use measurement::system::clock::SystemClock;

use crate::commands::measuring::measure_quietly;
use crate::context::Context;
use crate::error::Error;
use crate::outputs::Outputs;
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
    let (mut out, mut err) = (io::sink(), io::sink());
    let command_line = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    let mut context = Context {
        command_line: command_line.collect(),
        ..Context::new(registry, &InstalledScenes, &clock, &world, &mut out, &mut err)
    };
    let measured = measure_quietly(&mut context, &plan, Outputs::default())?;
    measured.failures.into_iter().next().map_or(Ok(measured.record), Err)
}
