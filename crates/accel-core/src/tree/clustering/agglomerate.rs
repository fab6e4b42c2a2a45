//! Agglomerative clustering of boxes by the surface their joint box wastes.
//!
//! Paper: K. Klimaszewski, T. Sederberg, "Faster Ray Tracing Using Adaptive Grids", IEEE CG&A
//! 17(1), 1997: of all pairs of clusters, the one with the smallest A / (A1 + A2) is merged (A the
//! surface of the box around both), again and again, as long as that ratio is below f and A is at
//! most the fraction m of the scene's surface.
//!
//! Deviation: finding the best of all pairs is quadratic. Beyond a number of boxes that the caller
//! sets, clusters are kept in Morton order, each looks for its best partner among the 16 on either
//! side only, and pairs that choose each other are merged at once (D. Meister, J. Bittner,
//! "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", IEEE TVCG
//! 24(3), 2018). Once few enough clusters are left, the exact method goes on.

use obvhs::ploc::morton::morton_encode_u64;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::parallel::{collect, sort};

/// When two clusters may be merged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MergeRule {
    /// f: A / (A1 + A2) must be below it.
    pub ratio: f64,
    /// Largest surface of a cluster's box.
    pub max_surface: f64,
    /// Up to this number of clusters the best of all pairs is found.
    pub exact_up_to: usize,
}

/// How far a cluster looks in Morton order, on either side.
const WINDOW: usize = 16;

/// Half the surface of a box does for ratios; the limit is halved as well.
#[derive(Clone, Copy)]
struct Cluster {
    bounds: Aabb<f64>,
    half: f64,
    /// Its first member in the chain.
    head: u32,
    tail: u32,
}

impl Cluster {
    fn joined(&self, other: &Self) -> f64 {
        self.bounds.union(other.bounds).half_area()
    }
}

/// The surface of a box.
pub fn surface<S: Scalar>(b: &Aabb<S>) -> f64 {
    2.0 * b.half_area()
}

/// The clusters, each ascending, in the order of their lowest members. Single boxes are clusters
/// of one.
pub fn agglomerate<S: Scalar>(boxes: &[Aabb<S>], rule: &MergeRule) -> Vec<Vec<u32>> {
    let mut clusters = collect(boxes.len(), |i| Cluster {
        bounds: boxes[i].in_double(),
        half: 0.5 * surface(&boxes[i]),
        head: i as u32,
        tail: i as u32,
    });
    // chains of members; the end of a chain points at itself
    let mut next: Vec<u32> = (0..boxes.len() as u32).collect();
    if clusters.len() > rule.exact_up_to {
        local(&mut clusters, &mut next, rule);
    }
    if clusters.len() <= rule.exact_up_to {
        exact(&mut clusters, &mut next, rule);
    }
    let mut all: Vec<Vec<u32>> = clusters
        .iter()
        .map(|c| {
            let mut members = vec![c.head];
            let mut at = c.head;
            while next[at as usize] != at {
                at = next[at as usize];
                members.push(at);
            }
            members.sort_unstable();
            members
        })
        .collect();
    all.sort_unstable_by_key(|c| c[0]);
    all
}

impl MergeRule {
    /// A / (A1 + A2), or infinity when the pair must not be merged.
    #[inline(always)]
    fn cost(&self, a: &Cluster, b: &Cluster) -> f64 {
        let joined = a.joined(b);
        let sum = a.half + b.half;
        // two boxes without surface: alike if their joint box has none either
        let ratio = if joined > 0.0 { joined / sum } else { 0.0 };
        if ratio < self.ratio && 2.0 * joined <= self.max_surface { ratio } else { f64::INFINITY }
    }
}

fn merged(a: &Cluster, b: &Cluster, next: &mut [u32]) -> Cluster {
    next[a.tail as usize] = b.head;
    let bounds = a.bounds.union(b.bounds);
    Cluster { bounds, half: bounds.half_area(), head: a.head, tail: b.tail }
}

/// Merges the best of all pairs until none may be merged: every cluster remembers its best
/// partner and looks for another only when that one was merged into something worse.
fn exact(clusters: &mut Vec<Cluster>, next: &mut [u32], rule: &MergeRule) {
    let n = clusters.len();
    let mut alive: Vec<usize> = (0..n).collect();
    let search = |clusters: &[Cluster], alive: &[usize], i: usize| {
        let mut found = (f64::INFINITY, usize::MAX);
        for &j in alive {
            let cost = rule.cost(&clusters[i], &clusters[j]);
            if cost < found.0 && j != i {
                found = (cost, j);
            }
        }
        found
    };
    let mut best: Vec<_> = (0..n).map(|i| search(clusters, &alive, i)).collect();
    loop {
        let mut first = usize::MAX;
        let mut lowest = f64::INFINITY;
        for &i in &alive {
            if best[i].0 < lowest {
                (lowest, first) = (best[i].0, i);
            }
        }
        if first == usize::MAX {
            break;
        }
        let (a, b) = (first.min(best[first].1), first.max(best[first].1));
        clusters[a] = merged(&clusters[a], &clusters[b], next);
        alive.retain(|&i| i != b);
        for &i in &alive {
            if i == a {
                best[i] = search(clusters, &alive, i);
                continue;
            }
            let candidate = (rule.cost(&clusters[i], &clusters[a]), a);
            let lost_partner = best[i].1 == a || best[i].1 == b;
            if candidate.0 < best[i].0
                || candidate.0 == best[i].0 && (lost_partner || a < best[i].1)
            {
                if candidate.0 < f64::INFINITY {
                    best[i] = candidate;
                }
            } else if lost_partner {
                best[i] = search(clusters, &alive, i);
            }
        }
    }
    *clusters = alive.iter().map(|&i| clusters[i]).collect();
}

