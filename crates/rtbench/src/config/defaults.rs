//! The table `[run]`: options of `run` by their long names, as if they had been typed first.
//!
//! They become arguments, read by the very parser of the command line. So what is valid there is
//! valid here, and a run's journal and record hold what it was really asked for.

use std::ffi::OsString;

use clap::parser::ValueSource;
use clap::{ArgMatches, Command, CommandFactory};
use toml::Value;

use crate::args::Cli;
use crate::config::file::{Config, ConfigError};
use measurement::settings::suggest;

/// What may not stand in a file: what belongs to one run alone, and what runs a stranger's code.
const NOT_THERE: [&str; 7] =
    ["help", "overwrite", "resume", "version", "plugin", "in_process", "plugin_limit"];

/// Options of which the later one wins, whatever their names: one typed takes both from the file.
const ALTERNATIVES: [[&str; 2]; 1] = [["rounds", "time_budget"]];

/// What a key of the table stands for.
pub(super) struct OptionDefault {
    /// Clap's name of the option.
    id: String,
    /// What would have been typed.
    arguments: Vec<OsString>,
}

impl Config {
    /// Every key of `[run]` is an option and every value is valid.
    pub(super) fn validate_run(&self) -> Result<(), ConfigError> {
        for (name, members) in &self.tables.sets {
            if members.get_ref().is_empty() {
                let name = name.get_ref();
                return Err(self.invalid(members.span(), format!("the set '{name}' has no scenes")));
            }
        }
        self.run_defaults().map(|_| ())
    }

    /// What `[run]` adds to a command line, where it is a `run` and does not say otherwise; see
    /// [`join`].
    ///
    /// # Errors
    /// [`ConfigError::Invalid`] naming the line.
    pub fn added_to(&self, arguments: &[OsString]) -> Result<Vec<OsString>, ConfigError> {
        let Ok(matches) = Cli::command().try_get_matches_from(arguments) else {
            return Ok(Vec::new());
        };
        let Some(("run", run)) = matches.subcommand() else { return Ok(Vec::new()) };
        if is_typed(run, "resume") {
            return Ok(Vec::new());
        }
        Ok(not_typed(run, self.run_defaults()?))
    }

    fn run_defaults(&self) -> Result<Vec<OptionDefault>, ConfigError> {
        let cli = Cli::command();
        let Some(run) = cli.find_subcommand("run") else { return Ok(Vec::new()) };
        let mut defaults = Vec::new();
        for (key, value) in &self.tables.run {
            let name = key.get_ref();
            let default = valid_default(&cli, run, name, value.get_ref());
            defaults.push(default.map_err(|message| self.invalid(key.span(), message))?);
        }
        Ok(defaults)
    }
}

/// What the defaults add to a `run` that does not say otherwise.
pub(super) fn not_typed(run: &ArgMatches, defaults: Vec<OptionDefault>) -> Vec<OsString> {
    let is_left = |default: &OptionDefault| {
        let others = ALTERNATIVES.iter().find(|all| all.contains(&&*default.id));
        let is_typed_otherwise = others.is_some_and(|all| all.iter().any(|id| is_typed(run, id)));
        !is_typed(run, &default.id) && !is_typed_otherwise
    };
    defaults.into_iter().filter(is_left).flat_map(|default| default.arguments).collect()
}

/// What a key with a value stands for, if the command line takes it.
///
/// # Errors
/// What is wrong, and what is valid.
pub(super) fn valid_default(
    cli: &Command,
    run: &Command,
    name: &str,
    value: &Value,
) -> Result<OptionDefault, String> {
    let default = default(run, name, value)?;
    let typed = ["rtbench", "run"].map(OsString::from).into_iter();
    let alone = cli.clone().try_get_matches_from(typed.chain(default.arguments.clone()));
    alone.map_err(|error| {
        let text = error.render().to_string();
        let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
        format!("{name}: {first}")
    })?;
    Ok(default)
}

