//! The house: no cycle of modules in any crate, no arrow upwards between crates.
//!
//! Arrows are read off the sources: `use` paths and paths within code. A name that a module gives
//! on (`pub use`) leads to the module that has it.

mod imports;
mod results;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use imports::Imports;

use crate::common::files_below;

/// The crates, each above those before it.
const FLOORS: [&str; 10] = [
    "exact_geometry",
    "accel_core",
    "plugins",
    "scene_loading",
    "renderer",
    "statistics",
    "presentation",
    "measurement",
    "studies",
    "rtbench",
];

/// Crates with cycles that are still to be broken, and how many modules are in them at most.
/// Nothing may be added.
const KNOWN: [(&str, usize); 0] = [];

/// The modules of a crate by their paths (`rounds::scope`; the root is empty) and what each names.
type Crate = BTreeMap<String, Imports>;

/// Arrows between modules.
type Arrows = BTreeMap<String, BTreeSet<String>>;

/// The modules below a folder of sources.
fn crate_of(folder: &Path) -> Crate {
    let mut modules = Crate::new();
    for path in files_below(folder) {
        if path.extension().is_none_or(|e| e != "rs") {
            continue;
        }
        let within = path.strip_prefix(folder).unwrap().with_extension("");
        let mut names: Vec<_> =
            within.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
        if matches!(names.last().unwrap().as_str(), "mod" | "lib" | "main") {
            names.pop();
        }
        let text = fs::read_to_string(&path).unwrap();
        modules.insert(names.join("::"), imports::read(&text));
    }
    modules
}

/// A path as seen from a module, from the root of its crate on; none where it leads elsewhere.
fn absolute(modules: &Crate, own: &str, path: &[String]) -> Option<Vec<String>> {
    let mut from: Vec<String> =
        own.split("::").filter(|s| !s.is_empty()).map(str::to_owned).collect();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" | "$crate" => {
            from.clear();
            rest = &path[1..];
        }
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|s| s == "super") {
                from.pop()?;
                rest = &rest[1..];
            }
        }
        first => {
            // a module below, or one that a `use` makes known here by its name
            let below = from.iter().map(String::as_str).chain([first]).collect::<Vec<_>>();
            if !modules.contains_key(&below.join("::")) {
                let known = modules.get(own)?.known_as.iter();
                let mut named = known.filter(|(name, to)| name == first && to != path);
                let (_, to) = named.next().filter(|(_, to)| to.first().unwrap() != first)?;
                let mut to = absolute(modules, own, to)?;
                to.extend(path[1..].iter().cloned());
                return Some(to);
            }
        }
    }
    from.extend(rest.iter().cloned());
    Some(from)
}

/// The module that a path from the root leads to, through names that are given on.
fn target(modules: &Crate, path: &[String]) -> Option<String> {
    let mut path = path.to_vec();
    // names are given on a few times at most
    for _ in 0..8 {
        let length =
            (0..=path.len()).rev().find(|&n| modules.contains_key(&path[..n].join("::")))?;
        let module = path[..length].join("::");
        let Some(item) = path.get(length) else { return Some(module) };
        let given = modules[&module].given_on.iter().find(|(name, _)| name == item);
        let further = given.and_then(|(_, to)| absolute(modules, &module, to));
        match further {
            Some(mut to) => {
                to.extend(path[length + 1..].iter().cloned());
                path = to;
            }
            None => return Some(module),
        }
    }
    None
}

/// Dependencies between modules.
fn arrows(modules: &Crate) -> Arrows {
    let mut arrows = Arrows::new();
    for (own, imports) in modules {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let words: BTreeSet<&str> = imports.code.split(|c| !is_word(c)).collect();
        // what is given on and not used is a name, no arrow
        let given = imports.given_on.iter().filter(|(name, _)| words.contains(name.as_str()));
        for path in imports.used.iter().chain(given.map(|(_, path)| path)) {
            let to = absolute(modules, own, path).and_then(|path| target(modules, &path));
            // the root names the modules; what it has itself is for the program's ends
            if let Some(to) = to.filter(|to| to != own && !to.is_empty() && !own.is_empty()) {
                arrows.entry(own.clone()).or_default().insert(to);
            }
        }
    }
    arrows
}

/// Everything that can be reached from a module.
fn reached(arrows: &Arrows, from: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![from.to_owned()];
    while let Some(next) = open.pop() {
        for to in arrows.get(&next).into_iter().flatten() {
            if found.insert(to.clone()) {
                open.push(to.clone());
            }
        }
    }
    found
}

