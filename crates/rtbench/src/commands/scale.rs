//! `rtbench scale`: measure one scene in several sizes, print, export, plot.

use crate::args::{Color, ExportArgs, ScaleArgs, ScaleExportArgs};
use crate::commands::measuring::{Kept, begin, exit_code, measure_rest, warn_of};
use crate::commands::resumable::{Begun, go_on, manifest, watch};
use crate::context::Context;
use crate::error::Error;
use crate::exports::occupied::Wanted;
use crate::exports::outputs::Outputs;
use measurement::journal::Journal;
use measurement::journal::lines::Manifest;
use measurement::plan::error::PlanError;
use measurement::record::RunRecord;
use measurement::settings::asked::Asked;
use measurement::settings::scale::ScaleSettings;
use presentation::json;
use studies::scale::Scale;
use studies::scale::{csv, plot, table};

/// Measures and returns the exit code.
///
/// # Errors
/// [`Error`] for what ends the run early: the command line, an output.
pub fn run(context: &mut Context<'_>, args: &ScaleArgs, color: Color) -> Result<u8, Error> {
    let settings = args.settings();
    let scale = Scale::new(&settings, context.registry, context.occluders, context.scenes)?;
    let record = begun(context, &scale);
    let mut kept = Kept::default();
    let manifest =
        Manifest { asked: Some(Asked::Scale(settings)), ..manifest(context, &scale.plan, &record) };
    let exports = &args.exports;
    if let Some(folder) = &exports.output {
        let wanted = Wanted {
            names: &NAMES,
            command_line: &record.command_line,
            manifest: Some(&manifest),
            overwrite: context.overwrite,
        };
        wanted.check(folder)?;
    }
    let outputs = outputs(exports)?;
    if let Some(folder) = &exports.output {
        kept.journal = Some(Journal::begin(folder, manifest)?);
    }
    watch(context, &kept, exports.output.as_deref(), scale.plan.scenes.len())?;
    measure(context, color, &scale, outputs, kept, record)
}

/// Finishes what was begun in the folder of `-o`.
///
/// # Errors
/// Those of [`run`], and for a run that would not be the same.
pub(super) fn resume(
    context: &mut Context<'_>,
    asked: &ScaleSettings,
    exports: &ExportArgs,
    color: Color,
    begun_before: Begun<'_>,
) -> Result<u8, Error> {
    let exports = of_scale(exports)?;
    let mut scale = Scale::new(asked, context.registry, context.occluders, context.scenes)?;
    scale.plan.set_view(&begun_before.found.manifest.settings.view);
    let record = begun(context, &scale);
    let (kept, record) = go_on(context, begun_before, &scale.plan, record)?;
    let outputs = outputs(&exports)?;
    watch(context, &kept, exports.output.as_deref(), scale.plan.scenes.len())?;
    measure(context, color, &scale, outputs, kept, record)
}

/// What the command line of `run --resume` wants written of a scale.
fn of_scale(exports: &ExportArgs) -> Result<ScaleExportArgs, PlanError> {
    let ExportArgs { export_github_smaller, export_github_bigger, export_bencher, .. } = exports;
    for (path, option) in [
        (export_github_smaller, "--export-github-smaller"),
        (export_github_bigger, "--export-github-bigger"),
        (export_bencher, "--export-bencher"),
    ] {
        if path.is_some() {
            return Err(PlanError::NotOfScale { option });
        }
    }
    Ok(ScaleExportArgs {
        output: exports.output.clone(),
        export_csv: exports.export_csv.clone(),
        export_markdown: exports.export_markdown.clone(),
        export_json: exports.export_json.clone(),
        export_slopes: None,
        export_svg: None,
    })
}

/// The record before the first size.
fn begun(context: &Context<'_>, scale: &Scale<'_>) -> RunRecord {
    RunRecord {
        scale: Some(scale.record.clone()),
        ..begin(context.world, &context.command_line, &scale.plan)
    }
}

