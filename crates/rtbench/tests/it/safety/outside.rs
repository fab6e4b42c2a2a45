//! Scene files with sources outside their folders, and second opinions about files.

use std::path::Path;

use crate::resuming::{journal, record, run, show};

/// A scene file that names a file above its folder.
fn scene_file(folder: &Path) -> String {
    std::fs::create_dir(folder.join("scenes")).unwrap();
    super::write_triangle(&folder.join("a.obj"));
    let text = serde_json::json!({
        "name": "outer", "title": "t", "why": "w", "source": { "file": "../a.obj" }
    });
    let path = folder.join("scenes/outer.json");
    std::fs::write(&path, text.to_string()).unwrap();
    show(&path)
}

#[test]
fn sources_outside_are_read_where_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (scene_file(folder.path()), folder.path().join("out"));
    let small = format!("{scene} tetra:1 --size 4 --rounds 1 -s obvhs-cwbvh,uniform-grid");
    for command in [format!("run {small}"), format!("scenes validate {scene}")] {
        let (code, _, err) = run(&command);
        assert_eq!(code, 1, "{command}: {err}");
        assert!(err.contains("outer.json") && err.contains("--allow-outside"), "{err}");
        let (code, _, err) = run(&format!("{command} --allow-outside"));
        assert_eq!(code, 0, "{command}: {err}");
    }
    let (code, _, err) = run(&format!("--allow-outside run {small} -o {}", show(&out)));
    assert_eq!(code, 0, "{err}");
    assert_eq!(record(&out).scenes.len(), 2);
    // a journal does not allow it by itself
    let text = std::fs::read_to_string(out.join("run.jsonl")).unwrap();
    let kept: String = text.split_inclusive('\n').take(3).collect();
    std::fs::write(out.join("run.jsonl"), kept).unwrap();
    let resume = format!("run --resume {}", show(&out));
    let (code, _, err) = run(&resume);
    assert!(code == 1 && err.contains("--allow-outside"), "{err}");
    let (code, _, err) = run(&format!("{resume} --allow-outside"));
    assert_eq!(code, 0, "{err}");
    assert!(journal(&out).is_complete);
}

/// The other process of a pair may read what this one may.
#[test]
fn children_read_what_their_parents_may() {
    let folder = tempfile::tempdir().unwrap();
    scene_file(folder.path());
    let program = env!("CARGO_BIN_EXE_rtbench");
    let check = |more: &str| {
        let mut command = std::process::Command::new(program);
        let rest = "--quick --size 4 --rounds 1 -s obvhs-cwbvh,uniform-grid";
        command.current_dir(folder.path()).args(["check", "outer", "--against", program]);
        command.args(rest.split(' ')).args(more.split_whitespace()).output().unwrap()
    };
    let refused = check("");
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");
    let allowed = check("--allow-outside");
    assert!(matches!(allowed.status.code(), Some(0 | 3)), "{allowed:?}");
}

#[test]
fn validate_asks_a_second_reader_and_says_where_they_differ() {
    let folder = tempfile::tempdir().unwrap();
    let (path, nff) = (folder.path().join("a.obj"), folder.path().join("a.nff"));
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    std::fs::write(folder.path().join("a.mtl"), "newmtl red\n").unwrap();
    for (text, said) in [
        (format!("mtllib a.mtl\n{text}"), "  tobj reads the same: 1 triangles"),
        // planted: for tobj a material must be known before it is used
        (
            format!("{text}mtllib a.mtl\n"),
            "  second reader: material `red`: 1 triangles here, 0 by tobj",
        ),
    ] {
        std::fs::write(&path, text).unwrap();
        let (code, out, err) = run(&format!("scenes validate {}", show(&path)));
        assert_eq!(code, 0, "{err}");
        assert!(out.contains(said), "{out}");
    }
    std::fs::write(
        &nff,
        "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 8 8\ns 0 0 0 1\n",
    )
    .unwrap();
    let (code, out, err) = run(&format!("scenes validate {}", show(&nff)));
    assert!(code == 0 && !out.contains("reader"), "{out}{err}");
}
