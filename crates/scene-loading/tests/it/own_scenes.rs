//! The generators of our own: sizes, and meshes that are what they say.

use std::collections::HashMap;

use glam::DVec3;
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
fn the_hare_has_the_stated_height_and_triangles_of_similar_size() {
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
fn sticks_are_closed_thin_and_in_all_directions() {
    let scene = generate("sticks:12").unwrap();
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
fn largest_sizes_stay_below_twenty_million_primitives() {
    for entry in OURS {
        let count = |n: u32| (entry.count)(n).primitives();
        assert!(count(entry.max_size) < 20_000_000 && count(entry.max_size + 1) > 20_000_000);
        assert_eq!((entry.generate)(3).primitives.len() as u64, count(3));
    }
}
