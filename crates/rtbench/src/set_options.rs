//! What a set file (`scenes/sets/*.json`) has for commands over its set: options of runs (`run` and
//! `quick`), added to a command line that does not give them, and thresholds of `check` for rows and
//! kinds of rays.
//!
//! Options become arguments, read by the very parser of the command line. So what is valid there is
//! valid here, and a run's journal and record hold what it was really asked for.

use std::ffi::OsString;

use clap::parser::ValueSource;
use clap::{ArgMatches, Command, CommandFactory};
use serde_json::Value;

use crate::args::{Cli, percent};
use crate::context::Context;
use crate::gate::thresholds::{RowThreshold, quantity_named};
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::select;
use measurement::scenes::{SceneCatalogue, SceneSet, SceneSource, SetThreshold};
use measurement::settings::choice;

/// Options that a set file may not have: scenes are the set's own, output files the user's, and
/// plugins are code.
const NOT_IN_SETS: [&str; 11] = [
    "help",
    "version",
    "scenes",
    "as_set",
    "output",
    "overwrite",
    "resume",
    "shard",
    "plugin",
    "in_process",
    "plugin_limit",
];

/// Alternatives: one that is typed takes both from the set.
const ALTERNATIVES: [&str; 2] = ["rounds", "time_budget"];

/// The arguments that the set of a run adds to its command line: the one set that it is a run of,
/// or that of `--as`.
pub fn added_by_set(
    arguments: &[OsString],
    scenes: &dyn SceneSource,
) -> Result<Vec<OsString>, PlanError> {
    let cli = Cli::command();
    let Ok(matches) = cli.clone().try_get_matches_from(arguments) else { return Ok(Vec::new()) };
    let run = run_of(&matches).filter(|run| !is_typed(run, "resume"));
    let Some(run) = run else { return Ok(Vec::new()) };
    let named: Vec<String> = run.get_many("scenes").into_iter().flatten().cloned().collect();
    let as_set = run.get_one::<String>("as_set").map(String::as_str);
    let Some(set) = set_of(as_set, &named) else { return Ok(Vec::new()) };
    let catalogue = scenes.catalogue()?;
    let own = catalogue.sets().find(|own| own.name == set);
    let quick = own.iter().filter(|_| is_typed(run, "quick")).flat_map(|own| own.quick.clone());
    let mut options = own.map(|own| own.run.clone()).unwrap_or_default();
    options.extend(quick);
    if options.is_empty() && is_typed(run, "as_set") {
        let has = |set: &SceneSet| !set.run.is_empty();
        return Err(without("set with options of its own", set, &catalogue, has));
    }
    let Some(known) = cli.find_subcommand("run") else { return Ok(Vec::new()) };
    let mut added = Vec::new();
    for (name, value) in &options {
        let (id, arguments) = option(&cli, known, name, value)
            .map_err(|why| PlanError::Invalid(format!("scenes/sets/{set}.json: run: {why}")))?;
        if !is_given(run, &id) {
            added.extend(arguments);
        }
    }
    Ok(added)
}

/// The set whose defaults are taken: that of `--as`, or the only scene, if that is a set.
fn set_of<'s>(as_set: Option<&'s str>, scenes: &'s [String]) -> Option<&'s str> {
    match (as_set, scenes) {
        (None, [only]) => Some(only),
        (as_set, _) => as_set,
    }
}

/// Puts arguments behind those that were typed, but before `--` and what follows it.
pub fn join<T: PartialEq<str>>(typed: &mut Vec<T>, added: impl IntoIterator<Item = T>) {
    let end = typed.iter().position(|a| *a == *"--").unwrap_or(typed.len());
    typed.splice(end..end, added);
}

/// Options of a run: of `run` itself, or of the one that a baseline is made by.
fn run_of(matches: &ArgMatches) -> Option<&ArgMatches> {
    match matches.subcommand()? {
        ("run", run) => Some(run),
        ("baseline", baseline) => match baseline.subcommand()? {
            ("save", run) => Some(run),
            _ => None,
        },
        _ => None,
    }
}

/// Returns whether the command line has the option, or an alternative to it.
fn is_given(run: &ArgMatches, id: &str) -> bool {
    let is_alternative = ALTERNATIVES.contains(&id);
    is_typed(run, id) || is_alternative && ALTERNATIVES.iter().any(|id| is_typed(run, id))
}

/// Returns whether an argument was given on the command line.
fn is_typed(matches: &ArgMatches, id: &str) -> bool {
    let known = matches.try_contains_id(id).unwrap_or(false);
    known && matches.value_source(id) == Some(ValueSource::CommandLine)
}

/// The option that a key with a value stands for, if the command line takes it: clap's name of it, and
/// what would have been typed.
fn option(
    cli: &Command,
    run: &Command,
    name: &str,
    value: &Value,
) -> Result<(String, Vec<OsString>), String> {
    let (id, arguments) = typed(run, name, value)?;
    let words = ["rtbench", "run"].map(OsString::from).into_iter();
    let alone = cli.clone().try_get_matches_from(words.chain(arguments.clone()));
    alone.map_err(|error| {
        let text = error.render().to_string();
        let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
        format!("{name}: {first}")
    })?;
    Ok((id, arguments))
}

