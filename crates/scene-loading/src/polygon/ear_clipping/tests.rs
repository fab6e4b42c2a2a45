//! Polygons of every kind, their areas and the work on them.

use std::f64::consts::TAU;

use glam::DMat3;

use super::*;

/// Vector area: its length is the area, its direction the side from which the outline runs
/// against the clock.
fn vector_area(outline: &[DVec3]) -> DVec3 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| a.cross(*b) * 0.5).sum()
}

/// Cuts the outline up, in several planes and both senses, and checks count and area.
fn check(flat: &[[f64; 2]], triangles: usize) {
    for turn in 0..5 {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.0, f64::from(turn), 0.3);
        for reversed in [false, true] {
            let mut outline: Vec<_> = flat
                .iter()
                .map(|&[x, y]| turn * DVec3::new(x, y, 0.0) + DVec3::new(3.0, -2.0, 1.0))
                .collect();
            if reversed {
                outline.reverse();
            }
            let whole = vector_area(&outline);
            let part = |t: &[u32; 3]| vector_area(&t.map(|i| outline[i as usize]));
            let parts: Vec<_> = triangulate(&outline).unwrap().iter().map(part).collect();
            assert_eq!(parts.len(), triangles);
            // The areas' sum is the whole only if none overlaps, as all face the same way.
            let sum: f64 = parts.iter().map(|a| a.length()).sum();
            assert!((sum - whole.length()).abs() <= 1e-12 * sum, "{sum} {whole}");
            // Not below 0, but for slivers between vertices in line up to rounding.
            assert!(parts.iter().all(|a| a.dot(whole) > -1e-12 * sum * sum));
        }
    }
}

#[test]
fn squares_and_arrows() {
    check(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 2);
    // From any of its corners; a fan from some of them covers 3.6 instead of 0.4.
    let mut arrow = [[0.0, 0.0], [2.0, 0.0], [0.2, 0.2], [0.0, 2.0]];
    for _ in 0..4 {
        check(&arrow, 2);
        arrow.rotate_left(1);
    }
    check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]], 4);
}

#[test]
fn combs_stars_and_spirals() {
    // A comb: teeth that see little of each other.
    let mut comb = vec![[0.0, 0.0], [40.0, 0.0]];
    for i in (0..20).rev() {
        let x = 2.0 * f64::from(i);
        comb.extend([[x + 2.0, 1.0 + x * x / 2000.0], [x + 1.0, 9.0]]);
    }
    comb.push([0.0, 1.0]);
    check(&comb, comb.len() - 2);
    let ray = |i: u32, n: u32, r: f64| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
        [r * cos, r * sin]
    };
    let star: Vec<_> = (0..101).map(|i| ray(i, 101, 1.0 + f64::from(i * 37 % 29) / 3.0)).collect();
    check(&star, 99);
    let out = (0..60).map(|i| ray(i, 20, 1.0 + f64::from(i) / 10.0));
    let back = (0..60).rev().map(|i| ray(i, 20, 1.05 + f64::from(i) / 10.0));
    let spiral: Vec<_> = out.chain(back).collect();
    check(&spiral, 118);
}

#[test]
fn vertices_on_an_edge_stay() {
    let flat = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
    let outline = flat.map(|[x, y]| DVec3::new(x, y, 0.0));
    let triangles = triangulate(&outline).unwrap();
    assert_eq!(triangles.len(), 4);
    let areas = triangles.iter().map(|t| vector_area(&t.map(|i| outline[i as usize])).length());
    assert_eq!(areas.sum::<f64>(), 9.0);
}

#[test]
fn degenerate_outlines_end() {
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    assert!(triangulate(&[]).unwrap().is_empty());
    assert!(triangulate(&[p(0.0, 0.0), p(1.0, 0.0)]).unwrap().is_empty());
    assert!(triangulate(&[p(0.0, 0.0), p(1.0, 0.0), p(2.0, 0.0)]).unwrap().is_empty());
    assert!(triangulate(&[p(f64::NAN, 0.0), p(1.0, 0.0), p(2.0, 1.0)]).unwrap().is_empty());
    // A repeated vertex and a spike cost no triangles.
    let square = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
    assert_eq!(triangulate(&square).unwrap().len(), 2);
    let spike = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(5.0, 1.0), p(1.0, 1.0), p(0.0, 1.0)];
    let pieces = triangulate(&spike).unwrap();
    let areas = pieces.iter().map(|t| vector_area(&t.map(|i| spike[i as usize])).length());
    assert_eq!(areas.sum::<f64>(), 1.0);
    // A lopsided bow tie: crosses itself, but must end.
    let tie = [p(0.0, 0.0), p(2.0, 2.0), p(2.0, 0.0), p(0.0, 1.0)];
    assert!(triangulate(&tie).unwrap().len() <= 2);
}

