//! What commands that measure have in common: all scenes of a plan, one after another.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::args::Precision;
use crate::context::{Context, Verbosity};
use crate::error::{Error, FAILURE, SUCCESS, WRONG_HITS};
use crate::export::files::Outputs;
use crate::machine;
use crate::plan::{Plan, Rounds};
use crate::pools::Pools;
use crate::progress::Progress;
use crate::record::{RunRecord, SCHEMA_VERSION, SceneRecord, Settings, Verdict};
use crate::scene_run::{Equipment, run_scene};
use crate::summary::summarize;

/// What came of a plan.
#[derive(Debug)]
pub struct Measured {
    /// Everything about the scenes that could be measured.
    pub record: RunRecord,
    /// Scenes that could not.
    pub failures: usize,
}

/// Measures all scenes of the plan. After each, the outputs are written anew and `show` prints it.
///
/// # Errors
/// [`Error`] for threads that cannot be started, outputs that cannot be written, and those of
/// `show`. A scene that fails is reported and costs the others nothing.
pub fn measure_scenes(
    context: &mut Context<'_>,
    plan: &Plan<'_>,
    outputs: &mut Outputs<'_>,
    mut show: impl FnMut(&mut Context<'_>, &RunRecord, &SceneRecord) -> Result<(), Error>,
) -> Result<Measured, Error> {
    let mut record = begin(context, plan);
    outputs.write(&record, false)?;
    let pools = Pools::new(plan.threads)?;
    let progress = progress(context, plan);
    let start = context.clock.now();
    let mut failures = 0_usize;
    for (i, known) in plan.scenes.iter().enumerate() {
        let name = known.name();
        progress.message(format!("{name}: loading"));
        let deadline = deadline(plan, start, context.clock.now(), plan.scenes.len() - i);
        let equipment = Equipment { pools: &pools, clock: context.clock, progress: &progress };
        let measured = known.load().map_err(Error::from).and_then(|loaded| match plan.precision {
            Precision::F32 => run_scene::<f32>(plan, &loaded, &equipment, deadline),
            Precision::F64 => run_scene::<f64>(plan, &loaded, &equipment, deadline),
        });
        let scene = match measured {
            Ok(scene) => scene,
            Err(error) => {
                // One bad scene does not cost the others.
                failures += 1;
                progress.skip(steps_a_scene(plan));
                progress.suspend(|| {
                    let _ = writeln!(context.err, "error: {error}");
                });
                continue;
            }
        };
        record.scenes.push(scene);
        record.summary = summarize(&record.scenes, plan.seed);
        record.peak_rss_bytes = machine::peak_rss().max(record.peak_rss_bytes);
        outputs.write(&record, false)?;
        if let Some(scene) = record.scenes.last() {
            progress.suspend(|| show(context, &record, scene))?;
        }
    }
    progress.finish();
    outputs.write(&record, true)?;
    Ok(Measured { record, failures })
}

/// 4 when a row is wrong, 1 when something could not be measured, else 0.
pub fn exit_code(measured: &Measured) -> u8 {
    let rows = || measured.record.scenes.iter().flat_map(|s| &s.rows);
    if rows().any(|r| r.verdict == Verdict::Wrong) {
        WRONG_HITS
    } else if measured.failures > 0
        || rows().any(|r| r.verdict == Verdict::NotBuilt && r.known_defect.is_none())
    {
        FAILURE
    } else {
        SUCCESS
    }
}

/// Says what went wrong in a scene.
pub fn warn_of(context: &mut Context<'_>, scene: &SceneRecord) {
    for warning in &scene.warnings {
        context.warn(format_args!("{}: {warning}", scene.name));
    }
    for refused in &scene.oracle.refused {
        context.warn(format_args!("{}: refused as reference: {refused}", scene.name));
    }
}

/// The record before the first scene.
fn begin(context: &Context<'_>, plan: &Plan<'_>) -> RunRecord {
    RunRecord {
        schema_version: SCHEMA_VERSION,
        tool: machine::tool(),
        command_line: context.command_line.clone(),
        started_unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs()),
        machine: machine::machine(),
        compiler: machine::compiler(),
        settings: Settings {
            seed: plan.seed,
            threads: plan.threads,
            precision: match plan.precision {
                Precision::F32 => "f32".into(),
                Precision::F64 => "f64".into(),
            },
            resolution: plan.settings.resolution,
            max_depth: plan.settings.max_depth,
            rays: plan.kinds.iter().map(|k| k.name().to_owned()).collect(),
            reference: plan.rows.get(plan.baseline).map(|r| r.label()).unwrap_or_default(),
            quick: plan.quick,
        },
        scenes: Vec::new(),
        summary: Vec::new(),
        peak_rss_bytes: machine::peak_rss(),
    }
}

/// Steps of the bar for a scene: each row is checked, timed in each round, rendered.
fn steps_a_scene(plan: &Plan<'_>) -> u64 {
    let rounds = match plan.rounds {
        Rounds::Fixed(n) => n,
        Rounds::Budget { at_least, .. } => at_least,
    };
    (plan.rows.len() * (rounds + 2)) as u64
}

fn progress(context: &Context<'_>, plan: &Plan<'_>) -> Progress {
    let visible = context.terminal.stderr && context.verbosity > Verbosity::Quiet;
    let budget = match plan.rounds {
        Rounds::Budget { total, .. } => Some(total),
        Rounds::Fixed(_) => None,
    };
    Progress::new(visible, steps_a_scene(plan) * plan.scenes.len() as u64, budget)
}

/// When the rounds of the next scene end: what is left of the budget, shared by the scenes left.
fn deadline(plan: &Plan<'_>, start: Duration, now: Duration, left: usize) -> Option<Duration> {
    let Rounds::Budget { total, .. } = plan.rounds else { return None };
    let spent = now.saturating_sub(start);
    let share = total.saturating_sub(spent) / u32::try_from(left.max(1)).unwrap_or(u32::MAX);
    Some(now + share)
}
