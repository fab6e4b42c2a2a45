//! What the library's scripts lack: names behind commas and colons, options behind the first of several
//! arguments (zsh), and names of arguments without an option (fish).

use std::fmt::Write;

use clap::{Arg, Command};
use clap_complete::Shell;

/// The script of a shell, with what it lacks.
pub(super) fn completed(shell: Shell, script: String, cli: &Command) -> String {
    match shell {
        Shell::Bash => script + include_str!("whole_words.bash"),
        Shell::Zsh => script.lines().map(|line| zsh_line(line) + "\n").collect(),
        Shell::Fish => {
            let mut script = script + include_str!("lists.fish");
            for command in cli.get_subcommands().filter(|c| !c.is_hide_set()) {
                let condition = format!("__fish_rtbench_using_subcommand {}", command.get_name());
                fish_names(command, &condition, &mut script);
                for below in command.get_subcommands() {
                    let seen = format!("__fish_seen_subcommand_from {}", below.get_name());
                    fish_names(below, &format!("{condition}; and {seen}"), &mut script);
                }
            }
            script
        }
        _ => script,
    }
}

/// `'*::` takes the rest of the line for arguments: options are not completed there any more. Names are a list where
/// there may be several behind an option.
fn zsh_line(line: &str) -> String {
    let is_rest = line.strip_prefix("'*::").is_some_and(|rest| !rest.starts_with(':'));
    let line = if is_rest { line.replacen("'*::", "'*:", 1) } else { line.to_owned() };
    let is_list = ["'*-s+[", "'*--structures=[", "'*--rays=[", "'*--kind=[", "'*--tracers=["];
    match line
        .rsplit_once(":(")
        .and_then(|(before, names)| Some((before, names.strip_suffix(")' \\")?)))
    {
        Some((before, names)) if is_list.iter().any(|begin| line.starts_with(begin)) => {
            format!("{before}: _sequence compadd - {names}' \\")
        }
        _ => line,
    }
}

/// Adds the names of a command's arguments without an option, and of lists behind options.
fn fish_names(command: &Command, condition: &str, script: &mut String) {
    for arg in command.get_arguments().filter(|arg| !arg.is_hide_set()) {
        let names = plain_names(arg);
        if names.is_empty() {
            continue;
        }
        let begin = format!("complete -c rtbench -n \"{condition}\"");
        // what cannot be written to a String
        let _ = match (arg.is_positional(), arg.get_value_delimiter()) {
            (true, _) => writeln!(script, "{begin} -a \"{names}\""),
            (false, Some(',')) => {
                let short = arg.get_short().map(|c| format!(" -s {c}")).unwrap_or_default();
                let long = arg.get_long().map(|name| format!(" -l {name}")).unwrap_or_default();
                writeln!(script, "{begin}{short}{long} -x -a \"(__fish_rtbench_list {names})\"")
            }
            _ => Ok(()),
        };
    }
}

/// The names that an argument takes, those that no shell reads as more than a word.
fn plain_names(arg: &Arg) -> String {
    let is_plain =
        |name: &&str| name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.:=/".contains(c));
    let values = arg.get_possible_values();
    let names: Vec<&str> = values.iter().map(|v| v.get_name()).filter(is_plain).collect();
    names.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zsh_goes_on_behind_arguments_and_in_lists() {
        assert_eq!(zsh_line("'*::scenes -- Scenes:(a b)' \\"), "'*:scenes -- Scenes:(a b)' \\");
        assert_eq!(zsh_line("'*::: :->rtbench' \\"), "'*::: :->rtbench' \\");
        assert_eq!(
            zsh_line("'*-s+[Rows]:STRUCTURE:(a a\\:b=)' \\"),
            "'*-s+[Rows]:STRUCTURE: _sequence compadd - a a\\:b=' \\"
        );
        assert_eq!(zsh_line("'--sort=[Order]:SORT:(a b)' \\"), "'--sort=[Order]:SORT:(a b)' \\");
    }

    #[test]
    fn fish_gets_plain_names_alone() {
        let names = ["a", "$(b)", "c:d=1"];
        let of = |arg: Arg| arg.value_parser(names);
        let rows = of(Arg::new("rows").short('s').long("rows").value_delimiter(','));
        let command = Command::new("x").arg(of(Arg::new("scene"))).arg(rows);
        let mut script = String::new();
        fish_names(&command, "here", &mut script);
        assert_eq!(
            script,
            "complete -c rtbench -n \"here\" -a \"a c:d=1\"\n\
             complete -c rtbench -n \"here\" -s s -l rows -x -a \"(__fish_rtbench_list a c:d=1)\"\n"
        );
    }
}