#[test]
fn quadrangles_are_cut_up_alike_whatever_cuts_them() {
    let mut random = Random(5);
    let (mut convex_ones, mut others) = (0, 0);
    for _ in 0..2000 {
        // on a coarse grid, so that corners lie in line and in one place, too
        let mut at = || DVec2::new((random.next() * 6.0).floor(), (random.next() * 6.0).floor());
        let points = [at(), at(), at(), at()];
        let by_ring = Ring::new(points.to_vec()).cut_up(u64::MAX).unwrap();
        match convex(&points) {
            Some(triangles) => {
                assert_eq!(triangles, by_ring, "{points:?}");
                convex_ones += 1;
            }
            None => others += 1,
        }
    }
    assert!(convex_ones > 100 && others > 100, "{convex_ones} {others}");
}

/// Numbers in [0, 1), by a linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }
}

#[test]
fn many_vertices_are_cut_up_in_near_linear_time() {
    let n = 100_000;
    let mut random = Random(3);
    let mut ring = |radius: &mut dyn FnMut(&mut Random) -> f64| {
        let corner = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
            DVec2::new(cos, sin) * radius(&mut random)
        };
        (0..n).map(corner).collect::<Vec<DVec2>>()
    };
    let spiral = (0..n).map(|i| {
        let (j, off) = if i < n / 2 { (i, 0.0) } else { (n - 1 - i, 0.05) };
        let turns = j as f64 / (n / 2) as f64 * 100.0;
        DVec2::from_angle(turns) * (1.0 + turns / 10.0 + off)
    });
    for (name, outline, most) in [
        ("circle", ring(&mut |_| 1.0), 5),
        ("coast", ring(&mut |random| 1.0 + 1e-4 * random.next()), 300),
        ("star", ring(&mut |random| 0.5 + 0.5 * random.next()), STEPS_PER_CORNER),
        ("spiral", spiral.collect(), STEPS_PER_CORNER),
    ] {
        let cross = |[a, b, c]: [DVec2; 3]| orientation(a, b, c);
        let mut outline = outline;
        let origin = DVec2::splat(0.0);
        let area = |outline: &[DVec2]| {
            let next = outline.iter().cycle().skip(1);
            outline.iter().zip(next).map(|(&a, &b)| cross([origin, a, b])).sum::<f64>()
        };
        if area(&outline) < 0.0 {
            outline.reverse();
        }
        let mut ring = Ring::new(outline.clone());
        let triangles = ring.cut_up(u64::MAX).unwrap();
        assert_eq!(triangles.len(), n - 2, "{name}");
        let per_corner = ring.steps / n as u64;
        assert!(per_corner < most, "{name}: {per_corner} steps a corner");
        // The sum is the whole only if no triangle overlaps another.
        let parts = triangles.iter().map(|t| cross(t.map(|i| outline[i as usize])).abs());
        let (sum, whole) = (parts.sum::<f64>(), area(&outline));
        assert!((sum - whole).abs() < 1e-9 * sum, "{name}: {sum} {whole}");
        // The planted fault: with a budget it ends early, and says so.
        assert!(Ring::new(outline).cut_up(ring.steps / 2).is_none(), "{name}");
    }
}

#[test]
fn a_bent_outline_has_no_hole() {
    // Seen along any axis two of its corners are one; along its area vector they are not.
    let outline = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 1]]
        .map(|p: [i32; 3]| DVec3::from_array(p.map(f64::from)));
    let triangles = triangulate_bent(&outline, vector_area(&outline)).unwrap();
    assert_eq!(triangles, [[0, 1, 2], [2, 3, 0]]);
    // The planted fault: taken for a flat one it loses half of itself.
    assert_eq!(triangulate(&outline).unwrap().len(), 1);
    // A corner twice costs nothing: its triangle is there, without area.
    let twice = [outline[0], outline[1], outline[1], outline[2], outline[3]];
    assert_eq!(triangulate_bent(&twice, vector_area(&twice)).unwrap().len(), 3);
}
