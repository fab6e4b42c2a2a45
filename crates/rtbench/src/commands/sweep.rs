//! `rtbench sweep`: one parameter over its values, or one scene in several sizes; printed, exported and
//! plotted. `rtbench explain`: a row and the reference in all their crafts.

use crate::args::{ExplainArgs, SweepArgs};
use crate::commands::measuring::{PlanResults, begin, exit_code, measure_rest, measure_scenes};
use crate::commands::run_state::RunState;
use crate::context::Context;
use crate::error::Error;
use crate::outputs::OutputFile;
use measurement::record::{RunRecord, file};
use presentation::json;
use presentation::text::Screen;
use studies::explain::{Explain, table};
use studies::sweep::sizes::Sizes;
use studies::sweep::sizes::{self, SizeSweep};
use studies::sweep::{Sweep, report};

pub fn run(context: &mut Context<'_>, args: &SweepArgs) -> Result<u8, Error> {
    let screen = context.screen();
    let measured = match &args.sizes {
        Some(asked) => over_sizes(context, args, asked, screen),
        None => over_values(context, args, screen),
    }?;
    Ok(exit_code(&measured))
}

fn over_values(
    context: &mut Context<'_>,
    args: &SweepArgs,
    screen: Screen,
) -> Result<PlanResults, Error> {
    let sweep = Sweep::new(&args.settings()?, context.registry, context.scenes)?;
    context.warn_of_instructions();
    let files: [OutputFile<'_>; 4] = [
        (file::NAME, Box::new(json::written)),
        ("sweep.csv", Box::new(|run| report::to_csv(&sweep, run))),
        ("sweep.md", Box::new(|run| Ok(report::to_markdown(&sweep, run)))),
        ("sweep.svg", Box::new(|run| Ok(report::to_svg(&sweep, run)))),
    ];
    let outputs = context.outputs_in(args.output.as_ref(), files)?;
    let measured = measure_scenes(context, &sweep.plan, outputs, |out, run, scene| {
        report::write(out, &sweep, run, scene, screen)
    })?;
    if !measured.record.scenes.is_empty() {
        screen.write_notes(context.out, report::GLOSSARY)?;
    }
    Ok(measured)
}

fn over_sizes(
    context: &mut Context<'_>,
    args: &SweepArgs,
    asked: &Sizes,
    screen: Screen,
) -> Result<PlanResults, Error> {
    let settings = args.size_settings(asked)?;
    let sweep = SizeSweep::new(&settings, context.registry, context.occluders, context.scenes)?;
    context.warn_of_instructions();
    let files: [OutputFile<'_>; 5] = [
        (file::NAME, Box::new(json::written)),
        ("sweep.csv", Box::new(sizes::table::sizes_csv)),
        ("slopes.csv", Box::new(sizes::table::slopes_csv)),
        ("sweep.md", Box::new(|run| Ok(sizes::table::to_markdown(run)))),
        ("sweep.svg", Box::new(|run| Ok(sizes::table::to_svg(run)))),
    ];
    let outputs = context.outputs_in(args.output.as_ref(), files)?;
    let record = RunRecord {
        scale: Some(sweep.record.clone()),
        ..begin(context.world, &context.command_line, &sweep.plan)
    };
    let kept = RunState::default();
    let measured = measure_rest(context, &sweep.plan, outputs, kept, record, |out, run, scene| {
        sizes::table::write_size(out, run, scene, screen)
    })?;
    if !measured.record.scenes.is_empty() {
        sizes::table::write_slopes(context.out, &measured.record, screen)?;
    }
    Ok(measured)
}

/// `rtbench explain`: measures a row and the reference in all their crafts.
pub fn explain(context: &mut Context<'_>, args: &ExplainArgs) -> Result<u8, Error> {
    let explain = Explain::new(
        &args.scenes,
        &args.structure,
        &args.measuring.settings(),
        args.processes,
        context.registry,
        context.scenes,
    )?;
    let screen = context.screen();
    let files: [OutputFile<'_>; 3] = [
        (file::NAME, Box::new(json::written)),
        ("explain.csv", Box::new(|run| table::to_csv(&explain, run))),
        ("explain.md", Box::new(|run| Ok(table::to_markdown(&explain, run)))),
    ];
    let outputs = context.outputs_in(args.output.as_ref(), files)?;
    let measured = measure_scenes(context, &explain.plan, outputs, |out, run, scene| {
        table::write(out, &explain, run, scene, screen)
    })?;
    if !measured.record.scenes.is_empty() {
        screen.write_notes(context.out, table::GLOSSARY)?;
    }
    Ok(exit_code(&measured))
}

#[cfg(test)]
mod tests {
    use accel_core::occluders;
    use accel_core::structures::REGISTRY;
    use clap::Parser;

    use crate::args::{Cli, Command, SweepArgs};
    use measurement::scenes::InstalledScenes;
    use presentation::svg_plot::Scale;
    use studies::sweep::Sweep;
    use studies::sweep::sizes::SizeSweep;

    fn args(arguments: &str) -> Result<SweepArgs, String> {
        let words = ["rtbench", "sweep"].into_iter().chain(arguments.split(' '));
        let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
        let Command::Sweep(args) = cli.command else { return Err("another command".into()) };
        Ok(args)
    }

