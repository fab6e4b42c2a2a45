//! `rtbench show`: pictures of structures, and one ray's way.

use accel_core::query::cells::NoCells;
use accel_core::structures::REGISTRY;

use accel_core::structures::Entry;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

use crate::adoption::documents::text_of;
use crate::common::{Ended, Folder, run_with};

/// Over the real registry, not the one of other tests.
fn run(arguments: &str) -> Ended {
    let all: &[Entry] = REGISTRY;
    run_with(all, &InstalledScenes, &SystemClock::default(), arguments)
}

/// The texts of an SVG file, which must be well-formed.
fn texts(path: &str) -> Vec<String> {
    let svg = std::fs::read_to_string(path).unwrap();
    let tree = roxmltree::Document::parse(&svg).expect("well-formed XML");
    let texts = tree.descendants().filter(|n| n.has_tag_name("text"));
    texts.map(|n| n.text().unwrap_or_default().to_owned()).collect()
}

#[test]
fn every_structure_of_the_registry_is_drawn() {
    let folder = Folder::new();
    for entry in REGISTRY {
        let name = entry.info.name;
        let path = format!("{}/{name}.svg", folder.path());
        for options in ["", "--project", "--depth 1", "--ray 200,200", "--slice x=0.3"] {
            let ended = run(&format!("show teapot:2 -s {name} {options} -o {path} --overwrite"));
            let wrote = format!("wrote {path}: cells of {name} over teapot:2\n");
            assert_eq!((ended.code, &ended.err), (0, &wrote), "{name} {options}");
            let texts = texts(&path);
            assert!(texts.iter().any(|t| t == name), "{name} {options}: {texts:?}");
            assert!(texts.iter().any(|t| t.contains("references to primitives in a cell")));
        }
    }
}

/// The pictures that `scripts/pictures.sh` draws with `show`: their names, and the arguments.
fn pictures_of_the_docs() -> Vec<(String, String)> {
    let script = text_of("scripts/pictures.sh");
    let lines = script.lines().filter_map(|line| line.strip_prefix("show ")?.split_once(' '));
    lines.map(|(name, arguments)| (name.to_owned(), arguments.to_owned())).collect()
}

#[test]
fn pictures_of_the_docs_are_drawn_by_this_program() {
    let (folder, pictures) = (Folder::new(), pictures_of_the_docs());
    assert!(pictures.len() >= 8, "{pictures:?}");
    let draw = |name: &str, arguments: &str| {
        let ended = run(&format!("show {arguments} -o {}/{name} --overwrite", folder.path()));
        assert_eq!(ended.code, 0, "{name}: {}", ended.err);
        folder.text(name)
    };
    for (name, arguments) in &pictures {
        let shown = text_of(&format!("docs/pictures/{name}"));
        assert!(draw(name, arguments) == shown, "{name} is stale: scripts/pictures.sh draws it");
    }
    // planted: another scene
    let (name, arguments) = &pictures[0];
    let other = draw(name, &arguments.replace("teapot:5", "teapot:4"));
    assert!(other != text_of(&format!("docs/pictures/{name}")));
}

#[test]
fn several_structures_have_one_scale_that_is_named() {
    let folder = Folder::new();
    let of = |structures: &str| {
        let path = format!("{}/one.svg", folder.path());
        let ended = run(&format!("show teapot:3 -s {structures} -o {path} --overwrite"));
        assert_eq!(ended.code, 0, "{}", ended.err);
        texts(&path)
    };
    // the longest list of brute force is in the legend of both, and in none of the other alone
    let both = of("uniform-grid,brute-force");
    assert!(both.iter().any(|t| t == "513-1024"), "{both:?}");
    assert!(both.iter().any(|t| t == "1 cell, 0 empty, 561 references"), "{both:?}");
    assert!(!of("uniform-grid").iter().any(|t| t == "513-1024"));
}

#[test]
fn a_ray_is_listed_step_by_step_as_it_is_counted() {
    let ended = run("show teapot:3 -s uniform-grid,obvhs-bvh2,brute-force --ray 230,235");
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    for (name, inner) in
        [("uniform-grid", "inner 0"), ("obvhs-bvh2", "inner "), ("brute-force", "inner 0")]
    {
        let at = ended.out.find(&format!("teapot:3 through {name}")).expect(name);
        let table = &ended.out[at..];
        let summary = table.lines().find(|line| line.contains(" steps (")).unwrap();
        assert!(summary.contains(inner) && summary.contains("hits primitive"), "{summary}");
        let steps: usize = summary.split(' ').next().unwrap().parse().unwrap();
        let listed = table.lines().skip(2).take_while(|line| !line.contains(" steps ("));
        assert_eq!(
            listed.filter(|l| l.trim_start().starts_with(|c: char| c.is_ascii_digit())).count(),
            steps,
            "{name}"
        );
    }
    // all agree
    let hits: Vec<&str> =
        ended.out.lines().filter_map(|line| line.split("hits primitive ").nth(1)).collect();
    assert!(hits.len() == 3 && hits.iter().all(|hit| *hit == hits[0]), "{hits:?}");
}

