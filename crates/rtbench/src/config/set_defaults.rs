//! Options that a set of scenes has for its runs: its rays, sizes and rows, as if they had been typed.
//!
//! A set is there for a question, and the question is more than its scenes: `speed` asks for many rays
//! of three kinds in two orders. What is typed, and what a configuration says, goes before.

use std::ffi::OsString;

use clap::{ArgMatches, CommandFactory};
use toml::Value;

use crate::args::Cli;
use crate::config::defaults::{is_typed, not_typed, valid_default};
use crate::config::file::ConfigError;
use measurement::plan::error::PlanError;
use measurement::scenes::SceneSource;
use measurement::settings::suggest;

/// What belongs to one run, and not to a question: scenes are the set's own, files the user's.
const NOT_IN_SETS: [&str; 4] = ["scenes", "as", "output", "shard"];

/// What the set of a run adds to its command line: the one set that it is a run of, or that of `--as`.
///
/// # Errors
/// [`PlanError::UnknownName`] for a set of `--as` that has no options, [`ConfigError::InSet`].
pub fn of_set(
    arguments: &[OsString],
    scenes: &dyn SceneSource,
) -> Result<Vec<OsString>, ConfigError> {
    let cli = Cli::command();
    let Ok(matches) = cli.clone().try_get_matches_from(arguments) else { return Ok(Vec::new()) };
    let Some(run) = run_of(&matches) else { return Ok(Vec::new()) };
    if is_typed(run, "resume") {
        return Ok(Vec::new());
    }
    let named: Vec<&String> = run.get_many("scenes").into_iter().flatten().collect();
    let set = match (run.get_one::<String>("as_set"), &named[..]) {
        (Some(set), _) => set,
        (None, [only]) => only,
        _ => return Ok(Vec::new()),
    };
    let options = scenes.run_options(set, is_typed(run, "quick")).map_err(PlanError::Scene)?;
    if options.is_empty() && is_typed(run, "as_set") {
        return Err(without_options(set, scenes)?.into());
    }
    let Some(known) = cli.find_subcommand("run") else { return Ok(Vec::new()) };
    let mut defaults = Vec::new();
    for (name, value) in &options {
        let invalid = |message| ConfigError::InSet { set: set.clone(), message };
        if NOT_IN_SETS.contains(&&**name) {
            return Err(invalid(format!("{name}: not an option of sets")));
        }
        let value = Value::try_from(value).map_err(|e| invalid(format!("{name}: {e}")))?;
        defaults.push(valid_default(&cli, known, name, &value).map_err(invalid)?);
    }
    Ok(not_typed(run, defaults))
}

/// The options of a run: of `run` itself, or of the one that a baseline is made by.
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

fn without_options(set: &str, scenes: &dyn SceneSource) -> Result<PlanError, ConfigError> {
    let mut valid = Vec::new();
    for (name, _) in scenes.sets().map_err(PlanError::Scene)? {
        if !scenes.run_options(&name, false).map_err(PlanError::Scene)?.is_empty() {
            valid.push(name);
        }
    }
    Ok(PlanError::UnknownName {
        what: "set with options of its own",
        name: set.to_owned(),
        hint: suggest::hint(set, valid.iter().map(String::as_str)),
        valid: valid.join(", "),
    })
}

#[cfg(test)]
mod tests {
    use serde_json::{Map, json};

    use super::*;
    use crate::config::join;
    use measurement::scenes::{Installed, KnownScene, LoadError};

    /// A source with one set that has options.
    struct One(serde_json::Value);

    impl SceneSource for One {
        fn resolve(&self, _: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
            Ok(Vec::new())
        }

        fn scenes(&self) -> Result<Vec<(String, String)>, LoadError> {
            Ok(Vec::new())
        }

        fn sets(&self) -> Result<Vec<(String, Vec<String>)>, LoadError> {
            Ok(vec![("own".into(), Vec::new()), ("plain".into(), Vec::new())])
        }

        fn run_options(
            &self,
            set: &str,
            quick: bool,
        ) -> Result<Map<String, serde_json::Value>, LoadError> {
            let mut options = Map::new();
            if set == "own" {
                options.extend(self.0.as_object().unwrap().clone());
                options.extend(quick.then(|| ("size".to_owned(), json!(64))));
            }
            Ok(options)
        }
    }

    fn joined(options: serde_json::Value, typed: &str) -> Result<String, String> {
        let mut arguments: Vec<OsString> = typed.split_whitespace().map(Into::into).collect();
        let added = of_set(&arguments, &One(options)).map_err(|e| e.to_string())?;
        join(&mut arguments, added);
        Ok(arguments.iter().map(|a| a.to_str().unwrap()).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn the_set_says_what_the_command_line_does_not() {
        let of = |typed| {
            let options = json!({"size": 1024, "order": "both", "structures": ["hug", "octree"],
                                 "by-kind": true});
            joined(options, typed).unwrap()
        };
        let all = "--by-kind --order=both --size=1024 --structures=hug --structures=octree";
        for typed in [
            "rtbench run own",
            "rtbench run tetra balls --as own",
            "rtbench baseline save main own",
        ] {
            assert_eq!(of(typed), format!("{typed} {all}"));
        }
        assert_eq!(
            of("rtbench run own -s octree --order scanline"),
            "rtbench run own -s octree --order scanline --by-kind --size=1024"
        );
        assert!(of("rtbench run own --quick").contains("--size=64"));
        // no other runs, no other commands
        for typed in [
            "rtbench run",
            "rtbench run own tetra",
            "rtbench run plain",
            "rtbench list sets",
            "rtbench baseline list",
        ] {
            assert_eq!(of(typed), typed);
        }
    }

    #[test]
    fn what_is_not_known_is_an_error_that_names_the_set() {
        let of = |options| joined(options, "rtbench run own").unwrap_err();
        let error = of(json!({"szie": 9}));
        let said = "own.json: run: unknown option 'szie' (did you mean 'size'?)";
        assert!(error.contains(said), "{error}");
        assert!(of(json!({"size": 0})).contains("own.json: run: size: "));
        assert!(of(json!({"scenes": ["tetra"]})).contains("scenes: not an option of sets"));
        assert!(of(json!({"size": null})).contains("size"));
        let error = joined(json!({"size": 9}), "rtbench run tetra --as onw").unwrap_err();
        assert!(error.contains("'onw' (did you mean 'own'?); valid: own"), "{error}");
    }

    #[test]
    fn the_sets_that_the_program_carries_are_valid() {
        let mut with_options = Vec::new();
        for (set, _) in Installed.sets().unwrap() {
            for quick in ["", "--quick"] {
                let words = ["rtbench", "run", &set, quick];
                let words = words.into_iter().filter(|word| !word.is_empty());
                let arguments: Vec<OsString> = words.map(Into::into).collect();
                if !of_set(&arguments, &Installed).unwrap().is_empty() {
                    with_options.push(set.clone());
                }
            }
        }
        assert_eq!(with_options, ["speed", "speed"]);
    }
}