    fn sweep(arguments: &str) -> Result<Sweep<'static>, String> {
        let settings = args(&format!("tetra:2 {arguments}"))?.settings();
        let settings = settings.map_err(|e| e.to_string())?;
        Sweep::new(&settings, REGISTRY, &InstalledScenes).map_err(|e| e.to_string())
    }

    fn labels(sweep: &Sweep<'_>) -> Vec<String> {
        sweep.plan.rows.iter().map(|r| r.label()).collect()
    }

    #[test]
    fn values_default_rules_and_reference_are_rows_of_one_plan() {
        let s = sweep("-s uniform-grid:mailbox=hash -p density --values 4,1.0").unwrap();
        assert_eq!(s.lines.len(), s.plan.rows.len());
        assert_eq!(
            labels(&s)[..4],
            [
                "uniform-grid density=1 mailbox=hash",
                "uniform-grid density=4 mailbox=hash",
                "uniform-grid mailbox=hash",
                "uniform-grid resolution=woo density=1 mailbox=hash",
            ]
        );
        assert!(s.lines[1].is_swept && s.lines[1].value.as_deref() == Some("4"));
        assert!(s.lines[2].is_default && !s.lines[2].is_swept);
        assert_eq!(s.lines[3].rules, ["woo"]);
        assert_eq!(s.plan.rows[s.plan.baseline].label(), "obvhs-cwbvh");
        assert!(s.has_rules && s.axis.label.starts_with("cells per primitive"));
        assert_eq!(s.settings, "mailbox=hash");
    }

    #[test]
    fn one_row_can_be_value_default_rule_and_reference() {
        let s = sweep("-s uniform-grid:resolution=woo -p density --values 1,2").unwrap();
        assert_eq!((s.lines[0].is_swept, s.lines[0].rules.as_slice()), (true, &["woo"][..]));
        assert!(s.lines[1].is_swept && s.lines[1].is_default);
        let s = sweep("-s obvhs-cwbvh -p preset --values fast,medium").unwrap();
        assert_eq!((labels(&s).len(), s.plan.baseline), (2, 1));
        assert!(s.lines[1].is_swept && s.lines[1].is_default);
        assert_eq!(s.axis.scale, Scale::Words(vec!["fast".to_owned(), "medium".to_owned()]));
    }

    #[test]
    fn whole_numbers_are_swept_without_rules() {
        let s = sweep("-s kd-tree -p max-depth --values 1..16:5").unwrap();
        let values: Vec<_> = s.lines.iter().filter(|l| l.is_swept).map(|l| &l.value).collect();
        assert_eq!(values.len(), 5);
        assert!(s.lines.iter().all(|l| l.rules.is_empty()));
        assert_eq!((s.axis.scale, s.has_rules), (Scale::Log, false));
    }

    #[test]
    fn a_named_reference_is_added() {
        let s = sweep("-s uniform-grid -p order --values file --reference obvhs-bvh2").unwrap();
        assert_eq!(s.plan.rows[s.plan.baseline].label(), "obvhs-bvh2");
        assert_eq!(s.lines.len(), s.plan.rows.len());
    }

    fn sizes(arguments: &str) -> Result<SizeSweep<'static>, String> {
        let args = args(arguments)?;
        let settings = args.size_settings(args.sizes.as_ref().unwrap());
        let settings = settings.map_err(|e| e.to_string())?;
        SizeSweep::new(&settings, REGISTRY, occluders::REGISTRY, &InstalledScenes)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn sizes_are_the_nearest_ones_each_once() {
        let s = sizes("balls-tess --sizes 1e3..1e7 -s uniform-grid").unwrap();
        let names: Vec<&str> = s.plan.scenes.iter().map(|scene| scene.name()).collect();
        let expected = [1, 2, 3, 4, 5].map(|n| format!("balls-tess:{n}"));
        assert_eq!(names, expected);
        assert_eq!(s.record.sizes[3].primitives, 1_417_154);
        let s = sizes("balls --sizes 1k,1778,3162,5623,10k -s uniform-grid").unwrap();
        let asked: Vec<usize> = s.record.sizes.iter().map(|size| size.asked.len()).collect();
        assert_eq!((s.record.sizes[0].name.as_str(), asked), ("balls:3", vec![2, 3]));
        let kinds: Vec<&str> = s.plan.kinds.iter().map(|k| k.name()).collect();
        assert_eq!(kinds, ["primary", "shadow"]);
        assert_eq!(s.plan.settings.resolution, [256, 256]);
    }

    #[test]
    fn all_structures_are_measured_at_their_defaults() {
        let s = sizes("tetra --sizes 64..1024 --quick").unwrap();
        let labels: Vec<String> = s.plan.rows.iter().map(|row| row.label()).collect();
        assert_eq!(labels.len(), REGISTRY.len() + occluders::REGISTRY.len());
        assert!(REGISTRY.iter().all(|e| labels.iter().any(|l| l == e.info.name)), "{labels:?}");
        let s = sizes("tetra --sizes 64 -s uniform-grid:density=4").unwrap();
        assert!(s.plan.rows.iter().any(|row| row.label() == "uniform-grid density=4"));
        let s = sizes("tetra --sizes 64 --rays primary").unwrap();
        assert_eq!(s.plan.rows.len(), REGISTRY.len(), "no shadow rays, no occluder");
    }

    #[test]
    fn limits_are_read() {
        let s = sizes("tetra --sizes 64 --time-limit 2m --max-memory 1.5GiB").unwrap();
        let limits = s.plan.build_limits.unwrap();
        assert_eq!((limits.seconds, limits.bytes), (120.0, 3 << 29));
    }
}