#[test]
fn requests_that_cannot_be_drawn_are_errors() {
    let folder = Folder::new();
    let path = folder.path();
    for (command, said) in [
        ("show teapot:2 -s uniform-grid".to_owned(), "--output"),
        (format!("show teapot:2 -o {path}/a.svg"), "--structure"),
        (format!("show teapot:2 -s uniform-grid -o {path}/a.jpg"), ".svg"),
        (format!("show teapot:2 -s unifrom-grid -o {path}/a.svg"), "did you mean 'uniform-grid'?"),
        (format!("show teapot:2 -s light-buffer -o {path}/a.svg"), "not space"),
        (format!("show teapot:2 -s uniform-grid --slice w -o {path}/a.svg"), "expected x, y or z"),
        (format!("show teapot:2 -s octree --window 0,0,0:1,0,1 -o {path}/a.svg"), "flat"),
        (
            format!("show teapot:2 -s octree --window 0,0,0:1,1,1 --slice x=2 -o {path}/a.svg"),
            "a box that the plane of --slice cuts",
        ),
        (
            format!("show teapot:2 -s uniform-grid --slice x --project -o {path}/a.svg"),
            "cannot be used",
        ),
        (format!("show teapot:2 -s uniform-grid --ray 512,0 -o {path}/a.svg"), "512 x 512"),
        (format!("show spd -s uniform-grid -o {path}/a.svg"), "one scene"),
    ] {
        let ended = run(&command);
        assert_eq!(ended.code, 2, "{command}: {}", ended.err);
        assert!(ended.err.contains(said), "{command}: {}", ended.err);
    }
    assert!(!std::path::Path::new(&format!("{path}/a.svg")).exists());
    // a structure of another program may show nothing
    let error = rtbench::error::Error::NoCells { row: "mine x=1".into(), source: NoCells::UNTOLD };
    assert_eq!(
        error.to_string(),
        "structure mine x=1: its cells cannot be shown: it does not say what they are"
    );
}

#[test]
fn files_are_kept() {
    let folder = Folder::new();
    let path = format!("{}/a.svg", folder.path());
    let command = format!("show balls:2 -s kd-tree,wide-bvh --size 100 -o {path}");
    assert_eq!(run(&command).code, 0);
    let again = run(&command);
    assert!(again.code == 1 && again.err.contains("exists"), "{}", again.err);
}

#[test]
fn cost_draws_several_structures_side_by_side() {
    let folder = Folder::new();
    let width = |structures: &str| {
        let maps = format!("{}/maps", folder.path());
        let command = format!(
            "cost effect-hard-shadows --size 32 {structures} --heat-maps {maps} --overwrite"
        );
        let ended = run(&command);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let svg = std::fs::read_to_string(format!("{maps}/tests.svg")).unwrap();
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let width = tree.root_element().attribute("width").unwrap().parse::<f64>().unwrap();
        let tables = ended.out.lines().filter(|line| line.contains("Zachmann's product")).count();
        (width, tables)
    };
    let ((one, table), (two, tables)) = (width("-s kd-tree"), width("-s kd-tree,uniform-grid"));
    // the image is a panel, too
    assert!(two > one * 4.0 / 3.0, "{one} {two}");
    assert_eq!((table, tables), (1, 2));
}

#[test]
fn a_window_shows_the_hare_in_the_stadium() {
    let folder = Folder::new();
    let path = format!("{}/cells.svg", folder.path());
    // parts of surfaces drawn: of the whole stadium, and of half a metre around the hare
    let drawn = |window: &str| {
        let ended = run(&format!(
            "show stadium:3 -s recursive-grid --slice z=0 {window} -o {path} --overwrite"
        ));
        assert_eq!(ended.code, 0, "{}", ended.err);
        let svg = std::fs::read_to_string(&path).unwrap();
        let surfaces = svg.lines().filter(|line| line.contains("stroke=\"#141414\""));
        surfaces.map(|line| line.matches('M').count()).sum::<usize>()
    };
    let (whole, hare) = (drawn(""), drawn("--window -0.25,-0.05,-0.25:0.25,0.45,0.25"));
    assert!(hare > 10 && hare < whole, "{hare} of {whole}");
}

#[test]
fn pictures_of_one_scale_have_the_same_colors() {
    let folder = Folder::new();
    let path = format!("{}/cells.svg", folder.path());
    let of = |structure: &str, options: &str| {
        let ended = run(&format!("show teapot:3 -s {structure} {options} -o {path} --overwrite"));
        assert_eq!(ended.code, 0, "{}", ended.err);
        texts(&path)
    };
    let grids = ["uniform-grid:density=0.1", "uniform-grid:density=10"];
    let classes = |texts: &[String]| texts.iter().filter(|t| t.contains('-')).cloned().collect();
    let [coarse, fine]: [Vec<String>; 2] = grids.map(|grid| classes(&of(grid, "")[2..]));
    assert_ne!(coarse, fine);
    let [coarse, fine]: [Vec<String>; 2] = grids.map(|grid| classes(&of(grid, "--scale 256")[2..]));
    assert_eq!(coarse, fine);
    // a scale that ends below the longest list says so
    assert!(of("brute-force", "--scale 256").iter().any(|t| t == "129-256 or more"));
}
