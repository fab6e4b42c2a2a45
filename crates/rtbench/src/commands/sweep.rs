//! `rtbench sweep`: measure one parameter over its values, print, export, plot.

use crate::args::{Color, SweepArgs};
use crate::commands::measuring::{exit_code, measure_scenes, warn_of};
use crate::context::Context;
use crate::error::Error;
use crate::exports::outputs::Outputs;
use presentation::json;
use presentation::text::Screen;
use studies::sweep::Sweep;
use studies::sweep::{csv, plot, table};

/// Sweeps and returns the exit code.
///
/// # Errors
/// [`Error`] for what ends the sweep early: the command line, an output.
pub fn run(context: &mut Context<'_>, args: &SweepArgs, color: Color) -> Result<u8, Error> {
    let sweep = Sweep::new(&args.settings(), context.registry, context.scenes)?;
    context.warn_of_instructions();
    let mut screen = context.terminal.screen(color);
    if args.wide {
        screen.width = Screen::WIDE;
    }
    let mut outputs = Outputs::default();
    outputs.add(args.export_csv.as_ref(), |run| csv::to_string(&sweep, run))?;
    outputs.add(args.export_svg.as_ref(), |run| Ok(plot::to_svg(&sweep, run)))?;
    outputs.add(args.export_markdown.as_ref(), |run| Ok(table::to_markdown(&sweep, run)))?;
    outputs.add(args.export_json.as_ref(), json::written)?;
    let has_tables = !outputs.are_printed();
    let measured = measure_scenes(context, &sweep.plan, &mut outputs, |context, run, scene| {
        warn_of(context, scene);
        if has_tables {
            table::write(context.out, &sweep, run, scene, screen)?;
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

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;
    use clap::Parser;

    use crate::args::{Cli, Command};
    use measurement::scenes::Installed;
    use studies::sweep::{Abscissa, Sweep};

    fn sweep(arguments: &str) -> Result<Sweep<'static>, String> {
        let words = ["rtbench", "sweep", "tetra:2"].into_iter().chain(arguments.split(' '));
        let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
        let Command::Sweep(args) = cli.command else { return Err("another command".into()) };
        Sweep::new(&args.settings(), REGISTRY, &Installed).map_err(|e| e.to_string())
    }

    fn labels(sweep: &Sweep<'_>) -> Vec<String> {
        sweep.plan.rows.iter().map(|r| r.label()).collect()
    }

    #[test]
    fn values_default_rules_and_reference_are_rows_of_one_plan() {
        let s = sweep("-s uniform-grid -p density --values 4,1.0 --set mailbox=hash").unwrap();
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
        assert_eq!(s.plan.rows[s.plan.baseline].label(), "obvhs-cwbvh adapter=direct");
        assert_eq!(s.abscissa, Abscissa::CellsPerPrimitive);
        assert_eq!(s.settings, "mailbox=hash");
    }

    #[test]
    fn one_row_can_be_value_default_rule_and_reference() {
        let s = sweep("-s uniform-grid:resolution=woo -p density --values 1,2").unwrap();
        assert_eq!((s.lines[0].is_swept, s.lines[0].rules.as_slice()), (true, &["woo"][..]));
        assert!(s.lines[1].is_swept && s.lines[1].is_default);
        let s = sweep("-s obvhs-cwbvh:adapter=direct -p preset --values fast,medium").unwrap();
        assert_eq!((labels(&s).len(), s.plan.baseline), (2, 1));
        assert!(s.lines[1].is_swept && s.lines[1].is_default);
        assert_eq!(s.abscissa, Abscissa::Words);
    }

    #[test]
    fn whole_numbers_are_swept_without_rules() {
        let s = sweep("-s kd-tree -p max-depth --from 1 --to 16 --steps 5").unwrap();
        let values: Vec<_> = s.lines.iter().filter(|l| l.is_swept).map(|l| &l.value).collect();
        assert_eq!(values.len(), 5);
        assert!(s.lines.iter().all(|l| l.rules.is_empty()));
        assert_eq!(s.abscissa, Abscissa::Number { is_log: true });
    }

    #[test]
    fn a_named_reference_is_added() {
        let s = sweep("-s uniform-grid -p order --values file --reference obvhs-bvh2").unwrap();
        assert_eq!(s.plan.rows[s.plan.baseline].label(), "obvhs-bvh2");
        assert_eq!(s.lines.len(), s.plan.rows.len());
    }
}
