//! The cells that a ray pierces in a regular grid, in whole numbers: the oracle of the traversals,
//! here and in the tests of accel-core.
//!
//! Origin and direction are whole multiples of a power of two. The parameters at which planes are
//! met are fractions; times the product of the direction's components they are whole numbers too,
//! so that each comparison is exact, and each step an addition.

use glam::DVec3;

/// Units a cell: coordinates with 24 binary places are whole.
const UNITS: f64 = (1_u32 << 24) as f64;

/// Units to the farthest origin.
const FARTHEST: f64 = UNITS * (1_u32 << 14) as f64;

/// A ray in the coordinates of the grid: cells have side 1 and the grid begins at 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IntegerRay {
    origin: [i128; 3],
    direction: [i128; 3],
}

/// A cell on the way of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PiercedCell {
    pub cell: [i32; 3],
    /// The longest way on an axis that the ray makes within it, in cells; correct to a few ulps.
    pub length: f64,
}

impl IntegerRay {
    /// `None` where the numbers are not multiples of 2^-24, the origin is more than 2^14 cells away
    /// (the traversal there would be long), or the direction needs more than 26 bits.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let whole = |x: f64, limit: f64| {
            let units = x * UNITS;
            (units.fract() == 0.0 && units.abs() < limit).then_some(units as i128)
        };
        let [x, y, z] = origin.to_array();
        let origin = [whole(x, FARTHEST)?, whole(y, FARTHEST)?, whole(z, FARTHEST)?];
        // the scale of the direction does not matter: without common factors of two it is small
        let [x, y, z] = direction.to_array();
        let mut direction = [whole(x, 1e17)?, whole(y, 1e17)?, whole(z, 1e17)?];
        let zeros = direction.iter().filter(|d| **d != 0).map(|d| d.trailing_zeros()).min()?;
        direction.iter_mut().for_each(|d| *d >>= zeros);
        direction.iter().all(|d| d.abs() < 1 << 26).then_some(Self { origin, direction })
    }

    /// The cells of a grid of `n` cells an axis that the ray from parameter 0 on crosses by more
    /// than a point, in their order. A ray within a plane is in the cells above the plane.
    pub fn pierced(&self, n: i32) -> Vec<PiercedCell> {
        let unit = UNITS as i128;
        let product: i128 = self.direction.iter().filter(|d| **d != 0).product::<i128>().abs();
        let mut cell = [0_i128; 3];
        // parameters times `product`, in units
        let (mut next, mut step) = ([i128::MAX; 3], [0_i128; 3]);
        for k in 0..3 {
            let (o, d) = (self.origin[k], self.direction[k]);
            cell[k] = o.div_euclid(unit);
            if d == 0 {
                continue;
            }
            let above = o.rem_euclid(unit);
            if d < 0 && above == 0 {
                cell[k] -= 1;
            }
            let way = match (d > 0, above) {
                (true, _) => unit - above,
                (false, 0) => unit,
                (false, _) => above,
            };
            step[k] = product / d.abs();
            next[k] = way * step[k];
        }
        let fastest = self.direction.iter().map(|d| d.abs()).max().unwrap_or(0) as f64;
        let to_cells = fastest / (product as f64 * UNITS);
        let mut found = Vec::new();
        let mut last = 0_i128;
        loop {
            let ahead = |k: usize| match self.direction[k].signum() {
                1 => cell[k] < i128::from(n),
                -1 => cell[k] >= 0,
                _ => (0..i128::from(n)).contains(&cell[k]),
            };
            if !(0..3).all(ahead) {
                return found;
            }
            let first = next[0].min(next[1]).min(next[2]);
            if cell.iter().all(|c| (0..i128::from(n)).contains(c)) {
                let length = (first - last) as f64 * to_cells;
                found.push(PiercedCell { cell: cell.map(|c| c as i32), length });
            }
            last = first;
            for k in 0..3 {
                if next[k] == first {
                    cell[k] += self.direction[k].signum();
                    next[k] += unit * step[k];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn cells(origin: DVec3, direction: DVec3, n: i32) -> Vec<[i32; 3]> {
        let ray = IntegerRay::new(origin, direction).unwrap();
        ray.pierced(n).into_iter().map(|p| p.cell).collect()
    }

    #[test]
    fn ties_are_diagonal_steps_and_planes_are_left_at_once() {
        let along = dvec3(1.0, 1.0, 1.0);
        assert_eq!(cells(DVec3::ZERO, along, 3), [[0; 3], [1; 3], [2; 3]]);
        assert_eq!(cells(DVec3::splat(2.0), -along, 3), [[1; 3], [0; 3]]);
        let flat = dvec3(2.0, 1.0, 0.0);
        let found = cells(dvec3(-1.0, 0.5, 1.0), flat, 2);
        assert_eq!(found, [[0, 1, 1], [1, 1, 1]]);
        assert!(cells(dvec3(-1.0, 0.5, 2.0), flat, 2).is_empty());
        assert!(cells(dvec3(5.0, 0.5, 0.5), flat, 2).is_empty());
    }

    #[test]
    fn lengths_are_those_of_the_longest_axis() {
        let ray = IntegerRay::new(dvec3(0.25, 0.5, 0.5), dvec3(4.0, 1.0, 0.0)).unwrap();
        let lengths: Vec<f64> = ray.pierced(3).iter().map(|p| p.length).collect();
        assert_eq!(lengths, [0.75, 1.0, 0.25, 0.75]);
    }

    #[test]
    fn numbers_that_are_not_whole_are_refused() {
        assert!(IntegerRay::new(dvec3(0.1, 0.0, 0.0), DVec3::X).is_none());
        assert!(IntegerRay::new(DVec3::ZERO, DVec3::ZERO).is_none());
        assert!(IntegerRay::new(dvec3(1e10, 0.0, 0.0), DVec3::X).is_none());
    }
}
