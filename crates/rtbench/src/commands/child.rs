//! Child processes of `rtbench check`: they read a record from standard input and answer in JSON on
//! standard output. Also those of `rtbench sweep --sizes`, which need no record (see
//! `trial_build`), and of plugin rows (see [`plugins::serve`]).

use std::io::{Read, Write};

use crate::args::{ChildAction, ChildArgs, TrialArgs};
use crate::commands::accuracy;
use crate::commands::measuring::{measure_one, measure_quietly};
use crate::commands::run_state::RowJournal;
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS};
use crate::gate::contest::Lap;
use crate::outputs::Outputs;
use crate::replan;
use accel_core::registry::Buildable;
use measurement::callgrind::counted::count_all;
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::{self, MeasuredRow};
use measurement::plan::strides::FixedStrides;
use measurement::plan::{OneProcess, Plan};
use measurement::record::{RunRecord, Sample};
use measurement::rounds::scene_run::{SceneInput, light_positions};
use measurement::rounds::scope::Laps;
use measurement::rounds::trial::Event;
use measurement::scenes::LoadedScene;
use measurement::settings::Precision;
use measurement::system::pools::{self, Pools};
use measurement::system::progress::Progress;
use measurement::system::{machine, memory};
use presentation::json::FormatError;
use renderer::Geometry;
use serde::de::DeserializeOwned;

/// With few checks: the fraction of the usual rays that is checked, one in this many.
const LIGHTLY: usize = 16;

fn read_request<T: DeserializeOwned>() -> Result<T, Error> {
    let mut text = Vec::new();
    std::io::stdin().lock().read_to_end(&mut text)?;
    Ok(serde_json::from_slice(&text).map_err(FormatError::from)?)
}

pub fn run(context: &mut Context<'_>, args: &ChildArgs) -> Result<u8, Error> {
    let record = read_request::<RunRecord>;
    use ChildAction::{Accuracy, Laps, Measure};
    let times = matches!(args.action, Measure { .. } | Laps | Accuracy);
    // until the answer is made, all else lies elsewhere
    let _held = times.then(memory::draw_layout);
    let (answer, failures) = match &args.action {
        ChildAction::Build(build) => return trial_build(context, build).map(|()| SUCCESS),
        ChildAction::Plugin(args) => {
            end_with_parent();
            plugins::serve(&args.file, &args.socket)?;
            return Ok(SUCCESS);
        }
        ChildAction::Measure { rounds, lightly, process, first_round } => {
            let record = replan::restrict_to_known_rows(&record()?, context);
            let mut plan = replan::plan(&record, Some(*rounds), None, context)?;
            // whole images are not compared
            plan.limits.render_pass = 0.0;
            plan.processes = 1;
            plan.process = OneProcess { number: *process, first_round: *first_round as usize };
            if *lightly {
                check_lightly(&mut plan, &record);
            }
            let measured = measure_quietly(context, &plan, Outputs::default())?;
            (serde_json::to_string(&measured.record), measured.failures.len())
        }
        ChildAction::Laps => return laps(context).map(|()| SUCCESS),
        ChildAction::Accuracy => {
            (serde_json::to_string(&accuracy::times(context, &read_request()?)?), 0)
        }
        ChildAction::CountInstructions => {
            let plan = replan::plan(&record()?, None, None, context)?;
            (serde_json::to_string(&count_all(&plan)?), 0)
        }
    };
    writeln!(context.out, "{}", answer.map_err(FormatError::from)?)?;
    context.out.flush()?;
    Ok(if failures == 0 { SUCCESS } else { FAILURE })
}

/// Few answers are checked: an earlier child checked them all.
fn check_lightly(plan: &mut Plan<'_>, record: &RunRecord) {
    plan.limits.oracle_tests = 0;
    plan.strides = FixedStrides::of(record, LIGHTLY);
}

/// Laps that standard input asks for, a row's label a line.
struct AskedLaps;

