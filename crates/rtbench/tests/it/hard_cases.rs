//! The cases C1, C2, K1 and K2 of the project's catalogue of hard cases, by name: command lines that
//! make no sense, outputs that fail, panics; `kills` has those that end a run.

#![cfg(unix)]

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::resuming::{begun, csv, journal, outputs, record, run, run_in, show};
use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::{Entry, REGISTRY, brute_force};
use accel_core::{Ray, Scalar};
use measurement::journal::lines::read;
use measurement::record::{SceneRecord, Verdict};

/// Arguments of the program as a process.
pub fn program(arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtbench"));
    command.args(arguments.split_whitespace());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Waits for a process: exit code, standard output, standard error.
pub fn ended(child: Child) -> (Option<i32>, String, String) {
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn c1_numbers_that_make_no_sense() {
    for arguments in [
        "run tetra:2 --size 0",
        "run tetra:2 --size 2147483648",
        "run tetra:2 --size -1",
        "run tetra:0",
        "run tetra:2 --rounds 0",
        "run tetra:2 -j 0",
        "run tetra:2 -s uniform-grid:density=0",
        "run tetra:2 -s uniform-grid:density=nan",
        "run tetra:2 -s uniform-grid:max-cells=0",
        "run tetra:2 -s light-buffer:resolution=0",
        "render tetra:2 -o /dev/null --size 0",
        "render tetra:2 -o /dev/null --samples supersamples=0",
        "render tetra:2 -o /dev/null --samples shadow=0",
        "render tetra:2 -o /dev/null --samples glossy=0",
        "render tetra:2 -o /dev/null --depth 0",
        "render tetra:2 -o /dev/null --size 2147483648",
        "cost tetra:2 --size 0",
        "verify --rays 0",
        "sweep tetra:2 -s uniform-grid -p density --values 0..0",
        "sweep tetra:2 -s uniform-grid -p density --values 0",
    ] {
        let (code, out, err) = run(arguments);
        assert_eq!((code, out.as_str()), (2, ""), "{arguments}: {err}");
        assert!(!err.is_empty(), "{arguments}");
    }
    // One pixel is an image.
    let (code, out, err) = run("run tetra:2 --size 1 --quick --rounds 1 -s obvhs-cwbvh");
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("1 primary"), "{out}");
    for entry in REGISTRY {
        for param in entry.info.params {
            for value in ["", "nan", "inf", "1e400", "\u{0}"] {
                assert!(entry.params([(param.name, value)]).is_err(), "{} {value}", param.name);
            }
        }
    }
}

#[test]
fn c1_paths_with_spaces_and_of_any_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let names: [&[u8]; 3] = [b"plain.obj", b"two words.obj", b"caf\xe9.obj"];
    let rows: Vec<String> = names
        .iter()
        .map(|name| {
            let path = folder.path().join(OsString::from_vec(name.to_vec()));
            std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
            let out = folder.path().join(OsString::from_vec([b"out of ", *name].concat()));
            let mut arguments: Vec<OsString> =
                "run --quick --size 8 -s uniform-grid,obvhs-cwbvh -o"
                    .split(' ')
                    .map(Into::into)
                    .collect();
            arguments.extend([out.clone().into_os_string(), path.into_os_string()]);
            let (code, _, err) = run_in(REGISTRY, arguments);
            assert_eq!(code, 0, "{err}");
            // and what is kept can be resumed, whatever its name
            let mut again: Vec<OsString> = vec!["run".into(), "--resume".into()];
            again.push(out.clone().into_os_string());
            let (code, _, err) = run_in(REGISTRY, again);
            assert_eq!(code, 0, "{err}");
            let csv = csv(&out);
            csv.lines().filter_map(|line| line.split_once(',')).map(|(_, row)| row).collect()
        })
        .collect();
    assert_eq!(rows[0], rows[1]);
    assert_eq!(rows[0], rows[2]);
}

/// Four small scenes; a second or two in all.
pub const SMALL: &str = "run tetra:1 tetra:2 tetra:3 balls:1 --quick --rounds 2 --size 8 \
                     -s uniform-grid,obvhs-cwbvh -q";

