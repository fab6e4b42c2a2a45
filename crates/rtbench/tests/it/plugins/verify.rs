//! `verify` of plugins: last bits and edges are no faults of a test of one's own, all else is; and
//! a fault is reduced to what its author needs.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::{compiled, minimal, root, rtbench};
use crate::common::{Folder, PLANTED, run_with};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

/// Exit code, counts over all cases, in both precisions and in each, and all it says.
fn verify(
    plugin: &Path,
    row: &str,
    cases: &str,
    more: &[&str],
) -> (i32, HashMap<String, u64>, String) {
    let folder = Folder::new();
    let (plugin, output) = (plugin.to_str().unwrap(), folder.path());
    let arguments = ["verify", "--cases", cases, "--rays", "300", "-j", "2", "-s", row];
    let files = ["--plugin", plugin, "-o", &output];
    let ended = rtbench(&[&arguments[..], &files, more].concat());
    let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
    let names = ["trials", "mismatches", "last_bits", "at_edges", "lost", "invented", "wrong_id"];
    let rows = folder.csv_of("verify.csv");
    let mut counts = HashMap::new();
    for (row, name) in rows.iter().flat_map(|row| names.map(|name| (row, name))) {
        for key in [name.to_owned(), format!("{name} {}", row["precision"])] {
            *counts.entry(key).or_default() += row[name].parse::<u64>().unwrap();
        }
    }
    (ended.status.code().unwrap(), counts, said)
}

#[test]
fn verify_demands_all_bits_of_plugins_with_our_triangle_test() {
    let folder = Folder::new();
    let Some(plugin) = compiled(&folder, "peers/brute-c/brute.c", &[]) else { return };
    // far rays, and what is no ray, are not asked as they are
    let (code, counts, said) = verify(&plugin, "brute-c", "G1,ray", &[]);
    assert!(code == 0 && counts["last_bits"] == 0, "{said}");
    assert!(said.contains("supports f32 only (it lacks RTBENCH_TRIANGLES_F64)"), "{said}");
    assert!(counts["trials f32"] > 0 && counts["trials f64"] == 0, "{said}");
}

#[test]
fn verify_demands_all_bits_in_f64() {
    let folder = Folder::new();
    let source = "crates/rtbench/tests/it/plugins/indexed.c";
    let Some(plugin) = compiled(&folder, source, &[]) else { return };
    for place in [&[][..], &["--in-process"]] {
        let (code, counts, said) = verify(&plugin, "indexed", "G1,R1", place);
        assert!(code == 0 && counts["last_bits"] == 0 && !said.contains("refused"), "{said}");
        assert_eq!(counts["trials f32"], counts["trials f64"], "{said}");
    }
}

#[test]
fn a_test_in_f32_is_wrong_in_f64() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    for place in [&[][..], &["--in-process"]] {
        let cases = "G1,R1,R8";
        let (code, counts, said) = verify(&plugin, "minimal-cpp:fault=single", cases, place);
        let of = |names: [&str; 3], precision: &str| {
            names.iter().map(|name| counts[&format!("{name} {precision}")]).sum::<u64>()
        };
        let wrong = ["lost", "invented", "wrong_id"];
        assert_eq!((code, of(wrong, "f32")), (4, 0), "{said}");
        assert!(of(wrong, "f64") * 10 > counts["trials f64"], "{said}");
        assert!(said.contains("in f64 ") && said.contains("in f32 "), "{said}");
    }
}

#[test]
fn last_bits_and_edges_are_counted_and_all_else_is_wrong() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let of = |fault: &str| {
        let (code, counts, said) =
            verify(&plugin, &format!("minimal-cpp:fault={fault}"), "G1,R1,R8", &[]);
        let wrong = ["lost", "invented", "wrong_id"].map(|name| counts[name]);
        assert_eq!(wrong.iter().sum::<u64>(), counts["mismatches"], "{said}");
        assert_eq!(code, if counts["mismatches"] > 0 { 4 } else { 0 }, "{fault}: {said}");
        (counts, wrong, said)
    };
    let (right, wrong, said) = of("none");
    assert_eq!(wrong, [0; 3], "{said}");
    for precision in ["f32", "f64"] {
        assert!(right[&format!("at_edges {precision}")] > 0, "{said}");
        assert!(right[&format!("last_bits {precision}")] > 0, "{said}");
    }
    assert!(said.contains("at edges (within 64 ulps of the scene's"), "{said}");
    // planted: what is tolerated
    let (coarse, wrong, said) = of("last-bits");
    assert!(wrong == [0; 3] && coarse["last_bits"] > right["last_bits"], "{said}");
    let (leaking, wrong, said) = of("edges");
    assert!(wrong == [0; 3] && leaking["at_edges"] > right["at_edges"], "{said}");
    // planted: what is not
    for (fault, kind) in [("drop", 0), ("occlusion", 0), ("t-min", 1), ("id", 2)] {
        let (_, wrong, said) = of(fault);
        assert!(wrong[kind] > 20, "{fault}: {said}");
    }
}

