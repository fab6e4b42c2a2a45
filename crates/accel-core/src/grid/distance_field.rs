//! Distances of the voxels of a grid to the nearest occupied one, exact, in three metrics.
//!
//! All three are separable: the distance along x first, then the best over y of what x gave and
//! the way along y, then z (T. Saito, J. Toriwaki, "New Algorithms for Euclidean Distance
//! Transformation of an n-Dimensional Digitized Picture", Pattern Recognition 27, 1994, for the
//! Euclidean one). Deviation: the search along an axis goes outwards and ends where the way alone
//! is longer than the best found, so one routine serves every metric.

/// How distances between voxels are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// |dx| + |dy| + |dz|.
    CityBlock,
    /// max(|dx|, |dy|, |dz|).
    Chessboard,
    /// sqrt(dx^2 + dy^2 + dz^2), rounded down.
    Euclidean,
}

/// The largest distance kept.
const CAP: u16 = 255;

impl Metric {
    /// The measure between voxels so far apart; the square for the Euclidean metric.
    pub fn of(self, delta: [i32; 3]) -> u32 {
        let d = delta.map(i32::unsigned_abs);
        match self {
            Self::CityBlock => d[0] + d[1] + d[2],
            Self::Chessboard => d[0].max(d[1]).max(d[2]),
            Self::Euclidean => d[0] * d[0] + d[1] * d[1] + d[2] * d[2],
        }
    }

    /// Measure of a way of `d` along one axis.
    #[inline(always)]
    fn along(self, d: u16) -> u16 {
        if self == Self::Euclidean { d.saturating_mul(d) } else { d }
    }

    /// Measure of a way that measures `a` on some axes and `b` on the others.
    #[inline(always)]
    fn combined(self, a: u16, b: u16) -> u16 {
        if self == Self::Chessboard { a.max(b) } else { a.saturating_add(b) }
    }

    /// The distance kept for a measure.
    fn kept(self, measure: u16) -> u8 {
        let distance = if self == Self::Euclidean { measure.isqrt() } else { measure };
        distance.min(CAP) as u8
    }
}

/// For every voxel (x fastest) its distance to the nearest occupied one, at most 255; 0 in
/// occupied ones. With an octant only voxels ahead count: bit k of it set means that ahead is
/// downwards on axis k.
pub fn distances(occupied: &[bool], n: [u32; 3], metric: Metric, octant: Option<usize>) -> Vec<u8> {
    let mut field: Vec<u16> =
        occupied.iter().map(|&o| if o { 0 } else { metric.along(CAP) }).collect();
    let n = n.map(|n| n as usize);
    let mut line = vec![0; n.iter().copied().max().unwrap_or(0)];
    let mut stride = 1;
    for (k, &length) in n.iter().enumerate() {
        let (up, down) = match octant {
            None => (true, true),
            Some(octant) => (octant >> k & 1 == 0, octant >> k & 1 == 1),
        };
        for first in (0..field.len()).filter(|i| i / stride % length == 0) {
            for (i, value) in line[..length].iter_mut().enumerate() {
                *value = field[first + i * stride];
            }
            for i in 0..length {
                let mut best = line[i];
                for d in 1..length.min(usize::from(CAP) + 1) {
                    let way = metric.along(d as u16);
                    if way >= best || (i + d >= length && i < d) {
                        break;
                    }
                    if up && i + d < length {
                        best = best.min(metric.combined(line[i + d], way));
                    }
                    if down && i >= d {
                        best = best.min(metric.combined(line[i - d], way));
                    }
                }
                field[first + i * stride] = best;
            }
        }
        stride *= length;
    }
    field.into_iter().map(|measure| metric.kept(measure)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_the_distances_found_by_search() {
        let n = [9u32, 7, 12];
        let cells = (n[0] * n[1] * n[2]) as usize;
        let at = |i: usize| [i % 9, i / 9 % 7, i / 63].map(|c| c as i32);
        for filled in [vec![0], vec![cells - 1, 100], vec![5, 300, 301, 520], vec![]] {
            let mut occupied = vec![false; cells];
            filled.iter().for_each(|&i: &usize| occupied[i] = true);
            for metric in [Metric::CityBlock, Metric::Chessboard, Metric::Euclidean] {
                for octant in (0..8).map(Some).chain([None]) {
                    let field = distances(&occupied, n, metric, octant);
                    for (i, &found) in field.iter().enumerate() {
                        let delta = |&j: &usize| {
                            let (a, b) = (at(i), at(j));
                            [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
                        };
                        let is_ahead = |d: &[i32; 3]| {
                            octant.is_none_or(|o| {
                                (0..3).all(|k| if o >> k & 1 == 0 { d[k] >= 0 } else { d[k] <= 0 })
                            })
                        };
                        let nearest = filled.iter().map(delta).filter(is_ahead);
                        let nearest = nearest.map(|d| metric.of(d)).min();
                        let expected = nearest.map_or(255, |m| match metric {
                            Metric::Euclidean => m.isqrt(),
                            _ => m,
                        });
                        assert_eq!(u32::from(found), expected, "{metric:?} {octant:?} {i}");
                    }
                }
            }
        }
    }

    #[test]
    fn long_grids_are_capped() {
        let mut occupied = vec![false; 1000];
        occupied[0] = true;
        for metric in [Metric::CityBlock, Metric::Chessboard, Metric::Euclidean] {
            let field = distances(&occupied, [1000, 1, 1], metric, None);
            assert_eq!((field[200], field[254], field[999]), (200, 254, 255));
        }
    }
}