/// Resumes a run that failed: then its table is that of a run that did not.
fn resumes_well(folder: &Path) {
    let whole = tempfile::tempdir().unwrap();
    let (code, expected, err) = ended(begun(SMALL, whole.path()).spawn().unwrap());
    assert_eq!(code, Some(0), "{err}");
    let before = journal(folder).finished;
    let (code, out, err) =
        ended(program(&format!("run --resume {}", show(folder))).spawn().unwrap());
    assert_eq!(code, Some(0), "{err}");
    let titles = |text: &str| -> Vec<String> {
        text.lines().filter(|l| l.contains("primitives; rays")).map(str::to_owned).collect()
    };
    assert_eq!(titles(&out), titles(&expected));
    assert_eq!(outputs(folder), outputs(whole.path()));
    let after = journal(folder);
    assert!(after.is_complete && record(folder).complete);
    assert!(before.iter().all(|(i, scene)| after.finished.get(i) == Some(scene)));
}

#[test]
fn c2_standard_output_to_a_full_device() {
    let folder = tempfile::tempdir().unwrap();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let (code, _, err) = ended(begun(SMALL, folder.path()).stdout(full).spawn().unwrap());
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("standard output"), "{err}");
    assert_eq!(journal(folder.path()).finished.len(), 1);
    resumes_well(folder.path());
}

#[test]
fn c2_standard_output_to_a_closed_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = begun(SMALL, folder.path()).spawn().unwrap();
    drop(child.stdout.take());
    let (code, _, err) = ended(child);
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("standard output was closed") && !err.contains("panicked"), "{err}");
    assert_eq!(journal(folder.path()).finished.len(), 1);
    resumes_well(folder.path());
}

/// A limit on the size of files stands for a full disk: writes beyond it fail, and the signal that
/// comes with it does not end the program.
#[test]
fn c2_files_on_a_full_disk() {
    let mut kept = Vec::new();
    for kibibytes in [1, 5, 9, 14, 20] {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let script = format!(
            "ulimit -f {}; exec \"$0\" \"$@\"",
            // POSIX: in units of 512 bytes
            2 * kibibytes
        );
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_rtbench")]);
        command.args(SMALL.split_whitespace()).arg("-o").arg(folder.path());
        command.env("TMPDIR", elsewhere.path());
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let (code, out, err) = ended(child);
        assert_eq!(code, Some(1), "{kibibytes}: {err}");
        let is_said = err.contains("are saved in ") || err.contains("are only printed");
        assert_eq!(is_said, out.contains("primitives; rays"), "{kibibytes}: {out}{err}");
        assert!(err.contains("cannot write"), "{kibibytes}: {err}");
        let text = std::fs::read(folder.path().join("run.jsonl")).unwrap();
        assert!(text.is_empty() || text.ends_with(b"\n"), "{kibibytes}: a torn line");
        if text.is_empty() {
            continue;
        }
        let finished = journal(folder.path()).finished.len();
        let shown = out.lines().filter(|l| l.contains("primitives; rays")).count();
        assert!(finished == shown || finished + 1 == shown, "{finished} {shown}");
        kept.push(finished);
        resumes_well(folder.path());
    }
    assert!(kept.iter().any(|&n| n > 0), "{kept:?}: the limits are too low to show anything");
}

#[test]
fn c2_folders_that_take_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "kept").unwrap();
    for output in [file.join("below"), "/proc/rtbench".into()] {
        let (code, out, err) = ended(begun(SMALL, &output).spawn().unwrap());
        assert_eq!((code, out.as_str()), (Some(1), ""), "{err}");
        assert!(err.contains("cannot write"), "{err}");
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "kept");
}

