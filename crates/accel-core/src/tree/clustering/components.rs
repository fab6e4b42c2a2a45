//! Connected components of boxes: two boxes are connected when they are near each other.
//!
//! Idea: F. Cazals, G. Drettakis, C. Puech, "Filtering, Clustering and Hierarchy Construction: a
//! New Solution for Ray-Tracing Complex Scenes", Eurographics 1995, who cluster objects of like
//! size by their distance. Deviation: a component is flooded box by box, and flooded boxes leave
//! the search tree at once, so that 10,000 copies of one box cost one query, not 10,000 squared.
//! Several threads flood parts of space, and then the boxes at their borders.

use std::cmp::Ordering;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::parallel::{forks, should_parallelize};
use crate::tree::clustering::box_tree::{BoxTree, NeighbourRule};

/// The components, each ascending, in the order of their lowest members; on all threads.
pub fn components<S: Scalar>(boxes: &[Aabb<S>], near: &NeighbourRule<S>) -> Vec<Vec<u32>> {
    let ids = (0..boxes.len() as u32).collect();
    let mut all = in_halves(boxes, near, ids, forks());
    for members in &mut all {
        members.sort_unstable();
    }
    all.sort_unstable_by_key(|members| members[0]);
    all
}

/// The components of these boxes, in any order: those of two halves at once, `forks` times one
/// below the other, and then those that boxes near the other half connect.
fn in_halves<S: Scalar>(
    boxes: &[Aabb<S>],
    near: &NeighbourRule<S>,
    mut ids: Vec<u32>,
    forks: u32,
) -> Vec<Vec<u32>> {
    if forks == 0 || !should_parallelize(ids.len()) {
        return flooded(boxes, near, &ids);
    }
    let around = |ids: &[u32]| ids.iter().fold(Aabb::empty(), |b, &i| boxes[i as usize].union(b));
    let axis = around(&ids).longest_axis();
    let low = |i: u32| boxes[i as usize].min.to_array()[axis];
    let middle = ids.len() / 2;
    ids.select_nth_unstable_by(middle, |&a, &b| {
        low(a).partial_cmp(&low(b)).unwrap_or(Ordering::Equal).then(a.cmp(&b))
    });
    let upper = ids.split_off(middle);
    let (below, above) = (around(&ids), around(&upper));
    let is_near = |other: Aabb<S>| move |&i: &u32| near.holds(&boxes[i as usize], &other);
    let border: Vec<u32> = ids.iter().copied().filter(is_near(above)).collect();
    let border = [border, upper.iter().copied().filter(is_near(below)).collect()].concat();
    let half = |ids| in_halves(boxes, near, ids, forks - 1);
    let (mut parts, upper) = rayon::join(|| half(ids), || half(upper));
    parts.extend(upper);
    connected(boxes.len(), parts, flooded(boxes, near, &border))
}

/// The components of these boxes, in the order of their lowest places in `ids`.
fn flooded<S: Scalar>(boxes: &[Aabb<S>], near: &NeighbourRule<S>, ids: &[u32]) -> Vec<Vec<u32>> {
    let boxes: Vec<_> = ids.iter().map(|&i| boxes[i as usize]).collect();
    let mut tree = BoxTree::new(&boxes);
    let mut seen = vec![false; boxes.len()];
    let mut all = Vec::new();
    for seed in 0..boxes.len() {
        if seen[seed] {
            continue;
        }
        seen[seed] = true;
        let mut members = vec![seed as u32];
        let mut next = 0;
        let mut found = Vec::new();
        while next < members.len() {
            let query = boxes[members[next] as usize];
            next += 1;
            tree.take_near(&query, near, &mut found);
            for i in found.drain(..) {
                // a box that is not near itself (negative gap) is still in the tree
                if !std::mem::replace(&mut seen[i as usize], true) {
                    members.push(i);
                }
            }
        }
        members.iter_mut().for_each(|i| *i = ids[*i as usize]);
        all.push(members);
    }
    all
}