/// The sets of modules each of which can be reached from all others of its set.
fn cycles(arrows: &Arrows) -> Vec<BTreeSet<String>> {
    let reached: BTreeMap<&String, BTreeSet<String>> =
        arrows.keys().map(|module| (module, reached(arrows, module))).collect();
    let mut cycles: Vec<BTreeSet<String>> = Vec::new();
    for (module, found) in &reached {
        if found.contains(*module) && !cycles.iter().any(|cycle| cycle.contains(*module)) {
            let back = |other: &&String| reached.get(other).is_some_and(|r| r.contains(*module));
            cycles.push(found.iter().filter(back).cloned().collect());
        }
    }
    cycles
}

/// Paths that lead to a crate above the own one.
fn upward(floor: usize, modules: &Crate) -> Vec<String> {
    let mut found = Vec::new();
    for (own, imports) in modules {
        let given = imports.given_on.iter().map(|(_, path)| path);
        for path in imports.used.iter().chain(given) {
            let to = FLOORS.iter().position(|name| path.first().is_some_and(|first| first == name));
            let is_own_module = absolute(modules, own, path).is_some();
            if to.is_some_and(|to| to > floor) && !is_own_module {
                found.push(format!("{}::{own} -> {}", FLOORS[floor], path.join("::")));
            }
        }
    }
    found
}

fn sources(name: &str) -> std::path::PathBuf {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    crates.join(name.replace('_', "-")).join("src")
}

#[test]
fn every_crate_has_its_floor() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut found: Vec<String> = fs::read_dir(crates)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_str().unwrap().replace('-', "_"))
        .collect();
    let mut floors = FLOORS.map(str::to_owned);
    floors.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, floors);
}

#[test]
fn modules_have_no_new_cycles() {
    for name in FLOORS {
        let cycles = cycles(&arrows(&crate_of(&sources(name))));
        let modules: usize = cycles.iter().map(BTreeSet::len).sum();
        let known = KNOWN.iter().find(|(known, _)| *known == name).map(|(_, most)| *most);
        assert!(
            modules <= known.unwrap_or(0),
            "{name}: {modules} modules use one another in circles: {cycles:#?}"
        );
        assert!(known.is_none() || modules > 0, "{name} has no cycle any more: take it off KNOWN");
    }
}

#[test]
fn arrows_between_crates_point_down() {
    for (floor, name) in FLOORS.iter().enumerate() {
        let found = upward(floor, &crate_of(&sources(name)));
        assert!(found.is_empty(), "{found:#?}");
    }
}

/// A crate of texts, by module.
fn planted(files: &[(&str, &str)]) -> Crate {
    files.iter().map(|(module, text)| ((*module).to_owned(), imports::read(text))).collect()
}

#[test]
fn a_planted_cycle_is_named() {
    let sound = [
        ("", "pub mod a; pub mod b; pub mod c;"),
        ("a", "pub use inner::Given; use crate::b::B;"),
        ("a::inner", "use super::super::c; pub struct Given;"),
        ("b", "use crate::c::{C, D}; // use crate::a::A;"),
        ("c", "pub struct C;"),
    ];
    assert!(cycles(&arrows(&planted(&sound))).is_empty());
    for (module, fault) in [
        ("c", "use crate::a::A;"),
        ("c", "fn f() { crate::a::f() }"),
        ("c", "pub use super::a::A; fn f(_: A) {}"),
        // by the name that a module above has here, alone or under another
        ("c", "use crate as all; fn f() { all::a::f() }"),
    ] {
        let mut files = sound;
        files.iter_mut().filter(|f| f.0 == module).for_each(|f| f.1 = fault);
        let found = cycles(&arrows(&planted(&files)));
        assert_eq!(found, [["a", "b", "c"].map(str::to_owned).into()], "{fault}");
    }
    // a name that is given on leads to where it is, and no further
    let mut files = sound;
    files[4].1 = "use crate::a::Given;";
    let found = cycles(&arrows(&planted(&files)));
    assert_eq!(found, [["a::inner", "c"].map(str::to_owned).into()]);
    // what is reached through a module that a `use` names
    for fault in
        ["use crate::a; fn f() { a::inner::f() }", "use super::a as x; fn f(_: x::inner::T) {}"]
    {
        files[4].1 = fault;
        let found = cycles(&arrows(&planted(&files)));
        let circle = ["a::inner", "c"].map(str::to_owned);
        assert!(circle.iter().all(|module| found[0].contains(module)), "{fault}: {found:?}");
    }
}

#[test]
fn a_planted_arrow_upwards_is_named() {
    let files = [("", "mod x;"), ("x", "use measurement::plan::Plan; use studies::run;")];
    let floor = FLOORS.iter().position(|name| *name == "measurement").unwrap();
    assert_eq!(upward(floor, &planted(&files)), ["measurement::x -> studies::run"]);
    assert!(upward(FLOORS.len() - 1, &planted(&files)).is_empty());
}
