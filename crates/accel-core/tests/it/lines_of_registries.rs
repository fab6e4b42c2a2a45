//! Mistakes in a line of a registry.

use accel_core::params::{ParamKind, ParamSpec};
use accel_core::registry::{RegistryItem as _, check};
use accel_core::structure::StructureInfo;
use accel_core::structures::{Entry, REGISTRY, Traceable};

const LEAF: ParamSpec = ParamSpec {
    name: "leaf",
    summary: "",
    default: "4",
    kind: ParamKind::Integer { min: 1, max: 8 },
};
const PARAMS: &[ParamSpec] = &[LEAF];
const LEAF_0: &[ParamSpec] = &[ParamSpec { default: "0", ..LEAF }];
const TWICE: &[ParamSpec] = &[LEAF, LEAF];
const OF_ALL: &[ParamSpec] = &[ParamSpec { name: Traceable::COMMON[0].name, ..LEAF }];

/// Complaint about a registry with this line, whose builders are never called.
fn said_of(info: StructureInfo) -> String {
    let info: &'static StructureInfo = Box::leak(Box::new(info));
    let line = Entry::new(info, |_| unreachable!(), |_| unreachable!());
    let registry: Vec<_> = REGISTRY.iter().copied().chain([line]).collect();
    check(&registry, &["light-buffer"]).err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn planted_mistakes_are_named() {
    let own = |params, variants| StructureInfo {
        params,
        variants,
        ..StructureInfo::new("my-tree", "a tree")
    };
    assert_eq!(said_of(own(PARAMS, &["", "leaf=8"])), "");
    for (info, expected) in [
        (StructureInfo::new("", ""), "cannot be the name"),
        (StructureInfo::new("all", ""), "cannot be the name"),
        (StructureInfo::new("my tree", ""), "'my tree' cannot be the name"),
        (StructureInfo::new("kd-tree", ""), "two structures have the name 'kd-tree'"),
        (StructureInfo::new("light-buffer", ""), "two structures have the name"),
        (own(TWICE, &[""]), "my-tree has two parameters of the name 'leaf'"),
        (own(OF_ALL, &[""]), "my-tree has two parameters of the name"),
        (own(LEAF_0, &[""]), "my-tree.leaf = '0': expected a whole number from 1 to 8"),
        (own(PARAMS, &["leaf=9"]), "my-tree.leaf = '9'"),
        (own(PARAMS, &["depth=9"]), "my-tree has no parameter 'depth'; it has leaf"),
        (own(PARAMS, &["leaf 9"]), "'leaf 9' is not a variant"),
    ] {
        let said = said_of(info);
        assert!(said.contains(expected), "{said}: expected {expected}");
    }
}
