//! `rtbench reproduce havran1999`: counters, published and ours.

use std::fs::File;
use std::io::Write;

use rayon::prelude::*;

use super::chosen;
use crate::args::HavranArgs;
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS};
use crate::reproduce::published::{SCENES, figures};
use crate::reproduce::verdict::Verdict;
use crate::reproduce::{ReproduceError, Row, reproduce_scene, structures};

/// Reproduces, prints a line a figure and the sums; with `--strict` an unexplained difference is a
/// failure.
///
/// # Errors
/// [`Error`] for unknown names, unwritable files and scenes that cannot be traced.
pub fn run(context: &mut Context<'_>, args: &HavranArgs) -> Result<u8, Error> {
    let scenes = chosen(&args.scenes, &SCENES, ReproduceError::UnknownScene)?;
    let structures = chosen(&args.structures, &structures(), ReproduceError::UnknownStructure)?;
    let mut file = match &args.export_csv {
        Some(path) => Some((
            path,
            File::create(path).map_err(|source| Error::Write { path: path.clone(), source })?,
        )),
        None => None,
    };
    let figures = figures().map_err(ReproduceError::from)?;
    let rows: Vec<Row> = scenes
        .par_iter()
        .map(|scene| reproduce_scene(scene, &structures, &figures))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    write_table(context.out, &rows)?;
    context.out.flush()?;
    if let Some((path, file)) = &mut file {
        let text = csv_text(&rows)?;
        file.write_all(text.as_bytes())
            .map_err(|source| Error::Write { path: (*path).clone(), source })?;
    }
    let unexplained = rows.iter().any(|r| r.verdict == Verdict::Unexplained);
    Ok(if args.strict && unexplained { FAILURE } else { SUCCESS })
}

fn write_table(out: &mut dyn Write, rows: &[Row]) -> std::io::Result<()> {
    writeln!(
        out,
        "{:<8} {:<11} {:<12} {:<15} {:>11} {:>13} {:>7}  verdict",
        "scene", "structure", "params", "counter", "published", "ours", "ratio"
    )?;
    for row in rows {
        let decimals = if row.ours.fract() == 0.0 { 0 } else { 3 };
        writeln!(
            out,
            "{:<8} {:<11} {:<12} {:<15} {:>11} {:>13.decimals$} {:>7.4}  {}",
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

fn csv_text(rows: &[Row]) -> Result<String, Error> {
    let format = |message: String| Error::Format { format: "CSV", message };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(|e| format(e.to_string()))?;
    }
    let bytes = writer.into_inner().map_err(|e| format(e.to_string()))?;
    String::from_utf8(bytes).map_err(|e| format(e.to_string()))
}
