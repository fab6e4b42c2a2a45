//! `rtbench reproduce havran1999`: counters, published and ours.

use std::io::Write;

use crate::args::HavranArgs;
use crate::commands::reproduce::chosen::chosen;
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::{FAILURE, SUCCESS};
use crate::exports::outputs::write_file;
use measurement::system::created::create;
use presentation::csv;
use studies::reproduce::published::{SCENES, figures};
use studies::reproduce::verdict::Verdict;
use studies::reproduce::{ReproduceError, ReproducedRow, reproduce_scene, structures};

/// Reproduces scene after scene, prints one line per figure as soon as a scene is done, and the
/// sums; with `--strict` an unexplained difference is a failure.
///
/// # Errors
/// [`Error`] for unknown names, unwritable files and scenes that cannot be traced.
pub fn run(context: &mut Context<'_>, args: &HavranArgs) -> Result<u8, Error> {
    let scenes = chosen(&args.scenes, &SCENES, ReproduceError::UnknownScene)?;
    let structures = chosen(&args.structures, &structures(), ReproduceError::UnknownStructure)?;
    let _created = create([&args.export_csv])?;
    let figures = figures().map_err(ReproduceError::from)?;
    let mut rows = Vec::new();
    write_header(context.out)?;
    for scene in scenes {
        context.say(format_args!("{scene}: counting"));
        let of_scene = reproduce_scene(scene, &structures, &figures)?;
        write_rows(context.out, &of_scene)?;
        context.out.flush()?;
        rows.extend(of_scene);
    }
    write_sums(context.out, &rows)?;
    write_file(args.export_csv.as_deref(), || {
        csv::written(|writer| rows.iter().try_for_each(|row| writer.serialize(row)))
    })?;
    let unexplained = rows.iter().any(|r| r.verdict == Verdict::Unexplained);
    Ok(if args.strict && unexplained { FAILURE } else { SUCCESS })
}

fn write_header(out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(
        out,
        "{:<8} {:<15} {:<17} {:<15} {:>11} {:>13} {:>8}  verdict",
        "scene", "structure", "params", "counter", "published", "ours", "ratio"
    )
}

fn write_rows(out: &mut dyn Write, rows: &[ReproducedRow]) -> std::io::Result<()> {
    for row in rows {
        let decimals = if row.ours.fract() == 0.0 { 0 } else { 3 };
        writeln!(
            out,
            "{:<8} {:<15} {:<17} {:<15} {:>11} {:>13.decimals$} {:>8.4}  {}",
            row.scene,
            row.structure,
            row.params,
            row.counter,
            row.published,
            row.ours,
            row.ratio,
            row.verdict
        )?;
    }
    Ok(())
}

fn write_sums(out: &mut dyn Write, rows: &[ReproducedRow]) -> std::io::Result<()> {
    let count = |of: fn(&Verdict) -> bool| rows.iter().filter(|r| of(&r.verdict)).count();
    writeln!(
        out,
        "\n{} figures: {} exact, {} within tolerance, {} differ for a known reason, {} unexplained",
        rows.len(),
        count(|v| *v == Verdict::Exact),
        count(|v| *v == Verdict::Within),
        count(|v| matches!(v, Verdict::KnownReason(_))),
        count(|v| *v == Verdict::Unexplained),
    )
}
