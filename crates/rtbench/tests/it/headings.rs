//! Help: each option stands under a heading that its own struct names.

use clap::{Args, Command, CommandFactory, Parser};
use rtbench::args::Cli;

/// Structs that name a heading. Options of all others stand under "Options".
const HEADINGS: [(&str, &str); 6] = [
    ("ViewArgs", "View and lights"),
    ("MeasuringArgs", "Measuring"),
    ("SamplingArgs", "Sampling"),
    ("PluginArgs", "Plugins"),
    ("TableArgs", "Tables"),
    ("exports", "Files"),
];

/// Options of structs into which `MeasuringArgs` is flattened.
const BESIDE_MEASURING: [&str; 6] =
    ["time_budget", "reference", "order", "lights", "pass_limit", "max_memory"];

/// Options of a command and of those below it that stand under a heading of another struct. The
/// groups that clap derives from structs have members where nothing is flattened into them: the
/// options of all others are expected under no heading.
fn misplaced(command: &Command) -> Vec<String> {
    let mut found: Vec<String> = command.get_subcommands().flat_map(misplaced).collect();
    let is_any_of = |name: &str| command.get_groups().any(|group| group.get_id() == name);
    for arg in command.get_arguments().filter(|arg| !arg.is_positional()) {
        let is_of = |name: &str| {
            let mut groups = command.get_groups().filter(|group| group.get_id() == name);
            groups.any(|group| group.get_args().any(|id| id == arg.get_id()))
        };
        let named = HEADINGS.iter().find(|(name, _)| is_of(name));
        let id = arg.get_id().as_str();
        // `sweep` has a limit of its own
        let is_own = (command.get_name(), id) == ("sweep", "max_memory");
        let is_nested = is_any_of("MeasuringArgs") && BESIDE_MEASURING.contains(&id) && !is_own;
        let nested = is_nested.then_some("Measuring");
        let expected = named.map(|(_, heading)| *heading).or(nested);
        let is_of_all = arg.is_global_set() && arg.get_help_heading() == Some("Every command");
        if arg.get_help_heading() != expected && !is_of_all {
            let (name, heading) = (command.get_name(), arg.get_help_heading());
            found
                .push(format!("{name}: {} under {heading:?}, expected {expected:?}", arg.get_id()));
        }
    }
    found
}

#[test]
fn options_stand_under_the_heading_of_their_struct() {
    let found = misplaced(&Cli::command());
    assert!(found.is_empty(), "{found:#?}");
}

/// Commands whose option of structures does not take both `--structures` and `--structure`.
fn one_name_only(command: &Command) -> Vec<String> {
    let mut found: Vec<String> = command.get_subcommands().flat_map(one_name_only).collect();
    let ours = |arg: &&clap::Arg| ["structure", "structures"].contains(&arg.get_id().as_str());
    for arg in command.get_arguments().filter(ours) {
        let names = arg.get_long_and_visible_aliases().into_iter().flatten();
        let hidden = arg.get_all_aliases().into_iter().flatten();
        let names: Vec<&str> = names.chain(hidden).collect();
        if !["structure", "structures"].iter().all(|name| names.contains(name)) {
            found.push(format!("{}: {names:?}", command.get_name()));
        }
    }
    found
}

#[test]
fn structures_are_named_in_singular_and_plural() {
    assert_eq!(one_name_only(&Cli::command()), [""; 0]);
    let planted = Command::new("x").arg(clap::Arg::new("structures").long("structures"));
    assert_eq!(one_name_only(&planted), ["x: [\"structures\"]"]);
}

#[test]
fn an_option_under_the_heading_of_another_struct_is_found() {
    #[derive(Args)]
    #[command(next_help_heading = "View and lights")]
    struct ViewArgs {
        #[arg(long)]
        inner: bool,
    }
    #[derive(Parser)]
    struct Outer {
        #[arg(long)]
        before: bool,
        #[command(flatten)]
        inner: ViewArgs,
        #[arg(long, help_heading = "View and lights")]
        after: bool,
    }
    let found = misplaced(&Outer::command());
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("after under Some(\"View and lights\")"), "{found:?}");
    let _ = |outer: Outer| (outer.before, outer.inner.inner, outer.after);
}
