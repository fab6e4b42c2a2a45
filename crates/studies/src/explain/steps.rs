//! From one row to another in steps, each of which changes one thing.
//!
//! Rows stand at the corners of a cube whose edges are what the two differ in: adapter, kernel,
//! structure, query. A way along edges that are all measured gives factors whose product is the
//! whole. Where there are several, a factor is the geometric mean over all of them: what a thing
//! brings, whichever of the others were changed before (L. S. Shapley, "A Value for n-Person
//! Games", 1953, of logarithms).

use std::collections::BTreeMap;

use crate::explain::craft::Variant;

/// Properties in which two rows may differ, in the order of tables and of [`Variant::values`].
pub const AXES: [&str; 4] = ["adapter", "kernel", "structure", "query"];

/// A factor of the whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// The changed properties, from old to new.
    pub name: String,
    /// Those of [`AXES`] that change; several if no row changes only one of them.
    pub axes: Vec<usize>,
    /// The factor: the product of the times of rows, by index, raised to these powers.
    pub powers: Vec<(usize, f64)>,
}

/// The steps from the row at `from` to that at `to`; empty where one of them is none. `rows` holds
/// none for those that have no time.
pub fn steps(rows: &[Option<Variant>], from: usize, to: usize) -> Vec<Step> {
    let at = |row: usize| rows.get(row).and_then(Option::as_ref);
    let (Some(first), Some(last)) = (at(from), at(to)) else { return Vec::new() };
    let [first, last] = [first, last].map(Variant::values);
    let ends = || first.iter().zip(&last).enumerate();
    let axes: Vec<usize> = ends().filter(|(_, (a, b))| a != b).map(|(axis, _)| axis).collect();
    let whole = (1usize << axes.len()) - 1;
    // the row at each corner: a bit for each axis, set where it is changed already
    let corner = |corner: usize| {
        let is_changed = |axis: usize| {
            axes.iter().position(|a| *a == axis).is_some_and(|bit| corner & (1 << bit) != 0)
        };
        let wanted = ends().map(|(axis, (a, b))| *if is_changed(axis) { b } else { a });
        let is_wanted = |of: &Variant| wanted.clone().eq(of.values());
        match corner {
            0 => Some(from),
            _ if corner == whole => Some(to),
            _ => rows.iter().position(|row| row.as_ref().is_some_and(is_wanted)),
        }
    };
    let corners: Vec<Option<usize>> = (0..=whole).map(corner).collect();
    let mut ways = Vec::new();
    follow(&corners, vec![0], &mut ways);
    let longest = ways.iter().map(Vec::len).max().unwrap_or(0);
    ways.retain(|way| way.len() == longest);
    if longest <= axes.len() {
        // some things are changed together: the mean over ways would mix them with others
        ways.truncate(1);
    }
    let share = 1.0 / ways.len().max(1) as f64;
    // by the first axis that changes: no two steps share it
    let mut steps: BTreeMap<u32, Step> = BTreeMap::new();
    for way in &ways {
        for pair in way.windows(2) {
            let &[before, after] = pair else { continue };
            let changed = before ^ after;
            let step = steps.entry(changed.trailing_zeros()).or_insert_with(|| {
                let bits = axes.iter().enumerate().filter(|(bit, _)| changed & (1 << bit) != 0);
                let axes: Vec<usize> = bits.map(|(_, axis)| *axis).collect();
                let named = ends().zip(AXES).filter(|((axis, _), _)| axes.contains(axis));
                let names = named.map(|((_, (a, b)), name)| format!("{name}: {a} to {b}"));
                let name = names.collect::<Vec<_>>().join("; ");
                Step { name, axes, powers: Vec::new() }
            });
            for (end, power) in [(after, share), (before, -share)] {
                if let Some(row) = corners.get(end).copied().flatten() {
                    step.powers.push((row, power));
                }
            }
        }
    }
    steps.into_values().collect()
}

