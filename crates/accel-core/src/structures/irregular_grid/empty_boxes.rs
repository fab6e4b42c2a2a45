//! Empty parts of a division joined to boxes: the largest cubes of two, four, eight... parts a side
//! that are empty, at places that are multiples of their size.

use crate::structures::irregular_grid::lattice::coords_of as at;

/// Marks the empty cubes of a division.
#[derive(Debug)]
pub(super) struct EmptyBoxes {
    parts: [u32; 3],
    /// Marks of parts, of cubes of two parts a side, of four...; x fastest.
    levels: Vec<Vec<bool>>,
}

impl EmptyBoxes {
    /// Marks for a division into this many parts per axis.
    pub(super) fn new(parts: [u32; 3], is_empty: impl Fn(usize) -> bool) -> Self {
        let count = |n: [u32; 3]| n.iter().map(|&n| n as usize).product::<usize>();
        let mut levels = vec![(0..count(parts)).map(is_empty).collect::<Vec<bool>>()];
        let mut fine = parts;
        while fine.iter().any(|&n| n > 1)
            && let Some(below) = levels.last()
            && below.contains(&true)
        {
            let coarse = fine.map(|n| n.div_ceil(2));
            let mut level = vec![true; count(coarse)];
            for (i, _) in below.iter().enumerate().filter(|(_, empty)| !**empty) {
                level[index(at(i, fine).map(|x| x / 2), coarse)] = false;
            }
            levels.push(level);
            fine = coarse;
        }
        Self { parts, levels }
    }

    /// Gives the parts of every box the entry of its first part.
    pub(super) fn share(&self, entries: &mut [u32]) {
        if self.levels.len() < 2 {
            return;
        }
        for part in (0..entries.len()).filter(|&part| self.levels[0][part]) {
            entries[part] = entries[self.around(part).0];
        }
    }

    /// The first part of the largest box with an empty part, and the last one's coordinates.
    pub(super) fn around(&self, part: usize) -> (usize, [u32; 3]) {
        let p = at(part, self.parts);
        let is_empty = |level: &usize| {
            let n = self.parts.map(|n| n.div_ceil(1 << level));
            self.levels.get(*level).is_some_and(|l| l[index(p.map(|x| x >> level), n)])
        };
        let level = (1..self.levels.len()).take_while(is_empty).last().unwrap_or(0);
        let first = p.map(|x| x >> level << level);
        let last = std::array::from_fn(|k| (first[k] + (1 << level)).min(self.parts[k]) - 1);
        (index(first, self.parts), last)
    }
}

fn index(p: [u32; 3], n: [u32; 3]) -> usize {
    let [p, n] = [p, n].map(|v| v.map(|x| x as usize));
    p[0] + n[0] * (p[1] + n[1] * p[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_parts_are_joined_and_no_full_one_is() {
        // 5 x 4 x 3 with one full part at (4, 1, 0)
        let n = [5, 4, 3];
        let full = index([4, 1, 0], n);
        let boxes = EmptyBoxes::new(n, |part| part != full);
        assert_eq!(boxes.around(0), (0, [3, 3, 2]));
        assert_eq!(boxes.around(index([3, 3, 2], n)), (0, [3, 3, 2]));
        // beside the full one nothing larger than a part, above it what is left of a cube
        assert_eq!(boxes.around(index([4, 0, 0], n)), (index([4, 0, 0], n), [4, 0, 0]));
        assert_eq!(boxes.around(index([4, 3, 1], n)), (index([4, 2, 0], n), [4, 3, 1]));
        for part in (0..60).filter(|part| *part != full) {
            let (first, last) = boxes.around(part);
            let (f, p) = (at(first, n), at(part, n));
            assert!((0..3).all(|k| f[k] <= p[k] && p[k] <= last[k] && last[k] < n[k]));
            let inside = (0..3).all(|k| f[k] <= at(full, n)[k] && at(full, n)[k] <= last[k]);
            assert!(!inside, "{part}");
            assert_eq!(boxes.around(first), (first, last), "all parts of a box agree");
        }
        assert!(EmptyBoxes::new([3, 1, 1], |_| true).around(2) == (0, [2, 0, 0]));
        assert_eq!(EmptyBoxes::new([2, 1, 1], |part| part == 1).around(1), (1, [1, 0, 0]));
    }
}
