//! Connected components of boxes: two boxes are connected when they are near each other.
//!
//! Idea: F. Cazals, G. Drettakis, C. Puech, "Filtering, Clustering and Hierarchy Construction: a
//! New Solution for Ray-Tracing Complex Scenes", Eurographics 1995, who cluster objects of like
//! size by their distance. Deviation: a component is flooded box by box, and flooded boxes leave
//! the search tree at once, so that 10,000 copies of one box cost one query, not 10,000 squared.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::tree::clustering::box_tree::{BoxTree, Nearness};

/// The components, each ascending, in the order of their lowest members.
pub fn components<S: Scalar>(boxes: &[Aabb<S>], near: &Nearness<S>) -> Vec<Vec<u32>> {
    let mut tree = BoxTree::new(boxes);
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
        members.sort_unstable();
        all.push(members);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn random_boxes(n: usize, side: f64) -> Vec<Aabb<f64>> {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        (0..n)
            .map(|_| {
                let min = DVec3::new(random(), random(), random());
                Aabb { min, max: min + DVec3::new(random(), random(), random()) * side }
            })
            .collect()
    }

    /// Quadratic labelling until nothing changes.
    fn oracle(boxes: &[Aabb<f64>], near: &Nearness<f64>) -> Vec<Vec<u32>> {
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
                    let near = Nearness { gap, closed };
                    assert_eq!(components(&boxes, &near), oracle(&boxes, &near), "{n} {gap}");
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
        let count = |gap, closed| components(&boxes, &Nearness { gap, closed }).len();
        assert_eq!((count(0.0, true), count(0.0, false), count(1.0, true)), (2, 3, 1));
    }

    #[test]
    fn many_copies_of_one_box_are_one_component_fast() {
        let boxes = vec![random_boxes(1, 1.0)[0]; 200_000];
        assert_eq!(components(&boxes, &Nearness { gap: 0.0, closed: true }).len(), 1);
    }
}
