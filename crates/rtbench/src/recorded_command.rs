//! The command line as results show it: what to type, without the folders of one machine.

use std::path::Path;

/// The command line of a record: the program is `rtbench`, whatever it was started as. An absolute
/// path within `folder` becomes relative to it; of any other absolute path the last name stays.
pub fn recorded(command_line: &[String], folder: Option<&Path>) -> Vec<String> {
    let arguments = command_line.iter().skip(1).map(|argument| without_folders(argument, folder));
    std::iter::once("rtbench".to_owned()).chain(arguments).collect()
}

/// One argument: a path alone, behind `--name=`, or behind a letter as in `-oPATH`.
fn without_folders(argument: &str, folder: Option<&Path>) -> String {
    let value = match argument.strip_prefix("--") {
        Some(long) => long.split_once('=').map_or("", |(_, value)| value),
        None if argument.starts_with('-') => argument.get(2..).unwrap_or_default(),
        None => argument,
    };
    let (name, path) = (argument.strip_suffix(value).unwrap_or_default(), Path::new(value));
    if !path.is_absolute() {
        return argument.to_owned();
    }
    let inside = folder.and_then(|folder| path.strip_prefix(folder).ok());
    let shown = match inside {
        Some(inside) if inside.as_os_str().is_empty() => ".".into(),
        Some(inside) => inside.to_string_lossy(),
        None => path.file_name().unwrap_or_default().to_string_lossy(),
    };
    format!("{name}{shown}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn recorded_commands_name_no_folder_of_the_machine() {
        let typed = "/home/me/rtbench/target/release/rtbench run /data/hall.obj kitchen -o /tmp/out \
                     --export-csv=/home/me/rtbench/out/a.csv -o/tmp/x/y --baselines /home/me/rtbench \
                     -s grid:a=1 --set uniform-grid.density=4 --export-json - results/one ../b";
        let typed: Vec<String> = typed.split_whitespace().map(str::to_owned).collect();
        let expected = "rtbench run hall.obj kitchen -o out --export-csv=out/a.csv -oy --baselines . \
                        -s grid:a=1 --set uniform-grid.density=4 --export-json - results/one ../b";
        let recorded = recorded(&typed, Some(Path::new("/home/me/rtbench")));
        assert_eq!(recorded, expected.split_whitespace().collect::<Vec<_>>());
        // it stays as it is when it is recorded again
        assert_eq!(super::recorded(&recorded, None), recorded);
    }

    #[test]
    fn a_process_without_arguments_is_rtbench() {
        assert_eq!(recorded(&[], None), ["rtbench"]);
        assert_eq!(recorded(&["./rtbench".into(), String::new()], None), ["rtbench", ""]);
    }
}
