//! Each stage on records with a planted fault.

use measurement::callgrind::CountedRow;
use measurement::record::{FloorRecord, RunRecord, Verdict};
use rtbench::comparison::differences;
use rtbench::gate::contest::{Key, PairedTimes};
use rtbench::gate::report::Report;
use rtbench::gate::thresholds::Thresholds;
use rtbench::gate::{Evidence, Finding, GateOutcome, Instructions, Times, judge, wall_clock};

use super::planted::{REFERENCE, ROW, record, row, timed};

fn in_run(cpu_pressure: Option<f64>) -> Times<'static> {
    Times::InRun { cpu_pressure, across_processors: false }
}

fn of(base: &RunRecord, now: &RunRecord, instructions: Instructions<'_>) -> Vec<Finding> {
    let thresholds = &Thresholds::default();
    judge(&Evidence { thresholds, base, now, instructions, times: in_run(None) })
}

/// Outcome of a stage for a quantity of [`ROW`].
fn outcome(findings: &[Finding], stage: &str, quantity: &str) -> GateOutcome {
    let found = |f: &&Finding| f.stage == stage && f.quantity == quantity && f.row == ROW;
    findings.iter().find(found).map(|f| f.outcome).unwrap()
}

/// The outcome of a quantity after a fault was planted in [`ROW`].
fn after(fault: impl Fn(&mut RunRecord), stage: &str, quantity: &str) -> GateOutcome {
    let mut now = record();
    fault(&mut now);
    outcome(&of(&record(), &now, Instructions::NotAsked), stage, quantity)
}

#[test]
fn a_record_held_against_itself_is_unchanged() {
    let record = timed(15, 2.0, 0.1, 1);
    let findings = of(&record, &record, Instructions::NotAsked);
    assert!(findings.len() > 20 && findings.iter().all(|f| f.outcome == GateOutcome::Unchanged));
    assert_eq!(Report::worst(&findings), GateOutcome::Unchanged);
}

#[test]
fn changed_and_wrong_answers_are_regressions() {
    let answers = |fault: fn(&mut RunRecord)| after(fault, "answers", "answers");
    assert_eq!(answers(|_| ()), GateOutcome::Unchanged);
    let other = answers(|r| row(r, ROW).answers_sha256 = Some("0".repeat(64)));
    assert_eq!(other, GateOutcome::Regression);
    assert_eq!(answers(|r| row(r, ROW).answers_sha256 = None), GateOutcome::NotJudged);
    assert_eq!(answers(|r| row(r, ROW).checked_rays += 1), GateOutcome::NotJudged);
    assert_eq!(answers(|r| row(r, ROW).verdict = Verdict::Wrong), GateOutcome::WrongHits);
    for verdict in [Verdict::Panicked, Verdict::NotBuilt] {
        let mut now = record();
        row(&mut now, ROW).verdict = verdict;
        let findings = of(&record(), &now, Instructions::NotAsked);
        assert_eq!(outcome(&findings, "answers", "answers"), GateOutcome::Regression);
        // built by neither: nothing was compared
        let findings = of(&now, &now, Instructions::NotAsked);
        assert_eq!(outcome(&findings, "answers", "answers"), GateOutcome::NotJudged);
    }
}

