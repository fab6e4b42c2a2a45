//! Plugins in several processes, in the gate and in `verify`, with limits, and those of `peers/`
//! that need more.

use std::path::Path;
use std::process::Command;

use measurement::record::Verdict;

use super::{compiled, minimal, root, rtbench, run};
use crate::common::{Folder, row};

#[test]
fn several_processes_load_the_plugin_each() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let more = ["--processes", "3", "--rounds", "2", "--plugin-limit", "30s"];
    let (code, record, said) = run(&plugin, "wide-bvh,minimal-cpp:leaf=2", &more);
    assert_eq!(code, 0, "{said}");
    for label in ["wide-bvh", "minimal-cpp leaf=2"] {
        let row = row(&record, label);
        assert_eq!(row.verdict, Verdict::Ok);
        let processes: Vec<u32> = row.samples.iter().map(|sample| sample.process).collect();
        assert_eq!(processes, [0, 0, 1, 1, 2, 2], "{label}");
        assert!(row.ratio.is_some());
    }
    assert!(record.floor.is_some(), "{said}");
    // a row that dies while it is checked costs the others nothing
    let (code, record, said) = run(&plugin, "wide-bvh,minimal-cpp:fault=crash", &more);
    assert_eq!(code, 1, "{said}");
    assert_eq!(row(&record, "minimal-cpp fault=crash").verdict, Verdict::Panicked);
    assert_eq!(row(&record, "wide-bvh").samples.len(), 6);
}

#[test]
fn time_of_extra_threads_is_reported() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let (code, record, said) = run(&plugin, "minimal-cpp,minimal-cpp:fault=spin", &[]);
    assert_eq!(code, 0, "{said}");
    let part = |label| row(&record, label).plugin.as_ref().unwrap().other_threads;
    assert!(part("minimal-cpp") < 0.05 && part("minimal-cpp fault=spin") > 0.5, "{said}");
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(words.matches("threads beyond -j").count(), 1, "{said}");
    // with several threads others than the one that calls are asked for
    let (_, record, _) = run(&plugin, "minimal-cpp:fault=spin", &["-j", "2"]);
    assert_eq!(row(&record, "minimal-cpp fault=spin").plugin.as_ref().unwrap().other_threads, 0.0);
}

#[test]
fn devices_are_timed_by_time_of_day_and_get_whole_batches() {
    let folder = Folder::new();
    let source = "crates/rtbench/tests/it/plugins/device.c";
    let waits = |more: &[&str]| {
        let plugin = compiled(&folder, source, more)?;
        let (code, record, said) = run(&plugin, "device", &[]);
        assert_eq!(code, 0, "{said}");
        let note = row(&record, "device").plugin.as_ref().unwrap().note.clone().unwrap();
        Some((row(&record, "device").trace_s.unwrap().median, note))
    };
    // it sleeps, which processor time does not show
    let Some((device, note)) = waits(&[]) else { return };
    assert!(note.starts_with("timed by time of day; its largest call had "), "{note}");
    let (processor, note) = waits(&["-DPROCESSOR"]).unwrap();
    assert!(note.starts_with("its largest call had "), "{note}");
    assert!(processor < device, "{processor} {device}");
    // more rays than threads get at a time
    // all of them, though a call takes long
    let more = ["-j", "2", "--size", "96", "--rays", "primary", "--pass-limit", "600s"];
    for (variant, is_whole) in [(&[][..], true), (&["-DPROCESSOR"], false)] {
        let Some(plugin) = compiled(&folder, source, variant) else { return };
        for place in [&[][..], &["--in-process"]] {
            let (code, record, said) = run(&plugin, "device", &[&more[..], place].concat());
            assert_eq!(code, 0, "{said}");
            let checked = row(&record, "device").checked_rays;
            assert!(checked > 4096, "{checked}");
            let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
            let whole = format!("its largest call had {checked} rays");
            assert_eq!(words.contains(&whole), is_whole, "{said}");
        }
    }
}

