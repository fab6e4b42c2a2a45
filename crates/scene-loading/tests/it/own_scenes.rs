//! The generators of our own: sizes, and meshes that are what they say.

use std::collections::HashMap;

use scene_loading::procedural::{OURS, generate};
use scene_loading::{Scene, Shape};

fn triangles(scene: &Scene) -> Vec<[u32; 3]> {
    let of = |shape: Shape| match shape {
        Shape::Triangle { v } => v,
        other => panic!("{other:?}"),
    };
    scene.primitives.iter().map(|p| of(p.shape)).collect()
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
    let scene = generate("hare:20").unwrap();
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
fn the_hare_is_as_tall_as_it_says_and_its_triangles_are_of_like_size() {
    let scene = generate("hare").unwrap();
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
    let scene = generate("stadium").unwrap();
    assert_eq!(scene.primitives.len(), 84_992);
    let size = scene.bounds().size();
    assert!((229.0..232.0).contains(&size.x), "{size}");
    assert_eq!(generate("stadium:5").unwrap().primitives.len(), 8 * 25 + 15_800);
}

#[test]
fn largest_sizes_stay_below_twenty_million_primitives() {
    for entry in OURS {
        let count =
            |n: u32| 8 * u64::from(n).pow(2) + if entry.name == "hare" { 0 } else { 15_800 };
        assert!(count(entry.max_size) < 20_000_000 && count(entry.max_size + 1) > 20_000_000);
        assert_eq!((entry.generate)(3).primitives.len() as u64, count(3));
    }
}
