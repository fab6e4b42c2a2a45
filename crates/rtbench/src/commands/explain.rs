//! `rtbench explain`: measure a row and the reference in all their crafts, print, export.

use crate::args::{Color, ExplainArgs};
use crate::commands::measuring::{exit_code, measure_scenes, warn_of};
use crate::context::Context;
use crate::error::Error;
use crate::exports::occupied::PlannedOutput;
use crate::exports::outputs::{OutputError, Outputs};
use measurement::record::file;
use presentation::json;
use studies::explain::Explain;
use studies::explain::table;

/// The files of `-o`.
const NAMES: [&str; 3] = [file::NAME, "explain.csv", "explain.md"];

/// Measures and returns the exit code.
///
/// # Errors
/// [`Error`] for what ends it early: the command line, an output.
pub fn run(context: &mut Context<'_>, args: &ExplainArgs, color: Color) -> Result<u8, Error> {
    let explain = Explain::new(&args.settings(), context.registry, context.scenes)?;
    if let Some(folder) = &args.output {
        let wanted = PlannedOutput {
            names: &NAMES,
            command_line: &context.command_line,
            manifest: None,
            overwrite: context.overwrite,
        };
        wanted.check(folder)?;
    }
    let screen = context.terminal.screen(color);
    let mut outputs = outputs(args, &explain)?;
    let has_tables = !outputs.are_printed();
    let measured = measure_scenes(context, &explain.plan, &mut outputs, |context, run, scene| {
        warn_of(context, scene);
        if has_tables {
            table::write(context.out, &explain, run, scene, screen)?;
            context.out.flush()?;
        }
        Ok(())
    })?;
    if has_tables && !measured.record.scenes.is_empty() {
        table::write_glossary(context.out, screen)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}

/// Creates what the command line names.
fn outputs<'e>(args: &ExplainArgs, explain: &'e Explain<'_>) -> Result<Outputs<'e>, OutputError> {
    let mut outputs = Outputs::default();
    let [json_name, csv_name, markdown_name] =
        NAMES.map(|name| args.output.as_ref().map(|folder| folder.join(name)));
    if let Some(folder) = &args.output {
        outputs.folder(folder)?;
    }
    for path in [csv_name.as_ref(), args.export_csv.as_ref()] {
        outputs.add(path, |run| table::to_csv(explain, run))?;
    }
    for path in [markdown_name.as_ref(), args.export_markdown.as_ref()] {
        outputs.add(path, |run| Ok(table::to_markdown(explain, run)))?;
    }
    for path in [json_name.as_ref(), args.export_json.as_ref()] {
        outputs.add(path, json::written)?;
    }
    Ok(outputs)
}