#[test]
fn a_crash_is_a_failure_of_its_case_alone() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let (code, counts, said) = verify(&plugin, "minimal-cpp:fault=crash", "R1,R5", &[]);
    // the process of each round ended
    assert!(code == 4 && counts["mismatches"] == 4, "{said}");
    assert_eq!(said.matches("minimal-cpp fault=crash': crashes: its process ended").count(), 4);
}

#[test]
fn a_lost_hit_is_reduced_to_a_reproducing_program() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let out = format!("{}/shrunk", folder.path());
    let (code, _, said) = verify(&plugin, "minimal-cpp:fault=drop", "R1", &["--shrink", &out]);
    assert_eq!(code, 4, "{said}");
    let heading = said.lines().find(|line| line.contains(" reduced to ")).unwrap();
    let left = heading.split_once(" reduced to ").unwrap().1.strip_suffix(" and 1").unwrap();
    // it drops the fourth of every seven triangles: what comes behind one is not needed
    let last = left.parse::<u32>().unwrap() - 1;
    assert!(last % 7 == 3 && last < 59, "{heading}");
    assert!(
        said.contains("  ray: from ") && said.contains(&format!("  triangle {last}: ")),
        "{said}"
    );
    let file = |ending: &str| format!("{out}/minimal-cpp-fault-drop-R1-f32.{ending}");
    // the same rays again
    let traced = |row: &str| {
        let (scene, rays) = (file("obj"), file("rays"));
        let arguments =
            ["rays", "trace", &scene, "--rays", &rays, "--plugin", plugin.to_str().unwrap()];
        let ended = rtbench(&[&arguments[..], &["-s", row]].concat());
        let said = String::from_utf8_lossy(&ended.stdout).into_owned();
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        said.split_once("ray 0: ").unwrap().1.lines().next().unwrap().to_owned()
    };
    let right = format!("primitive {last} at");
    assert!(traced("minimal-cpp").starts_with(&right));
    assert!(!traced("minimal-cpp:fault=drop").starts_with(&right));
    // the program of the bug report, and with the fault mended
    for precision in ["f32", "f64"] {
        let file = |ending: &str| format!("{out}/minimal-cpp-fault-drop-R1-{precision}.{ending}");
        let program = fs::read_to_string(file("c")).unwrap();
        for (text, code) in [(program.clone(), 1), (program.replace("\"drop\"", "\"none\""), 0)] {
            let (source, binary) = (file("try.c"), file("try"));
            fs::write(&source, text).unwrap();
            let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
            let include = root().join("crates/plugins/include");
            let built = Command::new(compiler)
                .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"])
                .args([&include, Path::new(&source), &plugin])
                .args(["-lm", "-o", &binary])
                .output()
                .unwrap();
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            let ended = Command::new(&binary).output().unwrap();
            let said = String::from_utf8_lossy(&ended.stdout);
            assert_eq!(ended.status.code(), Some(code), "{said}");
        }
    }
    // one trial alone
    let trial = "R1 f32 seed=1 round=0 rays=300 ray=0 minimal-cpp fault=occlusion";
    let plugin = plugin.to_str().unwrap();
    let again = rtbench(&["verify", "--replay", trial, "--shrink", &out, "--plugin", plugin]);
    assert_eq!(again.status.code(), Some(4), "{}", String::from_utf8_lossy(&again.stderr));
    assert!(Path::new(&out).join("minimal-cpp-fault-occlusion-R1-f32.c").exists());
}

#[test]
fn failures_of_our_rows_are_reduced_too() {
    let folder = Folder::new();
    let arguments =
        format!("verify -j 2 --cases G1 -s dropper --rays 200 --shrink {}", folder.path());
    let ended = run_with(&PLANTED, &InstalledScenes, &SystemClock::default(), &arguments);
    assert_eq!(ended.code, 4, "{}", ended.err);
    for precision in ["f32", "f64"] {
        assert!(ended.out.contains(&format!("dropper-G1-{precision}.obj")), "{}", ended.out);
        let rays = folder.text(&format!("dropper-G1-{precision}.rays"));
        assert_eq!(rays.lines().filter(|line| !line.starts_with('#')).count(), 1, "{rays}");
    }
    assert!(ended.out.contains("dropper-G1-f32.c") && ended.out.contains("dropper-G1-f64.c"));
    let again = run_with(&PLANTED, &InstalledScenes, &SystemClock::default(), &arguments);
    assert!(again.code == 1 && again.err.contains("--overwrite"), "{}", again.err);
}