/// Puts arguments behind those that were typed, but before `--` and what follows it.
pub fn join<T: PartialEq<str>>(typed: &mut Vec<T>, added: impl IntoIterator<Item = T>) {
    let end = typed.iter().position(|a| *a == *"--").unwrap_or(typed.len());
    typed.splice(end..end, added);
}

/// Whether an argument was given on the command line.
pub(super) fn is_typed(matches: &ArgMatches, id: &str) -> bool {
    let known = matches.try_contains_id(id).unwrap_or(false);
    known && matches.value_source(id) == Some(ValueSource::CommandLine)
}

/// What a key with a value stands for.
fn default(run: &Command, name: &str, value: &Value) -> Result<OptionDefault, String> {
    let options = || run.get_arguments().filter(|a| !NOT_THERE.contains(&a.get_id().as_str()));
    let named = |a: &clap::Arg| match a.get_long() {
        Some(long) => long.to_owned(),
        None => a.get_id().to_string(),
    };
    let Some(option) = options().find(|a| named(a) == name) else {
        let valid: Vec<String> = options().map(named).collect();
        let hint = suggest::hint(name, valid.iter().map(String::as_str));
        return Err(format!("unknown option '{name}'{hint}; valid: {}", valid.join(", ")));
    };
    let id = option.get_id().to_string();
    if !option.get_action().takes_values() {
        let is_set = value.as_bool().ok_or_else(|| format!("{name}: expected true or false"))?;
        let arguments = if is_set { vec![format!("--{name}").into()] } else { Vec::new() };
        return Ok(OptionDefault { id, arguments });
    }
    let is_list = matches!(option.get_action(), clap::ArgAction::Append);
    let values = match value {
        Value::Array(values) if is_list => values.as_slice(),
        value => std::slice::from_ref(value),
    };
    let mut arguments = Vec::new();
    for value in values {
        let text = match value {
            Value::String(text) => text.clone(),
            Value::Integer(n) => n.to_string(),
            Value::Float(x) => x.to_string(),
            _ if is_list => return Err(format!("{name}: expected texts: [\"a\", \"b\"]")),
            _ => return Err(format!("{name}: expected a text or a number")),
        };
        arguments.push(match option.get_long() {
            Some(long) => format!("--{long}={text}").into(),
            None => text.into(),
        });
    }
    Ok(OptionDefault { id, arguments })
}

#[cfg(test)]
mod tests {
    use super::join;
    use crate::config::file::tests::read;

    const TEXT: &str = "[run]\nscenes = [\"tetra:2\", \"balls:1\"]\nrounds = 7\nquick = true\n\
                        seed = 3\nstructures = \"obvhs-cwbvh\"\nset = [\"uniform-grid.density=4\"]\n";

    fn joined(text: &str, typed: &str) -> String {
        let mut arguments: Vec<_> = typed.split_whitespace().map(Into::into).collect();
        let added = read(text).unwrap().added_to(&arguments).unwrap();
        join(&mut arguments, added);
        arguments.iter().map(|a| a.to_str().unwrap()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn the_file_says_what_the_command_line_does_not() {
        let all = joined(TEXT, "rtbench run");
        assert_eq!(
            all,
            "rtbench run --quick --rounds=7 tetra:2 balls:1 --seed=3 --set=uniform-grid.density=4 \
             --structures=obvhs-cwbvh"
        );
        let all = joined(TEXT, "rtbench run kitchen -s all --time-budget 9s -q");
        assert_eq!(
            all,
            "rtbench run kitchen -s all --time-budget 9s -q --quick --seed=3 \
             --set=uniform-grid.density=4"
        );
    }

    #[test]
    fn other_commands_and_resumed_runs_are_left_alone() {
        for typed in
            ["rtbench list sets", "rtbench run --resume x", "rtbench", "rtbench run --bogus"]
        {
            assert_eq!(joined(TEXT, typed), typed);
        }
        assert_eq!(joined("[run]\nquick = false\n", "rtbench run"), "rtbench run");
        let all = joined("[run]\nquick = true\n", "rtbench run -- tetra");
        assert_eq!(all, "rtbench run --quick -- tetra");
    }
}
