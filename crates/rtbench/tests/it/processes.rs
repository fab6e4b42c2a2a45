//! `run --processes`, and the same run on several machines.

use accel_core::structures::REGISTRY;
use measurement::record::{RunRecord, Verdict};
use measurement::system::clock::SystemClock;
use rtbench::context::Environment;
use studies::accuracy::record::AccuracyRecord;

use crate::check::{run_timed, with_program};
use crate::common::{Ended, Folder, PLANTED};

fn run(folder: &Folder, arguments: &str) -> Ended {
    run_timed(REGISTRY, with_program(&folder.path()), &SystemClock::default(), arguments)
}

fn record(folder: &Folder, name: &str) -> RunRecord {
    serde_json::from_str(&folder.text(&format!("{name}/results.json"))).unwrap()
}

const TABLE: &str =
    "tetra:3 balls:1 --quick --size 12 -s uniform-grid,kd-tree,obvhs-cwbvh,light-buffer";

#[test]
fn figures_are_over_all_processes_and_a_copy_gives_the_floor() {
    let folder = Folder::new();
    let arguments = format!("run {TABLE} --processes 3 --rounds 4 -o {}/a", folder.path());
    let ended = run(&folder, &arguments);
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    assert!(ended.out.contains("3 processes: figures are geometric means"), "{}", ended.out);
    assert!(ended.out.contains("A/A floor "), "{}", ended.out);
    let record = record(&folder, "a");
    assert_eq!(record.settings.processes, 3);
    // three rows of structures have a ratio of builds and of traces each, but for the reference
    assert_eq!(record.floor.as_ref().unwrap().figures, 2 * 3 * 2);
    for row in record.scenes.iter().flat_map(|s| &s.rows) {
        assert_eq!(row.verdict, Verdict::Ok, "{}", row.label());
        let visits: Vec<_> = row.samples.iter().map(|s| (s.process, s.round)).collect();
        let expected = (0..12).map(|round| (round / 4, round));
        assert_eq!(visits, expected.collect::<Vec<_>>());
        assert!(row.samples.iter().all(|s| s.reference_trace_s.is_some()));
        let ratio = row.ratio.unwrap();
        assert!(row.is_reference || ratio.low < ratio.median && ratio.median < ratio.high);
    }
    // the same run in one process is another run to resume, and none to compare counters with
    let resumed = run(&folder, &format!("run --resume {}/a", folder.path()));
    assert_eq!(resumed.code, 0, "{}", resumed.err);
}

#[test]
fn a_process_that_gives_no_answer_is_an_error_that_names_it() {
    let folder = Folder::new();
    // the program does not know the structures that are planted here
    let arguments = "run tetra:2 --quick --size 12 -s dropper,obvhs-cwbvh --processes 2";
    let clock = SystemClock::default();
    let ended = run_timed(&PLANTED, with_program(&folder.path()), &clock, arguments);
    assert_ne!(ended.code, 0, "{}", ended.out);
    let unknown = run(&folder, "run tetra:2 --processes 0");
    assert_eq!(unknown.code, 2, "{}", unknown.err);
}

#[test]
fn accuracy_has_times_of_all_processes_and_errors_of_one() {
    let folder = Folder::new();
    let axes =
        "accuracy mailbox precision soft-shadows --scene balls:1 --quick --rounds 3 --trials 500";
    let read = |processes: u32| {
        let arguments = format!("{axes} --processes {processes} -o {}/{processes}", folder.path());
        let ended = run(&folder, &arguments);
        assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
        let text = folder.text(&format!("{processes}/accuracy.json"));
        serde_json::from_str::<AccuracyRecord>(&text).unwrap()
    };
    let (alone, of_two) = (read(1), read(2));
    assert_eq!((of_two.processes, of_two.rounds), (2, 3));
    let scenes = |record: &AccuracyRecord| {
        record.axes.iter().flat_map(|axis| axis.scenes.clone()).collect::<Vec<_>>()
    };
    for (one, two) in scenes(&alone).iter().zip(&scenes(&of_two)) {
        assert_eq!((one.processes, two.processes), (1, 2));
        for (one, two) in one.rows.iter().zip(&two.rows) {
            assert_eq!((&one.variant, one.error), (&two.variant, two.error));
            assert_eq!((one.seconds.len(), two.seconds.len()), (3, 6));
            assert!(two.parts.iter().all(|part| part.seconds.len() == 6));
        }
    }
    assert!(folder.text("2/accuracy.md").contains("2 processes of 3 rounds"));
    let environment =
        Environment { program: Some("/nowhere/rtbench".into()), ..with_program(&folder.path()) };
    let arguments = format!("{axes} --processes 2");
    let ended = run_timed(REGISTRY, environment, &SystemClock::default(), &arguments);
    assert_eq!(ended.code, 1, "{}", ended.out);
    assert!(ended.err.contains("cannot start /nowhere/rtbench"), "{}", ended.err);
}