/// Merges pairs of mutually best partners within a window of the Morton order, until hardly any
/// (one in a thousand) merge or the exact method can take over.
fn local(clusters: &mut Vec<Cluster>, next: &mut [u32], rule: &MergeRule) {
    sort_by_morton_code(clusters);
    loop {
        let n = clusters.len();
        let partner = collect(n, |i| {
            // the order of pairs is total, so the very best pair is always mutual; among equal
            // ones, i ^ j lets all copies of a box pair up at once
            let mut best = (f64::INFINITY, usize::MAX, usize::MAX);
            let mut found = usize::MAX;
            for j in i.saturating_sub(WINDOW)..(i + WINDOW + 1).min(n) {
                if j != i {
                    let cost = rule.cost(&clusters[i], &clusters[j]);
                    let candidate = (cost, i ^ j, i.min(j));
                    if cost < f64::INFINITY && candidate < best {
                        (best, found) = (candidate, j);
                    }
                }
            }
            found
        });
        let mut kept = Vec::with_capacity(n);
        for i in 0..n {
            match partner[i] {
                usize::MAX => kept.push(clusters[i]),
                j if partner[j] != i => kept.push(clusters[i]),
                j if i < j => kept.push(merged(&clusters[i], &clusters[j], next)),
                _ => {}
            }
        }
        let done = n - kept.len() <= n / 1000 || kept.len() <= rule.exact_up_to;
        *clusters = kept;
        if done {
            return;
        }
    }
}

fn sort_by_morton_code(clusters: &mut Vec<Cluster>) {
    let centre = |c: &Cluster| c.bounds.min * 0.5 + c.bounds.max * 0.5;
    let around = |all: Aabb<f64>, p| all.union(Aabb { min: p, max: p });
    let all = clusters.iter().map(centre).fold(Aabb::empty(), around);
    let extent = all.size().max_element().max(f64::MIN_POSITIVE);
    let code = |c: &Cluster| {
        let place = ((centre(c) - all.min) / extent * f64::from(1 << 20)).as_uvec3();
        morton_encode_u64(place.x, place.y, place.z)
    };
    let mut keys = collect(clusters.len(), |i| (code(&clusters[i]), i as u32));
    sort(&mut keys);
    *clusters = collect(keys.len(), |k| clusters[keys[k].1 as usize]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn cube(x: f64, y: f64, side: f64) -> Aabb<f64> {
        let min = DVec3::new(x, y, 0.0);
        Aabb { min, max: min + side }
    }

    fn rule(ratio: f64, max_surface: f64, exact_up_to: usize) -> MergeRule {
        MergeRule { ratio, max_surface, exact_up_to }
    }

    /// Two heaps of cubes far apart, and a cube alone.
    fn heaps() -> Vec<Aabb<f64>> {
        let mut boxes = Vec::new();
        for i in 0..40 {
            let (x, y) = (f64::from(i % 7) * 1.01, f64::from(i / 7) * 1.01);
            boxes.push(cube(x, y, 1.0));
            boxes.push(cube(x + 1000.0, y, 1.0));
        }
        boxes.push(cube(0.0, 1e5, 1.0));
        boxes
    }

    #[test]
    fn heaps_become_clusters_whichever_method() {
        for exact_up_to in [1000, 10] {
            let clusters = agglomerate(&heaps(), &rule(1.5, f64::INFINITY, exact_up_to));
            let sizes: Vec<_> = clusters.iter().map(Vec::len).collect();
            assert_eq!(sizes, [40, 40, 1], "exact up to {exact_up_to}");
            assert!(clusters[0].iter().all(|i| i % 2 == 0));
        }
    }

    #[test]
    fn the_limit_on_surface_is_kept() {
        let boxes = heaps();
        for exact_up_to in [1000, 10] {
            let clusters = agglomerate(&boxes, &rule(2.0, 20.0, exact_up_to));
            assert!(clusters.len() > 20);
            for c in &clusters {
                let b = c.iter().fold(Aabb::empty(), |b, &i| b.union(boxes[i as usize]));
                assert!(c.len() == 1 || surface(&b) <= 20.0);
            }
            assert_eq!(clusters.iter().map(Vec::len).sum::<usize>(), boxes.len());
        }
    }

    #[test]
    fn greedy_takes_the_best_pair_first() {
        // 0-1 waste least; then 2 joins them, while 3 is too far
        let boxes =
            [cube(0.0, 0.0, 1.0), cube(1.0, 0.0, 1.0), cube(2.2, 0.0, 1.0), cube(9.0, 0.0, 1.0)];
        assert_eq!(agglomerate(&boxes, &rule(0.9, 1e9, 99)), [vec![0, 1], vec![2], vec![3]]);
        assert_eq!(agglomerate(&boxes, &rule(1.1, 1e9, 99)), [vec![0, 1, 2], vec![3]]);
        assert_eq!(agglomerate(&boxes, &rule(0.5, 1e9, 99)).len(), 4);
    }

    #[test]
    fn points_and_copies_end() {
        for boxes in [vec![cube(1.0, 1.0, 0.0); 5000], vec![cube(1.0, 1.0, 1.0); 5000]] {
            for exact_up_to in [10_000, 100] {
                assert_eq!(agglomerate(&boxes, &rule(1.5, 1e9, exact_up_to)).len(), 1);
            }
        }
    }
}
