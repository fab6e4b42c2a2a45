//! `rtbench rays trace`: rays come in by files, and hits go out.

use std::fs;
use std::path::Path;

use super::{compiled, minimal, rtbench};
use crate::common::Folder;

fn ended(arguments: &[&str]) -> (i32, String, String) {
    let ended = rtbench(arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (ended.status.code().unwrap(), text(&ended.stdout), text(&ended.stderr))
}

#[test]
fn rays_that_went_out_come_in_and_their_hits_are_right() {
    let folder = Folder::new();
    let file = |name: &str| Path::new(&folder.path()).join(name).to_str().unwrap().to_owned();
    let (rays, hits) = (file("a.rays"), file("a.hits"));
    let export = ["rays", "export", "tetra:3", "--size", "24", "-o", &rays];
    let (code, _, err) = ended(&export);
    assert_eq!(code, 0, "{err}");
    let trace = ["rays", "trace", "tetra:3", "--rays", &rays, "-s", "kd-tree", "-o", &hits];
    let (code, out, err) = ended(&trace);
    assert!(code == 0 && out.is_empty(), "{out}{err}");
    let (code, out, err) = ended(&["rays", "check", "tetra:3", &hits]);
    assert!(code == 0 && out.contains("shadow"), "{out}{err}");
    // planted: a hit that is lost is seen
    let mut bytes = fs::read(&hits).unwrap();
    let first = 128 + 8 * bytes[128..].chunks(8).position(|hit| hit[4..] != [255; 4]).unwrap();
    bytes[first + 4..first + 8].fill(255);
    fs::write(&hits, bytes).unwrap();
    assert_eq!(ended(&["rays", "check", "tetra:3", &hits]).0, 4);
    // nothing is written over, and a file of hits has one answer for each ray
    let (code, _, err) = ended(&trace);
    assert!(code == 1 && err.contains("--overwrite"), "{err}");
    let two = [
        "rays",
        "trace",
        "tetra:3",
        "--rays",
        &rays,
        "-s",
        "kd-tree,octree",
        "-o",
        &file("b.hits"),
    ];
    let (code, _, err) = ended(&two);
    assert!(code == 2 && err.contains("one structure"), "{err}");
    // rays of another scene, or fewer than are spoken of
    let (code, _, err) = ended(&["rays", "trace", "tetra:2", "--rays", &rays, "-s", "kd-tree"]);
    assert!(code == 1 && err.contains("byte 80: the rays belong to another scene"), "{err}");
    let bytes = fs::read(&rays).unwrap();
    fs::write(&rays, &bytes[..bytes.len() - 1]).unwrap();
    let (code, _, err) = ended(&["rays", "trace", "tetra:3", "--rays", &rays, "-s", "kd-tree"]);
    assert!(code == 1 && err.contains("its header states"), "{err}");
}

#[test]
fn rays_as_text_are_traced_by_several_rows() {
    let folder = Folder::new();
    let file = |name: &str| Path::new(&folder.path()).join(name).to_str().unwrap().to_owned();
    let (scene, rays) = (file("a.obj"), file("a.rays"));
    fs::write(&scene, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(
        &rays,
        "# down, and up\n0.25 0.25 0x1p+0 0 0 0 -0x1.8p+0 inf\n0.25 0.25 1 0 0 0 1 9\n",
    )
    .unwrap();
    let mut arguments =
        vec!["rays", "trace", &scene, "--rays", &rays, "-s", "brute-force,wide-bvh"];
    let hits = file("a.hits");
    let (code, _, err) = ended(&[&arguments[..6], &["octree", "-o", &hits]].concat());
    assert!(code == 1 && err.contains("byte 0: text: hits are written for"), "{err}");
    let plugin = minimal(&folder);
    if let Some(plugin) = &plugin {
        arguments.extend(["--plugin", plugin.to_str().unwrap()]);
    }
    for precision in ["f32", "f64"] {
        let (code, out, err) = ended(&[&arguments[..], &["--precision", precision]].concat());
        assert_eq!(code, 0, "{err}");
        let of_f64 = out.matches("(0x1.5555555555555p-1)").count();
        assert_eq!(of_f64, if precision == "f64" { out.lines().count() / 2 } else { 0 }, "{out}");
        let hit = "ray 0: primitive 0 at t = 0.666666";
        assert_eq!(out.matches(hit).count(), out.lines().count() / 2, "{out}");
        assert!(out.contains("(0x1.5555") && out.contains("ray 1: no hit"), "{out}");
    }
    if let Some(plugin) = compiled(&folder, "peers/brute-c/brute.c", &[]) {
        let plugin = ["--plugin", plugin.to_str().unwrap(), "--precision", "f64"];
        let (code, _, err) = ended(&[&arguments[..5], &plugin, &["-s", "brute-c"]].concat());
        assert!(code == 1 && err.contains("brute-c: cannot be built: supports f32 only"), "{err}");
    }
    for (text, said) in [("1 2 3\n", ":1: 3 numbers"), ("\n1 2 3 0 0 0 x 1\n", ":2: 'x' is no")] {
        fs::write(&rays, text).unwrap();
        let (code, _, err) = ended(&arguments);
        assert!(code == 1 && err.contains(said), "{err}");
    }
    fs::write(&rays, [255, 254, 0]).unwrap();
    let (code, _, err) = ended(&arguments);
    assert!(code == 1 && err.contains("byte 0: neither"), "{err}");
}