#[test]
fn counters_have_no_tolerance() {
    let tests = |by: i64| {
        let fault = |r: &mut RunRecord| {
            let work = row(r, ROW).work.as_mut().unwrap();
            work.intersection_tests = work.intersection_tests.checked_add_signed(by).unwrap();
        };
        after(fault, "counters", "n_it")
    };
    assert_eq!(tests(0), GateOutcome::Unchanged);
    assert_eq!(tests(1), GateOutcome::Regression);
    assert_eq!(tests(-1), GateOutcome::Improved);
    // a plugin that counts no more has not become better
    let none =
        after(|r| row(r, ROW).work.as_mut().unwrap().intersection_tests = 0, "counters", "n_it");
    assert_eq!(none, GateOutcome::NotJudged);
    let memory =
        after(|r| row(r, ROW).stats.as_mut().unwrap().memory_bytes += 1, "counters", "memory");
    assert_eq!(memory, GateOutcome::Regression);
    let other_rays = after(|r| row(r, ROW).work.as_mut().unwrap().rays += 1, "counters", "n_it");
    assert_eq!(other_rays, GateOutcome::NotJudged);
    let saved = after(|r| row(r, ROW).work.as_mut().unwrap().tests_saved += 1, "counters", "saved");
    assert_eq!(saved, GateOutcome::NotJudged);
    let empty = after(|r| row(r, ROW).stats.as_mut().unwrap().n_ev += 1, "counters", "n_ev");
    assert_eq!(empty, GateOutcome::NotJudged);
    let cells = after(|r| row(r, ROW).stats.as_mut().unwrap().n_v += 1, "counters", "n_v");
    assert_eq!(cells, GateOutcome::Regression);
}

fn counted(trace: u64) -> Vec<CountedRow> {
    let row = |structure: &str, trace| CountedRow {
        scene: "tetra:2".into(),
        structure: structure.into(),
        settings: String::new(),
        rays: 1000,
        build: Some(50_000),
        trace: Some(trace),
    };
    vec![row(ROW, trace), row(REFERENCE, 1_000_000)]
}

#[test]
fn half_a_percent_more_instructions_is_a_regression() {
    let record = record();
    let base = counted(1_000_000);
    let trace = |now: &[CountedRow]| {
        let findings = of(&record, &record, Instructions::Counted { base: &base, now });
        let reference = |f: &&Finding| f.stage == "instructions" && f.row == REFERENCE;
        assert!(findings.iter().filter(reference).all(|f| f.outcome == GateOutcome::Unchanged));
        outcome(&findings, "instructions", "trace")
    };
    assert_eq!(trace(&counted(1_030_000)), GateOutcome::Regression);
    // planted: one percent
    assert_eq!(trace(&counted(1_010_000)), GateOutcome::Regression);
    assert_eq!(trace(&counted(1_004_900)), GateOutcome::Unchanged);
    assert_eq!(trace(&counted(950_000)), GateOutcome::Improved);
    let mut other = counted(1_030_000);
    other[0].rays += 1;
    assert_eq!(trace(&other), GateOutcome::NotJudged);
    assert_eq!(trace(&counted(1_000_000)[1..]), GateOutcome::NotJudged);
    let build = |instructions| {
        let mut now = counted(1_000_000);
        now[0].build = Some(instructions);
        let findings = of(&record, &record, Instructions::Counted { base: &base, now: &now });
        outcome(&findings, "instructions", "build")
    };
    // what the allocator does of itself, and more than that
    assert_eq!([build(50_400), build(49_600)], [GateOutcome::Unchanged; 2]);
    assert_eq!([build(51_000), build(49_000)], [GateOutcome::Regression, GateOutcome::Improved]);
    let findings = of(&record, &record, Instructions::Missing("no valgrind"));
    assert_eq!(Report::worst(&findings), GateOutcome::Inconclusive);
}

/// GateOutcome for the trace time of [`ROW`].
fn time(base: &RunRecord, now: &RunRecord) -> GateOutcome {
    outcome(&of(base, now, Instructions::NotAsked), "times", "trace")
}