/// Components, with those put together that have members in one of `bridges`.
fn connected(boxes: usize, components: Vec<Vec<u32>>, bridges: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let mut component_of = vec![u32::MAX; boxes];
    for (members, number) in components.iter().zip(0..) {
        members.iter().for_each(|&i| component_of[i as usize] = number);
    }
    // of each component, one that it is part of; itself, where it is part of no other
    let mut whole: Vec<u32> = (0..components.len() as u32).collect();
    let find = |whole: &mut [u32], mut part: u32| {
        while whole[part as usize] != part {
            // halves the way of the next that asks
            whole[part as usize] = whole[whole[part as usize] as usize];
            part = whole[part as usize];
        }
        part
    };
    for bridge in bridges {
        for ends in bridge.windows(2) {
            let [a, b] = [0, 1].map(|k| find(&mut whole, component_of[ends[k] as usize]));
            whole[a.max(b) as usize] = a.min(b);
        }
    }
    let mut all: Vec<Vec<u32>> = vec![Vec::new(); components.len()];
    for (part, number) in components.into_iter().zip(0..) {
        let whole = find(&mut whole, number) as usize;
        if all[whole].is_empty() { all[whole] = part } else { all[whole].extend(part) }
    }
    all.retain(|members| !members.is_empty());
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::{Random, on_threads};
    use glam::DVec3;

    fn random_boxes(n: usize, side: f64) -> Vec<Aabb<f64>> {
        let mut random = Random(7);
        let mut place = |_| {
            let min = random.point([1.0; 3]);
            Aabb { min, max: min + random.point([side; 3]) }
        };
        (0..n).map(&mut place).collect()
    }

    /// Quadratic labelling until nothing changes.
    fn oracle(boxes: &[Aabb<f64>], near: &NeighbourRule<f64>) -> Vec<Vec<u32>> {
        let mut label: Vec<usize> = (0..boxes.len()).collect();
        loop {
            let mut changed = false;
            for i in 0..boxes.len() {
                for j in 0..boxes.len() {
                    if label[j] < label[i] && near.holds(&boxes[i], &boxes[j]) {
                        label[i] = label[j];
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        let mut all = vec![Vec::new(); boxes.len()];
        for (i, &l) in label.iter().enumerate() {
            all[l].push(i as u32);
        }
        all.retain(|c| !c.is_empty());
        all
    }

    #[test]
    fn components_equal_a_quadratic_labelling() {
        for (n, side) in [(1, 0.1), (5, 0.5), (200, 0.1), (200, 0.2), (300, 0.05)] {
            let boxes = random_boxes(n, side);
            for gap in [-0.02, 0.0, 0.03] {
                for closed in [true, false] {
                    let near = NeighbourRule { gap, closed };
                    assert_eq!(components(&boxes, &near), oracle(&boxes, &near), "{n} {gap}");
                }
            }
        }
    }

    #[test]
    fn any_number_of_threads_finds_the_same() {
        let on = |threads, boxes: &[Aabb<f64>], near: &NeighbourRule<f64>| {
            on_threads(threads, || components(boxes, near))
        };
        // rows of touching cubes through all parts, and heaps within and across them
        let rows = (0..30_000u32).map(|i| {
            let min =
                DVec3::new(f64::from(i % 300), f64::from(i / 300 % 10), f64::from(i / 3000)) * 1.5;
            let long = if i % 7 == 0 { 1.6 } else { 1.0 };
            Aabb { min, max: min + DVec3::new(long, 1.0, 1.0) }
        });
        for boxes in [random_boxes(30_000, 0.02), random_boxes(20_000, 0.05), rows.collect()] {
            for gap in [-0.02, 0.0, 0.003] {
                let near = NeighbourRule { gap, closed: gap == 0.0 };
                let one = on(1, &boxes, &near);
                assert!(one.len() > 1 || gap > 0.0 || boxes.len() == 20_000, "{gap}");
                for threads in [2, 7] {
                    assert!(on(threads, &boxes, &near) == one, "{threads} threads, gap {gap}");
                }
            }
        }
    }

    #[test]
    fn touching_boxes_are_near_only_when_closed() {
        let unit = |x: f64| Aabb::<f64> {
            min: DVec3::new(x, 0.0, 0.0),
            max: DVec3::new(x + 1.0, 1.0, 1.0),
        };
        let boxes = [unit(0.0), unit(1.0), unit(3.0)];
        let count = |gap, closed| components(&boxes, &NeighbourRule { gap, closed }).len();
        assert_eq!((count(0.0, true), count(0.0, false), count(1.0, true)), (2, 3, 1));
    }

    #[test]
    fn many_copies_of_one_box_are_one_component_fast() {
        let boxes = vec![random_boxes(1, 1.0)[0]; 200_000];
        assert_eq!(components(&boxes, &NeighbourRule { gap: 0.0, closed: true }).len(), 1);
    }
}
