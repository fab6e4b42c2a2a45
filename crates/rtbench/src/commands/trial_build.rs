//! The process of a [`measurement::rounds::trial`]: loads, builds, says so.

use accel_core::registry::Buildable;
use renderer::Geometry;

use crate::args::TrialArgs;
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::FAILURE;
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::{self, MeasuredRow};
use measurement::rounds::scene_run::light_positions;
use measurement::rounds::trial::Event;
use measurement::scenes::LoadedScene;
use measurement::settings::Precision;
use measurement::system::machine;
use measurement::system::pools;
use presentation::format_error::FormatError;

/// Builds a row over a scene and says what that took.
///
/// # Errors
/// [`Error`] for a scene that cannot be loaded or a row that there is not.
pub fn run(context: &mut Context<'_>, args: &TrialArgs) -> Result<(), Error> {
    end_with_parent();
    let names = [args.row.clone()];
    let (structures, occluding) =
        measured_row::select(context.registry, context.occluders, &names, &[])?;
    let rows = structures.into_iter().map(MeasuredRow::from);
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
    let format = |e: serde_json::Error| FormatError { format: "JSON", message: e.to_string() };
    writeln!(context.out, "{}", serde_json::to_string(event).map_err(format)?)?;
    Ok(context.out.flush()?)
}

/// Ends this process when its standard input ends: whoever wanted the answer is gone, interrupted
/// or killed, and a build can go on for long.
pub fn end_with_parent() {
    std::thread::spawn(|| {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        std::process::exit(i32::from(FAILURE));
    });
}