#[test]
fn times_regress_if_the_interval_and_the_rank_test_agree() {
    let base = timed(15, 2.0, 0.02, 1);
    assert_eq!(time(&base, &timed(15, 2.6, 0.02, 2)), GateOutcome::Regression);
    assert_eq!(time(&base, &timed(15, 1.0, 0.02, 2)), GateOutcome::Improved);
    assert_eq!(time(&base, &timed(15, 2.0, 0.02, 2)), GateOutcome::Unchanged);
    // 30% with noise of the same size: it may be
    assert_eq!(time(&base, &timed(15, 2.2, 0.4, 2)), GateOutcome::Inconclusive);
    // four rounds against four cannot be significant
    assert_eq!(time(&timed(4, 2.0, 0.01, 1), &timed(4, 2.6, 0.01, 2)), GateOutcome::Inconclusive);
    assert_eq!(time(&timed(2, 2.0, 0.01, 1), &timed(2, 2.6, 0.01, 2)), GateOutcome::NotJudged);
    // as certain, but a copy of the program differs from it by more
    let mut floored = timed(15, 2.6, 0.02, 2);
    floored.floor = FloorRecord::of([("planted".to_owned(), 1.4)].into_iter());
    assert_eq!(time(&base, &floored), GateOutcome::Inconclusive);
}

/// The trace times of [`ROW`] times a factor, ratios too.
fn scaled(mut record: RunRecord, factor: f64) -> RunRecord {
    for sample in &mut row(&mut record, ROW).samples {
        sample.trace_s.values_mut().for_each(|s| *s *= factor);
    }
    record
}

#[test]
fn times_below_the_minimum_on_both_sides_are_not_judged() {
    let base = timed(15, 2.0, 0.02, 1);
    let short = scaled(timed(15, 2.0, 0.02, 2), 1e-3);
    assert_eq!(time(&scaled(base.clone(), 1e-3), &short), GateOutcome::NotJudged);
    // planted: microseconds became milliseconds, and the other way round
    assert_eq!(time(&scaled(base.clone(), 1e-3), &base), GateOutcome::Regression);
    assert_eq!(time(&base, &short), GateOutcome::Improved);
}

#[test]
fn noisy_times_are_never_reported_unchanged() {
    let base = timed(15, 2.0, 0.5, 1);
    let findings = of(&base, &timed(15, 2.0, 0.5, 2), Instructions::NotAsked);
    let times: Vec<&Finding> = findings.iter().filter(|f| f.stage == "times").collect();
    for finding in &times {
        let change = finding.change.unwrap();
        let is_within = change.low >= 1.0 / 1.05 && change.high <= 1.05;
        assert_eq!(finding.outcome == GateOutcome::Unchanged, is_within, "{finding:?}");
    }
    // what would decide it is said
    let trace = times.iter().find(|f| f.quantity == "trace" && f.row == ROW).unwrap();
    assert_eq!(trace.outcome, GateOutcome::Inconclusive);
    assert!(trace.note.contains("rounds") || trace.note.contains("too near"), "{}", trace.note);
    // planted: a floor of a third, which nothing that a check sees is beyond
    let mut floored = timed(15, 2.0, 0.1, 2);
    floored.floor = FloorRecord::of([("planted".to_owned(), 1.32)].into_iter());
    let findings = of(&timed(15, 2.0, 0.1, 1), &floored, Instructions::NotAsked);
    let wide =
        findings.iter().filter(|f| f.change.is_some_and(|c| c.high > 1.05 && c.low != c.high));
    assert!(
        wide.clone().count() > 0 && wide.clone().all(|f| f.outcome == GateOutcome::Inconclusive)
    );
}

#[test]
fn times_of_another_processor_are_judged_on_request() {
    let base = timed(15, 2.0, 0.02, 1);
    let mut now = timed(15, 2.6, 0.02, 2);
    let thresholds = &Thresholds::default();
    let of = |now: &RunRecord, across_processors| {
        let times = Times::InRun { cpu_pressure: None, across_processors };
        let instructions = Instructions::NotAsked;
        let findings = judge(&Evidence { thresholds, base: &base, now, instructions, times });
        outcome(&findings, "times", "trace")
    };
    // 4 KiB of memory and a kernel's release are no other machine
    now.machine.memory_bytes = now.machine.memory_bytes.map(|bytes| bytes + 4096);
    now.machine.os += "-2";
    assert_eq!(of(&now, false), GateOutcome::Regression);
    assert_eq!(differences::remarks(&base, &now), Vec::<String>::new());
    now.machine.batches_by_avx512 = Some(!base.machine.batches_by_avx512.unwrap_or_default());
    now.machine.threads += 1;
    assert_eq!(
        [of(&now, false), of(&now, true)],
        [GateOutcome::NotJudged, GateOutcome::Regression]
    );
    let remark = &differences::remarks(&base, &now)[0];
    let known = base.machine.batches_by_avx512.is_some();
    assert!(remark.contains("threads of the machine") && remark.contains("AVX-512") == known);
    // counters are judged on any machine
    row(&mut now, ROW).work.as_mut().unwrap().traversal_steps += 1;
    let findings = self::of(&base, &now, Instructions::NotAsked);
    assert_eq!(outcome(&findings, "counters", "n_ts"), GateOutcome::Regression);
}

