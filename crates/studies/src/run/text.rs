//! A run on the terminal.

use std::io::{self, Write};

use crate::run::tables::GLOSSARY;
use crate::run::{foreign, kind_tables, tables};
use measurement::record::{RunRecord, SceneRecord};
use presentation::text::{write_notes, write_table};

/// Prints the block of a scene.
///
/// # Errors
/// Those of the writer.
pub fn write_scene(
    out: &mut dyn Write,
    run: &RunRecord,
    scene: &SceneRecord,
    colors: bool,
) -> io::Result<()> {
    write_table(out, &tables::scene_table(run, scene, true), colors)?;
    if run.settings.by_kind {
        write_table(out, &kind_tables::scene_table(run, scene, true), colors)?;
    }
    foreign::table(scene).map_or(Ok(()), |table| write_table(out, &table, colors))
}

/// Prints the summary and what the symbols mean.
///
/// # Errors
/// Those of the writer.
pub fn write_summary(out: &mut dyn Write, run: &RunRecord, colors: bool) -> io::Result<()> {
    write_table(out, &tables::summary_table(run, true), colors)?;
    if run.settings.by_kind {
        write_table(out, &kind_tables::summary_table(run, true), colors)?;
        write_table(out, &kind_tables::picture_table(run), colors)?;
    }
    write_notes(out, GLOSSARY, colors)
}
