//! The rules of thumb for the number of voxels, as rows beside a sweep.

use accel_core::grid::resolution::ResolutionRule;
use accel_core::params::{ParamKind, ParamSpec};
use accel_core::structures::Entry;

use measurement::plan::rows::Assignments;

/// The rules that are formulas for N voxels: they are measured at one voxel per primitive. The
/// others know their density, or have the structure's default.
const ONE_PER_PRIMITIVE: [&str; 3] = ["regular", "woo", "heterogeneous"];

/// Returns whether the parameter decides the number of voxels of a grid, so that rules compete with
/// it.
pub fn apply_to(entry: &Entry, parameter: &ParamSpec) -> bool {
    let names_rules = |p: &ParamSpec| matches!(p.kind, ParamKind::Resolution);
    names_rules(parameter)
        || parameter.name == "density" && entry.info.params.iter().any(names_rules)
}

/// Each rule with its settings, over settings of other parameters. The rule `density` is the
/// structure's default and stands there as such.
pub fn settings<'t>(others: &[(&'t str, &'t str)]) -> Vec<(&'static str, Assignments<'t>)> {
    let others = others.iter().copied().filter(|(n, _)| !["resolution", "density"].contains(n));
    let of = |rule: &'static str| {
        let density = ONE_PER_PRIMITIVE.contains(&rule).then_some(("density", "1"));
        (rule, others.clone().chain([("resolution", rule)]).chain(density).collect())
    };
    ResolutionRule::NAMES.iter().copied().filter(|r| *r != "density").map(of).collect()
}

#[cfg(test)]
mod tests {
    use accel_core::structures::{REGISTRY, find};

    use super::*;

    #[test]
    fn rules_compete_where_the_number_of_voxels_is_swept() {
        for entry in REGISTRY {
            let grids = [
                "uniform-grid",
                "compact-grid",
                "two-level-grid",
                "hashed-grid",
                "bricked-grid",
                "proximity-clouds",
            ];
            let is_grid = grids.contains(&entry.info.name);
            for p in entry.info.params {
                let expected = is_grid && ["density", "resolution"].contains(&p.name);
                assert_eq!(apply_to(entry, p), expected, "{}.{}", entry.info.name, p.name);
            }
        }
    }

    #[test]
    fn every_rule_can_be_built() {
        let entry = find("uniform-grid").unwrap();
        let rules = settings(&[("density", "7"), ("mailbox", "hash")]);
        assert_eq!(rules.len(), ResolutionRule::NAMES.len() - 1);
        for (rule, settings) in rules {
            let params = entry.params(settings).unwrap();
            assert_eq!((params.text("resolution"), params.text("mailbox")), (rule, "hash"));
            assert_ne!(params.text("density"), "7");
        }
    }
}