/// All ways from the last corner of `way` to the opposite one, over corners that have a row.
fn follow(corners: &[Option<usize>], way: Vec<usize>, ways: &mut Vec<Vec<usize>>) {
    let Some(&here) = way.last() else { return };
    if here + 1 == corners.len() {
        ways.push(way);
        return;
    }
    let onward = |(next, row): (usize, &Option<usize>)| {
        let is_beyond = next != here && next & here == here;
        (is_beyond && row.is_some()).then_some(next)
    };
    for next in corners.iter().enumerate().filter_map(onward) {
        follow(corners, way.iter().copied().chain([next]).collect(), ways);
    }
}

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;
    use measurement::plan::rows::Row;

    use super::*;

    /// The steps between the first two of these rows, in words.
    fn factors_of(rows: &[&str]) -> Vec<String> {
        let of = |text: &&str| Some(Variant::of(&Row::parse(REGISTRY, text).unwrap()));
        let rows: Vec<_> = rows.iter().map(of).collect();
        let steps = steps(&rows, 0, 1);
        // what is divided by is multiplied by elsewhere, but for the ends
        let mut sums = vec![0.0; rows.len()];
        steps.iter().flat_map(|s| &s.powers).for_each(|(row, power)| sums[*row] += power);
        if !steps.is_empty() {
            assert_eq!((sums[0], sums[1]), (-1.0, 1.0));
            assert!(sums[2..].iter().all(|sum| sum.abs() < 1e-12), "{sums:?}");
        }
        let step = |step: &Step| {
            let names: Vec<&str> = step.axes.iter().map(|axis| AXES[*axis]).collect();
            format!("{} {:?}", names.join("+"), step.powers)
        };
        steps.iter().map(step).collect()
    }

    const DIRECT: &str = "obvhs-cwbvh";
    const ROBUST: &str = "obvhs-cwbvh:adapter=robust";
    const SCALAR: &str = "obvhs-cwbvh:adapter=robust:kernel=scalar";

    #[test]
    fn rows_one_step_apart_have_one_path() {
        assert_eq!(
            factors_of(&[DIRECT, "wide-bvh:query=batch", SCALAR, ROBUST, "wide-bvh"]),
            [
                "adapter [(2, 1.0), (0, -1.0)]",
                "kernel [(3, 1.0), (2, -1.0)]",
                "structure [(4, 1.0), (3, -1.0)]",
                "query [(1, 1.0), (4, -1.0)]",
            ]
        );
    }

    #[test]
    fn factors_of_two_paths_are_averaged() {
        assert_eq!(
            factors_of(&[SCALAR, "uniform-grid", ROBUST, "uniform-grid:kernel=scalar",]),
            [
                "kernel [(2, 0.5), (0, -0.5), (1, 0.5), (3, -0.5)]",
                "structure [(1, 0.5), (2, -0.5), (3, 0.5), (0, -0.5)]",
            ]
        );
        // a way over a row that has no time is none
        assert_eq!(
            factors_of(&[SCALAR, "uniform-grid", ROBUST]),
            ["kernel [(2, 1.0), (0, -1.0)]", "structure [(1, 1.0), (2, -1.0)]"]
        );
    }

    #[test]
    fn inseparable_factors_are_reported_together() {
        let whole: [(&[&str], _); 3] = [
            (&["recursive-grid", "wide-bvh"], "kernel+structure"),
            (&[DIRECT, "recursive-grid", ROBUST], "adapter+structure"),
            (&["octree", "kd-tree"], "structure"),
        ];
        for (rows, factors) in whole {
            assert_eq!(factors_of(rows), [format!("{factors} [(1, 1.0), (0, -1.0)]")]);
        }
    }

    #[test]
    fn a_row_without_a_time_is_not_explained() {
        let octree = Variant::of(&Row::parse(REGISTRY, "octree").unwrap());
        assert!(steps(&[Some(octree.clone()), None], 0, 1).is_empty());
        assert!(steps(&[Some(octree)], 0, 1).is_empty());
    }
}