#[test]
fn k1_one_thread_or_many() {
    let folder = tempfile::tempdir().unwrap();
    let (mut images, mut counted) = (Vec::new(), Vec::new());
    for run_number in 0..10 {
        let threads = [1, 3][run_number % 2];
        let png = folder.path().join(format!("{run_number}.png"));
        let (code, _, err) =
            run(&format!("render effect-all --size 24 -j {threads} -o {}", show(&png)));
        assert_eq!(code, 0, "{err}");
        images.push(std::fs::read(&png).unwrap());
        let out = folder.path().join(run_number.to_string());
        let arguments = "run balls:2 --quick --rounds 1 --size 16 -s uniform-grid,recursive-grid";
        let (code, _, err) = run(&format!("{arguments} -j {threads} -o {}", show(&out)));
        assert_eq!(code, 0, "{err}");
        let rows = record(&out).scenes.remove(0).rows;
        counted
            .push(rows.into_iter().map(|r| (r.work, r.stats, r.checked_rays)).collect::<Vec<_>>());
    }
    assert!(images.iter().all(|image| *image == images[0]));
    assert!(counted.iter().all(|rows| *rows == counted[0]), "{counted:?}");
}

/// Brute force that panics: at the thousandth ray, or (`LATER`) when it is built for the third
/// time, which is in a timed round.
struct Panicking<S, const LATER: bool> {
    ids: Vec<u32>,
    scalar: std::marker::PhantomData<S>,
}

static RAYS: AtomicUsize = AtomicUsize::new(0);
static BUILDS: AtomicUsize = AtomicUsize::new(0);

impl<S: Scalar, const LATER: bool> Structure<S> for Panicking<S, LATER> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        if LATER && BUILDS.fetch_add(1, Ordering::SeqCst) >= 2 {
            panic!("planted in a build");
        }
        let ids = (0..prims.len() as u32).collect();
        Ok(Self { ids, scalar: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        if !LATER && RAYS.fetch_add(1, Ordering::SeqCst) >= 1000 {
            panic!("planted in a tile");
        }
        sink.elementary_step(false);
        let _ = sink.test(&self.ids);
    }

    fn stats(&self) -> StructureStats {
        StructureStats { cells: 1, references: self.ids.len() as u64, ..StructureStats::default() }
    }
}

type AtARay<S> = Panicking<S, false>;
type InARound<S> = Panicking<S, true>;

const INFO: StructureInfo = StructureInfo::new("panics-at-a-ray", "panics");
static AT_A_RAY: StructureInfo = INFO;
static IN_A_ROUND: StructureInfo = StructureInfo { name: "panics-in-a-round", ..INFO };

static PLANTED: &[Entry] = &[
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    accel_core::entry!(crate::hard_cases::AtARay, AT_A_RAY),
    accel_core::entry!(crate::hard_cases::InARound, IN_A_ROUND),
];

#[test]
fn k2_a_panic_costs_its_row_and_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "run tetra:2 tetra:3 --size 16 --rounds 4 -s all --rays primary,diffuse -o {}",
        show(folder.path())
    );
    let (code, out, err) = run_in(PLANTED, arguments.split_whitespace().map(Into::into));
    assert_eq!(code, 1, "{err}");
    let record = record(folder.path());
    assert!(record.complete);
    for SceneRecord { rows, name, .. } in &record.scenes {
        let verdicts: Vec<Verdict> = rows.iter().map(|r| r.verdict).collect();
        assert_eq!(verdicts, [Verdict::Ok, Verdict::Panicked, Verdict::Panicked], "{name}");
        assert!(rows[0].trace_s.is_some() && rows[1].trace_s.is_none(), "{name}");
    }
    let notes: Vec<&str> = out
        .lines()
        .filter(|line| line.starts_with("panics-") && line.contains("planted"))
        .collect();
    assert_eq!(notes.len(), 4, "once a scene and row: {notes:?}");
    assert!(notes[0].starts_with("panics-at-a-ray: panicked: planted in a tile"), "{notes:?}");
    assert!(notes[1].contains("planted in a build"), "{notes:?}");
}

/// The fixed inputs of the fuzz target `results`.
#[test]
fn fuzz_seeds_of_the_journal() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/results");
    let mut finished = Vec::new();
    for file in std::fs::read_dir(folder).unwrap() {
        let bytes = std::fs::read(file.unwrap().path()).unwrap();
        finished.extend(read(&bytes).ok().map(|found| found.finished.len()));
    }
    finished.sort();
    assert_eq!(finished, [0, 0, 1, 2]);
}