fn typed(run: &Command, name: &str, value: &Value) -> Result<(String, Vec<OsString>), String> {
    let long_of = |a: &clap::Arg| a.get_long().unwrap_or(a.get_id().as_str()).to_owned();
    let Some(known) = run.get_arguments().find(|a| long_of(a) == name) else {
        let options = run.get_arguments().filter(|a| !NOT_IN_SETS.contains(&a.get_id().as_str()));
        let valid: Vec<String> = options.map(long_of).collect();
        let hint = choice::hint(name, valid.iter().map(String::as_str));
        return Err(format!("unknown option '{name}'{hint}; valid: {}", valid.join(", ")));
    };
    let id = known.get_id().to_string();
    if NOT_IN_SETS.contains(&&*id) {
        return Err(format!("{name}: not an option of sets"));
    }
    if !known.get_action().takes_values() {
        let is_set = value.as_bool().ok_or_else(|| format!("{name}: expected true or false"))?;
        let arguments = if is_set { vec![format!("--{name}").into()] } else { Vec::new() };
        return Ok((id, arguments));
    }
    let is_list = matches!(known.get_action(), clap::ArgAction::Append);
    let values = match value {
        Value::Array(values) if is_list => values.as_slice(),
        value => std::slice::from_ref(value),
    };
    let mut arguments = Vec::new();
    for value in values {
        let text = match value {
            Value::String(text) => text.clone(),
            Value::Number(number) => number.to_string(),
            _ if is_list => {
                return Err(format!("{name}: expected a list of strings: [\"a\", \"b\"]"));
            }
            _ => return Err(format!("{name}: expected a string or a number")),
        };
        arguments.push(format!("--{name}={text}").into());
    }
    Ok((id, arguments))
}

/// The error that a set lacks something, with the names of those that have it.
fn without(
    what: &'static str,
    set: &str,
    catalogue: &SceneCatalogue,
    has: impl Fn(&SceneSet) -> bool,
) -> PlanError {
    let able = catalogue.sets().filter(|set| has(set));
    let mut valid: Vec<&str> = able.map(|set| &*set.name).collect();
    if valid.is_empty() {
        valid.push("none");
    }
    PlanError::unknown(what, set, valid)
}

/// The thresholds of the set that a check names: by `--as`, or as its only scene.
pub fn thresholds_of_check(
    context: &Context<'_>,
    as_set: Option<&str>,
    scenes: &[String],
) -> Result<Vec<RowThreshold>, PlanError> {
    let Some(set) = set_of(as_set, scenes) else { return Ok(Vec::new()) };
    let catalogue = context.scenes.catalogue()?;
    let entries = catalogue.sets().find(|own| own.name == set).map_or(&[][..], |own| &own.check);
    if entries.is_empty() && as_set.is_some() {
        let has = |set: &SceneSet| !set.check.is_empty();
        return Err(without("set with thresholds of its own", set, &catalogue, has));
    }
    let read = |(entry, own): (usize, &SetThreshold)| {
        let place = format!("scenes/sets/{set}.json: check, entry {entry}");
        threshold(context, own).map_err(|why| PlanError::Invalid(format!("{place}: {why}")))
    };
    (1..).zip(entries).map(read).collect()
}

/// Reads an entry, or describes its fault.
fn threshold(context: &Context<'_>, entry: &SetThreshold) -> Result<RowThreshold, String> {
    let row = entry.row.as_deref().map(|text| row(context, text)).transpose()?;
    let of = entry.of.as_deref().map(quantity_named).transpose()?;
    let read = |name: &str, text: &Option<String>| {
        let read = text.as_deref().map(percent).transpose();
        read.map_err(|why| format!("{name}: {why}"))
    };
    let time = read("time-threshold", &entry.time_threshold)?;
    let instructions = read("instruction-threshold", &entry.instruction_threshold)?;
    if time.is_none() && instructions.is_none() {
        return Err("expected a time-threshold or an instruction-threshold".into());
    }
    if row.is_none() && of.is_none() {
        return Err("expected a row or a quantity (of); -t is the threshold of all".into());
    }
    let threshold = RowThreshold { row, of, time, instructions };
    match threshold.kind() {
        Some(kind) if instructions.is_some() => Err(format!(
            "instruction-threshold: instructions of {kind} rays are not counted separately"
        )),
        _ => Ok(threshold),
    }
}