impl Laps for AskedLaps {
    fn next(&self) -> Option<String> {
        let mut line = String::new();
        let read = std::io::stdin().read_line(&mut line);
        matches!(read, Ok(n) if n > 0).then(|| line.trim_end().to_owned())
    }

    fn made(&self, sample: Option<&Sample>) {
        let lap = sample.map(|s| Lap { build_s: s.build_s, trace_s: s.trace_s.clone() });
        let mut out = std::io::stdout().lock();
        // who asked may be gone; then there is no next line either
        let _ = serde_json::to_writer(&mut out, &lap).map_err(std::io::Error::from);
        let _ = out.write_all(b"\n").and_then(|()| out.flush());
    }
}

/// Gets the rows of the record on the first line ready, and makes the laps that the others ask for.
fn laps(context: &Context<'_>) -> Result<(), Error> {
    let mut line = String::new();
    std::io::stdin().read_line(&mut line)?;
    let record: RunRecord = serde_json::from_str(&line).map_err(FormatError::from)?;
    let mut plan = replan::plan(&record, None, None, context)?;
    plan.limits.render_pass = 0.0;
    plan.processes = 1;
    check_lightly(&mut plan, &record);
    let pools = Pools::new(plan.threads)?;
    let equipment = SceneInput {
        pools: &pools,
        clock: context.clock,
        world: context.world,
        progress: &Progress::new(false, 0, None),
        trials: &[],
        log: &RowJournal::new(None),
        laps: Some(&AskedLaps),
    };
    for known in &plan.scenes {
        measure_one(&plan, &**known, &equipment, None)?;
    }
    Ok(())
}

/// Builds a row over a scene and says what that took.
fn trial_build(context: &mut Context<'_>, args: &TrialArgs) -> Result<(), Error> {
    end_with_parent();
    let names = [args.row.clone()];
    let (structures, occluding) =
        measured_row::select(context.registry, context.occluders, &names, &[])?;
    let rows = structures.into_iter().map(MeasuredRow::Structure);
    let mut rows = rows.chain(occluding.into_iter().map(MeasuredRow::Occluder));
    let row = rows.next().ok_or(PlanError::NoRows)?;
    let scenes = context.scenes.resolve(std::slice::from_ref(&args.scene))?;
    for scene in scenes {
        let loaded = scene.load()?;
        let event = match args.precision {
            Precision::F32 => built::<f32>(context, &loaded, &row, args.threads)?,
            Precision::F64 => built::<f64>(context, &loaded, &row, args.threads)?,
        };
        say(context, &event)?;
    }
    Ok(())
}

fn built<S: Buildable>(
    context: &mut Context<'_>,
    loaded: &LoadedScene,
    row: &MeasuredRow<'_>,
    threads: u16,
) -> Result<Event, Error> {
    let geometry = Geometry::<S>::of(&loaded.scene)?;
    let lights = light_positions(&loaded.scene);
    let pool = pools::pool(usize::from(threads))?;
    say(context, &Event::Loaded)?;
    let before = machine::resident("self");
    let is_new = machine::reset_peak_rss();
    let build = row.prepare();
    let start = context.clock.now();
    let built = pool.install(|| build(geometry.prims(), &lights));
    let build_s = context.clock.seconds_since(start);
    let process_bytes = machine::peak_rss().filter(|_| is_new);
    let peak_bytes = process_bytes.zip(before).map(|(peak, before)| peak.saturating_sub(before));
    Ok(match built {
        Ok(_) => Event::Built { peak_bytes, process_bytes, build_s },
        Err(_) => Event::Refused,
    })
}

fn say(context: &mut Context<'_>, event: &Event) -> Result<(), Error> {
    writeln!(context.out, "{}", serde_json::to_string(event).map_err(FormatError::from)?)?;
    Ok(context.out.flush()?)
}

/// Ends this process when its standard input ends: whoever wanted the answer is gone, interrupted
/// or killed, and a build can go on for long.
fn end_with_parent() {
    std::thread::spawn(|| {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        std::process::exit(i32::from(FAILURE));
    });
}
