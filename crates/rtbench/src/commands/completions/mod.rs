//! `rtbench completions`: what a shell completes, the scenes, structures and settings that there are among it.

mod scripts;

use accel_core::params::{ParamKind, ParamSpec};
use accel_core::structure::StructureInfo;
use accel_core::structures::COMMON;
use clap::builder::PossibleValuesParser;
use clap::{Arg, CommandFactory};
use renderer::RayKind;
use renderer::tracers::TRACERS;
use studies::accuracy::axis::AXES;

use crate::args::{Cli, CompletionsArgs};
use crate::context::Context;
use crate::error::Error;

/// The names that there are, by what arguments take.
struct Names {
    scenes: Vec<String>,
    structures: Vec<String>,
    parameters: Vec<String>,
    overrides: Vec<String>,
    occluders: Vec<String>,
}

/// Prints completions.
///
/// # Errors
/// Those of the scenes' source, [`Error::Output`].
pub fn run(context: &mut Context<'_>, args: &CompletionsArgs) -> Result<(), Error> {
    let names = Names::of(context)?;
    let mut cli = Cli::command();
    cli = cli.mut_subcommands(|command| {
        let command = command.mut_args(|arg| names.completed(arg));
        command.mut_subcommands(|below| below.mut_args(|arg| names.completed(arg)))
    });
    // the library takes no error of its writer
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut cli, super::printed::NAME, &mut text);
    let script = scripts::completed(args.shell, String::from_utf8_lossy(&text).into_owned(), &cli);
    context.out.write_all(script.as_bytes())?;
    Ok(context.out.flush()?)
}

impl Names {
    fn of(context: &Context<'_>) -> Result<Self, Error> {
        let structures = || context.registry.iter().map(|e| e.info);
        let sets = context.scenes.sets()?.into_iter().map(|(name, _)| name);
        let scenes = context.scenes.scenes()?.into_iter().map(|(name, _)| name);
        let mut parameters: Vec<String> =
            structures().flat_map(params).map(|p| p.name.to_owned()).collect();
        parameters.sort_unstable();
        parameters.dedup();
        let set = |info: &'static StructureInfo| {
            params(info).map(move |p| format!("{}.{}=", info.name, p.name))
        };
        Ok(Self {
            scenes: scenes.chain(sets).collect(),
            structures: structures().flat_map(with_settings).collect(),
            parameters,
            overrides: structures().flat_map(set).collect(),
            occluders: context.occluders.iter().map(|e| e.info.name.to_owned()).collect(),
        })
    }

    /// An argument that takes names, with the names; files are completed beside them.
    fn completed(&self, arg: Arg) -> Arg {
        let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<String>>();
        let values = match arg.get_id().as_str() {
            "scene" | "scenes" => self.scenes.clone(),
            "structure" | "reference" | "through" => self.structures.clone(),
            "structures" => {
                let occluders = self.occluders.iter().cloned();
                self.structures.iter().cloned().chain(occluders).chain(["all".into()]).collect()
            }
            "overrides" => self.overrides.clone(),
            "parameter" => self.parameters.clone(),
            "shadows" => self.occluders.clone(),
            "rays" | "kind" => words(&RayKind::ALL.map(|kind| kind.name())),
            "tracers" => TRACERS.iter().map(|t| t.name.to_owned()).collect(),
            "axes" => AXES.iter().map(|axis| axis.name.to_owned()).collect(),
            _ => return arg,
        };
        // numbers of rays, and words that are chosen from already
        if values.is_empty() || !arg.get_possible_values().is_empty() {
            return arg;
        }
        // names of the library live as long as the program, which ends with this command
        let values = values.into_iter().map(|name| -> &'static str { name.leak() });
        arg.value_parser(PossibleValuesParser::new(values))
    }
}

fn params(info: &'static StructureInfo) -> impl Iterator<Item = &'static ParamSpec> {
    info.params.iter().chain(COMMON)
}

/// A structure, and with each of its settings: the values of those that have few.
fn with_settings(info: &'static StructureInfo) -> impl Iterator<Item = String> {
    let settings = info.params.iter().flat_map(move |p| match p.kind {
        ParamKind::Choice(words) => {
            let with = words.iter().map(|word| format!("{}:{}={word}", info.name, p.name));
            with.collect::<Vec<String>>()
        }
        _ => vec![format!("{}:{}=", info.name, p.name)],
    });
    std::iter::once(info.name.to_owned()).chain(settings)
}