#[test]
fn baselines_have_rows_of_plugins() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let (plugin, baselines) = (plugin.to_str().unwrap(), Folder::new());
    let baselines = baselines.path();
    let asked = |arguments: &[&str]| {
        let ended = rtbench(&[arguments, &["--baselines", &baselines]].concat());
        let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
        (ended.status.code().unwrap(), said)
    };
    let rows = "wide-bvh,minimal-cpp";
    let save = ["baseline", "save", "base", "tetra:3", "--quick", "--rounds", "2", "-s", rows];
    let (code, said) = asked(&[&save[..], &["--plugin", plugin]].concat());
    assert_eq!(code, 0, "{said}");
    // nothing is a regression that is longer by less than ten times
    let check = ["check", "-b", "base", "--rounds", "2", "-t", "900%", "--all"];
    let (code, said) = asked(&[&check[..], &["--plugin", plugin]].concat());
    assert!(code == 0 && said.contains("minimal-cpp"), "{code} {said}");
    let (code, said) = asked(&check);
    assert_ne!(code, 0);
    assert!(
        said.contains("minimal-cpp belongs to the plugin minimal.so; give its file with --plugin"),
        "{said}"
    );
    // what valgrind counts is none of a plugin
    let (code, said) = asked(&[&check[..], &["--plugin", plugin, "--instructions"]].concat());
    assert!(code == 2 && said.contains("cannot be used with"), "{said}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_plugin_stays_within_its_memory_limit() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let rows = "wide-bvh,minimal-cpp,minimal-cpp:fault=memory";
    let (code, record, said) = run(&plugin, rows, &["--max-memory", "64MiB"]);
    assert_eq!(code, 1, "{said}");
    let refused = row(&record, "minimal-cpp fault=memory");
    assert_eq!(refused.verdict, Verdict::OutOfMemory, "{:?}", refused.error);
    assert!(refused.error.as_ref().unwrap().contains("more than the limit of 64 MiB"), "{said}");
    assert_eq!(row(&record, "minimal-cpp").verdict, Verdict::Ok);
    // with room for it the same row is one like others
    let (code, record, said) = run(&plugin, rows, &["--max-memory", "4GiB"]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(row(&record, "minimal-cpp fault=memory").verdict, Verdict::Ok);
}

#[test]
fn indices_are_passed_on_request_only() {
    let folder = Folder::new();
    let source = "crates/rtbench/tests/it/plugins/indexed.c";
    for more in [&[][..], &["-DNOT_ASKED"]] {
        let Some(plugin) = compiled(&folder, source, more) else { return };
        for place in [&[][..], &["--in-process"]] {
            for precision in ["f32", "f64"] {
                let place = [place, &["--precision", precision]].concat();
                let (code, record, said) = run(&plugin, "wide-bvh,indexed", &place);
                assert_eq!(code, 0, "{said}");
                let theirs = row(&record, "indexed");
                assert_eq!((theirs.verdict, theirs.mismatches), (Verdict::Ok, 0));
            }
        }
    }
}

#[test]
fn plugins_of_earlier_headers_go_on_working() {
    let folder = Folder::new();
    // the scene was smaller before indices, and the plugin before f64
    let header = std::fs::read_to_string(root().join("crates/plugins/include/rtbench.h")).unwrap();
    let (before, rest) =
        header.split_once("    /* The same triangles with each vertex once").unwrap();
    let (_, after) = rest.split_once("} rtbench_scene;").unwrap();
    let after = after.replace("RTBENCH_HAS_INDICES(scene)", "NOT_THERE(scene)");
    let (between, rest) = after.split_once("/* The four structs above in double").unwrap();
    let (_, rest) = rest.split_once("} rtbench_scene_f64;").unwrap();
    let (plugin, rest) = rest.split_once("    /* The same six for a plugin").unwrap();
    let (_, rest) = rest.split_once("} rtbench_plugin;").unwrap();
    let older = format!("{before}}} rtbench_scene;{between}{plugin}}} rtbench_plugin;{rest}");
    for later in ["vertex_count;", "rtbench_scene_f64", "_f64)("] {
        assert!(header.contains(later) && !older.contains(later), "{later}");
    }
    std::fs::write(Path::new(&folder.path()).join("rtbench.h"), older).unwrap();
    let path = folder.path();
    let Some(older) = compiled(&folder, "peers/brute-c/brute.c", &["-iquote", &path]) else {
        return;
    };
    for place in [&[][..], &["--in-process"]] {
        let (code, record, said) = run(&older, "wide-bvh,brute-c", place);
        assert_eq!(code, 0, "{said}");
        assert_eq!(row(&record, "brute-c").verdict, Verdict::Ok);
        let place = [place, &["--precision", "f64"]].concat();
        let (_, record, said) = run(&older, "wide-bvh,brute-c", &place);
        assert!(said.contains("supports f32 only (it lacks RTBENCH_TRIANGLES_F64)"), "{said}");
        assert_eq!(row(&record, "brute-c").verdict, Verdict::NotBuilt);
    }
}

#[test]
fn tables_say_where_a_row_comes_from() {
    let folder = Folder::new();
    let Some(plugin) = minimal(&folder) else { return };
    let (plugin, out) = (plugin.to_str().unwrap(), folder.path());
    let rows = ["-s", "wide-bvh,minimal-cpp", "--plugin", plugin, "-o", &out];
    let ended = rtbench(&[&["run", "tetra:5", "--quick"][..], &rows].concat());
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let record = folder.record();
    let text = folder.text("results.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let place = |name: &str| reader.headers().unwrap().iter().position(|h| h == name).unwrap();
    let [structure, origin, edges] = ["structure", "origin", "edge_mismatches"].map(place);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let of = |name: &str| rows.iter().find(|fields| &fields[structure] == name).unwrap();
    assert_eq!((&of("wide-bvh")[origin], &of("wide-bvh")[edges]), ("", ""));
    let counted = row(&record, "minimal-cpp").plugin.as_ref().unwrap().edge_mismatches;
    assert_eq!(&of("minimal-cpp")[origin], "plugin");
    assert_eq!(of("minimal-cpp")[edges], counted.to_string());
}

#[test]
fn a_peer_without_its_library_is_not_built() {
    let folder = Folder::new();
    for version in ["3", "4"] {
        let more = [format!("-DEMBREE={version}"), "-ldl".to_owned()];
        let more: Vec<&str> = more.iter().map(String::as_str).collect();
        let Some(plugin) = compiled(&folder, "peers/embree/embree.cpp", &more) else { return };
        let (plugin, variable) = (plugin.to_str().unwrap(), format!("EMBREE{version}_LIBRARY"));
        let name = format!("embree-{version}");
        let ended = Command::new(env!("CARGO_BIN_EXE_rtbench"))
            .args(["run", "tetra:2", "--quick", "-s", &format!("wide-bvh,{name}")])
            .args(["--plugin", plugin])
            .env(&variable, "/nowhere/libembree.so")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ended.stdout);
        assert_eq!(ended.status.code(), Some(1), "{said}");
        let why = format!("libembree{version}.so cannot be opened, set {variable}");
        assert!(said.lines().any(|l| l.starts_with(&name) && l.contains(&why)), "{said}");
    }
}

#[test]
fn peers_whose_sources_are_elsewhere_say_so() {
    let named = [("tinybvh", "TINYBVH"), ("bvh-v2", "BVH_V2"), ("nanort", "NANORT")];
    let mut script = Command::new("bash");
    script.arg(root().join("scripts/peers.sh"));
    for (name, variable) in named {
        script.arg(name).env_remove(variable);
    }
    let Ok(ended) = script.output() else { return println!("not tested: there is no bash") };
    let said = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success(), "{said}");
    for (name, variable) in named {
        assert!(said.contains(&format!("{name}: not built: set {variable} to a folder")), "{said}");
    }
}
