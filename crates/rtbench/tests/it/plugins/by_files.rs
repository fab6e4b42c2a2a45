//! Rays, triangles and hits by files: what a program that is no plugin has.

use std::fs;
use std::path::Path;

use super::rtbench;
use crate::common::Folder;

const HEADER: usize = 128;

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

/// Moeller and Trumbore in f64, as a stranger would write it.
fn hit(ray: [f64; 8], triangle: [f64; 9]) -> Option<f64> {
    let at = |i: usize| glam::DVec3::from_slice(&triangle[3 * i..]);
    let (origin, direction) =
        (glam::DVec3::from_slice(&ray[0..]), glam::DVec3::from_slice(&ray[4..]));
    let (e1, e2, s) = (at(1) - at(0), at(2) - at(0), origin - at(0));
    let (h, q) = (direction.cross(e2), s.cross(e1));
    let det = e1.dot(h);
    let (u, v, t) = (s.dot(h) / det, direction.dot(q) / det, e2.dot(q) / det);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray[3] && t <= ray[7]).then_some(t)
}

/// Bytes of a file's header, by its version.
fn header(bytes: &[u8]) -> usize {
    if bytes[8] == 2 { HEADER + 24 } else { HEADER }
}

/// An external program: reads files of rays and triangles, writes a file of hits.
pub fn answered(rays: &[u8], triangles: &[u8]) -> Vec<u8> {
    let numbers = |bytes: &[u8], n: usize| -> Vec<f64> {
        (0..n).map(|i| f64::from(f32_at(bytes, 4 * i))).collect()
    };
    let all: Vec<[f64; 9]> = triangles[header(triangles)..]
        .chunks(40)
        .map(|c| numbers(c, 9).try_into().unwrap())
        .collect();
    let mut hits = rays[..header(rays)].to_vec();
    hits[..8].copy_from_slice(b"RTBHITS\n");
    hits[12] = 8;
    for record in rays[header(rays)..].chunks(32) {
        let ray: [f64; 8] = numbers(record, 8).try_into().unwrap();
        let found = all.iter().zip(0u32..).filter_map(|(tri, id)| Some((hit(ray, *tri)?, id)));
        let (t, id) = found.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, u32::MAX));
        hits.extend((t as f32).to_le_bytes());
        hits.extend(id.to_le_bytes());
    }
    hits
}