fn measure(
    context: &mut Context<'_>,
    color: Color,
    scale: &Scale<'_>,
    mut outputs: Outputs<'static>,
    kept: Kept,
    record: RunRecord,
) -> Result<u8, Error> {
    context.warn_of_instructions();
    let screen = context.terminal.screen(color);
    let has_tables = !outputs.are_printed();
    let measured =
        measure_rest(context, &scale.plan, &mut outputs, kept, record, |context, run, scene| {
            warn_of(context, scene);
            if has_tables {
                table::write_size(context.out, run, scene, screen)?;
                context.out.flush()?;
            }
            Ok(())
        })?;
    if has_tables && !measured.record.scenes.is_empty() {
        table::write_slopes(context.out, &measured.record, screen)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}

/// The files in the folder of `-o`, the record first.
const NAMES: [&str; 5] = ["results.json", "scale.csv", "slopes.csv", "scale.md", "scale.svg"];

/// The files that the command line names, and those of its folder.
fn outputs(args: &ScaleExportArgs) -> Result<Outputs<'static>, Error> {
    let mut outputs = Outputs::default();
    if let Some(folder) = &args.output {
        outputs.folder(folder)?;
    }
    let within = |name| args.output.as_ref().map(|folder| folder.join(name));
    let [results, sizes, slopes, markdown, svg] = NAMES.map(within);
    for path in [results, args.export_json.clone()] {
        outputs.add(path.as_ref(), json::written)?;
    }
    for path in [sizes, args.export_csv.clone()] {
        outputs.add(path.as_ref(), csv::sizes)?;
    }
    for path in [slopes, args.export_slopes.clone()] {
        outputs.add(path.as_ref(), csv::slopes)?;
    }
    for path in [markdown, args.export_markdown.clone()] {
        outputs.add(path.as_ref(), |run| Ok(table::to_markdown(run)))?;
    }
    for path in [svg, args.export_svg.clone()] {
        outputs.add(path.as_ref(), |run| Ok(plot::to_svg(run)))?;
    }
    Ok(outputs)
}

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;
    use clap::Parser;

    use accel_core::occluders;

    use crate::args::{Cli, Command};
    use measurement::scenes::Installed;
    use studies::scale::Scale;

    fn scale(arguments: &str) -> Result<Scale<'static>, String> {
        let words = ["rtbench", "scale"].into_iter().chain(arguments.split(' '));
        let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
        let Command::Scale(args) = cli.command else { return Err("another command".into()) };
        Scale::new(&args.settings(), REGISTRY, occluders::REGISTRY, &Installed)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn sizes_are_the_nearest_ones_each_once() {
        let s = scale("balls-tess --sizes 1e3..1e7 -s uniform-grid").unwrap();
        let names: Vec<&str> = s.plan.scenes.iter().map(|scene| scene.name()).collect();
        let expected = [1, 2, 3, 4, 5].map(|n| format!("balls-tess:{n}"));
        assert_eq!(names, expected);
        assert_eq!(s.record.sizes[3].primitives, 1_417_154);
        let s = scale("balls --sizes 1e3..1e4 --per-decade 4 -s uniform-grid").unwrap();
        let asked: Vec<usize> = s.record.sizes.iter().map(|size| size.asked.len()).collect();
        assert_eq!((s.record.sizes[0].name.as_str(), asked), ("balls:3", vec![2, 3]));
        assert_eq!(
            s.plan.kinds.iter().map(|k| k.name()).collect::<Vec<_>>(),
            ["primary", "shadow"]
        );
        assert_eq!(s.plan.settings.resolution, [256, 256]);
    }

    #[test]
    fn all_structures_are_measured_at_their_defaults() {
        let s = scale("tetra --sizes 64..1024 --quick").unwrap();
        let labels: Vec<String> = s.plan.rows.iter().map(|row| row.label()).collect();
        assert_eq!(labels.len(), REGISTRY.len() + occluders::REGISTRY.len());
        assert!(REGISTRY.iter().all(|e| labels.iter().any(|l| l == e.info.name)), "{labels:?}");
        let s = scale("tetra --sizes 64 --set uniform-grid.density=4 --rays primary").unwrap();
        assert!(s.plan.rows.iter().any(|row| row.label() == "uniform-grid density=4"));
        assert_eq!(s.plan.rows.len(), REGISTRY.len(), "no shadow rays, no occluder");
    }

    #[test]
    fn limits_are_read() {
        let s = scale("tetra --sizes 64 --time-limit 2m --max-memory 1.5GiB").unwrap();
        let limits = s.plan.build_limits.unwrap();
        assert_eq!((limits.seconds, limits.bytes), (120.0, 3 << 29));
    }

    #[test]
    fn what_cannot_be_scaled_says_why() {
        for (arguments, said) in [
            ("kitchen", "does not come in sizes; those that do: balls"),
            ("kitchn", "unknown scene"),
            ("hare --sizes 1e3..1e9", "its sizes go from 8 to 19996488"),
            ("balls --sizes 1", "the nearest size of balls has 11 primitives"),
            ("hare --sizes 1e6..1e3", "is not below"),
            ("hare --per-decade 0", "per-decade"),
            ("hare --max-memory 8", "8GiB"),
            ("hare -s unifrom-grid", "did you mean 'uniform-grid'?"),
        ] {
            let error = scale(arguments).unwrap_err();
            assert!(error.contains(said), "{arguments}: {error}");
        }
    }
}