#[test]
fn ratios_within_a_run_prove_nothing_on_a_busy_machine() {
    let (base, thresholds) = (timed(15, 2.0, 0.02, 1), &Thresholds::default());
    let of = |times: f64, share: f64| {
        let now = &timed(15, times, 0.02, 2);
        let times = in_run(Some(share));
        let instructions = Instructions::NotAsked;
        let findings = judge(&Evidence { thresholds, base: &base, now, instructions, times });
        outcome(&findings, "times", "trace")
    };
    assert_eq!([of(2.6, 0.1), of(2.6, 0.5)], [GateOutcome::Regression, GateOutcome::Inconclusive]);
    assert_eq!([of(1.0, 0.1), of(1.0, 0.5)], [GateOutcome::Improved, GateOutcome::Inconclusive]);
    assert_eq!([of(2.0, 0.1), of(2.0, 0.5)], [GateOutcome::Unchanged; 2]);
}

#[test]
fn the_reference_has_no_ratio_to_itself() {
    let record = timed(15, 2.0, 0.05, 1);
    let findings = of(&record, &record, Instructions::NotAsked);
    assert!(!findings.iter().any(|f| f.stage == "times" && f.row == REFERENCE));
}

/// Laps of [`ROW`] in so many processes, new over old `times`, all halved or doubled by what
/// disturbs them; the copy takes as long as the new program, but for `copy`.
fn turns(processes: u32, times: f64, copy: f64) -> Vec<PairedTimes> {
    let disturbed = |i: u32| 0.01 * [0.5, 1.0, 2.0][i as usize % 3];
    let jitter = |i: u32| [0.99, 1.0, 1.01, 1.0, 1.005][i as usize % 5];
    let seconds = |i: u32| {
        let new = times * jitter(i / 4) * disturbed(i);
        [disturbed(i), new, copy * new]
    };
    let of = |quantity| PairedTimes {
        key: Key { scene: "tetra:2".into(), row: ROW.into(), quantity },
        times: (0..4 * processes).map(seconds).collect(),
        processes: (0..4 * processes).map(|i| i / 4).collect(),
    };
    vec![of("build"), of("trace")]
}

fn pairs(n: u32, times: f64) -> Vec<PairedTimes> {
    turns(n, times, 1.0)
}

fn paired(pairs: &[PairedTimes]) -> Vec<Finding> {
    let (record, thresholds) = (&record(), &Thresholds { time: 0.02, ..Thresholds::default() });
    let times = Times::Paired { pairs, looks: 3 };
    let instructions = Instructions::NotAsked;
    judge(&Evidence { thresholds, base: record, now: record, instructions, times })
}

#[test]
fn pairs_cancel_what_disturbs_both() {
    let of = |n, times| outcome(&paired(&pairs(n, times)), "times", "trace");
    assert_eq!(of(15, 1.3), GateOutcome::Regression);
    // planted: five percent
    assert_eq!(of(15, 1.05), GateOutcome::Regression);
    assert_eq!(of(15, 1.0), GateOutcome::Unchanged);
    assert_eq!(of(15, 0.5), GateOutcome::Improved);
    // two processes say too little
    assert_eq!(of(2, 1.03), GateOutcome::Inconclusive);
    assert_eq!(outcome(&paired(&[]), "times", "trace"), GateOutcome::NotJudged);
}

