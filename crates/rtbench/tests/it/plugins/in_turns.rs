//! Two builds of one plugin, in turns: what changed between them is found, by answers and by
//! tables.

use super::{compiled, minimal, rtbench};
use crate::common::Folder;

#[test]
fn two_builds_of_a_plugin_are_compared() {
    let (older, newer, wrong, out) = (Folder::new(), Folder::new(), Folder::new(), Folder::new());
    let Some(old) = minimal(&older) else { return };
    let source = "peers/minimal-cpp/minimal.cpp";
    let Some(new) = compiled(&newer, source, &["-pthread", "-DNDEBUG"]) else { return };
    let check = |new: &std::path::Path, name: &str| {
        let folder = format!("{}/{name}", out.path());
        let ended = rtbench(&[
            "check",
            "tetra:4",
            "--quick",
            "--size",
            "16",
            "-s",
            "minimal-cpp",
            "--plugin",
            new.to_str().unwrap(),
            "--against",
            old.to_str().unwrap(),
            "--rounds",
            "2",
            "-o",
            &folder,
        ]);
        let said = [ended.stdout, ended.stderr].concat();
        (ended.status.code().unwrap(), String::from_utf8_lossy(&said).into_owned())
    };
    let (code, said) = check(&new, "same");
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("check against plugin ") && said.contains("minimal.so"), "{said}");
    let report: serde_json::Value = serde_json::from_str(&out.text("same/check.json")).unwrap();
    let rows: Vec<&str> =
        report["pairs"].as_array().unwrap().iter().map(|p| p["row"].as_str().unwrap()).collect();
    assert!(rows.contains(&"minimal-cpp"), "{rows:?}");
    // planted: the newer build drops hits
    let text = std::fs::read_to_string(super::root().join(source)).unwrap();
    let dropping = text.replace("drops = fault == \"drop\"", "drops = true");
    assert_ne!(text, dropping);
    let file = std::path::Path::new(&wrong.path()).join("minimal.cpp");
    std::fs::write(&file, dropping).unwrap();
    let Some(bad) = compiled(&wrong, file.to_str().unwrap(), &["-pthread"]) else { return };
    let (code, said) = check(&bad, "wrong");
    assert!(code == 4 && said.contains("wrong hits"), "{code}: {said}");
}

#[test]
fn rows_that_neither_build_of_a_plugin_can_build_do_not_pass() {
    let (older, newer) = (Folder::new(), Folder::new());
    let Some(old) = minimal(&older) else { return };
    let source = "peers/minimal-cpp/minimal.cpp";
    let Some(new) = compiled(&newer, source, &["-pthread", "-DNDEBUG"]) else { return };
    let (new, old) = (new.to_str().unwrap(), old.to_str().unwrap());
    let check = |scenes: &[&str]| {
        let plugins = ["--plugin", new, "--against", old];
        let how = ["--quick", "--size", "16", "-s", "wide-bvh", "--rounds", "2", "-t", "900%"];
        let ended = rtbench(&[&["check"], scenes, &plugins, &how].concat());
        let said = [ended.stdout, ended.stderr].concat();
        (ended.status.code().unwrap(), String::from_utf8_lossy(&said).into_owned())
    };
    // spheres, which it refuses: rows of ours that did not change do not answer for it
    let (code, said) = check(&["balls:1"]);
    assert!(code == 6 && said.contains("1 not judged: not built"), "{code}: {said}");
    // where one scene is compared, the other is only named
    let (code, said) = check(&["balls:1", "tetra:4"]);
    assert!(code == 0 && said.contains("1 not judged: not built"), "{code}: {said}");
}
