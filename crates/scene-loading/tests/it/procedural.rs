//! The generated scenes. Those of the SPD against the files that the original programs (SPD 3.14)
//! write; those of our own: sizes, and meshes that are what they say.
//!
//! Checksums, counts and bounds of the SPD were computed from those files, not from our scenes: the
//! checksum is the SHA-256 of the file with `-0` replaced by `0`, so that it covers every number
//! and the order of everything.

use std::collections::HashMap;

use glam::DVec3;
use scene_loading::procedural::{self, OURS, SPD, SpecError};
use scene_loading::{Scene, Shape};
use sha2::{Digest, Sha256};

use crate::nff_text::write_nff;
use crate::triangles;

/// What the original file of a scene holds: its name; numbers of spheres, cones, polygons, patches;
/// of materials and lights; its bounds; its checksum.
type Reference = (&'static str, [usize; 4], [usize; 2], [[f64; 3]; 2], &'static str);

#[rustfmt::skip]
const REFERENCES: [Reference; 8] = [
    ("balls", [7381, 0, 1, 0], [2, 3], [[-12.0, -12.0, -0.5], [12.0, 12.0, 0.83056684]],
     "ca955919729183aff08bde63286a8b6dc4196626f99f642f150b9210ed7249bf"),
    ("gears", [0, 0, 9345, 0], [65, 5], [[-2.0, -2.0, 0.0], [2.0, 2.0, 1.0]],
     "888b3b7f3573891dbfe3e5b5c852020677fb2c526f0455a57018ed57702c0336"),
    ("lattice", [2197, 6084, 0, 0], [8281, 6], [[-0.0208333; 3], [1.0208333; 3]],
     "768ec7e5327a523027235e71a898783e6e4d9cb2500c79ca25dfe6931ca66177"),
    ("mount", [4, 0, 8192, 0], [2, 1], [[-1.15961, -1.0, -0.702953], [1.0, 1.15961, 1.37821]],
     "c48f8bdbcc7f28e661939b9c246e41c78d562662bc9b43819000cdc9538809b9"),
    ("rings", [4200, 4200, 1, 0], [841, 3], [[-10.8389, 1.65358, -9.33895], [8.83895, 20.905, 10.3389]],
     "e0f31dca34897a69575da1492d1bcdd3c5a8b1101c109ea3040e28c3ca4cc042"),
    ("teapot", [0, 0, 144, 9120], [3, 2], [[-4.0, -4.0, 0.0], [4.0, 4.0, 3.15]],
     "90531da9a4374eb485da3270873e472093e28748c89940c7f094c19f7a35fed0"),
    ("tetra", [0, 0, 4096, 0], [1, 1], [[-1.0; 3], [1.0; 3]],
     "6bb2da0228e0edc67f1d780926aafc9fd1bd04c1887472a4af5b567a208dbffe"),
    ("tree", [4095, 4095, 1, 0], [2, 7], [[-50.0, -50.0, 0.0], [50.0, 50.0, 3.13748741]],
     "57ae111e5e70e6ca13caf5868804a43a1ca68dadf5dfffcbef265adefcada8a2"),
];

/// Spheres, cones, polygons, patches.
fn counts(scene: &Scene) -> [usize; 4] {
    let mut counts = [0; 4];
    for primitive in &scene.primitives {
        counts[match primitive.shape {
            Shape::Sphere(_) => 0,
            Shape::Cone(_) => 1,
            Shape::Polygon { .. } => 2,
            Shape::Patch { .. } => 3,
            Shape::Triangle { .. } => panic!("SPD scenes have no plain triangles"),
        }] += 1;
    }
    counts
}