#[test]
fn answers_of_another_program_are_judged() {
    let folder = Folder::new();
    let file = |name: &str| Path::new(&folder.path()).join(name).to_str().unwrap().to_owned();
    let (rays, triangles, answers) = (file("a.rays"), file("a.tris"), file("a.hits"));
    let kinds = "primary,diffuse,shadow";
    let ended = rtbench(&[
        "rays",
        "export",
        "tetra:3",
        "--size",
        "24",
        "--kind",
        kinds,
        "-o",
        &rays,
        "--triangles",
        &triangles,
    ]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let (r, t) = (fs::read(&rays).unwrap(), fs::read(&triangles).unwrap());
    assert_eq!((&r[..8], &t[..8]), (&b"RTBRAYS\n"[..], &b"RTBTRIS\n"[..]));
    let [primary, shadow] = [u64_at(&r, 16), u64_at(&r, 24)];
    assert_eq!((primary, u64_at(&t, 56)), (24 * 24, 64));
    assert!(shadow > 0 && t.len() == HEADER + 40 * 64);
    let hits = answered(&r, &t);
    let check = |hits: &[u8]| {
        fs::write(&answers, hits).unwrap();
        let ended = rtbench(&["rays", "check", "tetra:3", &answers]);
        let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
        (ended.status.code().unwrap(), said)
    };
    let (code, said) = check(&hits);
    assert_eq!(code, 0, "{said}");
    // planted faults
    let mut some_hit = HEADER;
    while hits[some_hit + 4..some_hit + 8] == [255; 4] {
        some_hit += 8;
    }
    let mut bad = hits.clone();
    bad[some_hit + 4..some_hit + 8].fill(255);
    let (code, said) = check(&bad);
    assert!(code == 4 && said.contains("drops a hit"), "{said}");
    let mut bad = hits.clone();
    let shadows = HEADER + 8 * primary as usize;
    let blocked = |record: &mut [u8]| {
        let is_blocked = record[4..8] != [255; 4];
        record[4..8].fill(if is_blocked { 255 } else { 0 });
    };
    bad[shadows..shadows + 8 * shadow as usize].chunks_mut(8).for_each(blocked);
    let (code, said) = check(&bad);
    assert!(code == 4 && said.contains("wrong occlusion"), "{said}");
    // files that are none: named with the place
    let mut bad = hits.clone();
    bad[some_hit + 4] = 99;
    let (code, said) = check(&bad);
    assert!(code == 1 && said.contains(&format!("byte {some_hit}: ")), "{said}");
    let (code, said) = check(&hits[..hits.len() - 1]);
    assert!(code == 1 && said.contains(&format!("byte {}: ", hits.len() - 1)), "{said}");
    let mut bad = hits.clone();
    bad[80] ^= 1;
    let (code, said) = check(&bad);
    assert!(code == 1 && said.contains("byte 80: its rays belong to another scene"), "{said}");
    let (code, said) = check(b"RTBHITS\n");
    assert!(code == 1 && said.contains("byte 8: the file ends within its header"), "{said}");
}

#[test]
fn rays_may_be_six_numbers() {
    let folder = Folder::new();
    let file = Path::new(&folder.path()).join("a.rays");
    let path = file.to_str().unwrap();
    let arguments = ["rays", "export", "tetra:2", "--size", "8", "--kind", "primary", "--format"];
    let ended = rtbench(&[&arguments[..], &["hagrid", "-o", path]].concat());
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    assert_eq!(fs::read(&file).unwrap().len(), 64 * 24);
    // what is there is not written over
    assert!(!rtbench(&[&arguments[..], &["hagrid", "-o", path]].concat()).status.success());
    let ended = rtbench(&["rays", "export", "balls:1", "-o", &format!("{path}.not")]);
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(
        !ended.status.success() && said.contains("other primitives than static triangles"),
        "{said}"
    );
}

#[test]
fn exports_of_far_scenes_name_the_origin_and_are_judged() {
    let folder = Folder::new();
    let file = |name: &str| Path::new(&folder.path()).join(name).to_str().unwrap().to_owned();
    let [scene, rays, triangles, answers] = ["a.obj", "a.rays", "a.tris", "a.hits"].map(file);
    let mut text = String::new();
    for i in 0..9 {
        let [x, y] = [448_000 + i % 3, 5_411_000 + i / 3];
        text += &format!("v {x}.1 {y}.1 12\nv {x}.9 {y}.1 12.5\nv {x}.1 {y}.9 12.25\nf -3 -2 -1\n");
    }
    fs::write(&scene, text).unwrap();
    let kind = ["--kind", "primary,shadow"];
    let files = ["-o", &rays, "--triangles", &triangles];
    let command = [&["rays", "export", &scene, "--size", "24"], &kind[..], &files[..]].concat();
    let ended = rtbench(&command);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let (r, t) = (fs::read(&rays).unwrap(), fs::read(&triangles).unwrap());
    for bytes in [&r, &t] {
        let origin = [0, 1, 2].map(|k| f64::from_bits(u64_at(bytes, HEADER + 8 * k)));
        assert_eq!((bytes[8], origin), (2, [448_000.0, 5_411_000.0, 0.0]));
    }
    // a record and the origin are a corner of the file
    assert!((f64::from(f32_at(&t, header(&t))) - 0.1).abs() < 1e-7);
    let check = |hits: &[u8]| {
        fs::write(&answers, hits).unwrap();
        rtbench(&["rays", "check", &scene, &answers]).status.code()
    };
    let hits = answered(&r, &t);
    assert_eq!(check(&hits), Some(0));
    // planted: one parameter that is another
    let first = (header(&hits)..hits.len()).step_by(8).find(|&at| hits[at + 4] != 255).unwrap();
    let mut wrong = hits.clone();
    wrong[first..first + 4].copy_from_slice(&1.0f32.to_le_bytes());
    assert_eq!(check(&wrong), Some(4));
}
