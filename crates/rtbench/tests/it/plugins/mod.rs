//! Plugins over rtbench.h: the two of `peers/`, compiled here with the machine's compiler. Without
//! one these tests say so and pass.

mod by_files;
mod everywhere;
mod foreign;
mod in_turns;
#[cfg(unix)]
mod slurm;
mod trace;
mod verify;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use measurement::record::{RunRecord, Verdict};

use crate::common::{Folder, row};

/// The root of the repository.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().and_then(Path::parent).unwrap()
}

/// Compiles a source of the repository, or says why not.
fn compiled(folder: &Folder, source: &str, more: &[&str]) -> Option<PathBuf> {
    let is_c = source.ends_with(".c");
    let (variable, usual, standard) =
        if is_c { ("CC", "cc", "-std=c99") } else { ("CXX", "c++", "-std=c++17") };
    let compiler = std::env::var(variable).unwrap_or_else(|_| usual.into());
    let library =
        Path::new(&folder.path()).join(Path::new(source).with_extension("so").file_name()?);
    let include = root().join("crates/plugins/include");
    let mut command = Command::new(&compiler);
    command.args([standard, "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-I"]);
    command.arg(include).args(more).arg("-o").arg(&library).arg(root().join(source));
    match command.output() {
        Ok(ended) => {
            assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
            Some(library)
        }
        Err(error) => {
            println!("not tested: no compiler '{compiler}' ({error})");
            None
        }
    }
}

fn minimal(folder: &Folder) -> Option<PathBuf> {
    compiled(folder, "peers/minimal-cpp/minimal.cpp", &["-pthread"])
}

fn rtbench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rtbench")).args(arguments).output().unwrap()
}

/// A small run over a plugin; exit code, record, and all it says.
fn run(plugin: &Path, rows: &str, more: &[&str]) -> (i32, RunRecord, String) {
    let folder = Folder::new();
    let (plugin, out) = (plugin.to_str().unwrap(), folder.path());
    let mut arguments = vec!["run", "tetra:5", "--quick", "-s", rows, "--plugin", plugin];
    arguments.extend(["-o", &out]);
    arguments.extend(more);
    let ended = rtbench(&arguments);
    let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
    assert!(Path::new(&out).join("results.json").exists(), "{said}");
    (ended.status.code().unwrap(), folder.record(), said)
}

#[test]
fn a_plugin_stands_beside_our_structures() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let in_f64 = ["--precision", "f64", "-j", "2", "--in-process"];
    for more in [
        &[][..],
        &["--in-process"],
        &["-j", "2"],
        &["-j", "2", "--in-process"],
        &in_f64[..2],
        &in_f64,
    ] {
        let (code, record, said) = run(&plugin, "wide-bvh,minimal-cpp:leaf=2", more);
        assert_eq!(code, 0, "{said}");
        let (ours, theirs) = (row(&record, "wide-bvh"), row(&record, "minimal-cpp leaf=2"));
        assert_eq!((ours.verdict, theirs.verdict), (Verdict::Ok, Verdict::Ok));
        assert_eq!(theirs.checked_rays, ours.checked_rays);
        assert_eq!(theirs.rays_by_kind, ours.rays_by_kind);
        assert_eq!(theirs.samples.len(), ours.samples.len());
        assert!(theirs.ratio.is_some() && theirs.build_s.is_some());
        let stats = theirs.stats.as_ref().unwrap();
        assert!(stats.n_oiv == 1024 && stats.n_in + 1 == stats.n_v && stats.memory_bytes > 0);
        // it counts nothing
        assert!(theirs.work.is_none() && theirs.render_s.is_none());
        let facts = theirs.plugin.as_ref().unwrap();
        assert_eq!(facts.own_process, !more.contains(&"--in-process"));
        assert!(facts.own_test && facts.file == "minimal.so" && facts.version == "1.0");
        assert_eq!(facts.sha256.len(), 64);
        // what differs at edges is a rate, and said
        assert!(facts.edge_mismatches * 100 < theirs.checked_rays);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains("answers differ at edges"), "{said}");
        assert_eq!(said.contains("an empty call takes"), facts.own_process, "{said}");
    }
    // without -s it is among all, and a row that -s does not name is added
    let (_, record, _) = run(&plugin, "brute-force", &[]);
    assert_eq!(row(&record, "minimal-cpp").verdict, Verdict::Ok);
}

#[test]
fn planted_faults_are_named() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let faults = [
        ("drop", Verdict::Wrong, "drops a hit"),
        ("id", Verdict::Wrong, "wrong id"),
        ("t-min", Verdict::Wrong, "accepts t < t_min"),
        ("occlusion", Verdict::Wrong, "wrong occlusion"),
        ("hang", Verdict::Panicked, "hangs: no answer within 1 s while tracing 16 rays"),
        ("crash", Verdict::Panicked, "crashes: its process ended with signal: 11 (SIGSEGV)"),
        ("wild-write", Verdict::Panicked, "crashes: its process ended with signal"),
        ("exit", Verdict::Panicked, "crashes: its process ended with exit status: 0"),
    ];
    let rows: Vec<String> =
        faults.iter().map(|(fault, ..)| format!("minimal-cpp:fault={fault}")).collect();
    let rows = format!("wide-bvh,minimal-cpp,{}", rows.join(","));
    let (code, record, said) = run(&plugin, &rows, &["--plugin-limit", "1s"]);
    assert_eq!(code, 4, "{said}");
    for (fault, verdict, word) in faults {
        let label = format!("minimal-cpp fault={fault}");
        let wrong = row(&record, &label);
        assert_eq!(wrong.verdict, verdict, "{label}");
        let why = wrong.error.as_ref().or(wrong.example.as_ref()).unwrap();
        assert!(why.contains(word), "{label}: {why}");
        assert!(said.lines().any(|l| l.starts_with(&label) && l.contains(word)), "{said}");
        assert!(wrong.samples.is_empty() && wrong.trace_s.is_none());
    }
    // a fault costs its row and no other
    for good in ["wide-bvh", "minimal-cpp"] {
        assert_eq!(row(&record, good).verdict, Verdict::Ok, "{good}");
        assert!(!row(&record, good).samples.is_empty());
    }
    // where nothing is wrong, a row that died is a failure
    let (code, _, said) = run(&plugin, "wide-bvh,minimal-cpp:fault=crash", &[]);
    assert_eq!(code, 1, "{said}");
}