fn checksum(scene: &Scene) -> String {
    let mut text = Vec::new();
    write_nff(scene, &mut text).unwrap();
    Sha256::digest(&text).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn default_sizes_equal_the_original_files() {
    assert!(SPD.iter().map(|e| e.name).eq(REFERENCES.iter().map(|r| r.0)));
    for (name, kinds, [materials, lights], bounds, sha256) in REFERENCES {
        let scene = procedural::generate(name).unwrap();
        assert_eq!(scene.name, name);
        assert_eq!(counts(&scene), kinds, "{name}");
        assert_eq!(scene.materials.len(), materials, "{name}");
        assert_eq!(scene.lights.len(), lights, "{name}");
        assert!(scene.lights.iter().all(|l| (l.color, l.radius) == (None, 0.0)));
        assert!(scene.warnings.is_empty());
        assert_eq!(checksum(&scene), sha256, "{name}");

        let printed = procedural::generate_as_printed(name).unwrap();
        assert_eq!(checksum(&printed), sha256, "{name}");
        let [min, max] = bounds.map(DVec3::from_array);
        let found = printed.bounds();
        assert!((found.min - min).abs().max_element() < 1e-8, "{name}: {found:?}");
        assert!((found.max - max).abs().max_element() < 1e-8, "{name}: {found:?}");
    }
}

#[test]
fn views_are_the_published_ones() {
    let camera = procedural::generate_as_printed("rings").unwrap().camera;
    assert_eq!(camera.from, DVec3::new(-1.0, -2.61313, 0.5));
    assert_eq!(camera.at, DVec3::new(-1.0, -1.61313, 0.5));
    assert_eq!(camera.up, DVec3::Z);
    assert_eq!((camera.angle, camera.hither, camera.resolution), (45.0, 1.0, [512, 512]));
    let camera = procedural::generate_as_printed("lattice").unwrap().camera;
    assert_eq!(camera.from, DVec3::new(0.541667, 1.0, 0.958333));
    assert_eq!(camera.at, DVec3::new(0.541667, -1.0, -1.04167));
    assert_eq!(camera.up, DVec3::new(0.2, 1.0, 0.0));
    assert_eq!((camera.angle, camera.hither, camera.resolution), (60.0, 0.0, [512, 512]));
}

#[test]
fn materials_count_the_surface_lines() {
    let scene = procedural::generate_as_printed("lattice").unwrap();
    for (i, primitive) in scene.primitives.iter().enumerate() {
        assert_eq!(primitive.material as usize, i);
    }
    let sphere = &scene.materials[0];
    assert_eq!(sphere.color, [0.9; 3]);
    assert_eq!((sphere.diffuse, sphere.specular, sphere.shine), (0.5, 0.5, 3.0827));
    assert_eq!((sphere.transmittance, sphere.refraction_index), (0.0, 0.0));
    let glass = &procedural::generate_as_printed("mount").unwrap().materials[0];
    assert_eq!((glass.diffuse, glass.specular, glass.shine), (0.1, 0.1, 101.148));
    assert_eq!((glass.transmittance, glass.refraction_index), (0.9, 1.5));
}

#[test]
fn a_changed_coordinate_changes_the_checksum() {
    let (.., sha256) = REFERENCES[0];
    let mut scene = procedural::generate_as_printed("balls").unwrap();
    assert_eq!(checksum(&scene), sha256);
    scene.spheres[5000].center.y *= 1.0 + 1e-4;
    assert_ne!(checksum(&scene), sha256);
}

#[test]
fn other_sizes_have_the_documented_counts() {
    let n = 3_usize;
    let rods = 5 * n * (n + 1) * (2 * n + 1);
    for (spec, expected) in [
        ("balls:3", [(9_usize.pow(4) - 1) / 8, 0, 1, 0]),
        ("gears:3", [0, 0, 146 * n.pow(3) + 1, 0]),
        ("lattice:3", [64, 3 * n * 16, 0, 0]),
        ("mount:3", [4, 0, 2 * 64, 0]),
        ("rings:3", [rods, rods, 1, 0]),
        ("teapot:3", [0, 0, 9, 64 * n * n - 8 * n]),
        ("tetra:3", [0, 0, 64, 0]),
        ("tree:3", [15, 15, 1, 0]),
    ] {
        let scene = procedural::generate(spec).unwrap();
        assert_eq!(scene.name, spec);
        assert_eq!(counts(&scene), expected, "{spec}");
    }
}

/// Checksums of what the original programs write at sizes that are not the default.
#[test]
fn other_sizes_equal_the_original_programs() {
    for (spec, sha256) in [
        ("balls:2", "889986d6c46a909339ad333680c98b3ff939bfe6aaf2aa513c36c8b3ef8be9b4"),
        ("gears:3", "12e2cbf84c947e288c0e38212a118db42023429b5d5db338c5d792fd898672b3"),
        ("lattice:5", "5729e1f3742969f4a31c37f97fd2758ac91097c6b106ab3253afaaf5786b7948"),
        ("mount:9", "4cc66c8dc2ba85c9117eb3219ac175bd228b0c5ea37b5b8706a80d7c74a366a6"),
        ("rings:3", "ee3002f59226b345d32361348db23d57446edea9ad48f30af6e07bb48bebf5ca"),
        ("teapot:5", "41756e21f0bf58aa7f4a553cf34791bb79078c0d20c67d2f2c86d3b545e2b48b"),
        ("tetra:4", "8002960cb8820727ace1ed3a78c7f680a3c39012077f641fa0472c00a1bafa14"),
        ("tree:8", "a72f719e9f786d1643558beec3805fb3bff3b7d8234dfac8645215f933cd00f5"),
    ] {
        assert_eq!(checksum(&procedural::generate(spec).unwrap()), sha256, "{spec}");
    }
}

#[test]
fn bad_specs_are_typed_errors() {
    let error = procedural::generate("bals").unwrap_err();
    assert!(matches!(&error, SpecError::UnknownName { name, .. } if name == "bals"));
    for entry in SPD {
        assert!(error.to_string().contains(entry.name), "{error}");
    }
    for size in ["0", "8", "", "-1", "four", "4:4", "99999999999999999999"] {
        let error = procedural::generate(&format!("balls:{size}")).unwrap_err();
        assert!(matches!(&error, SpecError::BadSize { name: "balls", max_size: 7, .. }));
        assert!(error.to_string().contains("from 1 to 7"), "{error}");
    }
}

#[test]
fn the_default_size_spelt_out_is_the_default_scene() {
    assert_eq!(procedural::generate("tetra:6"), procedural::generate("tetra"));
    assert_eq!(procedural::generate("tetra:5").unwrap().name, "tetra:5");
}

/// The limits are as large as 20 million primitives allow.
#[test]
fn largest_sizes_stay_below_twenty_million_primitives() {
    let primitives = |name: &str, n: u64| match name {
        "balls" => (9_u64.pow(n as u32 + 1) - 1) / 8 + 1,
        "gears" => 146 * n.pow(3) + 1,
        "lattice" => (n + 1).pow(3) + 3 * n * (n + 1).pow(2),
        "mount" => 2 * 4_u64.pow(n as u32) + 4,
        "rings" => 10 * n * (n + 1) * (2 * n + 1) + 1,
        "teapot" => 65 * n * n - 8 * n,
        "tetra" => 4_u64.pow(n as u32),
        "tree" => 2 * (2_u64.pow(n as u32 + 1) - 1) + 1,
        _ => panic!("no formula for {name}"),
    };
    for entry in SPD {
        let max = u64::from(entry.max_size);
        assert!(primitives(entry.name, max) < 20_000_000, "{}", entry.name);
        assert!(primitives(entry.name, max + 1) > 20_000_000, "{}", entry.name);
        let scene = (entry.generate)(2);
        assert_eq!(scene.primitives.len() as u64, primitives(entry.name, 2), "{}", entry.name);
    }
}

/// How often each edge is walked in a direction.
fn edges(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], u32> {
    let mut edges = HashMap::new();
    for &[a, b, c] in triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    edges
}

/// Closed, and all triangles wound alike: each edge is walked once in each direction.
fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let edges = edges(triangles);
    edges.iter().all(|([a, b], n)| *n == 1 && edges.get(&[*b, *a]) == Some(&1))
}