/// A structure, or the label of a row.
fn row(context: &Context<'_>, text: &str) -> Result<String, String> {
    let named = [text.to_owned()];
    let (structures, occluders) = select(context.registry, context.occluders, &named, &[])
        .map_err(|error| error.to_string())?;
    if !text.contains([':', ' ']) {
        return Ok(text.to_owned());
    }
    let labels = structures.iter().map(|row| row.label());
    let mut labels = labels.chain(occluders.iter().map(|row| row.label()));
    labels.next().ok_or_else(|| format!("{text}: no row"))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use measurement::scenes::{InstalledScenes, KnownScene, LoadError};

    struct SingleSet(Value);

    impl SceneSource for SingleSet {
        fn resolve(&self, _: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
            Ok(Vec::new())
        }

        fn catalogue(&self) -> Result<SceneCatalogue, LoadError> {
            let folder = tempfile::tempdir().unwrap();
            let sets = folder.path().join("sets");
            std::fs::create_dir(&sets).unwrap();
            let write = |name: &str, run: &Value, quick: Value| {
                let set = json!({"name": name, "title": "", "scenes": ["tetra"], "run": run,
                                 "quick": quick});
                std::fs::write(sets.join(format!("{name}.json")), set.to_string()).unwrap();
            };
            write("own", &self.0, json!({"size": 64}));
            write("plain", &json!({}), json!({}));
            let mut catalogue = SceneCatalogue::default();
            catalogue.add_folder(folder.path())?;
            Ok(catalogue)
        }
    }

    fn joined(options: Value, typed: &str) -> Result<String, String> {
        let mut arguments: Vec<OsString> = typed.split_whitespace().map(Into::into).collect();
        let added = added_by_set(&arguments, &SingleSet(options)).map_err(|e| e.to_string())?;
        join(&mut arguments, added);
        Ok(arguments.iter().map(|a| a.to_str().unwrap()).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn a_set_supplies_options_not_on_the_command_line() {
        let of = |typed: &str| {
            let options = json!({"size": 1024, "order": "both", "structures": ["hug", "octree"],
                                 "by-kind": true});
            joined(options, typed).unwrap()
        };
        let all = "--by-kind --order=both --size=1024 --structures=hug --structures=octree";
        for typed in ["run own", "run tetra balls --as own", "baseline save main own"] {
            let typed = format!("rtbench {typed}");
            assert_eq!(of(&typed), format!("{typed} {all}"));
        }
        let typed = "rtbench run own -s octree --order scanline";
        assert_eq!(of(typed), format!("{typed} --by-kind --size=1024"));
        assert!(of("rtbench run own --quick").contains("--size=64"));
        // no other runs, no other commands
        for typed in ["run", "run own tetra", "run plain", "list sets", "baseline list"] {
            let typed = format!("rtbench {typed}");
            assert_eq!(of(&typed), typed);
        }
    }

    #[test]
    fn flags_alternatives_and_separators_are_respected() {
        let of = |options, typed| joined(options, typed).unwrap();
        let options = || json!({"rounds": 7, "quick": false, "seed": 3});
        assert_eq!(of(options(), "rtbench run own"), "rtbench run own --rounds=7 --seed=3");
        let typed = "rtbench run own --time-budget 9s";
        assert_eq!(of(options(), typed), format!("{typed} --seed=3"));
        let separated = of(options(), "rtbench run --rounds 2 -- own");
        assert_eq!(separated, "rtbench run --rounds 2 --seed=3 -- own");
        for typed in ["rtbench run --resume x", "rtbench run own --bogus"] {
            assert_eq!(of(options(), typed), typed);
        }
    }

    #[test]
    fn unknown_options_of_a_set_are_errors_that_name_it() {
        let of = |options| joined(options, "rtbench run own").unwrap_err();
        let error = of(json!({"szie": 9}));
        let said = "own.json: run: unknown option 'szie' (did you mean 'size'?)";
        assert!(error.contains(said), "{error}");
        for (options, said) in [
            (json!({"size": 0}), "own.json: run: size: "),
            (json!({"scenes": ["tetra"]}), "scenes: not an option of sets"),
            (json!({"size": null}), "size: expected a string or a number"),
            (json!({"by-kind": "yes"}), "by-kind: expected true or false"),
            (json!({"structures": [1, {}]}), "structures: expected a list of strings"),
            (json!({"plugin": ["evil.so"]}), "plugin: not an option of sets"),
            (json!({"resume": "x"}), "resume: not an option of sets"),
        ] {
            let error = of(options);
            assert!(error.contains(said), "{said}: {error}");
        }
        let error = joined(json!({"size": 9}), "rtbench run tetra --as onw").unwrap_err();
        assert!(error.contains("'onw' (did you mean 'own'?); valid: own"), "{error}");
    }

    #[test]
    fn the_sets_that_the_program_carries_are_valid() {
        let mut with_options = Vec::new();
        for SceneSet { name: set, .. } in InstalledScenes.catalogue().unwrap().sets() {
            for quick in ["", "--quick"] {
                let words = ["rtbench", "run", set, quick];
                let words = words.into_iter().filter(|word| !word.is_empty());
                let arguments: Vec<OsString> = words.map(Into::into).collect();
                if !added_by_set(&arguments, &InstalledScenes).unwrap().is_empty() {
                    with_options.push(set.clone());
                }
            }
        }
        assert_eq!(with_options, ["speed", "speed"]);
    }
}
