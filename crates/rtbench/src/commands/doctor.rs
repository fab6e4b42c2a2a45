//! `rtbench doctor`: what may disturb measurements on this machine.

use std::io::Write;

use crate::args::{Color, DoctorArgs, Format};
use crate::context::Context;
use crate::doctor::{Diagnosis, Level, System, diagnose};
use crate::error::Error;
use presentation::json;
use presentation::table::Style;
use presentation::text::painted;

/// Looks and prints.
pub fn run(context: &mut Context<'_>, args: &DoctorArgs, color: Color) -> Result<(), Error> {
    let diagnosis = diagnose(&System::of(context.world), context.clock);
    match args.format {
        Format::Json => context.out.write_all(json::written(&diagnosis)?.as_bytes())?,
        Format::Text => write(context.out, &diagnosis, context.terminal.colors(color))?,
    }
    Ok(context.out.flush()?)
}

fn write(out: &mut dyn Write, diagnosis: &Diagnosis, colors: bool) -> std::io::Result<()> {
    let findings = &diagnosis.findings;
    let width = findings.iter().map(|f| f.name.chars().count()).max().unwrap_or(0);
    for finding in findings {
        let (level, style) = match finding.level {
            Level::Good => ("good", Style::Plain),
            Level::Warning => ("warning", Style::Bad),
            Level::Unknown => ("unknown", Style::Dim),
        };
        let level = painted(&format!("{level:<7}"), style, colors);
        writeln!(out, "{level}  {:<width$}  {}", finding.name, finding.value)?;
        if let Some(advice) = finding.advice {
            writeln!(out, "{:9}{:width$}  {}", "", "", finding.meaning)?;
            writeln!(out, "{:9}{:width$}  to do: {advice}", "", "")?;
        }
    }
    let warnings = findings.iter().filter(|f| f.level == Level::Warning).count();
    writeln!(out, "{warnings} of {} may disturb measurements", findings.len())
}