#[test]
fn the_hare_is_a_closed_mesh_that_faces_outward() {
    let scene = procedural::generate("hare:20").unwrap();
    let triangles = triangles(&scene);
    assert_eq!(triangles.len(), 8 * 20 * 20);
    assert!(is_closed(&triangles));
    // six times the volume, by the divergence theorem
    let volume: f64 = triangles
        .iter()
        .map(|t| t.map(|i| scene.vertices[i as usize]))
        .map(|[a, b, c]| a.dot(b.cross(c)))
        .sum();
    assert!((0.005..0.05).contains(&volume), "{volume}");
    // planted fault: a hole
    assert!(!is_closed(&triangles[1..]));
}

#[test]
fn the_hare_has_the_stated_height_and_triangles_of_similar_size() {
    let scene = procedural::generate("hare").unwrap();
    let size = scene.bounds().size();
    assert!((0.25..0.35).contains(&size.y), "{size}");
    let mut areas: Vec<f64> = triangles(&scene)
        .iter()
        .map(|t| t.map(|i| scene.vertices[i as usize]))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .collect();
    areas.sort_by(f64::total_cmp);
    let part = |p: f64| areas[(p * (areas.len() - 1) as f64) as usize];
    assert!(part(0.0) > 0.0 && part(0.95) / part(0.05) < 30.0, "{} {}", part(0.05), part(0.95));
}

#[test]
fn the_stadium_is_800_times_as_long_as_the_hare_is_tall() {
    let scene = procedural::generate("stadium").unwrap();
    assert_eq!(scene.primitives.len(), 84_992);
    let size = scene.bounds().size();
    assert!((229.0..232.0).contains(&size.x), "{size}");
    assert_eq!(procedural::generate("stadium:5").unwrap().primitives.len(), 8 * 25 + 15_800);
}

#[test]
fn sticks_are_closed_thin_and_in_all_directions() {
    let scene = procedural::generate("sticks:12").unwrap();
    let all = triangles(&scene);
    assert_eq!((all.len(), is_closed(&all)), (12 * 144, true));
    let size = scene.bounds().size();
    assert!(size.min_element() > 2.0 && size.max_element() < 3.3, "{size}");
    // six times the volume of a stick, and boxes that are far larger
    let mut small = 0;
    for stick in all.chunks(12) {
        let corners = stick.iter().map(|t| t.map(|i| scene.vertices[i as usize]));
        let volume: f64 = corners.clone().map(|[a, b, c]| a.dot(b.cross(c))).sum();
        let expected = 6.0 * 1.2 * 0.002 * 0.002;
        assert!((volume / expected - 1.0).abs() < 1e-6, "{volume} {expected}");
        let points = || corners.clone().flatten();
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let sides = points().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
        small += usize::from(sides.element_product() < 1000.0 * expected / 6.0);
    }
    assert!(small < 20, "{small} of 144 lie along an axis, or nearly");
}

#[test]
fn largest_sizes_of_ours_stay_below_twenty_million_primitives() {
    for entry in OURS {
        let count = |n: u32| (entry.count)(n).primitives();
        assert!(count(entry.max_size) < 20_000_000 && count(entry.max_size + 1) > 20_000_000);
        assert_eq!((entry.generate)(3).primitives.len() as u64, count(3));
    }
}