#[test]
fn a_test_in_f32_is_wrong_in_a_run_in_f64() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let rows = "wide-bvh,minimal-cpp,minimal-cpp:fault=single";
    let (code, record, said) = run(&plugin, rows, &["--precision", "f64"]);
    assert_eq!(code, 4, "{said}");
    assert_eq!(row(&record, "minimal-cpp").verdict, Verdict::Ok);
    let wrong = row(&record, "minimal-cpp fault=single");
    assert_eq!(wrong.verdict, Verdict::Wrong);
    assert!(wrong.mismatches * 4 > wrong.checked_rays, "{said}");
}

#[test]
fn plugins_with_our_triangle_test_match_in_all_bits() {
    let folder = Folder::new();
    let Some(plugin) = compiled(&folder, "peers/brute-c/brute.c", &[]) else { return };
    let (code, record, said) = run(&plugin, "wide-bvh,brute-c", &[]);
    assert_eq!(code, 0, "{said}");
    let (ours, theirs) = (row(&record, "wide-bvh"), row(&record, "brute-c"));
    assert!(!theirs.plugin.as_ref().unwrap().own_test);
    assert_eq!((theirs.verdict, theirs.mismatches), (Verdict::Ok, 0));
    if theirs.checked_rays == ours.checked_rays {
        assert_eq!(theirs.answers_sha256, ours.answers_sha256);
    }
}

#[test]
fn files_that_are_no_plugins_are_refused() {
    let folder = Folder::new();
    let text = Path::new(&folder.path()).join("text.so");
    std::fs::write(&text, "nothing").unwrap();
    let refused = |plugin: &Path, words: &str, more: &[&str]| {
        let mut arguments = vec!["run", "tetra:2", "--quick", "--plugin", plugin.to_str().unwrap()];
        arguments.extend(more);
        let ended = rtbench(&arguments);
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.code().is_some_and(|code| code == 1 || code == 2), "{said}");
        assert!(said.contains(words) && ended.stdout.is_empty(), "{said}");
    };
    refused(&text, "cannot be loaded", &[]);
    refused(&text, "cannot be loaded", &["--in-process"]);
    refused(&text.with_extension("not"), "No such file", &[]);
    let Some(plugin) = minimal(&folder) else { return };
    refused(&plugin, "expected a whole number from 1 to 64", &["-s", "minimal-cpp:leaf=0"]);
    let source = "crates/rtbench/tests/it/plugins/indexed.c";
    let Some(incomplete) = compiled(&folder, source, &["-DNO_FUNCTION"]) else { return };
    for place in [&[][..], &["--in-process"]] {
        let words = "it answers RTBENCH_TRIANGLES_F64, but its function 'closest_f64' is NULL";
        refused(&incomplete, words, place);
    }
    let other = Folder::new();
    let version = ["-DRTBENCH_ABI_VERSION=99u", "-Wno-error", "-w"];
    let newer = std::fs::read_to_string(root().join("crates/plugins/include/rtbench.h")).unwrap();
    let newer = newer.replace("#define RTBENCH_ABI_VERSION 1u", "");
    std::fs::write(Path::new(&other.path()).join("rtbench.h"), newer).unwrap();
    // a header that is asked for in quotes is looked for there first
    let folder = other.path();
    let more = [version[0], version[1], version[2], "-iquote", &folder];
    let Some(newer) = compiled(&other, "peers/minimal-cpp/minimal.cpp", &more) else { return };
    refused(&newer, "built for version 99 of rtbench.h, but this program has version 1", &[]);
}

#[test]
fn the_journal_of_a_run_names_no_plugin() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let (out, plugin) = (Folder::new(), plugin.to_str().unwrap());
    let path = out.path();
    let begun = ["run", "tetra:2", "--quick", "-s", "hug", "--plugin", plugin, "-o", &path];
    assert!(rtbench(&begun).status.success());
    let ended = rtbench(&["run", "--resume", &path]);
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(!ended.status.success() && said.contains("give the same with --plugin"), "{said}");
    let ended = rtbench(&["run", "--resume", &path, "--plugin", plugin]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    // another file under the same name
    let other = Folder::new();
    let more = ["-DNDEBUG", "-g"];
    let Some(changed) = compiled(&other, "peers/minimal-cpp/minimal.cpp", &more) else { return };
    let ended = rtbench(&["run", "--resume", &path, "--plugin", changed.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(!ended.status.success() && said.contains("its file has changed"), "{said}");
}
