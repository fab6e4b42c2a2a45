//! `rtbench profile`: what the time of a run's fastest rows is spent on.

use crate::args::{Color, ProfileArgs};
use crate::context::Context;
use crate::doctor::memory;
use crate::error::Error;
use crate::exports::outputs::write_file;
use crate::gate::GateError;
use crate::like::{Narrowed, narrowed};
use crate::profile::{Machine, fastest_rows, tables};
use measurement::callgrind::simulation::{caches_below, simulate};
use measurement::record::file;
use presentation::markdown::push_table;
use presentation::text::write_table;

/// Measures the machine's memory, simulates its caches under the rows, and prints both beside the
/// times of the results.
///
/// # Errors
/// [`Error`] for results that cannot be read, a machine that does not tell its caches, a missing
/// valgrind, and outputs.
pub fn run(context: &mut Context<'_>, args: &ProfileArgs, color: Color) -> Result<(), Error> {
    let record = file::read(&args.results)?;
    let wanted =
        Narrowed { scenes: &args.scene, structures: &args.structures, ..Narrowed::default() };
    let mut record = narrowed(&record, &wanted).map_err(GateError::from)?;
    if args.structures.is_empty() {
        let kept = fastest_rows(&record);
        let is_kept = |label: &String| kept.contains(label);
        for scene in &mut record.scenes {
            scene.rows.retain(|row| row.is_reference || is_kept(&row.label()));
        }
    }
    let caches = caches_below(&context.world.system_root()).map_err(GateError::from)?;
    context.say(format_args!("timing loads that wait for one another"));
    let latencies = memory::measure(&memory::SIZES, context.clock);
    context.say(format_args!("simulating caches: some minutes"));
    let program = context.environment.program.as_deref();
    let allow_outside = context.scenes.allows_outside();
    let fetched = simulate(program, &record, &caches, args.rays, allow_outside);
    let fetched = fetched.map_err(GateError::from)?;
    let tables = tables(&record, &fetched, &Machine::new(&caches, &latencies));
    let colors = context.terminal.colors(color);
    for table in &tables {
        write_table(context.out, table, colors)?;
    }
    write_file(args.export_markdown.as_deref(), || {
        let mut text = String::new();
        tables.iter().for_each(|table| push_table(&mut text, table));
        Ok(text)
    })?;
    Ok(context.out.flush()?)
}
