//! `rtbench explain`: a row and the reference in all their crafts.

use crate::args::ExplainArgs;
use crate::commands::measuring::{exit_code, measure_scenes};
use crate::context::Context;
use crate::error::Error;
use crate::outputs::OutputFile;
use measurement::record::file;
use presentation::json;
use studies::explain::{Explain, table};

/// Measures and returns the exit code.
pub fn run(context: &mut Context<'_>, args: &ExplainArgs) -> Result<u8, Error> {
    let explain = Explain::new(&args.settings(), context.registry, context.scenes)?;
    let screen = context.screen();
    let files: [OutputFile<'_>; 3] = [
        (file::NAME, Box::new(json::written)),
        ("explain.csv", Box::new(|run| table::to_csv(&explain, run))),
        ("explain.md", Box::new(|run| Ok(table::to_markdown(&explain, run)))),
    ];
    let mut outputs = context.outputs_in(args.output.as_ref(), files)?;
    let measured = measure_scenes(context, &explain.plan, &mut outputs, |out, run, scene| {
        table::write(out, &explain, run, scene, screen)
    })?;
    if !measured.record.scenes.is_empty() {
        screen.write_notes(context.out, table::GLOSSARY)?;
    }
    Ok(exit_code(&measured))
}
