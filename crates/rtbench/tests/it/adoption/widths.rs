//! Text and tables are no wider than the terminal, and what matters most has room.

use crate::common::{Folder, run_within};

/// The lines that are wider than they may be.
fn too_wide(text: &str, width: usize) -> Vec<&str> {
    text.lines().filter(|line| line.trim_end().chars().count() > width).collect()
}

/// Commands with prose, tables, lists or warnings.
const COMMANDS: [&str; 9] = [
    "run tetra:2 --size 16 --rounds 2 -s uniform-grid:density=1,obvhs-cwbvh --columns ratio,build",
    "list structures",
    "list scenes",
    "list axes",
    "scenes info tetra:2",
    "accuracy mailbox --quick --scene tetra:2",
    "explain tetra:2 --size 16 --rounds 3",
    "reproduce zachmann2007 --scenes tetra --quick --size 8",
    "verify -j 1 --cases G1 -s uniform-grid --rays 100",
];

#[test]
fn text_fits_80_and_120_columns() {
    for width in [80, 120] {
        for command in COMMANDS {
            let ended = run_within(width, command);
            assert_eq!(ended.code, 0, "{command}: {}", ended.err);
            for text in [&ended.out, &ended.err] {
                assert_eq!(too_wide(text, width), [""; 0], "{command} within {width}");
            }
        }
    }
}

#[test]
fn tables_of_all_commands_that_judge_fit() {
    let folder = Folder::new();
    let path = folder.path();
    let rows =
        "-s uniform-grid:resolution=heterogeneous:density=20,kd-tree,obvhs-cwbvh:preset=fastest";
    let run = format!("run tetra:2 --quick --rounds 6 {rows}");
    assert_eq!(run_within(80, &format!("{run} -o {path}/a")).code, 0);
    assert_eq!(run_within(80, &format!("{run} -o {path}/b")).code, 0);
    let commands = [
        (
            "sweep tetra:2 --quick -s uniform-grid -p density --values 1,2".to_owned(),
            ["density ", "ratio [95%]", "to best", "mark"],
        ),
        (
            "sweep tetra --sizes 4..64 --quick -s uniform-grid,kd-tree --rounds 3".to_owned(),
            ["ns/ray", "ratio [95%]", "verdict", "trace [95%]"],
        ),
        (
            format!("compare {path}/a {path}/b -m all"),
            ["metric", "ratio [95%]", "outcome", "All scenes"],
        ),
        (
            format!("check --baseline {path}/a/results.json --all"),
            ["what", "change", "outcome", "answers: "],
        ),
    ];
    for (command, heads) in &commands {
        for width in [80, 120] {
            let ended = run_within(width, command);
            assert!(matches!(ended.code, 0 | 3), "{command}: {}", ended.err);
            // the last line of a check names its baseline, whole
            let tables = if command.starts_with("check") {
                ended.out.trim_end().rsplit_once('\n').unwrap().0
            } else {
                &ended.out
            };
            assert_eq!(too_wide(tables, width), [""; 0], "{command} within {width}");
            for head in heads {
                assert!(tables.contains(head), "{command} within {width} has no {head}:\n{tables}");
            }
        }
    }
    let narrow = run_within(80, &commands[0].0).out;
    let left_out = narrow.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(left_out.contains("Columns that do not fit: "), "{narrow}");
    let wide = run_within(400, &commands[0].0).out;
    assert!(wide.contains("second.") && !wide.contains("do not fit"), "{wide}");
    assert_eq!(too_wide("four\nfive5\nsix   ", 4), ["five5"]);
}