#[test]
fn decided_comparisons_are_not_measured_again() {
    let (record, thresholds) = (&record(), &Thresholds { time: 0.02, ..Thresholds::default() });
    let open = |times: f64, n: u32| {
        let pairs = &pairs(n, times);
        let times = Times::Paired { pairs, looks: 3 };
        let instructions = Instructions::NotAsked;
        let evidence = Evidence { thresholds, base: record, now: record, instructions, times };
        wall_clock::undecided(&evidence).into_iter().filter(|key| key.row == ROW).count()
    };
    assert_eq!([open(1.3, 9), open(1.0, 9), open(1.02, 9)], [0, 0, 2]);
}

#[test]
fn differences_below_the_noise_floor_are_inconclusive() {
    let of = |times, copy| outcome(&paired(&turns(15, times, copy)), "times", "trace");
    assert_eq!(of(1.3, 1.0), GateOutcome::Regression);
    // planted: the program differs from itself by as much
    assert_eq!(of(1.3, 1.4), GateOutcome::Inconclusive);
    assert_eq!(of(1.3, 0.7), GateOutcome::Inconclusive);
    assert_eq!(of(0.75, 1.4), GateOutcome::Inconclusive);
    assert_eq!(of(0.5, 1.4), GateOutcome::Improved);
}

#[test]
fn a_regression_of_times_must_be_seen_twice() {
    let confirmed = |second: f64| {
        let mut findings = paired(&pairs(15, 1.3));
        wall_clock::confirm(&mut findings, &paired(&pairs(15, second)));
        outcome(&findings, "times", "trace")
    };
    assert_eq!(confirmed(1.3), GateOutcome::Regression);
    assert_eq!(confirmed(1.0), GateOutcome::Inconclusive);
}

#[test]
fn each_difference_that_forbids_comparing_is_named() {
    type Fault = fn(&mut RunRecord);
    let faults: [(&str, Fault); 9] = [
        ("threads: 1, then 2", |r| r.settings.threads = 2),
        ("precision", |r| r.settings.precision = "f64".into()),
        ("resolution", |r| r.settings.resolution = [8; 2]),
        ("seed", |r| r.settings.seed += 1),
        ("target: x86_64", |r| r.compiler.target = Some("other".into())),
        ("target features", |r| r.compiler.target_features.push("more".into())),
        ("opt-level", |r| r.compiler.opt_level = Some("0".into())),
        ("scene tetra:2: sha256", |r| r.scenes[0].sha256 = "0".repeat(64)),
        ("scene tetra:2: rays", |r| *r.scenes[0].rays.get_mut("primary").unwrap() += 1),
    ];
    assert_eq!(differences::refusals(&record(), &record()), Vec::<String>::new());
    let mut all = record();
    for (said, fault) in &faults {
        let mut now = record();
        fault(&mut now);
        fault(&mut all);
        let reasons = differences::refusals(&record(), &now);
        assert!(reasons.len() == 1 && reasons[0].contains(said), "{said}: {reasons:?}");
    }
    assert_eq!(differences::refusals(&record(), &all).len(), faults.len());
    let mut elsewhere = record();
    elsewhere.machine.cpu = Some("another".into());
    assert_eq!(differences::refusals(&record(), &elsewhere), Vec::<String>::new());
    let remark = &differences::remarks(&record(), &elsewhere)[0];
    assert!(remark.contains("Another processor") && remark.contains(", then another"), "{remark}");
    let mut by_day = record();
    by_day.settings.timed_by = "time of day, planted".into();
    let remarks = differences::remarks(&by_day, &record());
    assert!(
        remarks[0].starts_with("Times of the baseline are time of day, planted, now "),
        "{remarks:?}"
    );
}
